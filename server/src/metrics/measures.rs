//! What a world tells of itself when it is measured: numbers, and no copy of the world.

use std::sync::Arc;
use std::time::Duration;

use baudbot_sim::link::LineCounters;
use baudbot_sim::{RobotView, Scenario, SimTime};

use crate::letter::Activity;
use crate::pace::Pacing;
use crate::sessions::SeatMeasures;

/// Quantiles of the cycles' durations that are told.
pub(super) const QUANTILES: [f64; 3] = [0.5, 0.95, 0.99];

/// A world's numbers.
pub(crate) struct Measures {
    /// Robots have their names from here.
    pub(crate) scenario: Arc<Scenario>,
    pub(crate) activity: Activity,
    pub(crate) tick: u64,
    pub(crate) time: SimTime,
    pub(crate) running: Duration,
    pub(crate) pacing: Pacing,
    pub(crate) observers: usize,
    pub(crate) frames_missed: u64,
    /// Of the first robots of the scenario.
    pub(crate) robots: Vec<RobotMeasures>,
}

/// A robot's numbers.
pub(crate) struct RobotMeasures {
    /// To the laptop, and to the microcontroller.
    pub(super) lines: [Line; 2],
    pub(super) cycles: CycleMeasures,
    pub(super) turns: u64,
    pub(super) commands: u64,
    pub(super) collisions: u64,
    pub(super) distance_m: f64,
    pub(super) frames_missed: u64,
    pub(super) seat: SeatMeasures,
}

/// One direction of a cable.
pub(super) struct Line {
    pub(super) counters: LineCounters,
    /// Bytes that wait for the wire or are on it.
    pub(super) waiting_bytes: u64,
}

/// How a robot's control cycles went.
pub(super) struct CycleMeasures {
    pub(super) kept: u64,
    pub(super) late: u64,
    pub(super) unanswered: u64,
    /// Neither of these yet.
    pub(super) open: u64,
    pub(super) count: u64,
    pub(super) sum_ns: u64,
    /// `None` before the first.
    pub(super) quantiles_ns: [Option<u64>; 3],
}

impl RobotMeasures {
    /// Of a robot and its seat.
    pub(crate) fn of(robot: &RobotView<'_>, seat: SeatMeasures) -> Self {
        let (counters, cycles) = (robot.counters(), robot.cycles());
        let [up, down] = robot.under_way();
        let durations = &cycles.durations;
        Self {
            lines: [
                Line { counters: *robot.uplink(), waiting_bytes: up },
                Line { counters: *robot.downlink(), waiting_bytes: down },
            ],
            cycles: CycleMeasures {
                kept: cycles.kept,
                late: cycles.late,
                unanswered: cycles.unanswered,
                open: cycles.under_way(),
                count: durations.count(),
                sum_ns: durations.sum_ns(),
                quantiles_ns: QUANTILES.map(|q| durations.quantile_ns(q)),
            },
            turns: counters.turns,
            commands: robot.commands(),
            collisions: counters.collisions,
            distance_m: counters.distance_m,
            frames_missed: robot.frames_missed(),
            seat,
        }
    }
}
