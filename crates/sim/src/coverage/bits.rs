//! A set of cells: one bit each.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::floor::MAX_CELLS;

/// A set of numbers below a limit, and how many they are.
///
/// Serialised as the lengths of runs, in turn of absent and of present numbers, beginning with absent ones:
/// what robots cover has few and long runs, so this is much shorter than the words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    words: Vec<u64>,
    count: usize,
}

impl Bits {
    /// None of the numbers below `limit`.
    pub(super) fn new(limit: usize) -> Self {
        Self { words: vec![0; limit.div_ceil(WORD)], count: 0 }
    }

    /// All numbers below `limit`.
    #[cfg(test)]
    pub(super) fn full(limit: usize) -> Self {
        let mut all = Self::new(limit);
        all.insert_where(0..limit, |_| u64::MAX);
        all
    }

    /// The bytes that they have on the heap.
    pub(super) fn heap_bytes(&self) -> usize {
        self.words.len() * size_of::<u64>()
    }

    /// Words of memory.
    pub(super) fn words(&self) -> usize {
        self.words.len()
    }
    /// Whether all of them are among these.
    pub(super) fn is_within(&self, others: &Self) -> bool {
        let of = |i: usize| others.words.get(i).copied().unwrap_or(0);
        self.words.iter().enumerate().all(|(i, word)| word & !of(i) == 0)
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn contains(&self, bit: usize) -> bool {
        self.words.get(bit / WORD).is_some_and(|word| word >> (bit % WORD) & 1 == 1)
    }

    /// Whether it was absent and is present now. A number beyond the limit stays absent.
    pub(super) fn insert(&mut self, bit: usize) -> bool {
        let mask = 1 << (bit % WORD);
        match self.words.get_mut(bit / WORD) {
            Some(word) if *word & mask == 0 => {
                *word |= mask;
                self.count += 1;
                true
            }
            Some(_) | None => false,
        }
    }

    /// Inserts the number if it is in `allowed`.
    pub(super) fn insert_allowed(&mut self, bit: usize, allowed: &Self) {
        if let (Some(word), Some(allowed)) = (self.words.get_mut(bit / WORD), allowed.words.get(bit / WORD)) {
            let new = allowed & !*word & 1 << (bit % WORD);
            *word |= new;
            self.count += usize::from(new != 0);
        }
    }

    /// Inserts those numbers of the range that are in `allowed`.
    pub(super) fn insert_range(&mut self, range: Range<usize>, allowed: &Self) {
        self.insert_where(range, |i| allowed.words.get(i).copied().unwrap_or(0));
    }

    fn insert_where(&mut self, range: Range<usize>, allowed: impl Fn(usize) -> u64) {
        if range.is_empty() {
            return;
        }
        let (first, last) = (range.start / WORD, (range.end - 1) / WORD);
        for (i, word) in self.words.iter_mut().enumerate().take(last + 1).skip(first) {
            let from = if i == first { u64::MAX << (range.start % WORD) } else { u64::MAX };
            let to = if i == last { u64::MAX >> (WORD - 1 - (range.end - 1) % WORD) } else { u64::MAX };
            let new = allowed(i) & from & to & !*word;
            *word |= new;
            self.count += new.count_ones() as usize;
        }
    }

    /// The first place at or after `from` whose bit is not `value`.
    fn run_end(&self, from: usize, value: bool) -> usize {
        let differs = |word: u64| if value { !word } else { word };
        let mut mask = u64::MAX << (from % WORD);
        for (i, word) in self.words.iter().enumerate().skip(from / WORD) {
            let rest = differs(*word) & mask;
            if rest != 0 {
                return i * WORD + rest.trailing_zeros() as usize;
            }
            mask = u64::MAX;
        }
        self.words.len() * WORD
    }

    /// The lengths of runs of the numbers below `limit`, in turn of absent and of present ones, beginning with
    /// absent ones.
    pub(super) fn runs(&self, limit: usize) -> Vec<u32> {
        let mut runs = Vec::new();
        let (mut from, mut value) = (0, false);
        while from < limit {
            let end = self.run_end(from, value).min(limit);
            // A grid has at most a few million cells.
            runs.push((end - from) as u32);
            (from, value) = (end, !value);
        }
        runs
    }
}

impl Serialize for Bits {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.runs(self.words.len() * WORD).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Bits {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let runs = Vec::<u32>::deserialize(deserializer)?;
        let limit = runs.iter().map(|&run| u64::from(run)).sum::<u64>();
        let most = MAX_CELLS.next_multiple_of(WORD as u64);
        // Five bytes must not be able to ask for half a gigabyte.
        if limit > most || limit % WORD as u64 != 0 {
            let problem =
                format_args!("coverage: has {limit} cells; whole words of 64 and at most {most} fit");
            return Err(D::Error::custom(problem));
        }
        let mut bits = Self::new(limit as usize);
        let mut from = 0;
        for (i, run) in runs.into_iter().enumerate() {
            let end = from + run as usize;
            if i % 2 == 1 {
                bits.insert_where(from..end, |_| u64::MAX);
            }
            from = end;
        }
        Ok(bits)
    }
}

const WORD: usize = u64::BITS as usize;

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges by their first and their last number.
    fn of(limit: usize, ranges: &[(usize, usize)]) -> Bits {
        let mut bits = Bits::new(limit);
        ranges.iter().for_each(|&(first, last)| bits.insert_range(first..last + 1, &Bits::full(limit)));
        bits
    }

