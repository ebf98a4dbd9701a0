//! Noise of a sensor's readings: Wahde 2016, Eq. (3.1), and what §3.2.2 says without an equation.
//!
//! Of the reading S of a component the noise makes
//!
//! Ŝ = (S g + o + b) N(1, σₘ) + N(0, σₐ) + U(±w) + spike, or the value of a dropout,
//!
//! with the gain g and the offset o of the specimen and its drifting bias b. With σₘ only this is (3.1).
//!
//! Deviations. All but the factor N(1, σₘ) is ours. The notes say that "other distributions (e.g. a uniform
//! distribution) can be used as well" and that "even sensors that are supposed to be identical often show
//! very different characteristics in practice"; they give no numbers.
//!
//! These choices were made:
//!
//! - Gains, offsets, drifts and the normal and uniform noise of two components are independent: they are
//!   noise of what measures, and each component is measured for itself.
//! - A dropout or a spike happens to a whole reading. They are faults of what all components share: the
//!   supply, the bus, the transfer that fails. A dropout then has the same value in all components; a spike
//!   has another height in each.
//! - Kinds that are off draw nothing. Those that are on draw equally often at each reading, whether a spike
//!   or a dropout happens or not; so two runs that differ in nothing but a probability or a standard
//!   deviation have otherwise the same noise.
//! - For a value S of a scan of 32 and more S N(1, σₘ) + N(0, σₐ) is drawn as what it is, N(S, √(σₘ² S² + σₐ²)): it takes
//!   one deviate.
//! - Nothing is clamped or wrapped here. The device knows what its readings can be.

use alloc::boxed::Box;

use baudbot_geometry::math;
use serde::{Deserialize, Serialize};

use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Between, Number, Share, Sigma};

/// Noise of one sensor, applied to each of its readings in the order of the fields. 0 and `None` are off.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Noise {
    /// Standard deviation of the specimen's gain, N(1, σ), drawn once per run.
    #[serde(with = "Number::<Sigma>")]
    pub gain_spread: f64,
    /// Standard deviation of the specimen's offset, drawn once per run, in the reading's unit.
    #[serde(with = "Number::<Sigma>")]
    pub offset_spread: f64,
    /// Bias that changes slowly at random.
    pub drift: Option<Drift>,
    /// σ of Eq. (3.1): each reading is multiplied by an N(1, σ).
    #[serde(with = "Number::<Sigma>")]
    pub multiplicative: f64,
    /// Standard deviation of the noise added to each reading, in the reading's unit.
    #[serde(with = "Number::<Sigma>")]
    pub additive: f64,
    /// Half width of the uniform noise added to each reading, in the reading's unit.
    #[serde(with = "Number::<Distance>")]
    pub uniform: f64,
    /// Occasional readings that are far off.
    pub spikes: Option<Spikes>,
    /// Occasional readings that fail.
    pub dropout: Option<Dropout>,
}

/// A bias that wanders: a Gauss–Markov process of first order (Ornstein and Uhlenbeck's), stationary from the
/// start of the run. Its values at two instants Δt apart have the correlation exp(−Δt/τ).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Drift {
    /// Standard deviation of the bias at any instant, in the reading's unit.
    #[serde(with = "Number::<Sigma>")]
    pub sigma: f64,
    /// Time constant of the bias, after which 63 % of its old value has decayed.
    #[serde(with = "Number::<TimeConstant>")]
    pub time_constant_s: f64,
}

/// Occasional readings that are far off.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spikes {
    /// Probability that a reading has a spike.
    #[serde(with = "Number::<Share>")]
    pub probability: f64,
    /// Half width of the uniform number added to each value, in the value's unit.
    #[serde(with = "Number::<Distance>")]
    pub magnitude: f64,
}

/// Occasional readings that fail.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Dropout {
    /// Probability that a reading fails.
    #[serde(with = "Number::<Share>")]
    pub probability: f64,
    /// Value of all components of a failed reading.
    #[serde(with = "Number::<Reading>")]
    pub value: f64,
}

