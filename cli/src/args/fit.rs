//! The arguments of `baudbot fit`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// A log: a table whose columns have their unit in their name, or a recording in MCAP; `-` is stdin
    #[arg(value_name = "LOG", required_unless_present = "list")]
    pub(crate) file: Option<PathBuf>,
    /// The preset of a robot, a sensor, motors, a link or an adapter to fit
    #[arg(long, value_name = "PRESET", conflicts_with = "scenario", required_unless_present = "scenario")]
    pub(crate) preset: Option<String>,
    /// A scenario with the robot to fit
    #[arg(long, value_name = "FILE")]
    pub(crate) scenario: Option<String>,
    /// The robot, in the scenario and in the log [default: the only one]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Fields to fit, as paths below the robot; `*` matches any part of a name, and a table's name means all its fields
    #[arg(long, value_name = "FIELD,…", value_delimiter = ',', required_unless_present = "list")]
    pub(crate) fields: Vec<String>,
    /// Names of columns in the log where they differ, such as time_s=stamp,command_left=l
    #[arg(long, value_name = "NAME=COLUMN,…", value_delimiter = ',')]
    pub(crate) columns: Vec<String>,
    /// Before the fit, change one field of the scenario, such as robots.robot.link.baud=57600
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// List the fields that can be fitted, and the known columns
    #[arg(long)]
    pub(crate) list: bool,
    /// Draw the residuals between log and model as an SVG picture; `-` is stdout, without other output
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the numbers as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Suppress the progress bar
    #[arg(long)]
    pub(crate) quiet: bool,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot fit --list --preset khepera-1          what can be fitted, and from which columns
  baudbot fit echo.csv --preset ch340 --fields 'link.adapter.*'
  baudbot fit curve.csv --preset arsim --fields sensors.ir_left.c1_m2,sensors.ir_left.c2,sensors.ir_left.noise
  baudbot fit drive.csv --scenario my.toml --robot alice --fields 'motors.*' --svg rest.svg
  baudbot fit drive.csv --preset create-2 --fields motors.dead_time_ms --columns time_s=stamp,command_left=l,command_right=r

Stdout is TOML for the robot's table in a scenario; each line also works with --set, after `robots.NAME.`. What the
log cannot determine is a comment with the reason. The exit code is 1 if the log determines none of the fields.

A column's name ends in its unit: time _s _ms _us _ns, lengths _m _cm _mm, angles _rad _deg, speeds _m_s _cm_s _mm_s, turn
rates _rad_s _deg_s, values of sensors _raw _fraction _v. Lines that begin with # are comments, but `# baud: 9600` is read.";
