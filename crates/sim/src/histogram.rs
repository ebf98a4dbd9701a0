//! The distribution of durations, in little memory.
//!
//! Durations are counted in buckets: 64 for every doubling, so that a quantile is right to 0.8 %; the smallest, the
//! largest, their number and their sum are exact. A part whose durations are all alike needs a single bucket, and none
//! needs more than 3,776.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::heap::NO_MEMORY;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Counts of durations in nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram(Counts);

/// Most parts have durations that are all alike, and those of a crowd are counted in every tick: so they take little room.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Counts {
    Alike { ns: u64, count: u64 },
    Spread(Box<Spread>),
}

/// Durations of any lengths, and the form in which all are saved.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Spread {
    /// Number of the first bucket in `buckets`.
    first: u32,
    buckets: Vec<u32>,
    count: u64,
    sum_ns: u64,
    min_ns: u64,
    max_ns: u64,
}

impl Histogram {
    /// Counts a duration.
    #[inline]
    pub fn note(&mut self, ns: u64) {
        match &mut self.0 {
            Counts::Alike { ns: other, count } if *other == ns => *count += 1,
            Counts::Alike { .. } | Counts::Spread(_) => self.note_other(ns),
        }
    }

    #[inline(never)]
    fn note_other(&mut self, ns: u64) {
        match &mut self.0 {
            Counts::Alike { count: 0, .. } => self.0 = Counts::Alike { ns, count: 1 },
            Counts::Alike { .. } => {
                let mut spread = self.spread();
                spread.note(ns);
                self.0 = Counts::Spread(Box::new(spread));
            }
            Counts::Spread(spread) => spread.note(ns),
        }
    }

    /// The histogram in the form in which it is saved.
    fn spread(&self) -> Spread {
        match self.0 {
            Counts::Alike { count: 0, .. } => Spread::default(),
            Counts::Alike { ns, count } => Spread {
                first: bucket(ns),
                buckets: vec![u32::try_from(count).unwrap_or(u32::MAX)],
                count,
                sum_ns: ns.saturating_mul(count),
                min_ns: ns,
                max_ns: ns,
            },
            Counts::Spread(ref spread) => Spread::clone(spread),
        }
    }

    /// Whether durations can have been counted so.
    pub(crate) fn is_sound(&self) -> bool {
        match &self.0 {
            Counts::Alike { count, .. } => crate::sound::count(*count),
            Counts::Spread(spread) => spread.is_sound(),
        }
    }

    /// The number of counted durations.
    pub fn count(&self) -> u64 {
        match &self.0 {
            Counts::Alike { count, .. } => *count,
            Counts::Spread(spread) => spread.count,
        }
    }

    /// The sum of the durations, in nanoseconds.
    pub fn sum_ns(&self) -> u64 {
        match &self.0 {
            Counts::Alike { ns, count } => ns.saturating_mul(*count),
            Counts::Spread(spread) => spread.sum_ns,
        }
    }

    /// The mean of the durations, in nanoseconds, cut off; `None` if there were none.
    pub fn mean_ns(&self) -> Option<u64> {
        self.sum_ns().checked_div(self.count())
    }

    /// The smallest, in nanoseconds; `None` if there were none.
    pub fn min_ns(&self) -> Option<u64> {
        let min_ns = match &self.0 {
            Counts::Alike { ns, .. } => *ns,
            Counts::Spread(spread) => spread.min_ns,
        };
        (self.count() > 0).then_some(min_ns)
    }

    /// The largest, in nanoseconds; `None` if there were none.
    pub fn max_ns(&self) -> Option<u64> {
        let max_ns = match &self.0 {
            Counts::Alike { ns, .. } => *ns,
            Counts::Spread(spread) => spread.max_ns,
        };
        (self.count() > 0).then_some(max_ns)
    }

    /// The duration, in nanoseconds, that a share `q` of them, in [0, 1], does not exceed: by nearest rank, and to
    /// 0.8 %. `None` if there were none.
    pub fn quantile_ns(&self, q: f64) -> Option<u64> {
        match &self.0 {
            Counts::Alike { .. } => self.min_ns(),
            Counts::Spread(spread) => spread.quantile_ns(q),
        }
    }
}

impl Default for Histogram {
    fn default() -> Self {
        Self(Counts::Alike { ns: 0, count: 0 })
    }
}

impl Serialize for Histogram {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            // The histogram has no list as long as all durations are alike.
            Counts::Alike { .. } => serializer.serialize_newtype_struct(NO_MEMORY, &self.spread()),
            Counts::Spread(spread) => spread.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Histogram {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spread = Spread::deserialize(deserializer)?;
        let alike = Self(Counts::Alike { ns: spread.min_ns, count: spread.count });
        Ok(if alike.spread() == spread { alike } else { Self(Counts::Spread(Box::new(spread))) })
    }
}

impl Spread {
    fn note(&mut self, ns: u64) {
        let bucket = bucket(ns);
        self.count += 1;
        self.sum_ns = self.sum_ns.saturating_add(ns);
        let place = bucket.wrapping_sub(self.first) as usize;
        if let Some(n) = self.buckets.get_mut(place) {
            *n = n.saturating_add(1);
            self.min_ns = self.min_ns.min(ns);
            self.max_ns = self.max_ns.max(ns);
        } else {
            self.make_room(bucket, ns);
        }
    }

