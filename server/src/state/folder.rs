//! The folder in which a server keeps its state.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_recording::journal::JournalError;
use baudbot_sim::Scenario;

use super::files::WorldFiles;
use super::keeper::{Keeper, Now};
use super::kept::{self, Found, Problem};
use super::threads::Threads;
use super::{LAYOUT, file_names, private};

/// Why a folder cannot be used for a server's state.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// Something of it cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another server uses it.
    #[error("{}: another server keeps its state there; stop that one, or choose another folder", .0.display())]
    InUse(PathBuf),
    /// It is something else.
    #[error(
        "{}: is not empty, and no folder of a server's state; choose another, which is made if it is not there", .0.display()
    )]
    Foreign(PathBuf),
    /// Another version of the program has made it.
    #[error("{}: its layout is `{found}`; this version of baudbot knows `{}`", path.display(), layout().trim_end())]
    Layout {
        /// The folder.
        path: PathBuf,
        /// What it says of itself.
        found: String,
    },
}

/// The folder in which a server keeps its state. No other server can use it meanwhile. Clones are the same folder.
#[derive(Clone, Debug)]
pub struct StateFolder(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    path: PathBuf,
    threads: Threads,
    /// The names of what is there and is no world that goes on: they are left alone.
    taken: Mutex<BTreeSet<String>>,
    /// Locked as long as this lives.
    _marker: File,
}

impl StateFolder {
    /// Takes a folder, which is made if it is not there.
    ///
    /// # Errors
    /// If another server uses it, it is something else, or it cannot be written to.
    pub fn open(path: &Path) -> Result<Self, StateError> {
        let at = |path: &Path| {
            let path = path.to_owned();
            move |source| StateError::Io { path, source }
        };
        private::make_folder(path).map_err(at(path))?;
        let marker = path.join(MARKER);
        if !marker.exists() && fs::read_dir(path).map_err(at(path))?.next().is_some() {
            return Err(StateError::Foreign(path.to_owned()));
        }
        let mut file = private::open(&marker).map_err(at(&marker))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StateError::InUse(path.to_owned())),
            Err(TryLockError::Error(error)) => return Err(at(&marker)(error)),
        }
        let mut found = String::new();
        Read::by_ref(&mut file).take(256).read_to_string(&mut found).map_err(at(&marker))?;
        if found.is_empty() {
            file.write_all(layout().as_bytes()).map_err(at(&marker))?;
        } else if found != layout() {
            let found = found.trim_end().escape_debug().to_string();
            return Err(StateError::Layout { path: path.to_owned(), found });
        }
        for folder in [WORLDS, RECORDINGS].map(|name| path.join(name)) {
            private::make_folder(&folder).map_err(at(&folder))?;
        }
        let threads = Threads::start().map_err(at(path))?;
        Ok(Self(Arc::new(Inner { path: path.to_owned(), threads, taken: Mutex::default(), _marker: file })))
    }

    /// Where recordings go, unless another folder is named for them.
    pub fn recordings(&self) -> PathBuf {
        self.0.path.join(RECORDINGS)
    }

    /// The worlds that are there, in the order of their names. One that cannot be used is set aside, and what is no world, or cannot
    /// be read, is left as it is.
    ///
    /// # Errors
    /// If the folder of the worlds cannot be read.
    pub fn worlds(&self) -> Result<Vec<Found>, StateError> {
        let path = self.0.path.join(WORLDS);
        let entries = fs::read_dir(&path).and_then(Iterator::collect::<io::Result<Vec<_>>>);
        let entries = entries.map_err(|source| StateError::Io { path: path.clone(), source })?;
        let mut names: Vec<_> = entries.into_iter().map(|entry| entry.file_name()).collect();
        names.sort_unstable();
        let look = |name: OsString| look_at(&path.join(&name), &name.to_string_lossy());
        let found: Vec<_> = names.into_iter().filter_map(look).collect();
        self.taken().extend(found.iter().filter_map(taken));
        Ok(found)
    }

    /// Keeps a world from now on. `made`: the scenario with which it was made.
    pub(crate) fn keep(&self, made: Arc<Scenario>, now: &Now<'_>) -> Keeper {
        let folder = self.0.path.join(WORLDS).join(now.name);
        let threads = self.0.threads.clone();
        let is_taken = self.taken().contains(now.name);
        let files = match is_taken {
            true => WorldFiles::none(folder, threads),
            false => WorldFiles::new(folder, threads, now.world.tick()),
        };
        Keeper::new(files, made, now)
    }

    fn taken(&self) -> MutexGuard<'_, BTreeSet<String>> {
        // Nothing panics while it is changed.
        self.0.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What is in the folder of the worlds under this name; `None` if nobody has to be told of it.
fn look_at(path: &Path, name: &str) -> Option<Found> {
    if file_names::is_deleted(name) && path.symlink_metadata().is_ok_and(|found| found.is_dir()) {
        // The server was killed before it was gone.
        if let Err(error) = fs::remove_dir_all(path) {
            tracing::warn!(folder = %path.display(), %error, "the state of a deleted world cannot be removed");
        }
        return None;
    }
    // Those that were set aside have a dot.
    if name.contains('.') {
        return None;
    }
    let ignored = |problem| Some(Found::Ignored { path: path.to_owned(), problem });
    match fs::metadata(path) {
        Err(error) => Some(unreadable(name, path, JournalError::from(error).to_string())),
        Ok(found) if !found.is_dir() => ignored("is not a folder"),
        Ok(_) if !file_names::is_world(name) => ignored("has a name that no world can have"),
        Ok(_) => world(name, path),
    }
}

fn world(name: &str, folder: &Path) -> Option<Found> {
    match kept::read(name, folder) {
        Ok(Some(world)) => Some(Found::World(Box::new(world))),
        Ok(None) => {
            // If it cannot be removed, the next start attempts it again.
            let _ = file_names::remove_unfinished(folder).and_then(|()| fs::remove_dir(folder));
            None
        }
        Err((file, problem @ Problem::Journal(JournalError::Io(_)))) => {
            Some(unreadable(name, &file, problem.to_string()))
        }
        Err((file, problem)) => Some(set_aside(name, folder, file, &problem)),
    }
}

fn set_aside(name: &str, folder: &Path, file: PathBuf, problem: &Problem) -> Found {
    let to = file_names::damaged(folder);
    if let Err(error) = fs::rename(folder, &to) {
        return unreadable(name, &file, format!("{problem}, and the folder cannot be set aside: {error}"));
    }
    let problem = problem.to_string();
    tracing::error!(world = name, file = %file.display(), problem, to = %to.display(), "world set aside");
    Found::SetAside { name: name.to_owned(), file, problem, to }
}

fn unreadable(name: &str, file: &Path, problem: String) -> Found {
    tracing::error!(world = name, file = %file.display(), problem, "world left as it is");
    Found::Unreadable { name: name.to_owned(), file: file.to_owned(), problem }
}

/// The name of what is left as it is.
fn taken(found: &Found) -> Option<String> {
    match found {
        Found::World(_) | Found::SetAside { .. } => None,
        Found::Unreadable { name, .. } => Some(name.clone()),
        Found::Ignored { path, .. } => path.file_name().map(|name| name.to_string_lossy().into_owned()),
    }
}

/// The file that says what the folder is, and that a server locks.
const MARKER: &str = "baudbot-state";

const WORLDS: &str = "worlds";
const RECORDINGS: &str = "recordings";

fn layout() -> String {
    format!("baudbot-state {LAYOUT}\n")
}
