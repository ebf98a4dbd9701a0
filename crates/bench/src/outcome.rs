//! The result of a workload.

use serde::{Deserialize, Serialize};

use crate::measure::{Sample, median};

/// The measurements of a workload, in a process of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the workload.
    pub workload: String,
    /// Unit of its figure.
    pub unit: String,
    /// One a repeat.
    pub samples: Vec<Sample>,
    /// The most memory that the process had, in bytes; `None` where the system does not report it.
    pub peak_memory_bytes: Option<u64>,
    /// Threads that stepped the world.
    pub threads: usize,
    /// Fingerprint of the world's state after its first ticks, in hexadecimal digits, if the run is the same every time.
    pub hash: Option<String>,
    /// The number of those ticks.
    pub hash_ticks: Option<u64>,
    /// The measurement of the same run, to compare with.
    pub beside: Option<Beside>,
    /// The other notes.
    pub notes: Vec<String>,
}

/// Something that a workload is compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beside {
    /// The description.
    pub what: String,
    /// One a repeat, in the workload's unit.
    pub samples: Vec<Sample>,
}

impl Beside {
    /// The median of its figures.
    pub fn median(&self) -> f64 {
        median(self.samples.iter().map(|sample| sample.value))
    }

    /// The median of the workload's figures, each divided by the one of this that was measured just before.
    pub fn median_ratio(&self, outcome: &Outcome) -> f64 {
        median(self.samples.iter().zip(&outcome.samples).map(|(own, other)| other.value / own.value))
    }
}

impl Outcome {
    /// Nothing yet.
    pub(crate) fn new(workload: &str, unit: &str, threads: usize) -> Self {
        Self {
            workload: workload.to_owned(),
            unit: unit.to_owned(),
            samples: Vec::new(),
            peak_memory_bytes: None,
            threads,
            hash: None,
            hash_ticks: None,
            beside: None,
            notes: Vec::new(),
        }
    }

    /// The median of the figures.
    pub fn median(&self) -> f64 {
        median(self.values())
    }

    /// The least and the greatest of the figures.
    pub fn spread(&self) -> [f64; 2] {
        [self.values().fold(f64::INFINITY, f64::min), self.values().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The median of the figures, each for a million rounds of the calibration loop that ran just before it.
    pub fn median_per_million_rounds(&self) -> f64 {
        median(self.samples.iter().map(|sample| sample.value / sample.calibration_per_s * 1e6))
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.samples.iter().map(|sample| sample.value)
    }
}
