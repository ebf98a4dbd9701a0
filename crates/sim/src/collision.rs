//! Collisions of the robots' discs with the arena and with each other (§3.2.5).
//!
//! A robot runs into something; something does not run into it: of two robots that meet, only one that moves
//! towards the other has collided. The notes test where a body is after a step; so do we, and on the way as
//! well if the step is long against the body, so that none passes through a wall. How a robot goes on along what it ran
//! into is in `slide`.

mod slide;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Crowd, Point, Pose, Vector, angle, math};
use serde::{Deserialize, Serialize};

pub(crate) use slide::{Slid, Thrust};

use crate::arena::{Arena, Thing};
use crate::movable::{Body, Form};
use crate::parallel;

/// The effect of a collision, the same for all robots of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CollisionPolicy {
    /// The run ends, the pose uncorrected: ARSim's rule.
    StopRun,
    /// The robot stays where it was before the step that would have run into something, and loses its speed.
    /// It may turn, and drive away.
    StopRobot,
    /// The robot goes on along what it ran into, with friction. Where that lets it not go on, it is as with
    /// [`StopRobot`](Self::StopRobot).
    Slide {
        /// Coefficient of Coulomb's friction between a robot and what it slides along; not negative, or infinite.
        friction: f64,
    },
}

impl CollisionPolicy {
    /// The friction of robots that slide.
    pub(crate) fn friction(self) -> Option<f64> {
        match self {
            Self::StopRun | Self::StopRobot => None,
            Self::Slide { friction } => Some(friction),
        }
    }
}

/// A robot ran into something.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Collision {
    /// Name of the robot.
    pub robot: String,
    /// Name of the shape or of the other robot.
    pub with: String,
}

/// The other party of a collision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Partner {
    Shape(String),
    Robot(usize),
}

/// The obstacle of a robot, by its place in its list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Met {
    Arena(Thing),
    Obstacle(usize),
    Robot(usize),
}

/// A robot's way in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) before: Pose,
    pub(crate) after: Pose,
    /// The pose after the step if nothing were in the way.
    wanted: Pose,
    pub(crate) room: Room,
    /// The thrust, if robots slide.
    pub(crate) thrust: Thrust,
    /// The result of sliding, if it slides.
    pub(crate) slid: Option<Slid>,
    /// The number of searches for a way along its obstacle.
    tries: u8,
}

/// The obstacle of a robot, and its way along that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    met: Met,
    slid: Option<Slid>,
}

/// A disc in which a robot is free of all that stands still, whatever its heading, while its middle is in there.
///
/// It is looked for anew when a robot leaves it. Where a wall is so near that there is none, the robot drives on a bit
/// before the next look.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Room {
    middle: Point,
    radius_m: f64,
    /// The distance of the next look from the middle.
    look_m: f64,
}

impl Room {
    /// The room around a robot that is at `middle`, unless it has been there or near by already.
    pub(crate) fn look(&mut self, arena: &Arena, form: &Form<'_>, middle: Point) {
        if Self::is_within(self.look_m, self.middle, middle) {
            return;
        }
        let reach_m = form.reach_m();
        let radius_m = ALMOST_ALL * (arena.free_around(middle) - reach_m);
        *self = Self { middle, radius_m, look_m: radius_m.max(LOOK_AGAIN * reach_m) };
    }

    fn contains(&self, pose: &Pose) -> bool {
        Self::is_within(self.radius_m, self.middle, pose.position)
    }

    /// A robot that is nowhere is not in it, either.
    fn is_within(radius_m: f64, middle: Point, point: Point) -> bool {
        radius_m > 0.0 && (point - middle).norm_squared() < radius_m * radius_m
    }
}

/// All robots' ways in a step: all are free of each other and of the arena before it.
pub(crate) struct Step<'a> {
    pub(crate) arena: &'a Arena,
    /// Other obstacles, such as doors.
    pub(crate) obstacles: &'a [Body],
    /// The movables, once they have been pushed: robots must not slide into them. No robot is in one before the step or
    /// after it.
    pub(crate) movables: &'a [Body],
    /// The robots' shapes.
    pub(crate) form: &'a (dyn Fn(usize) -> Form<'a> + Sync),
    pub(crate) ways: &'a mut [Way],
    /// The robots with all their way: see [`swept`].
    pub(crate) crowd: &'a Crowd,
}

