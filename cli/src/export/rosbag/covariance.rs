//! The certainty of the values. A covariance of 0 means to ROS that it is unknown, and filters fail on it.

use baudbot_sim::sensor::Sensor;
use baudbot_wire::Encoding;

/// The variance of what is exact, such as the truth: a number that can be inverted.
pub(super) const CERTAIN: f64 = 1e-9;

/// The variance of a value that a sensor reads, in the square of its unit: what its noise and the steps of its converter give. Without
/// noise only the steps are left.
pub(super) fn variance(sensor: &Sensor, component: usize, value: f64, has_noise: bool) -> f64 {
    let noise = &sensor.noise;
    let squares = |numbers: &[f64]| numbers.iter().map(|number| number * number).sum::<f64>();
    let of_noise = squares(&[
        noise.additive,
        noise.multiplicative * value,
        noise.gain_spread * value,
        noise.offset_spread,
        noise.drift.map_or(0.0, |drift| drift.sigma),
    ]) + noise.uniform * noise.uniform / 3.0;
    let step = sensor.encodings.get(component).map_or(0.0, step);
    CERTAIN + if has_noise { of_noise } else { 0.0 } + step * step / 12.0
}

/// The difference between neighbouring values.
fn step(encoding: &Encoding) -> f64 {
    let steps = |bits: u8| ((1_u64 << bits) - 1) as f64;
    match *encoding {
        Encoding::Level { bits, min, max } => (max - min).abs() / steps(bits),
        Encoding::Signed { bits, limit } => 2.0 * limit / steps(bits),
        Encoding::Counter { .. } => 1.0,
        Encoding::Float64 => 0.0,
    }
}

/// Covariances of x, y and the heading, or of the speeds along and about these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Planar([[f64; 3]; 3]);

impl Planar {
    /// The covariance of three independent values.
    pub(super) fn diagonal([x, y, heading]: [f64; 3]) -> Self {
        Self([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, heading]])
    }

    /// The covariance of exact values.
    pub(super) fn certain() -> Self {
        Self::diagonal([CERTAIN; 3])
    }

    /// The covariance with variances of the readings added.
    pub(super) fn plus(self, [x, y, heading]: [f64; 3]) -> Self {
        let Self(mut sum) = self;
        sum[0][0] += x;
        sum[1][1] += y;
        sum[2][2] += heading;
        Self(sum)
    }

    /// The covariance after a way that ended with this heading: the uncertainty of a pose grows by those of the way and
    /// the turn, the first of which goes along the new heading, as for the odometer.
    pub(super) fn after(self, heading_rad: f64, way_m: f64, variances: [f64; 2]) -> Self {
        let (sin, cos) = heading_rad.sin_cos();
        // The effect of a wrong heading on the new place.
        let turned = [[1.0, 0.0, -way_m * sin], [0.0, 1.0, way_m * cos], [0.0, 0.0, 1.0]];
        let drawn = [[cos, -way_m * sin], [sin, way_m * cos], [0.0, 1.0]];
        let mut sum = [[0.0; 3]; 3];
        for (i, row) in sum.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                let mut before = 0.0;
                for (k, row) in self.0.iter().enumerate() {
                    for (l, covariance) in row.iter().enumerate() {
                        before += turned[i][k] * covariance * turned[j][l];
                    }
                }
                let new = (0..2).map(|k| drawn[i][k] * variances[k] * drawn[j][k]).sum::<f64>();
                *cell = before + new;
            }
        }
        Self(sum)
    }

    /// In space: x, y, z and the turns about these. The robot does not leave the floor, nor tilt.
    pub(super) fn in_space(self) -> [f64; 36] {
        const PLACES: [usize; 3] = [0, 1, 5];
        let mut all = [0.0; 36];
        for axis in 2..5 {
            all[axis * 7] = CERTAIN;
        }
        for (i, row) in self.0.iter().enumerate() {
            for (j, covariance) in row.iter().enumerate() {
                all[PLACES[i] * 6 + PLACES[j]] = *covariance;
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_makes_a_pose_less_certain() {
        let start = Planar::certain();
        // Straight on along x, 1 m: a wrong heading is a wrong y.
        let Planar(after) = start.after(0.0, 1.0, [0.01, 0.04]);
        assert!((after[0][0] - 0.01).abs() < 1e-6 && (after[2][2] - 0.04).abs() < 1e-6, "{after:?}");
        assert!((after[1][1] - 0.04).abs() < 1e-6 && (after[1][2] - 0.04).abs() < 1e-6, "{after:?}");
        let space = Planar(after).in_space();
        assert!((space[0] - 0.01).abs() < 1e-6 && (space[35] - 0.04).abs() < 1e-6 && space[11] == space[31]);
        assert!((0..6).all(|axis| space[axis * 7] > 0.0), "{space:?}");
    }
}
