//! Things that move by themselves: doors, obstacles on a path, people.
//!
//! A path is followed whatever stands around, but for one rule: nothing moves into a robot or into a thing that can
//! be pushed. It waits until the way is free, and how long it has waited is told.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Direction, Point, Pose, Vector, angle, math};
use serde::{Deserialize, Serialize};

use crate::arena::{Arena, Look};
use crate::heap::elements;
use crate::movable::{Body, Form};
use crate::random::Stream;
use crate::sound;
use crate::time::SimTime;

/// The model of such a thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Mover {
    /// Unique among all that can be run into.
    pub name: String,
    /// Radius, if it is a disc.
    pub radius_m: f64,
    /// Corners in its own frame, in metres; none if it is a disc.
    pub outline: Vec<Point>,
    /// The look from the side.
    pub look: Look,
    /// The start, world from mover.
    pub start: Pose,
    /// The path.
    pub path: Path,
}

/// The path of a thing that moves by itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Path {
    /// From point to point, without turning.
    Stops {
        /// The corners; the first is the start.
        points: Vec<Point>,
        /// In m/s.
        speed_m_s: f64,
        /// The pause at each, in nanoseconds.
        pause_ns: u64,
        /// The end of the round.
        after: AfterLast,
    },
    /// About the origin of its own frame, as a door about its hinge.
    Swing {
        /// Heading at the one end, where it starts, and at the other, in radians.
        ends_rad: [f64; 2],
        /// In rad/s.
        rate_rad_s: f64,
        /// The pause at each end, in nanoseconds.
        pause_ns: u64,
    },
    /// Straight on in a direction that is drawn again now and then, and whenever something is in the way.
    Wander {
        /// In m/s.
        speed_m_s: f64,
        /// The longest time in one direction, in nanoseconds.
        turn_ns: u64,
    },
}

/// The behaviour of a thing at the end of its path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, Serialize))]
pub enum AfterLast {
    /// It goes all the way back.
    #[default]
    Return,
    /// It goes straight to the first point.
    Cycle,
    /// It stays there.
    Stay,
}

/// The pose and the progress of such a thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MoverState {
    pub(crate) pose: Pose,
    /// The point, or end, that it goes to.
    goal: usize,
    /// Backwards along its points.
    returning: bool,
    waits_until: SimTime,
    /// Time that something was in its way, in nanoseconds.
    pub(crate) blocked_ns: u64,
    pub(crate) stream: Stream,
}

/// The obstacles of a thing that moves by itself.
pub(crate) struct Around<'a> {
    pub(crate) arena: &'a Arena,
    pub(crate) bodies: &'a [Body],
}

impl Mover {
    /// The bytes that it has on the heap, besides its name.
    pub(crate) fn heap_bytes(&self) -> usize {
        let points = match &self.path {
            Path::Stops { points, .. } => elements(points),
            Path::Swing { .. } | Path::Wander { .. } => 0,
        };
        elements(&self.outline) + points
    }

