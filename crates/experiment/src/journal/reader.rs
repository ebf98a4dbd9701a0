//! Reading a journal: which of its lines are sound, and what is wrong with the others.

use std::cmp::Reverse;
use std::io::{self, BufRead};

use serde::Deserialize;

use super::Header;
use super::seal::Seal;
use crate::run_record::{Row, Written};
use crate::shard::Shard;

/// The contents of a journal.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// The sound rows of runs that were done, in the order of the runs, each once.
    pub(super) rows: Vec<Entry>,
    /// The last row of each run that failed, in the order of the runs. They are done again if there is a chance.
    pub(super) failed: Vec<Entry>,
    /// The first line, if it is sound.
    pub(super) header: Option<Header>,
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
pub(crate) struct Entry {
    pub(crate) run: u64,
    /// Where the line begins.
    pub(crate) start: u64,
    /// Its number, from 1.
    pub(crate) line: u64,
    /// Its checksum: equal lines of equal experiments have equal ones.
    pub(crate) sum: u64,
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
    /// It is for other runs of this experiment.
    OfAnotherShard(Option<Shard>),
    /// It could not be read.
    Unreadable(io::Error),
}

/// What becomes of damage: of a row's line, and of the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Consequence {
    pub(super) of_row: &'static str,
    pub(super) of_header: &'static str,
}

/// Looks through a journal that is to be resumed, and should have this header. What is damaged is left out and told.
pub(super) fn read(lines: impl BufRead, header: &Header) -> Result<Found, Refusal> {
    read_with(lines, header, RESUMED)
}

/// The same, of a journal with which something else is done.
pub(super) fn read_with(
    mut lines: impl BufRead,
    header: &Header,
    consequence: Consequence,
) -> Result<Found, Refusal> {
    let seal = header.seal();
    let mut found = Found { is_whole: true, is_sound: true, ..Found::default() };
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        lines.read_until(b'\n', &mut line).map_err(Refusal::Unreadable)?;
        found.is_whole = line.last().is_none_or(|last| *last == b'\n');
        if line.is_empty() {
            break;
        }
        if !found.is_whole {
            if number > 1 {
                found.damage.push(format!("line {number} is incomplete; {}", consequence.of_row));
            }
            break;
        }
        if number == 1 {
            found.header = own_header(&line, header)?;
        }
        if found.header.is_none() || number > 1 {
            found.take(&seal, &line, number, header.runs, consequence);
        }
        found.len += line.len() as u64;
    }
    let is_begun = found.len == 0 && header.line().is_ok_and(|own| own.starts_with(&line));
    if !(found.header.is_some() || is_begun) && found.rows.is_empty() && found.failed.is_empty() {
        return Err(Refusal::Foreign);
    }
    found.keep_each_once(consequence);
    Ok(found)
}

/// The first line if it is a header, of this experiment.
fn own_header(line: &[u8], header: &Header) -> Result<Option<Header>, Refusal> {
    let Some((object, _)) = Seal::default().open(line) else {
        return match serde_json::from_slice::<HeaderBefore>(line) {
            Ok(_) => Err(Refusal::Before),
            Err(_) => Ok(None),
        };
    };
    match serde_json::from_slice::<Header>(&object) {
        Ok(other) if other.fingerprint != header.fingerprint => Err(Refusal::OfAnother(other)),
        Ok(other) if other.build != header.build => Err(Refusal::OfAnotherBuild(other)),
        Ok(own) => Ok(Some(own)),
        Err(_) => Err(Refusal::Foreign),
    }
}

/// The row of a line, with its checksum; `None` if the line is damaged.
pub(super) fn row(seal: &Seal, line: &[u8]) -> Option<(Row, u64)> {
    let (object, sum) = seal.open(line)?;
    Some((serde_json::from_slice::<Written>(&object).ok()?.row()?, sum))
}

impl Found {
    /// Refuses a journal for other runs. One whose header is damaged is for those that it has.
    pub(super) fn of_shard(self, shard: Option<Shard>) -> Result<Self, Refusal> {
        let of_row = |row: &Entry| shard.map(|shard| Shard::of(row.run, shard.count()));
        let other = match &self.header {
            Some(own) => Some(own.shard).filter(|own| *own != shard),
            None => self.rows.iter().chain(&self.failed).map(of_row).find(|of_row| *of_row != shard),
        };
        other.map_or(Ok(self), |other| Err(Refusal::OfAnotherShard(other)))
    }

    /// Takes in a row, but for one that must be done again.
    fn take(&mut self, seal: &Seal, line: &[u8], number: u64, runs: u64, consequence: Consequence) {
        let row = row(seal, line).filter(|(row, _)| row.run < runs);
        match &row {
            // Without a header the file cannot stay as it is.
            _ if number == 1 => self.damage.push(format!("line 1 is damaged; {}", consequence.of_header)),
            None => self.damage.push(format!("line {number} is damaged; {}", consequence.of_row)),
            Some(_) => {}
        }
        self.is_sound &= row.is_some() && number > 1;
        if let Some((row, sum)) = row {
            let rows = if row.has_failed() { &mut self.failed } else { &mut self.rows };
            rows.push(Entry { run: row.run, start: self.len, line: number, sum });
        }
    }

    /// Duplicate lines count once; lines of a run that differ are both dropped, since either may be wrong. A later line replaces that
    /// of a run that failed.
    fn keep_each_once(&mut self, consequence: Consequence) {
        self.rows.sort_unstable_by_key(|row| (row.run, row.start));
        let (mut kept, mut told) = (Vec::with_capacity(self.rows.len()), Vec::new());
        for of_a_run in self.rows.chunk_by(|a, b| a.run == b.run) {
            match of_a_run.iter().find(|row| row.sum != of_a_run[0].sum) {
                None => kept.push(of_a_run[0]),
                Some(other) => {
                    let (run, line) = (other.run, of_a_run[0].line);
                    let then = consequence.of_row;
                    told.push(format!("lines {line} and {} disagree about run {run}; {then}", other.line));
                }
            }
        }
        self.is_sound &= told.is_empty();
        self.rows = kept;
        self.failed.sort_unstable_by_key(|row| (row.run, Reverse(row.start)));
        self.failed.dedup_by_key(|row| row.run);
        self.failed.retain(|row| self.rows.binary_search_by_key(&row.run, |done| done.run).is_err());
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

const RESUMED: Consequence = Consequence { of_row: "its run is repeated", of_header: "it is rewritten" };
