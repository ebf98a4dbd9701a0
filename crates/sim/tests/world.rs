//! The promises of a world: the same bits for the same run, and bodies that stay out of walls.

use std::fmt::Write;

use crate::common::{ARSIM, BODY, WANDER, run, tick, world, world_with};
use baudbot_sim::{Ending, SimTime, World};
use proptest::prelude::*;

/// Robots on a grid, each with two noisy IR sensors and encoders.
fn crowd(names: &[&str]) -> String {
    let mut toml = String::from(
        "step_ms = 10.0\nsubsteps = 2\n[[arena.polygons]]\nname = \"border\"\nsolid = false\npoints_m = [[-3, -3], [9, -3], [9, 3], [-3, 3]]\n",
    );
    for name in names {
        // The place depends on the name alone, so that the order in the file does not matter.
        let i = f64::from(name.as_bytes()[0] - b'a');
        write!(
            toml,
            "[[robots]]\nname = \"{name}\"\nstart = {{ x_m = {}, heading_rad = {} }}\n{BODY}\n\
             link = {{ kind = \"uart\", baud = 9600, byte_error_rate = 0.01 }}\n",
            i * 0.9 - 2.0,
            i * 0.7
        )
        .unwrap();
        for (side, bearing) in [("left", 0.8), ("right", -0.8)] {
            write!(toml, "[robots.sensors.{side}]\nkind = \"ir\"\nbearing_rad = {bearing}\nrays = 3\nopening_rad = 0.5\nrange_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1\nsigma = 0.05\nbits = 8\n").unwrap();
        }
        toml += "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 600\nbits = 16\n";
    }
    toml
}

#[test]
fn the_order_of_robots_in_the_file_changes_nothing() {
    let hash = |names: &[&str]| {
        let mut world = world(&crowd(names));
        run(&mut world, 500, 0.6, 0.5);
        world.hash()
    };
    let sorted = hash(&["a", "b", "c", "d", "e"]);
    assert_eq!(sorted, hash(&["e", "b", "d", "a", "c"]));
    assert_ne!(sorted, hash(&["a", "b", "c", "d", "f"]));
}

#[test]
fn a_robot_out_of_reach_changes_no_other() {
    let trace = |names: &[&str]| {
        let mut world = world(&crowd(names));
        run(&mut world, 300, 0.3, -0.3);
        let robot = world.robots().find(|robot| robot.spec().name == "a").unwrap();
        (*robot.motion(), robot.readings().to_vec(), *robot.uplink())
    };
    assert_eq!(trace(&["a"]), trace(&["a", "k"]));
}

#[test]
fn a_snapshot_is_a_clone_with_the_same_hash_and_the_same_future() {
    let mut one = world(WANDER);
    run(&mut one, 123, 0.5, 0.4);
    let mut two = one.clone();
    assert_eq!(one.hash(), two.hash());
    run(&mut one, 200, 0.4, 0.5);
    run(&mut two, 200, 0.4, 0.5);
    assert_eq!(one.hash(), two.hash());
    run(&mut two, 1, 0.4, 0.5);
    assert_ne!(one.hash(), two.hash());
}

/// Without noise (3.1) is the reading itself.
#[test]
fn the_seed_matters_only_where_there_is_noise() {
    let hash = |overrides: &[&str]| {
        let mut world = world_with(WANDER, overrides);
        run(&mut world, 100, 0.5, 0.5);
        let robot = world.robot(0);
        (world.hash(), robot.sensors().map(|sensor| sensor.sample[0]).collect::<Vec<_>>())
    };
    assert_ne!(hash(&["seed=1"]).1, hash(&["seed=2"]).1);
    assert_eq!(hash(&["seed=1", "noise=false"]).1, hash(&["seed=2", "noise=false"]).1);
}

