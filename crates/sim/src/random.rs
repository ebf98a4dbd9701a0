//! Named streams of random numbers.
//!
//! Every noisy part owns the stream that is named after it (`"alice/ir_left"`), seeded from the scenario's
//! seed and that name. So adding a sensor changes no other sensor's noise, and the order in which parts are
//! read changes nothing. The generator is PCG-64, named explicitly because `rand`'s standard generator may
//! change between versions; the normal deviate is our own on `libm`, because a platform's `ln` and `cos`
//! differ in the last bits. For the many values of a scan the stream draws the states of several generators, which then
//! run side by side.

use baudbot_geometry::normal::{self, Lanes};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// A stream of random numbers that belongs to one part of the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Place", into = "Place")]
pub struct Stream {
    generator: Pcg64,
    place: Place,
}

/// The identity of a stream and its progress: all that a snapshot needs, since the generator can be wound forward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Place {
    key: u64,
    drawn: u64,
}

impl From<Stream> for Place {
    fn from(stream: Stream) -> Self {
        stream.place
    }
}

impl From<Place> for Stream {
    fn from(place: Place) -> Self {
        let mut mixer = SplitMix(place.key);
        let mut seed = [0; 32];
        for chunk in seed.chunks_exact_mut(8) {
            chunk.copy_from_slice(&mixer.next().to_le_bytes());
        }
        let mut generator = Pcg64::from_seed(seed);
        generator.advance(place.drawn.into());
        Self { generator, place }
    }
}

impl Stream {
    /// The stream called `name` of the run with this `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        Self::of(seed, &[name])
    }

    /// The stream of which these are the parts of its name, one behind the other.
    pub(crate) fn of(seed: u64, name: &[&str]) -> Self {
        let bytes = name.iter().flat_map(|part| part.bytes());
        Place { key: seed ^ bytes.fold(FNV_OFFSET, fnv1a_step), drawn: 0 }.into()
    }

    /// Goes on with other numbers, which follow from this seed and from what it was.
    pub(crate) fn reseed(&mut self, seed: u64) {
        *self = Place { key: spread(spread(seed) ^ self.place.key), drawn: 0 }.into();
    }

    /// The key that distinguishes this stream from all others of its kind.
    pub fn key(&self) -> u64 {
        self.place.key
    }

    /// Whether there is more to be drawn.
    pub(crate) fn is_sound(&self) -> bool {
        crate::sound::count(self.place.drawn)
    }

    fn draw(&mut self) -> u64 {
        self.place.drawn += 1;
        self.generator.next_u64()
    }

    /// Uniform in [0, 1), with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        unit(self.draw())
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller's method, one of its two values).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        normal::deviate(u, v)
    }

    /// Changes each value with a normal deviate of its own. These are made in lanes, whose states are drawn from the
    /// stream: so they are others than [`normal`](Self::normal) would draw.
    pub fn each_normal(&mut self, values: &mut [f64], change: impl Fn(f64, f64) -> f64) {
        let words = core::array::from_fn(|_| core::array::from_fn(|_| self.draw()));
        Lanes::new(words).each_normal(values, change);
    }

    /// No normal deviate is larger than this, since no uniform one is nearer to 1 than 2^-53.
    pub(crate) const MOST_NORMAL: f64 = 8.6;

    /// Draws what a normal deviate takes, where it would make no difference.
    pub(crate) fn skip_normal(&mut self) {
        self.draw();
        self.draw();
    }

    /// An integer in `0..n`; `n` must not be 0. The bias of the multiply-shift is below 2^-32 for small `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        (((self.draw() >> 32) * u64::from(n)) >> 32) as u32
    }
}

