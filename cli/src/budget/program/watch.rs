//! A run in which programs are watched.

use std::sync::Arc;

use baudbot_scenario::budget::Span;
use baudbot_sim::chip::{Board, ChipSpec, Edge, Seen, WheelPins};
use baudbot_sim::link::LineCounters;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::What;
use baudbot_sim::{RobotView, Scenario, World};

use super::{Age, Load, ProgramBudget, Rate, Rounds, verdict};
use crate::trace::unseen;

/// The observations of a robot's program.
pub(super) struct Watch {
    robot: usize,
    wheels: WheelPins,
    /// The number of edges and events.
    edges: u64,
    events: u64,
    conversions: u64,
    /// The instants at which each sensor was read.
    reads: Vec<Vec<u64>>,
    /// The instants at which the motors were made to do otherwise.
    changes: Vec<u64>,
}

/// The world after so many seconds, or when its run was over before.
pub(super) fn measure(scenario: &Arc<Scenario>, robots: &[usize], seconds: f64) -> (World, Vec<Watch>) {
    let mut world = World::new(Arc::clone(scenario));
    world.keep_timeline(EVENTS);
    let watch = |&robot: &usize| {
        let spec = &scenario.robots[robot];
        spec.chip.as_deref().map(|chip| Watch::new(robot, (spec, chip)))
    };
    let mut watches: Vec<Watch> = robots.iter().filter_map(watch).collect();
    robots.iter().for_each(|&robot| world.keep_edges(robot, true));
    let ticks = (seconds * 1e9 / scenario.step_ns as f64).ceil().max(1.0) as u64;
    while world.tick() < ticks && world.ending().is_none() {
        world.begin();
        world.finish(&[]);
        watches.iter_mut().for_each(|watch| watch.see(&world));
    }
    (world, watches)
}

impl Watch {
    fn new(robot: usize, (spec, chip): (&RobotSpec, &ChipSpec)) -> Self {
        let (wheels, reads) = (WheelPins::new(chip), vec![Vec::new(); spec.sensors.len()]);
        Self { robot, wheels, edges: 0, events: 0, conversions: 0, reads, changes: Vec::new() }
    }

    fn see(&mut self, world: &World) {
        let robot = world.robot(self.robot);
        let Some(edges) = robot.board().and_then(Board::edges) else { return };
        let (_, seen) = edges.since(unseen(self.edges, edges.total()));
        self.edges = edges.total();
        seen.for_each(|edge| self.edge(edge));
        let timeline = robot.timeline();
        let (_, events) = timeline.since(unseen(self.events, timeline.total()));
        self.events = timeline.total();
        for event in events {
            if let What::Acquire { sensor } = event.what
                && let Some(reads) = self.reads.get_mut(usize::from(sensor))
            {
                reads.push(event.start.as_ns());
            }
        }
    }

    fn edge(&mut self, edge: &Edge) {
        if matches!(edge.seen, Seen::Converted { .. }) {
            self.conversions += 1;
        }
        if self.wheels.take(edge).is_some() {
            self.changes.push(edge.at_ns);
        }
    }

    pub(super) fn budget(&self, world: &World) -> Option<ProgramBudget> {
        let robot = world.robot(self.robot);
        let (spec, board) = (robot.spec(), robot.board()?);
        let starts_after_ns = spec.processor.bootloader_ns;
        let watched_ns = world.time().as_ns().saturating_sub(starts_after_ns).max(1);
        let per_s = |count: u64| count as f64 * 1e9 / watched_ns as f64;
        let rounds = board.rounds();
        let ns = |cycles: u64| board.clock().ns(cycles);
        let round = rounds.map(|rounds| Span {
            best_ns: ns(rounds.least()),
            typical_ns: Some(ns(rounds.typical())),
            worst_ns: Some(ns(rounds.most())),
        });
        let (ages, readings_to_motors) = self.ages(spec);
        let lost_bytes = [robot.uplink(), robot.downlink()].into_iter().map(lost).sum();
        let deadline_ns = deadline_ns(world, spec);
        Some(ProgramBudget {
            robot: spec.name.clone(),
            part: board.chip().part().properties().name.to_owned(),
            clock_hz: board.clock().hz(),
            watched_ns,
            starts_after_ns,
            deadline_ns,
            round_cycles: rounds.map(|rounds| Rounds {
                count: rounds.count(),
                best: rounds.least(),
                typical: rounds.typical(),
                worst: rounds.most(),
            }),
            round,
            readings_to_motors,
            rates: self.rates(spec, rounds.map_or(0, |rounds| rounds.count()), per_s),
            ages,
            loads: loads(&robot, board, per_s),
            stack_bytes: u32::from(board.chip().part().ram_end().saturating_sub(board.chip().lowest_sp())),
            lost_bytes,
            verdict: verdict(deadline_ns, [round, readings_to_motors], lost_bytes),
        })
    }

