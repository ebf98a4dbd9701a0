//! The file of the audit log, and the thread that writes it.

use std::io::{self, Write};
use std::num::NonZeroU8;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Serialize;
use time::OffsetDateTime;
use time::format_description::well_known::Iso8601;
use time::format_description::well_known::iso8601::{Config, EncodedConfig, TimePrecision};

use crate::log::Throttle;
use crate::system::open_private_log;

/// Lines that wait for the disk, at most; more are counted and lost.
const WAITING: usize = 65_536;

/// Refusals that have a line each second.
const REFUSALS_A_SECOND: u32 = 20;

/// The time for which a line that could not be written waits for its next attempt.
const PAUSE: Duration = Duration::from_millis(500);

/// The time for which the end of the program waits for the disk.
const PATIENCE: Duration = Duration::from_secs(2);

/// The audit log of a server: lines of JSON, which are appended to a file. Clones write to the same file.
#[derive(Clone)]
pub struct AuditLog(Arc<Shared>);

struct Shared {
    lines: Option<SyncSender<String>>,
    thread: Option<JoinHandle<()>>,
    lost: Arc<AtomicU64>,
    refusals: Mutex<Refusals>,
}

/// Refusals of the present second: wrong tokens must not fill the disk.
#[derive(Default)]
struct Refusals {
    since: Option<Instant>,
    told: u32,
}

impl AuditLog {
    /// Opens a file for it, which is made with mode 0600 if it is not there. What is in it stays.
    ///
    /// # Errors
    /// If it cannot be opened for appending, or there is no thread for it.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::into_file(open_private_log(path)?)
    }

    fn into_file(file: impl Write + Send + 'static) -> io::Result<Self> {
        let (lines, waiting) = sync_channel(WAITING);
        let lost = Arc::default();
        let own = Arc::clone(&lost);
        let thread = thread::Builder::new().name("audit".to_owned());
        let thread = thread.spawn(move || write_all(file, &waiting, &own))?;
        Ok(Self(Arc::new(Shared {
            lines: Some(lines),
            thread: Some(thread),
            lost,
            refusals: Mutex::default(),
        })))
    }

    /// Appends a line, without waiting for the disk.
    pub(crate) fn append(&self, line: &impl Serialize) {
        let Some(lines) = &self.0.lines else { return };
        let text = serde_json::to_string(line).expect("lines have texts and numbers only");
        if let Err(TrySendError::Full(_)) = lines.try_send(text + "\n") {
            self.0.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Notes what happens to the server itself.
    pub(crate) fn note(&self, event: &'static str, text: &str) {
        self.append(&Note { at: now(), event, text });
    }

    /// Whether a refusal is logged now. Those that are not are counted as lost.
    pub(super) fn tells_refusal(&self, now: Instant) -> bool {
        let mut refusals = self.0.refusals.lock().unwrap_or_else(PoisonError::into_inner);
        if refusals.since.is_none_or(|since| now.saturating_duration_since(since) >= Duration::from_secs(1)) {
            *refusals = Refusals { since: Some(now), told: 0 };
        }
        let tells = refusals.told < REFUSALS_A_SECOND;
        if tells {
            refusals.told += 1;
        } else {
            self.0.lost.fetch_add(1, Ordering::Relaxed);
        }
        tells
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.lines = None;
        let Some(thread) = self.thread.take() else { return };
        let until = Instant::now() + PATIENCE;
        while !thread.is_finished() && Instant::now() < until {
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// An event of the server.
#[derive(Serialize)]
struct Note<'a> {
    at: String,
    event: &'static str,
    text: &'a str,
}

/// The line for lost lines.
#[derive(Serialize)]
struct Lost {
    at: String,
    event: &'static str,
    lines: u64,
}

/// Writes lines until all senders are gone. A line that cannot be written is tried again.
fn write_all(mut file: impl Write, lines: &Receiver<String>, lost: &AtomicU64) {
    let failures = Throttle::default();
    while let Ok(line) = lines.recv() {
        write_at_last(&mut file, &line, &failures);
        let count = lost.swap(0, Ordering::Relaxed);
        if count > 0 {
            let line = Lost { at: now(), event: "lost", lines: count };
            let text = serde_json::to_string(&line).expect("it has texts and a number");
            write_at_last(&mut file, &(text + "\n"), &failures);
        }
    }
}

fn write_at_last(file: &mut impl Write, line: &str, failures: &Throttle) {
    let mut rest = line.as_bytes();
    while !rest.is_empty() {
        match file.write(rest) {
            Ok(written) if written > 0 => rest = &rest[written..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            problem => {
                if failures.note(Instant::now()).is_some() {
                    let error = problem
                        .err()
                        .map_or_else(|| "it takes no bytes".to_owned(), |error| error.to_string());
                    tracing::error!(error, "the audit log cannot be written; its lines wait");
                }
                thread::sleep(PAUSE);
            }
        }
    }
}

/// RFC 3339, with three digits after the second.
const MILLISECONDS: EncodedConfig =
    Config::DEFAULT.set_time_precision(TimePrecision::Second { decimal_digits: NonZeroU8::new(3) }).encode();

/// The present instant for a line: in UTC, to the millisecond.
pub(super) fn now() -> String {
    at(OffsetDateTime::now_utc())
}

/// Lines sort by their instants as texts, so all have as many digits.
fn at(instant: OffsetDateTime) -> String {
    instant.format(&Iso8601::<MILLISECONDS>).expect("the present has a year of four digits")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_have_three_digits_after_the_second() {
        let instant = |nanos| OffsetDateTime::from_unix_timestamp_nanos(nanos).unwrap();
        assert_eq!(at(instant(0)), "1970-01-01T00:00:00.000Z");
        assert_eq!(at(instant(1_350_999_999)), "1970-01-01T00:00:01.350Z");
    }

    /// A disk that is full for its first attempts, and then takes three bytes at a time.
    struct Full {
        attempts: u32,
        taken: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.attempts += 1;
            if self.attempts <= 2 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let count = bytes.len().min(3);
            self.taken.lock().unwrap().extend_from_slice(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn lines_wait_for_a_disk_that_is_full() {
        let taken = Arc::default();
        let log = AuditLog::into_file(Full { attempts: 0, taken: Arc::clone(&taken) }).unwrap();
        log.append(&"first");
        log.append(&"second");
        drop(log);
        assert_eq!(*taken.lock().unwrap(), b"\"first\"\n\"second\"\n");
    }

    #[test]
    fn refusals_have_twenty_lines_a_second_and_the_others_are_counted() {
        let log = AuditLog::into_file(io::sink()).unwrap();
        let start = Instant::now();
        let told =
            |after: u64| (0..50).filter(|_| log.tells_refusal(start + Duration::from_millis(after))).count();
        assert_eq!([told(0), told(999), told(1000)], [20, 0, 20]);
        assert_eq!(log.0.lost.load(Ordering::Relaxed), 110);
    }

    #[test]
    fn instants_are_those_of_rfc_3339_to_the_millisecond() {
        let now = now();
        assert!(OffsetDateTime::parse(&now, &Iso8601::DEFAULT).is_ok() && now.ends_with('Z'), "{now}");
        assert!(now.len() <= "2026-11-26T04:37:36.123Z".len(), "{now}");
    }
}
