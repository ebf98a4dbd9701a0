//! The way from text to a [`Log`].

use std::io::BufRead;

use super::cells::{next_line, number, separator, split, text};
use super::error::{LogError, Problem, Warning};
use super::names::{Name, Quantity, meaning};
use super::{Column, Labels, Log, Note, times};

/// The options for reading a log.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The robot's name; needed if the log has rows of several.
    pub robot: Option<String>,
    /// Names for columns that have others in the file: ours, and that of the file.
    pub renamed: Vec<(String, String)>,
    /// Columns of sensors that are to be kept, by their names in the table of a run.
    pub readings: Vec<String>,
}

/// Most numbers that are kept: 256 MiB of them.
const MOST_NUMBERS: usize = 1 << 25;

/// The number of bytes after which progress is reported.
const TOLD_BYTES: u64 = 1 << 20;

/// Reads a log; `file` is its name in messages. `progress` gets the number of bytes that have been read.
///
/// # Errors
/// Names line and column of the first cell that cannot be used.
pub fn read(
    file: &str,
    mut input: impl BufRead,
    options: &Options,
    progress: &mut dyn FnMut(u64),
) -> Result<Log, LogError> {
    let mut reader = Reader { file, line: 0, notes: Vec::new(), header: None };
    let (mut line, mut cells, mut done, mut told) = (Vec::new(), Vec::new(), 0, 0);
    loop {
        reader.line += 1;
        let Some(read) = next_line(&mut input, &mut line).map_err(|problem| reader.here(problem))? else {
            break;
        };
        done += read;
        if done - told >= TOLD_BYTES {
            told = done;
            progress(done);
        }
        let bytes =
            if reader.line == 1 { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&line) } else { &line };
        let text = text(bytes).map_err(|problem| reader.here(problem))?;
        reader.take(text, &mut cells, options)?;
    }
    progress(done);
    reader.finish(options)
}

struct Reader<'a> {
    file: &'a str,
    line: u64,
    notes: Vec<Note>,
    header: Option<Header>,
}

/// The line of names, and what came below it.
struct Header {
    separator: char,
    names: Vec<String>,
    columns: Vec<Column>,
    robot: Option<usize>,
    label: Option<usize>,
    robots: Vec<String>,
    labels: Labels,
    ignored: Vec<String>,
    lines: Vec<u64>,
}

