//! Frames of HTTP/2 that carry nothing for a service, and how many of them a connection may send.
//!
//! A PING is answered, a SETTINGS is acknowledged, and the sender gets no work done by it. A client in good order sends
//! some: to know whether the server is there, how far it is, and that it has read something. One that sends millions a
//! second takes a processor. h2 bounds what waits to be answered, and not how often it is asked for.

use std::time::{Duration, Instant};

/// Counts the frames of a connection, of which it reads the heads only.
pub(super) struct Frames {
    /// Bytes until the next head: first those of the client's preface.
    skip: usize,
    head: [u8; HEAD],
    /// The number of bytes of the head so far.
    come: usize,
    second: Option<Instant>,
    counts: [u32; KINDS.len()],
}

/// A kind of frame that carries nothing: its number, whether only those without a payload are counted, and how many there may be in a second.
struct Kind {
    number: u8,
    name: &'static str,
    only_empty: bool,
    most: u32,
}

const fn kind(number: u8, name: &'static str, most: u32) -> Kind {
    Kind { number, name, only_empty: false, most }
}

/// The kinds and their limits. A client measures its way to the server by a PING for each answer, at most, and
/// acknowledges each.
const KINDS: [Kind; 7] = [
    Kind { only_empty: true, ..kind(0, "DATA without data", 10_000) },
    kind(2, "PRIORITY", 1000),
    kind(3, "RST_STREAM", 20_000),
    kind(4, "SETTINGS", 100),
    kind(6, "PING", 20_000),
    kind(8, "WINDOW_UPDATE", 100_000),
    // Such as those of extensions, which are to be ignored, and of a push, which no client may send.
    kind(u8::MAX, "other", 100),
];

/// HEADERS and CONTINUATION, which h2 limits.
const WITH_HEADERS: [u8; 2] = [1, 9];

const PREFACE: usize = 24;
const HEAD: usize = 9;

impl Frames {
    pub(super) fn new() -> Self {
        Self { skip: PREFACE, head: [0; HEAD], come: 0, second: None, counts: [0; KINDS.len()] }
    }

    /// Bytes have come.
    ///
    /// # Errors
    /// The name of the kind of which there are too many in this second.
    pub(super) fn read(&mut self, mut bytes: &[u8], now: Instant) -> Result<(), &'static str> {
        let second = *self.second.get_or_insert(now);
        if now.saturating_duration_since(second) >= Duration::from_secs(1) {
            (self.second, self.counts) = (Some(now), [0; KINDS.len()]);
        }
        loop {
            let skipped = self.skip.min(bytes.len());
            bytes = &bytes[skipped..];
            self.skip -= skipped;
            let taken = (HEAD - self.come).min(bytes.len());
            if taken == 0 {
                return Ok(());
            }
            self.head[self.come..self.come + taken].copy_from_slice(&bytes[..taken]);
            bytes = &bytes[taken..];
            self.come += taken;
            if self.come == HEAD {
                self.come = 0;
                let [a, b, c, number, ..] = self.head;
                self.skip = u32::from_be_bytes([0, a, b, c]) as usize;
                self.count(number)?;
            }
        }
    }

    fn count(&mut self, number: u8) -> Result<(), &'static str> {
        if WITH_HEADERS.contains(&number) {
            return Ok(());
        }
        let place = KINDS.iter().position(|kind| kind.number == number).unwrap_or(KINDS.len() - 1);
        let kind = &KINDS[place];
        if kind.only_empty && self.skip > 0 {
            return Ok(());
        }
        self.counts[place] += 1;
        if self.counts[place] > kind.most { Err(kind.name) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u8, payload: usize) -> Vec<u8> {
        let mut frame = (payload as u32).to_be_bytes()[1..].to_vec();
        frame.extend([number, 0, 0, 0, 0, 1]);
        // The payload contains bytes that look like heads of PINGs.
        frame.extend([0, 0, 8, 6, 0, 0, 0, 0, 0].iter().cycle().take(payload));
        frame
    }

    /// A connection that has sent its preface and this, in pieces of so many bytes.
    fn told(piece: usize, sent: &[u8]) -> Result<(), &'static str> {
        let (mut frames, now) = (Frames::new(), Instant::now());
        [&[b'x'; PREFACE][..], sent].concat().chunks(piece).try_for_each(|piece| frames.read(piece, now))
    }

    #[test]
    fn each_kind_that_carries_nothing_has_its_limit_and_work_has_none() {
        for kind in &KINDS {
            let number = if kind.number == u8::MAX { 77 } else { kind.number };
            let payload = if kind.only_empty { 0 } else { 8 };
            let most = frame(number, payload).repeat(kind.most as usize);
            for piece in [1, 7, 16 << 10] {
                assert_eq!(told(piece, &most), Ok(()), "{}", kind.name);
                let one_more = [&most[..], &frame(number, payload)].concat();
                assert_eq!(told(piece, &one_more), Err(kind.name));
            }
        }
        let work = [frame(1, 50), frame(0, 100), frame(9, 3)].concat().repeat(50_000);
        assert_eq!(told(16 << 10, &work), Ok(()));
    }

    #[test]
    fn a_second_later_there_may_be_as_many_again() {
        let (mut frames, start) = (Frames::new(), Instant::now());
        frames.read(&[0; PREFACE], start).unwrap();
        let settings = frame(4, 6).repeat(60);
        for ms in [0, 1000, 2000, 3500] {
            assert_eq!(frames.read(&settings, start + Duration::from_millis(ms)), Ok(()), "{ms}");
        }
        assert_eq!(frames.read(&settings, start + Duration::from_millis(3600)), Err("SETTINGS"));
    }
}
