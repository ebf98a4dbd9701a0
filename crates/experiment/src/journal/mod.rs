//! The journal: a line a run, in the order in which they end, written at once. It is all that a sweep needs to resume.
//!
//! The first line says which experiment it is of, and each line ends with a checksum (`seal`). `reader` finds which lines are
//! sound: the runs of all others are done again, after a sweep that was killed as after a disk that forgot a bit. So are runs that
//! failed: a later line of such a run replaces the earlier one. Lines reach
//! the disk within a tenth of a second or with the next one, so that a power cut takes a few of the last runs at most.

mod reader;
mod scan;
mod seal;
#[cfg(test)]
mod tests;

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use serde::{Deserialize, Serialize};

pub(crate) use self::reader::Entry;
use self::reader::{Found, Refusal};
pub(crate) use self::scan::Scan;
use self::seal::Seal;
use crate::error::Error;
use crate::figures::INFOS;
use crate::run_record::{Row, Written};
use crate::shard::Shard;

/// A journal that is open.
#[derive(Debug)]
pub(crate) struct Journal<M = File> {
    path: PathBuf,
    medium: M,
    seal: Seal,
    /// Bytes that are whole lines.
    len: u64,
    /// Each run with where its line begins.
    rows: Vec<(u64, u64)>,
    /// Runs that failed and are to be done again, in their order.
    failed: Vec<Entry>,
    /// How many runs failed before.
    repeated: u64,
    /// When the disk last had all lines.
    synced: Option<Instant>,
    is_synced: bool,
}

/// The output of a journal.
pub(crate) trait Medium: Write {
    /// Drops what is beyond so many bytes.
    fn cut(&mut self, len: u64) -> io::Result<()>;

    /// Waits until all is where a power cut does not reach it.
    fn sync(&mut self) -> io::Result<()>;
}

impl Medium for File {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        match self.sync_data() {
            // A device or a pipe keeps nothing.
            Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
            synced => synced,
        }
    }
}

/// The first line.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Name of the experiment.
    sweep: String,
    fingerprint: String,
    /// What the build of the program that did the runs says of itself.
    build: String,
    runs: u64,
    /// Which of the runs this journal is for, if not for all.
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

    /// What checks the lines of rows below this header.
    fn seal(&self) -> Seal {
        Seal::new(format!("{} {}", self.fingerprint, self.build))
    }

    fn line(&self) -> serde_json::Result<Vec<u8>> {
        Seal::default().line(self)
    }
}

impl Journal {
    /// Opens a journal to resume it, or begins one. Damaged lines are reported and removed.
    pub(crate) fn open(path: &Path, header: &Header, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let mut journal = Self::new(path, appending(path)?, header.seal());
        // A device or a pipe has no lines to go on with, and may have no end.
        if path.metadata().is_ok_and(|metadata| metadata.is_file()) {
            let lines = BufReader::new(File::open(path).map_err(Error::file("read", path))?);
            let found = reader::read(lines, header)
                .and_then(|found| found.of_shard(header.shard))
                .map_err(|refusal| refused(path, header, refusal))?;
            found.damage.iter().for_each(|damage| tell(&format!("{}: {damage}", path.display())));
            journal = journal.go_on_with(&found, header)?;
        }
        if journal.len == 0 {
            journal.put_header(header)?;
        }
        Ok(journal)
    }

    /// With what is sound in it, and nothing else.
    fn go_on_with(mut self, found: &Found, header: &Header) -> Result<Self, Error> {
        self.len = found.len;
        self.rows = found.rows.iter().map(|row| (row.run, row.start)).collect();
        self.repeated = found.failed.len() as u64;
        // If nothing is kept, the file is to be as old as the first run that is.
        let is_done_anew = self.rows.is_empty() && self.repeated > 0;
        self.failed = if is_done_anew { Vec::new() } else { found.failed.clone() };
        if !found.is_sound || is_done_anew {
            return self.mended(header);
        }
        if !found.is_whole {
            self.medium.cut(self.len).map_err(Error::file("mend", &self.path))?;
        }
        Ok(self)
    }

