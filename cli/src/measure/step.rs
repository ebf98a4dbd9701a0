//! `baudbot measure step`: how the wheels of a robot answer to a step of their command.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;

use super::header;
use super::numbers::numbers;
use super::port::Port;
use super::typed::{Typed, ask};
use crate::args::StepArgs;
use crate::error::Refused;
use crate::escapes::unescaped;
use crate::output_files;
use crate::signals::{INTERRUPTED, Stop};
use crate::text::{self, pairs, tell};

pub(super) fn step(args: &StepArgs) -> anyhow::Result<ExitCode> {
    let stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    if !is_allowed(args, &stop)? {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let mut robot = Robot { port: Port::open(&args.port, &args.device)?, args };
    let unwritable = || format!("cannot write {}", args.output.display());
    let mut file = output_files::open(&args.output).with_context(unwritable)?;
    file.write_all(head(args).as_bytes()).with_context(unwritable)?;
    let mut log = Log { args, file: &mut file, start: Instant::now(), last: None, samples: 0, missed: 0 };
    let is_stopped = drive(args, &mut robot, &mut log, &stop)?;
    let words = log.words();
    file.flush().with_context(unwritable)?;
    if args.output.as_os_str() == "-" {
        tell!("{}", words.trim_end());
    } else {
        text::print(&words)?;
    }
    Ok(if is_stopped { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// Whether the person lets the robot move.
fn is_allowed(args: &StepArgs, stop: &Stop) -> anyhow::Result<bool> {
    if args.yes {
        return Ok(true);
    }
    if !io::stdin().is_terminal() {
        return Err(Refused::error(
            "the robot will move: give it room and add --yes, or run this in a terminal",
        ));
    }
    tell!(
        "THE ROBOT WILL MOVE for {} s with the commands {} and {}. Lift its wheels off the ground, or give it room, and keep its \
         switch within reach.",
        args.seconds,
        args.left,
        args.right
    );
    Ok(matches!(ask("Enter starts it, Ctrl-C does not: ", stop)?, Typed::Line(_)))
}

/// The text above the table.
fn head(args: &StepArgs) -> String {
    let mut notes = vec![
        ("experiment", "step".to_owned()),
        ("device", args.device.display().to_string()),
        ("baud", args.port.baud.to_string()),
        ("full", args.full.to_string()),
    ];
    notes.extend(args.m_per_count.map(|way| ("m_per_count", way.to_string())));
    notes.extend(args.track_m.map(|track| ("track_m", track.to_string())));
    let mut columns = "time_s,command_left,command_right,count_left,count_right".to_owned();
    if args.m_per_count.is_some() {
        columns += ",speed_m_s";
    }
    if args.track_m.is_some() {
        columns += ",turn_rate_rad_s";
    }
    header(&notes, &columns)
}

/// Watches the robot at rest, driving, and at rest again. Returns whether Ctrl-C ended it.
fn drive(args: &StepArgs, robot: &mut Robot<'_>, log: &mut Log<'_>, stop: &Stop) -> anyhow::Result<bool> {
    let rest = (args.rest_s, [0.0; 2]);
    let mut end_s = 0.0;
    let mut next = log.start;
    for (span_s, command) in [rest, (args.seconds, [args.left, args.right]), rest] {
        end_s += span_s;
        robot.command(command)?;
        while next < log.start + Duration::from_secs_f64(end_s) {
            thread::sleep(next.saturating_duration_since(Instant::now()));
            if stop.is_wanted() {
                return Ok(true);
            }
            let sent = Instant::now();
            let counts = robot.counts(log.start + Duration::from_secs_f64(end_s))?;
            log.note(sent + (Instant::now() - sent) / 2, command, counts)?;
            if log.samples == 0 && log.missed >= GIVES_UP_AFTER {
                return Err(robot.silent());
            }
            next = (next + Duration::from_millis(args.period_ms.into())).max(Instant::now());
        }
        if log.samples == 0 {
            return Err(robot.silent());
        }
    }
    Ok(false)
}

/// A robot that is stopped whatever happens.
struct Robot<'a> {
    port: Port,
    args: &'a StepArgs,
}

impl Robot<'_> {
    /// Sets both motors, in the robot's own units.
    fn command(&mut self, [left, right]: [f64; 2]) -> anyhow::Result<()> {
        let text = self.args.command.replace("{left}", &left.to_string());
        self.port.write(&unescaped(&text.replace("{right}", &right.to_string()))?)
    }

    /// Counts of both wheels; `None` if no answer with them came in time, or before the command is to change.
    fn counts(&mut self, change: Instant) -> anyhow::Result<Option<[f64; 2]>> {
        // An answer that came too late is not one to this question.
        self.port.discard()?;
        self.port.write(&self.args.ask.0)?;
        let timeout = Duration::from_millis(self.args.port.timeout_ms.into());
        let deadline = change.min(Instant::now() + timeout);
        let first = usize::from(self.args.number) - 1;
        while let Some(line) = self.port.line(deadline)? {
            // Commands are answered, too, but not with so many numbers.
            if let Some([left, right, ..]) = numbers(&line).get(first..) {
                return Ok(Some([*left, *right]));
            }
        }
        Ok(None)
    }

    fn silent(&self) -> anyhow::Error {
        anyhow::anyhow!(
            "{}: no answer with the counts of two wheels; check --baud, --ask, --number and the end of its lines. No command \
             to move was sent",
            self.port.name()
        )
    }
}

impl Drop for Robot<'_> {
    fn drop(&mut self) {
        // More than once, as a robot may be busy, or a byte be lost.
        for _ in 0..3 {
            let _ = self.command([0.0; 2]);
            self.port.drain();
            thread::sleep(STOP_PAUSE);
        }
    }
}

/// The table.
struct Log<'a> {
    args: &'a StepArgs,
    file: &'a mut dyn Write,
    start: Instant,
    last: Option<(f64, [f64; 2])>,
    samples: u32,
    missed: u32,
}

