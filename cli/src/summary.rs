//! What is told about a run: the server's counters, with what the scenario knows about them.

use baudbot_proto::v1;
use baudbot_proto::v1::pace::Kind;
use baudbot_sim::Scenario;
use baudbot_sim::link::Link;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Sensor as SensorSpec;
use serde::Serialize;

use crate::crew::Job;
use crate::link;

/// A run.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) scenario: String,
    pub(crate) world: String,
    pub(crate) pace: String,
    pub(crate) seed: u64,
    pub(crate) ticks: u64,
    pub(crate) step_ns: u64,
    pub(crate) simulated_s: f64,
    pub(crate) wall_s: f64,
    /// How many times as fast as real time it was.
    pub(crate) simulated_per_wall: f64,
    pub(crate) ending: String,
    /// Somebody ended it before its end.
    pub(crate) interrupted: bool,
    /// Hexadecimal, as JSON's numbers have too few bits.
    pub(crate) state_hash: String,
    /// In real and scaled time.
    pub(crate) clock: Option<Clock>,
    /// In lockstep.
    pub(crate) lockstep: Option<Lockstep>,
    /// What the referee counted, if there was anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) score: Option<Score>,
    /// Those of the things that move by themselves that something was in the way of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) blocked: Vec<Blocked>,
    /// Where it was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) recording: Option<Recording>,
    pub(crate) robots: Vec<Robot>,
}

/// A recording of the run.
#[derive(Debug, Serialize)]
pub(crate) struct Recording {
    pub(crate) file: String,
    pub(crate) bytes: u64,
    pub(crate) ticks: u64,
    /// Why it ended before the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) problem: Option<String>,
}

impl Recording {
    fn new(status: &v1::RecordingStatus) -> Self {
        let problem = Some(status.problem.clone()).filter(|problem| !problem.is_empty());
        Self { file: status.recording.clone(), bytes: status.bytes, ticks: status.ticks, problem }
    }
}

/// What the referee counted.
#[derive(Debug, Serialize)]
pub(crate) struct Score {
    /// Of the free floor, what bodies covered.
    pub(crate) covered_percent: Option<f64>,
    /// Of the free floor, what rays reached.
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

/// How well simulated time followed the wall clock.
#[derive(Debug, Serialize)]
pub(crate) struct Clock {
    pub(crate) overruns: u64,
    pub(crate) lateness_max_ms: f64,
    /// Wall-clock time that the world let go, as it lagged by more than its pace allows, and how often it did.
    pub(crate) let_go_s: f64,
    pub(crate) times_let_go: u64,
    /// Simulated time beyond that of the scaled wall clock, without what was let go.
    pub(crate) drift_percent: f64,
    pub(crate) lateness: Vec<Lateness>,
}

/// Ticks that were less than so late, and not less than the entry before.
#[derive(Debug, Serialize)]
pub(crate) struct Lateness {
    pub(crate) below_us: u64,
    pub(crate) ticks: u64,
}

/// How long the world waited.
#[derive(Debug, Serialize)]
pub(crate) struct Lockstep {
    pub(crate) waiting_s: f64,
    pub(crate) watchdog_timeouts: u64,
}

/// What happened to a robot.
#[derive(Debug, Serialize)]
pub(crate) struct Robot {
    pub(crate) robot: String,
    /// Empty if it had none.
    pub(crate) brain: String,
    pub(crate) distance_m: f64,
    pub(crate) collisions: u64,
    pub(crate) turns: u64,
    pub(crate) commands: u64,
    pub(crate) lost_deliveries: u64,
    /// Steps of its brain that were thrown away, since there were too many at a time.
    pub(crate) lost_steps: u64,
    /// What its brain last said of itself in words.
    pub(crate) said: String,
    pub(crate) frames_missed: u64,
    /// `ideal`, `uart` or `usb`.
    pub(crate) link: &'static str,
    /// Absent if the link has no baud rate.
    pub(crate) baud: Option<u32>,
    pub(crate) bits_per_character: Option<u8>,
    /// The brain is the microcontroller's program; there is no link.
    #[serde(skip_serializing_if = "is_false")]
    pub(crate) onboard: bool,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) cycles: Cycles,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) battery: Option<Battery>,
    /// Those that it has been in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) zones: Vec<Zone>,
    pub(crate) sensors: Vec<Sensor>,
}

