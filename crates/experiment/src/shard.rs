//! A share of an experiment's runs, for one of many machines. The runs that it has follow from their numbers alone,
//! without a coordinator.
//!
//! The runs in their order are cut into blocks, and each shard has one run of each block. So shards differ by one run at
//! most, and also share the work if later runs cost more than earlier ones. Which run of a block it is, is drawn by the
//! block's number: costs that repeat, as they do if a field has as many values as there are shards, do not all fall on
//! the same one.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of so many shares of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    /// The number of shards; never 0.
    count: u32,
    /// The index of this one, from 0.
    index: u32,
}

/// The reason why a text is no shard.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    /// The text has another form.
    #[error(
        "a shard is I/N, the number I of N shards, from 0, such as 0/8 (in Kubernetes \"$JOB_COMPLETION_INDEX/8\")"
    )]
    Form,
    /// The number of shards is 0.
    #[error("there are no shards; give at least one, as in 0/1")]
    None,
    /// More than there can be.
    #[error("there are at most {MOST} shards, not {count}")]
    TooMany {
        /// The number that there are to be.
        count: u32,
    },
    /// The shard's number is beyond theirs.
    #[error("shards are numbered from 0, as Kubernetes' JOB_COMPLETION_INDEX is, so the last of {count} is {}/{count}", count - 1)]
    Beyond {
        /// The number that there are.
        count: u32,
    },
}

impl Shard {
    /// All runs.
    pub const WHOLE: Self = Self { count: 1, index: 0 };

    /// All of so many shards.
    pub fn all(count: u32) -> impl Iterator<Item = Self> {
        (0..count).map(move |index| Self { count, index })
    }

    /// The number of its runs, of so many.
    pub fn len(self, total: u64) -> u64 {
        let count = u64::from(self.count);
        let full = total / count;
        full + u64::from(self.run(full).is_some_and(|run| run < total))
    }

    /// The shard's runs, of so many, in their order.
    pub fn runs(self, total: u64) -> impl Iterator<Item = u64> {
        // Only the last block may be without one.
        (0..self.len(total)).filter_map(move |block| self.run(block))
    }

    /// The shard that has a run, of so many shards.
    pub fn of(run: u64, count: u32) -> Self {
        let shards = u64::from(count.max(1));
        let (block, place) = (run / shards, run % shards);
        let index = (place + shards - turn(block, shards)) % shards;
        Self { count: count.max(1), index: index as u32 }
    }

    /// The number of shards.
    pub fn count(self) -> u32 {
        self.count
    }

    /// A name for its folder.
    pub fn folder(self) -> String {
        format!("{}-of-{}", self.index, self.count)
    }

    /// The shard's run of a block; `None` if there is no such number.
    fn run(self, block: u64) -> Option<u64> {
        let count = u64::from(self.count);
        let place = (u64::from(self.index) + turn(block, count)) % count;
        block.checked_mul(count)?.checked_add(place)
    }
}

/// The number of places by which a block is turned: one of so many, as good as random. It may never change, as journals
/// of some shards are continued by later versions.
fn turn(block: u64, count: u64) -> u64 {
    // Vigna's SplitMix64, with the block's number as its seed.
    let mut z = block.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((u128::from(z ^ (z >> 31)) * u128::from(count)) >> 64) as u64
}

/// The most machines that are realistic.
const MOST: u32 = 1_000_000;

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let (index, count) = text.split_once('/').ok_or(ShardError::Form)?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| ShardError::Form);
        let (index, count) = (number(index)?, number(count)?);
        match count {
            0 => Err(ShardError::None),
            _ if count > MOST => Err(ShardError::TooMany { count }),
            _ if index >= count => Err(ShardError::Beyond { count }),
            _ => Ok(Self { count, index }),
        }
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl TryFrom<String> for Shard {
    type Error = ShardError;

    fn try_from(text: String) -> Result<Self, ShardError> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_together_all_and_none_has_two_runs_more_than_another() {
        for count in [1, 2, 3, 7, 8, 60, 1000] {
            for total in [0, 1, 2, 7, 8, 9, 63, 64, 65, 240, 1001] {
                let mut owner = vec![None; total as usize];
                for shard in Shard::all(count) {
                    let runs: Vec<_> = shard.runs(total).collect();
                    assert!(runs.is_sorted(), "{shard} of {total}: {runs:?}");
                    assert_eq!(runs.len() as u64, shard.len(total), "{shard} of {total}");
                    let fair = total / u64::from(count);
                    assert!((fair..=fair + 1).contains(&shard.len(total)), "{shard} of {total}: {runs:?}");
                    for run in runs {
                        assert_eq!(Shard::of(run, count), shard, "run {run}");
                        assert_eq!(owner[run as usize].replace(shard), None, "run {run} of {total}");
                    }
                }
                assert!(owner.iter().all(Option::is_some), "{count} shards of {total}: {owner:?}");
            }
        }
        assert!(Shard::WHOLE.runs(1000).eq(0..1000));
    }

    #[test]
    fn which_runs_a_shard_has_never_changes() {
        let runs = |text: &str| text.parse::<Shard>().unwrap().runs(40).collect::<Vec<_>>();
        assert_eq!(runs("0/8"), [7, 12, 20, 24, 35]);
        assert_eq!(runs("7/8"), [6, 11, 19, 31, 34]);
    }

    /// The work of the shard with the most, as a multiple of a fair share.
    fn most(count: u32, total: u64, cost: impl Fn(u64) -> f64) -> f64 {
        let work = |shard: Shard| shard.runs(total).map(&cost).sum::<f64>();
        Shard::all(count).map(work).fold(0.0, f64::max) * f64::from(count)
            / (0..total).map(&cost).sum::<f64>()
    }

    #[test]
    fn work_is_shared_whether_costs_rise_or_repeat() {
        for count in [2, 3, 4, 8, 10, 16, 20] {
            let total = 60 * u64::from(count);
            // The costs rise as with a field of ever slower values.
            let rising = most(count, total, |run| 1.0 + run as f64);
            assert!(rising < 1.02, "{count} shards: {rising}");
            // The costs are as with a last field of some values, the second half of which are ten times as slow, and
            // one or ten seeds.
            for period in (2..=32).chain([40, 60, 80, 100]) {
                let repeating =
                    most(count, total, |run| if run % period < period.div_ceil(2) { 1.0 } else { 10.0 });
                assert!(repeating < 1.4, "{count} shards, period {period}: {repeating}");
            }
        }
    }

    #[test]
    fn what_is_no_shard_is_refused_with_the_remedy() {
        let refused = |text: &str| text.parse::<Shard>().expect_err(text).to_string();
        assert!(refused("8/8").ends_with("so the last of 8 is 7/8"), "{}", refused("8/8"));
        assert_eq!(refused("0/1000001"), "there are at most 1000000 shards, not 1000001");
        assert_eq!(refused("0/0"), "there are no shards; give at least one, as in 0/1");
        for text in ["", "3", "/8", "3/", "-1/8", "1/2/3", "a/b", "0/4294967296", " 1/8"] {
            assert!(refused(text).starts_with("a shard is I/N"), "{text}");
        }
        assert_eq!("3/8".parse::<Shard>().unwrap().to_string(), "3/8");
        let last = Shard { count: MOST, index: MOST - 1 };
        assert_eq!(last.runs(u64::from(MOST)).map(|run| Shard::of(run, MOST)).collect::<Vec<_>>(), [last]);
        assert!(last.len(u64::MAX) >= u64::MAX / u64::from(MOST), "no overflow");
    }
}
