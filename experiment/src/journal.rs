//! The journal: a line a run, in the order in which they end, written at once. It is all that a sweep needs to go on.
//!
//! The first line says which experiment it is of. A sweep that was killed may have torn the last line, which is dropped;
//! every other line is whole. Lines reach the disk within a tenth of a second or with the next one, so that a power cut
//! takes a few of the last runs at most.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::figures::INFOS;
use crate::row::{Row, Written};

/// A journal that is open.
#[derive(Debug)]
pub(crate) struct Journal<M = File> {
    path: PathBuf,
    medium: M,
    /// Bytes that are whole lines.
    len: u64,
    /// Each run with where its line begins.
    rows: Vec<(u64, u64)>,
    /// When the disk last had all lines.
    synced: Option<Instant>,
    is_synced: bool,
}

/// What a journal is written to.
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
    #[serde(default)]
    build: String,
    runs: u64,
    figures: Vec<String>,
}

impl Header {
    pub(crate) fn new(name: &str, fingerprint: String, build: String, runs: u64) -> Self {
        let figures = INFOS.iter().map(|info| info.name.to_owned()).collect();
        Self { sweep: name.to_owned(), fingerprint, build, runs, figures }
    }
}

impl Journal {
    /// Opens a journal to go on with it, or begins one.
    pub(crate) fn open(path: &Path, header: &Header) -> Result<Self, Error> {
        let file =
            OpenOptions::new().append(true).create(true).open(path).map_err(Error::file("write", path))?;
        let mut journal = Self::new(path, file);
        // A device or a pipe has no lines to go on with, and may have no end.
        if path.metadata().is_ok_and(|metadata| metadata.is_file()) {
            journal.read(header)?;
        }
        if journal.len == 0 {
            journal.put(header)?;
        }
        Ok(journal)
    }

    /// Takes in the lines that are there.
    fn read(&mut self, header: &Header) -> Result<(), Error> {
        let mut lines = BufReader::new(File::open(&self.path).map_err(Error::file("read", &self.path))?);
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            lines.read_until(b'\n', &mut line).map_err(Error::file("read", &self.path))?;
            if line.last() != Some(&b'\n') {
                break;
            }
            match number {
                1 => self.compare(&line, header)?,
                _ => self.take(&line, number, header.runs)?,
            }
            self.len += line.len() as u64;
        }
        self.rows.sort_unstable();
        self.rows.dedup_by_key(|row| row.0);
        if !line.is_empty() {
            if self.len == 0 && !json(header, &self.path)?.starts_with(&line) {
                return Err(self.foreign());
            }
            self.medium.cut(self.len).map_err(Error::file("mend", &self.path))?;
        }
        Ok(())
    }

    /// Takes in a row, but for one that must be done again.
    fn take(&mut self, line: &[u8], number: u64, runs: u64) -> Result<(), Error> {
        let row = self.parse(line, &format!("line {number}"))?;
        if row.run >= runs {
            return Err(Error::Refused(format!(
                "{}: line {number} is of run {}, but the last run is {}; delete that line, or begin anew with --fresh",
                self.path.display(),
                row.run,
                runs.saturating_sub(1)
            )));
        }
        if !row.has_panicked() {
            self.rows.push((row.run, self.len));
        }
        Ok(())
    }

    fn foreign(&self) -> Error {
        let path = self.path.display();
        Error::Refused(format!("{path} is no journal of an experiment; choose another place with --out DIR"))
    }

    fn compare(&self, line: &[u8], header: &Header) -> Result<(), Error> {
        let found: Header = serde_json::from_slice(line).map_err(|_| self.foreign())?;
        let (path, mending) =
            (self.path.display(), "or begin anew with --fresh, which deletes what is there");
        if found.fingerprint != header.fingerprint {
            return Err(Error::Refused(format!(
                "{path} is of another experiment, scenario or version (`{}`, {}…, and not {}…); choose another place \
                 with --out DIR, {mending}",
                found.sweep,
                found.fingerprint.get(..8).unwrap_or_default(),
                &header.fingerprint[..8]
            )));
        }
        if found.build != header.build {
            return Err(Error::Refused(format!(
                "{path} was begun by another build of baudbot, whose runs differ from this one's (`{}`, and not `{}`); \
                 go on with that build, choose another place with --out DIR, {mending}",
                found.build, header.build
            )));
        }
        Ok(())
    }

    fn parse(&self, line: &[u8], which: &str) -> Result<Row, Error> {
        let row = serde_json::from_slice::<Written>(line).ok().and_then(Written::row);
        row.ok_or_else(|| {
            Error::Refused(format!(
                "{}: {which} is damaged; delete it and that run is done again, or begin anew with --fresh",
                self.path.display()
            ))
        })
    }

    /// Puts the file elsewhere, in the place of what is there.
    pub(crate) fn move_to(&mut self, path: &Path) -> Result<(), Error> {
        std::fs::rename(&self.path, path).map_err(Error::file("write", path))?;
        path.clone_into(&mut self.path);
        Ok(())
    }

    /// All rows in the order of their runs.
    pub(crate) fn rows(&self) -> Result<impl Iterator<Item = Result<Row, Error>>, Error> {
        let mut rows = self.rows.clone();
        rows.sort_unstable();
        let mut file = BufReader::new(File::open(&self.path).map_err(Error::file("read", &self.path))?);
        let mut line = Vec::new();
        let mut at = 0;
        Ok(rows.into_iter().map(move |(_, start)| {
            line.clear();
            // Most rows stand near the one before: that needs no other look at the disk.
            let found = file.seek_relative(start as i64 - at as i64);
            let read = found.and_then(|()| file.read_until(b'\n', &mut line));
            at = start + read.map_err(Error::file("read", &self.path))? as u64;
            self.parse(&line, "the row")
        }))
    }
}

