//! Looking at what is kept without going on with it, and making a world of what is left of a damaged one.

use std::path::{Path, PathBuf};

use baudbot_recording::journal::{Entries, Journal, JournalError, Ports, Restored, Salvaged};

use super::file_names;
use super::folder::{StateError, StateFolder};
use super::kept::{self, Problem};
use super::storage::{Kind, Storage};

/// The result of a look at a world's folder.
#[derive(Debug)]
pub struct Checked {
    /// The name of its folder.
    pub name: String,
    /// The soundness.
    pub soundness: Soundness,
}

/// The soundness of a world's files.
#[derive(Debug)]
pub enum Soundness {
    /// A server continues it.
    Sound {
        /// The last tick.
        tick: u64,
        /// The instant of that tick, in seconds.
        time_s: f64,
        /// A remark, such as on an unfinished write at its end.
        note: Option<String>,
    },
    /// No server continues it.
    Damaged {
        /// The file that is damaged.
        file: PathBuf,
        /// The fault.
        problem: String,
        /// The tick, and the time in seconds, at which it can be recovered; `None` if it cannot.
        recoverable: Option<(u64, f64)>,
    },
    /// The state cannot be read.
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The fault.
        problem: String,
    },
}

/// A world that was made of what was left of a damaged one.
#[derive(Debug)]
pub struct Recovered {
    /// The world's name.
    pub name: String,
    /// The tick at which it goes on.
    pub tick: u64,
    /// The instant of that tick, in seconds.
    pub time_s: f64,
    /// The folder of the damaged one, which is as it was.
    pub from: PathBuf,
    /// The parts that were left out, a sentence each.
    pub notes: Vec<String>,
}

/// A reason why a world cannot be recovered.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// There is no folder of such a world.
    #[error("{}: there is neither a world `{name}` nor one that was set aside", worlds.display())]
    Absent {
        /// The folder of the worlds.
        worlds: PathBuf,
        /// The name.
        name: String,
    },
    /// The state is sound.
    #[error("world `{0}` is sound: a server can continue it; there is nothing to recover")]
    Sound(String),
    /// There is a world of the name that it is to have.
    #[error("{}: already exists; give the recovered world another name with --as NAME", .0.display())]
    Taken(PathBuf),
    /// The world cannot have this name.
    #[error("`{0}`: no world can have this name; write 1 to 64 letters, digits, _ or -")]
    Name(String),
    /// Nothing can be made of its journal.
    #[error("{} {problem}, and has no sound state from which a world could continue", file.display())]
    Nothing {
        /// The journal, or the folder if there is none.
        file: PathBuf,
        /// The fault.
        problem: String,
    },
    /// A file or folder cannot be read or written.
    #[error(transparent)]
    State(#[from] StateError),
}

impl StateFolder {
    /// Checks all worlds, those that were set aside, too, and changes nothing.
    ///
    /// # Errors
    /// If the folder of the worlds cannot be read.
    pub fn check(&self) -> Result<Vec<Checked>, StateError> {
        let (storage, (worlds, names)) = (self.storage(), self.names()?);
        let ours = names.into_iter().filter(|name| is_ours(name) && is_folder(storage, &worlds.join(name)));
        let checked = ours.filter_map(|name| {
            let folder = worlds.join(&name);
            Some(Checked { soundness: look(storage, &name, &folder)?, name })
        });
        Ok(checked.collect())
    }

    /// Makes a world `to` of what is left of a damaged one: `name`, or the last that was set aside of this name, or the folder of
    /// that name. The damaged one stays as it is, set aside.
    ///
    /// # Errors
    /// If there is none, it is sound, or nothing can be made of it.
    pub fn recover(&self, name: &str, to: &str) -> Result<Recovered, RecoverError> {
        if !file_names::is_world(to) {
            return Err(RecoverError::Name(to.to_owned()));
        }
        let (storage, worlds) = (self.storage(), self.of_worlds());
        let absent = || RecoverError::Absent { worlds: worlds.clone(), name: name.to_owned() };
        let mut from = damaged(storage, &worlds, name).ok_or_else(absent)?;
        if let Some(Soundness::Sound { .. }) = look(storage, name, &from) {
            return Err(RecoverError::Sound(name.to_owned()));
        }
        let (journal, salvaged) = salvage(storage, &from)?;
        let target = worlds.join(to);
        if from == target {
            let aside = file_names::damaged(storage, &from);
            storage.rename(&from, &aside).map_err(StateError::at(&from))?;
            from = aside;
        } else if !storage.is_free(&target) {
            return Err(RecoverError::Taken(target));
        }
        let mut notes = notes(&journal, &salvaged);
        storage.make_folder(&target).map_err(StateError::at(&target))?;
        notes.extend(copy_snapshots(storage, &from, &target)?);
        let restored = &salvaged.restored;
        begin_journal(storage, to, &target, restored)?;
        let (tick, time_s) = (restored.world.tick(), restored.world.time().as_seconds());
        Ok(Recovered { name: to.to_owned(), tick, time_s, from, notes })
    }
}

