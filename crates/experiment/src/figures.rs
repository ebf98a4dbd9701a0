//! Figures of merit: the results of a run as numbers. A figure that does not apply to a run is missing.
//!
//! More figures go in three places of this file: a variant of [`Figure`], a line of [`INFOS`] in the same place, and
//! `Figures::of`. They are made of the status of a world, which is on a server or here.

use baudbot_proto::v1::{Durations, EndingKind, LineStatus, RobotStatus, WorldStatus};
use baudbot_server::world_status;
use baudbot_sim::World;

use baudbot_run::UnknownName;

/// A figure of merit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "`INFOS` says what each is")]
pub enum Figure {
    TimeS,
    Collisions,
    DistanceM,
    Covered,
    Sensed,
    GoalsReached,
    GoalTimeS,
    EnergyJ,
    StalenessMeanMs,
    StalenessP50Ms,
    StalenessP95Ms,
    StalenessMaxMs,
    StepKept,
    CycleP95Ms,
    ExchangesPerS,
    BytesLost,
    FramesMissed,
    ReadsMissed,
    ClearanceMinM,
    ClearanceMinAtS,
    DeadlineSlackMinMs,
    DeadlineSlackMinAtS,
    StalenessMaxAtS,
    BatteryMin,
}

/// The description of a figure.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// The figure.
    pub figure: Figure,
    /// The name of the figure in files.
    pub name: &'static str,
    /// The name of the figure on charts, with its unit.
    pub title: &'static str,
    /// The figure is a fraction, from 0 to 1.
    pub is_share: bool,
    /// The meaning of the figure.
    pub meaning: &'static str,
}

/// All figures, in the order of their columns.
pub const INFOS: [Info; COUNT] = [
    info(Figure::TimeS, "time_s", "simulated time (s)", "simulated time of the run"),
    info(Figure::Collisions, "collisions", "collisions", "collisions of all robots"),
    info(Figure::DistanceM, "distance_m", "distance (m)", "distance driven by all robots together"),
    share(
        Figure::Covered,
        "covered",
        "covered fraction of the floor",
        "fraction of the free floor that bodies covered",
    ),
    share(
        Figure::Sensed,
        "sensed",
        "sensed fraction of the floor",
        "fraction of the free floor that rays reached",
    ),
    info(
        Figure::GoalsReached,
        "goals_reached",
        "goals reached",
        "zones with `goal`, and `end.goal`, that were reached",
    ),
    info(
        Figure::GoalTimeS,
        "goal_time_s",
        "time to the goal (s)",
        "time at which the run ended because its goal, or all goals, were reached",
    ),
    info(Figure::EnergyJ, "energy_j", "energy (J)", "energy drawn from all batteries"),
    info(
        Figure::StalenessMeanMs,
        "staleness_mean_ms",
        "mean staleness (ms)",
        "mean age of readings as the brain got them, of all sensors of all robots",
    ),
    info(
        Figure::StalenessP50Ms,
        "staleness_p50_ms",
        "median staleness (ms)",
        "median age of such readings, of the sensor with the oldest",
    ),
    info(
        Figure::StalenessP95Ms,
        "staleness_p95_ms",
        "95th percentile of staleness (ms)",
        "95th percentile of the age of such readings, of the sensor with the oldest",
    ),
    info(
        Figure::StalenessMaxMs,
        "staleness_max_ms",
        "largest staleness (ms)",
        "largest age of such a reading",
    ),
    share(
        Figure::StepKept,
        "step_kept",
        "fraction of cycles that met the deadline",
        "fraction of control cycles that met their deadline, of all robots",
    ),
    info(
        Figure::CycleP95Ms,
        "cycle_p95_ms",
        "95th percentile of control cycles (ms)",
        "95th percentile of the duration of answered control cycles, of the robot with the longest",
    ),
    info(
        Figure::ExchangesPerS,
        "exchanges_per_s",
        "exchanges (1/s)",
        "messages of readings per second that were answered by a command, of the robot with the fewest",
    ),
    info(
        Figure::BytesLost,
        "bytes_lost",
        "bytes lost",
        "bytes lost because a buffer was full or a cable was out, on all cables in both directions",
    ),
    info(
        Figure::FramesMissed,
        "frames_missed",
        "frames missed",
        "frames that fell due while the microcontroller was busy, of all robots",
    ),
    info(
        Figure::ReadsMissed,
        "reads_missed",
        "reads missed",
        "samples that fell due while the microcontroller was busy, of all sensors of all robots",
    ),
    info(
        Figure::ClearanceMinM,
        "clearance_min_m",
        "least clearance (m)",
        "least distance of a robot's body from anything it could run into; 0 at a collision",
    ),
    info(
        Figure::ClearanceMinAtS,
        "clearance_min_at_s",
        "time of the least clearance (s)",
        "time at which the clearance was least",
    ),
    info(
        Figure::DeadlineSlackMinMs,
        "deadline_slack_min_ms",
        "least slack to the deadline (ms)",
        "time from the end of the longest answered control cycle to its deadline; negative if it was late",
    ),
    info(
        Figure::DeadlineSlackMinAtS,
        "deadline_slack_min_at_s",
        "time of the least slack (s)",
        "time at which the cycle with the least slack had ended",
    ),
    info(
        Figure::StalenessMaxAtS,
        "staleness_max_at_s",
        "time of the largest staleness (s)",
        "time at which the brain had got the reading with the largest age",
    ),
    share(
        Figure::BatteryMin,
        "battery_min",
        "least charge of a battery",
        "least charge of a battery, as a fraction of its capacity",
    ),
];

