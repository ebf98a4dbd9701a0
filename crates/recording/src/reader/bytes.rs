//! The bytes of a file, with lookahead: they can be examined before they are consumed.

use std::io::{self, Read};

use crc32fast::Hasher;

/// The bytes of a file that have been read and not been taken yet. It grows with what the file gives, and not with what
/// is asked for.
pub(super) struct Bytes<R> {
    file: R,
    read: Vec<u8>,
    /// The number of those that are taken.
    taken: usize,
    /// The number of bytes of the file that have been taken.
    place: u64,
    is_at_end: bool,
    hasher: Hasher,
}

impl<R: Read> Bytes<R> {
    pub(super) fn new(file: R) -> Self {
        Self { file, read: Vec::new(), taken: 0, place: 0, is_at_end: false, hasher: Hasher::new() }
    }

    /// The next so many bytes, or as many as there are.
    pub(super) fn peek(&mut self, n: usize) -> io::Result<&[u8]> {
        let has = self.read.len() - self.taken;
        if has < n && !self.is_at_end {
            // Taken bytes make room once they are most of what is held.
            if self.taken > has {
                self.read.drain(..self.taken);
                self.taken = 0;
            }
            let lacking = (n - has).max(AT_ONCE) as u64;
            let got = self.file.by_ref().take(lacking).read_to_end(&mut self.read)?;
            self.is_at_end = (got as u64) < lacking;
        }
        let until = self.read.len().min(self.taken.saturating_add(n));
        Ok(&self.read[self.taken..until])
    }

    /// The bytes that have been read ahead, at least one unless the file is over.
    pub(super) fn ahead(&mut self) -> io::Result<&[u8]> {
        self.peek(1)?;
        Ok(&self.read[self.taken..])
    }

    /// Consumes bytes that have been examined.
    pub(super) fn take(&mut self, n: usize) {
        let until = self.read.len().min(self.taken + n);
        self.hasher.update(&self.read[self.taken..until]);
        self.place += (until - self.taken) as u64;
        self.taken = until;
    }

    /// The number of bytes of the file that have been taken.
    pub(super) fn place(&self) -> u64 {
        self.place
    }

    /// The CRC of all that has been taken since this was last asked.
    pub(super) fn checksum(&mut self) -> u32 {
        std::mem::take(&mut self.hasher).finalize()
    }
}

/// The least that is read at once.
const AT_ONCE: usize = 64 << 10;