    fn rates(&self, spec: &RobotSpec, rounds: u64, per_s: impl Fn(u64) -> f64) -> Vec<Rate> {
        let all = [
            ("rounds of the main loop", rounds),
            ("conversions of the ADC", self.conversions),
            ("changes of the motors", self.changes.len() as u64),
        ];
        let all = all.into_iter().map(|(what, count)| (what.to_owned(), count));
        let sensors = self.read_by_program(spec);
        let sensors = sensors.map(|(name, reads)| (format!("sensor {name}"), reads.len() as u64));
        all.chain(sensors).map(|(what, count)| Rate { what, per_s: per_s(count) }).collect()
    }

    /// The sensors that the program asks for.
    fn read_by_program<'a>(&'a self, spec: &'a RobotSpec) -> impl Iterator<Item = (&'a str, &'a [u64])> {
        let asks_for = move |place| spec.chip.as_ref().is_some_and(|chip| chip.asks_for(place));
        let sensors = spec.sensors.iter().zip(&self.reads).enumerate();
        let asked = sensors.filter(move |(place, (_, reads))| !reads.is_empty() && asks_for(*place));
        asked.map(|(_, (sensor, reads))| (sensor.name.as_str(), reads.as_slice()))
    }

    /// The age of each sensor's newest reading when the motors' signals changed, and the oldest of these.
    fn ages(&self, spec: &RobotSpec) -> (Vec<Age>, Option<Span>) {
        let mut oldest = vec![None; self.changes.len()];
        let mut ages = Vec::new();
        for (sensor, reads) in self.read_by_program(spec) {
            let age = |at: u64| {
                let newest = reads.partition_point(|read| *read <= at).checked_sub(1)?;
                Some(at - reads[newest]).filter(|age| *age <= FORGOTTEN_NS)
            };
            let of_changes: Vec<Option<u64>> = self.changes.iter().map(|at| age(*at)).collect();
            oldest.iter_mut().zip(&of_changes).for_each(|(oldest, age)| *oldest = (*oldest).max(*age));
            if let Some(span) = span(of_changes.into_iter().flatten().collect()) {
                ages.push(Age { sensor: sensor.to_owned(), span });
            }
        }
        (ages, span(oldest.into_iter().flatten().collect()))
    }
}

/// The loads: of the cable each way, and of the processor.
fn loads(robot: &RobotView<'_>, board: &Board, per_s: impl Fn(u64) -> f64) -> Vec<Load> {
    let most = 1e9 / robot.spec().link.burst_ns(1).max(1) as f64;
    let cable = |what, line: &LineCounters| {
        let bytes = per_s(line.bytes);
        Load { what, share: bytes / most, bytes_per_s: Some(bytes), most_bytes_per_s: Some(most) }
    };
    let awake = board.share_asleep().map(|asleep| Load {
        what: "processor",
        share: 1.0 - asleep,
        bytes_per_s: None,
        most_bytes_per_s: None,
    });
    [cable("uplink", robot.uplink()), cable("downlink", robot.downlink())].into_iter().chain(awake).collect()
}

fn lost(line: &LineCounters) -> u64 {
    line.corrupted_bytes + line.overrun_bytes + line.refused_bytes + line.lost_bytes
}

fn deadline_ns(world: &World, spec: &RobotSpec) -> u64 {
    match spec.deadline.on_late {
        Some(_) => spec.deadline.within_ns,
        None => world.scenario().step_ns,
    }
}

/// The least, the median and the most.
fn span(mut ns: Vec<u64>) -> Option<Span> {
    ns.sort_unstable();
    let (best, worst) = (*ns.first()?, *ns.last()?);
    Some(Span { best_ns: best, typical_ns: Some(ns[ns.len() / 2]), worst_ns: Some(worst) })
}

/// Events on a robot's timeline in a tick.
const EVENTS: usize = 1 << 14;

/// A sensor that was not read for so long is none that the program goes by.
const FORGOTTEN_NS: u64 = 1_000_000_000;
