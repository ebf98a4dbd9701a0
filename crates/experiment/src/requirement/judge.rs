//! Requirements held against a run, tick by tick.

use std::collections::VecDeque;

use baudbot_require::Monitor;
use baudbot_run::UnknownName;
use baudbot_sim::{RobotView, World};

use super::demand::{Demand, Demands, Fall};
use super::observable::Observable;

/// The requirements on a run that is under way.
#[derive(Clone, Debug)]
pub struct Judge {
    demands: Demands,
    monitors: Option<Monitors>,
    problem: Option<UnknownName>,
}

impl Judge {
    /// A judge of a world that has not begun.
    pub fn new(demands: impl Into<Demands>) -> Self {
        Self { demands: demands.into(), monitors: None, problem: None }
    }

    /// Sees the world in a tick that is begun, or at the end.
    #[inline]
    pub fn see(&mut self, world: &World) {
        if !self.demands.is_empty() && self.problem.is_none() {
            self.look(world);
        }
    }

    fn look(&mut self, world: &World) {
        if self.monitors.is_none() {
            match Monitors::new(&self.demands, world) {
                Ok(monitors) => self.monitors = Some(monitors),
                Err(problem) => self.problem = Some(problem),
            }
        }
        if let Some(Err(problem)) = self.monitors.as_mut().map(|monitors| monitors.see(world)) {
            self.problem = Some(problem);
        }
    }

    /// How the run keeps to the requirement that it keeps to least; `None` if nothing is required.
    ///
    /// # Errors
    /// If something is required of a robot or a sensor that is not there.
    pub fn fall(&self) -> Result<Option<Fall>, UnknownName> {
        let falls = self.falls()?;
        Ok(falls.into_iter().min_by(|a, b| a.order(b)))
    }

    /// How the run keeps to each requirement, in the order of requirements and robots.
    ///
    /// # Errors
    /// If something is required of a robot or a sensor that is not there.
    pub fn falls(&self) -> Result<Vec<Fall>, UnknownName> {
        match (&self.problem, &self.monitors) {
            (Some(problem), _) => Err(problem.clone()),
            (None, Some(monitors)) => Ok(monitors.falls().collect()),
            (None, None) => Ok(Vec::new()),
        }
    }

    /// What is required.
    pub fn demands(&self) -> &[Demand] {
        &self.demands
    }
}

/// The monitors of a run, one for each requirement and robot.
#[derive(Clone, Debug)]
struct Monitors {
    each: Vec<RobotMonitor>,
    last_ns: Option<u64>,
    /// The robots' speeds a tick before.
    speeds_m_s: Vec<f64>,
    /// The robots' oldest readings.
    gaps: Vec<Gaps>,
}

/// The readings that may be the oldest that a brain had in the last second: each is older than those behind it.
#[derive(Clone, Debug, Default)]
struct Gaps(VecDeque<Gap>);

/// The oldest reading at an instant.
#[derive(Clone, Copy, Debug)]
struct Gap {
    at_ns: u64,
    sensor: u32,
    age_ms: f64,
}

/// A monitor with the circumstances of the instant that decides.
#[derive(Clone, Debug)]
struct RobotMonitor {
    requirement: u32,
    robot: u32,
    monitor: Monitor<Observable>,
    speed_m_s: f64,
    stalest: Option<(u32, f64)>,
    longest_cycle_ns: Option<u64>,
}

