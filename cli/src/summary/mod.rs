//! The summary of a run: the server's counters, with data of the scenario.

use baudbot_experiment::Demand;
use baudbot_experiment::requirement::Fall;
use baudbot_proto::v1;
use baudbot_proto::v1::pace::Kind;
use baudbot_sim::Scenario;
use serde::Serialize;

use crate::args::Over;
use crate::assignment::Assigned;

mod chip;
mod program;
mod robot;

pub(crate) use chip::{Chip, ChipWarning, Rounds};
pub(crate) use program::Program;
pub(crate) use robot::{Battery, Cycles, Durations, Line, Robot, Sensor, Thinking, Zone};

/// A run.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) scenario: String,
    pub(crate) world: String,
    pub(crate) pace: String,
    /// The connection of the brains with their world.
    pub(crate) over: Over,
    pub(crate) seed: u64,
    pub(crate) ticks: u64,
    pub(crate) step_ns: u64,
    pub(crate) simulated_s: f64,
    pub(crate) wall_s: f64,
    /// The ratio of simulated time to real time.
    pub(crate) simulated_per_wall: f64,
    pub(crate) ending: String,
    /// The run was interrupted before its end.
    pub(crate) interrupted: bool,
    /// Hexadecimal, as JSON's numbers have too few bits.
    pub(crate) state_hash: String,
    /// In real and scaled time.
    pub(crate) clock: Option<Clock>,
    /// The counts of a world in lockstep.
    pub(crate) lockstep: Option<Lockstep>,
    /// The referee's counts, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) score: Option<Score>,
    /// The things that move by themselves and were blocked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) blocked: Vec<Blocked>,
    /// The recording's place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) recording: Option<Recording>,
    /// The number of lines that the programs of brains have printed and that were not shown.
    #[serde(skip)]
    pub(crate) unseen_lines: u64,
    pub(crate) robots: Vec<Robot>,
    /// Programs in simulated time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) programs: Vec<Program>,
    /// How the run keeps to what is required of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) requirements: Vec<Required>,
}

/// A requirement on a robot.
#[derive(Debug, Serialize)]
pub(crate) struct Required {
    pub(crate) requirement: String,
    pub(crate) robot: String,
    pub(crate) holds: bool,
    /// By how much; below 0, by how much it does not.
    pub(crate) robustness: f64,
    pub(crate) at_s: f64,
}

/// A recording of the run.
#[derive(Debug, Serialize)]
pub(crate) struct Recording {
    pub(crate) file: String,
    pub(crate) bytes: u64,
    pub(crate) ticks: u64,
    /// The reason why it ended before the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) problem: Option<String>,
}

impl Recording {
    fn new(status: &v1::RecordingStatus) -> Self {
        let problem = Some(status.problem.clone()).filter(|problem| !problem.is_empty());
        Self { file: status.recording.clone(), bytes: status.bytes, ticks: status.ticks, problem }
    }
}

/// The referee's counts.
#[derive(Debug, Serialize)]
pub(crate) struct Score {
    /// The percentage of the free floor that bodies covered.
    pub(crate) covered_percent: Option<f64>,
    /// The percentage of the free floor that rays reached.
    pub(crate) sensed_percent: Option<f64>,
    pub(crate) goals_reached: u32,
    pub(crate) goals: u32,
    /// Zones that any robot has been in.
    pub(crate) visited: Vec<String>,
}

/// Something that moves by itself, and how long it stood still for what was in its way.
#[derive(Debug, Serialize)]
pub(crate) struct Blocked {
    pub(crate) mover: String,
    pub(crate) blocked_s: f64,
}

/// The quality with which simulated time followed the wall clock.
#[derive(Debug, Serialize)]
pub(crate) struct Clock {
    pub(crate) overruns: u64,
    pub(crate) lateness_max_ms: f64,
    /// Wall-clock time that the world skipped, as it lagged by more than its pace allows, and the number of times.
    pub(crate) let_go_s: f64,
    pub(crate) times_let_go: u64,
    /// Simulated time beyond that of the scaled wall clock, without what was skipped, in percent.
    pub(crate) drift_percent: f64,
    pub(crate) lateness: Vec<Lateness>,
}

