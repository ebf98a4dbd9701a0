//! The things that move around the robots, those that they push and run into, and the referee's counts.

use std::f64::consts::PI;

use baudbot_sim::{Ending, Outline, World};
use proptest::prelude::*;

use crate::common::statistics::{chi_squared, kolmogorov_smirnov, uniform};
use crate::common::{BODY, refusal, run, tick, world};
use crate::devices::scene::{block, named, near, scene, wall};

fn thing<'a>(world: &'a World, name: &str) -> baudbot_sim::ThingView<'a> {
    world.things().find(|thing| thing.name == name).unwrap()
}

/// The least distance of an outline from the robot's centre.
fn distance(world: &World, name: &str) -> f64 {
    let centre = world.robot(0).motion().pose.position;
    match thing(world, name).outline {
        Outline::Disc(disc) => (disc.center - centre).norm() - disc.radius,
        Outline::Polygon(points) => {
            let edges = points.iter().zip(points.iter().cycle().skip(1));
            edges
                .map(|(&start, &end)| baudbot_geometry::Segment { start, end }.distance_squared(centre))
                .fold(f64::MAX, f64::min)
                .sqrt()
        }
    }
}

const DOOR: &str = "[[arena.movers]]\nname = \"door\"\noutline_m = [[0.0, -0.02], [0.8, -0.02], [0.8, 0.02], [0.0, 0.02]]\n\
                    x_m = -0.5\ny_m = -0.5\nswing = { to_rad = 1.5, rate_rad_s = 1.0, pause_s = 0.5 }\n";

#[test]
fn a_door_waits_for_the_robot_in_its_way_and_goes_on_when_that_has_left() {
    let mut world = world(&scene(DOOR, "start = { heading_rad = 1.5707963 }", ""));
    let mut blocked = Vec::new();
    for _ in 0..300 {
        tick(&mut world, 0.0, 0.0);
        assert!(distance(&world, "door") >= 0.2 - 1e-9, "{}", distance(&world, "door"));
        blocked.push(thing(&world, "door").blocked_ns);
    }
    assert!(blocked.is_sorted() && blocked[299] > 1_500_000_000, "{}", blocked[299]);
    assert!((0.1..0.7).contains(&thing(&world, "door").pose.heading));
    assert_eq!(world.robot(0).counters().collisions, 0, "who stands does not run into anything");
    // The robot drives away, forwards, and the door opens.
    run(&mut world, 400, 0.6, 0.6);
    let mut open = 0.0;
    for _ in 0..400 {
        tick(&mut world, 0.0, 0.0);
        open = f64::max(open, thing(&world, "door").pose.heading);
    }
    near(open, 1.5);
}

#[test]
fn who_drives_into_a_door_has_collided_with_it() {
    let shut = DOOR
        .replace("x_m = -0.5", "x_m = 0.5")
        .replace("y_m = -0.5", "y_m = -0.4")
        .replace("heading_rad", "h");
    let standing = shut
        .replace("swing", "heading_rad = 1.5707963\nswing")
        .replace("to_rad = 1.5", "to_rad = 1.6")
        .replace("pause_s = 0.5", "pause_s = 1000.0");
    let mut world = world(&scene(&standing, "", ""));
    let mut partners = Vec::new();
    for _ in 0..200 {
        tick(&mut world, 0.5, 0.5);
        partners.extend(world.collisions().iter().map(|collision| collision.with.clone()));
        assert!(distance(&world, "door") >= 0.2 - 1e-9);
    }
    assert_eq!(partners, ["door"]);
    assert_eq!(world.robot(0).counters().collisions, 1);
}

#[test]
fn a_person_wanders_about_and_never_into_walls_or_robots() {
    let room = "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-2, -2], [2, -2], [2, 2], [-2, 2]]\n\
                [[arena.movers]]\nname = \"person\"\nradius_m = 0.25\nx_m = 1.0\ny_m = 1.0\nwander = { speed_m_s = 1.0, turn_s = 3.0 }\n";
    let mut world = world(&scene(room, "", ""));
    let mut quadrants = [false; 4];
    for i in 0..12_000 {
        tick(&mut world, if i % 300 < 150 { 0.3 } else { -0.3 }, 0.2);
        let at = thing(&world, "person").pose.position;
        assert!(at.x.abs() <= 1.75 + 1e-9 && at.y.abs() <= 1.75 + 1e-9, "{at}");
        assert!(distance(&world, "person") >= 0.2 - 1e-9, "tick {i}");
        quadrants[usize::from(at.x > 0.0) + 2 * usize::from(at.y > 0.0)] = true;
    }
    assert_eq!(quadrants, [true; 4]);
}

