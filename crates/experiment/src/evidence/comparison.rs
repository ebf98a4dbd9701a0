//! The comparison of measurements on a real robot with a world of ours.

use serde::Deserialize;

use crate::evidence::at::At;
use crate::evidence::experiment::{Experiment, ExperimentError};
use crate::evidence::sample::Sample;

/// Measurements of one thing, and the experiment that repeats them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// The comparison's name, which is that of its file.
    #[serde(skip)]
    pub name: &'static str,
    /// The title of the comparison.
    pub title: String,
    /// The presets that it is about.
    pub presets: Vec<String>,
    /// The measurement on the real robot, in sentences.
    pub measured: String,
    /// The simulation, in sentences.
    pub simulated: String,
    /// The people who measured it, and the publication.
    pub source: String,
    /// The reliability of the measured values.
    pub reliability: Reliability,
    /// The varied quantity, with its unit.
    pub x: String,
    /// The measured quantity, with its unit.
    pub y: String,
    /// The experiment.
    pub experiment: Experiment,
    /// The condition under which a point agrees.
    pub bound: Bound,
    /// The measured points.
    pub points: Vec<Point>,
}

/// The way in which a figure became known to us.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reliability {
    /// Read in the source itself.
    Read,
    /// The numbers were computed from data that the source publishes.
    Computed,
    /// Read in an excerpt, or in a thread.
    Excerpt,
    /// The numbers are from memory; the source was not found.
    Recalled,
}

/// A measured point.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// The place of the point.
    pub at: At,
    /// Number of measurements, if that is known.
    pub n: Option<usize>,
    /// The mean of the measurements.
    pub mean: f64,
    /// The standard deviation of the measurements, if that is known.
    pub sd: Option<f64>,
    /// The least and the largest that was measured, or that those who measured it differ by.
    pub range: Option<[f64; 2]>,
    /// The reason why the simulation is known to differ here.
    pub disagrees: Option<String>,
}

/// The condition under which a simulated point agrees with the measured one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Bound {
    /// The simulated mean is within one measured standard deviation.
    Spread,
    /// The simulated mean is within so many per cent, and the standard deviation, where one is measured, within a
    /// factor.
    Percent {
        /// Largest deviation of the mean, in per cent.
        percent: f64,
        /// Largest ratio of the standard deviations, either way; none if these are not compared.
        spread_factor: Option<f64>,
    },
    /// The simulated mean is within the measured range.
    Range,
    /// The simulated mean is the measured one, to 1 in 10⁹.
    Exact,
}

/// A point of a real robot and of ours.
#[derive(Clone, Debug)]
pub struct Compared<'a> {
    /// The measurement.
    pub measured: &'a Point,
    /// The world's values.
    pub simulated: Sample,
    /// Whether they agree.
    pub agrees: bool,
}

macro_rules! comparisons {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("../../comparisons/", $name, ".toml")))),*]
    };
}

/// All comparisons, in the order of the page.
pub fn comparisons() -> Vec<Comparison> {
    let read = |(name, text): (&'static str, &str)| {
        let comparison: Comparison = toml::from_str(text)
            .unwrap_or_else(|error| panic!("{name}.toml, which is a part of the program: {error}"));
        Comparison { name, ..comparison }
    };
    FILES.into_iter().map(read).collect()
}

const FILES: [(&str, &str); 21] = comparisons![
    "khepera-ir" "khepera-1-ir" "e-puck-ir" "thymio-ir" "gp2d12" "gp2d12-near" "hc-sr04-card" "hc-sr04-cone" "hc-sr04-targets" "ping-targets"
    "e-puck-period" "e-puck-pairs" "e-puck-steps" "thymio-speed" "create-turn"
    "adapters" "ftdi-over-baud" "radio" "nimh-capacity" "nimh-voltage" "gps-rest"
];

impl Comparison {
    /// Does the experiment at each point.
    ///
    /// # Errors
    /// If the experiment cannot be done, for instance because a scenario cannot be made of it.
    pub fn run(&self) -> Result<Vec<Compared<'_>>, ExperimentError> {
        let at: Vec<_> = self.points.iter().map(|point| &point.at).collect();
        let samples = self.experiment.run(&at)?;
        let compare = |(measured, simulated): (_, Sample)| Compared {
            measured,
            simulated,
            agrees: self.bound.holds(measured, &simulated),
        };
        Ok(self.points.iter().zip(samples).map(compare).collect())
    }
}

impl Bound {
    /// Whether the simulated point agrees.
    pub fn holds(self, measured: &Point, simulated: &Sample) -> bool {
        let off = (simulated.mean - measured.mean).abs();
        match self {
            Self::Spread => measured.sd.is_some_and(|sd| off <= sd),
            Self::Percent { percent, spread_factor } => {
                let ratio = measured.sd.map(|sd| simulated.sd / sd);
                let is_spread =
                    |factor: f64| ratio.is_none_or(|ratio| ratio >= 1.0 / factor && ratio <= factor);
                off <= percent / 100.0 * measured.mean.abs() && spread_factor.is_none_or(is_spread)
            }
            Self::Range => {
                measured.range.is_some_and(|[least, most]| simulated.mean >= least && simulated.mean <= most)
            }
            Self::Exact => off <= 1e-9 * measured.mean.abs(),
        }
    }

    /// In words.
    pub fn words(self) -> String {
        match self {
            Self::Spread => "the mean is within the measured standard deviation".into(),
            Self::Percent { percent, spread_factor } => {
                let spread = spread_factor
                    .map(|factor| format!(", the standard deviation within a factor of {factor}"))
                    .unwrap_or_default();
                format!("the mean is within {percent} %{spread}")
            }
            Self::Range => "the mean is within the measured range".into(),
            Self::Exact => "the values are the same".into(),
        }
    }
}

impl Reliability {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Computed => "computed",
            Self::Excerpt => "excerpt",
            Self::Recalled => "recalled",
        }
    }
}
