//! Measured readings of a sensor, from comma-separated values into the scenario.

use std::path::Path;

use csv::{ErrorKind, StringRecord, Trim};
use toml_edit::{Array, DocumentMut, InlineTable, Item, Value};

use crate::error::{FileError, ImportError};
use crate::{file, tables};

/// Replaces the names of files with samples. Returns whether there are any.
pub(crate) fn inline(document: &mut DocumentMut, base: &Path) -> Result<bool, ImportError> {
    let mut has_any = false;
    let Some(robots) = document.get_mut("robots") else { return Ok(false) };
    for (i, robot) in tables::of(robots) {
        let Some(sensors) = robot.get_mut("sensors").and_then(Item::as_table_like_mut) else { continue };
        for (name, sensor) in sensors.iter_mut() {
            let Some(lookup) = sensor.as_table_like_mut().and_then(|sensor| sensor.get_mut("lookup")) else {
                continue;
            };
            let Some(file) = lookup.as_str() else { continue };
            let samples = samples(&base.join(file));
            let samples =
                samples.map_err(|error| error.at(format!("robots[{i}].sensors.{}.lookup", name.get())))?;
            let mut table = Value::from(samples);
            if let Some(name) = lookup.as_value() {
                *table.decor_mut() = name.decor().clone(); // a comment behind it
            }
            *lookup = table.into();
            has_any = true;
        }
    }
    Ok(has_any)
}

/// The file as the table that the scenario may have in its place.
fn samples(path: &Path) -> Result<InlineTable, FileError> {
    let text = file::bytes(path)?;
    let table = Samples::parse(&text).and_then(Samples::table);
    table.map_err(|problem| FileError::new(path, problem))
}

/// A reason why a file has no samples, in the words that follow its name.
#[derive(Debug, thiserror::Error)]
enum SamplesError {
    #[error("is empty: the first line names the columns, {DISTANCE},{ANGLE},{READING}")]
    Empty,
    #[error(
        "column `{column}` is none of {DISTANCE}, {ANGLE}, {READING}: rename it or take it out; there are {there}"
    )]
    UnknownColumn { column: String, there: String },
    #[error("column {column} appears more than once: {there}")]
    ColumnTwice { column: &'static str, there: String },
    #[error("column {column} is missing; there are {there}")]
    NoColumn { column: &'static str, there: String },
    #[error("line {line}: has {found} columns, the header has {expected}")]
    Length { line: usize, found: u64, expected: u64 },
    #[error("line {line}: is not text in UTF-8")]
    Encoding { line: usize },
    #[error("line {line}, column {column}: `{text}` is not a finite number")]
    Number { line: usize, column: &'static str, text: String },
    #[error(transparent)]
    Csv(csv::Error),
    #[error("has samples at {0} distances, needs 2 or more")]
    Distances(usize),
    #[error(
        "has no sample at distance_m = {distance_m}, angle_rad = {angle_rad}: every distance needs one at every angle"
    )]
    Gap { distance_m: f64, angle_rad: f64 },
}

struct Samples {
    has_angles: bool,
    rows: Vec<Sample>,
}

struct Sample {
    distance_m: f64,
    angle_rad: f64,
    reading: f64,
}