impl Monitors {
    /// The monitors of the robots of a world.
    ///
    /// # Errors
    /// If there is no such robot, or no such sensor.
    fn new(demands: &[Demand], world: &World) -> Result<Self, UnknownName> {
        let mut each = Vec::new();
        for (i, demand) in demands.iter().enumerate() {
            let robots = world
                .robots()
                .enumerate()
                .filter(|(_, view)| demand.robot.as_ref().is_none_or(|name| view.spec().name == *name));
            let before = each.len();
            each.extend(robots.map(|(robot, _)| RobotMonitor {
                requirement: i as u32,
                robot: robot as u32,
                monitor: Monitor::new(demand.requirement.clone()),
                speed_m_s: 0.0,
                stalest: None,
                longest_cycle_ns: None,
            }));
            if let Some(name) = demand.robot.as_ref().filter(|_| each.len() == before) {
                let names: Vec<_> = world.robots().map(|view| view.spec().name.as_str()).collect();
                return Err(UnknownName::new("robot", name, &names));
            }
        }
        let robots = world.robots().len();
        Ok(Self { each, last_ns: None, speeds_m_s: vec![0.0; robots], gaps: vec![Gaps::default(); robots] })
    }

    /// Sees the world at the beginning of a tick, or at the end.
    ///
    /// # Errors
    /// If a robot lacks a sensor that a requirement names.
    fn see(&mut self, world: &World) -> Result<(), UnknownName> {
        let now_ns = world.time().as_ns();
        // The end of a run may be shown twice.
        if self.last_ns.is_some_and(|last_ns| now_ns <= last_ns) {
            return Ok(());
        }
        self.last_ns = Some(now_ns);
        for (gaps, view) in self.gaps.iter_mut().zip(world.robots()) {
            gaps.see(&view, now_ns);
        }
        for watched in &mut self.each {
            let robot = watched.robot as usize;
            let mut problem = None;
            let value = |quantity: &Observable| {
                quantity.value(world, robot).unwrap_or_else(|error| {
                    problem = Some(error);
                    f64::NAN
                })
            };
            watched.monitor.see(now_ns, value).expect("it is later than the last");
            if let Some(problem) = problem {
                return Err(problem);
            }
            if watched.monitor.verdict().at_ns == now_ns {
                let view = world.robot(robot);
                let speed_m_s =
                    if view.collided() { self.speeds_m_s[robot] } else { view.motion().speed_m_s };
                (watched.speed_m_s, watched.stalest) = (speed_m_s, self.gaps[robot].oldest());
                watched.longest_cycle_ns = view.cycles().durations.max_ns();
            }
        }
        self.speeds_m_s.clear();
        self.speeds_m_s.extend(world.robots().map(|view| view.motion().speed_m_s));
        Ok(())
    }

    fn falls(&self) -> impl Iterator<Item = Fall> {
        self.each.iter().map(|watched| {
            let verdict = watched.monitor.verdict();
            Fall {
                requirement: watched.requirement,
                robot: watched.robot,
                robustness: verdict.robustness.clamp(-MOST, MOST),
                holds: verdict.holds,
                at_ns: verdict.at_ns,
                speed_m_s: watched.speed_m_s,
                stalest: watched.stalest,
                longest_cycle_ns: watched.longest_cycle_ns,
            }
        })
    }
}

impl Gaps {
    fn see(&mut self, view: &RobotView<'_>, now_ns: u64) {
        while self.0.pop_front_if(|gap| now_ns - gap.at_ns > SECOND_NS).is_some() {}
        let ages = (0..view.spec().sensors.len()).filter_map(|sensor| {
            let sampled_at = view.heard(sensor).sampled_at?;
            let age_ms = now_ns.saturating_sub(sampled_at.as_ns()) as f64 / 1e6;
            Some(Gap { at_ns: now_ns, sensor: sensor as u32, age_ms })
        });
        let Some(now) = ages.reduce(|a, b| if b.age_ms > a.age_ms { b } else { a }) else { return };
        while self.0.pop_back_if(|gap| gap.age_ms <= now.age_ms).is_some() {}
        self.0.push_back(now);
    }

    /// The sensor with the oldest reading, and its age in milliseconds.
    fn oldest(&self) -> Option<(u32, f64)> {
        self.0.front().map(|gap| (gap.sensor, gap.age_ms))
    }
}

/// The time before an instant within which the oldest reading is looked for.
const SECOND_NS: u64 = 1_000_000_000;

/// Robustness beyond it is as good as infinite, which JSON has no number for.
const MOST: f64 = 1e300;