/// A robot's control cycles: from the readings that its microcontroller frames to the command that answers them.
#[derive(Debug, Serialize)]
pub(crate) struct Cycles {
    pub(crate) deadline_ms: f64,
    pub(crate) kept: u64,
    pub(crate) late: u64,
    pub(crate) unanswered: u64,
    /// Of those that were kept or late; absent if there were none.
    pub(crate) kept_percent: Option<f64>,
    /// Messages of readings a second that were answered by a command.
    pub(crate) exchanges_per_s: f64,
    /// Absent if none was answered.
    pub(crate) duration: Option<Durations>,
}

/// How durations are spread.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Durations {
    pub(crate) mean_ms: f64,
    pub(crate) min_ms: f64,
    pub(crate) p50_ms: f64,
    pub(crate) p95_ms: f64,
    pub(crate) p99_ms: f64,
    pub(crate) max_ms: f64,
}

/// What feeds a robot, at the end.
#[derive(Debug, Serialize)]
pub(crate) struct Battery {
    pub(crate) charge_percent: f64,
    pub(crate) voltage_v: f64,
    pub(crate) used_j: f64,
    pub(crate) charged_j: f64,
}

/// A robot's time in a zone.
#[derive(Debug, Serialize)]
pub(crate) struct Zone {
    pub(crate) zone: String,
    pub(crate) time_s: f64,
}

/// One direction of a link.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    pub(crate) bytes: u64,
    pub(crate) messages: u64,
    /// Of the characters that the line could have carried; absent if it is ideal.
    pub(crate) used_percent: Option<f64>,
    pub(crate) overrun_bytes: u64,
    pub(crate) refused_bytes: u64,
    pub(crate) corrupted_bytes: u64,
    pub(crate) bad_frames: u64,
    pub(crate) bad_messages: u64,
    /// In outages of the cable.
    pub(crate) lost_bytes: u64,
}

/// A sensor and the freshness of its readings.
#[derive(Debug, Serialize)]
pub(crate) struct Sensor {
    pub(crate) sensor: String,
    pub(crate) samples: u64,
    pub(crate) missed: u64,
    /// Turns in which it was readable.
    pub(crate) readable: u64,
    /// How old it was then; absent if that is not known of any.
    pub(crate) age: Option<Durations>,
    /// The cable of its own, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) port: Option<Line>,
}

