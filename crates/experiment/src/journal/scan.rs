//! A journal that is only read: one of many that are merged. It may be on a disk that cannot be written, or still grow.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::reader::{self, Consequence, Entry, Refusal};
use super::seal::Seal;
use super::{Header, rows_at};
use crate::error::Error;
use crate::run_record::Row;
use crate::shard::Shard;

/// What is in a journal.
#[derive(Debug)]
pub(crate) struct Scan {
    pub(crate) path: PathBuf,
    /// Whose runs it is for, if not for all, or unknown.
    pub(crate) shard: Option<Shard>,
    /// The sound rows of runs that were done, in the order of the runs, each once.
    pub(crate) rows: Vec<Entry>,
    /// The last row of each run that failed.
    pub(crate) failed: Vec<Entry>,
    seal: Seal,
}

impl Scan {
    /// Looks through a journal of the experiment of this header; for which of its runs does not matter. Damage is told.
    pub(crate) fn read(path: &Path, header: &Header, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let lines = BufReader::new(File::open(path).map_err(Error::file("read", path))?);
        let found =
            reader::read_with(lines, header, COUNTED).map_err(|refusal| refused(path, header, refusal))?;
        found.damage.iter().for_each(|damage| tell(&format!("{}: {damage}", path.display())));
        let shard = found.header.and_then(|header| header.shard);
        let (rows, failed) = (found.rows, found.failed);
        Ok(Self { path: path.to_owned(), shard, rows, failed, seal: header.seal() })
    }

    /// The rows whose lines begin there.
    pub(crate) fn rows_at(
        &self,
        starts: Vec<u64>,
    ) -> Result<impl Iterator<Item = Result<Row, Error>>, Error> {
        rows_at(&self.path, self.seal.clone(), starts)
    }
}

/// The reason why a journal has no part in this experiment, and the remedy.
fn refused(path: &Path, header: &Header, refusal: Refusal) -> Error {
    let place = path.display();
    Error::Refused(match refusal {
        Refusal::Unreadable(cause) => return Error::file("read", path)(cause),
        Refusal::Foreign => {
            format!("{place} is not the journal of an experiment, or is damaged throughout; leave it out")
        }
        Refusal::Before => format!(
            "{place} is from an earlier version of baudbot, whose journals had no checksums; do its runs again with this one"
        ),
        Refusal::OfAnother(found) => format!(
            "{place} belongs to another experiment, scenario or version (`{}`, {}… instead of {}…); leave it out, or merge \
             with the file, the --seeds and the program of the shards",
            found.sweep,
            found.fingerprint.get(..8).unwrap_or_default(),
            &header.fingerprint[..8]
        ),
        Refusal::OfAnotherBuild(found) => format!(
            "{place} was written by another build of baudbot, whose runs differ from this one's (`{}` instead of `{}`); merge \
             with that build, or do all shards with one",
            found.build, header.build
        ),
        Refusal::OfAnotherShard(_) => format!("{place} is for other runs of this experiment"),
    })
}

const COUNTED: Consequence =
    Consequence { of_row: "its run does not count", of_header: "which shard's it is, is unknown" };