    /// The sound rows in a file that takes the place of this one once it is whole.
    fn mended(self, header: &Header) -> Result<Self, Error> {
        let path = self.path.with_extension("mended");
        // One that was not finished may be there.
        let _ = fs::remove_file(&path);
        let mut mended = Self::new(&path, appending(&path)?, self.seal.clone());
        mended.put_header(header)?;
        for row in self.rows()? {
            mended.append(&row?)?;
        }
        let done = mended.rows.len();
        let failed = self.failed.iter().map(|row| row.start).collect();
        for row in rows_at(&self.path, self.seal.clone(), failed)? {
            mended.append(&row?)?;
        }
        let moved = mended.rows.split_off(done).into_iter().zip(self.failed);
        mended.failed = moved.map(|((_, start), row)| Entry { start, ..row }).collect();
        mended.repeated = self.repeated;
        mended.sync()?;
        mended.move_to(&self.path)?;
        Ok(mended)
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

    /// When the first of its lines was written, as far as the file system knows.
    pub(crate) fn begun(&self) -> Option<SystemTime> {
        let metadata = fs::metadata(&self.path).ok()?;
        // A copy is younger than its lines.
        [metadata.created(), metadata.modified()].into_iter().filter_map(Result::ok).min()
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// All rows in the order of their runs.
    pub(crate) fn rows(&self) -> Result<impl Iterator<Item = Result<Row, Error>> + use<>, Error> {
        let mut rows = self.rows.clone();
        rows.sort_unstable();
        rows_at(&self.path, self.seal.clone(), rows.into_iter().map(|(_, start)| start).collect())
    }
}

/// The rows whose lines begin there, in this order.
fn rows_at(
    path: &Path,
    seal: Seal,
    starts: Vec<u64>,
) -> Result<impl Iterator<Item = Result<Row, Error>> + use<>, Error> {
    let path = path.to_owned();
    let mut file = BufReader::new(File::open(&path).map_err(Error::file("read", &path))?);
    let mut line = Vec::new();
    let mut at = 0;
    Ok(starts.into_iter().map(move |start| {
        line.clear();
        // Most rows stand near the one before: that needs no other look at the disk.
        let found = file.seek_relative(start as i64 - at as i64);
        let read = found.and_then(|()| file.read_until(b'\n', &mut line));
        at = start + read.map_err(Error::file("read", &path))? as u64;
        let row = reader::row(&seal, &line).map(|(row, _)| row);
        row.ok_or_else(|| {
            let path = path.display();
            Error::Refused(format!(
                "{path}: a line was damaged while the experiment ran; repeat the command to repeat its run"
            ))
        })
    }))
}

impl<M: Medium> Journal<M> {
    fn new(path: &Path, medium: M, seal: Seal) -> Self {
        Self {
            path: path.to_owned(),
            medium,
            seal,
            len: 0,
            rows: Vec::new(),
            failed: Vec::new(),
            repeated: 0,
            synced: None,
            is_synced: true,
        }
    }

    /// How many runs failed before, and are done again.
    pub(crate) fn repeated(&self) -> u64 {
        self.repeated
    }

    /// How many runs are in it.
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

    /// Where a run's line is that says the same: one that fails again and again needs no other.
    fn same_failure(&self, run: u64, line: &[u8]) -> Option<u64> {
        let place = self.failed.binary_search_by_key(&run, |row| row.run).ok()?;
        let (before, (_, sum)) = (&self.failed[place], self.seal.open(line)?);
        (before.sum == sum).then_some(before.start)
    }

    fn put_header(&mut self, header: &Header) -> Result<(), Error> {
        self.put(header.line())
    }

    /// Writes a line with one call, so that it is whole or the last. Nothing is left of one that failed.
    fn put(&mut self, line: serde_json::Result<Vec<u8>>) -> Result<(), Error> {
        let text = line.map_err(|error| Error::file("write", &self.path)(error.into()))?;
        if let Err(cause) = self.medium.write_all(&text).and_then(|()| self.medium.flush()) {
            // If even this fails the line is torn, and dropped when the journal is opened again.
            let _ = self.medium.cut(self.len);
            return Err(Error::file("write", &self.path)(cause));
        }
        self.len += text.len() as u64;
        self.is_synced = false;
        if self.synced.is_none_or(|at| at.elapsed() >= SYNC_INTERVAL) {
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until all lines are on the disk.
    pub(crate) fn sync(&mut self) -> Result<(), Error> {
        if !self.is_synced {
            self.medium.sync().map_err(Error::file("write", &self.path))?;
            (self.synced, self.is_synced) = (Some(Instant::now()), true);
        }
        Ok(())
    }
}

fn appending(path: &Path) -> Result<File, Error> {
    OpenOptions::new().append(true).create(true).open(path).map_err(Error::file("write", path))
}

/// The reason why a file is no journal that can be resumed, and the remedy.
fn refused(path: &Path, header: &Header, refusal: Refusal) -> Error {
    let place = path.display();
    let mending =
        "choose another place with --out DIR, or start over with --fresh, which deletes what is there";
    Error::Refused(match refusal {
        Refusal::Unreadable(cause) => return Error::file("read", path)(cause),
        Refusal::Foreign => {
            format!("{place} is not the journal of an experiment, or is damaged throughout; {mending}")
        }
        Refusal::Before => format!(
            "{place} was begun by an earlier version of baudbot, whose journals had no checksums, so damage \
             cannot be detected; {mending}"
        ),
        Refusal::OfAnother(found) => format!(
            "{place} belongs to another experiment, scenario or version, or to other seeds (`{}`, {}… instead of {}…); {mending}",
            found.sweep,
            found.fingerprint.get(..8).unwrap_or_default(),
            &header.fingerprint[..8]
        ),
        Refusal::OfAnotherBuild(found) => format!(
            "{place} was begun by another build of baudbot, whose runs differ from this one's (`{}` instead of `{}`); \
             continue with that build, {mending}",
            found.build, header.build
        ),
        Refusal::OfAnotherShard(found) => {
            let name = |shard: Option<Shard>| {
                shard.map_or_else(|| "all runs".to_owned(), |shard| format!("shard {shard}"))
            };
            format!("{place} is for {}, not for {}; {mending}", name(found), name(header.shard))
        }
    })
}

/// Waiting for the disk after each row would keep short runs waiting.
const SYNC_INTERVAL: Duration = Duration::from_millis(100);
