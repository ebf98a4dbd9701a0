//! The output of a program: its beginning and its end are kept, whatever its length. Some languages name the cause of a failure
//! first, and others last.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_fields::printable::PrintableLines;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, stderr};

use crate::programs::task::Output;

/// The beginning and the end of what a program has printed to its standard output and its standard error.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept(Arc<Mutex<Text>>);

#[derive(Debug, Default)]
struct Text {
    beginning: Vec<u8>,
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

    /// The same for the thread that calls this.
    pub(crate) fn read_here(self, mut stream: impl std::io::Read, from: From, output: Output) {
        let (mut buffer, mut line) = (vec![0; 16 << 10], Vec::new());
        loop {
            match stream.read(&mut buffer) {
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Ok(0) | Err(_) => return,
                Ok(n) => {
                    self.take(&buffer[..n], &mut line, from);
                    if output == Output::Shown {
                        // As above.
                        let _ = std::io::Write::write_all(&mut std::io::stderr(), &buffer[..n]);
                    }
                }
            }
        }
    }

    /// `line` is the beginning of this stream's current line.
    fn take(&self, bytes: &[u8], line: &mut Vec<u8>, from: From) {
        let mut text = self.text();
        let room = BEGINNING_BYTES.saturating_sub(text.beginning.len());
        text.beginning.extend(bytes.iter().take(room));
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

    /// The first and the last lines, without what a terminal would obey but tabs. A line `…` stands for those between them.
    pub(crate) fn lines(&self) -> Vec<String> {
        let text = self.text();
        let end: Vec<u8> = text.end.iter().copied().collect();
        let last = lines_of(&end);
        if text.dropped == 0 && last.len() <= FIRST_LINES + LAST_LINES {
            return last;
        }
        // Of what is longer than the beginning that is kept, its last line may be a part of one.
        let whole = text.beginning.iter().rposition(|&byte| byte == b'\n').unwrap_or(text.beginning.len());
        let first = lines_of(&text.beginning[..whole]).into_iter().take(FIRST_LINES);
        let last = &last[last.len().saturating_sub(LAST_LINES)..];
        first.chain(std::iter::once("…".to_owned())).chain(last.iter().cloned()).collect()
    }

    fn text(&self) -> MutexGuard<'_, Text> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn lines_of(bytes: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(bytes).lines().map(|line| PrintableLines(line).to_string()).collect()
}

const TRACEBACK: &[u8] = b"Traceback (most recent call last):";

/// The beginning of the last line of a program that uses one of baudbot's packages.
const END_OF_A_RUN: &[u8] = b"the run is over";

/// The bytes of the end of a program's output that are kept.
const MOST_BYTES: usize = 64 << 10;

/// The bytes of its beginning.
const BEGINNING_BYTES: usize = 8 << 10;

/// The lines of the beginning that are shown.
const FIRST_LINES: usize = 8;

/// The lines of the end.
const LAST_LINES: usize = 12;

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
        let lines = kept.lines();
        assert_eq!(lines.len(), FIRST_LINES + 1 + LAST_LINES);
        assert_eq!((lines[0].as_str(), lines[FIRST_LINES].as_str()), ("0123456789", "…"));
        assert_eq!(lines[FIRST_LINES + LAST_LINES], "\\u{1b}[2Jend");
        assert!(kept.text().end.len() <= MOST_BYTES && kept.text().beginning.len() <= BEGINNING_BYTES);
    }

    #[test]
    fn the_cause_that_stands_first_is_shown_with_its_tabs() {
        let kept = Kept::default();
        kept.take(b"panic: no reading\n\ngoroutine 1:\n\tmain.go:12\n", &mut Vec::new(), From::StandardError);
        assert_eq!(kept.lines(), ["panic: no reading", "", "goroutine 1:", "\tmain.go:12"]);
        for number in 5..=40 {
            kept.take(format!("line {number}\n").as_bytes(), &mut Vec::new(), From::StandardError);
        }
        let lines = kept.lines();
        assert_eq!(lines[..4], ["panic: no reading", "", "goroutine 1:", "\tmain.go:12"]);
        assert_eq!(lines[FIRST_LINES - 1..=FIRST_LINES + 1], ["line 8", "…", "line 29"]);
        assert_eq!(lines.last().map(String::as_str), Some("line 40"));
    }
}