#[test]
fn begin_twice_is_begin_once_and_finish_needs_begin() {
    let mut world = world(ARSIM);
    let turns = world.begin().to_vec();
    let hash = world.hash();
    assert_eq!(world.begin(), turns);
    assert_eq!(world.hash(), hash);
    world.finish(&[]);
    assert_eq!(world.tick(), 1);
    world.finish(&[]);
    assert_eq!(world.tick(), 1);
}

#[test]
fn a_run_ends_after_its_time_and_stays_ended() {
    let mut world = world_with(ARSIM, &["end.after_s=0.5"]);
    run(&mut world, 60, 0.0, 0.0);
    assert_eq!(world.ending(), Some(&Ending::TimeIsOver));
    assert_eq!((world.tick(), world.time()), (50, SimTime::from_ns(500_000_000)));
    assert!(world.begin().is_empty());
}

#[test]
fn a_run_ends_at_its_goal() {
    let mut world = world_with(ARSIM, &["end.goal={ x_m = 0.5, y_m = 0.0, radius_m = 0.05 }"]);
    run(&mut world, 1000, 0.5, 0.5);
    assert_eq!(world.ending(), Some(&Ending::GoalReached("robot".into())));
    let x = world.robot(0).motion().pose.position.x;
    assert!((0.45..0.46).contains(&x), "{x}");
}

fn two_facing(policy: &str) -> World {
    let robot = |name: &str, x: f64, heading: f64| {
        format!("[[robots]]\nname = \"{name}\"\nstart = {{ x_m = {x}, heading_rad = {heading} }}\n{BODY}\n")
    };
    world(&format!(
        "collision = \"{policy}\"\n{}{}",
        robot("a", 0.0, 0.0),
        robot("b", 1.0, core::f64::consts::PI)
    ))
}

#[test]
fn robots_that_run_into_each_other_end_the_run_or_stand_still() {
    let mut ended = two_facing("stop-run");
    run(&mut ended, 500, 0.5, 0.5);
    let ending = ended.ending().unwrap().to_string();
    assert_eq!(ending, "`a` ran into `b`");

    let mut stopped = two_facing("stop-robot");
    run(&mut stopped, 500, 0.5, 0.5);
    assert_eq!(stopped.ending(), None);
    let gap = stopped.robot(1).motion().pose.position.x - stopped.robot(0).motion().pose.position.x;
    assert!((0.4..0.41).contains(&gap), "{gap}");
    assert_eq!(stopped.robot(0).counters().collisions, 1, "a contact that lasts is one collision");
    assert!(stopped.robot(0).collided());
    // The robot can drive away again.
    run(&mut stopped, 100, -0.5, -0.5);
    assert!(!stopped.robot(0).collided());
    assert!(stopped.robot(0).motion().pose.position.x < 0.2);
}

/// Robots on the x axis, all heading along it, of which each gets its own signals.
fn drive_apart(world: &mut World, ticks: u64, signals: &[(f64, f64)]) {
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let bytes: Vec<_> = turns
            .iter()
            .map(|turn| {
                let (left, right) = signals[turn.robot];
                crate::common::command(world.robot(turn.robot).spec(), left, right)
            })
            .collect();
        let inputs: Vec<_> = turns
            .iter()
            .zip(&bytes)
            .map(|(turn, bytes)| baudbot_sim::Input { robot: turn.robot, at: turn.at, bytes })
            .collect();
        world.finish(&inputs);
    }
}

fn in_a_row(policy: &str, gap: f64) -> World {
    world(&format!(
        "collision = \"{policy}\"\n[[robots]]\nname = \"a\"\n{BODY}\n\
         [[robots]]\nname = \"b\"\nstart = {{ x_m = {gap} }}\n{BODY}\n"
    ))
}

