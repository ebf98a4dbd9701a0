//! The folder in which a server keeps its state.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_recording::journal::JournalError;
use baudbot_sim::Scenario;
use tokio::sync::Semaphore;

use super::files::WorldFiles;
use super::keeper::{Keeper, Now};
use super::kept::{self, Found, Problem};
use super::shared::Shared;
use super::storage::{Kind, Listed, Storage, System};
use super::threads::Threads;
use super::{LAYOUT, file_names, private};
use crate::system::most_journals;

/// A reason why a folder cannot be used for a server's state.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// Something of it cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Another server uses it.
    #[error("{}: another server keeps its state there; stop that one, or choose another folder", .0.display())]
    InUse(PathBuf),
    /// The folder does not exist.
    #[error("{}: there is no such folder; `baudbot serve --state FOLDER` creates one", .0.display())]
    Absent(PathBuf),
    /// The folder is something else.
    #[error(
        "{}: is not empty, and not the folder of a server's state; choose another, which is created if needed", .0.display()
    )]
    Foreign(PathBuf),
    /// Another version of the program has made it.
    #[error("{}: its layout is `{found}`; this version of baudbot needs `{}`", path.display(), layout().trim_end())]
    Layout {
        /// The folder.
        path: PathBuf,
        /// The mark that the folder has.
        found: String,
    },
}

impl StateError {
    /// The system's error about this file or folder.
    pub(super) fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}

/// The folder in which a server keeps its state. No other server can use it meanwhile. Clones are the same folder.
#[derive(Clone, Debug)]
pub struct StateFolder(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    path: PathBuf,
    shared: Shared,
    /// The names of what is there and is no world that goes on: they are left alone.
    taken: Mutex<BTreeSet<String>>,
    /// Locked as long as this lives; `None` on a simulated disk.
    _marker: Option<File>,
}

impl StateFolder {
    /// Takes a folder, which is made if it is not there.
    ///
    /// # Errors
    /// If another server uses it, it is something else, or it cannot be written to.
    pub fn open(path: &Path) -> Result<Self, StateError> {
        private::make_folder(path).map_err(StateError::at(path))?;
        let marker = path.join(MARKER);
        if !marker.exists() && fs::read_dir(path).map_err(StateError::at(path))?.next().is_some() {
            return Err(StateError::Foreign(path.to_owned()));
        }
        let mut file = private::open(&marker).map_err(StateError::at(&marker))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StateError::InUse(path.to_owned())),
            Err(TryLockError::Error(error)) => return Err(StateError::at(&marker)(error)),
        }
        let mut found = String::new();
        Read::by_ref(&mut file).take(256).read_to_string(&mut found).map_err(StateError::at(&marker))?;
        if found.is_empty() {
            file.write_all(layout().as_bytes()).map_err(StateError::at(&marker))?;
        } else if found != layout() {
            let found = found.trim_end().escape_debug().to_string();
            return Err(StateError::Layout { path: path.to_owned(), found });
        }
        for folder in [WORLDS, RECORDINGS].map(|name| path.join(name)) {
            private::make_folder(&folder).map_err(StateError::at(&folder))?;
        }
        sync_names(&System, path).map_err(StateError::at(path))?;
        let threads = Threads::start().map_err(StateError::at(path))?;
        Ok(Self::with(path, Arc::new(System), threads, Some(file)))
    }

    /// A folder on a simulated disk that is not shared. The work of threads is done by tasks of the runtime in which
    /// the server runs, which must be [without threads](crate::Builder::without_threads).
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn simulated(path: &Path, storage: Arc<dyn Storage>) -> Result<Self, StateError> {
        let worlds = path.join(WORLDS);
        let made = storage.make_folder(&worlds).and_then(|()| sync_names(&*storage, path));
        made.map_err(StateError::at(&worlds))?;
        Ok(Self::with(path, storage, Threads::Tasks, None))
    }

    fn with(path: &Path, storage: Arc<dyn Storage>, threads: Threads, marker: Option<File>) -> Self {
        let places = Arc::new(Semaphore::new(most_journals().min(Semaphore::MAX_PERMITS)));
        let shared = Shared { storage, threads, places };
        let path = path.to_owned();
        Self(Arc::new(Inner { path, shared, taken: Mutex::default(), _marker: marker }))
    }

    pub(super) fn storage(&self) -> &dyn Storage {
        &*self.0.shared.storage
    }

    /// Takes a folder that is there.
    ///
    /// # Errors
    /// As [`open`](Self::open), and if there is none.
    pub fn open_present(path: &Path) -> Result<Self, StateError> {
        // An empty one is made one by a server, and not by a person who looks.
        if !path.join(MARKER).exists() && fs::read_dir(path).map_or(true, |mut files| files.next().is_none())
        {
            return Err(StateError::Absent(path.to_owned()));
        }
        Self::open(path)
    }

    /// The folder of the worlds.
    pub(super) fn of_worlds(&self) -> PathBuf {
        self.0.path.join(WORLDS)
    }

    /// The folder of recordings, unless another one is named for them.
    pub fn recordings(&self) -> PathBuf {
        self.0.path.join(RECORDINGS)
    }

    /// The worlds that are there, in the order of their names. One that cannot be used is set aside, and what is no world, or cannot
    /// be read, is left as it is.
    ///
    /// # Errors
    /// If the folder of the worlds cannot be read.
    pub fn worlds(&self) -> Result<Vec<Found>, StateError> {
        let (path, names) = self.names()?;
        let look = |name: String| look_at(self.storage(), &path.join(&name), &name);
        let found: Vec<_> = names.into_iter().filter_map(look).collect();
        self.taken().extend(found.iter().filter_map(taken));
        Ok(found)
    }

    /// The folder of the worlds, and all names in it, sorted.
    pub(super) fn names(&self) -> Result<(PathBuf, Vec<String>), StateError> {
        let path = self.of_worlds();
        let listed = self.storage().list(&path).map_err(StateError::at(&path))?;
        let mut names: Vec<_> = listed.into_iter().map(|Listed { name, .. }| name).collect();
        names.sort_unstable();
        Ok((path, names))
    }

    /// Keeps a world from now on. `made`: the scenario with which it was made.
    pub(crate) fn keep(&self, made: Arc<Scenario>, now: &Now<'_>) -> Keeper {
        let folder = self.of_worlds().join(now.name);
        let shared = self.0.shared.clone();
        let is_taken = self.taken().contains(now.name);
        let files = match is_taken {
            true => WorldFiles::none(folder, shared),
            false => WorldFiles::new(folder, shared, now.world.tick()),
        };
        Keeper::new(files, made, now)
    }

    fn taken(&self) -> MutexGuard<'_, BTreeSet<String>> {
        // Nothing panics while it is changed.
        self.0.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Forces the names of the folders onto the disk, without which what is in them would be lost. The folders around may have been made