impl Samples {
    fn parse(text: &[u8]) -> Result<Self, SamplesError> {
        let mut reader = csv::ReaderBuilder::new().trim(Trim::All).from_reader(text);
        let columns = Columns::find(reader.headers().map_err(|error| problem(text, error))?)?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| problem(text, error))?;
            let number = |at, column| {
                let found = record.get(at).unwrap_or_default();
                let line = || line(text, record.position());
                number(found).ok_or_else(|| SamplesError::Number {
                    line: line(),
                    column,
                    text: found.to_owned(),
                })
            };
            rows.push(Sample {
                distance_m: number(columns.distance, DISTANCE)?,
                angle_rad: columns.angle.map_or(Ok(0.0), |angle| number(angle, ANGLE))?,
                reading: number(columns.reading, READING)?,
            });
        }
        Ok(Self { has_angles: columns.angle.is_some(), rows })
    }

    /// The samples by distance and angle, and what these are.
    fn table(mut self) -> Result<InlineTable, SamplesError> {
        let distances = self.sorted(|sample| sample.distance_m);
        let angles = self.sorted(|sample| sample.angle_rad);
        if distances.len() < 2 {
            return Err(SamplesError::Distances(distances.len()));
        }
        let samples = self.grid(&distances, &angles)?;
        let mut table = InlineTable::new();
        table.insert("distances_m", Array::from_iter(distances).into());
        if self.has_angles {
            table.insert("angles_rad", Array::from_iter(angles).into());
        }
        table.insert("samples", samples.into());
        Ok(table)
    }

    fn sorted(&self, number: impl Fn(&Sample) -> f64) -> Vec<f64> {
        let mut numbers: Vec<f64> = self.rows.iter().map(number).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        numbers
    }

    /// A list of readings for each distance and angle; none may be empty.
    fn grid(&mut self, distances: &[f64], angles: &[f64]) -> Result<Array, SamplesError> {
        // The sort is stable: readings of one place stay in the order of the file.
        self.rows
            .sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m).then(a.angle_rad.total_cmp(&b.angle_rad)));
        let mut rest = self.rows.as_slice();
        let mut grid = Array::new();
        for &distance_m in distances {
            let mut row = Array::new();
            for &angle_rad in angles {
                let is_here =
                    |sample: &&Sample| (sample.distance_m, sample.angle_rad) == (distance_m, angle_rad);
                let (here, others) = rest.split_at(rest.iter().take_while(is_here).count());
                if here.is_empty() {
                    return Err(SamplesError::Gap { distance_m, angle_rad });
                }
                rest = others;
                row.push(Array::from_iter(here.iter().map(|sample| sample.reading)));
            }
            grid.push(row);
        }
        Ok(grid)
    }
}

/// The places of the columns.
struct Columns {
    distance: usize,
    angle: Option<usize>,
    reading: usize,
}

impl Columns {
    fn find(header: &StringRecord) -> Result<Self, SamplesError> {
        let names: Vec<&str> = header.iter().collect();
        if names.is_empty() {
            return Err(SamplesError::Empty);
        }
        let there = names.join(", ");
        // One that is misspelt would otherwise be missed in silence.
        let known = [DISTANCE, ANGLE, READING];
        if let Some(other) = names.iter().find(|name| !known.contains(name)) {
            return Err(SamplesError::UnknownColumn { column: (*other).to_owned(), there });
        }
        if let Some(twice) = known.iter().find(|name| names.iter().filter(|other| other == name).count() > 1)
        {
            return Err(SamplesError::ColumnTwice { column: twice, there });
        }
        let find = |name: &str| names.iter().position(|other| *other == name);
        let required =
            |column| find(column).ok_or_else(|| SamplesError::NoColumn { column, there: there.clone() });
        Ok(Self { distance: required(DISTANCE)?, angle: find(ANGLE), reading: required(READING)? })
    }
}

/// A finite number, and no -0, which is the same place as 0.
fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|number| number.is_finite()).map(|number| number + 0.0)
}

#[expect(clippy::wildcard_enum_match_arm, reason = "the enum is not exhaustive")]
fn problem(text: &[u8], error: csv::Error) -> SamplesError {
    match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => {
            SamplesError::Length { line: line(text, pos.as_ref()), found: *len, expected: *expected_len }
        }
        ErrorKind::Utf8 { pos, .. } => SamplesError::Encoding { line: line(text, pos.as_ref()) },
        _ => SamplesError::Csv(error),
    }
}

/// A record's line, counted from 1. Its position is that of the empty lines before it.
fn line(text: &[u8], position: Option<&csv::Position>) -> usize {
    let start = position.map_or(0, |position| position.byte() as usize).min(text.len());
    let empty = text[start..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    1 + text[..start + empty].iter().filter(|&&byte| byte == b'\n').count()
}

const DISTANCE: &str = "distance_m";
const ANGLE: &str = "angle_rad";
const READING: &str = "reading";
