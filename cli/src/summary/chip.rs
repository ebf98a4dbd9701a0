//! The summary of a chip that ran a program of the user's own.

use baudbot_proto::v1;
use baudbot_sim::model::RobotSpec;
use serde::Serialize;

/// A chip.
#[derive(Debug, Serialize)]
pub(crate) struct Chip {
    /// The part's name, such as ATmega328P.
    pub(crate) part: String,
    /// The frequency of its clock source, by its name, in Hz.
    pub(crate) clock_hz: u32,
    pub(crate) cycles: u64,
    pub(crate) watchdog_resets: u32,
    /// The most that its stack has had.
    pub(crate) stack_bytes: u32,
    /// The share of the time in which its processor slept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) asleep_percent: Option<f64>,
    /// Rounds of its program's main loop, if one was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rounds: Option<Rounds>,
    /// The last line that it has sent, if that is text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) last_line: Option<String>,
    pub(crate) warnings: Vec<ChipWarning>,
}

/// Rounds of a main loop, in cycles of the clock source and in time.
#[derive(Debug, Serialize)]
pub(crate) struct Rounds {
    pub(crate) count: u64,
    pub(crate) least_cycles: u64,
    pub(crate) mean_cycles: f64,
    pub(crate) most_cycles: u64,
    pub(crate) least_ms: f64,
    pub(crate) mean_ms: f64,
    pub(crate) most_ms: f64,
}

impl Rounds {
    fn new(rounds: &v1::ChipRounds, hz: f64) -> Self {
        let ms = |cycles: f64| cycles / hz * 1e3;
        Self {
            count: rounds.count,
            least_cycles: rounds.least_cycles,
            mean_cycles: rounds.mean_cycles,
            most_cycles: rounds.most_cycles,
            least_ms: ms(rounds.least_cycles as f64),
            mean_ms: ms(rounds.mean_cycles),
            most_ms: ms(rounds.most_cycles as f64),
        }
    }
}

/// Something that its program or its wiring hardly means.
#[derive(Debug, Serialize)]
pub(crate) struct ChipWarning {
    pub(crate) problem: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) pin: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) part: String,
    pub(crate) first_s: f64,
    pub(crate) count: u64,
}

impl Chip {
    pub(super) fn new(status: &v1::ChipStatus, spec: &RobotSpec) -> Self {
        let warning = |warning: &v1::ChipWarning| ChipWarning {
            problem: warning.problem.clone(),
            pin: warning.pin.clone(),
            part: warning.part.clone(),
            first_s: warning.first_ns as f64 / 1e9,
            count: warning.count,
        };
        let clock = spec.chip.as_ref().map(|chip| chip.board().clock());
        Self {
            part: status.part.clone(),
            clock_hz: clock.map_or(0, |clock| clock.hz()),
            cycles: status.cycles,
            watchdog_resets: status.watchdog_resets,
            stack_bytes: status.stack_bytes,
            asleep_percent: status.share_asleep.map(|share| 100.0 * share),
            rounds: status
                .rounds
                .as_ref()
                .zip(clock)
                .map(|(rounds, clock)| Rounds::new(rounds, clock.frequency())),
            last_line: None,
            warnings: status.warnings.iter().map(warning).collect(),
        }
    }
}
