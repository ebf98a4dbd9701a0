//! The journal: a line a run, in the order in which they end, written at once. It is all that a sweep needs to resume.
//!
//! The first line identifies the experiment, and each line ends with a checksum (`seal`). `contents` finds which lines
//! are sound: the runs of all others are done again, after a sweep that was killed as after a disk that forgot a bit.
//! So are runs that failed: a later line of such a run replaces the earlier one. Lines reach the disk within a tenth of
//! a second or with the next one, so that a power cut takes a few of the last runs at most.

mod contents;
mod seal;
#[cfg(test)]
mod tests;

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use baudbot_server::Stored;
use serde::{Deserialize, Serialize};

pub(crate) use self::contents::{Contents, Entry, Purpose};
use self::seal::Seal;
use crate::error::Error;
use crate::figures::INFOS;
use crate::run_record::{Row, Written};
use crate::shard::Shard;

/// A journal that is open.
#[derive(Debug)]
pub(crate) struct Journal<F = File> {
    path: PathBuf,
    file: F,
    seal: Seal,
    /// Bytes that are whole lines.
    len: u64,
    /// Each run with where its line begins.
    rows: Vec<(u64, u64)>,
    /// Runs that failed and are to be done again, in their order.
    failed: Vec<Entry>,
    /// The number of runs that failed before.
    repeated: u64,
    /// The instant at which the disk last had all lines.
    synced: Option<Instant>,
    is_synced: bool,
}

/// The first line.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Name of the experiment.
    sweep: String,
    fingerprint: String,
    /// The description of the build of the program that did the runs.
    build: String,
    runs: u64,
    /// The shard of the runs that this journal is for, if it is not for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shard: Option<Shard>,
    figures: Vec<String>,
}

impl Header {
    pub(crate) fn new(name: &str, fingerprint: String, build: String, runs: u64) -> Self {
        let figures = INFOS.iter().map(|info| info.name.to_owned()).collect();
        Self { sweep: name.to_owned(), fingerprint, build, runs, shard: None, figures }
    }

    /// The header of a journal for some of the runs.
    pub(crate) fn of_shard(self, shard: Option<Shard>) -> Self {
        Self { shard, ..self }
    }

    /// The seal of the lines of rows below this header.
    fn seal(&self) -> Seal {
        Seal::new(format!("{} {}", self.fingerprint, self.build))
    }

    fn line(&self) -> io::Result<Vec<u8>> {
        Seal::default().line(self)
    }
}

impl Journal {
    /// Opens a journal to resume it, or begins one. Damaged lines are reported and removed.
    pub(crate) fn open(path: &Path, header: &Header, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let mut file = appending(path)?;
        let mut contents = Contents::none(path, header);
        // A device or a pipe has no lines to go on with, and may have no end.
        if path.metadata().is_ok_and(|metadata| metadata.is_file()) {
            contents = Contents::read(path, header, Purpose::Resume, tell)?;
        }
        let repeated = contents.failed.len() as u64;
        // If nothing is kept, the file is to be as old as the first run that is.
        let is_done_anew = contents.rows.is_empty() && repeated > 0;
        if is_done_anew {
            contents.failed.clear();
        }
        if !contents.is_sound || is_done_anew {
            contents.mend(header)?;
            file = appending(path)?;
        } else if !contents.is_whole {
            file.cut(contents.len).map_err(Error::file("mend", path))?;
        }
        let rows = contents.rows.iter().map(|row| (row.run, row.start)).collect();
        let (len, failed) = (contents.len, contents.failed);
        let mut journal = Self { len, rows, failed, repeated, ..Self::new(path, file, header.seal()) };
        if journal.len == 0 {
            journal.put(header.line())?;
        }
        Ok(journal)
    }

