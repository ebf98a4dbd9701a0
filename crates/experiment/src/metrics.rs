//! What was counted in a run: of a world here, or of a server's status, and the same of both.

use baudbot_proto::v1::{self, EndingKind};
use baudbot_sim::link::LineCounters;
use baudbot_sim::{Ending, Histogram, RobotView, World};

/// The counts that figures are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Counted {
    pub(crate) time_ns: u64,
    pub(crate) ending: String,
    /// The run ended because a goal, or all goals, were reached.
    pub(crate) is_goal: bool,
    pub(crate) covered: Option<f64>,
    pub(crate) sensed: Option<f64>,
    pub(crate) goals_reached: u64,
    pub(crate) robots: Vec<RobotCounted>,
    /// Fingerprint of the state at the end.
    pub(crate) hash: u64,
}

/// Of a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RobotCounted {
    pub(crate) collisions: u64,
    pub(crate) distance_m: f64,
    /// Control cycles that were kept, that were late, and that a command answered.
    pub(crate) kept: u64,
    pub(crate) late: u64,
    pub(crate) answered: u64,
    /// In whole nanoseconds; 95 of 100 of the answered cycles took no longer.
    pub(crate) cycle_p95_ns: Option<u64>,
    pub(crate) bytes_lost: u64,
    pub(crate) frames_missed: u64,
    pub(crate) reads_missed: u64,
    pub(crate) used_j: Option<f64>,
    /// Of each sensor whose readings' ages are known.
    pub(crate) ages: Vec<Ages>,
}

/// How old readings were.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ages {
    pub(crate) readings: u64,
    /// In whole nanoseconds, as a server tells it.
    pub(crate) mean_ns: u64,
    pub(crate) p50_ns: u64,
    pub(crate) p95_ns: u64,
    pub(crate) max_ns: u64,
}

impl Ages {
    fn of(ages: &Histogram) -> Option<Self> {
        Some(Self {
            readings: ages.count(),
            mean_ns: ages.mean_ns()?,
            p50_ns: ages.quantile_ns(0.5)?,
            p95_ns: ages.quantile_ns(0.95)?,
            max_ns: ages.max_ns()?,
        })
    }

    fn of_status(ages: &v1::Durations) -> Self {
        let v1::Durations { count, mean_ns, p50_ns, p95_ns, max_ns, .. } = *ages;
        Self { readings: count, mean_ns, p50_ns, p95_ns, max_ns }
    }
}

/// The goal of a run, if it ended by reaching it.
#[derive(Clone, Copy, PartialEq)]
enum Reached {
    /// The one goal of a scenario that has no zones for goals.
    TheGoal,
    AllGoals,
}

impl Counted {
    pub(crate) fn of_world(world: &World) -> Self {
        let scenario = world.scenario();
        let ending = world.ending().map(ToString::to_string).unwrap_or_default();
        let reached = match world.ending() {
            Some(Ending::GoalReached(_)) => Some(Reached::TheGoal),
            Some(Ending::AllGoals) => Some(Reached::AllGoals),
            Some(
                Ending::TimeIsOver
                | Ending::Collision(_)
                | Ending::Collisions(_)
                | Ending::Covered
                | Ending::Sensed
                | Ending::BatteryEmpty(_)
                | Ending::DeadlineMissed(_),
            )
            | None => None,
        };
        let zones = scenario.surroundings.zones.iter().zip(world.score().visited());
        let goals = zones.filter(|(zone, visited)| zone.goal && **visited).count() as u64;
        Self {
            time_ns: world.time().as_ns(),
            covered: world.score().covered(&scenario.rules),
            sensed: world.score().sensed(&scenario.rules),
            robots: world.robots().map(|robot| RobotCounted::of_view(&robot)).collect(),
            hash: world.hash(),
            ..Self::ended(ending, reached, goals)
        }
    }

    pub(crate) fn of_status(status: &v1::WorldStatus) -> Self {
        let score = status.score.as_ref();
        let goals = score.map_or(0, |score| score.goals_reached.into());
        let reached = match status.ending_kind() {
            EndingKind::GoalReached => Some(Reached::TheGoal),
            EndingKind::AllGoals => Some(Reached::AllGoals),
            EndingKind::Unspecified
            | EndingKind::TimeIsOver
            | EndingKind::Collision
            | EndingKind::Collisions
            | EndingKind::Covered
            | EndingKind::Sensed
            | EndingKind::BatteryEmpty
            | EndingKind::DeadlineMissed => None,
        };
        Self {
            time_ns: status.time_ns,
            covered: score.and_then(|score| score.covered),
            sensed: score.and_then(|score| score.sensed),
            robots: status.robots.iter().map(RobotCounted::of_status).collect(),
            hash: status.state_hash,
            ..Self::ended(status.ending.clone(), reached, goals)
        }
    }

    /// `goals` are the zones that robots have been in; the one goal of a scenario is none of these.
    fn ended(ending: String, reached: Option<Reached>, goals: u64) -> Self {
        let one = u64::from(reached == Some(Reached::TheGoal));
        Self { ending, is_goal: reached.is_some(), goals_reached: goals + one, ..Self::default() }
    }
}

impl RobotCounted {
    fn of_view(robot: &RobotView<'_>) -> Self {
        let lost = |line: &LineCounters| line.overrun_bytes + line.refused_bytes + line.lost_bytes;
        let ports = (0..robot.spec().sensors.len()).filter_map(|i| robot.port(i));
        let ages = robot.sensors().filter_map(|sensor| Ages::of(&sensor.freshness.ages));
        let cycles = robot.cycles();
        Self {
            collisions: robot.counters().collisions,
            distance_m: robot.counters().distance_m,
            kept: cycles.kept,
            late: cycles.late,
            answered: cycles.durations.count(),
            cycle_p95_ns: cycles.durations.quantile_ns(0.95),
            bytes_lost: lost(robot.uplink()) + lost(robot.downlink()) + ports.map(lost).sum::<u64>(),
            frames_missed: robot.frames_missed(),
            reads_missed: robot.sensors().map(|sensor| sensor.missed).sum(),
            used_j: robot.battery().map(|(_, state)| state.used_j),
            ages: ages.collect(),
        }
    }

    fn of_status(robot: &v1::RobotStatus) -> Self {
        let lost = |line: Option<&v1::LineStatus>| {
            line.map_or(0, |line| line.overrun_bytes + line.refused_bytes + line.lost_bytes)
        };
        let ports: u64 = robot.sensors.iter().map(|sensor| lost(sensor.port.as_ref())).sum();
        let ages = robot.sensors.iter().filter_map(|sensor| Some(Ages::of_status(sensor.ages.as_ref()?)));
        let cycles = robot.cycles.unwrap_or_default();
        Self {
            collisions: robot.collisions,
            distance_m: robot.distance_m,
            kept: cycles.kept,
            late: cycles.late,
            answered: cycles.durations.map_or(0, |durations| durations.count),
            cycle_p95_ns: cycles.durations.map(|durations| durations.p95_ns),
            bytes_lost: lost(robot.uplink.as_ref()) + lost(robot.downlink.as_ref()) + ports,
            frames_missed: robot.frames_missed,
            reads_missed: robot.sensors.iter().map(|sensor| sensor.missed).sum(),
            used_j: robot.battery.as_ref().map(|battery| battery.used_j),
            ages: ages.collect(),
        }
    }
}
