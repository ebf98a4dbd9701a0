//! The runs of an environment of a fleet, one after the other.

use baudbot_sim::Ending;

use crate::learn::env::Env;
use crate::learn::error::LearnError;

/// The run that an environment is in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Run {
    /// The seed that the first one was given.
    pub(crate) seed: u64,
    /// Runs since then.
    pub(crate) number: u64,
    pub(crate) is_over: bool,
    /// The run before this one, if it ended in the same step.
    pub(crate) last: Option<Info>,
}

/// The description of a run at its beginning and its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Info {
    /// Simulated time since its start, in nanoseconds.
    pub time_ns: u64,
    /// The seed of the run.
    pub seed: u64,
    /// The reason for its end.
    pub ending: Option<Ending>,
}

impl Info {
    pub(crate) fn of(env: &Env) -> Self {
        let world = env.world();
        let (time_ns, seed) = (world.time().as_ns(), world.scenario().seed);
        Self { time_ns, seed, ending: world.ending().cloned() }
    }
}

impl Run {
    pub(crate) fn begin(&mut self, env: &mut Env) -> Result<(), LearnError> {
        self.number += 1;
        self.is_over = false;
        env.reset(self.world_seed(), &[])
    }

    pub(crate) fn world_seed(&self) -> u64 {
        episode_seed(self.seed, self.number)
    }
}

/// The seed of a run: the first one's is `seed`, that of later ones is a function of it and the run's number.
pub(crate) fn episode_seed(seed: u64, number: u64) -> u64 {
    if number == 0 {
        return seed;
    }
    // SplitMix64 (Steele, Lea, Flood 2014), of which 48 bits are kept, so that the seed is an integer of TOML and JSON.
    let mut mixed = seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ (mixed >> 31)) >> 16
}

/// The seed of the first run of the environment at this place.
pub(crate) fn seed_of(seed: u64, place: usize) -> u64 {
    seed.wrapping_add(place as u64)
}