/// Copies the snapshots of a world that can be used, and returns those that are left out.
fn copy_snapshots(storage: &dyn Storage, from: &Path, target: &Path) -> Result<Vec<String>, StateError> {
    let mut left_out = Vec::new();
    for (number, path) in file_names::snapshots(storage, from).map_err(StateError::at(from))? {
        match kept::snapshot(storage, number, &path) {
            Ok(snapshot) => {
                let path = file_names::snapshot(target, number);
                let written = storage.write(&path, &snapshot.bytes).and_then(|file| file.sync());
                written.map_err(StateError::at(&path))?;
            }
            Err(error) => left_out.push(format!("snapshot {number} {error}, and is left out")),
        }
    }
    Ok(left_out)
}

/// Writes the journal with which the world `to` goes on. It comes last, whole: with it the world is there.
fn begin_journal(
    storage: &dyn Storage,
    to: &str,
    target: &Path,
    restored: &Restored,
) -> Result<(), StateError> {
    let ports = Ports { ports: restored.ports.clone() };
    let (world, made) = (&restored.world, &restored.made);
    let bytes = Entries::beginning(to, world, made, &restored.settings, &ports).take();
    let path = file_names::journal(target, 1);
    let new = path.with_extension(file_names::UNFINISHED);
    let written = storage.write(&new, &bytes).and_then(|file| file.sync());
    written.and_then(|()| storage.rename(&new, &path)).map_err(StateError::at(&path))?;
    storage.sync_folder(target).map_err(StateError::at(target))
}

/// The soundness of this folder's content; `None` if nothing was ever kept in it.
fn look(storage: &dyn Storage, name: &str, folder: &Path) -> Option<Soundness> {
    match kept::peek(storage, name, folder) {
        Ok(None) => None,
        Ok(Some(world)) => {
            Some(Soundness::Sound { tick: world.tick, time_s: world.time_s, note: world.note })
        }
        Err((file, problem @ Problem::Journal(JournalError::Io(_)))) => {
            Some(Soundness::Unreadable { file, problem: problem.to_string() })
        }
        Err((file, problem)) => {
            let place = |salvaged: Salvaged| {
                let world = salvaged.restored.world;
                (world.tick(), world.time().as_seconds())
            };
            let recoverable = salvage(storage, folder).ok().map(|(_, salvaged)| place(salvaged));
            Some(Soundness::Damaged { file, problem: problem.to_string(), recoverable })
        }
    }
}

fn is_folder(storage: &dyn Storage, path: &Path) -> bool {
    matches!(storage.kind(path), Ok(Kind::Folder))
}

/// Whether this is the name of a world's folder, or of one that was set aside.
fn is_ours(name: &str) -> bool {
    file_names::is_world(name) || file_names::is_damaged(name)
}

/// The folder that is meant by a name.
fn damaged(storage: &dyn Storage, worlds: &Path, name: &str) -> Option<PathBuf> {
    let is_name = is_ours(name);
    let named = Some(worlds.join(name)).filter(|folder| is_name && is_folder(storage, folder));
    let is_sound =
        |folder: &PathBuf| matches!(look(storage, name, folder), Some(Soundness::Sound { .. }) | None);
    match named {
        Some(folder) if file_names::is_damaged(name) || !is_sound(&folder) => Some(folder),
        named => file_names::last_damaged(storage, &worlds.join(name)).filter(|_| is_name).or(named),
    }
}

/// The newest journal of a folder of which something is left.
fn salvage(storage: &dyn Storage, folder: &Path) -> Result<(PathBuf, Salvaged), RecoverError> {
    let mut problem =
        RecoverError::Nothing { file: folder.to_owned(), problem: Problem::NoJournal.to_string() };
    for (number, (_, path)) in
        file_names::journals(storage, folder).map_err(StateError::at(folder))?.into_iter().enumerate()
    {
        let bytes = storage.read(&path).map_err(StateError::at(folder))?;
        match Journal::salvage(&bytes) {
            Ok(salvaged) => return Ok((path, salvaged)),
            Err(error) if number == 0 => {
                problem = RecoverError::Nothing { file: path, problem: error.to_string() };
            }
            Err(_) => {}
        }
    }
    Err(problem)
}

fn notes(journal: &Path, salvaged: &Salvaged) -> Vec<String> {
    let file = journal.file_name().unwrap_or_default().display();
    let Salvaged { restored: _, passed, left_out: (length, bytes), differs } = salvaged;
    let passed = passed.iter().map(|at| {
        format!("{file} is damaged at byte {at}; a later state in it includes everything before, so nothing is lost there")
    });
    let differs = differs
        .iter()
        .map(|error| format!("{file} {error}; everything after the previous fingerprint is left out"));
    let rest =
        (*bytes > 0).then(|| format!("the last {bytes} bytes of {file}, after byte {length}, are left out"));
    passed.chain(differs).chain(rest).collect()
}