/// A number that a reading may be, in any unit.
type Reading = Between<-1_000_000_000, 1_000_000_000>;
/// How far a reading may be off, in any unit.
type Distance = Between<0, 1_000_000_000>;

baudbot_fields::rules! {
    /// The time constant of a bias, in seconds.
    TimeConstant: Positive, 1e-6, 1e9;
}

/// The part of the noise that a specimen keeps from reading to reading. Each list has an entry a component, or none
/// if it is off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NoiseState {
    gains: Box<[f64]>,
    offsets: Box<[f64]>,
    /// The biases as they were at `drifted_at`.
    drifts: Box<[f64]>,
    drifted_at: SimTime,
}

impl Noise {
    /// Whether readings stay as they are and nothing is drawn.
    pub fn is_none(&self) -> bool {
        let sigmas =
            [self.gain_spread, self.offset_spread, self.drift_sigma(), self.multiplicative, self.additive];
        sigmas == [0.0; 5] && self.uniform == 0.0 && self.spikes().is_none() && self.dropout().is_none()
    }

    /// Whether a reading of 0 stays 0 whatever is drawn: the draws are made all the same.
    pub(crate) fn leaves_0(&self, stream: &mut Stream) -> bool {
        let is_factor_alone = [self.gain_spread, self.offset_spread, self.additive, self.uniform] == [0.0; 4]
            && self.drift.is_none()
            && self.spikes.is_none()
            && self.dropout.is_none();
        // Unless the factor could be negative, and the 0 too.
        let leaves = is_factor_alone && self.multiplicative.abs() < 1.0 / Stream::MOST_NORMAL;
        if leaves && self.multiplicative != 0.0 {
            stream.skip_normal();
        }
        leaves
    }

    /// A specimen of a sensor with so many components, at the start of the run. `specimen` should not be the
    /// stream of the readings' noise, so that another specimen makes no difference to that.
    pub(crate) fn start(&self, components: usize, specimen: &mut Stream) -> NoiseState {
        NoiseState {
            gains: spread(components, 1.0, self.gain_spread, specimen),
            offsets: spread(components, 0.0, self.offset_spread, specimen),
            drifts: spread(components, 0.0, self.drift_sigma(), specimen),
            drifted_at: SimTime::ZERO,
        }
    }

    /// Makes a disturbed reading of a true one that is taken at `now`, with as many components as the state.
    pub(crate) fn disturb(
        &self,
        state: &mut NoiseState,
        now: SimTime,
        values: &mut [f64],
        stream: &mut Stream,
    ) {
        if let Some(drift) = self.drift {
            state.drift(&drift, now, stream);
        }
        pair(values, &state.gains, |value, gain| value * gain);
        pair(values, &state.offsets, |value, offset| value + offset);
        pair(values, &state.drifts, |value, bias| value + bias);
        if values.len() >= MANY {
            self.disturb_many(values, stream);
        } else {
            each(values, |value| multiplicative(value, self.multiplicative, stream));
            each(values, |value| additive(value, self.additive, stream));
        }
        if self.uniform != 0.0 {
            each(values, |value| value + within(self.uniform, stream));
        }
        if let Some(spikes) = self.spikes() {
            let happens = stream.uniform() < spikes.probability;
            each(values, |value| {
                let height = within(spikes.magnitude, stream);
                if happens { value + height } else { value }
            });
        }
        if let Some(dropout) = self.dropout()
            && stream.uniform() < dropout.probability
        {
            values.fill(dropout.value);
        }
    }

