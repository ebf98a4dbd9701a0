//! The reason why a run ended.

use alloc::string::String;
use core::fmt;

use serde::{Deserialize, Serialize};

use crate::collision::Collision;

/// The reason why a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// The scenario's time is over.
    TimeIsOver,
    /// A robot ran into something.
    Collision(Collision),
    /// The robot of this name reached the scenario's goal.
    GoalReached(String),
    /// The allowed number of collisions was reached.
    Collisions(u64),
    /// The robots have been in all of the zones that are goals.
    AllGoals,
    /// The floor was covered to the wanted part.
    Covered,
    /// The floor was sensed to the wanted part.
    Sensed,
    /// The battery of the robot of this name is empty.
    BatteryEmpty(String),
    /// The brain of the robot of this name missed its deadline.
    DeadlineMissed(String),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeIsOver => f.write_str("the scenario's time is over"),
            Self::Collision(Collision { robot, with }) => write!(f, "`{robot}` ran into `{with}`"),
            Self::GoalReached(robot) => write!(f, "`{robot}` reached the goal"),
            Self::Collisions(n) => write!(f, "there were {n} collisions"),
            Self::AllGoals => f.write_str("all goals were reached"),
            Self::Covered => f.write_str("the required fraction of the floor was covered"),
            Self::Sensed => f.write_str("the required fraction of the floor was sensed"),
            Self::BatteryEmpty(robot) => write!(f, "the battery of `{robot}` is empty"),
            Self::DeadlineMissed(robot) => write!(f, "the brain of `{robot}` missed its deadline"),
        }
    }
}