#[test]
fn a_person_turns_anywhere_and_goes_straight_on_for_half_its_time_to_all_of_it() {
    let mut world = world(
        "step_ms = 1.0\n[[arena.movers]]\nname = \"p\"\nradius_m = 0.3\nwander = { speed_m_s = 1.0, turn_s = 0.1 }",
    );
    let (mut headings, mut lasted, mut ticks) = (Vec::new(), [0; 50], 0);
    while headings.len() <= 5000 {
        world.begin();
        world.finish(&[]);
        let heading = thing(&world, "p").pose.heading;
        if headings.last() == Some(&heading) {
            ticks += 1;
            continue;
        }
        // Of the times that have ended: 51 to 100 ticks, each as likely as another.
        if !headings.is_empty() {
            lasted[ticks - 51] += 1;
        }
        headings.push(heading);
        ticks = 1;
    }
    let outcome = kolmogorov_smirnov(&mut headings, uniform(-PI, PI));
    assert!(outcome.fits(), "{outcome:?}");
    let outcome = chi_squared(&lasted, &[1.0; 50]);
    assert!(outcome.fits(), "{lasted:?}: {outcome:?}");
}

#[test]
fn a_fast_thing_does_not_jump_over_a_robot() {
    // 100 m/s are a metre a tick, more than the robot is wide.
    let train = "[[arena.movers]]\nname = \"train\"\nradius_m = 0.1\nstops = { points_m = [[-1.5, 0.0], [5.0, 0.0]], speed_m_s = 100.0, then = \"stay\" }\n";
    let mut world = world(&scene(train, "", ""));
    run(&mut world, 50, 0.0, 0.0);
    let x = thing(&world, "train").pose.position.x;
    assert!(x < 0.0, "the train is at {x}, behind the robot at 0");
}

const CRATE: &str = "[[arena.movables]]\nname = \"crate\"\nsize_m = [0.3, 0.3]\nx_m = 0.6\ny_m = 0.05\nmass_kg = 0.5\nfriction = 0.3\n";

#[test]
fn a_box_is_pushed_up_to_the_wall_and_not_into_it() {
    let mut world = world(&scene(&(wall(1.5) + CRATE), "", ""));
    for _ in 0..600 {
        tick(&mut world, 0.6, 0.6);
        let Outline::Polygon(corners) = thing(&world, "crate").outline else { panic!("a box") };
        assert!(corners.iter().all(|corner| corner.x <= 1.5 + 1e-9), "{corners:?}");
        assert!(distance(&world, "crate") >= 0.2 - 1e-9, "{}", distance(&world, "crate"));
    }
    assert!(thing(&world, "crate").pose.position.x > 1.2, "{:?}", thing(&world, "crate").pose);
}

#[test]
fn the_wheels_of_a_robot_that_pushes_roll_as_it_moves() {
    let mut world = world(&scene(&(wall(1.5) + CRATE), "", ""));
    let mut slowed = 0;
    for _ in 0..600 {
        let before = world.robot(0).motion().speed_m_s;
        tick(&mut world, 0.6, 0.6);
        let (robot, motion) = (world.robot(0), world.robot(0).motion());
        let drive = &robot.spec().drive;
        let turning = drive.half_track_m * motion.turn_rate_rad_s;
        near(motion.wheel_speed_rad_s.left, (motion.speed_m_s - turning) / drive.wheel_radius_m);
        near(motion.wheel_speed_rad_s.right, (motion.speed_m_s + turning) / drive.wheel_radius_m);
        slowed += usize::from(motion.speed_m_s < before);
    }
    assert!(slowed > 0, "the crate and the wall slow it down");
}

#[test]
fn a_robot_that_jams_something_light_against_a_wall_stands_still() {
    for (mass_kg, substeps) in [(0.05, 1), (0.005, 1), (0.001, 1), (0.001, 10), (1.0, 1)] {
        let top = format!(
            "substeps = {substeps}\n{}[[arena.movables]]\nname = \"box\"\nsize_m = [0.3, 0.2]\nx_m = 0.5\ny_m = 0.0\n\
             mass_kg = {mass_kg}\nfriction = 0.5\n",
            wall(2.0)
        );
        let mut world = world(&scene(&top, "", ""));
        run(&mut world, 1000, 0.5, 0.5);
        let robot = world.robot(0);
        assert!(robot.motion().speed_m_s.abs() < 0.01, "{mass_kg} kg: {:?}", robot.motion());
        let (driven, x) = (robot.counters().distance_m, robot.motion().pose.position.x);
        assert!((driven - x).abs() < 0.05, "{mass_kg} kg: {driven} m driven, {x} m made");
    }
}