/// with it, by this server or by one that was killed. One of those that cannot be synced may be another user's, who made it long ago, and
/// is passed over.
fn sync_names(storage: &dyn Storage, path: &Path) -> io::Result<()> {
    for around in path.ancestors().skip(1) {
        let around = if around.as_os_str().is_empty() { Path::new(".") } else { around };
        let _ = storage.sync_folder(around);
    }
    storage.sync_folder(path)
}

/// The content of the folder of the worlds under this name; `None` if it needs no attention.
fn look_at(storage: &dyn Storage, path: &Path, name: &str) -> Option<Found> {
    let kind = storage.kind(path);
    if file_names::is_deleted(name) && matches!(kind, Ok(Kind::Folder)) {
        // The server was killed before it was gone.
        if let Err(error) = storage.remove_folder(path) {
            tracing::warn!(folder = %path.display(), %error, "the state of a deleted world cannot be removed");
        }
        return None;
    }
    // The names of folders that were set aside have a dot.
    if name.contains('.') {
        return None;
    }
    let ignored = |problem| Some(Found::Ignored { path: path.to_owned(), problem });
    match kind {
        Err(error) => Some(unreadable(name, path, JournalError::from(error).to_string())),
        Ok(Kind::File | Kind::Other) => ignored("is not a folder"),
        Ok(Kind::Folder) if !file_names::is_world(name) => ignored("has a name that no world can have"),
        Ok(Kind::Folder) => world(storage, name, path),
    }
}

fn world(storage: &dyn Storage, name: &str, folder: &Path) -> Option<Found> {
    match kept::read(storage, name, folder) {
        Ok(Some(world)) => Some(Found::World(Box::new(world))),
        Ok(None) => {
            // If it cannot be removed, the next start attempts it again.
            let _ =
                file_names::remove_unfinished(storage, folder).and_then(|()| storage.remove_folder(folder));
            None
        }
        Err((file, problem @ Problem::Journal(JournalError::Io(_)))) => {
            Some(unreadable(name, &file, problem.to_string()))
        }
        Err((file, problem)) => Some(set_aside(storage, name, folder, file, &problem)),
    }
}

fn set_aside(storage: &dyn Storage, name: &str, folder: &Path, file: PathBuf, problem: &Problem) -> Found {
    let to = file_names::damaged(storage, folder);
    if let Err(error) = storage.rename(folder, &to) {
        return unreadable(name, &file, format!("{problem}, and the folder cannot be set aside: {error}"));
    }
    let problem = problem.to_string();
    tracing::error!(world = name, file = %file.display(), problem, to = %to.display(), "world set aside");
    Found::SetAside { name: name.to_owned(), file, problem, to }
}

fn unreadable(name: &str, file: &Path, problem: String) -> Found {
    tracing::error!(world = name, file = %file.display(), problem, "world left unchanged");
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

/// The file that marks the folder, and that a server locks.
const MARKER: &str = "baudbot-state";

const WORLDS: &str = "worlds";
const RECORDINGS: &str = "recordings";

fn layout() -> String {
    format!("baudbot-state {LAYOUT}\n")
}
