//! Behaviours that find their way, through cables: on planned ways, past what no map has, in rows over a floor, and home.
//!
//! In the arenas of the gallery, and in arenas drawn at random, where nothing was tuned.

use std::fmt::Write as _;

use baudbot_brains::Chance;
use baudbot_brains::description::Description;
use baudbot_brains::navigation::{Floor, Method};
use baudbot_brains::registry::Registry;
use baudbot_sim::Scenario;
use baudbot_tests::{Pair, body, scenario};

const ERRANDS: &str = include_str!("../../scenarios/errands.toml");
const HALL: &str = include_str!("../../scenarios/hall.toml");
const MOWER: &str = include_str!("../../scenarios/mower.toml");
const FORAGER: &str = include_str!("../../scenarios/forager.toml");
const SWEEPER: &str = include_str!("../../scenarios/sweeper.toml");

/// How a run went.
#[derive(Debug)]
#[expect(dead_code, reason = "the time is printed")]
struct Run {
    driven_m: f64,
    seconds: f64,
    collisions: u64,
    at_m: [f64; 2],
}

fn of(pair: &Pair) -> Run {
    let robot = pair.world.robot(0);
    let at = robot.motion().pose.position;
    Run {
        driven_m: robot.counters().distance_m,
        seconds: pair.world.time().as_ns() as f64 * 1e-9,
        collisions: robot.counters().collisions,
        at_m: [at.x, at.y],
    }
}

/// The scenario with a brain that a text describes.
fn described(scenario: Scenario, brain: &str) -> Pair {
    let description = Description::parse(brain).unwrap_or_else(|error| panic!("{error}\n{brain}"));
    let brain = description.brain(scenario.seed(), &body(&scenario.robots()[0]), &Registry::standard());
    Pair::with_brain(scenario, brain.unwrap_or_else(|error| panic!("{error}"))).unwrap()
}

/// Lets it drive until it is within 0.2 m of the goal, for so many seconds at most; says whether it got there.
fn reaches(pair: &mut Pair, goal: [f64; 2], seconds: u64) -> bool {
    (0..seconds * 100).any(|_| {
        pair.tick(|_| {});
        let [x, y] = of(pair).at_m;
        (x - goal[0]).hypot(y - goal[1]) < 0.2
    })
}

fn all_goals_are_reached(toml: &str, brain: &str, seeds: std::ops::RangeInclusive<u64>, most_m: f64) {
    for seed in seeds {
        let mut pair = Pair::new(scenario(toml, &[&format!("seed={seed}")]), brain).unwrap();
        pair.run(u64::MAX);
        let (run, ending) = (of(&pair), pair.world.ending().map(ToString::to_string).unwrap_or_default());
        println!("{brain}, seed {seed}: {run:?}");
        assert!(ending.contains("goals") && run.collisions == 0, "{brain}, seed {seed}: {ending} {run:?}");
        assert!(run.driven_m < most_m, "{brain}, seed {seed}: {run:?}");
    }
}

#[test]
fn errands_in_an_office_are_done_and_no_wall_is_touched() {
    all_goals_are_reached(ERRANDS, "errands", 1..=1, 48.0);
}

#[test]
fn a_hall_with_pillars_and_a_person_is_crossed() {
    all_goals_are_reached(HALL, "hall", 1..=2, 20.0);
}

#[test]
#[ignore = "half a minute in release; the same with one and two seeds always"]
fn with_thirty_seeds() {
    all_goals_are_reached(ERRANDS, "errands", 1..=30, 48.0);
    all_goals_are_reached(HALL, "hall", 1..=30, 25.0);
}

/// Walls `[x, y, x, y]`, pillars `[x, y, radius]`, and the size of the whole.
struct Arena {
    size_m: [f64; 2],
    walls: Vec<[f64; 4]>,
    pillars: Vec<[f64; 3]>,
}

impl Arena {
    fn new(size_m: [f64; 2]) -> Self {
        let [x, y] = size_m;
        let walls = vec![[0.0, 0.0, x, 0.0], [x, 0.0, x, y], [x, y, 0.0, y], [0.0, y, 0.0, 0.0]];
        Self { size_m, walls, pillars: Vec::new() }
    }

    /// A wall across at this x, with a door.
    fn divide(&mut self, x: f64, [from, to]: [f64; 2], chance: &mut Chance) {
        let width = 0.9 + 0.4 * chance.uniform();
        let door = from + 0.3 + (to - from - width - 0.6) * chance.uniform();
        self.walls.extend([[x, from, x, door], [x, door + width, x, to]]);
    }