    /// Puts the file elsewhere, in the place of what is there.
    pub(crate) fn move_to(&mut self, path: &Path) -> Result<(), Error> {
        fs::rename(&self.path, path).map_err(Error::file("write", path))?;
        path.clone_into(&mut self.path);
        Ok(())
    }

    /// Runs that failed are not done again after all.
    pub(crate) fn keep_failed(&mut self) {
        self.rows.extend(self.failed.drain(..).map(|row| (row.run, row.start)));
        self.repeated = 0;
    }

    /// The instant at which the first of its lines was written, as far as the file system knows.
    pub(crate) fn begun(&self) -> Option<SystemTime> {
        let metadata = fs::metadata(&self.path).ok()?;
        // A copy is younger than its lines.
        [metadata.created(), metadata.modified()].into_iter().filter_map(Result::ok).min()
    }

    /// The path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// All rows in the order of their runs.
    pub(crate) fn rows(&self) -> Result<impl Iterator<Item = Result<Row, Error>> + use<>, Error> {
        let mut rows = self.rows.clone();
        rows.sort_unstable();
        contents::rows_at(&self.path, self.seal.clone(), rows.into_iter().map(|(_, start)| start).collect())
    }
}

impl<F: Stored> Journal<F> {
    fn new(path: &Path, file: F, seal: Seal) -> Self {
        Self {
            path: path.to_owned(),
            file,
            seal,
            len: 0,
            rows: Vec::new(),
            failed: Vec::new(),
            repeated: 0,
            synced: None,
            is_synced: true,
        }
    }

    /// The number of runs that failed before, and are done again.
    pub(crate) fn repeated(&self) -> u64 {
        self.repeated
    }

    /// The number of runs in it.
    pub(crate) fn done(&self) -> u64 {
        self.rows.len() as u64
    }

    /// The runs that are in it, sorted.
    pub(crate) fn runs(&self) -> Vec<u64> {
        let mut runs: Vec<_> = self.rows.iter().map(|row| row.0).collect();
        runs.sort_unstable();
        runs
    }

    /// Adds a row.
    pub(crate) fn append(&mut self, row: &Row) -> Result<(), Error> {
        let line = self.seal.line(&Written::from(row));
        if let Some(start) = line.as_ref().ok().and_then(|line| self.same_failure(row.run, line)) {
            self.rows.push((row.run, start));
            return Ok(());
        }
        let at = self.len;
        self.put(line)?;
        self.rows.push((row.run, at));
        Ok(())
    }

    /// The place of the run's line with the same failure: a run that fails again and again needs no other.
    fn same_failure(&self, run: u64, line: &[u8]) -> Option<u64> {
        let place = self.failed.binary_search_by_key(&run, |row| row.run).ok()?;
        let (before, (_, sum)) = (&self.failed[place], self.seal.open(line)?);
        (before.sum == sum).then_some(before.start)
    }

    /// Writes a line with one call, so that it is whole or the last. Nothing is left of one that failed.
    fn put(&mut self, line: io::Result<Vec<u8>>) -> Result<(), Error> {
        let written = line.and_then(|line| self.file.append_whole(&mut self.len, &line));
        written.map_err(Error::file("write", &self.path))?;
        self.is_synced = false;
        if self.synced.is_none_or(|at| at.elapsed() >= SYNC_INTERVAL) {
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until all lines are on the disk.
    pub(crate) fn sync(&mut self) -> Result<(), Error> {
        if !self.is_synced {
            match self.file.sync() {
                // A device or a pipe keeps nothing.
                Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {}
                synced => synced.map_err(Error::file("write", &self.path))?,
            }
            (self.synced, self.is_synced) = (Some(Instant::now()), true);
        }
        Ok(())
    }
}

fn appending(path: &Path) -> Result<File, Error> {
    OpenOptions::new().append(true).create(true).open(path).map_err(Error::file("write", path))
}

/// Waiting for the disk after each row would keep short runs waiting.
const SYNC_INTERVAL: Duration = Duration::from_millis(100);
