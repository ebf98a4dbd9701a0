//! Beliefs, which a brain publishes for people. All coordinates are of the world as the brain believes them to be, and all
//! numbers must be finite.

use alloc::string::String;
use alloc::vec::Vec;

/// The beliefs and the activity of a brain. A belief replaces all that were published before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Belief {
    /// The state or behaviour that is active, in a few words: one line without control characters.
    pub state: String,
    /// Utilities of behaviours.
    pub utilities: Vec<Utility>,
    /// The pose at which it believes to be.
    pub pose: Option<BelievedPose>,
    /// Other poses that it thinks possible.
    pub particles: Vec<Particle>,
    /// The places to which it means to go.
    pub path: Vec<Point>,
    /// The brain's map of the arena.
    pub map: Option<GridMap>,
}

/// The utility of a behaviour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Utility {
    /// The behaviour's name.
    pub name: String,
    /// The utility of the process.
    pub value: f64,
    /// Whether it runs.
    pub active: bool,
}

/// A pose that a brain believes in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BelievedPose {
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
    /// Counter-clockwise from the x axis, in radians.
    pub heading_rad: f64,
    /// The covariance of x and y: xx, xy and yy, in square metres.
    pub covariance_m2: Option<[f64; 3]>,
}

/// A pose that a brain thinks possible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Particle {
    /// In metres.
    pub x_m: f32,
    /// In metres.
    pub y_m: f32,
    /// Counter-clockwise from the x axis, in radians.
    pub heading_rad: f32,
    /// The particle's weight; all are equal if none has any.
    pub weight: f32,
}

/// Square cells of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridMap {
    /// The place of the lower left corner, in metres.
    pub x_m: f64,
    /// The place of the lower left corner, in metres.
    pub y_m: f64,
    /// The side of a cell, in metres.
    pub cell_m: f64,
    /// Cells in a row.
    pub columns: u32,
    /// A byte a cell, row by row from the lower left corner: 0 is free for sure, 254 is occupied for sure, 255 is not
    /// known.
    pub cells: Vec<u8>,
}

/// A place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
}