#[test]
fn a_robot_that_is_pushed_from_behind_can_drive_away_and_has_not_collided() {
    let mut world = in_a_row("stop-robot", 0.5);
    drive_apart(&mut world, 200, &[(1.0, 1.0), (0.0, 0.0)]);
    assert_eq!((world.robot(0).counters().collisions, world.robot(1).counters().collisions), (1, 0));
    drive_apart(&mut world, 200, &[(1.0, 1.0), (0.5, 0.5)]);
    assert!(world.robot(1).motion().pose.position.x > 1.0, "it drives away");
    // The other way about in a run that ends: it is the moving robot that ran into the one that stood.
    let mut world = in_a_row("stop-run", 0.5);
    drive_apart(&mut world, 200, &[(0.0, 0.0), (-0.5, -0.5)]);
    assert_eq!(world.ending().unwrap().to_string(), "`b` ran into `a`");
}

#[test]
fn a_robot_at_a_wall_can_turn_and_drive_along_and_away() {
    let wall = "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[0.5, -9], [0.6, -9], [0.6, 9], [0.5, 9]]";
    let mut world = world(&format!("{wall}\n[[robots]]\nname = \"a\"\n{BODY}\n"));
    run(&mut world, 200, 0.5, 0.5);
    assert!(world.robot(0).motion().pose.position.x <= 0.3);
    // A curve to the left turns it on the spot until it faces along the wall, and then away from it.
    run(&mut world, 1000, 0.3, 0.5);
    assert!(world.robot(0).motion().pose.position.x < 0.2, "{:?}", world.robot(0).motion());
    assert_eq!(world.robot(0).counters().collisions, 1);
}

#[test]
fn a_new_partner_is_a_new_collision_even_in_a_narrow_place() {
    let corridor = "[[arena.polygons]]\nname = \"corridor\"\nsolid = false\npoints_m = [[-0.25, -0.21], [4, -0.21], [4, 0.21], [-0.25, 0.21]]\n";
    let robots = format!(
        "[[robots]]\nname = \"a\"\n{BODY}\n[[robots]]\nname = \"b\"\nstart = {{ x_m = 2.0 }}\n{BODY}\n"
    );
    let mut world = world(&format!("{corridor}{robots}"));
    drive_apart(&mut world, 200, &[(-0.5, -0.5), (0.0, 0.0)]);
    assert_eq!(world.robot(0).counters().collisions, 1);
    drive_apart(&mut world, 800, &[(0.5, 0.5), (0.0, 0.0)]);
    assert_eq!(world.robot(0).counters().collisions, 2);
    drive_apart(&mut world, 1, &[(-0.1, -0.1), (0.0, 0.0)]);
    drive_apart(&mut world, 50, &[(-0.1, -0.1), (0.0, 0.0)]);
    assert!(!world.robot(0).collided());
}

/// Of several hits on a ray the nearest counts (§3.2.3).
#[test]
fn other_robots_are_seen_and_the_own_body_is_not() {
    let sensor = "[robots.sensors.front]\nkind = \"ir\"\nbearing_rad = 0.0\nrays = 1\nopening_rad = 0.0\nrange_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1\n";
    let toml = format!(
        "[[robots]]\nname = \"a\"\n{BODY}\n{sensor}[[robots]]\nname = \"b\"\nstart = {{ x_m = 1.0 }}\n{BODY}\n"
    );
    let mut world = world(&toml);
    world.begin();
    // The distance from rim to rim is 0.6 m: 0.03/0.36 + 0.1.
    let sample = world.robot(0).sensors().next().unwrap().sample[0];
    assert!((sample - (0.03 / 0.36 + 0.1)).abs() < 1e-12, "{sample}");
}

/// (2.31) and (2.32) give the speeds at which V̇ and φ̈ are 0, and (2.1)–(2.3) those of the wheels.
#[test]
fn arsims_steady_speeds_and_spins_come_out() {
    for (signal, speed) in [(0.5, 0.3876), (1.0, 0.7851)] {
        let mut world = world_with(ARSIM, &["robots.robot.start.x_m=-1.5", "arena={}"]);
        run(&mut world, 200, signal, signal);
        let v = world.robot(0).motion().speed_m_s;
        assert!((v - speed).abs() < 1e-4, "{v} at {signal}");
    }
    // Half the track in the motors' eyes makes the spin faster; with the whole track it is (2.2)'s 2.40.
    for (overrides, rate) in [(&["noise=false"], 3.1413), (&["robots.robot.motors.track_factor=1.0"], 2.40)] {
        let mut world = world_with(ARSIM, overrides);
        run(&mut world, 400, -0.7, 0.7);
        let omega = world.robot(0).motion().turn_rate_rad_s;
        assert!((omega - rate).abs() < 5e-3, "{omega}");
    }
}

