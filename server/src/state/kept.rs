//! Worlds that are found in a state folder.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::journal::{Journal, JournalError, PortState, Restored, Settings};
use baudbot_sim::{Scenario, World};

use super::file_names;
use super::storage::Storage;
use crate::convert::pace_of;
use crate::message::RecordConfig;
use crate::pace::Pace;

/// The content of a world's folder.
pub enum Found {
    /// A world that goes on.
    World(Box<KeptWorld>),
    /// One that cannot; it was set aside.
    SetAside {
        /// The world's name.
        name: String,
        /// The file that cannot be used, as it was called.
        file: PathBuf,
        /// The reason.
        problem: String,
        /// The new place of its folder.
        to: PathBuf,
    },
    /// One whose files cannot be read, or that cannot be set aside. It is left as it is, and a new world of its name is not kept.
    Unreadable {
        /// The world's name.
        name: String,
        /// The file or folder.
        file: PathBuf,
        /// The reason.
        problem: String,
    },
    /// Something else, which is left as it is, too.
    Ignored {
        /// The file or folder.
        path: PathBuf,
        /// The reason why it is no world.
        problem: &'static str,
    },
}

/// A world that goes on as its server left it.
pub struct KeptWorld {
    /// The name of the world.
    pub name: String,
    /// The world's scenario.
    pub scenario: Arc<Scenario>,
    /// The tick of the world.
    pub tick: u64,
    /// The instant at which that is, in seconds.
    pub time_s: f64,
    /// A remark.
    pub note: Option<String>,
    pub(crate) world: World,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    pub(crate) resumed: Resumed,
    /// Snapshots that cannot be used, which are given another name.
    spoiled: Vec<PathBuf>,
}

/// The parts of a world besides its state that outlived its server.
pub(crate) struct Resumed {
    /// The scenario with which it was made.
    pub(crate) made: Arc<Scenario>,
    pub(crate) ports: Vec<PortState>,
    /// Whether robots had brains, in the form of the sessions.
    pub(crate) slots: Vec<u8>,
    pub(crate) snapshots: Vec<KeptSnapshot>,
    /// The recording.
    pub(crate) recording: Option<RecordConfig>,
}

/// A snapshot that outlived its server.
pub(crate) struct KeptSnapshot {
    pub(crate) number: u64,
    pub(crate) world: World,
    pub(crate) ports: Vec<PortState>,
    /// The file of the snapshot.
    pub(crate) bytes: Vec<u8>,
}

/// The reason why a world cannot go on: a file of it, and its fault.
pub(super) type Unusable = (PathBuf, Problem);

/// The fault of a file or a folder.
#[derive(Debug, thiserror::Error)]
pub(super) enum Problem {
    /// A journal, or a snapshot, cannot be used or read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The folder has files, but no journal.
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
pub(super) fn read(storage: &dyn Storage, name: &str, folder: &Path) -> Result<Option<KeptWorld>, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    let Some(mut world) = peek(storage, name, folder)? else { return Ok(None) };
    for path in std::mem::take(&mut world.spoiled) {
        // Another snapshot may get its number.
        let to = file_names::damaged(storage, &path);
        storage.rename(&path, &to).map_err(at)?;
    }
    file_names::remove_unfinished(storage, folder).map_err(at)?;
    Ok(Some(world))
}

