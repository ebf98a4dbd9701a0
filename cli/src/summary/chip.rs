//! What is to be said of a chip that ran a program of the user's own.

use baudbot_proto::v1;
use baudbot_sim::model::RobotSpec;
use serde::Serialize;

/// A chip.
#[derive(Debug, Serialize)]
pub(crate) struct Chip {
    /// Such as ATmega328P.
    pub(crate) part: String,
    /// The frequency of its clock source, by its name, in Hz.
    pub(crate) clock_hz: u32,
    pub(crate) cycles: u64,
    pub(crate) watchdog_resets: u32,
    /// The most that its stack has had.
    pub(crate) stack_bytes: u32,
    /// The last line that it has sent, if that is text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) last_line: Option<String>,
    pub(crate) warnings: Vec<ChipWarning>,
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
        Self {
            part: status.part.clone(),
            clock_hz: spec.chip.as_ref().map_or(0, |chip| chip.board().clock().hz()),
            cycles: status.cycles,
            watchdog_resets: status.watchdog_resets,
            stack_bytes: status.stack_bytes,
            last_line: None,
            warnings: status.warnings.iter().map(warning).collect(),
        }
    }
}