/// Encoders (§1.2.2).
#[test]
fn encoders_count_the_marks_that_passed_and_wrap_on_the_wire() {
    let encoders = "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 600\nbits = 8";
    let mut world = world(&format!("[[robots]]\nname = \"r\"\n{BODY}\n{encoders}\n"));
    let mut wrapped = false;
    for _ in 0..200 {
        tick(&mut world, -0.3, 0.5);
        world.begin();
        let robot = world.robot(0);
        let travel = robot.motion().travel_m;
        let counts = |way: f64| (way * 600.0 / (core::f64::consts::TAU * 0.1)).floor();
        let expected = [counts(travel.left), counts(travel.right)];
        assert_eq!(robot.sensors().next().unwrap().sample, expected);
        // The laptop's value is the same modulo 256, as a signed number.
        for (value, count) in robot.readings()[0].values.iter().zip(expected) {
            assert_eq!((value - count).rem_euclid(256.0), 0.0);
            assert!((-128.0..128.0).contains(value));
            wrapped |= *value != count;
        }
    }
    assert!(wrapped, "it drove more than 128 counts");
    assert!(world.robot(0).motion().travel_m.left < 0.0, "and backwards on the left");
}

/// A sun that goes round clockwise once in an hour takes the reading of a robot at rest once round the other way.
#[test]
fn a_compass_that_goes_by_the_sun_turns_against_it() {
    let rate = -core::f64::consts::TAU / 3600.0;
    let compass = format!("[robots.sensors.compass]\nkind = \"compass\"\nsun_rad_s = {rate}");
    let robot = format!("[[robots]]\nname = \"r\"\nstart = {{ heading_rad = 0.3 }}\n{BODY}\n{compass}\n");
    let mut world = world(&robot);
    for _ in 0..1000 {
        world.begin();
        let (seconds, heading) =
            (world.time().as_seconds(), world.robot(0).sensors().next().unwrap().sample[0]);
        assert!((heading - (0.3 - rate * seconds)).abs() < 1e-12, "{seconds}: {heading}");
        world.finish(&[]);
    }
}

#[test]
fn the_compass_has_normal_noise_of_its_sigma_and_wraps() {
    let compass = "[robots.sensors.compass]\nkind = \"compass\"\nsigma_rad = 0.05";
    let robot = |heading: f64| {
        format!("[[robots]]\nname = \"r\"\nstart = {{ heading_rad = {heading} }}\n{BODY}\n{compass}\n")
    };
    let samples = |heading: f64| {
        let mut world = world(&robot(heading));
        (0..4000)
            .map(|_| {
                world.begin();
                let sample = world.robot(0).sensors().next().unwrap().sample[0];
                world.finish(&[]);
                sample
            })
            .collect::<Vec<f64>>()
    };
    let errors: Vec<f64> = samples(0.3).iter().map(|heading| heading - 0.3).collect();
    let mean = errors.iter().sum::<f64>() / 4000.0;
    let deviation = (errors.iter().map(|error| error * error).sum::<f64>() / 4000.0).sqrt();
    assert!(mean.abs() < 0.003, "{mean}");
    assert!((deviation - 0.05).abs() < 0.002, "{deviation}");
    // Kolmogorov and Smirnov: the largest distance from the normal distribution, at the 0.1 % level.
    let mut sorted = errors;
    sorted.sort_by(f64::total_cmp);
    let distance = sorted
        .iter()
        .enumerate()
        .map(|(i, error)| (normal_cdf(error / 0.05) - i as f64 / 4000.0).abs())
        .fold(0.0, f64::max);
    assert!(distance < 1.95 / 4000.0_f64.sqrt(), "{distance}");
    let near_pi = samples(core::f64::consts::PI);
    assert!(near_pi.iter().all(|heading| heading.abs() <= core::f64::consts::PI));
    assert!(near_pi.iter().any(|heading| *heading < 0.0) && near_pi.iter().any(|heading| *heading > 0.0));
}

