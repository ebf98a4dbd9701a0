//! The views of chips in a run: `--gdb ROBOT=PORT`, `--vcd ROBOT=FILE` and `--serial ROBOT=FILE`.

use std::path::PathBuf;

use clap::Args;

use super::GdbAddress;
use super::value::ValueError;

#[derive(Debug, Args)]
#[command(next_help_heading = "Firmware")]
pub(crate) struct ChipArgs {
    /// Debug a robot's firmware with avr-gdb, on a port of this machine; may be given several times
    ///
    /// The world waits at the chip's reset until a debugger connects, and is suspended whenever the chip is stopped. Port 0 picks a free
    /// port. docs/how-to/debugging.md has an example.
    #[arg(long = "gdb", value_name = "ROBOT=PORT")]
    pub(crate) gdb: Vec<GdbAddress>,
    /// Write the signals on the pins of a robot's chip as a VCD file, for GTKWave; may be given several times
    #[arg(long, value_name = "ROBOT=FILE", value_parser = output)]
    pub(crate) vcd: Vec<ChipOutput>,
    /// Write the bytes that a robot's firmware sends to the laptop; `-` is stdout; may be given several times
    #[arg(long, value_name = "ROBOT=FILE", value_parser = output)]
    pub(crate) serial: Vec<ChipOutput>,
}

/// A robot, and the file for what is seen of its chip.
#[derive(Clone, Debug)]
pub(crate) struct ChipOutput {
    pub(crate) robot: String,
    pub(crate) file: PathBuf,
}

/// Parses `ROBOT=FILE`. Names of robots have no `=`.
pub(super) fn output(text: &str) -> Result<ChipOutput, ValueError> {
    match text.split_once('=') {
        Some((robot, file)) if !robot.is_empty() && !file.is_empty() => {
            Ok(ChipOutput { robot: robot.to_owned(), file: file.into() })
        }
        Some(_) | None => Err(ValueError::Form("write ROBOT=FILE")),
    }
}
