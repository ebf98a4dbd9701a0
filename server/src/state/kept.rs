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
pub(super) type Unusable = (PathBuf, JournalError);

/// The world of a folder; `None` if it was never finished.
///
/// # Errors
/// If a file of it cannot be used.
pub(super) fn read(name: &str, folder: &Path) -> Result<Option<KeptWorld>, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    file_names::remove_unfinished(folder).map_err(at)?;
    for (_, path) in file_names::journals(folder).map_err(at)? {
        let used = |error: JournalError| (path.clone(), error);
        let bytes = fs::read(&path).map_err(|error| used(error.into()))?;
        match Journal::read(&bytes) {
            // The program was killed before anybody was told of it: the one before has all.
            Err(JournalError::Unfinished) => {}
            Err(error) => return Err(used(error)),
            Ok(journal) => {
                let restored = journal.restore().map_err(used)?;
                return Ok(Some(kept(name, restored, &journal, snapshots(folder)?)));
            }
        }
    }
    Ok(None)
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
        let used = |error: JournalError| (path.clone(), error);
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