    /// The normal noise of the many values of a scan.
    fn disturb_many(&self, values: &mut [f64], stream: &mut Stream) {
        let (multiplicative, additive) = (self.multiplicative, self.additive);
        if multiplicative != 0.0 && additive != 0.0 {
            let variance = additive * additive;
            stream.each_normal(values, move |value, deviate| {
                let sigma = multiplicative * value;
                value + math::sqrt(sigma * sigma + variance) * deviate
            });
        } else if multiplicative != 0.0 {
            stream.each_normal(values, move |value, deviate| value * (1.0 + multiplicative * deviate));
        } else if additive != 0.0 {
            stream.each_normal(values, move |value, deviate| value + additive * deviate);
        }
    }

    fn drift_sigma(&self) -> f64 {
        self.drift.map_or(0.0, |drift| drift.sigma)
    }

    fn spikes(&self) -> Option<Spikes> {
        self.spikes.filter(|spikes| spikes.probability > 0.0 && spikes.magnitude != 0.0)
    }

    fn dropout(&self) -> Option<Dropout> {
        self.dropout.filter(|dropout| dropout.probability > 0.0)
    }
}

impl NoiseState {
    /// Whether this specimen may have become what `other` is.
    pub(crate) fn may_become(&self, other: &Self) -> bool {
        let pairs =
            [(&self.gains, &other.gains), (&self.offsets, &other.offsets), (&self.drifts, &other.drifts)];
        pairs
            .into_iter()
            .all(|(own, other)| own.len() == other.len() && crate::sound::numbers(other.iter().copied()))
    }

    /// Takes the biases on to `now`: b' = b e^(−Δt/τ) + σ √(1 − e^(−2Δt/τ)) N(0, 1), which is exact for any
    /// Δt, so that a sensor that is read rarely drifts as one that is read often.
    fn drift(&mut self, drift: &Drift, now: SimTime, stream: &mut Stream) {
        let ratio = now.since(self.drifted_at) as f64 / (drift.time_constant_s * SECOND_NS as f64);
        let kept = math::exp(-ratio);
        // 1 − e^(−2x) = 2 tanh x / (1 + tanh x), which does not cancel when x is small.
        let tanh = math::tanh(ratio);
        let fresh = drift.sigma * math::sqrt(2.0 * tanh / (1.0 + tanh));
        each(&mut self.drifts, |bias| bias * kept + fresh * stream.normal());
        // Without biases nothing drifts, and the state stays as it is.
        if !self.drifts.is_empty() {
            self.drifted_at = now;
        }
    }
}

/// Multiplicative noise, Eq. (3.1): the reading times N(1, σ). Draws nothing if σ is 0.
pub(crate) fn multiplicative(reading: f64, sigma: f64, stream: &mut Stream) -> f64 {
    if sigma == 0.0 {
        return reading;
    }
    reading * (1.0 + sigma * stream.normal())
}

/// Additive noise: the reading plus N(0, σ), in the reading's unit. Draws nothing if σ is 0.
pub(crate) fn additive(reading: f64, sigma: f64, stream: &mut Stream) -> f64 {
    if sigma == 0.0 {
        return reading;
    }
    // An infinite distance stays so.
    if reading == f64::INFINITY {
        stream.skip_normal();
        return reading;
    }
    reading + sigma * stream.normal()
}

/// From so many components on, their normal noise is made at once.
const MANY: usize = 32;

/// So many N(mean, σ); none, and nothing is drawn, if σ is 0.
fn spread(components: usize, mean: f64, sigma: f64, stream: &mut Stream) -> Box<[f64]> {
    let components = if sigma == 0.0 { 0 } else { components };
    (0..components).map(|_| mean + sigma * stream.normal()).collect()
}

/// Uniform in [−half width, half width).
fn within(half_width: f64, stream: &mut Stream) -> f64 {
    half_width * (2.0 * stream.uniform() - 1.0)
}

fn each(values: &mut [f64], mut change: impl FnMut(f64) -> f64) {
    for value in values {
        *value = change(*value);
    }
}

/// Leaves the values as they are, signs of zeros included, if what they are paired with is off.
fn pair(values: &mut [f64], with: &[f64], change: impl Fn(f64, f64) -> f64) {
    for (value, with) in values.iter_mut().zip(with) {
        *value = change(*value, *with);
    }
}