const COUNT: usize = 24;

const fn info(figure: Figure, name: &'static str, title: &'static str, meaning: &'static str) -> Info {
    Info { figure, name, title, is_share: false, meaning }
}

const fn share(figure: Figure, name: &'static str, title: &'static str, meaning: &'static str) -> Info {
    Info { is_share: true, ..info(figure, name, title, meaning) }
}

impl Figure {
    /// The figure of this name.
    ///
    /// # Errors
    /// An error with those that exist, the nearest first.
    pub fn named(name: &str) -> Result<Self, UnknownName> {
        let names = INFOS.map(|info| info.name);
        let found = INFOS.iter().find(|info| info.name == name);
        found.map(|info| info.figure).ok_or_else(|| UnknownName::new("figure", name, &names))
    }

    /// Whether it needs somebody who sees the world at every tick: it is missing of a run on another machine's server.
    pub fn is_observed(self) -> bool {
        self as usize >= Self::ClearanceMinM as usize
    }

    /// The description of the figure.
    pub fn info(self) -> &'static Info {
        &INFOS[self as usize]
    }
}

/// The figures of a run, in the order of [`INFOS`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures(pub(crate) [Option<f64>; COUNT]);

impl Figures {
    /// The number of figures.
    pub const COUNT: usize = COUNT;

    /// One of them; `None` if it does not apply.
    pub fn get(&self, figure: Figure) -> Option<f64> {
        self.0[figure as usize]
    }

    pub(crate) fn set(&mut self, figure: Figure, value: Option<f64>) {
        self.0[figure as usize] = value.filter(|value| value.is_finite());
    }

    /// The figures of a run so far, without those of [`Figure::is_observed`].
    pub fn of_world(world: &World) -> Self {
        Self::of(&world_status(world))
    }

