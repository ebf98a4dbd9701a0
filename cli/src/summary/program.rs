//! Programs in simulated time, in the summary of a run.

use baudbot_run::simulation::Progress;
use serde::Serialize;

use super::Summary;
use crate::assignment::Assigned;

/// A program at a robot's ports.
#[derive(Debug, Serialize)]
pub(crate) struct Program {
    pub(crate) robot: String,
    pub(crate) program: String,
    /// When it ended, if it did.
    pub(crate) ended_s: Option<f64>,
    /// The price of each call that did not wait, if it was given one.
    pub(crate) price_ns: Option<u64>,
    /// The calls that were charged, and the simulated time that they took.
    pub(crate) charged_calls: u64,
    pub(crate) charged_s: f64,
    /// Whether its memory was at other addresses than in another run.
    pub(crate) random_addresses: bool,
    /// What its tasks wait for at the end.
    pub(crate) waits: Vec<String>,
}

impl Summary {
    /// Adds the programs as they were at the end. A run whose programs have all ended is over.
    pub(crate) fn add_programs(&mut self, programs: &[Progress], assigned: &Assigned) {
        let price = |robot: &str| {
            assigned.at_ports.iter().find(|task| task.robot == robot).and_then(|task| task.program.price_ns())
        };
        self.unseen_lines += programs.iter().map(|program| program.unseen_lines).sum::<u64>();
        if !programs.is_empty() && self.ending.is_empty() && programs.iter().all(|one| one.ended_at.is_some())
        {
            let whose = if programs.len() == 1 { "its program has ended" } else { "all programs have ended" };
            whose.clone_into(&mut self.ending);
        }
        let summed = |one: &Progress| Program {
            robot: one.robot.clone(),
            program: one.program.clone(),
            ended_s: one.ended_at.map(|at| at.as_seconds()),
            price_ns: price(&one.robot),
            charged_calls: one.report.charged,
            charged_s: one.report.charged_ns as f64 * 1e-9,
            random_addresses: one.report.has_random_addresses,
            waits: one.waits.clone(),
        };
        self.programs = programs.iter().map(summed).collect();
    }
}