/// The same, and changes nothing.
///
/// # Errors
/// If a file of it cannot be used.
pub(super) fn peek(storage: &dyn Storage, name: &str, folder: &Path) -> Result<Option<KeptWorld>, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    let mut begun: Option<Unusable> = None;
    for (_, path) in file_names::journals(storage, folder).map_err(at)? {
        let used = |problem: Problem| (path.clone(), problem);
        let bytes = storage.read(&path).map_err(|error| used(error.into()))?;
        match Journal::read(&bytes) {
            // The power failed before all of it was on the disk, and before the one before was removed, which has all that was. If
            // there is none, it is lost.
            Err(error) if error.has_no_state() => begun = begun.or_else(|| Some(used(error.into()))),
            Err(error) => return Err(used(error.into())),
            Ok(journal) => {
                let restored = journal.restore().map_err(|error| used(error.into()))?;
                let (snapshots, spoiled) = snapshots(storage, folder)?;
                let notes = notes(&path, begun.as_ref(), &journal, &spoiled);
                let spoiled = spoiled.into_iter().map(|(path, _)| path).collect();
                let note = (!notes.is_empty()).then(|| notes.join("; "));
                let world = kept(name, restored, snapshots);
                return Ok(Some(KeptWorld { note, spoiled, ..world }));
            }
        }
    }
    match begun {
        Some(unusable) => Err(unusable),
        // A journal gets its name when it is whole: the server was killed before it had confirmed the world.
        None if file_names::is_unused(storage, folder).map_err(at)? => Ok(None),
        None => Err((folder.to_owned(), Problem::NoJournal)),
    }
}

/// The remarks on a world that goes on with this journal: on a newer one that was only begun, an unfinished write at
/// its end, and snapshots that cannot be used.
fn notes(
    path: &Path,
    begun: Option<&Unusable>,
    journal: &Journal,
    spoiled: &[(PathBuf, JournalError)],
) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some((newer, problem)) = begun {
        notes.push(format!("{} {problem}, and {} before it is continued", file(newer), file(path)));
    }
    if journal.torn() > 0 {
        let torn = journal.torn();
        notes.push(format!("the last {torn} bytes of its journal are an unfinished write and are left out"));
    }
    for (path, error) in spoiled {
        notes.push(format!("{} {error}, and is left out", file(path)));
    }
    notes
}

fn file(path: &Path) -> String {
    path.file_name().unwrap_or_default().display().to_string()
}

fn kept(name: &str, restored: Restored, snapshots: Vec<KeptSnapshot>) -> KeptWorld {
    let Restored { world, made, settings, ports, replayed: _ } = restored;
    let Settings { pace, paused, slots, recording } = settings;
    let recording =
        recording.map(|kept| RecordConfig { name: kept.name, path: kept.path.into(), look_hz: kept.look_hz });
    let (scenario, tick, time_s) = (Arc::clone(world.scenario()), world.tick(), world.time().as_seconds());
    let pace = pace.and_then(pace_of).unwrap_or(Pace::REAL_TIME);
    let resumed = Resumed { made, ports, slots, snapshots, recording };
    let (name, note, spoiled) = (name.to_owned(), None, Vec::new());
    KeptWorld { name, scenario, tick, time_s, note, world, pace, paused, resumed, spoiled }
}

/// Snapshots, and those that are not whole, as the power failed before they were on the disk: no reason to lose the world.
type Snapshots = (Vec<KeptSnapshot>, Vec<(PathBuf, JournalError)>);

fn snapshots(storage: &dyn Storage, folder: &Path) -> Result<Snapshots, Unusable> {
    let at = |error: io::Error| (folder.to_owned(), error.into());
    let (mut whole, mut spoiled) = (Vec::new(), Vec::new());
    for (number, path) in file_names::snapshots(storage, folder).map_err(at)? {
        match snapshot(storage, number, &path) {
            Ok(snapshot) => whole.push(snapshot),
            Err(error @ JournalError::Io(_)) => return Err((path, error.into())),
            Err(error) => spoiled.push((path, error)),
        }
    }
    Ok((whole, spoiled))
}

/// The snapshot in a file.
///
/// # Errors
/// If it cannot be used.
pub(super) fn snapshot(
    storage: &dyn Storage,
    number: u64,
    path: &Path,
) -> Result<KeptSnapshot, JournalError> {
    let bytes = storage.read(path)?;
    let journal = Journal::read(&bytes)?;
    // A snapshot gets its name only when it is whole, so a torn one is damaged.
    if journal.torn() > 0 {
        return Err(JournalError::Damaged(journal.length()));
    }
    let Restored { world, ports, .. } = journal.restore()?;
    Ok(KeptSnapshot { number, world, ports, bytes })
}