impl<M: Medium> Journal<M> {
    fn new(path: &Path, medium: M) -> Self {
        Self { path: path.to_owned(), medium, len: 0, rows: Vec::new(), synced: None, is_synced: true }
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
        let at = self.len;
        self.put(&Written::from(row))?;
        self.rows.push((row.run, at));
        Ok(())
    }

    /// Writes a line with one call, so that it is whole or the last. Nothing is left of one that failed.
    fn put(&mut self, line: &impl Serialize) -> Result<(), Error> {
        let text = json(line, &self.path)?;
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

/// A line.
fn json(line: &impl Serialize, path: &Path) -> Result<Vec<u8>, Error> {
    let mut text = serde_json::to_vec(line).map_err(|error| Error::file("write", path)(error.into()))?;
    text.push(b'\n');
    Ok(text)
}

/// Waiting for the disk after each row would keep short runs waiting.
const SYNC_INTERVAL: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use super::*;

    /// Has room for so many bytes.
    #[derive(Default)]
    struct Full {
        bytes: Vec<u8>,
        room: usize,
        /// How many bytes there were at each sync.
        syncs: Vec<usize>,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let fits = bytes.len().min(self.room - self.bytes.len());
            self.bytes.extend(&bytes[..fits]);
            if fits == 0 { Err(ErrorKind::StorageFull.into()) } else { Ok(fits) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Medium for Full {
        fn cut(&mut self, len: u64) -> io::Result<()> {
            self.bytes.truncate(len as usize);
            Ok(())
        }

        fn sync(&mut self) -> io::Result<()> {
            self.syncs.push(self.bytes.len());
            Ok(())
        }
    }

    #[test]
    fn on_a_full_disk_whole_rows_stay_and_the_error_names_the_file() {
        let row = |run| Row { run, outcome: Err("too short".to_owned()) };
        let mut journal =
            Journal::new(Path::new("/somewhere/rows.jsonl"), Full { room: 100, ..Full::default() });
        let mut run = 0;
        let error = loop {
            match journal.append(&row(run)) {
                Ok(()) => run += 1,
                Err(error) => break error.to_string(),
            }
        };
        assert!(error.starts_with("cannot write /somewhere/rows.jsonl: "), "{error}");
        let text = String::from_utf8(journal.medium.bytes.clone()).unwrap();
        assert_eq!(text.lines().count() as u64, run);
        assert!(run > 0 && text.ends_with("}\n"), "{text}");
        assert_eq!(journal.runs(), (0..run).collect::<Vec<_>>());
        // With room again it goes on where it was.
        journal.medium.room = 1000;
        journal.append(&row(run)).unwrap();
        assert_eq!(journal.medium.bytes.len() as u64, journal.len);
    }

    #[test]
    fn rows_reach_the_disk_soon_but_not_each_by_itself() {
        let row = |run| Row { run, outcome: Err("too short".to_owned()) };
        let medium = Full { room: 100_000, ..Full::default() };
        let mut journal = Journal::new(Path::new("/somewhere/rows.jsonl"), medium);
        let start = Instant::now();
        (0..100).for_each(|run| journal.append(&row(run)).unwrap());
        let most = 1 + start.elapsed().as_millis() / SYNC_INTERVAL.as_millis();
        assert!((1..=most as usize).contains(&journal.medium.syncs.len()), "{:?}", journal.medium.syncs);
        journal.synced = Instant::now().checked_sub(SYNC_INTERVAL);
        journal.append(&row(100)).unwrap();
        assert_eq!(journal.medium.syncs.last(), Some(&journal.medium.bytes.len()));
        journal.synced = Some(Instant::now() + SYNC_INTERVAL);
        journal.append(&row(101)).unwrap();
        assert_ne!(journal.medium.syncs.last(), Some(&journal.medium.bytes.len()));
        journal.sync().unwrap();
        assert_eq!(journal.medium.syncs.last(), Some(&journal.medium.bytes.len()));
    }
}
