//! A recording's file: its length, and its behaviour on a full disk.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file that is written to its end or, if that fails, cut off behind what was whole.
pub struct RecordingFile {
    file: File,
    bytes: Arc<AtomicU64>,
    failed: bool,
}

impl RecordingFile {
    /// Makes a file where there is none.
    ///
    /// # Errors
    /// If it cannot be made, or is there.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).create_new(true).open(path)?;
        Ok(Self { file, bytes: Arc::default(), failed: false })
    }

    /// The file itself.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Bytes that are in the file, now and later.
    pub fn length(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.bytes)
    }

    /// Nothing is written any more.
    pub(crate) fn close(&mut self) {
        self.failed = true;
    }
}

impl Write for RecordingFile {
    /// All or nothing: what is in the file in part is taken back.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failed {
            // Nothing may follow where something is missing.
            return Err(io::Error::other("the recording has ended"));
        }
        if let Err(error) = self.file.write_all(bytes) {
            self.failed = true;
            let _ = self.file.set_len(self.bytes.load(Ordering::Relaxed));
            return Err(error);
        }
        self.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for RecordingFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.seek(position)
    }
}
