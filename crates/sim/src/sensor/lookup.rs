//! Readings from samples of a real sensor: Wahde 2016, Eq. (3.2).
//!
//! Ŝ = ŝ₁ + (L − L₁) / (L₂ − L₁) (ŝ₂ − ŝ₁)
//!
//! L is the distance, L₁ and L₂ are the measured distances next to it, and ŝ₁ and ŝ₂ are samples chosen at
//! random from those that were taken there.
//!
//! Deviations. The notes mention samples at several angles, but have no equation for them. Here four samples
//! are chosen, at two distances and two angles, and interpolated bilinearly: first between the angles, then
//! (3.2). The notes leave open what a distance beyond the measured ones reads: here what the last one does.
//! (3.2) is computed as a weighted mean, which gives exactly the samples where the sensor was measured.

use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::FRAC_PI_2;

use serde::Deserialize;

use crate::heap::{elements, list};
use crate::random::Stream;
use baudbot_fields::{FieldError, Path};

/// Samples of a real sensor, taken at several distances and, maybe, angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Lookup {
    distances_m: Vec<f64>,
    /// Empty if the samples do not depend on the angle.
    angles_rad: Vec<f64>,
    /// By distance and angle; no list is empty.
    samples: Vec<Vec<Vec<f64>>>,
}

/// The fields of a table of samples.
#[derive(Debug, Deserialize)]
#[serde(expecting = "a table of samples (only the program that reads scenario files can look at a file)")]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sheet {
    /// Distances at which samples were taken. Range: at least 2 distances; each not negative, increasing.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 0)), length(min = 2)))]
    distances_m: Vec<f64>,
    /// Angles of incidence at which samples were taken. Range: none or at least 2 angles; each 0 to π/2, increasing.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 0, max = FRAC_PI_2))))]
    #[serde(default)]
    angles_rad: Vec<f64>,
    /// Samples, as lists of readings. Range: one row per distance, with one list per angle, or one list if there are
    /// no angles; no list empty.
    samples: Vec<Vec<Vec<f64>>>,
}

impl Sheet {
    /// The samples, whose table stands at `path`.
    ///
    /// # Errors
    /// As [`Lookup::new`], with the whole path.
    pub fn lookup(self, path: &Path) -> Result<Lookup, FieldError> {
        Lookup::new(self.distances_m, self.angles_rad, self.samples)
            .map_err(|error| path.field(&error.path).error(error.problem))
    }
}

impl Lookup {
    /// The bytes that it has on the heap.
    pub(super) fn heap_bytes(&self) -> usize {
        let samples = list(&self.samples, |by_angle| list(by_angle, elements));
        elements(&self.distances_m) + elements(&self.angles_rad) + samples
    }

    /// A table of `samples[distance][angle]`, each a list of readings. The distances are in metres, at least
    /// two and increasing. The angles are those of incidence, in radians, between a ray and the normal of the
    /// surface that it meets: at least two and increasing from 0 to π/2, or none if the samples do not depend
    /// on the angle, which is then a single column: `samples[distance][0]`.
    ///
    /// # Errors
    /// Says which distance, angle or sample is wrong, or where samples are missing.
    pub fn new(
        distances_m: Vec<f64>,
        angles_rad: Vec<f64>,
        samples: Vec<Vec<Vec<f64>>>,
    ) -> Result<Self, FieldError> {
        check_axis("distances_m", &distances_m, f64::MAX)?;
        if !angles_rad.is_empty() {
            check_axis("angles_rad", &angles_rad, FRAC_PI_2)?;
        }
        if samples.len() != distances_m.len() {
            let problem = format!("{} rows for {} distances", samples.len(), distances_m.len());
            return Err(FieldError::new("samples", problem));
        }
        for (i, row) in samples.iter().enumerate() {
            check_row(i, row, angles_rad.len())?;
        }
        Ok(Self { distances_m, angles_rad, samples })
    }

    /// Whether the samples depend on the angle of incidence.
    pub(crate) fn has_angles(&self) -> bool {
        !self.angles_rad.is_empty()
    }

