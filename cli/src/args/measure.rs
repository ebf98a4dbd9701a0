//! The arguments of `baudbot measure`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::finite;
use super::value::{Bounds, ValueError, whole};
use crate::escapes::unescaped;

#[derive(Debug, Subcommand)]
pub(crate) enum MeasureCommand {
    /// Measures round-trip times of bytes to a device on a serial port
    #[command(after_long_help = ECHO_EXAMPLES)]
    Echo(EchoArgs),
    /// Measures a sensor's readings at distances that you enter
    #[command(after_long_help = CURVE_EXAMPLES)]
    Curve(CurveArgs),
    /// Measures how a robot's wheels respond to a step in the command; THE ROBOT MOVES
    #[command(after_long_help = STEP_EXAMPLES)]
    Step(StepArgs),
}

/// A serial port.
#[derive(Debug, Args)]
pub(crate) struct PortArgs {
    /// Baud rate: 8 bits, no parity, 1 stop bit
    #[arg(long, value_name = "N", default_value_t = 115_200, value_parser = whole(50_u32..=4_000_000))]
    pub(crate) baud: u32,
    /// Wait at most this long for an answer, in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 1000, value_parser = whole(1_u32..=60_000))]
    pub(crate) timeout_ms: u32,
    /// Wait this long after opening the port, in milliseconds, because an Arduino restarts then
    #[arg(long, value_name = "MS", default_value_t = 2000, value_parser = whole(0_u32..=60_000))]
    pub(crate) settle_ms: u32,
}

#[derive(Debug, Args)]
pub(crate) struct EchoArgs {
    /// The serial port, such as /dev/ttyUSB0, with TX wired to RX or the echo sketch on the board
    #[arg(long, value_name = "PATH")]
    pub(crate) device: Option<PathBuf>,
    /// Number of messages to send
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole(1_u32..=10_000_000))]
    pub(crate) count: u32,
    /// Length of each message, in bytes
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(1_u32..=4096))]
    pub(crate) bytes: u32,
    /// Pause between an echo and the next message, in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 0, value_parser = whole(0_u32..=60_000))]
    pub(crate) pause_ms: u32,
    /// Write the table to this file; `-` is stdout, and the summary then goes to stderr
    #[arg(short, long, value_name = "FILE", default_value = "echo.csv")]
    pub(crate) output: PathBuf,
    /// Print an Arduino sketch that sends each byte back, and do nothing else
    #[arg(long)]
    pub(crate) sketch: bool,
    /// Suppress the progress bar
    #[arg(long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) port: PortArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CurveArgs {
    /// Write the table to this file; rows are appended to an existing one
    #[arg(short, long, value_name = "FILE", default_value = "curve.csv")]
    pub(crate) output: PathBuf,
    /// Take readings from this serial port [default: you enter them]
    #[arg(long, value_name = "PATH", requires = "ask")]
    pub(crate) device: Option<PathBuf>,
    /// Text that makes the device send a reading; \n, \r, \t and \xNN are escapes
    #[arg(long, value_name = "TEXT", requires = "device", value_parser = bytes)]
    pub(crate) ask: Option<Bytes>,
    /// Position of the reading among the numbers of the answer, counted from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(1_u16..=1000))]
    pub(crate) number: u16,
    /// Number of readings at each distance
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole(1_u32..=100_000))]
    pub(crate) readings: u32,
    /// Name of the sensor, for a column `sensor`: curves of several sensors can be in one file
    #[arg(long, value_name = "NAME", value_parser = word)]
    pub(crate) sensor: Option<String>,
    #[command(flatten)]
    pub(crate) port: PortArgs,
}