/// A disc that a robot is in before the step, after it, and on its way.
pub(crate) fn swept(form: &Form<'_>, way: &Way) -> Circle {
    let long = math::sqrt(way.vector().norm_squared());
    Circle { center: way.before.position, radius: form.reach_m() + long }
}

/// The poses of a body on its way at which it is looked at, the last one of them. Half a radius is the longest way between two,
/// of a body with corners its thickness, its farthest corner's turning included: it cannot get past anything in between.
fn looks(form: &Form<'_>, before: &Pose, after: &Pose) -> impl Iterator<Item = Pose> {
    let (before, after) = (*before, *after);
    let way = after.position - before.position;
    let turn = angle::difference(after.heading, before.heading);
    let looks = match form {
        Form::Disc { radius_m } => way.norm() / (0.5 * radius_m),
        Form::Polygon(_) => (way.norm() + turn.abs() * form.reach_m()) / form.thickness_m(),
    };
    let looks = math::ceil(looks).clamp(1.0, MAX_LOOKS);
    (1..=looks as u32).map(move |i| {
        let mut pose = after;
        if f64::from(i) != looks {
            let part = f64::from(i) / looks;
            pose.position = before.position + way * part;
            pose.heading = before.heading + turn * part;
        }
        pose
    })
}

impl Way {
    pub(crate) fn new(before: Pose, after: Pose) -> Self {
        let (room, thrust) = (Room::default(), Thrust::default());
        Self { before, after, wanted: after, room, thrust, slid: None, tries: 0 }
    }

    fn vector(&self) -> Vector {
        self.after.position - self.before.position
    }
}

impl Step<'_> {
    /// The obstacle of robot `own` in this step, if there is one: the arena first, then the things that move in it,
    /// then the other robots in their order. Bodies that touch exactly do not collide.
    pub(crate) fn partner(&self, own: usize) -> Option<Met> {
        self.met_on_the_way(own).or_else(|| self.robot_met(own))
    }

    /// The first of the other robots that this one runs into.
    fn robot_met(&self, own: usize) -> Option<Met> {
        if self.ways.len() < 2 {
            return None;
        }
        let mut first = None;
        self.crowd.near(&self.crowd.discs()[own], |i| {
            if i != own && first.is_none_or(|first| i < first) && self.runs_into(own, i) {
                first = Some(i);
            }
        });
        first.map(Met::Robot)
    }

    /// Whether the two overlap after the step and `own` has moved towards the other. Of two that overlap, at least
    /// one has.
    fn runs_into(&self, own: usize, other: usize) -> bool {
        let (form, its_form) = ((self.form)(own), (self.form)(other));
        let near = form.reach_m() + its_form.reach_m();
        let (way, its_way) = (&self.ways[own], &self.ways[other]);
        let gap = its_way.after.position - way.after.position;
        if gap.norm_squared() >= near * near || way.before == way.after {
            return false;
        }
        let (mine, its) = (form.at(&way.after), its_form.at(&its_way.after));
        if !mine.overlaps(&its) {
            return false;
        }
        if let (Form::Disc { .. }, Form::Disc { .. }) = (form, its_form) {
            // Discs that do not approach each other cannot come to overlap.
            let towards = its_way.before.position - way.before.position;
            return way.vector().dot(&towards) > 0.0;
        }
        // A corner reaches what the centre moves away from: it is asked what either could do alone.
        mine.overlaps(&its_form.at(&its_way.before)) || !form.at(&way.before).overlaps(&its)
    }

    fn met_on_the_way(&self, own: usize) -> Option<Met> {
        let Way { before, after, room, .. } = &self.ways[own];
        if self.obstacles.is_empty() && room.contains(before) && room.contains(after) {
            return None;
        }
        let form = (self.form)(own);
        looks(&form, before, after).find_map(|pose| self.met_at(&form.at(&pose)))
    }

    fn met_at(&self, body: &Body) -> Option<Met> {
        let obstacle = || self.obstacles.iter().position(|obstacle| obstacle.overlaps(body));
        body.arena_thing(self.arena).map(Met::Arena).or_else(|| obstacle().map(Met::Obstacle))
    }

    /// Finds the robots that must leave their ways, into `held`: those that would run into the arena or into one
    /// another, and those that would then run into one that stays. With `friction` they slide along their obstacles,
    /// if they can; the others stay. A disc may turn where it stands.
    ///
    /// All robots are judged by the same picture in each round, so their order does not matter; each round
    /// takes one of its tries from some of them, stops more of them, or is the last.
    pub(crate) fn hold_back(
        &mut self,
        friction: Option<f64>,
        held: &mut Vec<Option<Met>>,
        found: &mut Vec<Option<Found>>,
        is_parallel: bool,
    ) {
        held.clear();
        held.resize(self.ways.len(), None);
        found.resize(self.ways.len(), None);
        let most = if friction.is_some() { TRIES } else { 0 };
        for way in &mut *self.ways {
            (way.wanted, way.slid, way.tries) = (way.after, None, 0);
        }
        loop {
            let step = &*self;
            parallel::each(is_parallel, held, found, |own, held, found| {
                let stays = held.is_some() && step.ways[own].slid.is_none();
                let met = if stays { None } else { step.partner(own) };
                *found = met.map(|met| {
                    let may = friction.filter(|_| step.ways[own].tries < most);
                    Found { met, slid: may.and_then(|friction| step.slide(own, friction)) }
                });
            });
            if found.iter().all(Option::is_none) {
                return;
            }
            for (own, found) in found.iter().enumerate() {
                let Some(Found { met, slid }) = found else { continue };
                let way = &mut self.ways[own];
                way.after = slid.map_or(way.before, |slid| slid.after);
                (way.slid, way.tries) = (*slid, way.tries + 1);
                held[own] = held[own].or(Some(*met));
            }
        }
    }
}

