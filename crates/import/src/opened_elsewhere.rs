//! Opening of files that users name, where there are neither pipes nor devices, as in a browser.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Opens a plain file.
///
/// # Errors
/// If it cannot be opened.
pub fn plain(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// Opens a file.
///
/// # Errors
/// If it cannot be opened.
pub fn any(path: &Path) -> io::Result<impl Read> {
    File::open(path)
}
