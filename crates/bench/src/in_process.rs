//! Worlds with their brains in one thread: no network, no pace.

use baudbot_scenario::ScenarioError;
use baudbot_sim::World;
use baudbot_sim::chip::Board;
use baudbot_sim::model::RobotSpec;

use crate::measure::{self, Effort, Sample};
use crate::outcome::Beside;
use crate::plan::{Plan, PlanError};
use crate::process::Clock;
use crate::rig::{NoThreads, Rig};
use crate::scale::Scale;
use crate::scenario::{Cable, Infrared, Laser, Program, chips, office, parse, plans};

/// A world that runs as fast as it can.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InProcess {
    /// Small robots with infra-red sensors, 1, 10, 100 or 1,000 of them; in steps of a robot.
    Infrared { robots: usize, cable: Cable },
    /// Robots with lasers in an office; one in rays a second, many as a multiple of real time.
    Office { robots: usize, laser: Laser },
    /// Robots whose microcontrollers run a program, cycle by cycle; in robots that keep real time.
    Chips { robots: usize, program: Program },
}

/// The reason why a workload could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// The floor plan is invalid.
    #[error("a floor plan in crates/bench/geometry: {0}")]
    Plan(#[from] PlanError),
    /// The parser refused its scenario.
    #[error("the workload's scenario: {0}")]
    Scenario(#[from] ScenarioError),
    /// There are not as many threads as asked for.
    #[error(transparent)]
    Threads(#[from] NoThreads),
    /// The workload has other processes, and a number of ticks means nothing.
    #[error("`{0}` has other processes and takes no --ticks; W1 to W4, G and V do")]
    NotInProcess(&'static str),
    /// The run is not the workload.
    #[error("the run is not what it should be: {0}")]
    NotReal(String),
}

/// The findings of a run in process.
pub(crate) struct Run {
    pub(crate) samples: Vec<Sample>,
    /// Ticks of the first stretch, and the world's fingerprint after it: the same for every build and machine.
    pub(crate) probe_ticks: u64,
    pub(crate) hash: u64,
    /// The measurement by turns with the run.
    pub(crate) beside: Option<Beside>,
    pub(crate) notes: Vec<String>,
}

impl InProcess {
    /// Measures it. A crowd of 10,000 is measured by turns with 100 of them.
    pub(crate) fn run(
        self,
        effort: Effort,
        threads: usize,
        mut progress: impl FnMut(u32),
    ) -> Result<Run, Unfit> {
        let mut own = Stretch::begin(self, threads)?;
        let mut few = match self {
            Self::Infrared { robots: CROWD, cable } => {
                Some(Stretch::begin(Self::Infrared { robots: FEW, cable }, threads)?)
            }
            Self::Infrared { .. } | Self::Office { .. } | Self::Chips { .. } => None,
        };
        match &mut few {
            None => own.measure(effort, progress)?,
            Some(few) => {
                for repeat in 1..=effort.repeats {
                    progress(repeat);
                    let once = Effort { repeats: 1, ..effort };
                    few.measure(once, |_| {})?;
                    own.measure(once, |_| {})?;
                }
            }
        }
        let what = || format!("{FEW} robots");
        let beside = few.map(|few| Beside { what: what(), samples: few.samples });
        Ok(Run {
            notes: beside.iter().map(|few| growth(&few.samples, &own.samples)).collect(),
            samples: own.samples,
            probe_ticks: self.probe_ticks(),
            hash: own.hash,
            beside,
        })
    }

    /// Runs a number of ticks from the start; the world's fingerprint after them.
    pub(crate) fn run_ticks(self, ticks: u64, threads: usize) -> Result<u64, Unfit> {
        let mut rig = self.rig()?;
        rig.set_threads(threads)?;
        rig.run(ticks);
        Ok(rig.world().hash())
    }

    /// The world at its start.
    pub(crate) fn rig(self) -> Result<Rig, Unfit> {
        Ok(Rig::new(parse(&self.scenario()?)?))
    }

    fn scenario(self) -> Result<String, PlanError> {
        Ok(match self {
            Self::Infrared { robots, cable } => {
                let plan: Plan = match robots {
                    1 => plans::IR_1,
                    10 => plans::IR_10,
                    1000 => plans::IR_1000,
                    _ => plans::IR_100,
                }
                .parse()?;
                let side = (robots / plan.robots.len()).isqrt();
                Infrared::new(cable).scenario(&plan.tiled(side))
            }
            Self::Office { robots, laser } => office(&plans::OFFICE.parse::<Plan>()?, robots, laser),
            Self::Chips { robots, program } => chips(robots, program),
        })
    }

    /// A number of ticks in which every sensor is read several times and every robot is on its way, and which take a
    /// debug build no more than a second or two.
    pub(crate) fn probe_ticks(self) -> u64 {
        match self {
            Self::Infrared { robots, .. } => (2000 / robots as u64).max(10),
            Self::Office { robots: 1, .. } => 200,
            Self::Office { .. } => 30,
            Self::Chips { .. } => 100,
        }
    }

    /// Two numbers of ticks with whole scans, and no more than valgrind goes through in some seconds.
    pub(crate) fn scale(self) -> Scale {
        let (ticks, units_a_tick, unit) = match self {
            Self::Infrared { robots: 1, .. } => ([2000, 12_000], 1.0, "step"),
            Self::Infrared { robots: CROWD, .. } => ([2, 6], CROWD as f64, "robot-step"),
            Self::Infrared { robots, .. } => {
                ([2000 / robots as u64, 12_000 / robots as u64], robots as f64, "robot-step")
            }
            Self::Office { robots: 1, .. } => ([200, 1200], self.units_a_tick(), "ray"),
            Self::Office { robots, laser: Laser::Still { .. } } => ([10, 60], robots as f64, "robot-tick"),
            Self::Office { robots, laser: Laser::Swept { .. } } => ([20, 40], robots as f64, "robot-tick"),
            Self::Chips { robots, .. } => ([2, 12], robots as f64, "robot-tick"),
        };
        Scale { ticks, units_a_tick, unit }
    }

    fn units_a_tick(self) -> f64 {
        match self {
            Self::Infrared { robots, .. } => robots as f64,
            Self::Office { robots: 1, laser } => laser.rays() as f64 * STEP_MS / f64::from(laser.period_ms()),
            Self::Office { .. } => STEP_MS * 1e-3,
            Self::Chips { robots, .. } => robots as f64 * STEP_MS * 1e-3,
        }
    }
}

/// A world that is measured bit by bit.
struct Stretch {
    world: InProcess,
    rig: Rig,
    clock: Clock,
    /// The fingerprint after its first ticks.
    hash: u64,
    samples: Vec<Sample>,
}

impl Stretch {
    /// The stretch after its first ticks.
    fn begin(world: InProcess, threads: usize) -> Result<Self, Unfit> {
        let mut rig = world.rig()?;
        rig.set_threads(threads)?;
        rig.run(world.probe_ticks());
        check(&rig)?;
        let hash = rig.world().hash();
        let clock = if threads == 1 { Clock::Processor } else { Clock::Wall };
        Ok(Self { world, rig, clock, hash, samples: Vec::new() })
    }

    fn measure(&mut self, effort: Effort, progress: impl FnMut(u32)) -> Result<(), Unfit> {
        let samples = measure::rate(effort, self.clock, progress, |ticks| {
            self.rig.run(ticks);
            Ok::<_, Unfit>(())
        })?;
        check(&self.rig)?;
        let units = self.world.units_a_tick();
        self.samples
            .extend(samples.into_iter().map(|sample| Sample { value: sample.value * units, ..sample }));
        Ok(())
    }
}

/// The cost of a robot in a crowd, in terms of one among few: pairs that were measured one after the other.
fn growth(few: &[Sample], crowd: &[Sample]) -> String {
    let costs: Vec<_> = few.iter().zip(crowd).map(|(few, crowd)| few.value / crowd.value).collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let most = costs.iter().copied().fold(0.0, f64::max);
    format!(
        "a robot among {CROWD} costs {:.2} times as much as one among {FEW} ({least:.2} to {most:.2}, {} pairs)",
        measure::median(costs.iter().copied()),
        costs.len()
    )
}

/// Whether every robot drives, is somewhere, and reads its sensors as often as it should.
fn check(rig: &Rig) -> Result<(), Unfit> {
    let (world, step_ns) = (rig.world(), rig.world().scenario().step_ns);
    let run_ns = world.tick() * step_ns;
    for robot in world.robots() {
        let (spec, pose) = (robot.spec(), robot.motion().pose);
        let wrong = |what: String| Err(Unfit::NotReal(format!("robot `{}` {what}", spec.name)));
        let place = [pose.position.x, pose.position.y, pose.heading];
        if !place.iter().all(|number| number.is_finite()) {
            return wrong(format!("is at {place:?}"));
        }
        let way_m = robot.counters().distance_m;
        // A robot that turns on the spot at times is on its way for a good part of its first minute all the same. Of a
        // crowd one may find itself in a corner, hours later, that it does not get out of; all together still drive.
        let least_m = SLOWEST_M_S * (run_ns as f64 * 1e-9).min(A_MINUTE_S);
        if way_m.partial_cmp(&least_m) != Some(std::cmp::Ordering::Greater) {
            return wrong(format!("has driven {way_m} m in {} s", run_ns as f64 * 1e-9));
        }
        if let Some(board) = robot.board() {
            check_chip(&spec.name, board)?;
            continue;
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
    check_ways(world, run_ns)
}

/// Whether a chip runs a program that has nothing wrong with it.
fn check_chip(robot: &str, board: &Board) -> Result<(), Unfit> {
    if board.chip().cycles() > 0 && board.warnings().is_empty() {
        return Ok(());
    }
    Err(Unfit::NotReal(format!("robot `{robot}` has a chip of which is to be said: {:?}", board.warnings())))
}

/// Whether all robots together drive.
fn check_ways(world: &World, run_ns: u64) -> Result<(), Unfit> {
    let ways_m: f64 = world.robots().map(|robot| robot.counters().distance_m).sum();
    let mean_m = ways_m / world.robots().len() as f64;
    let least_m = SLOWEST_M_S * run_ns as f64 * 1e-9;
    if mean_m.partial_cmp(&least_m) != Some(std::cmp::Ordering::Greater) {
        return Err(Unfit::NotReal(format!(
            "robots have driven {mean_m} m each in {} s",
            run_ns as f64 * 1e-9
        )));
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

/// Robots of the largest world, and of the one that it is compared with.
const CROWD: usize = 10_000;
const FEW: usize = 100;

const STEP_MS: f64 = 10.0;

/// Slower than this in the mean, each robot in its first minute and all of them in the whole run, something is wrong.
const SLOWEST_M_S: f64 = 1e-3;

const A_MINUTE_S: f64 = 60.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::{Kind, WORKLOADS};

    /// Fingerprints after the first ticks. They change for the reasons for which golden hashes may
    /// (docs/explanation/determinism.md), and for another scenario or driver here; never for speed.
    const FINGERPRINTS: [(&str, u64); 14] = [
        ("W1/onboard", 0x5648_f963_c49a_2ab1),
        ("W1/ideal", 0x152c_5060_4948_4df9),
        ("W2", 0x45ee_5ce9_f659_d455),
        ("W2s/onboard", 0x58de_0822_51d9_b808),
        ("W2s/cable", 0x8001_b890_8d99_4c19),
        ("W3/10", 0x4e2a_ad67_32f7_059a),
        ("W3/100", 0xe5ad_d17b_065b_3ddb),
        ("W3/1000", 0x3fe7_3622_421f_6263),
        ("W4", 0x4f9c_fedc_3b58_b8a1),
        ("W4s/onboard", 0xd1d8_143e_a7c7_826b),
        ("W4s/cable", 0x64e5_b638_91a1_9174),
        ("G", 0xb4eb_3d15_1ccd_73d7),
        ("F/spinning", 0x35b3_7a76_ed2f_3336),
        ("F/sleeping", 0x58e4_c183_43d1_d477),
    ];

    #[test]
    fn each_workload_is_real_and_the_same_as_ever() {
        let mut known = FINGERPRINTS.iter();
        for workload in WORKLOADS {
            let Kind::InProcess(world) = workload.kind else { continue };
            let mut rig = world.rig().unwrap();
            rig.run(world.probe_ticks());
            check(&rig).unwrap_or_else(|error| panic!("{}: {error}", workload.name));
            let (name, hash) = known.next().expect("a fingerprint for each");
            assert_eq!((workload.name, rig.world().hash()), (*name, *hash), "{:x}", rig.world().hash());
        }
    }

    #[test]
    fn workloads_are_what_the_table_says() {
        let facts = |world: InProcess| {
            let rig = world.rig().unwrap();
            let scenario = rig.world().scenario();
            let spec = &scenario.robots[0];
            let rays: usize = spec.sensors.iter().map(|sensor| sensor.device.values()).sum();
            (scenario.arena.index().segments().len(), scenario.robots.len(), rays, scenario.noise)
        };
        assert_eq!(facts(InProcess::Infrared { robots: 1, cable: Cable::Ideal }), (8, 1, 8, true));
        assert_eq!(facts(InProcess::Infrared { robots: 1000, cable: Cable::Onboard }), (404, 1000, 8, true));
        // A hundred floors of ten boxes each, with the walls around and between them.
        let crowd = InProcess::Infrared { robots: CROWD, cable: Cable::Onboard };
        assert_eq!(facts(crowd), (100 * 10 * 4 + 2 * 11 * 10, 10_000, 8, true));
        assert_eq!(
            facts(InProcess::Office { robots: 1, laser: Laser::Still { period_ms: 10 } }),
            (100, 1, 683, true)
        );
        assert_eq!(
            facts(InProcess::Office { robots: 100, laser: Laser::Still { period_ms: 100 } }),
            (100, 100, 683, true)
        );
        let swept = |cable| facts(InProcess::Office { robots: 1, laser: Laser::Swept { cable } });
        assert_eq!([false, true].map(swept), [(100, 1, 682, true); 2]);
    }

    #[test]
    fn a_swept_laser_is_the_presets_but_for_its_cable() {
        let laser = |cable| {
            let rig = InProcess::Office { robots: 1, laser: Laser::Swept { cable } }.rig().unwrap();
            let sensor = &rig.world().scenario().robots[0].sensors[0];
            let is_on_a_cable = sensor.port.is_some();
            (is_on_a_cable, format!("{:?}", (&sensor.device, &sensor.own_clock, &sensor.noise)))
        };
        let [(on_board, own), (on_a_cable, presets)] = [false, true].map(laser);
        assert_eq!((on_board, on_a_cable), (false, true));
        assert_eq!(own, presets);
    }

    #[test]
    fn a_run_in_which_nobody_drives_is_refused() {
        let rig = InProcess::Infrared { robots: 1, cable: Cable::Onboard }.rig().unwrap();
        let error = check(&rig).unwrap_err().to_string();
        assert!(error.starts_with("the run is not what it should be: robot `r0000` has driven"), "{error}");
    }

    #[test]
    fn the_bits_do_not_depend_on_the_number_of_threads() {
        for world in [
            InProcess::Infrared { robots: 100, cable: Cable::Ideal },
            InProcess::Infrared { robots: 1000, cable: Cable::Onboard },
            InProcess::Office { robots: 100, laser: Laser::Still { period_ms: 100 } },
        ] {
            let alone = world.run_ticks(15, 1).unwrap();
            for threads in [2, 4, 16] {
                assert_eq!(world.run_ticks(15, threads).unwrap(), alone, "{threads} threads");
            }
        }
    }
}