#[derive(Debug, Args)]
pub(crate) struct StepArgs {
    /// The robot's serial port, such as /dev/ttyUSB0
    #[arg(long, value_name = "PATH")]
    pub(crate) device: PathBuf,
    /// The command that sets the motors, containing {left} and {right}, such as 'D,{left},{right}\n'
    #[arg(long, value_name = "TEXT", value_parser = template)]
    pub(crate) command: String,
    /// Text that makes the robot send its wheel counts, such as 'H\n'
    #[arg(long, value_name = "TEXT", value_parser = bytes)]
    pub(crate) ask: Bytes,
    /// Position of the left count among the numbers of the answer, counted from 1; the right count is the next number
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(1_u16..=1000))]
    pub(crate) number: u16,
    /// Command for the left motor, in the robot's own units
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) left: f64,
    /// Command for the right motor, in the robot's own units
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) right: f64,
    /// The robot's command for full speed, written to the table as the signal 1
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) full: f64,
    /// Duration of the drive, in seconds
    #[arg(long, value_name = "S", default_value_t = 2.0, allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) seconds: f64,
    /// Time recorded before and after the drive, in seconds
    #[arg(long, value_name = "S", default_value_t = 0.5, allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) rest_s: f64,
    /// Time between two samples, in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 20, value_parser = whole(1_u32..=60_000))]
    pub(crate) period_ms: u32,
    /// Distance per count of a wheel, in metres: adds a column speed_m_s
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) m_per_count: Option<f64>,
    /// Distance between the wheels, in metres: adds a column turn_rate_rad_s
    #[arg(long, value_name = "M", requires = "m_per_count", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) track_m: Option<f64>,
    /// Write the table to this file; `-` is stdout
    #[arg(short, long, value_name = "FILE", default_value = "step.csv")]
    pub(crate) output: PathBuf,
    /// Do not ask whether the robot may move
    #[arg(long)]
    pub(crate) yes: bool,
    #[command(flatten)]
    pub(crate) port: PortArgs,
}

/// Bytes to be sent.
#[derive(Clone, Debug)]
pub(crate) struct Bytes(pub(crate) Vec<u8>);

fn bytes(text: &str) -> Result<Bytes, ValueError> {
    let bytes = unescaped(text)?;
    if bytes.is_empty() { Err(ValueError::Form("must have at least one byte")) } else { Ok(Bytes(bytes)) }
}

fn template(text: &str) -> Result<String, ValueError> {
    unescaped(text)?;
    let is_whole = ["{left}", "{right}"].iter().all(|part| text.contains(part));
    is_whole.then(|| text.to_owned()).ok_or(ValueError::Form("must have {left} and {right} in it"))
}

/// A word that needs no quotes in a table.
fn word(text: &str) -> Result<String, ValueError> {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    let is_fine = !text.is_empty() && text.chars().all(is_word);
    let error = ValueError::Form("must consist of letters, digits, _, - and .");
    is_fine.then(|| text.to_owned()).ok_or(error)
}

fn positive(text: &str) -> Result<f64, ValueError> {
    Bounds::Above0.parsed(text)
}

pub(super) fn seconds(text: &str) -> Result<f64, ValueError> {
    Bounds::Above0AtMost(MOST_S).parsed(text)
}

/// Nobody lets a robot drive for longer than that without looking.
const MOST_S: f64 = 600.0;

const ECHO_EXAMPLES: &str = "\
Examples:
  baudbot measure echo --sketch > echo.ino       an Arduino that sends each byte back
  baudbot measure echo --device /dev/ttyUSB0 -o echo.csv
  baudbot measure echo --device /dev/ttyUSB0 --baud 9600 --bytes 16 --count 200 --pause-ms 3

Each message is sent when the previous one has come back. Ctrl-C ends early, and keeps the measurements so far. See
docs/how-to/measure.md.";

const CURVE_EXAMPLES: &str = "\
Examples:
  baudbot measure curve -o ir.csv                you enter distances and readings
  baudbot measure curve -o ir.csv --device /dev/ttyUSB0 --baud 9600 --ask 'N\\n' --number 3 --readings 20

At the prompt: a distance with its unit (`50 mm`, `5 cm`, `0.05 m`), `undo`, or Ctrl-D to end. The file is written after
each distance; the same command continues it. See docs/how-to/measure.md.";

const STEP_EXAMPLES: &str = "\
Examples:
  baudbot measure step --device /dev/ttyUSB0 --baud 9600 --command 'D,{left},{right}\\n' --ask 'H\\n' \\
      --left 20 --right 20 --full 127 --m-per-count 0.00008333 -o step.csv

THE ROBOT MOVES: lift its wheels, or give it room, and keep its switch within reach. It is stopped at the end, and
on Ctrl-C, by the command with 0 and 0. See docs/how-to/measure.md.";
