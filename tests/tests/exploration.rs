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
#[expect(dead_code, reason = "the time is printed")]
struct Explored {
    sensed: f64,
    distance_m: f64,
    seconds: f64,
    collisions: u64,
}

/// Lets the brain explore until all that the scenario wants is sensed, or its time is over.
fn explore(scenario: Scenario, brain: &str) -> Explored {
    let mut pair = Pair::new(scenario, brain).unwrap();
    pair.run(u64::MAX);
    let (robot, rules) = (pair.world.robot(0), pair.world.scenario().rules());
    Explored {
        sensed: pair.world.score().sensed(rules).unwrap(),
        distance_m: robot.counters().distance_m,
        seconds: pair.world.time().as_ns() as f64 * 1e-9,
        collisions: robot.counters().collisions,
    }
}

/// The scenario with the robot at another pose; `None` if it cannot stand there.
fn started(toml: &str, pose: [f64; 3]) -> Option<Scenario> {
    let names = ["x_m", "y_m", "heading_rad"];
    let set = |(name, value): (&str, &f64)| {
        Override::parse(&format!("robots.robot.start.{name}={value:?}")).expect("an override")
    };
    let changes: Vec<_> = names.into_iter().zip(&pose).map(set).collect();
    Scenario::parse_with(toml, &changes).ok()
}

/// So many poses at which the robot can stand, in a world of this size in metres.
fn starts(toml: &str, size_m: [f64; 2], count: usize) -> Vec<Scenario> {
    let mut chance = Chance::new(7, "starts");
    let mut any =
        || [chance.uniform() * size_m[0], chance.uniform() * size_m[1], chance.uniform() * 6.0 - 3.0];
    std::iter::repeat_with(|| started(toml, any())).flatten().take(count).collect()
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

/// By nodes one of the office's starts is allowed to fail: between table and wall, where they are a metre apart, no
/// angular interval is wide enough for a node, and the robot is done at once.
#[test]
#[ignore = "a minute in release; the same with one start always"]
fn room_and_office_are_explored_from_30_random_starts() {
    for (toml, size_m, brain, most_m, failures) in [
        (ROOM, [5.0, 4.0], NODES, 10.0, 0),
        (ROOM, [5.0, 4.0], FRONTIERS, 10.0, 0),
        (OFFICE, [12.0, 9.0], NODES, 120.0, 1),
        (OFFICE, [12.0, 9.0], FRONTIERS, 65.0, 0),
    ] {
        let runs: Vec<_> = starts(toml, size_m, 30).into_iter().map(|start| explore(start, brain)).collect();
        let mean = runs.iter().map(|run| run.distance_m).sum::<f64>() / runs.len() as f64;
        let most = runs.iter().map(|run| run.distance_m).fold(0.0, f64::max);
        let collisions: u64 = runs.iter().map(|run| run.collisions).sum();
        let failed: Vec<_> = runs.iter().filter(|run| run.sensed < 0.995).collect();
        println!("{brain}: mean {mean} m, most {most} m, {collisions} collisions, {} failed", failed.len());
        assert!(
            failed.len() <= failures && most <= most_m && collisions <= 2,
            "{brain}: {most} m, {failed:?}"
        );
    }
}
