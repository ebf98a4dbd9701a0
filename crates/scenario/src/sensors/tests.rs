use alloc::string::{String, ToString};
use alloc::vec;

use baudbot_fields::{Fields, Path};
use baudbot_sim::sensor::{Drift, Dropout, Lookup, LookupSheet, Noise, Spikes};

use crate::error::Sheet;

fn path() -> Path {
    Path::root().field("front").field("noise")
}

fn noise(toml: &str) -> Result<Noise, String> {
    let noise = Sheet::from(toml.parse::<toml::Table>().unwrap()).read(&path());
    noise.map_err(|error| error.to_string())
}

fn lookup(toml: &str) -> Result<Lookup, String> {
    let samples = Sheet::from(toml.parse::<toml::Table>().unwrap()).read(&path());
    samples.and_then(|samples: LookupSheet| samples.lookup(&path())).map_err(|error| error.to_string())
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
    assert_eq!(noise(toml), Ok(expected));
}

#[test]
fn an_empty_table_is_no_noise() {
    assert_eq!(noise(""), Ok(Noise::default()));
}

#[test]
fn noise_that_makes_no_sense_is_refused() {
    let refusals = [
        ("gain_spread = -0.1", "front.noise.gain_spread: must not be negative, is -0.1"),
        ("offset_spread = nan", "front.noise.offset_spread: must not be negative, is NaN"),
        ("multiplicative = 1e4", "front.noise.multiplicative: must be between 0 and 1000, is 10000"),
        ("additive = -1.0", "front.noise.additive: must not be negative, is -1"),
        ("uniform = inf", "front.noise.uniform: must be between 0 and 1000000000, is inf"),
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
            "front.noise.spikes.probability: must be between 0 and 1, is 1.5",
        ),
        (
            "spikes = { probability = 0.5, magnitude = -1.0 }",
            "front.noise.spikes.magnitude: must be between 0 and 1000000000, is -1",
        ),
        (
            "dropout = { probability = -0.5, value = 0.0 }",
            "front.noise.dropout.probability: must be between 0 and 1, is -0.5",
        ),
        (
            "dropout = { probability = 0.5, value = nan }",
            "front.noise.dropout.value: must be between -1000000000 and 1000000000, is NaN",
        ),
    ];
    for (toml, expected) in refusals {
        assert_eq!(noise(toml), Err(expected.into()));
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
        let error = noise(toml).unwrap_err();
        assert!(error.starts_with(path) && error.contains(name), "{error}");
    }
    let error = lookup("distances_m = [0.1, 0.2]").unwrap_err();
    assert!(error.contains("`samples`"), "{error}");
}

#[test]
fn samples_are_read_with_angles_and_without() {
    let samples = vec![vec![vec![0.5, 0.6]], vec![vec![0.1]]];
    let expected = Lookup::new(vec![0.1, 0.2], vec![], samples).unwrap();
    let toml = "distances_m = [0.1, 0.2]\nsamples = [[[0.5, 0.6]], [[0.1]]]";
    assert_eq!(lookup(toml), Ok(expected));

    let samples = vec![vec![vec![0.5], vec![0.6]], vec![vec![0.1], vec![0.2]]];
    let expected = Lookup::new(vec![0.1, 0.2], vec![0.0, 1.0], samples).unwrap();
    let toml = "distances_m = [0.1, 0.2]\nangles_rad = [0.0, 1.0]\n\
                samples = [[[0.5], [0.6]], [[0.1], [0.2]]]";
    assert_eq!(lookup(toml), Ok(expected));
}

#[test]
fn a_hole_is_refused_with_its_place() {
    let found = lookup("distances_m = [0.1, 0.2]\nsamples = [[[0.5, 0.6]], [[]]]");
    let expected = "front.noise.samples[1][0]: a hole: there must be at least one sample";
    assert_eq!(found, Err(expected.into()));
}
