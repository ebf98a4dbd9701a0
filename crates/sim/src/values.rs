//! Values of readings.

use smallvec::SmallVec;

/// One value a component. Those of most sensors are so few that they need no memory of their own.
pub type ReadingValues = SmallVec<[f64; 2]>;
