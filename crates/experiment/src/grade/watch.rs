//! The measures of a run, from the world at the beginning of each tick. None of it reaches a brain.

use baudbot_geometry::{Point, angle};
use baudbot_sim::collision::Collision;
use baudbot_sim::{RobotView, World};

use crate::figures::Figures;
use crate::grade::deficits::{Cost, Deficit};
use crate::grade::measure::{MEASURES, Measure, Own};
use crate::observer::Sight;
use crate::requirement::Demands;
use crate::served::Believed;

/// All measures of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    figures: Figures,
    own: [Option<f64>; MEASURES.len()],
}

/// A collision.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// The instant, in simulated seconds.
    pub at_s: f64,
    /// The robot.
    pub robot: String,
    /// The obstacle.
    pub with: String,
}

/// The place of the robot at the end that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Target {
    pub(crate) position: Point,
    pub(crate) heading_rad: Option<f64>,
}

/// The measures of a run so far.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// The robot's place.
    robot: usize,
    sight: Sight,
    target: Option<Target>,
    start: Point,
    heading_rad: f64,
    distance_m: f64,
    last_ns: u64,
    turned_rad: f64,
    farthest_m: f64,
    /// The time for which the robot has stood in the ticks so far, in nanoseconds.
    standing_ns: u64,
    standing_since_ns: u64,
    saturated_ns: u64,
    bias: f64,
    backwards_m: f64,
    queue_max_bytes: u64,
    errors: Errors,
    first_hit_s: Option<f64>,
    cost: Cost,
    /// The robot's time in each zone, in nanoseconds.
    in_zone_ns: Vec<u64>,
}

/// Distances of believed poses from the truth, in metres.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    count: u64,
    sum: f64,
    max: f64,
    last: f64,
}

impl Measures {
    /// One of them; `None` if it does not apply.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        match measure {
            Measure::Figure(figure) => self.figures.get(figure),
            Measure::Own(own) => self.own[own as usize],
        }
    }
}

impl Watch {
    /// Watches this robot, with its needs, of a world at its start.
    pub(crate) fn new(world: &World, robot: usize, target: Option<Target>, deficits: &[Deficit]) -> Self {
        let pose = world.robot(robot).motion().pose;
        Self {
            robot,
            sight: Sight::new(Demands::default()),
            target,
            start: pose.position,
            heading_rad: pose.heading,
            distance_m: 0.0,
            last_ns: 0,
            turned_rad: 0.0,
            farthest_m: 0.0,
            standing_ns: 0,
            standing_since_ns: 0,
            saturated_ns: 0,
            bias: 0.0,
            backwards_m: 0.0,
            queue_max_bytes: 0,
            errors: Errors::default(),
            first_hit_s: None,
            cost: Cost::new(deficits),
            in_zone_ns: world.score().in_zone_ns(robot).to_vec(),
        }
    }

    /// Sees the world at the beginning of a tick, or at the end, and the poses that brains have published since the tick before. Gives
    /// the collisions of that tick.
    pub(crate) fn see(&mut self, world: &World, believed: &[Believed]) -> Vec<Hit> {
        self.sight.see(world);
        let robot = world.robot(self.robot);
        let pose = robot.motion().pose;
        for believed in believed.iter().filter(|believed| believed.robot == self.robot) {
            self.errors.add((Point::new(believed.x_m, believed.y_m) - pose.position).norm());
        }
        let now_ns = world.time().as_ns();
        let took_ns = now_ns.saturating_sub(self.last_ns);
        if took_ns == 0 {
            return Vec::new();
        }
        self.last_ns = now_ns;
        self.turned_rad += angle::difference(pose.heading, self.heading_rad);
        self.heading_rad = pose.heading;
        self.farthest_m = self.farthest_m.max((pose.position - self.start).norm());
        self.note_motion(&robot, now_ns, took_ns);
        self.note_needs(world, took_ns);
        self.queue_max_bytes = self.queue_max_bytes.max(robot.under_way()[1]);
        self.hits(world)
    }

    fn note_needs(&mut self, world: &World, took_ns: u64) {
        let in_zone_ns = world.score().in_zone_ns(self.robot);
        let spent_s = |zone: usize| (in_zone_ns[zone] - self.in_zone_ns[zone]) as f64 / 1e9;
        self.cost.step(took_ns as f64 / 1e9, spent_s);
        self.in_zone_ns.copy_from_slice(in_zone_ns);
    }