    pub(crate) fn of(run: &WorldStatus) -> Self {
        let time_s = run.time_ns as f64 / 1e9;
        let score = run.score.clone().unwrap_or_default();
        // The one goal of a scenario that has no zones for goals is in no score.
        let is_the_goal = run.ending_kind() == EndingKind::GoalReached;
        let is_goal = is_the_goal || run.ending_kind() == EndingKind::AllGoals;
        let robots = &run.robots;
        let sum = |count: fn(&RobotStatus) -> u64| Some(robots.iter().map(count).sum::<u64>() as f64);
        let batteries = robots.iter().filter_map(|robot| robot.battery.as_ref());
        let energy = batteries.map(|battery| battery.used_j).reduce(|a, b| a + b);
        let cycles = || robots.iter().map(|robot| robot.cycles.unwrap_or_default());
        let exchanges = cycles().map(|cycles| cycles.durations.map_or(0, |answered| answered.count)).min();
        let cycle = cycles().filter_map(|cycles| Some(cycles.durations?.p95_ns)).max();
        let kept: u64 = cycles().map(|cycles| cycles.kept).sum();
        let over = kept + cycles().map(|cycles| cycles.late).sum::<u64>();
        let mut figures = Self::default();
        figures.set(Figure::TimeS, Some(time_s));
        figures.set(Figure::Collisions, sum(|robot| robot.collisions));
        figures.set(Figure::DistanceM, Some(robots.iter().fold(0.0, |sum, robot| sum + robot.distance_m)));
        figures.set(Figure::Covered, score.covered);
        figures.set(Figure::Sensed, score.sensed);
        figures.set(
            Figure::GoalsReached,
            Some((u64::from(score.goals_reached) + u64::from(is_the_goal)) as f64),
        );
        figures.set(Figure::GoalTimeS, is_goal.then_some(time_s));
        figures.set(Figure::EnergyJ, energy);
        figures.set_staleness(robots);
        figures.set(Figure::StepKept, (over > 0).then(|| kept as f64 / over as f64));
        figures.set(Figure::CycleP95Ms, cycle.map(|ns| ns as f64 / 1e6));
        figures.set(Figure::ExchangesPerS, exchanges.map(|count| count as f64 / time_s));
        figures.set(Figure::BytesLost, sum(bytes_lost));
        figures.set(Figure::FramesMissed, sum(|robot| robot.frames_missed));
        figures.set(Figure::ReadsMissed, sum(|robot| robot.sensors.iter().map(|sensor| sensor.missed).sum()));
        figures
    }

    /// Sets the figures of the ages of readings.
    fn set_staleness(&mut self, robots: &[RobotStatus]) {
        let ages =
            || robots.iter().flat_map(|robot| &robot.sensors).filter_map(|sensor| sensor.ages.as_ref());
        let aged: u64 = ages().map(|ages| ages.count).sum();
        let age_ns: f64 = ages().map(|ages| ages.mean_ns as f64 * ages.count as f64).sum();
        let oldest = |of: fn(&Durations) -> u64| ages().map(of).max().map(|ns| ns as f64 / 1e6);
        self.set(Figure::StalenessMeanMs, (aged > 0).then(|| age_ns / aged as f64 / 1e6));
        self.set(Figure::StalenessP50Ms, oldest(|ages| ages.p50_ns));
        self.set(Figure::StalenessP95Ms, oldest(|ages| ages.p95_ns));
        self.set(Figure::StalenessMaxMs, oldest(|ages| ages.max_ns));
    }
}

/// Bytes lost on all cables of a robot.
fn bytes_lost(robot: &RobotStatus) -> u64 {
    let ports = robot.sensors.iter().filter_map(|sensor| sensor.port);
    let lines = robot.uplink.into_iter().chain(robot.downlink).chain(ports);
    lines.map(|line: LineStatus| line.overrun_bytes + line.refused_bytes + line.lost_bytes).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_is_in_the_book() {
        let book = include_str!("../../../docs/reference/experiments.md");
        for info in &INFOS {
            assert!(book.contains(&format!("\n| `{}` | ", info.name)), "{}", info.name);
        }
    }

    #[test]
    fn every_figure_stands_in_its_place() {
        for (i, info) in INFOS.iter().enumerate() {
            assert_eq!(info.figure as usize, i, "{}", info.name);
            assert_eq!(Figure::named(info.name), Ok(info.figure));
        }
        let error = Figure::named("distance").unwrap_err().to_string();
        assert!(error.starts_with("there is no figure `distance`; did you mean `distance_m`?"), "{error}");
    }
}
