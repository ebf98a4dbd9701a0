//! Opening of files that users name, without a wait for ever: a pipe may have no writer.

use std::fs::{File, OpenOptions};
use std::io::{self, Cursor, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

/// Opens a plain file.
///
/// # Errors
/// If it cannot be opened, or is something else.
pub fn plain(path: &Path) -> io::Result<File> {
    let file = at_once(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::Error::other("is not a file")) }
}

/// Opens a file, a pipe or a device.
///
/// # Errors
/// If it cannot be opened; if it is a pipe that has no writer for two seconds.
pub fn any(path: &Path) -> io::Result<impl Read> {
    let mut file = at_once(path)?;
    let first = if file.metadata()?.file_type().is_fifo() { first_byte(&mut file)? } else { Vec::new() };
    fcntl_setfl(&file, fcntl_getfl(&file)? - OFlags::NONBLOCK)?;
    Ok(Cursor::new(first).chain(file))
}

/// Opens it without waiting, and so that reads do not block.
fn at_once(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).custom_flags(OFlags::NONBLOCK.bits().cast_signed()).open(path)
}

/// The first byte of a pipe; none if its writer has yet to write one.
fn first_byte(pipe: &mut File) -> io::Result<Vec<u8>> {
    let deadline = Instant::now() + PATIENCE;
    let mut byte = [0];
    loop {
        match pipe.read(&mut byte) {
            // A pipe without a writer is at its end.
            Ok(0) if Instant::now() < deadline => thread::sleep(INTERVAL),
            Ok(0) => return Err(io::Error::other("is a pipe that no program writes to")),
            Ok(_) => return Ok(byte.to_vec()),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(Vec::new()),
            Err(error) => return Err(error),
        }
    }
}

/// The time for which a pipe may have no writer: a program that was started beside this one may take a moment.
const PATIENCE: Duration = Duration::from_secs(2);

const INTERVAL: Duration = Duration::from_millis(10);
