//! Systems without users, links and descriptors, as a browser: the files are the program's own.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use tonic::Status;

/// Raises the process' limit of open files; there is none.
pub fn raise_descriptor_limit() {}

/// The limit of connections of a server by default.
pub(crate) fn usual_connections() -> usize {
    1024
}

/// Journals that may stay open between two writes.
pub(crate) fn most_journals() -> usize {
    1024
}

/// Whether a file that has just been opened leaves those to others that are theirs.
pub(crate) fn leaves_room(_: &File) -> bool {
    true
}

/// Whether this is the user who runs the server.
pub(crate) fn is_this_user(_: u32) -> bool {
    false
}

/// Opens a file for reading.
///
/// # Errors
/// If it cannot be opened.
pub(crate) fn open_plain_file(path: &Path) -> io::Result<Option<File>> {
    File::open(path).map(Some)
}

/// Opens a file for appending.
///
/// # Errors
/// If it cannot be opened.
pub(crate) fn open_private_log(path: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).create(true).open(path)
}

/// Does work that takes long. There are no threads: everything else waits for it.
///
/// # Errors
/// None.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Status> {
    Ok(work())
}
