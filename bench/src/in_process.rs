//! Worlds with their brains in one thread: no network, no pace.

use baudbot_sim::robot::RobotSpec;
use baudbot_sim::scenario::ScenarioError;

use crate::measure::{self, Effort, Sample};
use crate::plan::{Plan, PlanError};
use crate::rig::{NoThreads, Rig};
use crate::scenario::{Cable, Infrared, LASER_RAYS, office, parse, plans};

/// A world that runs as fast as it can.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InProcess {
    /// Small robots with infra-red sensors, 1, 10, 100 or 1,000 of them; in steps of a robot.
    Infrared { robots: usize, cable: Cable },
    /// Robots with lasers in an office; one in rays a second, many as a multiple of real time.
    Office { robots: usize, period_ms: u32 },
}

/// Why a workload could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// Its floor plan says nothing.
    #[error("a floor plan in bench/geometry: {0}")]
    Plan(#[from] PlanError),
    /// The parser refused its scenario.
    #[error("the workload's scenario: {0}")]
    Scenario(#[from] ScenarioError),
    /// There are not as many threads as asked for.
    #[error(transparent)]
    Threads(#[from] NoThreads),
    /// What ran is not the workload.
    #[error("the run is not what it should be: {0}")]
    NotReal(String),
}

/// What was found of a run in process.
pub(crate) struct Run {
    pub(crate) samples: Vec<Sample>,
    /// Ticks of the first stretch, and the world's fingerprint after it: the same for every build and machine.
    pub(crate) probe_ticks: u64,
    pub(crate) hash: u64,
}

impl InProcess {
    /// Measures it.
    pub(crate) fn run(self, effort: Effort, threads: usize, progress: impl FnMut(u32)) -> Result<Run, Unfit> {
        let mut rig = self.rig()?;
        rig.set_threads(threads)?;
        let probe_ticks = self.probe_ticks();
        rig.run(probe_ticks);
        check(&rig)?;
        let hash = rig.world().hash();
        let mut samples = measure::rate(effort, progress, |ticks| {
            rig.run(ticks);
            Ok::<_, Unfit>(())
        })?;
        check(&rig)?;
        let units = self.units_a_tick();
        for sample in &mut samples {
            sample.value *= units;
        }
        Ok(Run { samples, probe_ticks, hash })
    }

    /// The world at its start.
    pub(crate) fn rig(self) -> Result<Rig, Unfit> {
        Ok(Rig::new(parse(&self.scenario()?)?))
    }

    fn scenario(self) -> Result<String, PlanError> {
        Ok(match self {
            Self::Infrared { robots, cable } => {
                let plan = match robots {
                    1 => plans::IR_1,
                    10 => plans::IR_10,
                    100 => plans::IR_100,
                    _ => plans::IR_1000,
                };
                Infrared::new(cable).scenario(&plan.parse()?)
            }
            Self::Office { robots, period_ms } => {
                office(&plans::OFFICE.parse::<Plan>()?, robots, period_ms.into())
            }
        })
    }

    /// So many ticks that every sensor is read several times and every robot is on its way, and no more than take a
    /// debug build a second or two.
    pub(crate) fn probe_ticks(self) -> u64 {
        match self {
            Self::Infrared { robots, .. } => (2000 / robots as u64).max(10),
            Self::Office { robots: 1, .. } => 200,
            Self::Office { .. } => 30,
        }
    }

    fn units_a_tick(self) -> f64 {
        match self {
            Self::Infrared { robots, .. } => robots as f64,
            Self::Office { robots: 1, .. } => LASER_RAYS as f64,
            Self::Office { .. } => STEP_S,
        }
    }
}

/// Whether every robot drives, is somewhere, and reads its sensors as often as it should.
fn check(rig: &Rig) -> Result<(), Unfit> {
    let (world, step_ns) = (rig.world(), rig.world().scenario().step_ns());
    let run_ns = world.tick() * step_ns;
    for robot in world.robots() {
        let (spec, pose) = (robot.spec(), robot.motion().pose);
        let wrong = |what: String| Err(Unfit::NotReal(format!("robot `{}` {what}", spec.name)));
        let place = [pose.position.x, pose.position.y, pose.heading];
        if !place.iter().all(|number| number.is_finite()) {
            return wrong(format!("is at {place:?}"));
        }
        let way_m = robot.counters().distance_m;
        // A robot that turns on the spot at times is on its way for a good part of the run all the same.
        if way_m.partial_cmp(&(SLOWEST_M_S * run_ns as f64 * 1e-9)) != Some(std::cmp::Ordering::Greater) {
            return wrong(format!("has driven {way_m} m in {} s", run_ns as f64 * 1e-9));
        }
        if robot.commands() + 2 < world.tick() / commands_every(spec, step_ns) {
            return wrong(format!("obeyed {} commands in {} ticks", robot.commands(), world.tick()));
        }
        for (sensor, view) in spec.sensors.iter().zip(robot.sensors()) {
            let expected = run_ns / period_ns(sensor);
            if view.samples.abs_diff(expected) > 1 || view.missed > 0 {
                let name = &sensor.name;
                return wrong(format!("read `{name}` {} times, not {expected}", view.samples));
            }
        }
    }
    Ok(())
}

/// Ticks between two commands: a robot answers each reading.
fn commands_every(spec: &RobotSpec, step_ns: u64) -> u64 {
    spec.sensors.iter().map(|sensor| period_ns(sensor) / step_ns).max().unwrap_or(1).max(1)
}

fn period_ns(sensor: &baudbot_sim::sensor::Sensor) -> u64 {
    sensor.own_clock.map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns)
}

const STEP_S: f64 = 0.01;

/// Slower than this in the mean, something is wrong.
const SLOWEST_M_S: f64 = 1e-3;