#[cfg(test)]
mod tests {
    use alloc::boxed::Box;
    use alloc::format;
    use alloc::vec::Vec;

    use baudbot_geometry::math;

    use super::{Drift, Dropout, Noise, NoiseState, Spikes};
    use crate::random::Stream;
    use crate::statistics::{
        self, SAMPLES, assert_distributed, assert_rate, chi_squared, correlation, kolmogorov_smirnov, normal,
    };
    use crate::time::{SECOND_NS, SimTime};

    const DRIFT: Drift = Drift { sigma: 0.3, time_constant_s: 20.0 };

    /// Many disturbed readings of one sensor.
    fn readings<const N: usize>(noise: &Noise, truth: [f64; N]) -> Vec<[f64; N]> {
        let (mut specimen, mut stream) = (Stream::new(3, "a/ir:specimen"), Stream::new(3, "a/ir"));
        let mut state = noise.start(N, &mut specimen);
        let read = |i: usize| {
            let mut values = truth;
            noise.disturb(&mut state, SimTime::from_ns(i as u64), &mut values, &mut stream);
            values
        };
        (0..SAMPLES).map(read).collect()
    }

    fn singles(noise: &Noise, truth: f64) -> Vec<f64> {
        readings(noise, [truth]).into_iter().map(|[value]| value).collect()
    }

    /// The first component's reading at each instant, in a run that no other call has.
    fn run<const N: usize>(noise: &Noise, run: usize, truth: f64, at_s: [f64; N]) -> [f64; N] {
        let name = |suffix: &str| format!("a/{run}{suffix}");
        let (mut specimen, mut stream) = (Stream::new(5, &name(":specimen")), Stream::new(5, &name("")));
        let mut state = noise.start(2, &mut specimen);
        at_s.map(|at_s| {
            let mut values = [truth; 2];
            let now = SimTime::from_ns((at_s * SECOND_NS as f64) as u64);
            noise.disturb(&mut state, now, &mut values, &mut stream);
            values[0]
        })
    }

    fn everything() -> Noise {
        Noise {
            gain_spread: 0.1,
            offset_spread: 0.2,
            drift: Some(DRIFT),
            multiplicative: 0.03,
            additive: 0.04,
            uniform: 0.05,
            spikes: Some(Spikes { probability: 0.2, magnitude: 2.0 }),
            dropout: Some(Dropout { probability: 0.1, value: -7.0 }),
        }
    }

    /// (3.1).
    #[test]
    fn multiplicative_noise_is_a_normal_factor_3_1() {
        let mut samples = singles(&Noise { multiplicative: 0.1, ..Noise::default() }, 2.0);
        assert_distributed(&mut samples, |scale| normal(2.0, 0.2 * scale));
    }

    #[test]
    fn additive_noise_is_normal_whatever_the_reading() {
        for truth in [0.0, 2.0] {
            let mut samples = singles(&Noise { additive: 0.1, ..Noise::default() }, truth);
            assert_distributed(&mut samples, |scale| normal(truth, 0.1 * scale));
        }
    }

    #[test]
    fn uniform_noise_has_its_half_width() {
        let mut samples = singles(&Noise { uniform: 0.1, ..Noise::default() }, 2.0);
        assert_distributed(&mut samples, |scale| statistics::uniform(2.0 - 0.1 * scale, 2.0 + 0.1 * scale));
    }

    #[test]
    fn spikes_come_at_their_rate_with_their_magnitude_to_whole_readings() {
        let noise = Noise { spikes: everything().spikes, ..Noise::default() };
        let readings = readings(&noise, [1.0, 5.0]);
        let (spikes, others): (Vec<_>, Vec<_>) = readings.into_iter().partition(|&[x, _]| x != 1.0);
        assert_rate(spikes.len() as u64, SAMPLES as u64, 0.2);
        assert!(others.iter().all(|&reading| reading == [1.0, 5.0]), "a spike in the second component only");

        for (i, truth) in [1.0, 5.0].into_iter().enumerate() {
            let mut heights: Vec<_> = spikes.iter().map(|reading| reading[i] - truth).collect();
            assert_distributed(&mut heights, |scale| statistics::uniform(-2.0 * scale, 2.0 * scale));
        }
        let heights: Vec<_> = spikes.iter().map(|&[x, y]| (x, y)).collect();
        assert!(correlation(&heights).abs() < 0.03, "{}", correlation(&heights));
    }

