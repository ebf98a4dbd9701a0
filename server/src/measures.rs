//! Measures: the numbers of a world for monitoring, without a copy of its state.

use std::sync::Arc;
use std::time::Duration;

use baudbot_sim::link::LineCounters;
use baudbot_sim::{RobotView, Scenario, SimTime};

use crate::pace::Pacing;
use crate::report::{Activity, Keeping};

/// The name of a metric, its help, and its value. Counters end in `_total`, all others are gauges.
pub(crate) type Metric<Value> = (&'static str, &'static str, Value);

/// A number of a robot and of the brain that holds it.
type OfRobot = fn(&RobotView<'_>, &SlotMeasures) -> f64;

/// A number of a line, with the bytes that wait for it or are on it.
type OfLine = fn(&LineCounters, u64) -> f64;

/// The metrics of a robot.
pub(crate) const OF_ROBOTS: [Metric<OfRobot>; 14] = [
    ("baudbot_robot_turns_total", "Steps of the robot's brain, answered or not.", |robot, _| {
        robot.counters().turns as f64
    }),
    ("baudbot_robot_commands_total", "Commands that the microcontroller obeyed.", |robot, _| {
        robot.commands() as f64
    }),
    ("baudbot_robot_collisions_total", "Collisions.", |robot, _| robot.counters().collisions as f64),
    ("baudbot_robot_distance_meters_total", "Distance driven.", |robot, _| robot.counters().distance_m),
    (
        "baudbot_robot_reading_frames_missed_total",
        "Frames of readings skipped because the microcontroller was busy.",
        |robot, _| robot.frames_missed() as f64,
    ),
    ("baudbot_brain_attached", "1 if a brain is attached to the robot, 0 if none is.", |_, slot| {
        f64::from(u8::from(slot.attached))
    }),
    (
        "baudbot_brain_deliveries_lost_total",
        "Turns that were not delivered to the brain because it did not read.",
        |_, slot| slot.lost_deliveries as f64,
    ),
    (
        "baudbot_brain_steps_lost_total",
        "Steps that the brain sent beyond those that the world takes in a tick.",
        |_, slot| slot.lost_steps as f64,
    ),
    ("baudbot_brain_queued_turns", "Turns queued in the server until the brain reads them.", |_, slot| {
        slot.queued_turns as f64
    }),
    ("baudbot_brain_open_turns", "Turns that the brain has not answered, in lockstep.", |_, slot| {
        slot.open_turns as f64
    }),
    (
        "baudbot_brain_oldest_open_turn_seconds",
        "Wall-clock time since the oldest open Turn, 0 if there is none.",
        |_, slot| slot.oldest_open.as_secs_f64(),
    ),
    ("baudbot_brain_answers_total", "Turns that were answered, in lockstep.", |_, slot| {
        slot.answering.answers as f64
    }),
    (
        "baudbot_brain_answer_seconds_total",
        "Wall-clock time from Turns to their answers, including the network.",
        |_, slot| slot.answering.took.as_secs_f64(),
    ),
    (
        "baudbot_brain_cycles_open",
        "Control cycles that are neither kept nor late nor unanswered yet.",
        |robot, _| robot.cycles().under_way() as f64,
    ),
];

/// The metrics of one direction of a cable, with the bytes that wait for it or are on it.
pub(crate) const OF_LINES: [Metric<OfLine>; 9] = [
    ("baudbot_link_bytes_total", "Bytes that went over the line, including lost ones.", |line, _| {
        line.bytes as f64
    }),
    ("baudbot_link_messages_total", "Complete messages that arrived.", |line, _| line.messages as f64),
    (
        "baudbot_link_lost_bytes_total",
        "Bytes lost because the cable was out, or the bootloader still waited.",
        |line, _| line.lost_bytes as f64,
    ),
    ("baudbot_link_overrun_bytes_total", "Bytes lost because the receiver had no room.", |line, _| {
        line.overrun_bytes as f64
    }),
    (
        "baudbot_link_refused_bytes_total",
        "Bytes not accepted because the sender's buffer was full.",
        |line, _| line.refused_bytes as f64,
    ),
    ("baudbot_link_corrupted_bytes_total", "Bytes that arrived with a wrong bit.", |line, _| {
        line.corrupted_bytes as f64
    }),
    (
        "baudbot_link_bad_frames_total",
        "Frames discarded because of their checksum, encoding or length.",
        |line, _| line.bad_frames as f64,
    ),
    (
        "baudbot_link_bad_messages_total",
        "Intact frames with invalid content, and messages cut short by silence.",
        |line, _| line.bad_messages as f64,
    ),
    ("baudbot_link_waiting_bytes", "Bytes that wait for the line or are on it.", |_, waiting| waiting as f64),
];

/// Quantiles of the durations of control cycles.
pub(crate) const QUANTILES: [f64; 3] = [0.5, 0.95, 0.99];

/// Most robots that one answer to monitoring has, each in 40 lines.
pub(crate) const MAX_ROBOTS: usize = 5000;

/// The numbers of a world.
pub(crate) struct Measures {
    /// The scenario, which has the names of the robots.
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
    /// The measures of the first robots of the scenario.
    pub(crate) robots: Vec<RobotMeasures>,
}

/// The numbers of a robot.
pub(crate) struct RobotMeasures {
    /// In the order of [`OF_ROBOTS`].
    pub(crate) values: [f64; OF_ROBOTS.len()],
    /// In the order of [`OF_LINES`]: up to the laptop, and down to the microcontroller.
    pub(crate) lines: [[f64; OF_LINES.len()]; 2],
    pub(crate) cycles: CycleMeasures,
}

/// The outcomes of a robot's control cycles.
pub(crate) struct CycleMeasures {
    pub(crate) kept: u64,
    pub(crate) late: u64,
    pub(crate) unanswered: u64,
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

/// The answers of a brain program to its Turns in lockstep.
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
    pub(crate) fn of(robot: &RobotView<'_>, slot: &SlotMeasures) -> Self {
        let ([up, down], cycles) = (robot.under_way(), robot.cycles());
        let durations = &cycles.durations;
        let line = |counters, waiting| OF_LINES.map(|(_, _, value)| value(counters, waiting));
        Self {
            values: OF_ROBOTS.map(|(_, _, value)| value(robot, slot)),
            lines: [line(robot.uplink(), up), line(robot.downlink(), down)],
            cycles: CycleMeasures {
                kept: cycles.kept,
                late: cycles.late,
                unanswered: cycles.unanswered,
                count: durations.count(),
                sum_ns: durations.sum_ns(),
                quantiles_ns: QUANTILES.map(|q| durations.quantile_ns(q)),
            },
        }
    }
}
