//! Cognitive processes: what a brain makes of its readings without driving.

pub mod localization;
pub mod odometry;
pub mod particles;
pub mod proximity;
pub mod slam;

use baudbot_geometry::{Point, Segment};

use crate::localization::Map;
use crate::parameter::ParameterError;

/// The map with these walls, `[x, y, x, y]` in metres.
fn map_of(walls_m: &[[f64; 4]]) -> Result<Map, ParameterError> {
    let wall = |&[x, y, u, v]: &[f64; 4]| Segment { start: Point::new(x, y), end: Point::new(u, v) };
    Map::new(walls_m.iter().map(wall).collect(), Vec::new())
        .map_err(|error| ParameterError::value("walls_m", error))
}
