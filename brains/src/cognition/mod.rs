//! Cognitive processes: what a brain makes of its readings without driving.

pub mod localization;
pub mod odometry;
pub mod slam;
