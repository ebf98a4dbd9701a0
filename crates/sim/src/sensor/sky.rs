//! The satellites over the arena, and the dilution of precision (§1.2.2).
//!
//! A receiver solves for three coordinates and for its clock's error. With the unit vectors e to n satellites, the rows of G are (e, 1), and
//!
//! Q = (GᵀG)⁻¹, HDOP = √(Q₁₁ + Q₂₂), VDOP = √Q₃₃, PDOP = √(HDOP² + VDOP²)
//!
//! are the standard deviations of the fix in units of that of a single distance.
//!
//! Deviations. The notes say that three satellites are enough; a receiver whose clock is not right needs four. There are always the same
//! twelve, which do not move (real ones go round in twelve hours): their elevations are 6° apart from 15° on. They are a choice: with all of
//! them HDOP is 0.87 and VDOP 1.42 times as large, with nine 1.24 and 1.90 times. Published figures say that altitudes are 1.5 to 2 times
//! as wrong as positions. What hides the sky does so all around, so that those that are seen are the highest.

use baudbot_geometry::math;
use baudbot_wire::nmea::Satellite;

/// The satellites, by elevation. The length of the sentences, which the cable has to carry, is a real receiver's.
pub(super) const SKY: [Satellite; 12] = {
    let mut sky = [Satellite { prn: 1, elevation_deg: 15, azimuth_deg: 0, snr_db: 40 }; 12];
    let mut i = 0;
    while i < 12 {
        sky[i].prn = 2 + 2 * i as u8;
        sky[i].elevation_deg = 15 + 6 * i as u8;
        sky[i].azimuth_deg = (150 * i as u16) % 360;
        i += 1;
    }
    sky
};

/// The fewest satellites that make a fix.
pub(super) const LEAST: usize = 4;

/// Dilutions of precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dilution {
    pub(super) horizontal: f64,
    pub(super) vertical: f64,
}

/// The number of satellites that stand higher than a horizon, in radians.
pub(super) fn above(horizon_rad: f64) -> usize {
    SKY.iter().filter(|satellite| f64::from(satellite.elevation_deg).to_radians() > horizon_rad).count()
}

impl Dilution {
    /// With the highest satellites, at least [`LEAST`].
    pub(super) fn of(satellites: usize) -> Self {
        let mut matrix = [[0.0; 4]; 4];
        for satellite in &SKY[SKY.len() - satellites.clamp(LEAST, SKY.len())..] {
            let (sin, cos) = math::sin_cos(f64::from(satellite.elevation_deg).to_radians());
            let (east, north) = math::sin_cos(f64::from(satellite.azimuth_deg).to_radians());
            let row = [cos * east, cos * north, sin, 1.0];
            for (i, line) in matrix.iter_mut().enumerate() {
                line.iter_mut().zip(row).for_each(|(sum, other)| *sum += row[i] * other);
            }
        }
        invert(&mut matrix);
        let horizontal = math::sqrt(matrix[0][0] + matrix[1][1]);
        Self { horizontal, vertical: math::sqrt(matrix[2][2]) }
    }

    /// Of all three coordinates.
    pub(super) fn of_position(self) -> f64 {
        math::hypot(self.horizontal, self.vertical)
    }
}

/// Gauss and Jordan's method, without a search for pivots, which a matrix GᵀG does not need.
fn invert(matrix: &mut [[f64; 4]; 4]) {
    for k in 0..4 {
        let pivot = core::mem::replace(&mut matrix[k][k], 1.0);
        let row = matrix[k].map(|value| value / pivot);
        matrix[k] = row;
        for (_, other) in matrix.iter_mut().enumerate().filter(|&(i, _)| i != k) {
            let factor = core::mem::replace(&mut other[k], 0.0);
            other.iter_mut().zip(row).for_each(|(value, own)| *value -= factor * own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let matrix =
            [[4.0, 1.0, 0.5, 2.0], [1.0, 5.0, -1.0, 0.3], [0.5, -1.0, 6.0, 1.0], [2.0, 0.3, 1.0, 7.0]];
        let mut inverse = matrix;
        invert(&mut inverse);
        for (i, row) in matrix.iter().enumerate() {
            let columns = [0, 1, 2, 3].map(|j| inverse.map(|row: [f64; 4]| row[j]));
            for (j, column) in columns.iter().enumerate() {
                let sum: f64 = row.iter().zip(column).map(|(a, b)| a * b).sum();
                assert!((sum - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}: {sum}");
            }
        }
    }

    /// By a program of its own, with the whole inverse matrix.
    #[test]
    fn fewer_satellites_dilute_more_and_the_vertical_most() {
        for (satellites, horizontal, vertical) in
            [(12, 0.8749, 1.2453), (9, 1.237, 2.3532), (6, 2.1962, 6.0196), (4, 4.5925, 16.2256)]
        {
            let dilution = Dilution::of(satellites);
            assert!((dilution.horizontal - horizontal).abs() < 1e-4, "{satellites}: {dilution:?}");
            assert!((dilution.vertical - vertical).abs() < 1e-4, "{satellites}: {dilution:?}");
        }
    }

    #[test]
    fn a_higher_horizon_hides_the_lower_satellites() {
        let seen = [0.0, 14.0, 16.0, 30.0, 50.0, 80.0, 90.0].map(|horizon: f64| above(horizon.to_radians()));
        assert_eq!(seen, [12, 12, 11, 9, 6, 1, 0]);
    }
}