#[test]
fn a_robot_cannot_start_in_what_can_be_pushed_or_moves() {
    let message = refusal(&scene(&CRATE.replace("x_m = 0.6", "x_m = 0.3"), "", ""));
    assert!(
        message.starts_with("robots[0].start: at (0, 0) a robot of radius 0.2 m stands in `crate`"),
        "{message}"
    );
    let message = refusal(&scene(&DOOR.replace("-0.5\ny_m = -0.5", "-0.1\ny_m = 0.0"), "", ""));
    assert!(message.contains("stands in `door`"), "{message}");
    let message = refusal(&scene(&(wall(0.7) + CRATE), "", ""));
    assert!(message.contains("arena.movables[0]: `crate` stands in `wall`"), "{message}");
}

/// A long robot beside a wall that only its corner can reach, turning.
fn turning(policy: &str) -> World {
    let body = "body = { outline_m = [[0.5, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.5, -0.1]], half_track_m = 0.1, mass_kg = 3.0, \
                inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }";
    let top = format!("collision = \"{policy}\"\n{}", block("shelf", [-1.0, 0.3, 1.0, 0.4], ""));
    let mut world = world(&scene(&top, "", "").replace(BODY, body));
    run(&mut world, 300, -0.3, 0.3);
    world
}

/// A collision geometry, as in Fig. 3.5.
#[test]
fn a_robot_with_corners_runs_into_walls_by_turning() {
    let stopped = turning("stop-robot");
    let motion = stopped.robot(0).motion();
    assert_eq!(stopped.robot(0).counters().collisions, 1);
    // A corner (0.5, 0.1) gets up to 0.3 where 0.5 sin φ + 0.1 cos φ = 0.3.
    let highest = 0.5 * motion.pose.heading.sin() + 0.1 * motion.pose.heading.cos();
    assert!((0.25..=0.3 + 1e-9).contains(&highest), "{highest} at {:?}", motion.pose);
    assert_eq!(
        turning("stop-run").ending().map(ToString::to_string).as_deref(),
        Some("`r` ran into `shelf`")
    );
}

#[test]
fn a_robot_with_corners_runs_into_another_by_turning() {
    let body = "body = { outline_m = [[0.5, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.5, -0.1]], half_track_m = 0.1, mass_kg = 3.0, \
                inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }";
    let other = scene("", "start = { x_m = 0.3, y_m = 0.5 }", "").replace("name = \"r\"", "name = \"z\"");
    let mut world = world(&(scene("", "", "").replace(BODY, body) + &other));
    for _ in 0..300 {
        crate::devices::scene::tick_of(&mut world, "r", &[-0.3, 0.3]);
    }
    assert_eq!((world.robot(0).counters().collisions, world.robot(1).counters().collisions), (1, 0));
    assert!(world.robot(0).motion().pose.heading < 1.0);
}

const ROOM: &str =
    "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-1, -1], [3, -1], [3, 1], [-1, 1]]\n";

/// Area coverage (§6.1).
#[test]
fn coverage_grows_with_the_way_and_ends_the_run() {
    let top = format!("{ROOM}[metrics]\ncell_m = 0.1\n[end]\ncovered = 0.15\n");
    let mut world = world(&scene(&top, "", ""));
    let covered = |world: &World| world.score().covered(&world.scenario().rules).unwrap();
    let mut last = covered(&world);
    // At most the disc and the strip that it sweeps, of 8 m².
    for _ in 0..800 {
        if world.ending().is_some() {
            break;
        }
        tick(&mut world, 0.5, 0.5);
        let x = world.robot(0).motion().pose.position.x;
        let now = covered(&world);
        let most = (PI * 0.3 * 0.3 + 0.6 * x) / 6.0;
        assert!(now >= last && now <= most, "{now} after {last}, {most}");
        last = now;
    }
    assert_eq!(world.ending(), Some(&Ending::Covered));
    assert!(last >= 0.15);
}

#[test]
fn the_rays_of_the_chosen_sensor_cover_the_floor_that_they_cross() {
    let laser = named(
        "eye",
        "kind = \"laser\"\nmount = {}\nopening_rad = 6.28\nrays = 200\nrange_m = 9.0\nbits = 8\nperiod_ms = 1000.0",
    );
    let top = format!(
        "{ROOM}{}[metrics]\ncell_m = 0.1\nsensed_by = \"eye\"\n[end]\nsensed = 0.7\n",
        block("screen", [1.0, -0.3, 1.1, 0.3], "")
    );
    let mut world = world(&scene(&top, "", &laser));
    let sensed = |world: &World| world.score().sensed(&world.scenario().rules).unwrap();
    assert_eq!(sensed(&world), 0.0);
    tick(&mut world, 0.0, 0.0);
    let first = sensed(&world);
    assert!((0.5..0.9).contains(&first), "all but the shadow of the screen: {first}");
    run(&mut world, 1000, 0.4, 0.6);
    assert!(sensed(&world) >= first);
}

