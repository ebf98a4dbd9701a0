//! Exploration of an unknown arena: Wahde 2016, §6.1. A robot goes where it must so that its laser sees every part
//! of the floor.
//!
//! | explorer | goes to | from |
//! |---|---|---|
//! | [`Nodes`] | nodes that it has placed about a metre around each other | Wahde 2016, §6.1 |
//! | [`Frontiers`] | the nearest place from which something unknown can be seen | Yamauchi 1997 |
//!
//! An [`Explorer`] is a state machine without a body: it gets the believed pose and the scans, and returns where to
//! turn or to drive. As in the notes, the pose is taken as true. [`Explore`] gives it a body and a pose, and
//! [`behavior`] makes it one of many in a brain whose other processes know the pose.
//!
//! For proximity a robot uses its laser and whatever infra-red sensors and sonars look ahead; they should be mounted lower than
//! the laser. Something counts as near, too, if the robot ought to drive and has not moved for two seconds.
//!
//! All lengths follow the body's radius, but for those that are set. Progress is watched: a goal that is not reached in
//! some times its way is given up, and who has not got on for most of a minute ends; both name what they leave out. The
//! robot stands while something walks in front of it.

mod approach;
pub mod behavior;
pub mod brain;
pub mod frontiers;
pub mod graph;
mod left_out;
pub mod nodes;
mod outlook;
pub mod placement;
mod scout;
mod walkers;

#[doc(hidden)]
pub mod generated;

#[cfg(test)]
mod arena;

use baudbot_geometry::{Point, Pose};

use crate::mapping::{Occupancy, PlacedScan};

pub use brain::Explore;
pub use frontiers::Frontiers;
pub use left_out::LeftOut;
pub use nodes::Nodes;

/// The inputs of an explorer in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input<'a> {
    /// The believed pose.
    pub world_from_robot: Pose,
    /// The laser's last scan; `None` until there is one.
    pub scan: Option<&'a PlacedScan>,
    /// Something is close ahead, the notes' proximity detection. It should see what is too low for the laser.
    pub near: bool,
}

/// The command to the robot until the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Stand still; a scan from here is wanted.
    Wait,
    /// Turn on the spot to this heading.
    Turn {
        /// In the world, in radians.
        heading_rad: f64,
    },
    /// Drive straight on to a point, which is ahead.
    Drive {
        /// In the world, in metres.
        to: Point,
    },
    /// Stand still: nothing is left to be explored, but for this.
    Done(LeftOut),
    /// Stand still: it cannot go on.
    Failed(Failure),
}

/// A reason for an early end of an exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Whichever way it turns, something is in the way.
    Stuck,
    /// There is more to be explored than it can remember.
    TooLarge,
}

/// The present goal of an explorer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The place to reach, or to see.
    pub place: Point,
    /// The length of the way that is left, in metres.
    pub left_m: f64,
}

/// A method of exploration.
pub trait Explorer {
    /// One step; the more often it is called, the earlier the robot stops in front of something.
    fn step(&mut self, input: &Input<'_>) -> Command;

    /// Since the last step something else may have driven the robot.
    fn interrupt(&mut self);

    /// The explorer's present goal, from here.
    fn goal(&self, here: &Pose) -> Option<Goal>;

    /// The robot does not get to its goal, which is then left out.
    fn abandon(&mut self);

    /// The robot makes no progress at all: exploration ends, and all that is still to be seen is left out.
    fn finish(&mut self, here: &Pose);

    /// The explorer's map of the floor.
    fn grid(&self) -> &Occupancy;
}
