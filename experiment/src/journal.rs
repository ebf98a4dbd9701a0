//! The journal: a line a run, in the order in which they end, written at once. It is all that a sweep needs to go on.
//!
//! The first line says which experiment it is of. A sweep that was killed may have torn the last line, which is dropped;
//! every other line is whole.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

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
}

/// What a journal is written to.
pub(crate) trait Medium: Write {
    /// Drops what is beyond so many bytes.
    fn cut(&mut self, len: u64) -> io::Result<()>;
}

impl Medium for File {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }
}

/// The first line.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Name of the experiment.
    sweep: String,
    pub(crate) fingerprint: String,
    runs: u64,
    figures: Vec<String>,
}

impl Header {
    pub(crate) fn new(name: &str, fingerprint: String, runs: u64) -> Self {
        let figures = INFOS.iter().map(|info| info.name.to_owned()).collect();
        Self { sweep: name.to_owned(), fingerprint, runs, figures }
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
                _ => self.rows.push((self.parse(&line, &format!("line {number}"))?.run, self.len)),
            }
            self.len += line.len() as u64;
        }
        self.rows.sort_unstable();
        self.rows.dedup_by_key(|row| row.0);
        if !line.is_empty() {
            self.medium.cut(self.len).map_err(Error::file("mend", &self.path))?;
        }
        Ok(())
    }

    fn compare(&self, line: &[u8], header: &Header) -> Result<(), Error> {
        let path = self.path.display();
        let found: Header = serde_json::from_slice(line).map_err(|_| {
            Error::Refused(format!("{path} is no journal of a sweep; choose another place with --out DIR"))
        })?;
        if found.fingerprint == header.fingerprint {
            return Ok(());
        }
        Err(Error::Refused(format!(
            "{path} is of another experiment, scenario or version (`{}`, {}…, and not {}…); choose another place with \
             --out DIR, or begin anew with --fresh, which deletes what is there",
            found.sweep,
            found.fingerprint.get(..8).unwrap_or_default(),
            &header.fingerprint[..8]
        )))
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
        Self { path: path.to_owned(), medium, len: 0, rows: Vec::new() }
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
        let mut text =
            serde_json::to_vec(line).map_err(|error| Error::file("write", &self.path)(error.into()))?;
        text.push(b'\n');
        if let Err(cause) = self.medium.write_all(&text).and_then(|()| self.medium.flush()) {
            // If even this fails the line is torn, and dropped when the journal is opened again.
            let _ = self.medium.cut(self.len);
            return Err(Error::file("write", &self.path)(cause));
        }
        self.len += text.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Has room for so many bytes.
    #[derive(Default)]
    struct Full {
        bytes: Vec<u8>,
        room: usize,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let fits = bytes.len().min(self.room - self.bytes.len());
            self.bytes.extend(&bytes[..fits]);
            if fits == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(fits) }
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
    }

    #[test]
    fn on_a_full_disk_whole_rows_stay_and_the_error_names_the_file() {
        let row = |run| Row { run, outcome: Err("too short".to_owned()) };
        let mut journal =
            Journal::new(Path::new("/somewhere/rows.jsonl"), Full { bytes: Vec::new(), room: 100 });
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
}