#[test]
fn goals_are_zones_that_have_been_reached() {
    let goal = |name: &str, x: f64| {
        format!("[[arena.zones]]\nname = \"{name}\"\nx_m = {x:?}\ny_m = 0.0\nradius_m = 0.2\ngoal = true\n")
    };
    let other = "[[arena.zones]]\nname = \"no-goal\"\nx_m = 9.0\ny_m = 0.0\nradius_m = 0.2\n";
    let top = goal("near", 0.5) + &goal("far", 1.0) + other + "[end]\nall_goals = true\n";
    let mut world = world(&scene(&top, "", ""));
    let mut visits = Vec::new();
    for _ in 0..500 {
        tick(&mut world, 0.5, 0.5);
        visits.push(world.score().visited().to_vec());
    }
    assert_eq!(world.ending(), Some(&Ending::AllGoals));
    assert!(visits.contains(&vec![true, false, false]));
    assert_eq!(visits.last().unwrap(), &[true, true, false]);
    assert!((0.79..0.83).contains(&world.robot(0).motion().pose.position.x));
    let speed = 0.385;
    let seconds = world.score().in_zone_ns(0)[0] as f64 * 1e-9;
    assert!((seconds - 0.4 / speed).abs() < 0.2, "{seconds}");
}

#[test]
fn so_many_collisions_end_a_run() {
    let top = format!("{}[end]\ncollisions = 2\n", wall(0.4) + &block("back", [-0.5, -5.0, -0.4, 5.0], ""));
    let mut world = world(&scene(&top, "", ""));
    run(&mut world, 150, 0.5, 0.5);
    assert_eq!((world.robot(0).counters().collisions, world.ending()), (1, None));
    run(&mut world, 300, -0.5, -0.5);
    assert_eq!(world.ending(), Some(&Ending::Collisions(2)));
}

#[test]
fn a_robot_whose_axle_is_at_its_back_backs_into_a_wall_once() {
    let body = "body = { outline_m = [[0.5, 0.1], [-0.002, 0.1], [-0.002, -0.1], [0.5, -0.1]], half_track_m = 0.1, \
                mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }";
    let back = block("back", [-0.6, -1.0, -0.5, 1.0], "");
    let mut world = world(&format!(
        "collision = \"stop-robot\"\n{back}[[robots]]\nname = \"a\"\n{body}\nlink = {{ kind = \"ideal\" }}\n"
    ));
    run(&mut world, 500, -1.0, -1.0);
    assert!(world.robot(0).motion().pose.position.x < -0.47);
    assert_eq!(world.robot(0).counters().collisions, 1);
}

#[test]
fn a_robot_that_stands_in_a_zone_of_ice_does_not_start_to_slide() {
    let ice = "[[arena.zones]]\nname = \"ice\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 5.0\nslip = 1.0\n";
    let mut world = world(&scene(ice, "", ""));
    run(&mut world, 200, 0.5, 0.5);
    assert_eq!(world.robot(0).motion().pose.position.x, 0.0);
    assert!(world.robot(0).motion().travel_m.left > 0.1);
    assert_eq!(world.robot(0).counters().distance_m, 0.0);
}

#[test]
fn a_gyroscope_does_not_feel_wheels_that_spin_on_ice() {
    let ice = "[[arena.zones]]\nname = \"ice\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 5.0\nslip = 1.0\n";
    let gyroscope = "[robots.sensors.gyroscope]\nkind = \"gyroscope\"\nrange_rad_s = 10.0\n";
    let mut world = world(&format!(
        "{ice}[[robots]]\nname = \"a\"\n{}\nlink = {{ kind = \"ideal\" }}\n{gyroscope}",
        BODY
    ));
    run(&mut world, 100, -0.5, 0.5);
    assert!(world.robot(0).motion().turn_rate_rad_s > 0.1);
    assert_eq!(world.robot(0).readings()[0].values[..], [0.0]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_a_robot_does_among_doors_and_boxes_nothing_overlaps(signals in proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 12)) {
        let top = format!("{ROOM}{}{}", CRATE, DOOR.replace("x_m = -0.5", "x_m = 1.5").replace("pause_s = 0.5", "pause_s = 0.0"));
        let mut world = world(&scene(&top, "", ""));
        for (left, right) in signals {
            for _ in 0..40 {
                tick(&mut world, left, right);
                for name in ["door", "crate"] {
                    let gap = distance(&world, name) - 0.2;
                    prop_assert!(gap >= -1e-9, "{} overlaps by {}", name, gap);
                }
                let at = world.robot(0).motion().pose.position;
                prop_assert!(at.x >= -0.8 - 1e-9 && at.x <= 2.8 + 1e-9 && at.y.abs() <= 0.8 + 1e-9, "{}", at);
            }
        }
    }
}