    #[test]
    fn dropouts_come_at_their_rate_to_whole_readings_and_nothing_disturbs_their_value() {
        let readings = readings(&everything(), [1.0, 5.0]);
        let dropouts = readings.iter().filter(|&&reading| reading == [-7.0, -7.0]).count();
        let partial = readings.iter().filter(|reading| reading.contains(&-7.0)).count() - dropouts;
        assert_eq!(partial, 0, "readings of which only one component failed");
        assert_rate(dropouts as u64, SAMPLES as u64, 0.1);
    }

    #[test]
    fn spikes_and_dropouts_are_independent_and_come_singly() {
        let Noise { spikes, dropout, .. } = everything();
        let noise = Noise { spikes, dropout, ..Noise::default() };
        let kinds: Vec<_> = singles(&noise, 1.0)
            .into_iter()
            .map(|value| if value == -7.0 { 2 } else { usize::from(value != 1.0) })
            .collect();
        let mut pairs = [0; 9];
        for pair in kinds.chunks_exact(2) {
            pairs[3 * pair[0] + pair[1]] += 1;
        }
        let chances = [0.9 * 0.8, 0.9 * 0.2, 0.1];
        let expected: Vec<_> = chances.iter().flat_map(|x| chances.map(|y| x * y)).collect();
        let outcome = chi_squared(&pairs, &expected);
        assert!(outcome.fits(), "{pairs:?}: {outcome:?}");
    }

    #[test]
    fn specimens_differ_in_gain_and_keep_it_for_the_run() {
        let noise = Noise { gain_spread: 0.1, ..Noise::default() };
        let mut samples: Vec<_> = (0..SAMPLES)
            .map(|i| {
                let [first, last] = run(&noise, i, 2.0, [0.0, 100.0]);
                assert_eq!(first, last, "the gain changed");
                first
            })
            .collect();
        assert!(kolmogorov_smirnov(&mut samples[..2000].to_vec(), normal(2.0, 0.2)).fits());
        assert_distributed(&mut samples, |scale| normal(2.0, 0.2 * scale));
    }

    #[test]
    fn specimens_differ_in_offset_and_keep_it_for_the_run() {
        let noise = Noise { offset_spread: 0.1, ..Noise::default() };
        let mut samples: Vec<_> = (0..SAMPLES)
            .map(|i| {
                let [first, last] = run(&noise, i, 2.0, [0.0, 100.0]);
                assert_eq!(first, last, "the offset changed");
                first
            })
            .collect();
        assert!(kolmogorov_smirnov(&mut samples[..2000].to_vec(), normal(2.0, 0.1)).fits());
        assert_distributed(&mut samples, |scale| normal(2.0, 0.1 * scale));
    }

    #[test]
    fn drift_has_its_standard_deviation_at_the_start_and_at_any_later_reading() {
        let noise = Noise { drift: Some(DRIFT), ..Noise::default() };
        let runs: Vec<_> = (0..SAMPLES).map(|i| run(&noise, i, 1.0, [0.0, 0.01, 5.0, 45.0, 1e6])).collect();
        for reading in 0..5 {
            let mut samples: Vec<_> = runs.iter().map(|values| values[reading]).collect();
            assert_distributed(&mut samples, |scale| normal(1.0, 0.3 * scale));
        }
    }

