//! The contents of a journal: which of its lines are sound, and what is wrong with the others.

use std::cmp::Reverse;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use super::Header;
use super::seal::Seal;
use crate::error::Error;
use crate::outputs;
use crate::run_record::Row;
use crate::shard::Shard;

/// The contents of a journal. One of many that are merged may be on a disk that cannot be written, or still grow.
#[derive(Debug)]
pub(crate) struct Contents {
    pub(crate) path: PathBuf,
    /// The sound rows of runs that were done, in the order of the runs, each once.
    pub(crate) rows: Vec<Entry>,
    /// The last row of each run that failed, in the order of the runs. They are done again if there is a chance.
    pub(crate) failed: Vec<Entry>,
    seal: Seal,
    /// The first line, if it is sound.
    header: Option<Header>,
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
    /// The place in the file at which the line begins.
    pub(crate) start: u64,
    /// The number of the line, from 1.
    pub(crate) line: u64,
    /// The entry's checksum: equal lines of equal experiments have equal ones.
    pub(crate) sum: u64,
}

/// The reason why a journal is read, which decides what becomes of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// The journal's runs are continued, in the same file.
    Resume,
    /// The journal's rows are put with those of others.
    Merge,
}

/// The reason why a journal has no part in an experiment.
#[derive(Debug, thiserror::Error)]
pub(super) enum Refusal {
    /// The file could not be read.
    #[error(transparent)]
    Unreadable(#[from] io::Error),
    /// The file is no journal, or one in which nothing is sound.
    #[error("is not the journal of an experiment, or is damaged throughout")]
    Foreign,
    /// The journal is of other runs.
    #[error(
        "belongs to another experiment, scenario or version, or to other seeds (`{name}`, {found}… instead of {own}…)"
    )]
    OfAnother { name: String, found: String, own: String },
    /// Another build of the program began it.
    #[error(
        "was begun by another build of baudbot, whose runs differ from this one's (`{found}` instead of `{own}`)"
    )]
    OfAnotherBuild { found: String, own: String },
    /// The journal is for other runs of this experiment.
    #[error("is for {}, not for {}", runs_of(*found), runs_of(*own))]
    OfAnotherShard { found: Option<Shard>, own: Option<Shard> },
}

fn runs_of(shard: Option<Shard>) -> String {
    shard.map_or_else(|| "all runs".to_owned(), |shard| format!("shard {shard}"))
}

impl Refusal {
    fn error(self, path: &Path, purpose: Purpose) -> Error {
        let remedy = match (purpose, &self) {
            (Purpose::Resume, Self::OfAnotherBuild { .. }) => &format!("continue with that build, {ANEW}"),
            (
                Purpose::Resume,
                Self::Unreadable(_) | Self::Foreign | Self::OfAnother { .. } | Self::OfAnotherShard { .. },
            ) => ANEW,
            (Purpose::Merge, Self::OfAnother { .. }) => {
                "leave it out, or merge with the file, the --seeds and the program of the shards"
            }
            (Purpose::Merge, Self::OfAnotherBuild { .. }) => {
                "merge with that build, or do all shards with one"
            }
            (Purpose::Merge, Self::Unreadable(_) | Self::Foreign | Self::OfAnotherShard { .. }) => {
                "leave it out"
            }
        };
        if let Self::Unreadable(cause) = self {
            return Error::file("read", path)(cause);
        }
        Error::Refused(format!("{} {self}; {remedy}", path.display()))
    }
}

impl Purpose {
    /// The consequence for the run of a damaged line.
    fn of_row(self) -> &'static str {
        match self {
            Self::Resume => "its run is repeated",
            Self::Merge => "its run does not count",
        }
    }

    /// The consequence of a damaged first line.
    fn of_header(self) -> &'static str {
        match self {
            Self::Resume => "it is rewritten",
            Self::Merge => "which shard's it is, is unknown",
        }
    }
}