    #[test]
    fn ranges_are_as_their_numbers_one_by_one() {
        for range in [0..1, 3..60, 3..64, 63..65, 64..128, 5..190, 199..200, 0..200] {
            let mut one_by_one = Bits::new(200);
            for bit in range.clone() {
                assert!(one_by_one.insert(bit) && !one_by_one.insert(bit) && one_by_one.contains(bit));
            }
            assert_eq!(of(200, &[(range.start, range.end - 1)]), one_by_one, "{range:?}");
            assert_eq!(one_by_one.count(), range.len());
        }
    }

    #[test]
    fn only_what_is_allowed_is_inserted_and_counted() {
        let mut bits = of(200, &[(10, 19)]);
        bits.insert_range(0..200, &of(200, &[(15, 69), (100, 100)]));
        assert_eq!(bits, of(200, &[(10, 69), (100, 100)]));
        assert_eq!(bits.count(), 61);
        let allowed = of(128, &[(15, 69), (77, 80)]);
        (0..200).for_each(|bit| bits.insert_allowed(bit, &allowed));
        assert_eq!(bits, of(200, &[(10, 69), (77, 80), (100, 100)]));
        assert_eq!(bits.count(), 65);
    }

    #[test]
    fn beyond_the_limit_is_nothing() {
        let mut bits = Bits::new(64);
        assert!(!bits.insert(64) && !bits.contains(64));
        bits.insert_range(60..999, &Bits::full(999));
        bits.insert_range(7..7, &Bits::full(64));
        assert_eq!(bits.count(), 4);
    }

    #[test]
    fn runs_come_back_and_are_short() {
        for bits in [of(0, &[]), of(640, &[]), of(640, &[(0, 639)]), of(300, &[(0, 2), (64, 64), (100, 299)])]
        {
            let bytes = postcard::to_allocvec(&bits).unwrap();
            assert_eq!(postcard::from_bytes::<Bits>(&bytes).unwrap(), bits);
            assert!(bytes.len() < 12, "{bytes:?}");
        }
    }

    #[test]
    fn runs_go_as_far_as_they_are_asked_for() {
        let bits = of(128, &[(0, 2), (64, 64)]);
        assert_eq!(bits.runs(128), [0, 3, 61, 1, 63]);
        assert_eq!(bits.runs(100), [0, 3, 61, 1, 35]);
        assert_eq!(bits.runs(65), [0, 3, 61, 1]);
        assert_eq!(bits.runs(2), [0, 2]);
        assert!(bits.runs(0).is_empty());
    }

    #[test]
    fn a_few_bytes_cannot_ask_for_much_memory() {
        for runs in [vec![u32::MAX], vec![u32::MAX; 9], vec![4_000_000, 64], vec![63]] {
            let bytes = postcard::to_allocvec(&runs).unwrap();
            assert!(postcard::from_bytes::<Bits>(&bytes).is_err(), "{runs:?}");
        }
    }
}