    /// Its shape, in its own frame.
    pub fn form(&self) -> Form<'_> {
        Form::of(&self.outline, self.radius_m)
    }

    /// Whether it can be there: on its way to a point that there is, or behind the last.
    pub(crate) fn may_be(&self, state: &MoverState) -> bool {
        let goal = match &self.path {
            Path::Stops { points, .. } => state.goal <= points.len(),
            Path::Swing { .. } => state.goal <= 1,
            Path::Wander { .. } => true,
        };
        goal && sound::pose(&state.pose) && sound::count(state.blocked_ns) && state.stream.is_sound()
    }

    pub(crate) fn at_start(&self, seed: u64) -> MoverState {
        let pause_ns = match self.path {
            Path::Stops { pause_ns, .. } | Path::Swing { pause_ns, .. } => pause_ns,
            Path::Wander { .. } => 0,
        };
        MoverState {
            pose: self.start,
            goal: 1,
            returning: false,
            waits_until: SimTime::from_ns(pause_ns),
            blocked_ns: 0,
            stream: Stream::of(seed, &[&self.name, "/path"]),
        }
    }

    /// Moves for `dt` seconds from `now` on, unless something is in the way. A way that is long against its own
    /// body is gone in parts, so that it gets past nothing in between.
    pub(crate) fn step(&self, state: &mut MoverState, around: &Around<'_>, now: SimTime, dt: f64) {
        let speed_m_s = match self.path {
            Path::Stops { speed_m_s, .. } | Path::Wander { speed_m_s, .. } => speed_m_s,
            Path::Swing { rate_rad_s, .. } => rate_rad_s * self.form().reach_m(),
        };
        let parts = math::ceil(speed_m_s * dt / self.form().thickness_m()).clamp(1.0, MAX_PARTS);
        for _ in 0..parts as u32 {
            self.part_of_step(state, around, now, dt / parts);
        }
    }

    fn part_of_step(&self, state: &mut MoverState, around: &Around<'_>, now: SimTime, dt: f64) {
        let wanders = matches!(self.path, Path::Wander { .. });
        if now < state.waits_until && !wanders {
            return;
        }
        if wanders && (now >= state.waits_until || state.waits_until == SimTime::ZERO) {
            self.turn(state, now);
        }
        let (pose, arrives) = self.onwards(state, dt);
        let body = self.form().at(&pose);
        let in_the_way = around.bodies.iter().any(|other| body.overlaps(other))
            || (wanders && body.overlaps_arena(around.arena));
        if in_the_way {
            state.blocked_ns += (dt * 1e9) as u64;
            if wanders {
                state.waits_until = now;
            }
            return;
        }
        state.pose = pose;
        if arrives {
            self.arrive(state, now);
        }
    }

    fn turn(&self, state: &mut MoverState, now: SimTime) {
        let Path::Wander { turn_ns, .. } = self.path else { return };
        state.pose.heading = angle::wrap(core::f64::consts::TAU * state.stream.uniform());
        state.waits_until = now + (turn_ns as f64 * (0.5 + 0.5 * state.stream.uniform())) as u64 + 1;
    }

    /// The pose `dt` seconds on, and whether that is where it was going.
    fn onwards(&self, state: &MoverState, dt: f64) -> (Pose, bool) {
        let mut pose = state.pose;
        match &self.path {
            Path::Stops { points, speed_m_s, .. } => {
                let Some(&goal) = points.get(state.goal) else { return (pose, false) };
                let (way, reach): (Vector, _) = (goal - pose.position, speed_m_s * dt);
                let left = way.norm();
                pose.position = if left <= reach { goal } else { pose.position + way * (reach / left) };
                (pose, left <= reach)
            }
            Path::Swing { ends_rad, rate_rad_s, .. } => {
                let (left, reach) = (ends_rad[state.goal] - pose.heading, rate_rad_s * dt);
                pose.heading = if left.abs() <= reach {
                    ends_rad[state.goal]
                } else {
                    pose.heading + reach.copysign(left)
                };
                (pose, left.abs() <= reach)
            }
            Path::Wander { speed_m_s, .. } => {
                pose.position += Direction::from_angle(pose.heading).vector() * (speed_m_s * dt);
                (pose, false)
            }
        }
    }

    /// It pauses, and then goes to the next point or the other end.
    fn arrive(&self, state: &mut MoverState, now: SimTime) {
        match &self.path {
            Path::Wander { .. } => {}
            Path::Swing { pause_ns, .. } => {
                state.goal = 1 - state.goal;
                state.waits_until = now + *pause_ns;
            }
            Path::Stops { points, pause_ns, after, .. } => {
                state.waits_until = now + *pause_ns;
                let last = points.len() - 1;
                if state.returning {
                    state.returning = state.goal > 0;
                    state.goal = if state.returning { state.goal - 1 } else { 1.min(last) };
                } else if state.goal < last {
                    state.goal += 1;
                } else {
                    match after {
                        AfterLast::Stay => state.goal = points.len(),
                        AfterLast::Cycle => state.goal = 0,
                        AfterLast::Return => {
                            state.returning = true;
                            state.goal = last.saturating_sub(1);
                        }
                    }
                }
            }
        }
    }
}