    /// A reading at this distance, in metres, and this angle of incidence, in radians, whose sign does not
    /// matter. What lies beyond the measured distances or angles is read as the nearest of them; whether
    /// anything is read at all there is for the caller to say.
    ///
    /// Always chooses two samples from the stream, four if there are angles: at the nearer
    /// distance before the farther, there at the smaller angle before the larger. Where a single
    /// sample or only one of them matters, it is drawn all the same, so that the number of draws does not depend
    /// on where the robot is. Without a stream, that is without noise, a place's samples give their mean.
    pub(crate) fn read(&self, distance_m: f64, angle_rad: f64, mut stream: Option<&mut Stream>) -> f64 {
        let (near, weight) = bracket(&self.distances_m, distance_m);
        let mut at = |distance: usize| {
            let row = &self.samples[distance];
            if self.angles_rad.is_empty() {
                return choose(&row[0], stream.as_deref_mut());
            }
            let (smaller, weight) = bracket(&self.angles_rad, angle_rad.abs());
            let sample = choose(&row[smaller], stream.as_deref_mut());
            interpolate(sample, choose(&row[smaller + 1], stream.as_deref_mut()), weight)
        };
        let sample = at(near);
        interpolate(sample, at(near + 1), weight)
    }

    /// Mean and variance of the readings at this distance, in metres, and this angle of incidence, in radians, over the
    /// samples that may be chosen there.
    #[must_use]
    pub fn moments(&self, distance_m: f64, angle_rad: f64) -> (f64, f64) {
        let (near, weight) = bracket(&self.distances_m, distance_m);
        let at = |distance: usize| {
            let row = &self.samples[distance];
            if self.angles_rad.is_empty() {
                return moments(&row[0]);
            }
            let (smaller, weight) = bracket(&self.angles_rad, angle_rad.abs());
            between(moments(&row[smaller]), moments(&row[smaller + 1]), weight)
        };
        between(at(near), at(near + 1), weight)
    }
}

/// Mean and variance of one of the samples, all equally likely.
fn moments(samples: &[f64]) -> (f64, f64) {
    let mean = choose(samples, None);
    let squares: f64 = samples.iter().map(|sample| (sample - mean) * (sample - mean)).sum();
    (mean, squares / samples.len() as f64)
}

/// Mean and variance of (3.2) between independent readings.
fn between(from: (f64, f64), to: (f64, f64), weight: f64) -> (f64, f64) {
    let share = 1.0 - weight;
    (interpolate(from.0, to.0, weight), share * share * from.1 + weight * weight * to.1)
}

/// One of the samples, all equally likely, or their mean.
fn choose(samples: &[f64], stream: Option<&mut Stream>) -> f64 {
    match stream {
        Some(stream) => samples[stream.below(samples.len() as u32) as usize],
        None => samples.iter().sum::<f64>() / samples.len() as f64,
    }
}

/// The interval of the axis that `x` is in, and the fraction of the way through it, in [0, 1].
fn bracket(axis: &[f64], x: f64) -> (usize, f64) {
    let above = axis.partition_point(|&at| at <= x).clamp(1, axis.len() - 1);
    let (from, to) = (axis[above - 1], axis[above]);
    (above - 1, ((x - from) / (to - from)).clamp(0.0, 1.0))
}

/// Eq. (3.2).
fn interpolate(from: f64, to: f64, weight: f64) -> f64 {
    (1.0 - weight) * from + weight * to
}

fn check_axis(name: &str, axis: &[f64], max: f64) -> Result<(), FieldError> {
    if axis.len() < 2 {
        return Err(FieldError::new(name, format!("must be at least 2 to interpolate, is {}", axis.len())));
    }
    for (i, &at) in axis.iter().enumerate() {
        let place = || format!("{name}[{i}]");
        if !at.is_finite() || at < 0.0 {
            return Err(FieldError::new(place(), format!("must be a number not below 0, is {at}")));
        }
        if at > max {
            return Err(FieldError::new(place(), format!("must not be above {max}, is {at}")));
        }
        if i > 0 && at <= axis[i - 1] {
            let problem = format!("must be above the one before, {}, is {at}", axis[i - 1]);
            return Err(FieldError::new(place(), problem));
        }
    }
    Ok(())
}

