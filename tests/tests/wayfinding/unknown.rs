//! Past what no map has, by VFH+.

use std::fmt::Write as _;

use baudbot_brains::Chance;

use super::arena::Arena;
use super::{HALL, Run, STEERING, SWEEPER, described, of, reaches};

const PERSON: &str = "[[arena.movers]]\nname = \"person\"\nradius_m = 0.2\nx_m = 5.5\ny_m = 1.0\nheight_m = 1.7\n\
                      wander = { speed_m_s = 0.5, turn_s = 4.0 }";

/// The number of runs that were not done in time, and of those that collided.
fn lost_among_obstacles(seeds: std::ops::Range<u64>) -> [usize; 2] {
    let (mut lost, mut collided) = (0, 0);
    for seed in seeds {
        let chance = &mut Chance::new(seed, "unknown");
        let is_room = seed % 3 != 0;
        let arena = if is_room { Arena::pillars(chance) } else { Arena::aisle(chance) };
        let (start, goal) = if is_room { ([0.7, 0.7], [6.3, 5.3]) } else { ([0.7, 1.1], [8.3, 1.1]) };
        let brain = format!(
            "[motor.go]\nkind = \"vfh\"\n[motor.go.parameters]\ngoals_m = [{goal:?}]\n\
             {STEERING}\n[cognitive.odometry]\nkind = \"odometry\""
        );
        let person = if is_room { PERSON } else { "" };
        let mut local = described(arena.scenario(start, seed, person), &brain);
        let reached = reaches(&mut local, goal, 120);
        let run = of(&local);
        if !reached || run.collisions > 0 {
            println!("seed {seed}: there: {reached}, {run:?}");
        }
        lost += usize::from(!reached);
        collided += usize::from(run.collisions > 0);
    }
    [lost, collided]
}

#[test]
fn random_rooms_with_pillars_and_a_person_are_crossed_without_a_map() {
    assert_eq!(lost_among_obstacles(0..6), [0, 0]);
}

#[test]
#[ignore = "some minutes; the same with six arenas always"]
fn all_of_200_random_rooms_are_crossed_and_nobody_is_touched() {
    assert_eq!(lost_among_obstacles(0..200), [0, 0]);
}

/// A drive to and fro twice among pillars, with an odometer that errs by metres; how many of the four times it came
/// there, and the run.
fn to_and_fro(seed: u64, more: &str) -> (usize, Run) {
    let (_, robot) = HALL.split_once("[[robots]]").expect("a robot");
    let robot = robot.replace("sigma_m = 0.0001", "sigma_m = 0.001");
    let arena = Arena::pillars(&mut Chance::new(seed, "map"));
    let (start, goal) = ([0.7, 0.7], [6.3, 5.3]);
    let brain = format!(
        "[motor.go]\nkind = \"vfh\"\n[motor.go.parameters]\ngoals_m = [{goal:?}, {start:?}]\nagain = true\n{STEERING}\n\
         [cognitive.odometry]\nkind = \"odometry\"\nparameters = {{ variance_m2_per_m = 1e-3 }}\n{more}"
    );
    let mut local = described(arena.scenario_of(&robot, start, seed, ""), &brain);
    let reached =
        [goal, start, goal, start].iter().take_while(|goal| reaches(&mut local, **goal, 120)).count();
    (reached, of(&local))
}

/// The map that it makes keeps the robot where it believes to be, and what it avoids where it was seen.
#[test]
fn obstacles_are_passed_on_a_map_that_slam_makes() {
    for seed in 0..3 {
        let (alone, mapping) = (to_and_fro(seed, ""), to_and_fro(seed, "[cognitive.slam]\nkind = \"slam\""));
        println!("seed {seed}: odometry alone {alone:?}, with a map {mapping:?}");
        assert!(
            alone.0 < 4 && mapping.0 == 4 && mapping.1.collisions == 0,
            "seed {seed}: {alone:?}, {mapping:?}"
        );
    }
}

/// Crosses rooms with pillars, and touches none, by the sensors that this robot has.
fn pillars_are_passed(robot: &str, more: &str) {
    for seed in 0..3 {
        let arena = Arena::pillars(&mut Chance::new(seed, "cones"));
        let (start, goal) = ([0.7, 0.7], [6.3, 5.3]);
        let brain = format!(
            "[motor.go]\nkind = \"vfh\"\n[motor.go.parameters]\ngoals_m = [{goal:?}]\n{more}\n\
             [cognitive.odometry]\nkind = \"odometry\""
        );
        let mut local = described(arena.scenario_of(robot, start, seed, ""), &brain);
        let reached = reaches(&mut local, goal, 120);
        let run = of(&local);
        println!("seed {seed}: {run:?}");
        assert!(reached && run.collisions == 0, "seed {seed}: {run:?} {:?}", arena.pillars);
    }
}

#[test]
fn pillars_are_passed_by_what_sonars_hear() {
    let (_, robot) = HALL.split_once("[[robots]]").expect("a robot");
    let (before, rest) = robot.split_once("[robots.sensors.laser]").expect("a laser");
    let (_, after) = rest.split_once("[robots.firmware]").expect("firmware");
    let mut sonars = String::new();
    for i in 0..13 {
        // One after the other, as the microcontroller waits for each echo.
        let (bearing_rad, phase_ms) = (0.25 * (f64::from(i) - 6.0), 11.0 * f64::from(i));
        let _ = writeln!(
            sonars,
            "[robots.sensors.sonar{i}]\nkind = \"sonar\"\nbearing_rad = {bearing_rad:?}\nopening_rad = 0.25\nrays = 5\n\
             min_m = 0.03\nmax_m = 1.5\nperiod_ms = 150.0\nphase_ms = {phase_ms:?}"
        );
    }
    pillars_are_passed(
        &format!("{before}{sonars}[robots.firmware]{after}"),
        &format!("sight = {{ cone_rad = 0.25 }}\n{STEERING}"),
    );
}

#[test]
fn pillars_are_passed_by_what_infrared_sensors_see() {
    let (_, robot) = SWEEPER.split_once("[[robots]]").expect("a robot");
    let steering = "steering = { speed_m_s = 0.2, rotation_m_s = 0.1, full_speed_m_s = 0.5 }";
    pillars_are_passed(robot, &format!("sight = {{ ir = {{ c1_m2 = 0.03, c2 = 0.1 }} }}\n{steering}"));
}
