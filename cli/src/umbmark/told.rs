//! The result of UMBmark, for people and for programs.

use baudbot_brains::odometry::Calibration;
use baudbot_plot::quantity::{count, handy};
use baudbot_sim::drive::Deviation;
use baudbot_sim::model::RobotSpec;
use serde::Serialize;

use super::analysis::{Analysis, EndError, Group};
use super::course::Course;
use super::mm;
use crate::args::UmbmarkArgs;
use crate::text::{pairs, table};

/// The result to report.
pub(super) struct Told<'a> {
    pub(super) args: &'a UmbmarkArgs,
    pub(super) robot: &'a RobotSpec,
    pub(super) course: &'a Course,
    pub(super) first: &'a Analysis,
    /// The analysis with the corrections of the first.
    pub(super) second: Option<Analysis>,
}

/// The result, for programs.
#[derive(Serialize)]
pub(super) struct Found {
    robot: String,
    sensor: String,
    side_m: f64,
    speed_m_s: f64,
    arena: &'static str,
    measurements: Vec<Measurement>,
    corrected: Corrected,
    /// The scenario's values, which the robot's brain does not know.
    truth: Factors,
}

/// One measurement in both directions.
#[derive(Serialize)]
struct Measurement {
    cw: Ends,
    ccw: Ends,
    e_max_syst_m: f64,
    /// The angle α, in radians.
    type_a_rad: f64,
    /// The angle β, in radians.
    type_b_rad: f64,
    /// E_d and E_b, against the correction that this measurement was made with.
    wheel_ratio: f64,
    track_ratio: f64,
}

#[derive(Serialize)]
struct Ends {
    center_x_m: f64,
    center_y_m: f64,
    r_m: f64,
    sd_m: f64,
    runs: Vec<End>,
}

#[derive(Serialize)]
struct End {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

/// The values to reckon with from now on.
#[derive(Serialize)]
struct Corrected {
    wheel_ratio: f64,
    track_ratio: f64,
    wheel_factors: [f64; 2],
    wheel_radii_m: [f64; 2],
    track_m: f64,
}

#[derive(Serialize)]
struct Factors {
    wheel_ratio: f64,
    wheel_scale: f64,
    track_ratio: f64,
}

impl From<&Analysis> for Measurement {
    fn from(analysis: &Analysis) -> Self {
        Self {
            cw: Ends::from(&analysis.cw),
            ccw: Ends::from(&analysis.ccw),
            e_max_syst_m: analysis.e_max_syst_m(),
            type_a_rad: analysis.type_a_rad,
            type_b_rad: analysis.type_b_rad,
            wheel_ratio: analysis.wheel_ratio,
            track_ratio: analysis.track_ratio,
        }
    }
}

impl From<&Group> for Ends {
    fn from(group: &Group) -> Self {
        let [center_x_m, center_y_m] = group.center_m;
        let end = |&EndError { x_m, y_m, heading_rad }: &EndError| End { x_m, y_m, heading_rad };
        let runs = group.errors.iter().map(end).collect();
        Self { center_x_m, center_y_m, r_m: group.r_m(), sd_m: group.sd_m, runs }
    }
}

impl Told<'_> {
    pub(super) fn found(&self) -> Found {
        Found {
            robot: self.robot.name.clone(),
            sensor: self.course.sensor.clone(),
            side_m: self.args.side_m,
            speed_m_s: self.course.speed_m_s,
            arena: ARENA,
            measurements: [self.first].into_iter().chain(&self.second).map(Measurement::from).collect(),
            corrected: self.corrected(),
            truth: self.truth(),
        }
    }

    pub(super) fn words(&self) -> String {
        let head = [
            ("robot", format!("{}, steering by `{}`", self.robot.name, self.course.sensor)),
            ("square", self.square()),
            ("arena", ARENA.to_owned()),
        ];
        let mut words = pairs("", &head) + "\n" + &ends(self.first) + "\n" + &pairs("", &self.errors());
        if let Some(second) = &self.second {
            words +=
                &format!("\nagain, corrected:\n{}\n{}", ends(second), pairs("", &after(self.first, second)));
        }
        words + "\n" + &pairs("", &self.corrections()) + &self.warning()
    }

    fn square(&self) -> String {
        let (side, speed) = (handy(self.args.side_m), handy(self.course.speed_m_s));
        let runs = count(self.args.runs as usize, "run");
        format!("{side} m a side at {speed} m/s, {runs} in each direction")
    }