impl Reader<'_> {
    fn here(&self, problem: Problem) -> LogError {
        LogError { file: self.file.to_owned(), line: Some(self.line), column: None, problem: problem.into() }
    }

    fn at(&self, place: usize, name: &str, problem: Problem) -> LogError {
        LogError { column: Some((place, name.to_owned())), ..self.here(problem) }
    }

    fn take(&mut self, text: &str, cells: &mut Vec<String>, options: &Options) -> Result<(), LogError> {
        if let Some(comment) = text.strip_prefix('#') {
            if let Some((key, value)) = comment.split_once(':') {
                let (key, value) = (key.trim().to_ascii_lowercase(), value.trim().to_owned());
                self.notes.push(Note { line: self.line, key, value });
            }
            return Ok(());
        }
        if text.trim().is_empty() {
            return Ok(());
        }
        match self.header.take() {
            None => self.header = Some(self.header(text, cells, options)?),
            Some(mut header) => {
                self.row(&mut header, text, cells, options)?;
                self.header = Some(header);
            }
        }
        Ok(())
    }

    fn header(&self, text: &str, cells: &mut Vec<String>, options: &Options) -> Result<Header, LogError> {
        let separator = separator(text);
        split(text, separator, cells).map_err(|problem| self.here(problem))?;
        if is_carmen(text) {
            return Err(self.here(Problem::Carmen));
        }
        let is_number = |cell: &str| cell.replace(',', ".").parse::<f64>().is_ok();
        let has_numbers = cells.iter().any(|cell| is_number(cell));
        if text.split_whitespace().all(is_number) || cells.iter().all(|cell| is_number(cell)) {
            return Err(self.here(Problem::NoNames));
        }
        let mut header = Header {
            separator,
            names: cells.clone(),
            columns: Vec::new(),
            robot: None,
            label: None,
            robots: Vec::new(),
            labels: Labels::default(),
            ignored: Vec::new(),
            lines: Vec::new(),
        };
        let unknown = options.renamed.iter().find(|(_, from)| !cells.contains(from));
        if let Some((_, from)) = unknown {
            return Err(self.here(Problem::NoColumn { name: from.clone(), names: cells.join(", ") }));
        }
        for (i, cell) in cells.iter().enumerate() {
            self.name(&mut header, i, cell, options).map_err(|problem| self.at(i + 1, cell, problem))?;
        }
        if header.columns.is_empty() {
            // A first row with a word in it, which would be lost, and its numbers listed as names.
            let problem =
                if has_numbers { Problem::NoNames } else { Problem::NothingKnown { names: first(cells) } };
            return Err(self.here(problem));
        }
        Ok(header)
    }

    fn name(&self, header: &mut Header, i: usize, cell: &str, options: &Options) -> Result<(), Problem> {
        if cell.is_empty() {
            return Err(Problem::NoName);
        }
        let renamed = options.renamed.iter().find(|(_, from)| from == cell);
        let name = renamed.map_or(cell, |(ours, _)| ours);
        match name {
            "robot" => header.robot = Some(i),
            // Unless the robot's own sensor is called so, as that of a preset.
            "sensor" | "specimen" if !options.readings.iter().any(|reading| reading == name) => {
                header.label = Some(i);
            }
            _ => match meaning(name, &options.readings)? {
                Some(name) => {
                    if let Some(first) = header.columns.iter().find(|column| same(&column.name, &name)) {
                        return Err(Problem::Twice { first: first.place });
                    }
                    let header_name = cell.to_owned();
                    header.columns.push(Column {
                        name,
                        header: header_name,
                        place: i + 1,
                        values: Vec::new(),
                    });
                }
                None if renamed.is_some() => return Err(unknown_target(name, options)),
                None => header.ignored.push(cell.to_owned()),
            },
        }
        Ok(())
    }

    fn row(
        &self,
        header: &mut Header,
        text: &str,
        cells: &mut Vec<String>,
        options: &Options,
    ) -> Result<(), LogError> {
        split(text, header.separator, cells).map_err(|problem| self.here(problem))?;
        let columns = header.names.len();
        if cells.len() != columns {
            return Err(self.here(Problem::Cells { cells: cells.len(), columns }));
        }
        if let Some(robot) = header.robot {
            let robot = &cells[robot];
            if !header.robots.contains(robot) && header.robots.len() < MOST_WORDS {
                header.robots.push(robot.clone());
            }
            if options.robot.as_ref().is_some_and(|wanted| wanted != robot) {
                return Ok(());
            }
        }
        for column in &mut header.columns {
            let cell = &cells[column.place - 1];
            let number = number(cell).map_err(|problem| self.at(column.place, &column.header, problem))?;
            column.values.push(match &column.name {
                Name::Of(_, unit) => number * unit.si,
                Name::Reading(_) => number,
            });
        }
        if let Some(label) = header.label {
            let word = header.labels.place(&cells[label]);
            header.labels.of_rows.push(word);
        }
        header.lines.push(self.line);
        if header.lines.len() * (header.columns.len() + 1) > MOST_NUMBERS {
            return Err(self.here(Problem::TooMany { most: MOST_NUMBERS }));
        }
        Ok(())
    }

    fn finish(self, options: &Options) -> Result<Log, LogError> {
        let whole = |problem: Problem| LogError {
            file: self.file.to_owned(),
            line: None,
            column: None,
            problem: problem.into(),
        };
        let Some(header) = self.header else { return Err(whole(Problem::Empty)) };
        let names = || header.robots.join(", ");
        match &options.robot {
            Some(name) if header.robot.is_some() && header.lines.is_empty() && !header.robots.is_empty() => {
                return Err(whole(Problem::NoRobot { name: name.clone(), names: names() }));
            }
            None if header.robots.len() > 1 => return Err(whole(Problem::Robots { names: names() })),
            Some(_) | None => {}
        }
        if header.lines.is_empty() {
            return Err(whole(Problem::NoRows));
        }
        let warnings = warnings(&header);
        let log = Log {
            file: self.file.to_owned(),
            notes: self.notes,
            columns: header.columns,
            labels: header.label.map(|_| header.labels),
            lines: header.lines,
            segments: Vec::new(),
            warnings,
        };
        // The columns that models read are sound.
        for key in NUMBERS {
            log.note(key)?;
        }
        times::settle(log)
    }
}

