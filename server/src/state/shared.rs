//! What the files of all worlds have in common.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::file_names;
use super::storage::{Storage, Stored};
use super::threads::Threads;

/// What the files of all worlds have in common. Clones are the same.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    pub(super) storage: Arc<dyn Storage>,
    pub(super) threads: Threads,
    pub(super) journals: Arc<OpenJournals>,
}

/// The journals that are open at a time: a process may have so many open files, and worlds are not to take those that connections
/// and the file of tokens need. Beyond these a journal is open only while something is written to it.
#[derive(Debug)]
pub(super) struct OpenJournals {
    open: AtomicUsize,
    most: usize,
}

/// A journal may stay open as long as this lives.
#[derive(Debug)]
pub(super) struct Place(Arc<OpenJournals>);

impl OpenJournals {
    pub(super) fn new(most: usize) -> Self {
        Self { open: AtomicUsize::new(0), most }
    }

    /// A place, if one is free.
    pub(super) fn place(self: &Arc<Self>) -> Option<Place> {
        if self.open.fetch_add(1, Ordering::Relaxed) < self.most {
            return Some(Place(Arc::clone(self)));
        }
        self.open.fetch_sub(1, Ordering::Relaxed);
        None
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.open.fetch_sub(1, Ordering::Relaxed);
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
