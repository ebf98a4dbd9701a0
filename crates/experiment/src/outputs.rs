//! The folder of a sweep: one sweep at a time, and files that are there as a whole or not at all.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::ids;

/// A folder that belongs to this sweep while this value lives, even if the program is killed meanwhile.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    _lock: File,
    id: String,
}

impl Folder {
    /// Makes the folder if need be, and takes hold of it.
    pub(crate) fn take(path: &Path) -> Result<Self, Error> {
        fs::create_dir_all(path).map_err(Error::file("make the folder", path))?;
        let at = path.join(LOCK);
        let lock = File::options().read(true).write(true).create(true).truncate(false).open(&at);
        let mut lock = lock.map_err(Error::file("write", &at))?;
        match lock.try_lock() {
            Ok(()) => {
                let id = id_in(&mut lock).map_err(Error::file("read or write", &at))?;
                let no_lock = || {
                    let at = at.display();
                    Error::Refused(format!(
                        "{at} does not belong to an experiment; choose another place with --out DIR"
                    ))
                };
                Ok(Self { path: path.to_owned(), _lock: lock, id: id.ok_or_else(no_lock)? })
            }
            Err(TryLockError::WouldBlock) => Err(Error::Refused(format!(
                "another experiment is writing into {}; wait until it ends, or choose another place with --out DIR",
                path.display()
            ))),
            Err(TryLockError::Error(cause)) => Err(Error::file("lock", &at)(cause)),
        }
    }

    /// The folder's own id: random, and the same whenever a sweep resumes here. It distinguishes the worlds on a server
    /// that are of this sweep from all others.
    pub(crate) fn id(&self) -> &str {
        &self.id
    }

    /// The path of a file of this name.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Removes a file if it is there.
    pub(crate) fn remove(&self, name: &str) -> Result<(), Error> {
        let path = self.file(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Error::file("remove", &path)(error)),
            _ => Ok(()),
        }
    }

    /// Writes a file that is there as a whole or not at all.
    pub(crate) fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Content>,
    ) -> Result<(), Error> {
        write_whole(&self.file(name), &self.file(&format!(".{name}.tmp")), content)
    }
}

/// Writes a file beside its place and then puts it there.
pub(crate) fn write_whole(
    path: &Path,
    beside: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Content>,
) -> Result<(), Error> {
    let write = || -> Result<(), Content> {
        let mut out = BufWriter::new(File::create(beside)?);
        content(&mut out)?;
        out.flush()?;
        out.get_ref().sync_all()?;
        Ok(fs::rename(beside, path)?)
    };
    write().map_err(|error| match error {
        Content::Own(error) => error,
        Content::Io(cause) => {
            let _ = fs::remove_file(beside);
            Error::file("write", path)(cause)
        }
    })
}

/// The id in a lock, which gets one if it has none, or a torn one; `None` if something else is in it.
fn id_in(lock: &mut File) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    lock.take(64).read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    if ids::is_id(&text) {
        return Ok(Some(text.into_owned()));
    }
    if !ids::is_start_of_id(&text) {
        return Ok(None);
    }
    let id = ids::random_id();
    lock.rewind()?;
    lock.write_all(id.as_bytes())?;
    lock.sync_all()?;
    Ok(Some(id))
}

/// The reason why a file has no content: it could not be written, or there was nothing to write.
#[derive(Debug)]
pub(crate) enum Content {
    Io(io::Error),
    Own(Error),
}

impl From<io::Error> for Content {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<Error> for Content {
    fn from(error: Error) -> Self {
        Self::Own(error)
    }
}

/// The lock of a sweep's folder.
const LOCK: &str = ".lock";
