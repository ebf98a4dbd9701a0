//! The way from the errors at the ends of squares to the errors of the wheels: Borenstein & Feng 1996, "Measurement and
//! Correction of Systematic Odometry Errors in Mobile Robots", IEEE Transactions on Robotics and Automation 12(6).
//!
//! With ε = true pose − pose by odometry at the end of a run, in the frame of its start, whose x axis is the first side, L the
//! side and b the distance between the wheels, and the means of all clockwise and of all counter-clockwise runs
//!
//! ```text
//! r = √(x² + y²)                      E_max,syst = max(r_cw, r_ccw)
//! α = (x_cw + x_ccw) / −4L            α = (y_cw − y_ccw) / −4L        Type A: each turn is α short
//! β = (x_cw − x_ccw) / −4L            β = (y_cw + y_ccw) / −4L        Type B: each side bends by β to the left
//! E_b = 90° / (90° − α)               R = (L/2) / sin(β/2)            E_d = (R + b/2) / (R − b/2)
//! c_l = 2 / (E_d + 1)                 c_r = 2 / (1/E_d + 1)
//! ```
//!
//! *Deviations.* α and β are the means of their two formulas, whose errors of second order have opposite signs. b is the corrected
//! distance between the wheels, E_b b. All formulas are of first order in α and β: of large errors a second measurement, with
//! the first correction made, finds the rest, and the factors multiply.

use std::f64::consts::FRAC_PI_2;

use baudbot_brains::odometry::Calibration;

/// The end of a run: the true pose less the pose by odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EndError {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
}

/// All runs in one direction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    pub(super) errors: Vec<EndError>,
    /// Centre of gravity of the ends, in metres.
    pub(super) center_m: [f64; 2],
    /// σ: standard deviation of the ends about it, both axes together, in metres; 0 of a single run.
    pub(super) sd_m: f64,
}

/// The errors in both directions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Analysis {
    pub(super) cw: Group,
    pub(super) ccw: Group,
    /// The angle α of the errors, in radians.
    pub(super) type_a_rad: f64,
    /// The angle β of the errors, in radians.
    pub(super) type_b_rad: f64,
    /// E_d, against the calibration that odometry had.
    pub(super) wheel_ratio: f64,
    /// E_b, against the calibration that odometry had.
    pub(super) track_ratio: f64,
    /// The calibration to use from now on.
    pub(super) calibration: Calibration,
}

impl Group {
    /// A `Group` of at least one run.
    pub(super) fn new(errors: Vec<EndError>) -> Self {
        let count = errors.len() as f64;
        let mean = |of: fn(&EndError) -> f64| errors.iter().map(of).sum::<f64>() / count;
        let center_m = [mean(|error| error.x_m), mean(|error| error.y_m)];
        let square = |error: &EndError| {
            let [x_m, y_m] = [error.x_m - center_m[0], error.y_m - center_m[1]];
            x_m * x_m + y_m * y_m
        };
        let sd_m = (errors.iter().map(square).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
        Self { errors, center_m, sd_m }
    }

    /// Distance of the centre of gravity from the origin, in metres.
    pub(super) fn r_m(&self) -> f64 {
        self.center_m[0].hypot(self.center_m[1])
    }
}

impl Analysis {
    /// An `Analysis` of squares with this side, by an odometry with this calibration; `track_m` is the distance
    /// between the wheels by the data sheet.
    pub(super) fn new(cw: Group, ccw: Group, side_m: f64, track_m: f64, had: Calibration) -> Self {
        let ([x_cw, y_cw], [x_ccw, y_ccw]) = (cw.center_m, ccw.center_m);
        let type_a_rad = 0.5 * ((x_cw + x_ccw) + (y_cw - y_ccw)) / (-4.0 * side_m);
        let type_b_rad = 0.5 * ((x_cw - x_ccw) + (y_cw + y_ccw)) / (-4.0 * side_m);
        let track_ratio = FRAC_PI_2 / (FRAC_PI_2 - type_a_rad);
        let track = had.track * track_ratio;
        // (R + b/2) / (R − b/2), in a form that has no R beyond all bounds.
        let bend = track * track_m * (0.5 * type_b_rad).sin() / side_m;
        let wheel_ratio = (1.0 + bend) / (1.0 - bend);
        let ratio = wheel_ratio * had.wheels[1] / had.wheels[0];
        let wheels = [2.0 / (ratio + 1.0), 2.0 / (1.0 / ratio + 1.0)];
        let calibration = Calibration { wheels, track };
        Self { cw, ccw, type_a_rad, type_b_rad, wheel_ratio, track_ratio, calibration }
    }

    /// The measure E_max,syst, in metres.
    pub(super) fn e_max_syst_m(&self) -> f64 {
        self.cw.r_m().max(self.ccw.r_m())
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Pose, Twist, angle};

    use super::*;