    /// The errors of the wheels by the first measurement.
    fn errors(&self) -> [(&'static str, String); 5] {
        let Analysis { type_a_rad, type_b_rad, wheel_ratio, track_ratio, .. } = self.first;
        [
            ("E_max,syst", format!("{} mm", mm(self.first.e_max_syst_m()))),
            ("α, type A", format!("{:.3}° a turn", type_a_rad.to_degrees())),
            ("β, type B", format!("{:.3}° a side", type_b_rad.to_degrees())),
            ("E_d", format!("{wheel_ratio:.6}, diameters right / left")),
            ("E_b", format!("{track_ratio:.6}, track by that of the data sheet")),
        ]
    }

    /// The values to write into a brain, and the scenario's.
    fn corrections(&self) -> Vec<(&'static str, String)> {
        let Corrected { wheel_factors: [c_l, c_r], wheel_radii_m: [left, right], track_m, .. } =
            self.corrected();
        let Corrected { wheel_ratio, track_ratio, .. } = self.corrected();
        let mut lines = vec![
            ("wheel radii", format!("{:.4} mm left, {:.4} mm right", 1e3 * left, 1e3 * right)),
            ("track", format!("{:.4} mm", 1e3 * track_m)),
            ("in a brain", format!("wheel_factors = [{c_l:.6}, {c_r:.6}], track_factor = {track_ratio:.6}")),
        ];
        let truth = self.truth();
        if self.robot.drive.deviation.is_some() {
            let words = format!(
                "E_d {:.6} (found {wheel_ratio:.6}), E_b {:.6} (found {track_ratio:.6})",
                truth.wheel_ratio, truth.track_ratio
            );
            lines.push(("the scenario", words));
        }
        lines
    }

    /// Formulas of first order do not suit large errors.
    fn warning(&self) -> String {
        let large = self.first.e_max_syst_m() > LARGE * self.args.side_m;
        if !large {
            return String::new();
        }
        let remedy =
            if self.second.is_some() { "a shorter --side-m" } else { "--check, or a shorter --side-m" };
        format!(
            "\nThe errors are large for this square, and the formulas are of first order: try {remedy}.\n"
        )
    }

    fn calibration(&self) -> Calibration {
        self.second.as_ref().unwrap_or(self.first).calibration
    }

    fn corrected(&self) -> Corrected {
        let Calibration { wheels: [left, right], track } = self.calibration();
        let radius_m = self.course.wheel_radius_m();
        Corrected {
            wheel_ratio: right / left,
            track_ratio: track,
            wheel_factors: [left, right],
            wheel_radii_m: [left * radius_m, right * radius_m],
            track_m: track * self.course.track_m(),
        }
    }

    fn truth(&self) -> Factors {
        let drive = &self.robot.drive;
        let Some(Deviation { wheels, half_track_m }) = drive.deviation else {
            return Factors { wheel_ratio: 1.0, wheel_scale: 1.0, track_ratio: 1.0 };
        };
        Factors {
            wheel_ratio: wheels.right / wheels.left,
            wheel_scale: 0.5 * (wheels.left + wheels.right),
            track_ratio: half_track_m / drive.half_track_m,
        }
    }
}

/// The ends of the runs of both directions.
fn ends(analysis: &Analysis) -> String {
    let head = ["ends, truth − odometry", "x, mm", "y, mm", "θ, °", "r, mm", "σ, mm"].map(str::to_owned);
    let mut rows = vec![head];
    for (name, group) in [("cw", &analysis.cw), ("ccw", &analysis.ccw)] {
        for (i, EndError { x_m, y_m, heading_rad }) in group.errors.iter().enumerate() {
            let heading = format!("{:.2}", (1e2 * heading_rad.to_degrees()).round() / 1e2 + 0.0);
            rows.push([
                format!("{name} {}", i + 1),
                mm(*x_m),
                mm(*y_m),
                heading,
                mm(x_m.hypot(*y_m)),
                String::new(),
            ]);
        }
        let [x_m, y_m] = group.center_m;
        let name = format!("{name}, centre of gravity");
        rows.push([name, mm(x_m), mm(y_m), String::new(), mm(group.r_m()), mm(group.sd_m)]);
    }
    table("", &rows)
}

/// The effect of the correction.
fn after(first: &Analysis, second: &Analysis) -> [(&'static str, String); 1] {
    let (before_m, after_m) = (first.e_max_syst_m(), second.e_max_syst_m());
    let better = format!("{} times better", handy((before_m / after_m * 10.0).round() / 10.0));
    [("E_max,syst", format!("{} mm, before {} mm: {better}", mm(after_m), mm(before_m)))]
}

const ARENA: &str = "empty and unbounded, in place of the scenario's";

/// Errors that are a larger part of the side are not small.
const LARGE: f64 = 0.2;
