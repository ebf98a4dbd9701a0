//! Reading whole files of limited size.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::error::FileError;

/// The bytes of a file. What is not a plain file is refused: a pipe may have no end, or never begin.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let unreadable = |error: io::Error| {
        if error.kind() == io::ErrorKind::NotFound {
            return FileError::new(path, "there is no such file");
        }
        FileError::new(path, format!("cannot be read: {error}"))
    };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(FileError::new(path, "is not a file"));
    }
    let too_long =
        |bytes: u64| FileError::new(path, format!("has {bytes} bytes or more, the limit is {MAX_BYTES}"));
    if metadata.len() > MAX_BYTES {
        return Err(too_long(metadata.len()));
    }
    let mut bytes = Vec::new();
    // The file may grow while it is read.
    let mut file = File::open(path).map_err(unreadable)?.take(MAX_BYTES + 1);
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES { Err(too_long(bytes.len() as u64)) } else { Ok(bytes) }
}

/// The text of a file.
#[cfg(feature = "maps")]
pub(crate) fn text(path: &Path) -> Result<String, FileError> {
    String::from_utf8(bytes(path)?).map_err(|_| FileError::new(path, "is not text in UTF-8"))
}

const MAX_BYTES: u64 = 256 << 20;
