//! Reading a journal: which of its lines are sound, and what is wrong with the others.

use std::io::{self, BufRead};

use serde::Deserialize;

use super::Header;
use super::seal::Seal;
use crate::run_record::{Row, Written};

/// The contents of a journal.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// The sound rows in the order of their runs, each once.
    pub(super) rows: Vec<Entry>,
    /// A problem with a line, and its consequence.
    pub(super) damage: Vec<String>,
    /// Bytes of whole lines.
    pub(super) len: u64,
    /// Whether the last line has an end.
    pub(super) is_whole: bool,
    /// Whether all lines that have an end are sound.
    pub(super) is_sound: bool,
}

/// The line of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) run: u64,
    /// Where the line begins.
    pub(super) start: u64,
    /// Its number, from 1.
    line: u64,
    sum: u64,
}

/// The reason why a journal cannot be resumed.
#[derive(Debug)]
pub(super) enum Refusal {
    /// It is no journal, or one of which nothing is sound.
    Foreign,
    /// It is of a version that knew no checksums.
    Before,
    /// It is of other runs.
    OfAnother(Header),
    /// Another build of the program began it.
    OfAnotherBuild(Header),
    /// It could not be read.
    Unreadable(io::Error),
}

/// Looks through a journal that should have this header. What is damaged is left out and told.
pub(super) fn read(mut lines: impl BufRead, header: &Header) -> Result<Found, Refusal> {
    let seal = header.seal();
    let mut found = Found { is_whole: true, is_sound: true, ..Found::default() };
    let (mut line, mut has_header) = (Vec::new(), false);
    for number in 1.. {
        line.clear();
        lines.read_until(b'\n', &mut line).map_err(Refusal::Unreadable)?;
        found.is_whole = line.last().is_none_or(|last| *last == b'\n');
        if line.is_empty() {
            break;
        }
        if !found.is_whole {
            if number > 1 {
                found.damage.push(format!("line {number} is incomplete; {AGAIN}"));
            }
            break;
        }
        if number == 1 {
            has_header = is_header(&line, header)?;
        }
        if !has_header || number > 1 {
            found.take(&seal, &line, number, header.runs);
        }
        found.len += line.len() as u64;
    }
    let is_begun = found.len == 0 && header.line().is_ok_and(|own| own.starts_with(&line));
    if !(has_header || is_begun) && found.rows.is_empty() {
        return Err(Refusal::Foreign);
    }
    found.keep_each_once();
    Ok(found)
}

/// Whether the first line is the header, of this journal.
fn is_header(line: &[u8], header: &Header) -> Result<bool, Refusal> {
    let Some((object, _)) = Seal::default().open(line) else {
        return match serde_json::from_slice::<HeaderBefore>(line) {
            Ok(_) => Err(Refusal::Before),
            Err(_) => Ok(false),
        };
    };
    match serde_json::from_slice::<Header>(&object) {
        Ok(other) if other.fingerprint != header.fingerprint => Err(Refusal::OfAnother(other)),
        Ok(other) if other.build != header.build => Err(Refusal::OfAnotherBuild(other)),
        Ok(_) => Ok(true),
        Err(_) => Err(Refusal::Foreign),
    }
}

/// The row of a line, with its checksum; `None` if the line is damaged.
pub(super) fn row(seal: &Seal, line: &[u8]) -> Option<(Row, u64)> {
    let (object, sum) = seal.open(line)?;
    Some((serde_json::from_slice::<Written>(&object).ok()?.row()?, sum))
}

impl Found {
    /// Takes in a row, but for one that must be done again.
    fn take(&mut self, seal: &Seal, line: &[u8], number: u64, runs: u64) {
        let row = row(seal, line).filter(|(row, _)| row.run < runs);
        match &row {
            // Without a header the file cannot stay as it is.
            _ if number == 1 => self.damage.push("line 1 is damaged; it is rewritten".to_owned()),
            None => self.damage.push(format!("line {number} is damaged; {AGAIN}")),
            Some(_) => {}
        }
        self.is_sound &= row.is_some() && number > 1;
        if let Some((row, sum)) = row.filter(|(row, _)| !row.has_panicked()) {
            self.rows.push(Entry { run: row.run, start: self.len, line: number, sum });
        }
    }

    /// Duplicate lines count once; lines of a run that differ are both dropped, since either may be wrong.
    fn keep_each_once(&mut self) {
        self.rows.sort_unstable_by_key(|row| (row.run, row.start));
        let (mut kept, mut told) = (Vec::with_capacity(self.rows.len()), Vec::new());
        for of_a_run in self.rows.chunk_by(|a, b| a.run == b.run) {
            match of_a_run.iter().find(|row| row.sum != of_a_run[0].sum) {
                None => kept.push(of_a_run[0]),
                Some(other) => {
                    let (run, line) = (other.run, of_a_run[0].line);
                    told.push(format!("lines {line} and {} differ about run {run}; {AGAIN}", other.line));
                }
            }
        }
        self.is_sound &= told.is_empty();
        self.rows = kept;
        self.damage.append(&mut told);
    }
}

/// The first line as it was before there were checksums.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "only that they are there matters")]
struct HeaderBefore {
    sweep: String,
    fingerprint: String,
    #[serde(default)]
    build: String,
    runs: u64,
    figures: Vec<String>,
}

const AGAIN: &str = "its run is repeated";