    #[test]
    fn drift_is_forgotten_exponentially_however_often_it_is_read() {
        let noise = Noise { drift: Some(DRIFT), ..Noise::default() };
        let runs: Vec<_> = (0..SAMPLES)
            .map(|i| run(&noise, i, 1.0, [3.0, 3.2, 5.0, 7.0, 9.0, 11.0, 13.0, 33.0, 333.0]))
            .collect();
        for (from, to, ratio) in
            [(0, 1, 0.01), (0, 2, 0.1), (0, 6, 0.5), (2, 6, 0.4), (6, 7, 1.0), (0, 8, 16.5)]
        {
            let pairs: Vec<_> = runs.iter().map(|values| (values[from], values[to])).collect();
            let (found, expected) = (correlation(&pairs), math::exp(-ratio));
            // Four standard errors.
            let tolerance = 4.0 * (1.0 - expected * expected) / math::sqrt(SAMPLES as f64);
            assert!(
                (found - expected).abs() < tolerance,
                "{found} after {ratio} time constants, not {expected}"
            );
        }
    }

    #[test]
    fn components_have_noise_of_their_own() {
        let noise = Noise { spikes: None, dropout: None, ..everything() };
        let (mut gains, mut readings_of_run) = (Vec::new(), Vec::new());
        for i in 0..20_000 {
            let mut specimen = Stream::new(i, "specimen");
            let mut state = noise.start(2, &mut specimen);
            let mut values = [1.0; 2];
            noise.disturb(&mut state, SimTime::ZERO, &mut values, &mut Stream::new(i, "a"));
            gains.push((state.gains[0], state.gains[1]));
            readings_of_run.push((values[0], values[1]));
        }
        for pairs in [gains, readings_of_run] {
            assert!(correlation(&pairs).abs() < 0.03, "{}", correlation(&pairs));
        }
    }

    #[test]
    fn readings_are_disturbed_in_the_order_of_the_fields() {
        let noise = Noise { dropout: None, ..everything() };
        let mut state = NoiseState {
            gains: Box::new([2.0]),
            offsets: Box::new([10.0]),
            drifts: Box::new([100.0]),
            drifted_at: SimTime::ZERO,
        };
        let mut stream = Stream::new(1, "a");
        let mut expected = stream.clone();
        let mut values = [3.0];
        // No time has passed: the bias is as it was.
        noise.disturb(&mut state, SimTime::ZERO, &mut values, &mut stream);

        expected.normal();
        let mut value = (3.0 * 2.0 + 10.0 + 100.0) * (1.0 + 0.03 * expected.normal());
        value += 0.04 * expected.normal();
        value += 0.05 * (2.0 * expected.uniform() - 1.0);
        let spike = expected.uniform() < 0.2;
        let height = 2.0 * (2.0 * expected.uniform() - 1.0);
        value += if spike { height } else { 0.0 };
        assert_eq!((values, stream), ([value], expected));
    }

    #[test]
    fn what_is_off_draws_nothing_and_changes_no_bit() {
        let off = Noise {
            drift: Some(Drift { sigma: 0.0, ..DRIFT }),
            spikes: Some(Spikes { probability: 0.0, magnitude: 1.0 }),
            dropout: Some(Dropout { probability: 0.0, value: 1.0 }),
            ..Noise::default()
        };
        for noise in [Noise::default(), off] {
            assert!(noise.is_none());
            let mut stream = Stream::new(1, "a");
            let mut state = noise.start(2, &mut stream);
            let mut values = [-0.0, 0.1];
            let before = (state.clone(), stream.clone());
            noise.disturb(&mut state, SimTime::from_ns(9), &mut values, &mut stream);
            assert_eq!(values.map(f64::to_bits), [-0.0_f64, 0.1].map(f64::to_bits));
            assert_eq!((state, stream), before);
        }
    }

