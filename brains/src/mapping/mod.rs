//! What a brain makes of what it has seen.

pub mod floor;
pub mod frontier;
pub mod occupancy;
mod raster;
pub mod scan;

pub use floor::Floor;
pub use occupancy::{Cell, Occupancy, Occupied};
pub use scan::{Scan, View};
