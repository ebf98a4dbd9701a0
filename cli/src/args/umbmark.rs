//! The arguments of `baudbot umbmark`.

use std::path::PathBuf;

use clap::Args;

use super::value::{Bounds, ValueError, whole};
use super::{ChangeArgs, finite};

#[derive(Debug, Args)]
pub(crate) struct UmbmarkArgs {
    /// A scenario file, or a built-in scenario, such as wander or devices/laser (`baudbot list`)
    pub(crate) scenario: String,
    /// The robot to measure [default: the first]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Steer by this sensor of the robot [default: its encoders, or else its odometer]
    #[arg(long, value_name = "SENSOR")]
    pub(crate) sensor: Option<String>,
    /// Side of the square, in metres
    #[arg(long, value_name = "M", default_value_t = 4.0, allow_negative_numbers = true, value_parser = side)]
    pub(crate) side_m: f64,
    /// Runs in each direction
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole(1_u32..=1000))]
    pub(crate) runs: u32,
    /// Speed on the sides, in metres per second [default: 0.2, limited to a range that suits the robot]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) speed_m_s: Option<f64>,
    /// Measure again with the corrections applied
    #[arg(long)]
    pub(crate) check: bool,
    /// Draw the final positions of the runs as an SVG picture; `-` is stdout, without other output
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the result as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

/// The side of a square that a robot can drive round.
fn side(text: &str) -> Result<f64, ValueError> {
    Bounds::Between(LEAST_SIDE_M, MOST_SIDE_M).parsed(text)
}

const LEAST_SIDE_M: f64 = 0.1;
const MOST_SIDE_M: f64 = 1000.0;

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot umbmark arsim                          five squares of 4 m each way, by the robot's odometer
  baudbot umbmark my.toml --check                E_max,syst before and after the correction
  baudbot umbmark my.toml --set robots.robot.body.track_ratio=1.02 --set robots.robot.body.wheel_ratio=1.002 --check
  baudbot umbmark khepera --side-m 0.5 --runs 10 --svg ends.svg
  baudbot umbmark my.toml --json | python3 -m json.tool

The robot drives in an empty arena of its own, whatever the scenario's arena is. See docs/how-to/umbmark.md.";