fn check_row(distance: usize, row: &[Vec<f64>], angles: usize) -> Result<(), FieldError> {
    if row.len() != angles.max(1) {
        let problem = match angles {
            0 => format!("without angles a row is one list of samples, has {}", row.len()),
            _ => format!("{} lists of samples for {angles} angles", row.len()),
        };
        return Err(FieldError::new(format!("samples[{distance}]"), problem));
    }
    for (angle, samples) in row.iter().enumerate() {
        let place = format!("samples[{distance}][{angle}]");
        if samples.is_empty() {
            return Err(FieldError::new(place, "a hole: there must be at least one sample"));
        }
        if let Some(i) = samples.iter().position(|sample| !sample.is_finite()) {
            let problem = format!("must be a finite number, is {}", samples[i]);
            return Err(FieldError::new(format!("{place}[{i}]"), problem));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use alloc::string::ToString;
    use alloc::vec;
    use alloc::vec::Vec;
    use core::f64::consts::FRAC_PI_2;

    use super::Lookup;
    use crate::random::Stream;
    use crate::statistics::{SAMPLES, chi_squared};

    /// Single samples, so that nothing is left to chance: 10 L + angle number.
    fn certain(distances: &[f64], angles: &[f64]) -> Lookup {
        let columns = angles.len().max(1);
        let samples = distances.iter().map(|d| (0..columns).map(|i| vec![10.0 * d + i as f64]).collect());
        Lookup::new(distances.to_vec(), angles.to_vec(), samples.collect()).unwrap()
    }

    fn read(lookup: &Lookup, distance_m: f64, angle_rad: f64) -> f64 {
        lookup.read(distance_m, angle_rad, Some(&mut Stream::new(1, "a")))
    }

    #[track_caller]
    fn assert_close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }

    /// (3.2), in the notes' own numbers.
    #[test]
    fn the_example_of_3_2_is_three_fifths_of_the_way_between_two_samples() {
        let samples = vec![vec![vec![0.9]], vec![vec![0.6]], vec![vec![0.5]], vec![vec![0.1]]];
        let lookup = Lookup::new(vec![0.15, 0.20, 0.25, 0.30], vec![], samples).unwrap();
        assert_close(read(&lookup, 0.23, 0.0), 0.6 + (0.23 - 0.20) / (0.25 - 0.20) * (0.5 - 0.6));
    }

    #[test]
    fn each_pair_of_samples_is_chosen_evenly() {
        let near: Vec<_> = (0..10).map(f64::from).collect();
        let far: Vec<_> = (0..7).map(|i| 100.0 * f64::from(i)).collect();
        let lookup = Lookup::new(vec![0.20, 0.25], vec![], vec![vec![near], vec![far]]).unwrap();
        let mut stream = Stream::new(1, "a");
        let mut counts = [0; 70];
        for _ in 0..5 * SAMPLES {
            // Half way the reading is half the sum of the two, which tells which they were.
            let sum = (2.0 * lookup.read(0.225, 0.0, Some(&mut stream)) + 0.5) as usize;
            counts[10 * (sum / 100) + sum % 100] += 1;
        }
        let outcome = chi_squared(&counts, &[1.0; 70]);
        assert!(outcome.fits(), "{counts:?}: {outcome:?}");
        let mut loaded = [1.0; 70];
        loaded[..10].fill(1.05);
        assert!(!chi_squared(&counts, &loaded).fits(), "cannot tell a sample that is chosen too often");
    }

    #[test]
    fn where_it_was_measured_a_reading_is_a_sample() {
        let lookup = certain(&[0.1, 0.2, 0.5], &[]);
        assert_eq!([0.1, 0.2, 0.5].map(|d| read(&lookup, d, 0.3)), [1.0, 2.0, 5.0]);
    }

    #[test]
    fn beyond_its_ends_a_table_goes_on_as_it_ends() {
        let lookup = certain(&[0.1, 0.2, 0.5], &[0.2, 0.4]);
        assert_eq!([0.0, 0.6, f64::INFINITY].map(|d| read(&lookup, d, 0.2)), [1.0, 5.0, 5.0]);
        assert_eq!([0.0, 0.5, FRAC_PI_2].map(|angle| read(&lookup, 0.2, angle)), [2.0, 3.0, 3.0]);
    }

    #[test]
    fn angles_interpolate_bilinearly_and_have_no_sign() {
        let samples = vec![vec![vec![1.0], vec![2.0]], vec![vec![4.0], vec![9.0]]];
        let lookup = Lookup::new(vec![0.1, 0.2], vec![0.0, 1.0], samples).unwrap();
        // 1.25 at the nearer distance, 5.25 at the farther.
        for angle in [0.25, -0.25] {
            assert_close(read(&lookup, 0.15, angle), 0.5 * (1.25 + 5.25));
        }
    }

    #[test]
    fn the_number_of_draws_does_not_depend_on_the_place() {
        for (angles, draws) in [(vec![], 2), (vec![0.0, 0.5, 1.0], 4)] {
            let lookup = certain(&[0.1, 0.2, 0.5], &angles);
            let mut expected = Stream::new(1, "a");
            (0..draws).for_each(|_| _ = expected.below(1));
            for (distance, angle) in [(0.0, 0.0), (0.15, 0.7), (0.2, 0.5), (9.0, 1.5)] {
                let mut stream = Stream::new(1, "a");
                lookup.read(distance, angle, Some(&mut stream));
                assert_eq!(stream, expected, "at {distance} m, {angle} rad");
            }
        }
    }

    #[test]
    fn moments_are_those_of_the_readings() {
        let samples = vec![vec![vec![1.0, 3.0], vec![2.0]], vec![vec![7.0, 4.0, 4.0], vec![9.0, 10.0]]];
        let lookup = Lookup::new(vec![0.1, 0.2], vec![0.0, 1.0], samples).unwrap();
        let mut stream = Stream::new(1, "a");
        for (distance, angle) in [(0.1, 0.0), (0.13, 0.25), (0.5, -0.5)] {
            let n = 4 * SAMPLES;
            let readings: Vec<_> = (0..n).map(|_| lookup.read(distance, angle, Some(&mut stream))).collect();
            let mean = readings.iter().sum::<f64>() / n as f64;
            let variance =
                readings.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n as f64;
            let (expected, spread) = lookup.moments(distance, angle);
            assert!((mean - expected).abs() < 5.0 * (spread / n as f64).sqrt(), "{mean}, not {expected}");
            assert!((variance / spread - 1.0).abs() < 0.05, "{variance}, not {spread}");
        }
    }

    #[test]
    fn no_distance_and_no_sample_makes_a_panic_or_a_nan_of_numbers() {
        let extreme = vec![vec![vec![f64::MIN]], vec![vec![f64::MAX]]];
        let lookup = Lookup::new(vec![0.0, f64::MAX], vec![], extreme).unwrap();
        for distance in [-1.0, 0.0, 1.0, f64::MAX / 2.0, f64::MAX, f64::INFINITY] {
            assert!(read(&lookup, distance, f64::INFINITY).is_finite(), "at {distance}");
        }
        read(&lookup, f64::NAN, f64::NAN);
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_place() {
        let one = || vec![vec![1.0]];
        let refusal = |distances: &[f64], angles: &[f64], samples: Vec<Vec<Vec<f64>>>| {
            Lookup::new(distances.to_vec(), angles.to_vec(), samples).unwrap_err().to_string()
        };
        let distances = |distances: &[f64]| refusal(distances, &[], vec![one(), one()]);
        let angles = |angles: &[f64]| refusal(&[0.1, 0.2], angles, vec![one(), one()]);
        let samples = |samples| refusal(&[0.1, 0.2], &[], samples);
        let found = [
            distances(&[0.1]),
            distances(&[0.2, 0.2]),
            distances(&[0.2, f64::NAN]),
            distances(&[-0.1, 0.2]),
            angles(&[0.1]),
            angles(&[0.5, 0.4]),
            angles(&[0.5, 1.6]),
            angles(&[0.5, 1.5]),
            samples(vec![one()]),
            samples(vec![one(), vec![vec![1.0], vec![1.0]]]),
            samples(vec![one(), vec![]]),
            samples(vec![one(), vec![vec![]]]),
            samples(vec![one(), vec![vec![1.0, f64::INFINITY]]]),
        ];
        assert_eq!(found, REFUSALS);
    }

    const REFUSALS: [&str; 13] = [
        "distances_m: must be at least 2 to interpolate, is 1",
        "distances_m[1]: must be above the one before, 0.2, is 0.2",
        "distances_m[1]: must be a number not below 0, is NaN",
        "distances_m[0]: must be a number not below 0, is -0.1",
        "angles_rad: must be at least 2 to interpolate, is 1",
        "angles_rad[1]: must be above the one before, 0.5, is 0.4",
        "angles_rad[1]: must not be above 1.5707963267948966, is 1.6",
        "samples[0]: 1 lists of samples for 2 angles",
        "samples: 1 rows for 2 distances",
        "samples[1]: without angles a row is one list of samples, has 2",
        "samples[1]: without angles a row is one list of samples, has 0",
        "samples[1][0]: a hole: there must be at least one sample",
        "samples[1][0][1]: must be a finite number, is inf",
    ];
}