/// The first names of a line.
fn first(names: &[String]) -> String {
    let mut first = names[..names.len().min(MOST_NAMES)].join(", ");
    if names.len() > MOST_NAMES {
        first += &format!(" and {} more", names.len() - MOST_NAMES);
    }
    first.chars().take(MOST_LETTERS).collect()
}

/// Whether a line is one of CARMEN's, which the robotics data sets of its time are in.
fn is_carmen(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let first = words.next().is_some_and(|word| CARMEN.contains(&word));
    first && words.next().is_some()
}

/// The first words of the lines of CARMEN.
const CARMEN: [&str; 14] = [
    "ODOM",
    "FLASER",
    "RLASER",
    "LASER3",
    "LASER4",
    "ROBOTLASER1",
    "ROBOTLASER2",
    "RAWLASER1",
    "RAWLASER2",
    "PARAM",
    "SYNC",
    "TRUEPOS",
    "NMEAGGA",
    "NMEARMC",
];

/// Names that a message quotes, and their letters.
const MOST_NAMES: usize = 6;
const MOST_LETTERS: usize = 200;

/// Notes that are numbers.
const NUMBERS: [&str; 4] = ["baud", "bytes", "full_scale", "turnaround_us"];

/// Most robots and specimens that are distinguished.
const MOST_WORDS: usize = 10_000;

impl Labels {
    fn place(&mut self, word: &str) -> usize {
        let last = self.of_rows.last().copied().filter(|last| self.words[*last] == word);
        last.or_else(|| self.words.iter().position(|known| known == word)).unwrap_or_else(|| {
            if self.words.len() < MOST_WORDS {
                self.words.push(word.to_owned());
            }
            self.words.len() - 1
        })
    }
}

/// Whether two columns mean the same, perhaps in two units.
fn same(a: &Name, b: &Name) -> bool {
    match (a, b) {
        (Name::Of(a, _), Name::Of(b, _)) => a == b,
        (Name::Reading(a), Name::Reading(b)) => a == b,
        (Name::Of(..), Name::Reading(_)) | (Name::Reading(_), Name::Of(..)) => false,
    }
}

fn warnings(header: &Header) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if !header.ignored.is_empty() {
        warnings.push(Warning::Ignored { columns: header.ignored.clone() });
    }
    let is_heading =
        |column: &&Column| matches!(column.name, Name::Of(Quantity::Heading, unit) if unit.si == 1.0);
    if let Some(column) = header.columns.iter().find(is_heading) {
        let row = column.values.iter().position(|heading| heading.abs() > std::f64::consts::TAU);
        warnings
            .extend(row.map(|row| Warning::Degrees { line: header.lines[row], heading: column.values[row] }));
    }
    for column in &header.columns {
        let missing = |values: &[f64]| values.iter().filter(|value| value.is_nan()).count();
        let first = column.values.iter().position(|value| value.is_nan());
        if let Some(first) = first.filter(|_| column.name_is_needed()) {
            let (cells, line) = (missing(&column.values), header.lines[first]);
            warnings.push(Warning::Missing { column: column.header.clone(), cells, line });
        }
    }
    warnings
}

impl Column {
    /// Whether an empty cell is odd: sensors have no readings at first.
    fn name_is_needed(&self) -> bool {
        matches!(self.name, Name::Of(..))
    }
}

fn unknown_target(name: &str, options: &Options) -> Problem {
    let with_units = |quantity: &Quantity| {
        let stem = quantity.stems()[0];
        let units = quantity.dimension().units().iter();
        let names = units.map(|unit| format!("{stem}_{}", unit.suffix).trim_end_matches('_').to_owned());
        names.collect::<Vec<_>>()
    };
    let mut known: Vec<_> = Quantity::ALL.iter().flat_map(with_units).collect();
    known.extend(["robot", "sensor", "specimen"].map(str::to_owned));
    known.extend(options.readings.iter().cloned());
    Problem::Target { name: name.to_owned(), known: format!("known are: {}", known.join(", ")) }
}
