//! The durations of the rounds of a program's main loop.

use alloc::vec::Vec;

/// Rounds of a program's main loop, from one arrival at its head to the next, in periods of the clock source. It is found as
/// [`Chip::watch_rounds`](crate::Chip::watch_rounds) says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rounds {
    head: u32,
    count: u64,
    total: u64,
    least: u64,
    most: u64,
    /// Rounds of about the same length, the shortest first.
    alike: Vec<Alike>,
}

/// A round of a program's main loop that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// The word address of the loop's first instruction.
    pub head: u32,
    /// The duration, in periods of the clock source.
    pub cycles: u64,
}

/// Rounds whose lengths differ by a thirty-second at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Alike {
    place: u16,
    count: u64,
    total: u64,
}

impl Rounds {
    pub(crate) const fn new(head: u32) -> Self {
        Self { head, count: 0, total: 0, least: u64::MAX, most: 0, alike: Vec::new() }
    }

    /// Adds a number of rounds of a length.
    pub(crate) fn add(&mut self, length: u64, times: u64) {
        if times == 0 {
            return;
        }
        self.count += times;
        let total = length.saturating_mul(times);
        self.total = self.total.saturating_add(total);
        self.least = self.least.min(length);
        self.most = self.most.max(length);
        let place = place(length);
        match self.alike.binary_search_by_key(&place, |alike| alike.place) {
            Ok(found) => {
                let alike = &mut self.alike[found];
                alike.count += times;
                alike.total = alike.total.saturating_add(total);
            }
            Err(next) => self.alike.insert(next, Alike { place, count: times, total }),
        }
    }

    /// The word address of the loop's first instruction.
    pub const fn head(&self) -> u32 {
        self.head
    }

    /// The number of completed rounds.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// All of them together; divided by their number it is the mean.
    pub const fn total(&self) -> u64 {
        self.total
    }

    /// The shortest one; 0 if there was none.
    pub const fn least(&self) -> u64 {
        if self.count == 0 { 0 } else { self.least }
    }

    /// The longest one.
    pub const fn most(&self) -> u64 {
        self.most
    }

    /// The median, or the mean of rounds that differ from it by a thirty-second at most; 0 if there was none.
    pub fn typical(&self) -> u64 {
        let mut before = 0;
        let middle = self.alike.iter().find(|alike| {
            before += alike.count;
            2 * before >= self.count.max(1)
        });
        middle.map_or(0, |alike| alike.total / alike.count.max(1))
    }
}

/// The counter for rounds of a length: by the highest of its bits, and the five below that.
const fn place(length: u64) -> u16 {
    match length.checked_ilog2() {
        Some(octave @ FINE..) => {
            let below = (length >> (octave - FINE)) as u16 & ((1 << FINE) - 1);
            ((octave - FINE + 1) as u16) << FINE | below
        }
        Some(_) | None => length as u16,
    }
}

/// Bits of a length that are distinguished behind the highest one.
const FINE: u32 = 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_the_order_of_lengths_and_are_narrow() {
        let mut before = 0;
        for length in 1..100_000_u64 {
            let place = place(length);
            assert!(
                place == before || place == before + 1,
                "{length} is at {place}, {} at {before}",
                length - 1
            );
            before = place;
        }
        assert!(place(u64::MAX) < 64 << FINE, "{}", place(u64::MAX));
    }

    #[test]
    fn the_typical_round_is_the_median() {
        let mut rounds = Rounds::new(7);
        assert_eq!((rounds.count(), rounds.least(), rounds.typical(), rounds.most()), (0, 0, 0, 0));
        rounds.add(1000, 3);
        rounds.add(16_000_000, 2);
        rounds.add(12, 1);
        assert_eq!((rounds.count(), rounds.total()), (6, 32_003_012));
        assert_eq!((rounds.least(), rounds.typical(), rounds.most()), (12, 1000, 16_000_000));
    }
}