/// Ticks that were less than so late, and not less than the entry before.
#[derive(Debug, Serialize)]
pub(crate) struct Lateness {
    pub(crate) below_us: u64,
    pub(crate) ticks: u64,
}

/// The time for which the world waited.
#[derive(Debug, Serialize)]
pub(crate) struct Lockstep {
    pub(crate) waiting_s: f64,
    pub(crate) watchdog_timeouts: u64,
}

impl Summary {
    /// The summary of a world that was run with these brains.
    pub(crate) fn new(
        scenario: &Scenario,
        status: &v1::WorldStatus,
        interrupted: bool,
        assigned: &Assigned,
        over: Over,
    ) -> Self {
        let (simulated_s, wall_s) = (seconds(status.time_ns), seconds(status.running_wall_ns));
        let pacing = status.pacing.clone().unwrap_or_default();
        let kind = status.pace.and_then(|pace| pace.kind);
        let interrupted = interrupted && status.ending.is_empty();
        let robots = scenario.robots.iter().zip(&status.robots);
        Self {
            scenario: status.scenario.clone(),
            world: status.world.clone(),
            pace: kind.as_ref().map_or_else(String::new, pace_name),
            over,
            seed: scenario.seed,
            ticks: status.tick,
            step_ns: status.step_ns,
            simulated_s,
            wall_s,
            simulated_per_wall: simulated_s / wall_s,
            ending: if interrupted { "it was interrupted".to_owned() } else { status.ending.clone() },
            interrupted,
            state_hash: format!("{:016x}", status.state_hash),
            clock: kind.as_ref().and_then(factor).map(|factor| clock(&pacing, simulated_s, wall_s, factor)),
            lockstep: matches!(kind, Some(Kind::Lockstep(_))).then(|| Lockstep {
                waiting_s: seconds(pacing.waiting_wall_ns),
                watchdog_timeouts: pacing.watchdog_timeouts,
            }),
            score: status.score.as_ref().map(Score::new),
            blocked: status.movers.iter().filter(|mover| mover.blocked_ns > 0).map(Blocked::new).collect(),
            recording: status.recording.as_ref().map(Recording::new),
            unseen_lines: 0,
            robots: robots.map(|(spec, robot)| Robot::new(spec, robot, status, assigned)).collect(),
            programs: Vec::new(),
            requirements: Vec::new(),
        }
    }
}

impl Summary {
    /// Adds how the run keeps to what is required.
    pub(crate) fn add_requirements(&mut self, demands: &[Demand], falls: &[Fall]) {
        let required = |fall: &Fall| Required {
            requirement: demands[fall.requirement as usize].requirement.to_string(),
            robot: self.robots[fall.robot as usize].robot.clone(),
            holds: fall.holds,
            robustness: fall.robustness,
            at_s: fall.at_s(),
        };
        self.requirements = falls.iter().map(required).collect();
    }

    /// Adds the last line that each chip has sent, by the robot's place.
    pub(crate) fn add_last_lines(&mut self, last_line: impl Fn(usize) -> Option<String>) {
        for (place, robot) in self.robots.iter_mut().enumerate() {
            if let Some(chip) = &mut robot.chip {
                chip.last_line = last_line(place);
            }
        }
    }
}

impl Score {
    fn new(score: &v1::Score) -> Self {
        let visited = score.zones.iter().filter(|zone| zone.visited);
        Self {
            covered_percent: score.covered.map(|share| share * 100.0),
            sensed_percent: score.sensed.map(|share| share * 100.0),
            goals_reached: score.goals_reached,
            goals: score.goals,
            visited: visited.map(|zone| zone.zone.clone()).collect(),
        }
    }
}

