//! A brain's random numbers.

use baudbot_geometry::normal;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Random numbers that depend on a seed and a name only, so that two robots with the same brain and the same
/// seed do not dance in step. The generator is PCG-64, the same on every machine and in every version.
#[derive(Clone, Debug, PartialEq)]
pub struct Chance(Pcg64);

impl Chance {
    /// The numbers called `name`, such as `alice/wander`, of the run with this `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        Self(Pcg64::seed_from_u64(key(seed, name)))
    }

    /// The state of this generator's start and its increment, the high words first: for programs in other languages.
    pub(crate) fn words(seed: u64, name: &str) -> [u64; 4] {
        let SeedWords([low, high, step_low, step_high]) = SeedWords::seed_from_u64(key(seed, name));
        let wide = |high: u64, low: u64| (u128::from(high) << 64) | u128::from(low);
        let step = wide(step_high, step_low) | 1;
        let state = wide(high, low).wrapping_add(step).wrapping_mul(MULTIPLIER).wrapping_add(step);
        [(state >> 64) as u64, state as u64, (step >> 64) as u64, step as u64]
    }

    /// Uniform in [0, 1), with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// True with this probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// Normal, with mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        normal::deviate(u, v)
    }
}

/// The words that a generator begins with.
struct SeedWords([u64; 4]);

impl SeedableRng for SeedWords {
    type Seed = [u8; 32];

    fn from_seed(seed: Self::Seed) -> Self {
        let word =
            |place: usize| (0..8).rev().fold(0, |word, byte| (word << 8) | u64::from(seed[8 * place + byte]));
        Self([0, 1, 2, 3].map(word))
    }
}

/// PCG's multiplier for a state of 128 bits.
const MULTIPLIER: u128 = 0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645;

fn key(seed: u64, name: &str) -> u64 {
    seed ^ fnv1a(name.as_bytes())
}

/// The 64-bit FNV-1a hash.
fn fnv1a(bytes: &[u8]) -> u64 {
    let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

#[cfg(test)]
mod tests {
    use super::Chance;

    #[test]
    fn numbers_depend_on_seed_and_name_only() {
        let draw = |seed, name| Chance::new(seed, name).uniform();
        assert_eq!(draw(1, "alice/wander"), draw(1, "alice/wander"));
        assert_ne!(draw(1, "alice/wander"), draw(2, "alice/wander"));
        assert_ne!(draw(1, "alice/wander"), draw(1, "bob/wander"));
    }

    #[test]
    fn numbers_stay_the_same_between_versions() {
        let mut chance = Chance::new(7, "alice/wander");
        assert_eq!([chance.uniform(), chance.uniform()], [0.5728946248146071, 0.7520619467720493]);
    }

    #[test]
    fn normal_numbers_have_mean_0_and_variance_1() {
        let mut chance = Chance::new(1, "bell");
        let draws: Vec<_> = (0..20_000).map(|_| chance.normal()).collect();
        let mean = |power| draws.iter().map(|draw: &f64| draw.powi(power)).sum::<f64>() / 20_000.0;
        // Five standard errors: of the mean 1, of the square √2, of the fourth power √96, each over √20,000.
        assert!(mean(1).abs() < 0.036, "{}", mean(1));
        assert!((mean(2) - 1.0).abs() < 0.05, "{}", mean(2));
        assert!((mean(4) - 3.0).abs() < 0.35, "{}", mean(4));
    }
}