    fn note_motion(&mut self, robot: &RobotView<'_>, now_ns: u64, took_ns: u64) {
        let motion = robot.motion();
        if motion.speed_m_s.abs() < STILL_M_S && motion.turn_rate_rad_s.abs() < STILL_RAD_S {
            self.standing_ns += took_ns;
        } else {
            self.standing_since_ns = now_ns;
        }
        let signals = robot.signals();
        if signals.left.abs().max(signals.right.abs()) >= 1.0 {
            self.saturated_ns += took_ns;
        }
        self.bias += (signals.right - signals.left) / 2.0 * took_ns as f64;
        let distance_m = robot.counters().distance_m;
        if motion.speed_m_s < 0.0 {
            self.backwards_m += distance_m - self.distance_m;
        }
        self.distance_m = distance_m;
    }

    fn hits(&mut self, world: &World) -> Vec<Hit> {
        let at_s = world.time().as_ns() as f64 / 1e9;
        let own = &world.robot(self.robot).spec().name;
        if world.collisions().iter().any(|collision| collision.robot == *own) {
            self.first_hit_s.get_or_insert(at_s);
        }
        let hit =
            |Collision { robot, with }: &Collision| Hit { at_s, robot: robot.clone(), with: with.clone() };
        world.collisions().iter().map(hit).collect()
    }

    /// All measures, at the end of the run.
    pub(crate) fn measures(&self, world: &World) -> Measures {
        let robot = world.robot(self.robot);
        let pose = robot.motion().pose;
        let time_ns = self.last_ns.max(1) as f64;
        let mut own = [None; MEASURES.len()];
        let mut set = |measure: Own, value: Option<f64>| {
            own[measure as usize] = value.filter(|value| value.is_finite());
        };
        set(Own::TurnedRad, Some(self.turned_rad));
        set(Own::FarthestM, Some(self.farthest_m));
        set(Own::EndErrorM, self.target.map(|target| (target.position - pose.position).norm()));
        let heading_rad = self.target.and_then(|target| target.heading_rad);
        set(Own::EndErrorRad, heading_rad.map(|wanted| angle::difference(pose.heading, wanted).abs()));
        set(Own::StandingShare, Some(self.standing_ns as f64 / time_ns));
        set(Own::StandingEndS, Some((self.last_ns - self.standing_since_ns) as f64 / 1e9));
        let backwards = self.backwards_m / self.distance_m;
        set(Own::BackwardsShare, Some(if self.distance_m > 0.0 { backwards } else { 0.0 }));
        set(Own::SaturatedShare, Some(self.saturated_ns as f64 / time_ns));
        set(Own::SignalBias, Some(self.bias / time_ns));
        set(Own::FirstCollisionS, self.first_hit_s);
        set(Own::InGoalsS, in_goals_s(world, self.robot));
        set(Own::Commands, Some(robot.commands() as f64));
        set(Own::BytesDown, Some(robot.downlink().bytes as f64));
        set(Own::BytesUp, Some(robot.uplink().bytes as f64));
        set(Own::QueueMaxBytes, Some(self.queue_max_bytes as f64));
        set(Own::Beliefs, Some(self.errors.count as f64));
        let errors = (self.errors.count > 0).then_some(self.errors);
        set(Own::BeliefErrorMeanM, errors.map(|errors| errors.sum / errors.count as f64));
        set(Own::BeliefErrorMaxM, errors.map(|errors| errors.max));
        set(Own::BeliefErrorEndM, errors.map(|errors| errors.last));
        set(Own::QuadraticCost, self.cost.total());
        let mut figures = Figures::of_world(world);
        self.sight.complete(&mut figures);
        Measures { figures, own }
    }
}

impl Errors {
    fn add(&mut self, error_m: f64) {
        self.count += 1;
        self.sum += error_m;
        self.max = self.max.max(error_m);
        self.last = error_m;
    }
}

/// A robot's time in zones that are goals; `None` if there are none.
fn in_goals_s(world: &World, robot: usize) -> Option<f64> {
    let zones = &world.scenario().surroundings.zones;
    let goals = zones.iter().zip(world.score().in_zone_ns(robot)).filter(|(zone, _)| zone.goal);
    goals.map(|(_, &ns)| ns as f64 / 1e9).reduce(|a, b| a + b)
}

/// A robot stands still below this speed, in metres per second,
const STILL_M_S: f64 = 0.005;

/// and this turn rate, in radians per second.
const STILL_RAD_S: f64 = 0.01;