    #[cold]
    fn make_room(&mut self, bucket: u32, ns: u64) {
        if self.buckets.is_empty() {
            (self.first, self.min_ns) = (bucket, ns);
        }
        if let Some(lacking) = self.first.checked_sub(bucket).filter(|&lacking| lacking > 0) {
            self.buckets.splice(0..0, core::iter::repeat_n(0, lacking as usize));
            self.first = bucket;
        }
        let place = (bucket - self.first) as usize;
        if place >= self.buckets.len() {
            self.buckets.resize(place + 1, 0);
        }
        self.buckets[place] = self.buckets[place].saturating_add(1);
        self.min_ns = self.min_ns.min(ns);
        self.max_ns = self.max_ns.max(ns);
    }

    fn is_sound(&self) -> bool {
        let last = u64::from(self.first) + self.buckets.len() as u64;
        let is_in = last <= u64::from(bucket(u64::MAX)) + 1 && self.buckets.is_empty() == (self.count == 0);
        is_in && self.min_ns <= self.max_ns && crate::sound::count(self.count)
    }

    fn quantile_ns(&self, q: f64) -> Option<u64> {
        let exact = q.clamp(0.0, 1.0) * self.count as f64;
        let rank = (exact as u64 + u64::from(exact > (exact as u64) as f64)).max(1);
        let mut counted = 0;
        let place = self.buckets.iter().position(|&n| {
            counted += u64::from(n);
            counted >= rank
        })?;
        Some(middle_ns(self.first + place as u32).clamp(self.min_ns, self.max_ns))
    }
}

/// The logarithm to base 2 of the number of buckets in an octave.
const FINE: u32 = 6;

fn bucket(ns: u64) -> u32 {
    let octave = ns.checked_ilog2().unwrap_or(0);
    if octave < FINE {
        return ns as u32;
    }
    let shift = octave - FINE;
    (shift << FINE) + (ns >> shift) as u32
}

/// The middle of a bucket's durations.
fn middle_ns(bucket: u32) -> u64 {
    let shift = (bucket >> FINE).saturating_sub(1);
    let lowest = u64::from(bucket - (shift << FINE)) << shift;
    lowest + ((1 << shift) - 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_follow_each_other_without_a_gap_and_are_at_most_a_64th_wide() {
        for ns in (0..100_000).chain([u64::MAX - 1, u64::MAX, 1 << 40, (1 << 40) - 1]) {
            let (this, before) = (bucket(ns), bucket(ns.saturating_sub(1)));
            assert!(this - before <= 1, "{ns}");
            assert_eq!(bucket(middle_ns(this)), this, "{ns}");
            assert!(middle_ns(this).abs_diff(ns) <= ns / 128 + 1, "{ns}: {}", middle_ns(this));
        }
        assert_eq!(bucket(u64::MAX), 3775);
    }

    #[test]
    fn quantiles_are_right_to_their_resolution_and_the_rest_is_exact() {
        let mut histogram = Histogram::default();
        // 1 to 1000 µs, from both ends at once.
        for us in 1..=500 {
            histogram.note((501 - us) * 1000);
            histogram.note((500 + us) * 1000);
        }
        for (q, us) in [(0.0, 1.0), (0.5, 500.0), (0.9, 900.0), (0.99, 990.0), (1.0, 1000.0)] {
            let found = histogram.quantile_ns(q).unwrap() as f64 / 1000.0;
            assert!((found / us - 1.0).abs() < 0.009, "{q}: {found}");
        }
        assert_eq!((histogram.min_ns(), histogram.max_ns()), (Some(1000), Some(1_000_000)));
        assert_eq!((histogram.count(), histogram.mean_ns()), (1000, Some(500_500)));
    }

    #[test]
    fn equal_durations_need_one_bucket_and_are_told_exactly() {
        let mut histogram = Histogram::default();
        (0..10).for_each(|_| histogram.note(12_345_678));
        assert_eq!((histogram.spread().buckets.len(), histogram.quantile_ns(0.5)), (1, Some(12_345_678)));
    }

    #[test]
    fn what_is_saved_does_not_depend_on_how_it_is_kept() {
        let saved = |histogram: &Histogram| postcard::to_allocvec(histogram).unwrap();
        let (mut histogram, mut spread) = (Histogram::default(), Spread::default());
        let durations = [7, 7, 7, u64::MAX, u64::MAX, 0, 12_345_678, 7];
        // First all alike, then not; then from what is saved; and one that is alike at the limit of the sum.
        for ns in durations {
            assert_eq!(saved(&histogram), postcard::to_allocvec(&spread).unwrap());
            assert_eq!(postcard::from_bytes::<Histogram>(&saved(&histogram)).unwrap(), histogram);
            histogram.note(ns);
            spread.note(ns);
            let whole = Histogram(Counts::Spread(Box::new(spread.clone())));
            let told = |h: &Histogram| (h.count(), h.sum_ns(), h.min_ns(), h.max_ns(), h.quantile_ns(0.5));
            assert_eq!(told(&histogram), told(&whole), "after {ns}");
        }
        let (mut histogram, mut spread) = (Histogram::default(), Spread::default());
        for _ in 0..3 {
            histogram.note(u64::MAX);
            spread.note(u64::MAX);
            assert_eq!(saved(&histogram), postcard::to_allocvec(&spread).unwrap());
        }
        assert!(matches!(histogram.0, Counts::Alike { count: 3, .. }));
    }

    #[test]
    fn of_nothing_there_is_no_quantile() {
        assert_eq!(Histogram::default().quantile_ns(0.5), None);
        assert_eq!(Histogram::default().mean_ns(), None);
    }
}
