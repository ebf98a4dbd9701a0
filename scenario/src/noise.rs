//! From the tables `noise` and `lookup` of a sensor to [`Noise`] and [`Lookup`].

use alloc::vec::Vec;

use super::ScenarioError;
use super::check::Path;
use baudbot_sim::sensor::{Drift, Dropout, Lookup, Noise, Spikes};

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawNoise {
    gain_spread: f64,
    offset_spread: f64,
    drift: Option<RawDrift>,
    multiplicative: f64,
    additive: f64,
    uniform: f64,
    spikes: Option<RawSpikes>,
    dropout: Option<RawDropout>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDrift {
    sigma: f64,
    time_constant_s: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpikes {
    probability: f64,
    magnitude: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDropout {
    probability: f64,
    value: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(expecting = "a table of samples (only the program that reads scenario files can look at a file)")]
#[serde(deny_unknown_fields)]
pub(super) struct RawLookup {
    distances_m: Vec<f64>,
    #[serde(default)]
    angles_rad: Vec<f64>,
    samples: Vec<Vec<Vec<f64>>>,
}

/// The noise whose table stands at `path`.
pub(super) fn noise(path: &Path, raw: RawNoise) -> Result<Noise, ScenarioError> {
    Ok(Noise {
        gain_spread: path.sigma("gain_spread", raw.gain_spread)?,
        offset_spread: path.sigma("offset_spread", raw.offset_spread)?,
        drift: raw.drift.map(|raw| drift(&path.field("drift"), &raw)).transpose()?,
        multiplicative: path.sigma("multiplicative", raw.multiplicative)?,
        additive: path.sigma("additive", raw.additive)?,
        uniform: path.within("uniform", raw.uniform, 0.0, MAX_VALUE)?,
        spikes: raw.spikes.map(|raw| spikes(&path.field("spikes"), &raw)).transpose()?,
        dropout: raw.dropout.map(|raw| dropout(&path.field("dropout"), &raw)).transpose()?,
    })
}

/// The samples whose table stands at `path`.
pub(super) fn lookup(path: &Path, raw: RawLookup) -> Result<Lookup, ScenarioError> {
    Lookup::new(raw.distances_m, raw.angles_rad, raw.samples)
        .map_err(|error| path.field(&error.place).error(error.problem))
}

fn drift(path: &Path, raw: &RawDrift) -> Result<Drift, ScenarioError> {
    path.positive("time_constant_s", raw.time_constant_s)?;
    Ok(Drift {
        sigma: path.sigma("sigma", raw.sigma)?,
        time_constant_s: path.within("time_constant_s", raw.time_constant_s, 1e-6, 1e9)?,
    })
}

fn spikes(path: &Path, raw: &RawSpikes) -> Result<Spikes, ScenarioError> {
    Ok(Spikes {
        probability: path.within("probability", raw.probability, 0.0, 1.0)?,
        magnitude: path.within("magnitude", raw.magnitude, 0.0, MAX_VALUE)?,
    })
}

fn dropout(path: &Path, raw: &RawDropout) -> Result<Dropout, ScenarioError> {
    Ok(Dropout {
        probability: path.within("probability", raw.probability, 0.0, 1.0)?,
        value: path.within("value", raw.value, -MAX_VALUE, MAX_VALUE)?,
    })
}

/// No sensor reads more, in any unit.
const MAX_VALUE: f64 = 1e9;

#[cfg(test)]
mod tests {
    use alloc::string::{String, ToString};
    use alloc::vec;

    use super::{lookup, noise};
    use crate::ScenarioError;
    use crate::check::Path;
    use crate::error::deserialize;
    use baudbot_sim::sensor::{Drift, Dropout, Lookup, Noise, Spikes};

    fn path() -> Path {
        Path::root().field("front").field("noise")
    }

    fn parse<R: serde::de::DeserializeOwned, T>(
        toml: &str,
        make: fn(&Path, R) -> Result<T, ScenarioError>,
    ) -> Result<T, String> {
        let table: toml::Table = toml.parse().unwrap();
        deserialize(path().as_str(), toml::Value::Table(table))
            .and_then(|raw| make(&path(), raw))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn a_table_with_everything_is_read() {
        let toml = "gain_spread = 0.1\noffset_spread = 0.2\ndrift = { sigma = 0.3, time_constant_s = 100.0 }\n\
                    multiplicative = 0.02\nadditive = 0.4\nuniform = 0.5\n\
                    spikes = { probability = 0.001, magnitude = 0.6 }\n\
                    dropout = { probability = 0.01, value = -1.0 }";
        let expected = Noise {
            gain_spread: 0.1,
            offset_spread: 0.2,
            drift: Some(Drift { sigma: 0.3, time_constant_s: 100.0 }),
            multiplicative: 0.02,
            additive: 0.4,
            uniform: 0.5,
            spikes: Some(Spikes { probability: 0.001, magnitude: 0.6 }),
            dropout: Some(Dropout { probability: 0.01, value: -1.0 }),
        };
        assert_eq!(parse(toml, noise), Ok(expected));
    }

    #[test]
    fn an_empty_table_is_no_noise() {
        assert_eq!(parse("", noise), Ok(Noise::default()));
    }

    #[test]
    fn noise_that_makes_no_sense_is_refused() {
        let refusals = [
            ("gain_spread = -0.1", "front.noise.gain_spread: must not be negative, is -0.1"),
            ("offset_spread = nan", "front.noise.offset_spread: must not be negative, is NaN"),
            ("multiplicative = 1e4", "front.noise.multiplicative: must be within 0 and 1000, is 10000"),
            ("additive = -1.0", "front.noise.additive: must not be negative, is -1"),
            ("uniform = inf", "front.noise.uniform: must be within 0 and 1000000000, is inf"),
            (
                "drift = { sigma = 1.0, time_constant_s = 0.0 }",
                "front.noise.drift.time_constant_s: must be positive, is 0",
            ),
            (
                "drift = { sigma = -1.0, time_constant_s = 1.0 }",
                "front.noise.drift.sigma: must not be negative, is -1",
            ),
            (
                "spikes = { probability = 1.5, magnitude = 1.0 }",
                "front.noise.spikes.probability: must be within 0 and 1, is 1.5",
            ),
            (
                "spikes = { probability = 0.5, magnitude = -1.0 }",
                "front.noise.spikes.magnitude: must be within 0 and 1000000000, is -1",
            ),
            (
                "dropout = { probability = -0.5, value = 0.0 }",
                "front.noise.dropout.probability: must be within 0 and 1, is -0.5",
            ),
            (
                "dropout = { probability = 0.5, value = nan }",
                "front.noise.dropout.value: must be within -1000000000 and 1000000000, is NaN",
            ),
        ];
        for (toml, expected) in refusals {
            assert_eq!(parse(toml, noise), Err(expected.into()));
        }
    }

    #[test]
    fn fields_that_are_unknown_or_missing_are_refused_with_their_names() {
        for (toml, path, name) in [
            ("gian_spread = 0.1", "front.noise", "`gian_spread`"),
            ("drift = { sigma = 1.0 }", "front.noise.drift:", "`time_constant_s`"),
            ("spikes = { probability = 0.1 }", "front.noise.spikes:", "`magnitude`"),
            ("dropout = { probability = 0.1 }", "front.noise.dropout:", "`value`"),
        ] {
            let error = parse(toml, noise).unwrap_err();
            assert!(error.starts_with(path) && error.contains(name), "{error}");
        }
        let error = parse("distances_m = [0.1, 0.2]", lookup).unwrap_err();
        assert!(error.contains("`samples`"), "{error}");
    }

    #[test]
    fn samples_are_read_with_angles_and_without() {
        let samples = vec![vec![vec![0.5, 0.6]], vec![vec![0.1]]];
        let expected = Lookup::new(vec![0.1, 0.2], vec![], samples).unwrap();
        let toml = "distances_m = [0.1, 0.2]\nsamples = [[[0.5, 0.6]], [[0.1]]]";
        assert_eq!(parse(toml, lookup), Ok(expected));

        let samples = vec![vec![vec![0.5], vec![0.6]], vec![vec![0.1], vec![0.2]]];
        let expected = Lookup::new(vec![0.1, 0.2], vec![0.0, 1.0], samples).unwrap();
        let toml = "distances_m = [0.1, 0.2]\nangles_rad = [0.0, 1.0]\n\
                    samples = [[[0.5], [0.6]], [[0.1], [0.2]]]";
        assert_eq!(parse(toml, lookup), Ok(expected));
    }

    #[test]
    fn a_hole_is_refused_with_its_place() {
        let found = parse("distances_m = [0.1, 0.2]\nsamples = [[[0.5, 0.6]], [[]]]", lookup);
        let expected = "front.noise.samples[1][0]: a hole: there must be at least one sample";
        assert_eq!(found, Err(expected.into()));
    }
}
