//! Reports for operators.

use std::time::Duration;

use baudbot_proto::v1;
use baudbot_sim::chip::{Board, Rounds, Warning};
use baudbot_sim::link::LineCounters;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::time::SimTime;
use baudbot_sim::{Ending, Freshness, Histogram, RobotView, Scenario, SensorView, World};

use super::pace::pace_to;
use super::{battery, score};
use crate::pace::Pacing;
use crate::report::{Activity, Report};
use crate::thinking::Thought;

/// A world as it stands on its server.
pub(crate) fn status(report: &Report) -> v1::WorldStatus {
    let v1::WorldStatus { world, state, running_wall_ns, pacing, replay, recording, .. } =
        report.beside.clone();
    let mut status = world_status(&report.world);
    for (robot, slot) in status.robots.iter_mut().zip(&report.slots) {
        robot.attached = slot.brain.is_some();
        robot.brain = slot.brain.clone().unwrap_or_default();
        robot.lost_deliveries = slot.lost_deliveries;
        robot.lost_steps = slot.lost_steps;
        robot.said.clone_from(&slot.said);
        robot.thinking_wall = slot.thought.as_ref().and_then(|thought| durations(&thought.wall));
        robot.thinking_processor = slot.thought.as_ref().and_then(|thought| durations(&thought.processor));
    }
    let pace = Some(pace_to(report.pace));
    v1::WorldStatus { world, state, pace, running_wall_ns, pacing, replay, recording, ..status }
}

/// The status of a world that is on no server: all that follows from its state, with its robots' counters.
pub fn world_status(world: &World) -> v1::WorldStatus {
    v1::WorldStatus {
        scenario: world.scenario().name.clone(),
        tick: world.tick(),
        time_ns: world.time().as_ns(),
        step_ns: world.scenario().step_ns,
        state_hash: world.hash(),
        ending: world.ending().map(ToString::to_string).unwrap_or_default(),
        ending_kind: world.ending().map(ending_kind).unwrap_or_default().into(),
        robots: (0..world.robots().len()).map(|robot| robot_status(world, robot)).collect(),
        score: score(world),
        movers: movers(world),
        seed: world.scenario().seed,
        ..Default::default()
    }
}

pub(crate) fn activity(activity: Activity) -> v1::WorldState {
    match activity {
        Activity::WaitingForBrains => v1::WorldState::WaitingForBrains,
        Activity::Running => v1::WorldState::Running,
        Activity::Paused => v1::WorldState::Paused,
        Activity::Ended => v1::WorldState::Ended,
    }
}

/// The statuses of things that move by themselves, which come first among all things.
fn movers(world: &World) -> Vec<v1::MoverStatus> {
    let movers = world.things().take(world.scenario().movers.len());
    movers.map(|m| v1::MoverStatus { mover: m.name.to_owned(), blocked_ns: m.blocked_ns }).collect()
}

pub(crate) fn pace_status(pacing: &Pacing) -> v1::PaceStatus {
    let used = pacing.lateness_us_log2.iter().rposition(|&n| n > 0).map_or(0, |i| i + 1);
    v1::PaceStatus {
        late_ticks: pacing.overruns,
        lateness_us_log2: pacing.lateness_us_log2[..used].to_vec(),
        lateness_max_wall_ns: nanos(pacing.lateness_max),
        watchdog_timeouts: pacing.watchdog_timeouts,
        waiting_wall_ns: nanos(pacing.waiting),
        let_go_wall_ns: nanos(pacing.let_go),
        times_let_go: pacing.times_let_go,
    }
}

pub(crate) fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

fn robot_status(world: &World, index: usize) -> v1::RobotStatus {
    let robot = world.robot(index);
    let counters = robot.counters();
    let sensors = robot.sensors().zip(robot.spec().sensors.iter()).enumerate();
    v1::RobotStatus {
        robot: robot.spec().name.clone(),
        turns: counters.turns,
        commands: robot.commands(),
        collisions: counters.collisions,
        distance_m: counters.distance_m,
        uplink: Some(line_status(robot.uplink())),
        downlink: Some(line_status(robot.downlink())),
        sensors: sensors.map(|(i, (view, spec))| sensor_status(&view, spec, robot.port(i))).collect(),
        frames_missed: robot.frames_missed(),
        battery: battery(&robot),
        in_zone_ns: world.score().in_zone_ns(index).to_vec(),
        cycles: Some(cycle_status(&robot)),
        chip: robot.board().map(|board| chip_status(&robot, board)),
        stood_in_contact_ns: robot.stood_in_contact_ns(),
        ..Default::default()
    }
}