/// In [0, 1), of the upper 53 of these bits.
fn unit(bits: u64) -> f64 {
    // Signed, as processors have that at less cost.
    (bits >> 11).cast_signed() as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// 64 random bits that follow from a number alone.
pub(crate) fn spread(number: u64) -> u64 {
    SplitMix(number).next()
}

/// Vigna's SplitMix64: spreads one 64-bit seed over the generator's 256 bits.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

/// The initial value of a 64-bit FNV-1a.
pub(crate) const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// A step of a 64-bit FNV-1a.
pub(crate) const fn fnv1a_step(hash: u64, byte: u8) -> u64 {
    (hash ^ byte as u64).wrapping_mul(0x0000_0100_0000_01b3)
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::Stream;
    use crate::statistics::{assert_distributed, assert_rate, correlation, normal, rate};

    /// The deviates of so many scans, one after the other.
    fn scans(seed: u64, name: &str, scans: usize) -> Vec<[f64; RAYS]> {
        let mut stream = Stream::new(seed, name);
        let scan = || {
            let mut values = [0.0; RAYS];
            stream.each_normal(&mut values, |_, deviate| deviate);
            values
        };
        core::iter::repeat_with(scan).take(scans).collect()
    }

    const RAYS: usize = 682;

    #[track_caller]
    fn assert_independent(what: &str, pairs: &[(f64, f64)]) {
        let limit = 4.5 / (pairs.len() as f64).sqrt();
        let squares: Vec<_> = pairs.iter().map(|(a, b)| (a * a, b * b)).collect();
        for found in [correlation(pairs), correlation(&squares)] {
            assert!(found.abs() < limit, "{what}: {found}, of {limit}");
        }
    }

    #[test]
    fn a_stream_depends_on_seed_and_name_only() {
        let draw = |seed, name| Stream::new(seed, name).uniform();
        assert_eq!(Stream::of(3, &["alice", "/", "ir"]), Stream::new(3, "alice/ir"));
        assert_eq!(draw(1, "alice/ir"), draw(1, "alice/ir"));
        assert_ne!(draw(1, "alice/ir"), draw(2, "alice/ir"));
        assert_ne!(draw(1, "alice/ir"), draw(1, "bob/ir"));
    }

    #[test]
    fn a_stream_goes_on_where_a_snapshot_left_it() {
        let mut stream = Stream::new(3, "alice/ir");
        for _ in 0..17 {
            stream.normal();
        }
        let saved = postcard::to_allocvec(&stream).unwrap();
        assert!(saved.len() < 16, "a place, not the generator: {} bytes", saved.len());
        let mut restored: Stream = postcard::from_bytes(&saved).unwrap();
        assert_eq!(stream, restored);
        assert_eq!(stream.uniform(), restored.uniform());
    }

    /// N(0, 1), of which N(1, σ) of (3.1) is made.
    #[test]
    fn normal_deviates_have_mean_0_and_variance_1() {
        let mut stream = Stream::new(7, "test");
        let n = 100_000;
        let (mut sum, mut squares, mut beyond_two) = (0.0, 0.0, 0);
        for _ in 0..n {
            let x = stream.normal();
            sum += x;
            squares += x * x;
            beyond_two += usize::from(x.abs() > 2.0);
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < 0.01, "mean {}", sum / n);
        assert!((squares / n - 1.0).abs() < 0.02, "variance {}", squares / n);
        assert!((beyond_two as f64 / n - 0.0455).abs() < 0.003, "tail {beyond_two}");
    }

    #[test]
    fn deviates_of_scans_have_the_moments_and_the_tails_of_normal_ones() {
        let mut samples = scans(7, "test", 2000).as_flattened().to_vec();
        let n = samples.len() as f64;
        let moment = |power| samples.iter().map(|x: &f64| x.powi(power)).sum::<f64>() / n;
        // The variance of the mean of x^k is (E x^2k − (E x^k)²) / n.
        for (power, expected, variance) in [
            (1, 0.0, 1.0),
            (2, 1.0, 2.0),
            (3, 0.0, 15.0),
            (4, 3.0, 96.0),
            (5, 0.0, 945.0),
            (6, 15.0, 10_170.0),
        ] {
            let (found, limit) = (moment(power), 4.0 * f64::sqrt(variance / n));
            assert!((found - expected).abs() < limit, "moment {power}: {found}");
        }
        let n = samples.len() as u64;
        let beyond = |least: f64, side: f64| samples.iter().filter(|x| **x * side > least).count() as u64;
        for (least, probability) in [(1.0, 0.158_655_3), (2.0, 0.022_750_1)] {
            assert_rate(beyond(least, 1.0), n, probability);
            assert_rate(beyond(least, -1.0), n, probability);
        }
        for (least, probability) in [(3.0, 1.349_90e-3), (4.0, 3.167_12e-5)] {
            let found = [1.0, -1.0].map(|side| beyond(least, side));
            assert!(found.iter().all(|hits| rate(*hits, n, probability).fits()), "{least}: {found:?}");
        }
        assert_distributed(&mut samples, |scale| normal(0.0, scale));
    }

    #[test]
    fn each_ray_of_scans_has_normal_deviates() {
        let scans = scans(8, "test", 4000);
        // Of each part that is made at once, and the last one, which is not whole: first and second values of pairs.
        for ray in [0, 1, 7, 8, 63, 64, 65, 127, 128, 300, 511, 639, 640, 660, 661, 681] {
            let mut samples: Vec<_> = scans.iter().map(|scan| scan[ray]).collect();
            let outcome = crate::statistics::kolmogorov_smirnov(&mut samples, normal(0.0, 1.0));
            assert!(outcome.fits(), "ray {ray}: {outcome:?}");
        }
    }

    #[test]
    fn deviates_of_scans_are_independent() {
        let alice = scans(9, "alice/laser", 300);
        // Of rays beside each other; of the same lane, or of two values of a pair; and more.
        for apart in (1..=16).chain([21, 32, 42, 63, 64, 65, 128, 256, 640]) {
            let pairs: Vec<_> = alice
                .iter()
                .flat_map(|scan| scan.iter().copied().zip(scan[apart..].iter().copied()))
                .collect();
            assert_independent(&std::format!("{apart} apart"), &pairs);
        }
        let beside = |others: &[[f64; RAYS]]| -> Vec<_> {
            alice.as_flattened().iter().copied().zip(others.as_flattened().iter().copied()).collect()
        };
        assert_independent("scans", &beside(&alice[1..]));
        assert_independent("streams", &beside(&scans(9, "bob/laser", 300)));
        assert_independent("seeds", &beside(&scans(10, "alice/laser", 300)));
    }

    #[test]
    fn scans_go_on_where_a_snapshot_left_them() {
        let mut stream = Stream::new(3, "alice/laser");
        let draw = |stream: &mut Stream| {
            let mut values = vec![1.0; 100];
            stream.each_normal(&mut values, |value, deviate| value + 0.1 * deviate);
            (values, stream.uniform())
        };
        draw(&mut stream);
        let saved = postcard::to_allocvec(&stream).unwrap();
        assert!(saved.len() < 16, "a place, not the generators: {} bytes", saved.len());
        let mut restored: Stream = postcard::from_bytes(&saved).unwrap();
        assert_eq!(draw(&mut stream), draw(&mut restored));
        assert_eq!(stream, restored);
    }

    #[test]
    fn integers_cover_their_range_evenly() {
        let mut stream = Stream::new(7, "test");
        let mut counts = [0_i32; 8];
        for _ in 0..80_000 {
            counts[stream.below(8) as usize] += 1;
        }
        assert!(counts.iter().all(|&n| (n - 10_000).abs() < 500), "{counts:?}");
    }
}
