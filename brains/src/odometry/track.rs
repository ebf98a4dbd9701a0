//! Poses of the past, one after the other.

use baudbot_geometry::{Direction, Pose};

use super::step::Step;
use super::{Odometry, Place, fraction};

/// Poses at instants of the past. Those that are next to each other take little time.
#[derive(Clone, Debug)]
pub struct Track<'a> {
    pub(super) odometry: &'a Odometry,
    /// The last instant.
    pub(super) leg: Option<Leg>,
}

/// The way between two readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    from_ns: u64,
    to_ns: u64,
    from: Pose,
    /// The heading of `from`.
    facing: Direction,
    step: Step,
}

impl Track<'_> {
    /// The pose of [`Odometry::at`], world from robot.
    #[must_use]
    pub fn pose_at(&mut self, at_ns: u64) -> Option<Pose> {
        let same = self.leg.filter(|leg| leg.from_ns < at_ns && at_ns < leg.to_ns);
        let leg = match same {
            Some(leg) => leg,
            None => match self.odometry.place(at_ns)? {
                Place::At(estimate) => return Some(estimate.world_from_robot),
                Place::Between(before, next) => {
                    let from = before.estimate.world_from_robot;
                    let (from_ns, to_ns, facing) = (before.at_ns, next.at_ns, from.direction());
                    *self.leg.insert(Leg { from_ns, to_ns, from, facing, step: next.step })
                }
            },
        };
        let part = leg.step.part(fraction(leg.from_ns, at_ns, leg.to_ns));
        Some(leg.from.compose_facing(leg.facing, &part.then_from_now))
    }
}