fn chip_status(robot: &RobotView<'_>, board: &Board) -> v1::ChipStatus {
    let chip = board.chip();
    let warning = |(first, warning): (SimTime, &Warning)| v1::ChipWarning {
        problem: warning.explain(board.wiring()),
        pin: warning.printed_pin(),
        part: warning.part.map(|part| board.wiring().name(part).to_owned()).unwrap_or_default(),
        first_ns: first.as_ns(),
        count: warning.count,
    };
    v1::ChipStatus {
        part: chip.part().properties().name.to_owned(),
        cycles: chip.cycles(),
        watchdog_resets: chip.watchdog_resets(),
        stack_bytes: u32::from(chip.part().ram_end().saturating_sub(chip.lowest_sp())),
        warnings: robot.board_warnings().map(warning).collect(),
        rounds: board.rounds().map(chip_rounds),
        share_asleep: board.share_asleep(),
    }
}

fn chip_rounds(rounds: &Rounds) -> v1::ChipRounds {
    v1::ChipRounds {
        count: rounds.count(),
        least_cycles: rounds.least(),
        mean_cycles: rounds.total() as f64 / rounds.count().max(1) as f64,
        typical_cycles: rounds.typical(),
        most_cycles: rounds.most(),
    }
}

/// The thinking times of robots' brains, of those of which something was measured.
pub(crate) fn thinking<'a>(
    scenario: &Scenario,
    thought: impl Iterator<Item = Option<&'a Thought>>,
) -> Vec<v1::RobotThinking> {
    let of = |(spec, thought): (&RobotSpec, Option<&Thought>)| {
        let Thought { wall, processor } = thought?;
        let robot = spec.name.clone();
        Some(v1::RobotThinking { robot, wall: durations(wall), processor: durations(processor) })
    };
    scenario.robots.iter().zip(thought).filter_map(of).collect()
}

pub(crate) fn cycle_status(robot: &RobotView<'_>) -> v1::CycleStatus {
    let cycles = robot.cycles();
    v1::CycleStatus {
        deadline_ns: robot.spec().deadline.within_ns,
        kept: cycles.kept,
        late: cycles.late,
        unanswered: cycles.unanswered,
        unstated_writes: cycles.exceptions.writes,
        disturbed: cycles.exceptions.cycles,
        durations: durations(&cycles.durations),
    }
}

fn durations(histogram: &Histogram) -> Option<v1::Durations> {
    Some(v1::Durations {
        count: histogram.count(),
        mean_ns: histogram.mean_ns()?,
        min_ns: histogram.min_ns()?,
        p50_ns: histogram.quantile_ns(0.5)?,
        p95_ns: histogram.quantile_ns(0.95)?,
        p99_ns: histogram.quantile_ns(0.99)?,
        max_ns: histogram.max_ns()?,
    })
}

pub(crate) fn line_status(line: &LineCounters) -> v1::LineStatus {
    v1::LineStatus {
        bytes: line.bytes,
        corrupted_bytes: line.corrupted_bytes,
        overrun_bytes: line.overrun_bytes,
        refused_bytes: line.refused_bytes,
        messages: line.messages,
        bad_frames: line.bad_frames,
        bad_messages: line.bad_messages,
        lost_bytes: line.lost_bytes,
    }
}

fn sensor_status(sensor: &SensorView<'_>, spec: &Sensor, port: Option<&LineCounters>) -> v1::SensorStatus {
    let Freshness { readable, ages } = sensor.freshness;
    v1::SensorStatus {
        sensor: spec.name.clone(),
        samples: sensor.samples,
        missed: sensor.missed,
        readable: *readable,
        ages: durations(ages),
        port: port.map(line_status),
    }
}

pub(super) fn ending_kind(ending: &Ending) -> v1::EndingKind {
    match ending {
        Ending::TimeIsOver => v1::EndingKind::TimeIsOver,
        Ending::Collision(_) => v1::EndingKind::Collision,
        Ending::Collisions(_) => v1::EndingKind::Collisions,
        Ending::GoalReached(_) => v1::EndingKind::GoalReached,
        Ending::AllGoals => v1::EndingKind::AllGoals,
        Ending::Covered => v1::EndingKind::Covered,
        Ending::Sensed => v1::EndingKind::Sensed,
        Ending::BatteryEmpty(_) => v1::EndingKind::BatteryEmpty,
        Ending::DeadlineMissed(_) => v1::EndingKind::DeadlineMissed,
    }
}
