//! The observer of a run, who sees the truth at every tick: how near the run came to a failure, and when. None of it reaches a brain.

use std::sync::Arc;

use baudbot_sim::{Nearness, World};

use crate::experiment::Experiment;
use crate::figures::{Figure, Figures};
use crate::requirement::{Demands, Judge, excess_ns};
use crate::run_record::{Ran, RunError};

/// The extremes of a run so far.
#[derive(Clone, Debug)]
struct Observer {
    nearness: Nearness,
    slack: Peak,
    staleness: Peak,
    battery: Option<f64>,
}

/// The sight of a world from its first tick on.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    judge: Judge,
    observer: Option<Observer>,
}

impl Sight {
    /// The sight of an experiment's run, if anything of it is to be seen.
    pub(crate) fn of(experiment: &Experiment) -> Option<Self> {
        experiment.is_observed().then(|| Self::new(Arc::clone(&experiment.requirements)))
    }

    /// The sight of a world that has not begun.
    pub(crate) fn new(demands: Demands) -> Self {
        Self { judge: Judge::new(demands), observer: None }
    }

    /// Sees the world at the beginning of a tick, or at the end.
    pub(crate) fn see(&mut self, world: &World) {
        self.judge.see(world);
        match &mut self.observer {
            Some(observer) => observer.see(world),
            None => self.observer = Some(Observer::new(world)),
        }
    }

    /// Adds what was seen to the figures of the run.
    pub(crate) fn complete(&self, figures: &mut Figures) {
        if let Some(observer) = &self.observer {
            observer.tell(figures);
        }
    }

    /// Adds what was seen to a run that is over.
    ///
    /// # Errors
    /// If something is required of a robot or a sensor that is not there.
    pub(crate) fn tell(&self, mut ran: Ran) -> Result<Ran, RunError> {
        self.complete(&mut ran.figures);
        ran.fall = self.judge.fall().map_err(|problem| RunError::new(format!("require: {problem}")))?;
        Ok(ran)
    }
}

/// The largest of some durations, and the instant at which it was seen first.
#[derive(Clone, Copy, Debug, Default)]
struct Peak {
    value_ns: Option<i64>,
    at_ns: u64,
}

impl Observer {
    /// The observer of a world that begins.
    fn new(world: &World) -> Self {
        let mut observer = Self {
            nearness: Nearness::new(world),
            slack: Peak::default(),
            staleness: Peak::default(),
            battery: None,
        };
        observer.see(world);
        observer
    }

    /// Sees the world at the beginning of a tick, or at the end.
    fn see(&mut self, world: &World) {
        self.nearness.see(world);
        let now_ns = world.time().as_ns();
        for robot in world.robots() {
            self.slack.note(excess_ns(&robot), now_ns);
            self.staleness.note(robot.longest_age_ns().map(u64::cast_signed), now_ns);
            if let Some((battery, state)) = robot.battery() {
                let share = state.share(battery);
                self.battery = Some(self.battery.map_or(share, |least| least.min(share)));
            }
        }
    }

    /// Adds what was seen to the figures of the run.
    fn tell(&self, figures: &mut Figures) {
        let nearest = self.nearness.least().reduce(|a, b| if b.clearance_m < a.clearance_m { b } else { a });
        // A robot alone in the plane has nothing to run into.
        let nearest = nearest.filter(|least| least.clearance_m.is_finite());
        figures.set(Figure::ClearanceMinM, nearest.map(|least| least.clearance_m));
        figures.set(Figure::ClearanceMinAtS, nearest.map(|least| least.at.as_seconds()));
        let at_s = |peak: &Peak| peak.value_ns.map(|_| peak.at_ns as f64 / 1e9);
        figures.set(Figure::DeadlineSlackMinMs, self.slack.value_ns.map(|excess_ns| -excess_ns as f64 / 1e6));
        figures.set(Figure::DeadlineSlackMinAtS, at_s(&self.slack));
        figures.set(Figure::StalenessMaxAtS, at_s(&self.staleness));
        figures.set(Figure::BatteryMin, self.battery);
    }
}

impl Peak {
    fn note(&mut self, value_ns: Option<i64>, now_ns: u64) {
        if value_ns > self.value_ns {
            *self = Self { value_ns, at_ns: now_ns };
        }
    }
}
