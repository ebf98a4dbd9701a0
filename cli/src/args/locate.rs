//! The arguments of `baudbot locate`.

use std::path::PathBuf;

use baudbot_brains::localization::{laser, refine};
use baudbot_geometry::{Pose, angle};
use clap::{Args, ValueEnum};

use super::value::{Bounds, OptionError, ValueError, whole};
use super::{ChangeArgs, finite};

#[derive(Debug, Args)]
pub(crate) struct LocateArgs {
    /// A scenario file, or a built-in scenario; one of its robots needs a laser
    pub(crate) scenario: String,
    /// The robot's believed pose, in metres and radians
    #[arg(long, value_name = "X,Y,RAD", allow_hyphen_values = true, value_parser = pose)]
    pub(crate) guess: Pose,
    /// The robot's true pose, in metres and radians [default: its start]
    #[arg(long, value_name = "X,Y,RAD", allow_hyphen_values = true, value_parser = pose)]
    pub(crate) at: Option<Pose>,
    /// The robot to localize [default: the first with a laser]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// The laser to use [default: the robot's first that is not on a turret]
    #[arg(long, value_name = "SENSOR")]
    pub(crate) laser: Option<String>,
    /// Search method
    #[arg(long, value_name = "METHOD", default_value = "search")]
    pub(crate) method: Search,
    /// Approximate number of rays of the scan to match
    #[arg(long, value_name = "N", default_value_t = 171, value_parser = whole(1_u32..=100_000))]
    pub(crate) rays: u32,
    #[command(flatten)]
    pub(crate) search: SearchArgs,
    #[command(flatten)]
    pub(crate) refine: RefineArgs,
    /// Draw the scan and the poses tried as an SVG picture; `-` is stdout, without other output
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the result, and all poses tried, as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

/// The method by which a pose is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Search {
    /// Random poses in a box around the best pose so far, as in the lecture notes
    Search,
    /// Robust least squares on the rays, starting from the guess and from poses drawn around it
    Refine,
}

/// What only `--method search` has.
#[derive(Debug, Args)]
pub(crate) struct SearchArgs {
    /// search: whole width of the box in x and in y, in metres [default: 0.1]
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = finite)]
    box_m: Option<f64>,
    /// search: whole width of the box in heading, in radians [default: 0.1]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true, value_parser = finite)]
    box_rad: Option<f64>,
    /// search: stop below this matching error; 0 tries all poses [default: 0.02]
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true, value_parser = finite)]
    threshold: Option<f64>,
    /// search: maximum number of poses besides the guess [default: 300]
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=100_000))]
    iterations: Option<u32>,
    /// search: shrink the box after failures, unlike the lecture notes
    #[arg(long)]
    shrink: bool,
}

/// What only `--method refine` has.
#[derive(Debug, Args)]
pub(crate) struct RefineArgs {
    /// refine: maximum number of starts besides the guess [default: 8]
    #[arg(long, value_name = "N", value_parser = whole(0_u32..=1000))]
    starts: Option<u32>,
    /// refine: standard deviation of the guess in x and in y, in metres [default: 0.2]
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = finite)]
    sd_m: Option<f64>,
    /// refine: standard deviation of the guess in heading, in radians [default: 0.2]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true, value_parser = finite)]
    sd_rad: Option<f64>,
}

impl SearchArgs {
    /// The options that are given.
    pub(crate) fn given(&self) -> impl Iterator<Item = &'static str> {
        let all = [
            ("--box-m", self.box_m.is_some()),
            ("--box-rad", self.box_rad.is_some()),
            ("--threshold", self.threshold.is_some()),
            ("--iterations", self.iterations.is_some()),
            ("--shrink", self.shrink),
        ];
        all.into_iter().filter(|(_, is)| *is).map(|(option, _)| option)
    }

    /// The parameters for the library, or the option that cannot be so.
    pub(crate) fn parameters(&self) -> Result<laser::Parameters, OptionError> {
        let default = laser::Parameters::default();
        Ok(laser::Parameters {
            box_m: positive("--box-m", self.box_m.unwrap_or(default.box_m))?,
            box_rad: positive("--box-rad", self.box_rad.unwrap_or(default.box_rad))?,
            threshold: checked("--threshold", Bounds::AtLeast0, self.threshold.unwrap_or(default.threshold))?,
            iterations: self.iterations.map_or(default.iterations, |n| n as usize),
            shrink: self.shrink.then(Default::default),
        })
    }
}

impl RefineArgs {
    /// The options that are given.
    pub(crate) fn given(&self) -> impl Iterator<Item = &'static str> {
        let all = [
            ("--starts", self.starts.is_some()),
            ("--sd-m", self.sd_m.is_some()),
            ("--sd-rad", self.sd_rad.is_some()),
        ];
        all.into_iter().filter(|(_, is)| *is).map(|(option, _)| option)
    }

    /// The parameters for the library.
    pub(crate) fn parameters(&self) -> refine::Parameters {
        let default = refine::Parameters::default();
        refine::Parameters { starts: self.starts.map_or(default.starts, |n| n as usize), ..default }
    }

    /// The uncertainty of the guess, in metres and radians, or the option that cannot be so.
    pub(crate) fn deviations(&self) -> Result<(f64, f64), OptionError> {
        let sd_m = positive("--sd-m", self.sd_m.unwrap_or(UNSURE))?;
        Ok((sd_m, positive("--sd-rad", self.sd_rad.unwrap_or(UNSURE))?))
    }
}

/// A length or an angle that is one.
fn positive(option: &'static str, number: f64) -> Result<f64, OptionError> {
    checked(option, Bounds::Above0AtMost(MOST), number)
}

fn checked(option: &'static str, bounds: Bounds, number: f64) -> Result<f64, OptionError> {
    bounds.checked(number).map_err(|error| OptionError { option, error })
}

fn pose(text: &str) -> Result<Pose, ValueError> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| finite(number.trim()).ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, heading]) if [x, y, heading].iter().all(|number| number.abs() <= MOST_PLACE) => {
            Ok(Pose::new(x, y, angle::wrap(heading)))
        }
        _ => Err(ValueError::Example {
            form: "x, y and heading with commas between them, in metres and radians, such as 1.5,-2,0.1",
            text: text.to_owned(),
        }),
    }
}

/// The default uncertainty of a guess, in metres and radians.
const UNSURE: f64 = 0.2;

/// No box is wider, and no guess less sure, in metres and radians.
const MOST: f64 = 100.0;

/// As in scenarios.
const MOST_PLACE: f64 = 1e6;

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot locate tour --guess 2.3,1.8,0.2
  baudbot locate tour --guess 2.3,1.8,0.2 --threshold 0 --seed 2 --svg poses.svg
  baudbot locate tour --at 6,3,1.5 --guess 5.5,3.3,1.9 --method refine
  baudbot locate my.toml --robot alice --laser urg --guess 0.1,0,0.05 --iterations 1000 --shrink --json

The robot stands still, and its laser takes one scan with noise, as in a run. The map contains the stationary things at the
height of the laser; moving things appear in the scan, but not in the map. --seed changes the noise of the scan and the
poses tried. The exit code is 1 if too few rays could be compared at every pose.";
