//! Brains that need a laser and odometry together, across cables on which odometry is older than the next scan. The laser has a
//! cable of its own.

use baudbot_tests::{InProcess, scenario};

const HALL: &str = include_str!("../../catalogue/scenarios/hall.toml");
const TOUR: &str = include_str!("../../catalogue/scenarios/tour.toml");
const ERRANDS: &str = include_str!("../../catalogue/scenarios/errands.toml");
const ROOM: &str = include_str!("../../catalogue/scenarios/explore-room.toml");

/// The course of a run.
#[derive(Debug)]
struct Run {
    seconds: f64,
    collisions: u64,
    distance_m: f64,
    sensed: f64,
    goals: usize,
}

/// Lets a brain drive, for 120 s at most if the scenario has neither goals nor anything to be sensed.
fn run(toml: &str, brain: &str, link: &str, others: &[&str]) -> Run {
    let link = format!("robots.robot.link={{ kind = \"uart\", {link} }}");
    let changes: Vec<_> = [link.as_str()].into_iter().chain(others.iter().copied()).collect();
    let mut local = InProcess::new(scenario(toml, &changes), brain).unwrap();
    local.world.keep_timeline(0);
    local.run(if toml == TOUR { 12_000 } else { u64::MAX });
    let (robot, score) = (local.world.robot(0), local.world.score());
    Run {
        seconds: local.world.time().as_ns() as f64 * 1e-9,
        collisions: robot.counters().collisions,
        distance_m: robot.counters().distance_m,
        sensed: score.sensed(&local.world.scenario().rules).unwrap_or_default(),
        goals: score.visited().iter().filter(|is_visited| **is_visited).count(),
    }
}

/// A cable of 4800 baud: the odometer is 0.2 s old and new every 0.1 s, and the laser has a scan every 0.1 s. One
/// message in 25 is damaged.
const SLOW: &str = "baud = 4800, byte_error_rate = 0.001";

#[test]
fn a_hall_is_crossed_past_what_a_laser_sees_at_4800_baud() {
    let run = run(HALL, "hall", SLOW, &[]);
    assert!(run.goals == 2 && run.collisions == 0 && run.seconds < 3.0 * 42.0, "{run:?}");
}

#[test]
fn a_room_is_explored_at_4800_baud() {
    let run = run(ROOM, "explore", SLOW, &[]);
    assert!(run.sensed >= 0.995 && run.collisions == 0 && run.seconds < 3.0 * 17.6, "{run:?}");
}

/// The robot turned when the cable was pulled, and soon stopped: its odometry then has the angle of its turn, and not
/// the time.
#[test]
fn a_cable_that_was_out_for_two_seconds_leaves_a_robot_where_it_believes_to_be() {
    let out = "baud = 4800, outages = [{ from_s = 31.0, for_s = 2.0 }]";
    let run = run(TOUR, "tour", out, &["robots.robot.motors.timeout_ms=500.0", "end.after_s=60.0"]);
    assert!(run.collisions == 0 && run.distance_m > 9.0, "{run:?}");
}

/// All brains, three seeds, with and without damaged bytes: the table of docs/reference/experiments.md.
#[test]
#[ignore = "96 runs; the sharpest ones always"]
fn slow_cables_cost_time_and_no_more() {
    for seed in 1..=3 {
        let seed = format!("seed={seed}");
        for (toml, brain) in [(HALL, "hall"), (TOUR, "tour"), (ERRANDS, "errands"), (ROOM, "explore")] {
            let fast = run(toml, brain, "baud = 115200", &[&seed]);
            for baud in [4800, 9600, 14_400, 115_200] {
                for rate in ["0.0", "0.001"] {
                    let link = format!("baud = {baud}, byte_error_rate = {rate}");
                    let run = run(toml, brain, &link, &[&seed]);
                    println!("{brain} {link} {seed}: {run:?}");
                    assert_eq!(
                        (run.collisions, run.goals),
                        (0, fast.goals),
                        "{brain} {link} {seed}: {run:?}"
                    );
                    assert!(run.seconds <= 3.0 * fast.seconds, "{brain} {link} {seed}: {run:?}");
                    assert!(
                        run.distance_m >= 0.7 * fast.distance_m || toml != TOUR,
                        "{link} {seed}: {run:?}"
                    );
                    assert!(run.sensed >= 0.995 || toml != ROOM, "{link} {seed}: {run:?}");
                }
            }
        }
    }
}

/// Runs with a motor that stops without commands, whenever the cable goes, until three seconds after.
#[test]
#[ignore = "84 runs; the sharpest one always"]
fn no_robot_with_a_timeout_collides_while_its_cable_is_out() {
    for from_s in [3.0, 7.3, 12.0, 17.7, 25.0, 31.0, 38.4] {
        for baud in [4800, 9600, 115_200] {
            for (toml, brain) in [(HALL, "hall"), (TOUR, "tour"), (ERRANDS, "errands"), (ROOM, "explore")] {
                let link = format!("baud = {baud}, outages = [{{ from_s = {from_s:?}, for_s = 2.0 }}]");
                let over = format!("end.after_s={:?}", from_s + 5.0);
                let run = run(toml, brain, &link, &["robots.robot.motors.timeout_ms=500.0", &over]);
                assert_eq!(run.collisions, 0, "{brain} {link}: {run:?}");
            }
        }
    }
}
