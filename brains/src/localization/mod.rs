//! The pose of a robot in a known map, by its laser. Wahde 2016, §6.3. Wahde 2016, §6.3.
//!
//! 1. [`Scan`](crate::scan::Scan) is what the laser saw, [`map`] what it would see from a pose.
//! 2. [`laser`] is the notes' *Laser localization*: a random search around a guess.
//! 3. [`refine`] finds the same pose with far fewer virtual scans, and says how sure it is.
//! 4. [`particles`] follows many poses at once, and finds a robot that is lost.
//! 5. [`deskew`] corrects a scan that was taken while the robot moved.
//!
//! Each takes the pose from [`odometry`](crate::odometry), and returns a better one. [`Tried`] reports the poses that [`laser`]
//! and [`refine`] try on the way, for pictures.

pub mod deskew;
pub mod laser;
pub mod map;
pub mod particles;
pub mod refine;

#[cfg(test)]
pub(crate) mod test_arena;
#[cfg(test)]
mod tracking_tests;

use baudbot_geometry::Pose;

pub use map::{Map, VirtualLaser};

/// A pose at which a search has made a virtual scan, as in Fig. 6.18 of the notes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// Robot in the world.
    pub world_from_robot: Pose,
    /// The minimised error: ε of (6.8), or the sum of [`refine`], which only compares with others of its phase.
    pub error: f64,
    /// Whether the search went on from there.
    pub accepted: bool,
    /// The start to which it goes back: 0 is the guess.
    pub start: usize,
}
