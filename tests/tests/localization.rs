//! Fig. 6.14 through cables: a robot whose odometer errs by metres is kept on its way by a laser on USB.

use std::sync::{Arc, Mutex};

use baudbot_brains::composed::Composed;
use baudbot_brains::description::Description;
use baudbot_brains::registry::Registry;
use baudbot_client::{Action, Body, Brain, Turn};
use baudbot_sim::Scenario;
use baudbot_tests::{InProcess, scenario};

const SCENARIO: &str = include_str!("../../catalogue/scenarios/tour.toml");
const BRAIN: &str = include_str!("../../brains/repertoires/tour.toml");

/// A brain, and where it believes to be, for a test that knows the truth.
struct Witness {
    brain: Composed,
    believed_m: Believed,
}

impl Brain for Witness {
    fn step(&mut self, turn: &Turn) -> Action {
        let action = self.brain.step(turn);
        let position = self.brain.beliefs().pose.map(|estimate| estimate.world_from_robot.position);
        *self.believed_m.lock().unwrap() = position.map(|at| [at.x, at.y]);
        action
    }
}

/// The course of a tour of 48 m.
#[derive(Debug)]
struct Tour {
    /// Root of the mean square distance of what is believed from what is, in metres.
    believed_m: f64,
    /// The greatest distance of what the odometer gives from what is, in metres.
    odometer_m: f64,
    collisions: u64,
}

pub(crate) type Believed = Arc<Mutex<Option<[f64; 2]>>>;

/// A world with a brain that a text describes, and where that believes to be.
pub(crate) fn witnessed(scenario: Scenario, brain: &str) -> (InProcess, Believed) {
    let description = Description::parse(brain).unwrap();
    let body = Body::from(&scenario.robots[0]);
    let brain = description.brain(scenario.seed, &body, &Registry::standard()).unwrap();
    let believed_m = Believed::default();
    let local = InProcess::with_brain(scenario, Witness { brain, believed_m: Arc::clone(&believed_m) });
    (local, believed_m)
}

fn tour(seed: u64, brain: &str) -> Tour {
    let (mut local, believed_m) = witnessed(scenario(SCENARIO, &[&format!("seed={seed}")]), brain);
    let (mut squares, mut count, mut driven_m, mut last) = (0.0, 0.0, 0.0, [2.0, 2.0]);
    let mut tour = Tour { believed_m: 0.0, odometer_m: 0.0, collisions: 0 };
    while driven_m < 48.0 && local.world.ending().is_none() {
        local.tick(|_| {});
        let robot = local.world.robots().next().unwrap();
        let at = robot.motion().pose.position;
        driven_m += (at.x - last[0]).hypot(at.y - last[1]);
        last = [at.x, at.y];
        let Some([x, y]) = *believed_m.lock().unwrap() else { continue };
        squares += (at.x - x).powi(2) + (at.y - y).powi(2);
        count += 1.0;
        let odometer = robot.sensors().nth(1).unwrap().sample;
        tour.odometer_m = tour.odometer_m.max((at.x - odometer[0]).hypot(at.y - odometer[1]));
        tour.collisions += local.world.collisions().len() as u64;
    }
    assert!(driven_m >= 48.0, "it got only {driven_m} m far: {:?}", local.world.ending());
    tour.believed_m = f64::sqrt(squares / count);
    tour
}

fn keeps_its_way(seeds: std::ops::RangeInclusive<u64>) {
    for seed in seeds {
        let tour = tour(seed, BRAIN);
        println!("seed {seed}: {tour:?}");
        assert!(tour.believed_m <= 0.06 && tour.odometer_m > 1.0 && tour.collisions == 0, "{seed}: {tour:?}");
    }
}

#[test]
fn a_laser_keeps_a_robot_on_its_way_whose_odometer_errs_by_metres() {
    keeps_its_way(1..=2);
}

/// The brain of the tour with particles in place of its matches, so many of them.
fn with_particles(parameters: &str) -> String {
    let (before, rest) = BRAIN.split_once("laser_localization").unwrap();
    format!("{before}particle_localization{}", rest.replace("every_s = 5.0", parameters))
}

#[test]
fn particles_keep_it_on_its_way_too() {
    let tour = tour(1, &with_particles(""));
    println!("{tour:?}");
    assert!(tour.believed_m <= 0.06 && tour.odometer_m > 1.0 && tour.collisions == 0, "{tour:?}");
}

/// The robot gets a wrong pose, in another room, and turns on the spot.
#[test]
fn who_does_not_know_where_it_is_finds_out_by_particles() {
    let brain = with_particles("everywhere = true\nparticles = 4000");
    let (_, processes) = brain.split_once("[cognitive.odometry]").unwrap();
    let (_, rest) = processes.split_once('}').unwrap();
    let brain = format!(
        "[motor.turn]\nkind = \"constant\"\nparameters = {{ left = -0.1, right = 0.1 }}\n\
         [cognitive.odometry]\nkind = \"odometry\"\nparameters = {{ start = [9.0, 6.0, 1.0] }}{rest}"
    );
    let (mut local, believed_m) = witnessed(scenario(SCENARIO, &["seed=1"]), &brain);
    let mut off_m = |ticks: usize| {
        (0..ticks).for_each(|_| local.tick(|_| {}));
        let [x, y] = believed_m.lock().unwrap().expect("a belief");
        (x - 2.0).hypot(y - 2.0)
    };
    assert!(off_m(10) > 5.0, "it was told so");
    let found_m = off_m(3000);
    assert!(found_m < 0.1, "{found_m}");
}

/// `cargo test --release -p baudbot-tests --test system localization -- --ignored --nocapture`
#[test]
#[ignore = "takes a minute"]
fn with_ten_seeds() {
    keeps_its_way(1..=10);
}
