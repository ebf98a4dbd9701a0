//! The output of a program: the end of it is kept, whatever its length.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_fields::printable::Printable;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, stderr};

use crate::programs::task::Output;

/// The end of what a program has printed to its standard output and its standard error.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept(Arc<Mutex<Text>>);

#[derive(Debug, Default)]
struct Text {
    end: VecDeque<u8>,
    /// Bytes that are no longer kept.
    dropped: u64,
    has_traceback: bool,
    /// Lines of its standard output, without those with which baudbot's own packages end a run.
    printed: u64,
}

/// The stream of a program that something was printed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum From {
    StandardOutput,
    StandardError,
}

impl Kept {
    /// Reads until the program closes the stream.
    pub(crate) async fn read(self, mut stream: impl AsyncRead + Unpin, from: From, output: Output) {
        let (mut buffer, mut line) = (vec![0; 16 << 10], Vec::new());
        loop {
            match stream.read(&mut buffer).await {
                Ok(0) | Err(_) => return,
                Ok(n) => {
                    self.take(&buffer[..n], &mut line, from);
                    if output == Output::Shown {
                        // The write fails if stderr is closed, and then its text is not needed.
                        let _ = stderr().write_all(&buffer[..n]).await;
                    }
                }
            }
        }
    }

    /// `line` is the beginning of this stream's current line.
    fn take(&self, bytes: &[u8], line: &mut Vec<u8>, from: From) {
        let mut text = self.text();
        text.end.extend(bytes);
        let over = text.end.len().saturating_sub(MOST_BYTES);
        text.end.drain(..over);
        text.dropped += over as u64;
        for &byte in bytes {
            if byte == b'\n' {
                text.printed += u64::from(from == From::StandardOutput && !line.starts_with(END_OF_A_RUN));
                line.clear();
            } else if line.len() < TRACEBACK.len() {
                line.push(byte);
                text.has_traceback |= line.as_slice() == TRACEBACK;
            }
        }
    }

    /// The number of lines of its standard output, without those with which baudbot's own packages end a run.
    pub(crate) fn printed(&self) -> u64 {
        self.text().printed
    }

    /// Whether an exception of Python's was printed.
    pub(crate) fn has_traceback(&self) -> bool {
        self.text().has_traceback
    }

    /// The last lines, without what a terminal would obey.
    pub(crate) fn last_lines(&self) -> Vec<String> {
        let text = self.text();
        let bytes: Vec<u8> = text.end.iter().copied().collect();
        let whole = String::from_utf8_lossy(&bytes);
        let lines: Vec<_> = whole.lines().collect();
        let first = lines.len().saturating_sub(MOST_LINES);
        let mut shown: Vec<_> = lines[first..].iter().map(|line| Printable(line).to_string()).collect();
        if first > 0 || text.dropped > 0 {
            shown.insert(0, "…".to_owned());
        }
        shown
    }

    fn text(&self) -> MutexGuard<'_, Text> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

const TRACEBACK: &[u8] = b"Traceback (most recent call last):";

/// The beginning of the last line of a program that uses one of baudbot's packages.
const END_OF_A_RUN: &[u8] = b"the run is over";

/// The bytes of a program's output that are kept.
const MOST_BYTES: usize = 64 << 10;

/// The lines of those that are shown.
const MOST_LINES: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_but_for_the_last_one_of_baudbots_packages() {
        let (kept, mut line) = (Kept::default(), Vec::new());
        kept.take(b"here\nthe run", &mut line, From::StandardOutput);
        kept.take(b" is over after 12 turns\nand\nthere", &mut line, From::StandardOutput);
        kept.take(b"oh\n", &mut Vec::new(), From::StandardError);
        assert_eq!(kept.printed(), 2);
    }

    #[test]
    fn the_end_is_kept_and_a_traceback_is_seen_across_pieces() {
        let (kept, mut line) = (Kept::default(), Vec::new());
        for _ in 0..10_000 {
            kept.take(b"0123456789\n", &mut line, From::StandardOutput);
        }
        assert!(!kept.has_traceback());
        kept.take(
            b"say Traceback (most recent call last):\nTraceback (most re",
            &mut line,
            From::StandardOutput,
        );
        assert!(!kept.has_traceback());
        kept.take(b"cent call last):\n\x1b[2Jend", &mut line, From::StandardOutput);
        assert!(kept.has_traceback());
        let lines = kept.last_lines();
        assert_eq!(lines.len(), MOST_LINES + 1);
        assert_eq!((lines[0].as_str(), lines[MOST_LINES].as_str()), ("…", "\\u{1b}[2Jend"));
        assert!(kept.text().end.len() <= MOST_BYTES);
    }
}