impl Contents {
    /// The contents of a journal without entries.
    pub(super) fn none(path: &Path, header: &Header) -> Self {
        Self {
            path: path.to_owned(),
            rows: Vec::new(),
            failed: Vec::new(),
            seal: header.seal(),
            header: None,
            damage: Vec::new(),
            len: 0,
            is_whole: true,
            is_sound: true,
        }
    }

    /// Looks through a journal of the experiment of this header. Damage is reported.
    pub(crate) fn read(
        path: &Path,
        header: &Header,
        purpose: Purpose,
        tell: &dyn Fn(&str),
    ) -> Result<Self, Error> {
        let lines = BufReader::new(File::open(path).map_err(Error::file("read", path))?);
        let mut contents = Self::none(path, header);
        contents.take_all(lines, header, purpose).map_err(|refusal| refusal.error(path, purpose))?;
        contents.damage.iter().for_each(|damage| tell(&format!("{}: {damage}", path.display())));
        Ok(contents)
    }

    /// The shard whose runs it is for, if not for all, or unknown.
    pub(crate) fn shard(&self) -> Option<Shard> {
        self.header.as_ref().and_then(|header| header.shard)
    }

    /// The rows whose lines begin there.
    pub(crate) fn rows_at(
        &self,
        starts: Vec<u64>,
    ) -> Result<impl Iterator<Item = Result<Row, Error>> + use<>, Error> {
        rows_at(&self.path, self.seal.clone(), starts)
    }

