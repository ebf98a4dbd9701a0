//! The arguments of `baudbot export-brain`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::ChangeArgs;

#[derive(Debug, Args)]
pub(crate) struct ExportBrainArgs {
    /// A brain: a name, or a description file in TOML, with its parameters
    #[arg(value_name = "BRAIN[:K=V,…]")]
    pub(crate) brain: String,
    /// The language of the file
    #[arg(long, value_name = "LANGUAGE")]
    pub(crate) lang: ExportLanguage,
    /// A scenario file, or a built-in scenario, with the robot that gets the brain
    #[arg(long, value_name = "SCENARIO", default_value = crate::scenarios::DEFAULT)]
    pub(crate) scenario: String,
    /// The robot, whose sensors are the brain's readings [default: the scenario's first]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Write the file here; `-` is stdout
    #[arg(long, value_name = "FILE", default_value = "-")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

/// The language of an exported brain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportLanguage {
    /// C99, for a PC and for an ATmega328P
    C,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot export-brain avoid --lang c --out brain.c
  baudbot export-brain my-brain.toml --lang c --scenario my-robot.toml --robot alice --seed 7 --out brain.c
  baudbot export-brain patient --lang c --scenario patient | less

The comment at the head of the file says how to call it, and lists the readings. --seed chooses the brain's random numbers. What
cannot be exported, such as a behaviour that drives by the believed pose, is refused by its path (docs/how-to/export-brain.md).";