    /// Three rooms, each with a table.
    fn office(chance: &mut Chance) -> Self {
        let mut arena = Self::new([9.0, 5.0]);
        for x in [3.0, 6.0] {
            arena.divide(x, [0.0, 5.0], chance);
        }
        for room in [0.0, 3.0, 6.0] {
            let (x, y) = (room + 0.8 + 0.6 * chance.uniform(), 0.9 + 2.4 * chance.uniform());
            let (u, v) = (x + 0.3 + 0.5 * chance.uniform(), y + 0.3 + 0.5 * chance.uniform());
            arena.walls.extend([[x, y, u, y], [u, y, u, v], [u, v, x, v], [x, v, x, y]]);
        }
        arena
    }

    /// A corridor that winds round four walls.
    fn corridor(chance: &mut Chance) -> Self {
        let mut arena = Self::new([7.5, 2.5]);
        for i in 0..4 {
            let (x, gap) = (1.5 * f64::from(i + 1), 0.8 + 0.5 * chance.uniform());
            arena.walls.push(if i % 2 == 0 { [x, 0.0, x, 2.5 - gap] } else { [x, gap, x, 2.5] });
        }
        arena
    }

    /// A room with pillars, each 1.3 m from the next, middle to middle.
    fn pillars(chance: &mut Chance) -> Self {
        let mut arena = Self::new([7.0, 6.0]);
        for _ in 0..200 {
            let [x, y] = [1.0 + 5.0 * chance.uniform(), 1.0 + 4.0 * chance.uniform()];
            let far = |u: f64, v: f64, least_m: f64| (x - u).hypot(y - v) > least_m;
            let is_free = far(0.7, 0.7, 0.9) && far(6.3, 5.3, 0.9) && far(5.5, 1.0, 0.7);
            if is_free && arena.pillars.len() < 8 && arena.pillars.iter().all(|&[u, v, _]| far(u, v, 1.3)) {
                arena.pillars.push([x, y, 0.1 + 0.15 * chance.uniform()]);
            }
        }
        arena
    }

    /// A straight corridor with pillars at its sides.
    fn aisle(chance: &mut Chance) -> Self {
        let mut arena = Self::new([9.0, 2.2]);
        for i in 0..4 {
            let side = if i % 2 == 0 { 0.3 } else { 1.9 };
            arena.pillars.push([2.0 + 1.5 * f64::from(i), side + 0.2 * chance.uniform() - 0.1, 0.25]);
        }
        arena
    }

    /// A place where a body has 0.35 m of room, and from which such a way leads to the others.
    fn place(&self, chance: &mut Chance, to: Option<[f64; 2]>) -> [f64; 2] {
        let floor = Floor::new(&self.walls, 0.05, 0.35, Method::ThetaStar).unwrap();
        loop {
            let [x, y] = self.size_m.map(|m| m * chance.uniform());
            let is_reached = |[u, v]: [f64; 2]| {
                let far = (x - u).hypot(y - v) > 0.4 * self.size_m[0];
                far && floor.way([x, y].into(), [u, v].into()).is_ok()
            };
            if floor.is_free([x, y].into()) && to.is_none_or(is_reached) {
                return [x, y];
            }
        }
    }

    /// The robot of the hall in this arena, with what else there is.
    fn scenario(&self, start: [f64; 2], seed: u64, more: &str) -> Scenario {
        let (_, robot) = HALL.split_once("[[robots]]").expect("a robot");
        // Of the way alone: what an odometer that errs makes of it, other tests tell.
        self.scenario_of(&robot.replace("sigma_m = 0.0001", "sigma_m = 0.0"), start, seed, more)
    }

    /// The same with another robot, whose start has a line of its own.
    fn scenario_of(&self, robot: &str, start: [f64; 2], seed: u64, more: &str) -> Scenario {
        let mut toml =
            format!("name = \"random\"\nstep_ms = 10.0\ncollision = \"stop-robot\"\nseed = {seed}\n");
        for (i, [x, y, u, v]) in self.walls.iter().enumerate() {
            let _ = writeln!(
                toml,
                "[[arena.polygons]]\nname = \"wall{i}\"\nsolid = false\nclosed = false\n\
                 points_m = [[{x:?}, {y:?}], [{u:?}, {v:?}]]"
            );
        }
        for (i, [x, y, radius]) in self.pillars.iter().enumerate() {
            let _ = writeln!(
                toml,
                "[[arena.circles]]\nname = \"pillar{i}\"\nx_m = {x:?}\ny_m = {y:?}\nradius_m = {radius:?}"
            );
        }
        let (before, rest) = robot.split_once("start = {").expect("a start");
        let (_, after) = rest.split_once('\n').expect("a line of its own");
        let place = format!("start = {{ x_m = {:?}, y_m = {:?} }}", start[0], start[1]);
        scenario(&format!("{toml}\n{more}\n[[robots]]\n{before}{place}\n{after}"), &[])
    }
}

