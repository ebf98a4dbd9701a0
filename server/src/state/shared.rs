//! The shared state of all worlds' files.

use std::io;
use std::path::Path;
use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::file_names;
use super::storage::{Storage, Stored};
use super::threads::Threads;

/// The shared state of all worlds' files. Clones are the same.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    pub(super) storage: Arc<dyn Storage>,
    pub(super) threads: Threads,
    /// Places for journals that are open: a process may have so many open files, and worlds are not to take those that connections
    /// and the file of tokens need. Beyond these a journal is open only while something is written to it.
    pub(super) places: Arc<Semaphore>,
}

impl Shared {
    /// A place for a journal that stays open, if one is free.
    pub(super) fn place(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.places).try_acquire_owned().ok()
    }
}

/// Writes a file that is there whole or not at all, should the program be killed meanwhile.
pub(super) fn write_whole(storage: &dyn Storage, path: &Path, bytes: &[u8]) -> io::Result<Box<dyn Stored>> {
    let new = path.with_extension(file_names::UNFINISHED);
    let written = storage.write(&new, bytes);
    written.and_then(|file| storage.rename(&new, path).map(|()| file)).inspect_err(|_| {
        let _ = storage.remove_file(&new);
    })
}
