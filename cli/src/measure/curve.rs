//! `baudbot measure curve`: a sensor's readings at distances that a person sets and types.

use std::io::{self, IsTerminal};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Context;
use baudbot_plot::quantity::{count, handy};

use super::numbers::numbers;
use super::port::Port;
use super::table::Table;
use super::typed::{Typed, ask};
use crate::args::{Bytes, CurveArgs};
use crate::signals::{INTERRUPTED, Stop};
use crate::text::{self, tell};

pub(super) fn curve(args: &CurveArgs) -> anyhow::Result<ExitCode> {
    let mut notes = vec![("experiment", "curve".to_owned())];
    if let Some(device) = &args.device {
        notes.push(("device", device.display().to_string()));
        notes.push(("baud", args.port.baud.to_string()));
    }
    let columns =
        if args.sensor.is_some() { "distance_mm,value_raw,sensor" } else { "distance_mm,value_raw" };
    let mut table = Table::open(&args.output, &notes, columns)?;
    let stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let mut source = match (&args.device, &args.ask) {
        (Some(device), Some(ask)) => {
            Source::Device { port: Port::open(&args.port, device)?, ask: ask.clone() }
        }
        (None, _) | (_, None) => Source::Person,
    };
    if !table.is_empty() {
        tell!("continuing: {}", table.words());
    }
    let is_stopped = collect(args, &mut table, &mut source, &stop)?;
    text::print(&format!("{}\n", table.words()))?;
    Ok(if is_stopped { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// The source of readings.
enum Source {
    Device { port: Port, ask: Bytes },
    Person,
}

/// Collects readings distance by distance, until Ctrl-D or Ctrl-C; returns whether it was Ctrl-C.
fn collect(args: &CurveArgs, table: &mut Table, source: &mut Source, stop: &Stop) -> anyhow::Result<bool> {
    loop {
        let line = match ask(PROMPT, stop)? {
            Typed::Line(line) => line,
            Typed::End => {
                if io::stdin().is_terminal() {
                    tell!("");
                }
                return Ok(false);
            }
            Typed::Stopped => return Ok(true),
        };
        match line.as_str() {
            "" => continue,
            "undo" | "u" => {
                match table.undo()? {
                    Some((distance_mm, rows)) => {
                        tell!("removed {} at {distance_mm} mm", count(rows, "reading"));
                    }
                    None => tell!("there is nothing to undo"),
                }
                continue;
            }
            _ => {}
        }
        let Some(distance_mm) = distance_mm(&line) else {
            tell!(
                "`{line}` is not a distance; type a number with its unit, such as `50 mm`, `5 cm` or `0.05 m`"
            );
            continue;
        };
        let (readings, is_stopped) = source.readings(args, stop)?;
        let tail = args.sensor.as_ref().map(|name| format!(",{name}")).unwrap_or_default();
        table.add(readings.iter().map(|reading| format!("{distance_mm},{reading}{tail}")))?;
        tell!("{distance_mm} mm: {}", described(&readings));
        if is_stopped {
            return Ok(true);
        }
    }
}

impl Source {
    /// Readings at one distance, and whether Ctrl-C has ended it.
    fn readings(&mut self, args: &CurveArgs, stop: &Stop) -> anyhow::Result<(Vec<f64>, bool)> {
        let mut readings = Vec::new();
        while readings.len() < args.readings as usize {
            if stop.is_wanted() {
                return Ok((readings, true));
            }
            match self {
                Self::Device { port, ask } => match reading(args, port, ask)? {
                    Ok(number) => readings.push(number),
                    Err(problem) => {
                        tell!("{problem}");
                        break;
                    }
                },
                Self::Person => {
                    let prompt =
                        format!("  reading {} of {} (Enter ends): ", readings.len() + 1, args.readings);
                    match ask(&prompt, stop)? {
                        Typed::Stopped => return Ok((readings, true)),
                        Typed::End => break,
                        Typed::Line(line) if line.is_empty() => break,
                        Typed::Line(line) => match line.parse() {
                            Ok(number) if f64::is_finite(number) => readings.push(number),
                            _ => tell!("  `{line}` is not a number"),
                        },
                    }
                }
            }
        }
        Ok((readings, false))
    }
}

/// A reading of the device; the inner error is what is wrong with its answer, after which the next may be better.
fn reading(args: &CurveArgs, port: &mut Port, ask: &Bytes) -> anyhow::Result<Result<f64, NoReading>> {
    port.discard()?;
    port.write(&ask.0)?;
    let deadline = Instant::now() + Duration::from_millis(args.port.timeout_ms.into());
    let mut last = None;
    while let Some(line) = port.line(deadline)? {
        if let Some(number) = numbers(&line).get(usize::from(args.number) - 1) {
            return Ok(Ok(*number));
        }
        last = Some(line);
    }
    Ok(Err(NoReading { device: port.name(), number: args.number, last }))
}

/// The device has not answered, or not with a number.
#[derive(Debug)]
struct NoReading {
    device: String,
    number: u16,
    last: Option<String>,
}

impl std::fmt::Display for NoReading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.last {
            Some(line) => write!(f, "{}: `{line}` has no number {}; see --number", self.device, self.number),
            None => {
                write!(
                    f,
                    "{}: no line came within --timeout-ms; check --baud, --ask and the end of its lines",
                    self.device
                )
            }
        }
    }
}

/// A distance with its unit, in millimetres.
fn distance_mm(text: &str) -> Option<f64> {
    let end = text.find(|c: char| c.is_ascii_alphabetic())?;
    let (number, unit) = text.split_at(end);
    let mm = match unit {
        "mm" => 1.0,
        "cm" => 10.0,
        "m" => 1000.0,
        "in" => 25.4,
        _ => return None,
    };
    let distance_mm = number.trim().parse::<f64>().ok()? * mm;
    // A micrometre more or less is rounding.
    let rounded = (distance_mm * 1e3).round() / 1e3;
    (rounded.is_finite() && rounded >= 0.0).then_some(rounded)
}

fn described(readings: &[f64]) -> String {
    let number = readings.len() as f64;
    if readings.is_empty() {
        return "no readings".to_owned();
    }
    let mean = readings.iter().sum::<f64>() / number;
    let squares: f64 = readings.iter().map(|reading| (reading - mean) * (reading - mean)).sum();
    let sd = (squares / (number - 1.0).max(1.0)).sqrt();
    format!("{}, mean {}, sd {}", count(readings.len(), "reading"), handy(mean), handy(sd))
}

const PROMPT: &str = "distance (such as `50 mm`, or `undo`; Ctrl-D ends): ";

#[cfg(test)]
mod tests {
    use super::distance_mm;

    #[test]
    fn distances_need_a_unit() {
        let known = ["50 mm", "5cm", "0.05 m", "2 in", "0 mm"].map(distance_mm);
        assert_eq!(known, [Some(50.0), Some(50.0), Some(50.0), Some(50.8), Some(0.0)]);
        assert_eq!(["50", "mm", "-1 mm", "5 km", "nan m", "1e400 m", "x"].map(distance_mm), [None; 7]);
    }
}