impl Log<'_> {
    /// A row: counts at an instant while a command was in force.
    fn note(&mut self, at: Instant, command: [f64; 2], counts: Option<[f64; 2]>) -> anyhow::Result<()> {
        let Some(counts) = counts else {
            self.missed += 1;
            return Ok(());
        };
        self.samples += 1;
        let time_s = at.saturating_duration_since(self.start).as_secs_f64();
        let [left, right] = command.map(|command| command / self.args.full);
        let mut row = format!("{time_s:.6},{left},{right},{},{}", counts[0], counts[1]);
        if let Some(m_per_count) = self.args.m_per_count {
            // The cells of the first row stay empty, as there is no row before it.
            let speeds = self.last.map(|(before_s, before)| {
                [0, 1].map(|i| (counts[i] - before[i]) * m_per_count / (time_s - before_s))
            });
            row += &speeds
                .map_or_else(|| ",".to_owned(), |[left, right]| format!(",{:.6}", 0.5 * (left + right)));
            if let Some(track_m) = self.args.track_m {
                row += &speeds.map_or_else(
                    || ",".to_owned(),
                    |[left, right]| format!(",{:.6}", (right - left) / track_m),
                );
            }
        }
        self.last = Some((time_s, counts));
        writeln!(self.file, "{row}").context("cannot write the table")
    }

    fn words(&self) -> String {
        let mut lines = vec![("samples", self.samples.to_string()), ("unanswered", self.missed.to_string())];
        if let Some((time_s, [left, right])) = self.last {
            lines.push(("last", format!("{left} and {right} counts after {time_s:.3} s")));
        }
        pairs("", &lines)
    }
}

/// The number of questions without an answer at the start after which the device is taken not to answer.
const GIVES_UP_AFTER: u32 = 3;
/// The pause between two commands to stop.
const STOP_PAUSE: Duration = Duration::from_millis(20);
