//! Worlds that are found in a state folder.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::journal::{Journal, JournalError, PortState, Restored, Settings};
use baudbot_sim::{Scenario, World};

use super::file_names;
use crate::convert::pace_of;
use crate::message::RecordConfig;
use crate::pace::Pace;

/// What was found in a world's folder.
pub enum Found {
    /// A world that goes on.
    World(Box<KeptWorld>),
    /// One that cannot; it was set aside.
    SetAside {
        /// The world's name.
        name: String,
        /// The file that cannot be used, as it was called.
        file: PathBuf,
        /// Why.
        problem: String,
        /// Where its folder is now.
        to: PathBuf,
    },
    /// One whose files cannot be read, or that cannot be set aside. It is left as it is, and a new world of its name is not kept.
    Unreadable {
        /// The world's name.
        name: String,
        /// The file or folder.
        file: PathBuf,
        /// Why.
        problem: String,
    },
    /// Something else, which is left as it is, too.
    Ignored {
        /// The file or folder.
        path: PathBuf,
        /// Why it is no world.
        problem: &'static str,
    },
}

/// A world that goes on as its server left it.
pub struct KeptWorld {
    /// Its name.
    pub name: String,
    /// Its scenario.
    pub scenario: Arc<Scenario>,
    /// Its tick.
    pub tick: u64,
    /// When that is, in seconds.
    pub time_s: f64,
    /// What is to be told about it.
    pub note: Option<String>,
    pub(crate) world: World,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    pub(crate) resumed: Resumed,
}

/// What a world has besides its state that outlived its server.
pub(crate) struct Resumed {
    /// The scenario with which it was made.
    pub(crate) made: Arc<Scenario>,
    pub(crate) ports: Vec<PortState>,
    /// Whether robots had brains, as the sessions tell it.
    pub(crate) slots: Vec<u8>,
    pub(crate) snapshots: Vec<KeptSnapshot>,
    /// What was being recorded.
    pub(crate) recording: Option<RecordConfig>,
}

/// A snapshot that outlived its server.
pub(crate) struct KeptSnapshot {
    pub(crate) number: u64,
    pub(crate) world: World,
    pub(crate) ports: Vec<PortState>,
    /// Its file.
    pub(crate) bytes: Vec<u8>,
}

/// Why a world cannot go on: a file of it, and what is wrong with it.
pub(super) type Unusable = (PathBuf, Problem);

/// What is wrong with a file or a folder.
#[derive(Debug, thiserror::Error)]
pub(super) enum Problem {
    /// It is a journal, or a snapshot, that cannot be used or read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// It is a folder that has something, but no journal.
    #[error("has no journal")]
    NoJournal,
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Self::Journal(error.into())
    }
}

/// The world of a folder; `None` if nothing was ever kept in it.
///
/// # Errors
/// If a file of it cannot be used.
pub(super) fn read(name: &str, folder: &Path) -> Result<Option<KeptWorld>, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    let mut cut = None;
    for (_, path) in file_names::journals(folder).map_err(at)? {
        let used = |problem: Problem| (path.clone(), problem);
        let bytes = fs::read(&path).map_err(|error| used(error.into()))?;
        match Journal::read(&bytes) {
            // A power cut came before all of it was on the disk, and before the one before was removed, which has all. If there is
            // none, somebody has cut it.
            Err(JournalError::Unfinished) => cut = cut.or(Some(path)),
            Err(error) => return Err(used(error.into())),
            Ok(journal) => {
                let restored = journal.restore().map_err(|error| used(error.into()))?;
                let world = kept(name, restored, &journal, snapshots(folder)?);
                file_names::remove_unfinished(folder).map_err(at)?;
                return Ok(Some(world));
            }
        }
    }
    match cut {
        Some(path) => Err((path, JournalError::Unfinished.into())),
        // A journal gets its name when it is whole: the server was killed before it had said that the world is there.
        None if file_names::is_unused(folder).map_err(at)? => Ok(None),
        None => Err((folder.to_owned(), Problem::NoJournal)),
    }
}

fn kept(name: &str, restored: Restored, journal: &Journal, snapshots: Vec<KeptSnapshot>) -> KeptWorld {
    let Restored { world, made, settings, ports, replayed: _ } = restored;
    let Settings { pace, paused, slots, recording } = settings;
    let recording =
        recording.map(|kept| RecordConfig { name: kept.name, path: kept.path.into(), look_hz: kept.look_hz });
    let (scenario, tick, time_s) = (Arc::clone(world.scenario()), world.tick(), world.time().as_seconds());
    let pace = pace.and_then(pace_of).unwrap_or(Pace::REAL_TIME);
    let resumed = Resumed { made, ports, slots, snapshots, recording };
    let torn = Some(journal.torn()).filter(|torn| *torn > 0);
    let note =
        torn.map(|torn| format!("the last {torn} bytes of its journal were not whole and are left out"));
    KeptWorld { name: name.to_owned(), scenario, tick, time_s, note, world, pace, paused, resumed }
}

fn snapshots(folder: &Path) -> Result<Vec<KeptSnapshot>, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    let files = file_names::snapshots(folder).map_err(at)?;
    let read = |(number, path): (u64, PathBuf)| {
        let used = |error: JournalError| (path.clone(), error.into());
        let bytes = fs::read(&path).map_err(|error| used(error.into()))?;
        let journal = Journal::read(&bytes).map_err(used)?;
        // It is written to another name first, and then whole.
        if journal.torn() > 0 {
            return Err(used(JournalError::Damaged(journal.length())));
        }
        let Restored { world, ports, .. } = journal.restore().map_err(used)?;
        Ok(KeptSnapshot { number, world, ports, bytes })
    };
    files.into_iter().map(read).collect()
}