/// Nothing is so fast that its step has more parts.
const MAX_PARTS: f64 = 10_000.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn empty() -> Arena {
        Arena::new(Vec::new(), Vec::new())
    }

    fn mover(path: Path, start: Pose) -> Mover {
        Mover { name: "m".into(), radius_m: 0.1, outline: Vec::new(), look: Look::WALL, start, path }
    }

    fn run(mover: &Mover, bodies: &[Body], seconds: u64) -> MoverState {
        let arena = empty();
        let mut state = mover.at_start(1);
        for i in 0..seconds * 100 {
            let around = Around { arena: &arena, bodies };
            mover.step(&mut state, &around, SimTime::from_ns(i * 10_000_000), 0.01);
        }
        state
    }

    fn shuttle(after: AfterLast) -> Mover {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec();
        mover(Path::Stops { points, speed_m_s: 1.0, pause_ns: 0, after }, Pose::new(0.0, 0.0, 0.0))
    }

    #[test]
    fn paths_go_on_as_they_say() {
        let at = |after, seconds| run(&shuttle(after), &[], seconds).pose.position;
        let near = |a: Point, x, y| (a - Point::new(x, y)).norm() < 0.05;
        assert!(near(at(AfterLast::Stay, 9), 1.0, 1.0));
        assert!(near(at(AfterLast::Return, 3), 1.0, 0.0), "{}", at(AfterLast::Return, 3));
        assert!(near(at(AfterLast::Return, 5), 1.0, 0.0), "{}", at(AfterLast::Return, 5));
        let half_way = at(AfterLast::Cycle, 3);
        assert!((half_way.x - half_way.y).abs() < 1e-9 && half_way.x < 0.5, "{half_way}");
    }

    #[test]
    fn a_door_swings_and_waits_for_who_stands_in_it() {
        let outline =
            [(0.0, -0.02), (0.8, -0.02), (0.8, 0.02), (0.0, 0.02)].map(|(x, y)| Point::new(x, y)).to_vec();
        let path = Path::Swing { ends_rad: [0.0, 1.5], rate_rad_s: 1.0, pause_ns: 500_000_000 };
        let door = Mover { outline, ..mover(path, Pose::new(0.0, 0.0, 0.0)) };
        assert!((run(&door, &[], 2).pose.heading - 1.5).abs() < 0.02);
        let robot = Body::Disc(baudbot_geometry::Circle { center: Point::new(0.4, 0.4), radius: 0.1 });
        let held = run(&door, core::slice::from_ref(&robot), 4);
        assert!(held.pose.heading < 0.7 && held.blocked_ns > 1_000_000_000, "{held:?}");
        assert!(!door.form().at(&held.pose).overlaps(&robot));
    }

    #[test]
    fn who_wanders_stays_in_the_room_and_gets_about() {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let points = corners.map(|(x, y)| Point::new(x, y)).to_vec();
        let room = crate::arena::Polygon {
            name: "room".into(),
            points,
            solid: false,
            closed: true,
            look: Look::WALL,
        };
        let arena = Arena::new(alloc::vec![room], Vec::new());
        let path = Path::Wander { speed_m_s: 0.5, turn_ns: 3_000_000_000 };
        let person = mover(path, Pose::new(0.0, 0.0, 0.0));
        let mut state = person.at_start(7);
        let mut quadrants = [false; 4];
        for i in 0..20_000 {
            let around = Around { arena: &arena, bodies: &[] };
            person.step(&mut state, &around, SimTime::from_ns(i * 10_000_000), 0.01);
            let p = state.pose.position;
            assert!(p.x.abs() <= 0.9 && p.y.abs() <= 0.9, "{p}");
            quadrants[usize::from(p.x > 0.0) + 2 * usize::from(p.y > 0.0)] = true;
        }
        assert_eq!(quadrants, [true; 4]);
    }
}
