//! `explore` in `explore-room.toml` and `explore-office.toml`: a robot with a URG-04LX senses at least 99.5 % of the
//! floor, as the notes' does (§6.1).

use baudbot_brains::Chance;
use baudbot_sim::{Override, Scenario};
use baudbot_tests::Pair;

const ROOM: &str = include_str!("../../scenarios/explore-room.toml");
const OFFICE: &str = include_str!("../../scenarios/explore-office.toml");
const NODES: &str = "explore";
const FRONTIERS: &str = "explore:method=1";

/// How a run went.
#[derive(Debug)]
#[expect(dead_code, reason = "some are only printed")]
struct Explored {
    sensed: f64,
    distance_m: f64,
    seconds: f64,
    collisions: u64,
    /// How wrong the odometer is in the end, in metres.
    drift_m: f64,
}

/// An odometer like that of `tour.toml`, whose errors grow to metres in a tour of the office.
const ERRING: &str = "robots.robot.sensors.odometer.sigma_m=0.001";

/// Lets the brain explore until all that the scenario wants is sensed, or its time is over.
fn explore(scenario: Scenario, brain: &str) -> Explored {
    let mut pair = Pair::new(scenario, brain).unwrap();
    pair.run(u64::MAX);
    let (robot, rules) = (pair.world.robot(0), pair.world.scenario().rules());
    let at = robot.motion().pose.position;
    let odometer = robot.sensors().nth(1).expect("encoders, and then the odometer").sample;
    Explored {
        sensed: pair.world.score().sensed(rules).unwrap(),
        distance_m: robot.counters().distance_m,
        seconds: pair.world.time().as_ns() as f64 * 1e-9,
        collisions: robot.counters().collisions,
        drift_m: (at.x - odometer[0]).hypot(at.y - odometer[1]),
    }
}

/// The scenario with other changes, and the robot at another pose; `None` if it cannot stand there.
fn started(toml: &str, changes: &[&str], pose: [f64; 3]) -> Option<Scenario> {
    let names = ["x_m", "y_m", "heading_rad"];
    let set = |(name, value): (&str, &f64)| {
        Override::parse(&format!("robots.robot.start.{name}={value:?}")).expect("an override")
    };
    let changes = changes.iter().map(|text| Override::parse(text).expect("an override"));
    let changes: Vec<_> = names.into_iter().zip(&pose).map(set).chain(changes).collect();
    Scenario::parse_with(toml, &changes).ok()
}

/// So many poses at which the robot can stand, in a world of this size in metres.
fn starts(toml: &str, changes: &[&str], size_m: [f64; 2], count: usize) -> Vec<Scenario> {
    let mut chance = Chance::new(7, "starts");
    let mut any =
        || [chance.uniform() * size_m[0], chance.uniform() * size_m[1], chance.uniform() * 6.0 - 3.0];
    std::iter::repeat_with(|| started(toml, changes, any())).flatten().take(count).collect()
}

fn check(toml: &str, brain: &str, most_m: f64) {
    let explored = explore(Scenario::parse(toml).unwrap(), brain);
    println!("{brain}: {explored:?}");
    assert!(explored.sensed >= 0.995 && explored.distance_m <= most_m, "{brain}: {explored:?}");
    assert_eq!(explored.collisions, 0, "{brain}: {explored:?}");
}

#[test]
fn a_room_is_explored() {
    check(ROOM, NODES, 40.0);
    check(ROOM, FRONTIERS, 10.0);
}

#[test]
fn an_office_is_explored() {
    check(OFFICE, NODES, 120.0);
    check(OFFICE, FRONTIERS, 65.0);
}

#[test]
#[ignore = "a minute in release; the same with one start always"]
fn room_and_office_are_explored_from_30_random_starts() {
    for (toml, size_m, brain, most_m) in [
        (ROOM, [5.0, 4.0], NODES, 10.0),
        (ROOM, [5.0, 4.0], FRONTIERS, 10.0),
        (OFFICE, [12.0, 9.0], NODES, 120.0),
        (OFFICE, [12.0, 9.0], FRONTIERS, 65.0),
    ] {
        let runs: Vec<_> =
            starts(toml, &[], size_m, 30).into_iter().map(|start| explore(start, brain)).collect();
        let mean = runs.iter().map(|run| run.distance_m).sum::<f64>() / runs.len() as f64;
        let most = runs.iter().map(|run| run.distance_m).fold(0.0, f64::max);
        let collisions: u64 = runs.iter().map(|run| run.collisions).sum();
        let failed: Vec<_> = runs.iter().filter(|run| run.sensed < 0.995).collect();
        println!("{brain}: mean {mean} m, most {most} m, {collisions} collisions, {} failed", failed.len());
        assert!(failed.is_empty() && most <= most_m, "{brain}: {most} m, {failed:?}");
        assert_eq!(collisions, 0, "{brain}");
    }
}

/// With an odometer that errs the robot finds itself on the map that it makes. Says how many runs sensed less than 99 %.
fn fail_with_slam(toml: &str, size_m: [f64; 2], brain: &str, count: usize) -> usize {
    let starts = starts(toml, &[ERRING], size_m, count);
    let runs: Vec<_> = starts.into_iter().map(|start| explore(start, brain)).collect();
    let collisions: u64 = runs.iter().map(|run| run.collisions).sum();
    let drift_m = runs.iter().map(|run| run.drift_m).fold(0.0, f64::max);
    let failed: Vec<_> = runs.iter().filter(|run| run.sensed < 0.99).collect();
    println!("{brain}: {collisions} collisions, drift {drift_m} m at most, failed: {failed:?}");
    assert_eq!(collisions, 0, "{brain}");
    failed.len()
}

#[test]
fn an_odometer_that_errs_is_corrected_by_slam() {
    assert_eq!(fail_with_slam(ROOM, [5.0, 4.0], "explore:slam=1", 2), 0);
    assert_eq!(fail_with_slam(OFFICE, [12.0, 9.0], "explore:slam=1,method=1", 1), 0);
}

#[test]
#[ignore = "a minute in release; the same with 3 starts always"]
fn with_slam_room_and_office_are_explored_by_frontiers_from_30_random_starts() {
    assert_eq!(fail_with_slam(ROOM, [5.0, 4.0], "explore:slam=1,method=1", 30), 0);
    assert_eq!(fail_with_slam(OFFICE, [12.0, 9.0], "explore:slam=1,method=1", 30), 0);
}

/// Of the office's starts one is known to fail: it ends with 98.5 %, since nodes that could not be reached close a corner.
#[test]
#[ignore = "minutes in release; the same with 3 starts always"]
fn with_slam_room_and_office_are_explored_by_nodes_from_30_random_starts() {
    assert_eq!(fail_with_slam(ROOM, [5.0, 4.0], "explore:slam=1", 30), 0);
    assert!(fail_with_slam(OFFICE, [12.0, 9.0], "explore:slam=1", 30) <= 1);
}