impl Blocked {
    fn new(mover: &v1::MoverStatus) -> Self {
        Self { mover: mover.mover.clone(), blocked_s: seconds(mover.blocked_ns) }
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// The name of a pace on the command line.
pub(crate) fn pace_name(kind: &Kind) -> String {
    match kind {
        Kind::RealTime(_) => "real-time".to_owned(),
        Kind::Scaled(scaled) => format!("scaled:{}", scaled.factor),
        Kind::Lockstep(_) => "lockstep".to_owned(),
        Kind::Stepped(_) => "stepped".to_owned(),
        Kind::Free(_) => "free".to_owned(),
    }
}

fn factor(kind: &Kind) -> Option<f64> {
    match kind {
        Kind::RealTime(_) => Some(1.0),
        Kind::Scaled(scaled) => Some(scaled.factor),
        Kind::Lockstep(_) | Kind::Stepped(_) | Kind::Free(_) => None,
    }
}

fn clock(pacing: &v1::PaceStatus, simulated_s: f64, wall_s: f64, factor: f64) -> Clock {
    let lateness = pacing.lateness_us_log2.iter().enumerate();
    let let_go_s = seconds(pacing.let_go_wall_ns);
    let due_s = (wall_s - let_go_s) * factor;
    Clock {
        overruns: pacing.late_ticks,
        lateness_max_ms: pacing.lateness_max_wall_ns as f64 / 1e6,
        let_go_s,
        times_let_go: pacing.times_let_go,
        drift_percent: (simulated_s / due_s - 1.0) * 100.0,
        lateness: lateness.map(|(i, &ticks)| Lateness { below_us: 1 << i, ticks }).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assignment::Assignment;

    fn status(kind: Kind) -> v1::WorldStatus {
        v1::WorldStatus {
            pace: Some(v1::Pace { kind: Some(kind) }),
            time_ns: 3_000_000_000,
            running_wall_ns: 2_000_000_000,
            robots: vec![v1::RobotStatus {
                uplink: Some(v1::LineStatus { bytes: 288, ..Default::default() }),
                ..Default::default()
            }],
            pacing: Some(v1::PaceStatus { lateness_us_log2: vec![0, 2], ..Default::default() }),
            ..Default::default()
        }
    }

    #[test]
    fn shares_of_time_and_of_the_line() {
        let toml = r#"
            [[robots]]
            name = "alice"
            body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
            link = { kind = "uart", baud = 9600 }
        "#;
        let scenario = baudbot_scenario::parse(toml).unwrap();
        let brains = vec![Assignment { brain: "wander".into(), robots: vec!["alice".into()] }];
        let assigned = Assigned { brains, ..Assigned::default() };
        let scaled = Kind::Scaled(v1::Scaled { factor: 1.5, max_lag_ms: 100 });
        let summary = Summary::new(&scenario, &status(scaled), true, &assigned, Over::Grpc);
        assert_eq!(summary.simulated_per_wall, 1.5);
        assert!(summary.interrupted && summary.lockstep.is_none());
        let clock = summary.clock.unwrap();
        assert!(clock.drift_percent.abs() < 1e-12);
        assert_eq!((clock.lateness[1].below_us, clock.lateness[1].ticks), (2, 2));
        // 288 of the 2880 characters that fit into 3 s.
        assert_eq!(summary.robots[0].uplink.used_percent, Some(10.0));
        assert_eq!(summary.robots[0].brain, "wander");
    }

    #[test]
    fn a_run_that_has_ended_was_not_interrupted() {
        let scenario = baudbot_scenario::parse("").unwrap();
        let free = v1::WorldStatus { ending: "time".into(), ..status(Kind::Free(v1::Free {})) };
        let summary = Summary::new(&scenario, &free, true, &Assigned::default(), Over::Grpc);
        assert_eq!((summary.ending.as_str(), summary.interrupted), ("time", false));
        assert!(summary.clock.is_none());
    }
}
