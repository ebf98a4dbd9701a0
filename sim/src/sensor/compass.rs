//! Compass: the heading with additive Gaussian noise, as ARSim's, turned by iron nearby.

use baudbot_geometry::math;

use super::Measurement;

/// What a compass is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compass {
    /// Error of a magnetised body: size and phase of a sine of the heading, in radians.
    pub hard_iron_rad: (f64, f64),
    /// Error of an iron body: size and phase of a sine of twice the heading, in radians.
    pub soft_iron_rad: (f64, f64),
}

impl Compass {
    /// Heading in radians, counter-clockwise from the x axis, before noise.
    pub(super) fn read(&self, at: &Measurement<'_>) -> f64 {
        let heading = at.motion.pose.heading;
        let mut reading = heading;
        for ((size, phase), turns) in [(self.hard_iron_rad, 1.0), (self.soft_iron_rad, 2.0)] {
            if size != 0.0 {
                reading += size * math::sin(turns * heading + phase);
            }
        }
        if at.scene.surroundings.zones.is_empty() {
            return reading;
        }
        reading + at.scene.surroundings.compass_offset_at(at.motion.pose.position)
    }
}