const STEERING: &str = "steering = { speed_m_s = 0.4, rotation_m_s = 0.2, full_speed_m_s = 0.8 }";

fn planned_ways_hold(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let chance = &mut Chance::new(seed, "planned");
        let arena = if seed % 2 == 0 { Arena::office(chance) } else { Arena::corridor(chance) };
        let start = arena.place(chance, None);
        let goal = arena.place(chance, Some(start));
        let method = if seed % 4 < 2 { "theta_star" } else { "convex_cells" };
        let brain = format!(
            "[motor.follow]\nkind = \"follow_path\"\n[motor.follow.parameters]\nwalls_m = {:?}\ngoals_m = [{goal:?}]\n\
             method = \"{method}\"\n{STEERING}\n[cognitive.odometry]\nkind = \"odometry\"",
            arena.walls
        );
        let mut pair = described(arena.scenario(start, seed, ""), &brain);
        let reached = reaches(&mut pair, goal, 120);
        let run = of(&pair);
        assert!(
            reached && run.collisions == 0,
            "seed {seed}, {start:?} to {goal:?}: {run:?}\n{:?}",
            arena.walls
        );
    }
}

#[test]
fn planned_ways_through_random_offices_and_corridors_hold() {
    planned_ways_hold(0..6);
}

#[test]
#[ignore = "some minutes; the same with six arenas always"]
fn planned_ways_through_200_random_arenas_hold() {
    planned_ways_hold(0..200);
}

const PERSON: &str = "[[arena.movers]]\nname = \"person\"\nradius_m = 0.2\nx_m = 5.5\ny_m = 1.0\nheight_m = 1.7\n\
                      wander = { speed_m_s = 0.5, turn_s = 4.0 }";

/// How many were not done in time, and how many collided.
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
        let mut pair = described(arena.scenario(start, seed, person), &brain);
        let reached = reaches(&mut pair, goal, 120);
        let run = of(&pair);
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

