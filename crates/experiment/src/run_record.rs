//! A run that is to be done, and its record: its result, a row of the table.

use std::fmt::Display;

use baudbot_proto::v1::WorldStatus;
use serde::{Deserialize, Serialize};

use crate::design::Cell;
use crate::figures::{Figures, INFOS};
use crate::requirement::Fall;

/// A run and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Number of the run, from 0.
    pub run: u64,
    /// The course of the run, or the reason why it could not be.
    pub outcome: Result<Ran, RunError>,
}

/// The reason why a run could not be done. It is a text, as a row that is read back from a journal has no more of the error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[error("{0}")]
#[serde(transparent)]
pub struct RunError(String);

impl RunError {
    /// The text of an error.
    pub(crate) fn new(error: impl Display) -> Self {
        Self(error.to_string())
    }
}

/// The course of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Ran {
    /// The reason for its end.
    pub ending: String,
    /// The figures of merit.
    pub figures: Figures,
    /// How the run keeps to what is required, if anything is.
    pub fall: Option<Fall>,
    /// Fingerprint of the world's state at its end.
    pub hash: u64,
}

/// A run that is to be done.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Number of the run, from 0.
    pub run: u64,
    /// The task's combination of values.
    pub cell: Cell,
    /// The scenario's seed, and its brains'.
    pub seed: u64,
}

impl Row {
    /// Whether it could not be done: a program that is mended may do it.
    pub(crate) fn has_failed(&self) -> bool {
        self.outcome.is_err()
    }
}

impl Ran {
    pub(crate) fn of(run: &WorldStatus) -> Self {
        Self { ending: run.ending.clone(), figures: Figures::of(run), fall: None, hash: run.state_hash }
    }
}

/// The columns of a table of such rows.
pub(crate) fn columns<'a>(
    labels: impl Iterator<Item = &'a str>,
    has_success: bool,
    has_requirements: bool,
) -> impl Iterator<Item = &'a str> {
    let success = has_success.then_some(SUCCESS);
    let required = REQUIRED.into_iter().filter(move |_| has_requirements);
    let all = FIRST.into_iter().chain(labels).chain([ERROR, ENDING]).chain(success).chain(required);
    all.chain(INFOS.iter().map(|info| info.name)).chain([HASH])
}

/// Whether a column of this name is in every table, or may be.
pub(crate) fn is_column(name: &str) -> bool {
    FIRST.contains(&name)
        || [ERROR, ENDING, SUCCESS, HASH].contains(&name)
        || REQUIRED.contains(&name)
        || INFOS.iter().any(|info| info.name == name)
}

const FIRST: [&str; 3] = ["run", "cell", "seed"];
const ERROR: &str = "error";
const ENDING: &str = "ending";
const SUCCESS: &str = "success";
/// How the run keeps to the requirement that it keeps to least, and which that is.
const REQUIRED: [&str; 3] = ["robustness", "robustness_at_s", "requirement"];
const HASH: &str = "state_hash";

/// A row in the journal; the rest follows from its number.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Written {
    pub(crate) run: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<RunError>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ending: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    figures: Option<[Option<f64>; Figures::COUNT]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fall: Option<Fall>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state_hash: Option<String>,
}

impl From<&Row> for Written {
    fn from(row: &Row) -> Self {
        let ran = row.outcome.as_ref().ok();
        Self {
            run: row.run,
            error: row.outcome.as_ref().err().cloned(),
            ending: ran.map(|ran| ran.ending.clone()),
            figures: ran.map(|ran| ran.figures.0),
            fall: ran.and_then(|ran| ran.fall),
            state_hash: ran.map(|ran| format!("{:016x}", ran.hash)),
        }
    }
}

impl Written {
    /// `None` if something of a row is not there.
    pub(crate) fn row(self) -> Option<Row> {
        let outcome = match self.error {
            Some(error) => Err(error),
            None => Ok(Ran {
                ending: self.ending?,
                figures: Figures(self.figures?),
                fall: self.fall,
                hash: u64::from_str_radix(&self.state_hash?, 16).ok()?,
            }),
        };
        Some(Row { run: self.run, outcome })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_comes_back_from_the_journal_to_the_last_bit() {
        let mut figures = Figures::default();
        figures.0[2] = Some(0.1 + 0.2);
        figures.0[8] = Some(19.791_666_666_666_668);
        let ran = Ran {
            ending: "the scenario's \"time\" is over\n".into(),
            figures,
            fall: None,
            hash: u64::MAX - 1,
        };
        let fall = Fall {
            requirement: 1,
            robot: 0,
            robustness: -0.1 - 0.2,
            holds: false,
            at_ns: 7,
            speed_m_s: 0.3,
            stalest: Some((2, 0.1)),
            longest_cycle_ns: Some(8),
        };
        let fallen = Ran { fall: Some(fall), ..ran.clone() };
        for outcome in [Ok(ran), Ok(fallen), Err(RunError::new("robots[0].link.baud: must be ≥ 50"))] {
            let row = Row { run: 7, outcome };
            let text = serde_json::to_string(&Written::from(&row)).unwrap();
            assert!(!text.contains('\n'), "{text}");
            assert_eq!(serde_json::from_str::<Written>(&text).unwrap().row(), Some(row));
        }
    }
}
