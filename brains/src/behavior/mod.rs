//! Motor behaviours that repertoires choose among.

pub mod brain_behavior;
pub mod charge;
pub mod fixed_action;
pub mod follow_path;
pub mod follow_wall;
pub mod go_to;
pub mod home;
pub mod square;
pub mod taxis;
pub mod turn_away;

pub use crate::steering::Steering;