/// Crosses rooms with pillars, and touches none, by the sensors that this robot has.
fn pillars_are_passed(robot: &str, more: &str) {
    for seed in 0..3 {
        let arena = Arena::pillars(&mut Chance::new(seed, "cones"));
        let (start, goal) = ([0.7, 0.7], [6.3, 5.3]);
        let brain = format!(
            "[motor.go]\nkind = \"vfh\"\n[motor.go.parameters]\ngoals_m = [{goal:?}]\n{more}\n\
             [cognitive.odometry]\nkind = \"odometry\""
        );
        let mut pair = described(arena.scenario_of(robot, start, seed, ""), &brain);
        let reached = reaches(&mut pair, goal, 120);
        let run = of(&pair);
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

/// The sweeper's room with a table, its walls, and a battery that lasts.
fn room_with_a_table() -> (Scenario, String) {
    let table =
        "[[arena.polygons]]\nname = \"table\"\npoints_m = [[0.2, -0.3], [1.0, -0.3], [1.0, 0.3], [0.2, 0.3]]";
    let lasting = ["robots.robot.battery.capacity_mah=6000.0", "robots.robot.start.heading_rad=0.0"];
    let scenario = scenario(&format!("{SWEEPER}\n{table}"), &lasting);
    let outlines: [&[[f64; 2]]; 2] = [
        &[[-2.0, -1.5], [2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]],
        &[[0.2, -0.3], [1.0, -0.3], [1.0, 0.3], [0.2, 0.3]],
    ];
    let edges = outlines.iter().flat_map(|points| {
        (0..points.len()).map(|i| {
            let (from, to) = (points[i], points[(i + 1) % points.len()]);
            [from[0], from[1], to[0], to[1]]
        })
    });
    (scenario, format!("{:?}", edges.collect::<Vec<_>>()))
}

fn covered(pair: &Pair) -> f64 {
    pair.world.score().covered(pair.world.scenario().rules()).expect("it is counted")
}

/// Runs for so many seconds, or until that share is covered, whichever is first; the share.
fn covers(pair: &mut Pair, share: f64, seconds: u64) -> f64 {
    for _ in 0..seconds {
        pair.run(100);
        if covered(pair) >= share || pair.world.ending().is_some() {
            break;
        }
    }
    covered(pair)
}

#[test]
fn rows_cover_a_room_with_a_table_on_a_third_of_the_way_of_random_sweeping() {
    let (scenario, walls) = room_with_a_table();
    let rows = format!(
        "[motor.mow]\nkind = \"cover_rows\"\nparameters = {{ walls_m = {walls}, clearance_m = 0.01, cell_m = 0.0125, row_m = 0.2 }}\n\
         [cognitive.odometry]\nkind = \"odometry\""
    );
    let mut rows = described(scenario.clone(), &rows);
    let share = covers(&mut rows, 0.95, 900);
    let in_rows = of(&rows);
    let mut at_random = Pair::new(scenario, "avoid").unwrap();
    let random_share = covers(&mut at_random, 0.95, 3600);
    let random = of(&at_random);
    println!("in rows {share} {in_rows:?}; at random {random_share} {random:?}");
    assert!(share >= 0.95 && in_rows.collisions == 0, "{share} {in_rows:?}");
    assert!(random.driven_m > 3.0 * in_rows.driven_m, "{random_share} {random:?}, {in_rows:?}");
}

#[test]
#[ignore = "half a minute in release; a room with a table always"]
fn rows_cover_an_office_with_a_laser_against_an_odometer_that_errs() {
    for seed in 1..=3 {
        let mut pair = Pair::new(scenario(MOWER, &[&format!("seed={seed}")]), "mower").unwrap();
        let share = covers(&mut pair, 1.0, 2000);
        let run = of(&pair);
        println!("seed {seed}: {share} {run:?}");
        assert!(share >= 0.95 && run.collisions == 0 && run.driven_m < 450.0, "{seed}: {share} {run:?}");
    }
}

#[test]
fn an_ant_comes_home_by_its_odometry_and_searches_where_that_errs() {
    let mut searched = 0;
    for seed in 1..=6 {
        let mut pair = Pair::new(scenario(FORAGER, &[&format!("seed={seed}")]), "forager").unwrap();
        pair.run(60_000);
        let run = of(&pair);
        let from_nest_m = run.at_m[0].hypot(run.at_m[1]);
        println!("seed {seed}: {run:?}");
        // The nose smells the nest from 0.25 m, and it takes some way to stop.
        assert!(from_nest_m < 0.35 && run.driven_m > 30.0, "seed {seed}: {run:?}");
        let odometer = pair.world.robot(0).sensors().nth(1).unwrap().sample;
        searched += u32::from(odometer[0].hypot(odometer[1]) > 0.35);
    }
    assert!(searched >= 1, "the odometry has led all of them straight to the nest");
}

/// Errors of path integration without a compass grow as n^1.5 σ / √3 in steps of 1 (§4.4.4; the sum is exact in
/// `animals::ant`). Here σ is what the noise of both wheels makes of the heading in a read, and a step is the way of a read.
#[test]
fn the_vector_home_errs_as_path_integration_without_a_compass_does() {
    let sigma_m = 0.0005;
    let squares = (1..=20).map(|seed| {
        let mut pair = Pair::new(scenario(FORAGER, &[&format!("seed={seed}")]), STRAIGHT_OUT).unwrap();
        pair.run(3000);
        let (run, odometer) = (of(&pair), pair.world.robot(0).sensors().nth(1).unwrap().sample);
        // The believed way is along x, so what is off to the side is in y.
        let aside_m = run.at_m[1] - odometer[1];
        (aside_m * aside_m, run.driven_m)
    });
    let runs: Vec<_> = squares.collect();
    let found_m = (runs.iter().map(|(square, _)| square).sum::<f64>() / 20.0).sqrt();
    let (reads, way_m) = (1500.0_f64, runs.iter().map(|(_, way_m)| way_m).sum::<f64>() / 20.0);
    let sigma_rad = sigma_m * 2.0_f64.sqrt() / (2.0 * 0.17);
    let expected_m = way_m / reads * sigma_rad * reads.powf(1.5) / 3.0_f64.sqrt();
    println!("{found_m} m aside after {way_m} m, {expected_m} m expected");
    // A standard error of twenty is 16 %.
    assert!((found_m / expected_m - 1.0).abs() < 0.5, "{found_m} {expected_m}");
}

const STRAIGHT_OUT: &str = "forager:motor.journey.parameters.meander_hz=0";
