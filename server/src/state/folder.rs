//! The folder in which a server keeps its state.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::journal::JournalError;
use baudbot_sim::Scenario;

use super::files::WorldFiles;
use super::keeper::{Keeper, Now};
use super::kept::{self, Found};
use super::threads::Threads;
use super::{LAYOUT, file_names};

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
        fs::create_dir_all(path).map_err(at(path))?;
        let marker = path.join(MARKER);
        if !marker.exists() && fs::read_dir(path).map_err(at(path))?.next().is_some() {
            return Err(StateError::Foreign(path.to_owned()));
        }
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&marker);
        let mut file = options.map_err(at(&marker))?;
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
            fs::create_dir_all(&folder).map_err(at(&folder))?;
        }
        let threads = Threads::start().map_err(at(path))?;
        Ok(Self(Arc::new(Inner { path: path.to_owned(), threads, _marker: file })))
    }

    /// Where recordings go, unless another folder is named for them.
    pub fn recordings(&self) -> PathBuf {
        self.0.path.join(RECORDINGS)
    }

    /// The worlds that are there, in the order of their names. One that cannot be used is set aside.
    ///
    /// # Errors
    /// If something cannot be read or written, which is no fault of a file's content.
    pub fn worlds(&self) -> Result<Vec<Found>, StateError> {
        let path = self.0.path.join(WORLDS);
        let at = |path: &Path| {
            let path = path.to_owned();
            move |source| StateError::Io { path, source }
        };
        let mut found = Vec::new();
        let mut names = Vec::new();
        for entry in fs::read_dir(&path).map_err(at(&path))? {
            names.extend(entry.map_err(at(&path))?.file_name().to_str().map(str::to_owned));
        }
        names.sort_unstable();
        for name in names {
            let folder = path.join(&name);
            if name.contains(".deleted") {
                fs::remove_dir_all(&folder).map_err(at(&folder))?;
            }
            // Those that were set aside have a dot.
            if name.contains('.') {
                continue;
            }
            found.extend(self.world(name, &folder)?);
        }
        Ok(found)
    }

    fn world(&self, name: String, folder: &Path) -> Result<Option<Found>, StateError> {
        let io = |path: &Path, source| StateError::Io { path: path.to_owned(), source };
        match kept::read(&name, folder) {
            Ok(Some(world)) => Ok(Some(Found::World(Box::new(world)))),
            Ok(None) => {
                // The server was killed before it had said that the world is there.
                fs::remove_dir_all(folder).map_err(|error| io(folder, error))?;
                Ok(None)
            }
            Err((file, JournalError::Io(error))) => Err(io(&file, error)),
            Err((file, problem)) => {
                let to = file_names::free(&folder.with_extension("damaged"));
                fs::rename(folder, &to).map_err(|error| io(folder, error))?;
                let problem = problem.to_string();
                tracing::error!(world = name, file = %file.display(), problem, to = %to.display(), "world set aside");
                Ok(Some(Found::SetAside { name, file, problem, to }))
            }
        }
    }

    /// Keeps a world from now on. `made`: the scenario with which it was made.
    pub(crate) fn keep(&self, made: Arc<Scenario>, now: &Now<'_>) -> Keeper {
        let folder = self.0.path.join(WORLDS).join(now.name);
        Keeper::new(WorldFiles::new(folder, self.0.threads.clone()), made, now)
    }
}

/// The file that says what the folder is, and that a server locks.
const MARKER: &str = "baudbot-state";

const WORLDS: &str = "worlds";
const RECORDINGS: &str = "recordings";

fn layout() -> String {
    format!("baudbot-state {LAYOUT}\n")
}
