//! The folder for temporary files of all programs that sections start, so that none of them stays behind.

use std::io::{Error, ErrorKind};
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};

/// A folder of its own, which is removed when this is dropped.
pub(crate) struct Temporary(PathBuf);

impl Temporary {
    /// One that nobody else has. Its name is short, as the paths of sockets may not be long.
    ///
    /// # Errors
    ///
    /// It cannot be made.
    pub(crate) fn new() -> Result<Self, (PathBuf, Error)> {
        let mut builder = std::fs::DirBuilder::new();
        builder.mode(0o700);
        let mut n = 0_u32;
        loop {
            let folder = std::env::temp_dir().join(format!("bt-{}-{n}", std::process::id()));
            match builder.create(&folder) {
                Ok(()) => return Ok(Self(folder)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => n += 1,
                Err(error) => return Err((folder, error)),
            }
        }
    }

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            eprintln!("{} stays behind: {error}", self.0.display());
        }
    }
}
