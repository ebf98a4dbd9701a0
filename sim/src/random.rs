//! Named streams of random numbers.
//!
//! Every noisy part owns the stream that is named after it (`"alice/ir_left"`), seeded from the scenario's
//! seed and that name. So adding a sensor changes no other sensor's noise, and the order in which parts are
//! read changes nothing. The generator is PCG-64, named explicitly because `rand`'s standard generator may
//! change between versions; the normal deviate is our own on `libm`, because a platform's `ln` and `cos`
//! differ in the last bits.

use baudbot_geometry::{normal, vectors};
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

/// What a stream is and how far it is: all that a snapshot needs, since the generator can be wound forward.
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

    /// Changes each value with a normal deviate of its own, as if these were drawn one by one.
    pub fn each_normal(&mut self, values: &mut [f64], change: impl Fn(f64, f64) -> f64 + Copy) {
        let (mut us, mut vs, mut deviates) = ([0.0; AT_ONCE], [0.0; AT_ONCE], [0.0; AT_ONCE]);
        for values in values.chunks_mut(AT_ONCE) {
            let n = values.len();
            let mut generator = self.generator.clone();
            for (u, v) in us[..n].iter_mut().zip(&mut vs[..n]) {
                (*u, *v) = (unit(generator.next_u64()), unit(generator.next_u64()));
            }
            self.generator = generator;
            self.place.drawn += 2 * n as u64;
            normal::deviates(&us[..n], &vs[..n], &mut deviates[..n]);
            vectors::each_with(values, &deviates, change);
        }
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

/// So many normal deviates are computed at once.
const AT_ONCE: usize = 64;

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

/// Where a 64-bit FNV-1a begins.
pub(crate) const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// What a byte makes of a 64-bit FNV-1a.
pub(crate) const fn fnv1a_step(hash: u64, byte: u8) -> u64 {
    (hash ^ byte as u64).wrapping_mul(0x0000_0100_0000_01b3)
}

#[cfg(test)]
mod tests {
    use super::Stream;

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
    fn integers_cover_their_range_evenly() {
        let mut stream = Stream::new(7, "test");
        let mut counts = [0_i32; 8];
        for _ in 0..80_000 {
            counts[stream.below(8) as usize] += 1;
        }
        assert!(counts.iter().all(|&n| (n - 10_000).abs() < 500), "{counts:?}");
    }
}