/// A step of more than this many half radii is looked at in so many places; no robot is that fast.
const MAX_LOOKS: f64 = 10_000.0;

/// A robot that slides may run into something else, or that which it slides along moves on: then it tries once more.
const TRIES: u8 = 2;

/// The part of what is free around a robot that it is given as room.
const ALMOST_ALL: f64 = 0.999;

/// A robot without room is looked at again after this part of its reach.
const LOOK_AGAIN: f64 = 0.05;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::arena::{Look, Pillar, Polygon};

    const DISC: Form<'static> = Form::Disc { radius_m: 0.5 };

    fn row(xs: &[f64]) -> Vec<Pose> {
        xs.iter().map(|&x| Pose::new(x, 0.0, 0.0)).collect()
    }

    /// Calls `look` with a step of robots of these shapes, and returns its result.
    fn look<T>(
        arena: &Arena,
        forms: &[Form<'_>],
        before: &[Pose],
        after: &[Pose],
        look: impl FnOnce(Step<'_>) -> T,
    ) -> T {
        let mut crowd = Crowd::default();
        let way = |(&before, &after)| Way::new(before, after);
        let mut ways: Vec<_> = before.iter().zip(after).map(way).collect();
        crowd.rebuild(forms.iter().zip(&ways).map(|(form, way)| swept(form, way)));
        look(Step {
            arena,
            obstacles: &[],
            movables: &[],
            form: &|i| forms[i],
            ways: &mut ways,
            crowd: &crowd,
        })
    }

    fn held(forms: &[Form<'_>], before: &[Pose], after: &[Pose]) -> Vec<Option<Met>> {
        let (mut held, mut found) = (Vec::new(), Vec::new());
        look(&empty(), forms, before, after, |mut step| {
            step.hold_back(None, &mut held, &mut found, false);
        });
        held
    }

    /// The obstacle of each of some discs.
    fn partners(arena: &Arena, before: &[Pose], after: &[Pose]) -> Vec<Option<Met>> {
        let forms = alloc::vec![DISC; before.len()];
        look(arena, &forms, before, after, |step| (0..step.ways.len()).map(|own| step.partner(own)).collect())
    }

    fn empty() -> Arena {
        Arena::new(Vec::new(), Vec::new())
    }

    #[test]
    fn a_queue_that_runs_up_holds_back_one_after_the_other() {
        // The first two meet head on; the third would run into the second's old place; the fourth is free.
        let before = row(&[0.0, 1.2, 2.3, 9.0]);
        let held = held(&[DISC; 4], &before, &row(&[0.15, 1.05, 2.1, 9.2]));
        assert_eq!(held, [Some(Met::Robot(1)), Some(Met::Robot(0)), Some(Met::Robot(1)), None]);
    }

    #[test]
    fn only_the_robot_behind_is_held_back_in_a_rear_end_collision() {
        let before = row(&[0.0, 1.1]);
        let held = held(&[DISC; 2], &before, &row(&[0.3, 1.2]));
        assert_eq!(held, [Some(Met::Robot(1)), None]);
    }

    /// A bar across the way, and a disc beside its end.
    fn bar_and_disc(before: &[Pose; 2], after: &[Pose; 2]) -> Vec<Option<Met>> {
        let bar = [(1.0, -0.1), (1.0, 0.1), (-1.0, 0.1), (-1.0, -0.1)].map(|(x, y)| Point::new(x, y));
        let forms = [Form::Polygon(&bar), Form::Disc { radius_m: 0.15 }];
        held(&forms, before, after)
    }

    #[test]
    fn a_disc_runs_into_the_end_of_a_bar_while_it_moves_away_from_the_bars_middle() {
        let bar = Pose::new(0.0, 0.0, 0.0);
        let before = [bar, Pose::new(0.9, 0.3, 0.0)];
        let held = bar_and_disc(&before, &[bar, Pose::new(1.0, 0.2, 0.0)]);
        assert_eq!(held, [None, Some(Met::Robot(0))]);
    }

    #[test]
    fn a_bar_that_sweeps_into_a_disc_is_held_back_and_the_disc_that_flees_is_not() {
        let before = [Pose::new(0.0, 0.0, 0.0), Pose::new(0.9, 0.3, 0.0)];
        let held = bar_and_disc(&before, &[Pose::new(0.0, 0.0, 0.3), Pose::new(0.9, 0.31, 0.0)]);
        assert_eq!(held, [Some(Met::Robot(1)), None]);
        // Away from the other one, with corners or without.
        let held = bar_and_disc(&before, &[Pose::new(0.0, -0.01, 0.0), Pose::new(0.9, 0.2, 0.0)]);
        assert_eq!(held, [None, Some(Met::Robot(0))]);
    }

    /// A disc beside a segment (§3.2.5).
    #[test]
    fn touching_exactly_is_no_collision() {
        let before = row(&[-0.1, 1.0]);
        assert_eq!(partners(&empty(), &before, &row(&[0.0, 1.0])), [None, None]);
        let near = partners(&empty(), &before, &row(&[0.001, 1.0]));
        assert_eq!(near, [Some(Met::Robot(1)), None], "the other one stood still");
    }

    #[test]
    fn a_bar_does_not_turn_past_a_post_in_one_long_step() {
        let post = Pillar {
            name: "post".into(),
            circle: Circle { center: Point::new(0.6, 0.6), radius: 0.05 },
            look: Look::WALL,
        };
        let arena = Arena::new(Vec::new(), alloc::vec![post]);
        let bar = [(1.0, -0.1), (1.0, 0.1), (-1.0, 0.1), (-1.0, -0.1)].map(|(x, y)| Point::new(x, y));
        let before = [Pose::new(0.0, 0.0, 0.0)];
        let after = [Pose::new(0.0, 0.0, 1.5)];
        let met = look(&arena, &[Form::Polygon(&bar)], &before, &after, |step| step.partner(0));
        assert_eq!(met, Some(Met::Arena(Thing::Pillar(0))));
    }

    proptest! {
        /// Near walls, in corners, in solids, and as a disc or with corners.
        #[test]
        fn nothing_stands_in_a_robots_room(
            boxes in prop::collection::vec((-5.0..5.0, -5.0..5.0, 0.1..6.0, 0.1..6.0, any::<bool>()), 0..5),
            pillars in prop::collection::vec((-5.0..5.0, -5.0..5.0, 0.1..1.0), 0..3),
            (x, y, away, round) in (-6.0..6.0, -6.0..6.0, 0.0..1.2, -4.0..4.0),
            (heading, is_disc) in (-4.0..4.0, any::<bool>()),
        ) {
            let polygon = |(left, low, wide, high, solid): (f64, f64, f64, f64, bool)| {
                let corners = [(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)];
                let points = corners.iter().map(|(x, y)| Point::new(left + x, low + y)).collect();
                Polygon { name: String::new(), points, solid, closed: true, look: Look::WALL }
            };
            let pillar = |(x, y, radius): (f64, f64, f64)| {
                let circle = Circle { center: Point::new(x, y), radius };
                Pillar { name: String::new(), circle, look: Look::WALL }
            };
            let arena = Arena::new(
                boxes.into_iter().map(polygon).collect(),
                pillars.into_iter().map(pillar).collect(),
            );
            let bar = [(0.2, -0.05), (0.2, 0.05), (-0.1, 0.05), (-0.1, -0.05)].map(|(x, y)| Point::new(x, y));
            let form = if is_disc { Form::Disc { radius_m: 0.2 } } else { Form::Polygon(&bar) };
            let (mut room, middle) = (Room::default(), Point::new(x, y));
            room.look(&arena, &form, middle);
            let far = if room.look_m.is_finite() { away * room.look_m } else { 1e3 };
            let (sin, cos) = math::sin_cos(round);
            let pose = Pose::new(x + far * cos, y + far * sin, heading);
            if room.contains(&pose) {
                prop_assert_eq!(form.at(&pose).arena_thing(&arena), None);
            }
            // If there is room, it reaches nearly up to the nearest obstacle.
            let touching = Form::Disc { radius_m: room.radius_m + 1.01 * form.reach_m() + 0.01 };
            if room.radius_m > 0.0 && room.radius_m.is_finite() && room.radius_m < 1.0 {
                prop_assert!(touching.at(&Pose::new(x, y, 0.0)).arena_thing(&arena).is_some());
            }
        }
    }

    #[test]
    fn a_robot_without_room_is_looked_at_again_when_it_has_moved() {
        let post = Pillar {
            name: "post".into(),
            circle: Circle { center: Point::new(0.0, 0.0), radius: 1.0 },
            look: Look::WALL,
        };
        let arena = Arena::new(Vec::new(), alloc::vec![post]);
        let mut room = Room::default();
        let mut looks = |x: f64| {
            let before = room.middle;
            room.look(&arena, &DISC, Point::new(x, 0.0));
            (room.middle != before, room.radius_m > 0.0)
        };
        assert_eq!(looks(1.4), (true, false), "it overlaps the post");
        assert_eq!(looks(1.42), (false, false));
        assert_eq!(looks(2.0), (true, true));
        assert_eq!(looks(2.4), (false, true));
        assert_eq!(looks(f64::NAN), (true, false));
        assert!(!room.contains(&Pose::new(f64::NAN, 0.0, 0.0)));
    }

    /// Collisions between two steps, which §3.2.5 leaves out.
    #[test]
    fn nothing_passes_through_a_thin_wall_in_one_long_step() {
        let points =
            [(2.0, -1.0), (2.01, -1.0), (2.01, 1.0), (2.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec();
        let wall = Polygon { name: "wall".into(), points, solid: true, closed: true, look: Look::WALL };
        let arena = Arena::new(alloc::vec![wall], Vec::new());
        let before = row(&[0.0]);
        let after = row(&[4.0]);
        assert_eq!(partners(&arena, &before, &after), [Some(Met::Arena(Thing::Polygon(0)))]);
    }
}
