//! Checks of a state that comes from outside, whatever its source: numbers that are numbers, and counts that can
//! still be added to. Beside each type of the state is an `is_sound` that asks it, and what else must hold of it.

use baudbot_geometry::Pose;

use crate::wheels::Wheels;

/// Whether so much has been counted that any run can go on from it.
pub(crate) fn count(n: u64) -> bool {
    n < 1 << 60
}

/// Whether all of these are of a size that a world may have, in whatever unit.
pub(crate) fn numbers(numbers: impl IntoIterator<Item = f64>) -> bool {
    numbers.into_iter().all(|number| number.abs() <= MOST)
}

/// Whether a pose is somewhere.
pub(crate) fn pose(pose: &Pose) -> bool {
    numbers([pose.position.x, pose.position.y, pose.heading])
}

pub(crate) fn wheels(wheels: &Wheels) -> bool {
    numbers([wheels.left, wheels.right])
}

/// No length, speed or signal of a world is beyond that.
const MOST: f64 = 1e15;
