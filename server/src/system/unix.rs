//! Unix: how many files and connections the process may have open at a time, users, links.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
#[cfg(feature = "network")]
use std::os::unix::fs::MetadataExt;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::process::{Resource, Rlimit, geteuid, getrlimit, setrlimit};
use tokio::task::spawn_blocking;
use tonic::Status;

use super::descriptors::Descriptors;

/// Raises the process' limit of open files, connections included, to the highest that the system allows. A server that is to
/// have many should do this first.
pub fn raise_descriptor_limit() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current != maximum {
        // If that is not allowed, the limit stays, and the server has fewer connections.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    }
}

fn descriptors() -> Descriptors {
    Descriptors::of(getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX))
}

/// The most connections of a server, and the default of its limit.
pub(crate) fn usual_connections() -> usize {
    descriptors().connections
}

/// Journals that may stay open between two writes.
pub(crate) fn most_journals() -> usize {
    descriptors().journals
}

/// Whether a file that has just been opened leaves those to others that are theirs: the system gives the least number that is free.
pub(crate) fn leaves_room(file: &File) -> bool {
    usize::try_from(file.as_raw_fd()).is_ok_and(|number| number < descriptors().recordings_below)
}

/// Whether this is the user who runs the server.
pub(crate) fn is_this_user(uid: u32) -> bool {
    uid == geteuid().as_raw()
}

/// Opens a file for reading, but no link, and without waiting, as opening a pipe may; `None` for what is no file.
///
/// # Errors
/// If it cannot be opened.
pub(crate) fn open_plain_file(path: &Path) -> io::Result<Option<File>> {
    let flags = OFlags::RDONLY | OFlags::CLOEXEC | OFlags::NOFOLLOW | OFlags::NONBLOCK;
    match rustix::fs::open(path, flags, Mode::empty()) {
        Ok(file) => Ok(Some(File::from(file))),
        Err(Errno::LOOP | Errno::NXIO) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Whether other users of this machine, besides those of the file's group, can read a file.
#[cfg(feature = "network")]
pub(crate) fn everybody_can_read(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| metadata.mode() & 0o004 != 0)
}

/// Opens a file for appending, which is made with mode 0600 if it is not there.
///
/// # Errors
/// If it cannot be opened, or is a pipe: opening that waits for a reader.
pub(crate) fn open_private_log(path: &Path) -> io::Result<File> {
    if path.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo()) {
        let problem = "is a pipe, which may block the server; name a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    OpenOptions::new().append(true).create(true).mode(0o600).open(path)
}

/// Does work that takes long on a thread of its own, while other calls go on.
///
/// # Errors
/// `INTERNAL` if the work panics.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Status> {
    spawn_blocking(work).await.map_err(|error| Status::internal(error.to_string()))
}