/// Integrated by Simpson's rule: there is no error function in the standard library.
fn normal_cdf(x: f64) -> f64 {
    let density = |t: f64| (-0.5 * t * t).exp() / core::f64::consts::TAU.sqrt();
    let n = 200;
    let h = x / f64::from(n);
    let inner: f64 = (1..n).map(|i| density(f64::from(i) * h) * if i % 2 == 0 { 2.0 } else { 4.0 }).sum();
    0.5 + h / 3.0 * (density(0.0) + density(x) + inner)
}

/// (2.7)–(2.9) add up the noise of their reads.
#[test]
fn odometer_noise_grows_as_the_square_root_of_the_steps() {
    // σ √(2n) / (2R): 0.0112 rad after 10 s at 1e-4 m.
    let mut squares = 0.0;
    for seed in 0..40 {
        let mut world = world_with(ARSIM, &[&format!("seed={seed}")]);
        run(&mut world, 1000, 0.0, 0.0);
        world.begin();
        let heading = world.robot(0).sensors().nth(2).unwrap().sample[2];
        squares += heading * heading;
    }
    let spread = (squares / 40.0_f64).sqrt();
    assert!((0.008..0.0145).contains(&spread), "{spread}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the signals, with the policy that stops robots no robot ever is in a wall or in another.
    #[test]
    fn robots_never_end_up_in_walls_or_in_each_other(signals in prop::collection::vec((-1.0..1.0, -1.0..1.0), 1..20)) {
        let mut world = world(&crowd(&["a", "b", "c", "d"]));
        for (left, right) in signals {
            for _ in 0..20 {
                tick(&mut world, left, right);
                let discs: Vec<_> = world.robots().map(|robot| (robot.motion().pose.position, robot.spec().drive.radius_m)).collect();
                for (i, (center, radius)) in discs.iter().enumerate() {
                    let disc = baudbot_geometry::Circle { center: *center, radius: *radius };
                    prop_assert_eq!(world.scenario().arena.obstacle_at(&disc), None);
                    for (other, other_radius) in &discs[..i] {
                        prop_assert!((other - center).norm() >= radius + other_radius - 1e-12);
                    }
                }
            }
        }
    }

    /// Any bytes at any time: nothing panics, and the run is the same again.
    #[test]
    fn arbitrary_bytes_do_no_harm_and_repeat(inputs in prop::collection::vec((0_u64..30_000_000, prop::collection::vec(any::<u8>(), 0..40)), 0..30)) {
        let play = || {
            let mut world = world(WANDER);
            for (late, bytes) in &inputs {
                world.begin();
                let at = world.time() + *late;
                world.finish(&[baudbot_sim::Input { robot: 0, at, bytes }, baudbot_sim::Input { robot: 9, at, bytes }]);
            }
            world.hash()
        };
        prop_assert_eq!(play(), play());
    }
}

#[test]
fn a_brain_has_a_message_from_its_last_byte_to_its_step() {
    let mut world = world(WANDER);
    let mut has_had = [false; 2];
    for _ in 0..20 {
        assert!(!world.has_message(0), "it was handed over");
        world.begin();
        let end = SimTime::from_ns(world.time().as_ns() + world.scenario().step_ns);
        let arrived = world.turns().iter().any(|turn| turn.robot == 0 && turn.at < end);
        assert_eq!(world.has_message(0), arrived);
        has_had[usize::from(arrived)] = true;
        world.finish(&[]);
    }
    assert_eq!(has_had, [true; 2]);
    assert!(!world.has_message(7), "there is no such robot");
}