    #[test]
    fn every_kind_alone_is_noise() {
        let (all, none) = (everything(), Noise::default());
        let kinds = [
            Noise { gain_spread: all.gain_spread, ..none.clone() },
            Noise { offset_spread: all.offset_spread, ..none.clone() },
            Noise { drift: all.drift, ..none.clone() },
            Noise { multiplicative: all.multiplicative, ..none.clone() },
            Noise { additive: all.additive, ..none.clone() },
            Noise { uniform: all.uniform, ..none.clone() },
            Noise { spikes: all.spikes, ..none.clone() },
            Noise { dropout: all.dropout, ..none },
        ];
        for noise in kinds {
            assert!(!noise.is_none(), "{noise:?}");
        }
    }

    #[test]
    fn multiplicative_noise_alone_draws_one_deviate_a_component_and_has_the_bits_of_3_1() {
        let noise = Noise { multiplicative: 0.02, ..Noise::default() };
        let (mut specimen, mut stream) = (Stream::new(1, "a:specimen"), Stream::new(1, "a"));
        let mut alone = stream.clone();
        let mut state = noise.start(1, &mut specimen);
        let mut values = [0.7];
        noise.disturb(&mut state, SimTime::ZERO, &mut values, &mut stream);
        assert_eq!(values, [super::multiplicative(0.7, 0.02, &mut alone)]);
        assert_eq!((stream, specimen), (alone, Stream::new(1, "a:specimen")));
    }

    #[test]
    fn the_values_of_a_scan_have_the_noise_of_one_alone_and_draw_as_often_whatever_it_is() {
        const N: usize = 64;
        let truth = core::array::from_fn(|i| 0.5 * i as f64);
        for (multiplicative, additive) in [(0.02, 0.0), (0.0, 0.1), (0.02, 0.1)] {
            let noise = Noise { multiplicative, additive, ..Noise::default() };
            let mut streams = [Stream::new(4, "a"), Stream::new(4, "a")];
            streams[1].each_normal(&mut [0.0; N], |value, _| value);
            let mut state = noise.start(N, &mut Stream::new(4, "a:specimen"));
            let mut samples = Vec::new();
            for round in 0..SAMPLES / N {
                let mut values: [f64; N] = truth;
                noise.disturb(&mut state, SimTime::ZERO, &mut values, &mut streams[0]);
                if round == 0 {
                    assert_eq!(streams[0], streams[1]);
                }
                // The first value is 0, which a factor leaves as it is.
                let scaled = values.iter().zip(truth).skip(1).map(|(value, truth)| {
                    let [factor, offset] = [multiplicative * truth, additive];
                    (value - truth) / math::sqrt(factor * factor + offset * offset)
                });
                samples.extend(scaled);
            }
            assert_distributed(&mut samples, |scale| normal(0.0, scale));
        }
    }

    #[test]
    fn a_probability_changes_no_other_noise() {
        let rare = Noise { dropout: Some(Dropout { probability: 0.01, value: -7.0 }), ..everything() };
        let often = readings(&everything(), [1.0, 5.0]);
        let rarely = readings(&rare, [1.0, 5.0]);
        assert!(often.iter().zip(&rarely).all(|(often, rarely)| often == rarely || *often == [-7.0, -7.0]));
    }

    #[test]
    fn a_specimen_goes_on_where_a_snapshot_left_it() {
        let noise = everything();
        let mut stream = Stream::new(1, "a");
        let mut state = noise.start(2, &mut Stream::new(1, "a:specimen"));
        let read = |state: &mut NoiseState, stream: &mut Stream, ns| {
            let mut values = [1.0; 2];
            noise.disturb(state, SimTime::from_ns(ns), &mut values, stream);
            values
        };
        read(&mut state, &mut stream, 5 * SECOND_NS);
        let saved = postcard::to_allocvec(&(&state, &stream)).unwrap();
        let (mut restored, mut at): (NoiseState, Stream) = postcard::from_bytes(&saved).unwrap();
        assert_eq!(read(&mut state, &mut stream, 9 * SECOND_NS), read(&mut restored, &mut at, 9 * SECOND_NS));
        assert_eq!(state, restored);
    }
}
