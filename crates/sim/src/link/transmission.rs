//! The wire itself: bursts of characters.
//!
//! A burst begins when a character finds the wire idle, and goes on while it is busy. The n-th character of a
//! burst that began at T has arrived
//!
//! - over a UART at T + ⌈n · bits · 10⁹ / baud⌉ nanoseconds,
//! - over USB at T + ⌈n / bytes a frame⌉ frames, where T is the next boundary of a frame; what comes too late
//!   for the burst's last frame begins a new burst with the next one.
//!
//! Counting from the start of the burst keeps the instants exact where a character's time is no whole number of
//! nanoseconds.

use serde::{Deserialize, Serialize};

use super::Link;
use crate::time::SimTime;

/// The last burst on a wire.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Transmission {
    start: SimTime,
    characters: u64,
    /// The instant at which its last character has arrived.
    end: SimTime,
}

impl Transmission {
    /// Puts a character on the wire, behind those that are on it, and not before `ready`. Returns when it has arrived.
    pub(super) fn put(&mut self, link: &Link, ready: SimTime) -> SimTime {
        let frame_ns = link.frame_ns();
        if ready + frame_ns > self.end {
            self.start = ready.up_to(frame_ns);
            self.characters = 0;
        }
        self.characters += 1;
        self.end = self.start + link.burst_ns(self.characters);
        self.end
    }

    /// Puts so many characters, at least one, on a wire on which they take no time: [`put`](Self::put) for each of them.
    pub(super) fn put_at_once(&mut self, ready: SimTime, characters: u64) -> SimTime {
        if ready > self.end {
            self.start = ready;
            self.characters = 0;
        }
        self.characters += characters;
        self.end = self.start;
        self.end
    }

    /// Puts a character on the wire that is over at this instant, or when the one before it is.
    pub(super) fn put_until(&mut self, link: &Link, over: SimTime) -> SimTime {
        self.start = SimTime::from_ns(over.max(self.end).as_ns().saturating_sub(link.burst_ns(1)));
        self.characters = 1;
        self.end = self.start + link.burst_ns(1);
        self.end
    }

    /// The next character begins a burst, behind those that are on the wire.
    pub(super) fn begin(&mut self) {
        (self.start, self.characters) = (self.end, 0);
    }

    /// The instant at which at most `depth` of its characters will still be on the way.
    pub(super) fn drained_to(&self, link: &Link, depth: usize) -> SimTime {
        match self.characters.saturating_sub(depth as u64) {
            0 => SimTime::ZERO,
            finished => self.start + link.burst_ns(finished),
        }
    }

    /// Whether its characters are where this wire has them.
    pub(super) fn is_sound(&self, link: &Link) -> bool {
        crate::sound::count(self.characters) && self.end == self.start + link.burst_ns(self.characters)
    }

    /// The instant at which its last character has arrived; the start of the run if there was none yet.
    pub(super) fn end(&self) -> SimTime {
        self.end
    }

    /// The instant from which on the other side may begin, where both share the wire.
    pub(super) fn over(&self, turnaround_ns: u64) -> SimTime {
        if self.end == SimTime::ZERO { SimTime::ZERO } else { self.end + turnaround_ns }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::link::properties::{uart, usb};
    use crate::time::SECOND_NS;

    #[test]
    fn an_hour_of_characters_does_not_drift() {
        let (link, mut transmission) = (uart(115_200, 10), Transmission::default());
        for _ in 0..3600 * 11_520 {
            transmission.put(&link, SimTime::ZERO);
        }
        assert_eq!(transmission.end, SimTime::from_ns(3600 * SECOND_NS));
    }

    #[test]
    fn a_burst_that_is_begun_anew_leaves_what_is_on_the_wire_there() {
        let (slow, fast, mut transmission) = (uart(1000, 10), uart(100_000, 10), Transmission::default());
        let ms = |ms: u64| SimTime::from_ns(ms * 1_000_000);
        assert_eq!(
            (transmission.put(&slow, SimTime::ZERO), transmission.put(&slow, SimTime::ZERO)),
            (ms(10), ms(20))
        );
        transmission.begin();
        // The other side of a shared wire still has to wait for it.
        assert_eq!(transmission.over(1_000_000), ms(21));
        assert_eq!(transmission.put(&fast, ms(1)), SimTime::from_ns(20_100_000));
    }

    #[test]
    fn at_once_is_one_by_one_where_it_takes_no_time() {
        let (mut alone, mut together) = (Transmission::default(), Transmission::default());
        for (us, n) in [(0, 3), (0, 1), (5, 2), (4, 4), (9, 1)] {
            let ready = SimTime::from_ns(us * 1000);
            let last = (0..n).map(|_| alone.put(&Link::Ideal, ready)).last();
            assert_eq!(Some(together.put_at_once(ready, n)), last);
            assert_eq!(alloc::format!("{together:?}"), alloc::format!("{alone:?}"));
        }
    }

    #[test]
    fn usb_carries_so_many_bytes_a_frame_from_the_next_boundary_on() {
        let (link, mut transmission) = (usb(3), Transmission::default());
        let mut put = |us: u64| transmission.put(&link, SimTime::from_ns(us * 1000)).as_ns() / 1000;
        // On a boundary, and just behind it.
        assert_eq!(put(0), 1000);
        let arrivals: Vec<u64> = (0..5).map(|_| put(2001)).collect();
        assert_eq!(arrivals, [4000, 4000, 4000, 5000, 5000]);
        // In time for the burst's second frame, which has room for one more; the next waits for the third.
        assert_eq!([put(4000), put(4000)], [5000, 6000]);
        // Too late for the frame from 5 to 6 ms, though that has room.
        assert_eq!([put(5001), put(6000)], [7000, 7000]);
    }

    #[test]
    fn a_transmitter_has_room_again_when_all_but_its_depth_is_over() {
        let (link, mut transmission) = (uart(10_000, 10), Transmission::default());
        for _ in 0..5 {
            transmission.put(&link, SimTime::from_ns(500));
        }
        assert_eq!(transmission.drained_to(&link, 2), SimTime::from_ns(3_000_500));
        assert_eq!(transmission.drained_to(&link, 5), SimTime::ZERO);
        assert_eq!(transmission.drained_to(&link, usize::MAX), SimTime::ZERO);
    }
}