impl Summary {
    /// The summary of a world that was run with these brains.
    pub(crate) fn new(
        scenario: &Scenario,
        status: &v1::WorldStatus,
        interrupted: bool,
        jobs: &[Job],
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
            robots: robots
                .map(|(spec, robot)| {
                    let zones = zones(status, robot);
                    Robot { zones, ..Robot::new(spec, robot, simulated_s, jobs) }
                })
                .collect(),
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

/// The zones that a robot has been in.
fn zones(status: &v1::WorldStatus, robot: &v1::RobotStatus) -> Vec<Zone> {
    let all = status.score.iter().flat_map(|score| &score.zones).zip(&robot.in_zone_ns);
    let been_in = all.filter(|(_, ns)| **ns > 0);
    been_in.map(|(zone, &ns)| Zone { zone: zone.zone.clone(), time_s: seconds(ns) }).collect()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_false(value: &bool) -> bool {
    !value
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// A pace as the command line has it.
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

impl Robot {
    fn new(spec: &RobotSpec, status: &v1::RobotStatus, simulated_s: f64, jobs: &[Job]) -> Self {
        let (baud, bits_per_character) = match &spec.link {
            Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
            Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character)),
        };
        let capacity = link::bytes_per_second(&spec.link).map(|rate| rate * simulated_s);
        let job = jobs.iter().find(|job| job.robots.contains(&spec.name));
        Self {
            robot: status.robot.clone(),
            brain: job.map_or_else(|| status.brain.clone(), |job| job.brain.clone()),
            distance_m: status.distance_m,
            collisions: status.collisions,
            turns: status.turns,
            commands: status.commands,
            lost_deliveries: status.lost_deliveries,
            lost_steps: status.lost_steps,
            said: status.said.clone(),
            frames_missed: status.frames_missed,
            link: link::kind(&spec.link),
            baud,
            bits_per_character,
            onboard: matches!(spec.link, Link::Onboard),
            uplink: Line::new(&status.uplink.unwrap_or_default(), capacity),
            downlink: Line::new(&status.downlink.unwrap_or_default(), capacity),
            cycles: Cycles::new(status.cycles.as_ref(), simulated_s),
            battery: status.battery.as_ref().map(Battery::new),
            zones: Vec::new(),
            sensors: status
                .sensors
                .iter()
                .zip(spec.sensors.iter())
                .map(|(status, spec)| Sensor::new(status, spec, simulated_s))
                .collect(),
        }
    }
}

impl Line {
    fn new(status: &v1::LineStatus, capacity: Option<f64>) -> Self {
        Self {
            bytes: status.bytes,
            messages: status.messages,
            used_percent: capacity.map(|capacity| status.bytes as f64 / capacity * 100.0),
            overrun_bytes: status.overrun_bytes,
            refused_bytes: status.refused_bytes,
            corrupted_bytes: status.corrupted_bytes,
            bad_frames: status.bad_frames,
            bad_messages: status.bad_messages,
            lost_bytes: status.lost_bytes,
        }
    }
}

impl Cycles {
    fn new(status: Option<&v1::CycleStatus>, simulated_s: f64) -> Self {
        let status = status.copied().unwrap_or_default();
        let all = status.kept + status.late;
        let answered = status.durations.map_or(0, |durations| durations.count);
        Self {
            deadline_ms: status.deadline_ns as f64 / 1e6,
            kept: status.kept,
            late: status.late,
            unanswered: status.unanswered,
            kept_percent: (all > 0).then(|| status.kept as f64 / all as f64 * 100.0),
            exchanges_per_s: if simulated_s > 0.0 { answered as f64 / simulated_s } else { 0.0 },
            duration: status.durations.as_ref().map(Durations::new),
        }
    }
}

impl Durations {
    fn new(status: &v1::Durations) -> Self {
        let ms = |ns: u64| ns as f64 / 1e6;
        Self {
            mean_ms: ms(status.mean_ns),
            min_ms: ms(status.min_ns),
            p50_ms: ms(status.p50_ns),
            p95_ms: ms(status.p95_ns),
            p99_ms: ms(status.p99_ns),
            max_ms: ms(status.max_ns),
        }
    }
}

impl Battery {
    fn new(status: &v1::BatteryStatus) -> Self {
        let v1::BatteryStatus { charge, voltage_v, used_j, charged_j, current_a: _ } = *status;
        Self { charge_percent: charge * 100.0, voltage_v, used_j, charged_j }
    }
}

impl Sensor {
    fn new(status: &v1::SensorStatus, spec: &SensorSpec, simulated_s: f64) -> Self {
        let rate = spec.port.as_ref().and_then(|port| link::bytes_per_second(&port.link));
        let capacity = rate.map(|rate| rate * simulated_s);
        Self {
            sensor: status.sensor.clone(),
            samples: status.samples,
            missed: status.missed,
            readable: status.readable,
            age: status.ages.as_ref().map(Durations::new),
            port: status.port.as_ref().map(|line| Line::new(line, capacity)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let jobs = [Job { brain: "wander".into(), robots: vec!["alice".into()] }];
        let scaled = Kind::Scaled(v1::Scaled { factor: 1.5, max_lag_ms: 100 });
        let summary = Summary::new(&scenario, &status(scaled), true, &jobs);
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
        let summary = Summary::new(&scenario, &free, true, &[]);
        assert_eq!((summary.ending.as_str(), summary.interrupted), ("time", false));
        assert!(summary.clock.is_none());
    }
}
