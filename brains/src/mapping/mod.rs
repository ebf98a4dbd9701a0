//! What a brain makes of what it has seen.

pub(crate) mod disc;
pub mod floor;
pub mod frontier;
pub mod occupancy;
pub mod placed;
mod raster;
mod shown;

pub use floor::Floor;
pub use occupancy::{Cell, Occupancy, Occupied};
pub use placed::{PlacedScan, View};
