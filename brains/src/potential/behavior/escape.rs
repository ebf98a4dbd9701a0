//! The way out of a place where it locks: a detour.

use baudbot_brain::Signals;
use baudbot_geometry::{Point, Pose, math};

use super::{PotentialField, distance};
use crate::potential::detour::Detour;
use crate::potential::terrain::Terrain;

impl PotentialField {
    pub(super) fn begin_detour(&mut self, pose: &Pose, at_ns: u64) -> (Signals, &'static str) {
        self.felt.take_news();
        self.begun = (pose.position, self.begun.1.saturating_add(1));
        self.thought_ns = at_ns;
        let terrain = self.terrain(pose.position);
        let path = terrain.and_then(|terrain| terrain.path(pose.position, self.target()));
        self.detour = path.map(|path| Detour::new(path, self.radius_m));
        (Signals::default(), "")
    }

    /// Follows the way round, until the field leads on from here.
    pub(super) fn go_round(&mut self, pose: &Pose, at_ns: u64) -> (Signals, &'static str) {
        let at = pose.position;
        if at_ns.saturating_sub(self.thought_ns) >= THINK_NS {
            self.thought_ns = at_ns;
            self.think(pose);
        }
        let Some(detour) = &mut self.detour else { return self.follow(pose, at_ns) };
        if detour.is_forced() {
            return (self.look_for_a_way(), "knows no way");
        }
        let offset = detour.next(at) - at;
        (self.steer(pose, math::atan2(offset.y, offset.x), at_ns), "goes round")
    }

    /// Whether the path is still the best one, and whether the field leads on.
    fn think(&mut self, pose: &Pose) {
        let at = pose.position;
        let Some(terrain) = self.terrain(at) else { return };
        if self.leads_on(pose, &terrain) {
            self.detour = None;
            self.lock.begin();
            return;
        }
        let has_news = self.felt.take_news();
        let stray_m = STRAY * self.radius_m;
        let Some(detour) = &mut self.detour else { return };
        let is_lost = detour.is_forced() || detour.strayed_m(at) > stray_m;
        if !(has_news || is_lost) {
            return;
        }
        match terrain.path(at, self.target()) {
            Some(path) if is_lost => self.detour = Some(Detour::new(path, self.radius_m)),
            Some(path) => {
                if let Some(detour) = &mut self.detour {
                    detour.reconsider(path, &terrain);
                }
            }
            None => {}
        }
    }

    /// No way is open. What was felt may not be there: it looks round. A robot without sensors for that stands.
    fn look_for_a_way(&mut self) -> Signals {
        if self.felt.is_senseless() {
            return Signals::default();
        }
        if self.felt.marks().next().is_some() {
            self.felt.forget();
        }
        let signal = self.parameters.steering.rotation_m_s / self.parameters.steering.full_speed_m_s;
        Signals { left: -signal, right: signal }
    }

    /// Whether a point that follows the field from here comes to the target, with room for the body on all its path.
    fn leads_on(&self, pose: &Pose, terrain: &Terrain) -> bool {
        let (begun, detours) = self.begun;
        // Each detour goes twice as far as the one before, so that field and detour do not lead to and fro for ever.
        let away_m = self.radius_m * f64::from(1_u32 << detours.min(MOST_DOUBLED));
        if distance(pose.position, begun) < away_m {
            return false;
        }
        let (field, target, step_m) = (self.field(), self.target(), ROLL * self.radius_m);
        let down = field.direction(pose.position);
        if self.felt.room_m(pose, math::atan2(down.y, down.x)) < CLEAR * self.radius_m {
            return false;
        }
        let near_m = self.parameters.passed_m.min(self.parameters.arrived_m).max(step_m);
        let most = (MOST_ROLL * distance(pose.position, target) / step_m) as usize + 1;
        let mut at = pose.position;
        for _ in 0..most {
            if distance(at, target) <= near_m {
                return true;
            }
            if !terrain.is_open(at) {
                return false;
            }
            at += field.direction(at) * step_m;
        }
        false
    }

    fn terrain(&self, at: Point) -> Option<Terrain> {
        let hills: Vec<_> =
            self.parameters.obstacles.iter().filter(|hill| hill.alpha > 0.0).copied().collect();
        Terrain::new([at, self.target()], &hills, self.felt.marks(), self.felt.blur_m(), self.radius_m)
    }
}

/// The field is followed again with so much room in its direction, in radii of the body.
const CLEAR: f64 = 1.75;
/// A robot that is so far beside its path plans another one, in radii of the body.
const STRAY: f64 = 2.0;
/// The field is followed in steps of so many radii of the body ...
const ROLL: f64 = 0.2;
/// ... for so many times the path straight on.
const MOST_ROLL: f64 = 4.0;
/// So often the path of a detour is doubled at most.
const MOST_DOUBLED: u32 = 16;
/// The period in which the detour is planned again, in nanoseconds.
const THINK_NS: u64 = 500_000_000;
