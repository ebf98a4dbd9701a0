//! Measures: the numbers of a world for monitoring, without a copy of its state.

use std::sync::Arc;
use std::time::Duration;

use baudbot_sim::link::LineCounters;
use baudbot_sim::{RobotView, Scenario, SimTime};

use crate::pace::Pacing;
use crate::report::{Activity, Keeping};

/// Quantiles of the durations of control cycles.
pub(crate) const QUANTILES: [f64; 3] = [0.5, 0.95, 0.99];

/// Most robots that one answer to monitoring has, each in 40 lines.
pub(crate) const MAX_ROBOTS: usize = 5000;

/// The numbers of a world.
pub(crate) struct Measures {
    /// It has the names of the robots.
    pub(crate) scenario: Arc<Scenario>,
    pub(crate) activity: Activity,
    pub(crate) tick: u64,
    pub(crate) time: SimTime,
    /// Wall-clock time during which the world was running.
    pub(crate) running: Duration,
    pub(crate) pacing: Pacing,
    pub(crate) observers: usize,
    pub(crate) frames_missed: u64,
    /// Whether its state is kept, if the server keeps any.
    pub(crate) keeping: Option<Keeping>,
    /// Of the first robots of the scenario.
    pub(crate) robots: Vec<RobotMeasures>,
}

/// The numbers of a robot.
pub(crate) struct RobotMeasures {
    /// Up to the laptop, and down to the microcontroller.
    pub(crate) lines: [LineMeasures; 2],
    pub(crate) cycles: CycleMeasures,
    pub(crate) turns: u64,
    pub(crate) commands: u64,
    pub(crate) collisions: u64,
    pub(crate) distance_m: f64,
    pub(crate) frames_missed: u64,
    pub(crate) slot: SlotMeasures,
}

/// The numbers of one direction of a cable.
pub(crate) struct LineMeasures {
    pub(crate) counters: LineCounters,
    /// Bytes that wait for the line or are on it.
    pub(crate) waiting_bytes: u64,
}

/// The outcomes of a robot's control cycles.
pub(crate) struct CycleMeasures {
    pub(crate) kept: u64,
    pub(crate) late: u64,
    pub(crate) unanswered: u64,
    /// Cycles without an outcome yet.
    pub(crate) open: u64,
    pub(crate) count: u64,
    pub(crate) sum_ns: u64,
    /// `None` before the first cycle is over.
    pub(crate) quantiles_ns: [Option<u64>; 3],
}

/// The numbers of a robot's slot. A brain program that holds several robots answers for all of them at once.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlotMeasures {
    pub(crate) attached: bool,
    pub(crate) lost_deliveries: u64,
    pub(crate) lost_steps: u64,
    /// Turns that wait until the brain reads.
    pub(crate) queued_turns: usize,
    /// Turns that the brain has not answered, in lockstep.
    pub(crate) open_turns: usize,
    /// Wall-clock time since the tick of the oldest of these began.
    pub(crate) oldest_open: Duration,
    pub(crate) answering: Answering,
}

/// How a brain program answered its Turns in lockstep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Answering {
    pub(crate) answers: u64,
    /// Wall-clock time from the beginnings of the ticks to the answers, summed up.
    pub(crate) took: Duration,
}

impl Answering {
    /// Counts an answer.
    pub(crate) fn note(&mut self, took: Duration) {
        self.add(Self { answers: 1, took });
    }

    pub(crate) fn add(&mut self, other: Self) {
        self.answers += other.answers;
        self.took += other.took;
    }
}

impl RobotMeasures {
    /// The numbers of a robot with this slot.
    pub(crate) fn of(robot: &RobotView<'_>, slot: SlotMeasures) -> Self {
        let (counters, cycles) = (robot.counters(), robot.cycles());
        let [up, down] = robot.under_way();
        let durations = &cycles.durations;
        Self {
            lines: [
                LineMeasures { counters: *robot.uplink(), waiting_bytes: up },
                LineMeasures { counters: *robot.downlink(), waiting_bytes: down },
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
            slot,
        }
    }
}
