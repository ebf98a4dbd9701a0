//! Maps that a brain makes of its scans.

pub(crate) mod disc;
pub mod floor;
pub mod frontier;
pub mod occupancy;
pub mod placed;
mod shown;

pub use baudbot_geometry::grid::Cell;
pub use floor::Floor;
pub use occupancy::{Occupancy, Occupied};
pub use placed::{PlacedScan, View};
