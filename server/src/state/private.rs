//! Folders and files for this user only: a state has all that is true in its world.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// Makes a folder, and those above it, if it is not there. One that is there keeps its mode.
pub(super) fn make_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(path)
}

/// Opens a file for reading and writing, which is made if it is not there. One that is there keeps its content and its mode.
pub(super) fn open(path: &Path) -> io::Result<File> {
    made().read(true).truncate(false).open(path)
}

/// Writes a file, to which more can be added, in place of what an earlier attempt may have left.
pub(super) fn write(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let mut file = made().truncate(true).open(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

fn made() -> OpenOptions {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.write(true).create(true);
    options
}