    const TRACK_M: f64 = 0.34;
    const SIDE_M: f64 = 4.0;

    /// The end of a robot with these errors that drives a square which is perfect by a calibrated odometry.
    fn end(wheel_ratio: f64, track_ratio: f64, clockwise: bool, calibration: Calibration) -> EndError {
        let sign = if clockwise { -1.0 } else { 1.0 };
        let left = 2.0 / (wheel_ratio + 1.0);
        let true_wheels = [left, wheel_ratio * left];
        let half_track_m = 0.5 * TRACK_M;
        let mut world_from_robot = Pose::new(0.0, 0.0, 0.0);
        // Counted, in metres of the data sheet's wheels: what odometry calls a side, and what it calls a quarter of a turn.
        let quarter_m = FRAC_PI_2 * calibration.track * half_track_m;
        for _ in 0..4 {
            for ways_m in [[SIDE_M; 2], [-sign * quarter_m, sign * quarter_m]] {
                let ways_m = [0, 1].map(|i| ways_m[i] / calibration.wheels[i] * true_wheels[i]);
                let moved = Twist::of_wheels(ways_m, track_ratio * half_track_m).then_from_now();
                world_from_robot = world_from_robot.compose(&moved);
            }
        }
        let Pose { position, heading } = world_from_robot;
        EndError { x_m: position.x, y_m: position.y, heading_rad: angle::wrap(heading) }
    }

    fn analysis(wheel_ratio: f64, track_ratio: f64, had: Calibration) -> Analysis {
        let group = |clockwise| Group::new(vec![end(wheel_ratio, track_ratio, clockwise, had); 2]);
        Analysis::new(group(true), group(false), SIDE_M, TRACK_M, had)
    }

    #[test]
    fn a_perfect_robot_has_no_errors() {
        let found = analysis(1.0, 1.0, Calibration::NONE);
        assert!(found.e_max_syst_m() < 1e-12, "{found:?}");
        assert!(
            (found.wheel_ratio - 1.0).abs() < 1e-12 && (found.track_ratio - 1.0).abs() < 1e-12,
            "{found:?}"
        );
    }

    #[test]
    fn small_errors_are_found_to_a_hundredth_of_themselves() {
        for (wheel_ratio, track_ratio) in [(1.0002, 1.0), (1.0, 1.002), (0.9998, 0.998), (1.0002, 1.002)] {
            let found = analysis(wheel_ratio, track_ratio, Calibration::NONE);
            let error =
                |found: f64, injected: f64| (found - injected).abs() / (injected - 1.0_f64).abs().max(2e-4);
            assert!(error(found.wheel_ratio, wheel_ratio) < 0.01, "{wheel_ratio}: {found:?}");
            assert!(error(found.track_ratio, track_ratio) < 0.01, "{track_ratio}: {found:?}");
        }
    }

    #[test]
    fn a_second_measurement_finds_what_the_first_has_left_of_large_errors() {
        let (wheel_ratio, track_ratio) = (1.01, 1.05);
        let first = analysis(wheel_ratio, track_ratio, Calibration::NONE);
        let second = analysis(wheel_ratio, track_ratio, first.calibration);
        let Calibration { wheels: [left, right], track } = second.calibration;
        assert!((right / left - wheel_ratio).abs() < 1e-4 * 0.5, "{second:?}");
        assert!((track - track_ratio).abs() < 5e-4, "{second:?}");
        assert!(second.e_max_syst_m() < 0.1 * first.e_max_syst_m(), "{first:?}\n{second:?}");
        assert!((0.5 * (left + right) - 1.0).abs() < 1e-3, "{second:?}");
    }

    #[test]
    fn an_error_of_type_a_is_seen_on_opposite_sides_and_one_of_type_b_on_the_same() {
        let a = analysis(1.0, 1.01, Calibration::NONE);
        assert!(a.cw.center_m[1] < 0.0 && a.ccw.center_m[1] > 0.0 && a.type_a_rad > 0.0, "{a:?}");
        let b = analysis(1.001, 1.0, Calibration::NONE);
        assert!(b.cw.center_m[1] < 0.0 && b.ccw.center_m[1] < 0.0 && b.type_b_rad > 0.0, "{b:?}");
    }

    #[test]
    fn the_standard_deviation_counts_both_axes() {
        let error = |x_m, y_m| EndError { x_m, y_m, heading_rad: 0.0 };
        let group = Group::new(vec![error(1.0, 0.0), error(-1.0, 0.0), error(0.0, 2.0), error(0.0, -2.0)]);
        assert_eq!(group.center_m, [0.0, 0.0]);
        assert!((group.sd_m - (10.0_f64 / 3.0).sqrt()).abs() < 1e-15, "{group:?}");
        assert_eq!(Group::new(vec![error(3.0, 4.0)]).sd_m, 0.0);
    }
}