    /// Takes in the lines of a journal that should have this header. What is damaged is left out.
    pub(super) fn take_all(
        &mut self,
        mut lines: impl BufRead,
        header: &Header,
        purpose: Purpose,
    ) -> Result<(), Refusal> {
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            lines.read_until(b'\n', &mut line)?;
            self.is_whole = line.last().is_none_or(|last| *last == b'\n');
            if line.is_empty() {
                break;
            }
            if !self.is_whole {
                if number > 1 {
                    self.damage.push(format!("line {number} is incomplete; {}", purpose.of_row()));
                }
                break;
            }
            if number == 1 {
                self.header = own_header(&line, header)?;
            }
            if self.header.is_none() || number > 1 {
                self.take(&line, number, header.runs, purpose);
            }
            self.len += line.len() as u64;
        }
        let is_begun = self.len == 0 && header.line().is_ok_and(|own| own.starts_with(&line));
        if !(self.header.is_some() || is_begun) && self.rows.is_empty() && self.failed.is_empty() {
            return Err(Refusal::Foreign);
        }
        self.keep_each_once(purpose);
        match purpose {
            Purpose::Resume => self.check_shard(header.shard),
            Purpose::Merge => Ok(()),
        }
    }

    /// Refuses a journal for other runs. One whose header is damaged is for those that it has.
    fn check_shard(&self, own: Option<Shard>) -> Result<(), Refusal> {
        let of_row = |row: &Entry| own.map(|shard| Shard::of(row.run, shard.count()));
        let found = match &self.header {
            Some(header) => Some(header.shard).filter(|found| *found != own),
            None => self.rows.iter().chain(&self.failed).map(of_row).find(|found| *found != own),
        };
        found.map_or(Ok(()), |found| Err(Refusal::OfAnotherShard { found, own }))
    }

    /// Takes in a row, but for one that must be done again.
    fn take(&mut self, line: &[u8], number: u64, runs: u64, purpose: Purpose) {
        let row = self.seal.row(line).filter(|(row, _)| row.run < runs);
        match &row {
            // The file cannot stay as it is without a header.
            _ if number == 1 => self.damage.push(format!("line 1 is damaged; {}", purpose.of_header())),
            None => self.damage.push(format!("line {number} is damaged; {}", purpose.of_row())),
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
    fn keep_each_once(&mut self, purpose: Purpose) {
        self.rows.sort_unstable_by_key(|row| (row.run, row.start));
        let (mut rows, then) = (Vec::with_capacity(self.rows.len()), purpose.of_row());
        for of_a_run in self.rows.chunk_by(|a, b| a.run == b.run) {
            let first = of_a_run[0];
            let Some(other) = of_a_run.iter().find(|row| row.sum != first.sum) else {
                rows.push(first);
                continue;
            };
            self.is_sound = false;
            let (run, lines) = (first.run, (first.line, other.line));
            self.damage.push(format!("lines {} and {} disagree about run {run}; {then}", lines.0, lines.1));
        }
        self.rows = rows;
        self.failed.sort_unstable_by_key(|row| (row.run, Reverse(row.start)));
        self.failed.dedup_by_key(|row| row.run);
        self.failed.retain(|row| self.rows.binary_search_by_key(&row.run, |done| done.run).is_err());
    }

    /// Writes what is sound in it, and nothing else, to a file that takes its place once it is whole.
    pub(super) fn mend(&mut self, header: &Header) -> Result<(), Error> {
        let Self { path, rows, failed, len, .. } = self;
        let mut lines = Lines::of(path)?;
        outputs::write_whole(path, &path.with_extension("mended"), |out| {
            let line = header.line()?;
            out.write_all(&line)?;
            *len = line.len() as u64;
            for entry in rows.iter_mut().chain(failed) {
                let line = lines.at(entry.start)?;
                out.write_all(line)?;
                entry.start = *len;
                *len += line.len() as u64;
            }
            Ok(())
        })?;
        (self.is_whole, self.is_sound) = (true, true);
        Ok(())
    }
}

/// The first line if it is a header, of this experiment.
fn own_header(line: &[u8], own: &Header) -> Result<Option<Header>, Refusal> {
    let Some((object, _)) = Seal::default().open(line) else { return Ok(None) };
    let found: Header = serde_json::from_slice(&object).map_err(|_| Refusal::Foreign)?;
    if found.fingerprint != own.fingerprint {
        let short = |header: &Header| header.fingerprint.get(..8).unwrap_or_default().to_owned();
        let (found, own, name) = (short(&found), short(own), found.sweep);
        return Err(Refusal::OfAnother { name, found, own });
    }
    if found.build != own.build {
        return Err(Refusal::OfAnotherBuild { found: found.build, own: own.build.clone() });
    }
    Ok(Some(found))
}

/// The lines of a journal, by where they begin.
struct Lines {
    path: PathBuf,
    file: BufReader<File>,
    place: u64,
    line: Vec<u8>,
}

impl Lines {
    fn of(path: &Path) -> Result<Self, Error> {
        let file = BufReader::new(File::open(path).map_err(Error::file("read", path))?);
        Ok(Self { path: path.to_owned(), file, place: 0, line: Vec::new() })
    }

    fn at(&mut self, start: u64) -> Result<&[u8], Error> {
        self.line.clear();
        // Most lines stand near the one before: that needs no other look at the disk.
        let found = self.file.seek_relative(start as i64 - self.place as i64);
        let read = found.and_then(|()| self.file.read_until(b'\n', &mut self.line));
        self.place = start + read.map_err(Error::file("read", &self.path))? as u64;
        Ok(&self.line)
    }
}

/// The rows whose lines begin there, in this order.
pub(super) fn rows_at(
    path: &Path,
    seal: Seal,
    starts: Vec<u64>,
) -> Result<impl Iterator<Item = Result<Row, Error>> + use<>, Error> {
    let mut lines = Lines::of(path)?;
    Ok(starts.into_iter().map(move |start| {
        let row = seal.row(lines.at(start)?);
        row.map(|(row, _)| row).ok_or_else(|| {
            let path = lines.path.display();
            Error::Refused(format!(
                "{path}: a line was damaged while the experiment ran; repeat the command to repeat its run"
            ))
        })
    }))
}

/// The remedy for a file that is in the way.
const ANEW: &str =
    "choose another place with --out DIR, or start over with --fresh, which deletes what is there";
