//! `baudbot diagram`.

use std::path::PathBuf;

use clap::Args;

use super::value::whole;
use super::{ChangeArgs, instant, span};

#[derive(Debug, Args)]
pub(crate) struct DiagramArgs {
    /// A scenario file, a built-in scenario (`baudbot list`), or a recording (`.mcap`)
    #[arg(value_name = "SCENARIO|RUN.mcap")]
    pub(crate) scenario: String,
    /// A brain for one robot, or for all robots that no other --brain names, as in `baudbot run`; `none` leaves a robot without
    /// a brain
    #[arg(long = "brain", value_name = "[ROBOT=]BRAIN[:K=V,…]")]
    pub(crate) brains: Vec<String>,
    /// Set a parameter of all brains that have it; programs get it in the environment variable BAUDBOT_PARAMETERS
    #[arg(long = "parameter", value_name = "NAME=VALUE")]
    pub(crate) parameters: Vec<String>,
    /// The robot to show [default: the first]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Start of the window, in simulated seconds
    #[arg(long, value_name = "S", conflicts_with = "cycle", allow_negative_numbers = true, value_parser = instant)]
    pub(crate) at: Option<f64>,
    /// Show the N-th control cycle, from reading its sensors to its command, with the time beyond Δt in red [default: a window
    /// around the third cycle; for a robot with your own program, around the first round of the main loop that reads a sensor and
    /// then changes the drive of a wheel, or else around the first character sent or wheel driven]
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=100_000))]
    pub(crate) cycle: Option<u32>,
    /// Length of the window, in simulated milliseconds [default: 3 Δt, or the whole cycle]
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = span)]
    pub(crate) span: Option<f64>,
    /// Show these pins of the robot's chip, such as D9,A0 or PB1 [default: those with something on them, and those that change]
    #[arg(long, value_name = "PIN,…", value_delimiter = ',')]
    pub(crate) pins: Vec<String>,
    /// Draw an SVG picture; `-` is stdout [default: a table as text]
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the table as comma-separated values, with each edge on the pins; `-` is stdout
    #[arg(long, value_name = "FILE", conflicts_with = "svg")]
    pub(crate) csv: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}
