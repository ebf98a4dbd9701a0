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
    /// The motivational state by which it chooses.
    pub motivation: Option<Motivation>,
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

/// A motivational state: what the brain senses, its internal state with lethal boundaries, and what follows from them (Wahde 2016, §4.4.4).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motivation {
    /// The variables of the state.
    pub variables: Vec<StateVariable>,
    /// The tendencies of behaviours; none if they do not follow from the variables alone.
    pub tendencies: Vec<Tendency>,
}

/// A variable of a motivational state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateVariable {
    /// The variable's name.
    pub name: String,
    /// The variable's value, without unit.
    pub value: f64,
    /// Whether it is internal, such as hunger, and not sensed.
    pub internal: bool,
    /// The boundaries at which the robot dies: from this value on downwards, and from this one on upwards.
    pub lethal: [Option<f64>; 2],
}

/// The tendency to a behaviour: bias + Σ weight · value. The greater it is, the greater the utility that follows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tendency {
    /// The behaviour's name.
    pub name: String,
    /// The tendency where all variables are 0.
    pub bias: f64,
    /// The weight of each variable, in their order; none for all 0.
    pub weights: Vec<f64>,
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
