//! Robots that touch something: they stand free, go on along it, or are held.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use baudbot_geometry::{Point, Segment};
use baudbot_sim::{Input, World};

use crate::common::{BODY, command, refusal, run, world, world_with};

const ROOM: &str =
    "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n";
const POLICIES: [&str; 3] = ["slide", "stop-robot", "stop-run"];

/// A robot whose wheels turn at the commanded speed, 0.4 m/s at most.
fn servo_robot(name: &str, start: &str) -> String {
    format!(
        "[[robots]]\nname = \"{name}\"\nbody = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.05 }}\n\
         motors = {{ kind = \"servo\", curve_us_rpm = [[1300, -76.39437268410976], [1500, 0], [1700, 76.39437268410976]], neutral_us = 1500, \
         half_range_us = 200, dead_band_us = 0, lag_ms = 0, frame_ms = 0 }}\nlink = {{ kind = \"ideal\" }}\nstart = {{ {start} }}\n"
    )
}

fn at(world: &World, i: usize) -> Point {
    world.robot(i).motion().pose.position
}

/// 1.0 − 0.8 is less than 0.2 in binary numbers.
#[test]
fn who_touches_a_wall_by_rounding_stands_free_and_can_drive_away() {
    let square = "body = { outline_m = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]], half_track_m = 0.2, mass_kg = 3.0, \
                  inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }";
    for policy in POLICIES {
        for body in [BODY, square] {
            let robot = format!("[[robots]]\nname = \"a\"\n{body}\nstart = {{ x_m = 0.8, y_m = -0.8 }}\n");
            let mut world = world(&format!("collision = \"{policy}\"\n{ROOM}{robot}"));
            run(&mut world, 50, 0.0, 0.0);
            assert_eq!((world.ending(), at(&world, 0)), (None, Point::new(0.8, -0.8)), "{policy} {body}");
            run(&mut world, 100, -0.5, -0.5);
            assert_eq!((world.ending(), world.robot(0).counters().collisions), (None, 0), "{policy} {body}");
            assert!(at(&world, 0).x < 0.7, "{policy} {body}: {:?}", at(&world, 0));
        }
    }
}

/// A wall along the y axis at x = 0.5, touched at an angle, both ways and both sides, forwards and backwards.
#[test]
fn a_robot_goes_on_along_a_wall_at_its_tangential_speed_less_friction() {
    let wall =
        "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[0.5, -90], [0.6, -90], [0.6, 90], [0.5, 90]]\n";
    for (degrees, friction) in
        [(3.0, "0.3"), (17.0, "0.3"), (45.0, "0.3"), (45.0, "0.0"), (80.0, "0.0"), (60.0, "0.5")]
    {
        for (side, signal) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)] {
            let angle = f64::to_radians(degrees);
            let heading = side * (FRAC_PI_2 - angle) + if signal < 0.0 { std::f64::consts::PI } else { 0.0 };
            let robot = servo_robot("a", &format!("x_m = 0.39, heading_rad = {heading}"));
            let mut world = world(&format!("wall_friction = {friction}\nsubsteps = 5\n{wall}{robot}"));
            run(&mut world, 100, signal, signal);
            let before = at(&world, 0);
            run(&mut world, 100, signal, signal);
            let way = at(&world, 0) - before;
            let k = angle.cos() - friction.parse::<f64>().unwrap() * angle.sin();
            assert!(
                (way.y - side * 0.4 * k).abs() < 1e-6 && way.x.abs() < 1e-9,
                "{degrees} {friction}: {way:?}"
            );
            let gap = 0.4 - at(&world, 0).x;
            assert!((0.0..1e-9).contains(&gap), "{gap}");
            let motion = world.robot(0).motion();
            assert!((motion.speed_m_s - signal * 0.4 * k).abs() < 1e-6, "{}", motion.speed_m_s);
            assert_eq!(world.robot(0).counters().collisions, 1, "a contact that lasts is one collision");
            assert_eq!(world.robot(0).stood_in_contact_ns(), 0);
            // The robot drives away.
            run(&mut world, 50, -signal, -signal);
            assert!(at(&world, 0).x < 0.395, "{degrees} {friction}");
        }
    }
}

/// Beyond the cone of friction, in a corner, with infinite friction: it stands, and the summary knows for how long.
#[test]
fn what_friction_or_a_corner_holds_stands() {
    let held = |more: &str, start: &str| {
        let mut world = world(&format!("{more}\n{ROOM}{}", servo_robot("a", start)));
        run(&mut world, 200, 1.0, 1.0);
        let before = at(&world, 0);
        run(&mut world, 200, 1.0, 1.0);
        assert_eq!(at(&world, 0), before, "{more} {start}");
        assert_eq!(world.robot(0).motion().speed_m_s, 0.0, "{more} {start}");
        let stood_s = world.robot(0).stood_in_contact_ns() as f64 / 1e9;
        assert!((2.0..=4.0).contains(&stood_s), "{stood_s}");
    };
    held("", "x_m = 0.89, heading_rad = 0.1");
    held("", "x_m = 0.89, y_m = -0.89, heading_rad = -0.6");
    held("wall_friction = 0", "x_m = 0.85, y_m = 0.87, heading_rad = 0.8");
    held("wall_friction = inf", "x_m = 0.85, heading_rad = 1.5");
    // Along a wall into the corner.
    held("wall_friction = 0", "x_m = 0.85, y_m = 0.3, heading_rad = 1.4");
}

#[test]
fn infinite_friction_is_to_stop_bit_by_bit() {
    let robots: String = (0..4)
        .map(|i| {
            let start = format!(
                "x_m = {}, y_m = 0.1, heading_rad = {}",
                f64::from(i) * 0.4 - 0.6,
                f64::from(i) * 1.3
            );
            servo_robot(&format!("r{i}"), &start)
        })
        .collect();
    let toml = format!("{ROOM}{robots}");
    let mut worlds =
        [world_with(&toml, &["collision=stop-robot"]), world_with(&toml, &["wall_friction=inf"])];
    for i in 0..300 {
        let turn = f64::from(i % 37) / 40.0;
        for world in &mut worlds {
            run(world, 1, 1.0, turn);
        }
        for robot in 0..4 {
            assert_eq!(worlds[0].robot(robot).motion(), worlds[1].robot(robot).motion(), "{robot}, tick {i}");
        }
    }
    assert!(worlds[0].robots().any(|robot| robot.counters().collisions > 0));
}

#[test]
fn friction_is_of_robots_that_slide_and_not_negative() {
    assert_eq!(refusal("wall_friction = -0.1"), "wall_friction: must not be negative, is -0.1");
    assert!(refusal("wall_friction = nan").starts_with("wall_friction: must not be negative"));
    let message = refusal("collision = \"stop-run\"\nwall_friction = 0.1");
    assert!(message.starts_with("wall_friction: only robots that slide have it"), "{message}");
}

/// A door that stands open, a robot that stands, and a thing that it pushes along a wall.
#[test]
fn robots_slide_along_movers_and_robots_as_along_walls() {
    let person = "[[arena.movers]]\nname = \"m\"\nradius_m = 0.3\nstops = { points_m = [[0.4, 0.2], [0.4, 0.2001]], speed_m_s = 0.1 }\n";
    let other = servo_robot("b", "x_m = 0.3, y_m = 0.1");
    for (toml, name) in [(person.to_owned(), "mover"), (other, "robot")] {
        let mut world =
            world(&format!("wall_friction = 0.2\nsubsteps = 4\n{toml}{}", servo_robot("a", "x_m = -0.2")));
        for _ in 0..400 {
            let turns = world.begin().to_vec();
            let bytes: Vec<_> = turns
                .iter()
                .map(|turn| {
                    let signal = if turn.robot == 0 { 1.0 } else { 0.0 };
                    command(world.robot(turn.robot).spec(), signal, signal)
                })
                .collect();
            let inputs: Vec<_> = turns
                .iter()
                .zip(&bytes)
                .map(|(turn, bytes)| Input { robot: turn.robot, at: turn.at, bytes })
                .collect();
            world.finish(&inputs);
        }
        assert!(at(&world, 0).x > 0.5, "{name}: past it, {:?}", at(&world, 0));
        assert_eq!(world.robot(0).counters().collisions, 1, "{name}");
    }
}

/// Small numbers from a seed.
struct Dice(u64);

impl Dice {
    fn within(&mut self, min: f64, max: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        min + (max - min) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Walls in all directions: a room, slanted blocks, a wedge, pillars; and round robots of all motors.
fn crowded(seed: u64) -> World {
    let dice = &mut Dice(seed);
    let friction = [0.0, 0.1, 0.3, 1.0][(seed % 4) as usize];
    let mut toml = format!(
        "seed = {seed}\nwall_friction = {friction:?}\nsubsteps = {}\n{ROOM}",
        [1, 2, 10][(seed / 4 % 3) as usize]
    );
    for i in 0..3 {
        let (x, y, turn) = (dice.within(-0.7, 0.7), dice.within(-0.7, 0.7), dice.within(0.0, 6.3));
        let corners: Vec<String> = [(0.0, 0.0), (0.3, 0.05), (0.25, 0.2)]
            .iter()
            .map(|(u, v)| {
                format!("[{}, {}]", x + u * turn.cos() - v * turn.sin(), y + u * turn.sin() + v * turn.cos())
            })
            .collect();
        let _ = write!(toml, "[[arena.polygons]]\nname = \"w{i}\"\npoints_m = [{}]\n", corners.join(", "));
        let (x, y) = (dice.within(-0.9, 0.9), dice.within(-0.9, 0.9));
        let _ = write!(
            toml,
            "[[arena.circles]]\nname = \"c{i}\"\nx_m = {x}\ny_m = {y}\nradius_m = {}\n",
            dice.within(0.02, 0.2)
        );
    }
    for i in 0..9 {
        let motors = ["", "motors = { kind = \"servo\", lag_ms = 0 }\n"][i % 2];
        let robot = format!(
            "[[robots]]\nname = \"r{i}\"\nbody = {{ radius_m = {}, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.05 }}\n\
             {motors}link = {{ kind = \"ideal\" }}\nstart = {{ x_m = {}, y_m = {}, heading_rad = {} }}\n",
            dice.within(0.04, 0.12),
            dice.within(-0.95, 0.95),
            dice.within(-0.95, 0.95),
            dice.within(-3.0, 3.0)
        );
        let longer = toml.clone() + &robot;
        if baudbot_scenario::parse(&longer).is_ok() {
            toml = longer;
        }
    }
    world(&toml)
}

/// The greatest depth of the robots in something, by the distances of points from segments and centres alone.
fn deepest_m(world: &World) -> f64 {
    let arena = &world.scenario().arena;
    let discs: Vec<(Point, f64)> =
        world.robots().map(|robot| (robot.motion().pose.position, robot.spec().drive.radius_m)).collect();
    let mut deepest = f64::NEG_INFINITY;
    for (i, &(center, radius)) in discs.iter().enumerate() {
        let mut near = |distance: f64| deepest = f64::max(deepest, radius - distance);
        for polygon in arena.polygons() {
            polygon.edges().for_each(|edge: Segment| near(edge.distance(center)));
        }
        arena
            .pillars()
            .iter()
            .for_each(|pillar| near((center - pillar.circle.center).norm() - pillar.circle.radius));
        discs[..i].iter().for_each(|(other, its)| near((center - other).norm() - its));
        assert!(center.x.abs() < 1.0 && center.y.abs() < 1.0, "{center:?} is outside");
        let inside = arena
            .polygons()
            .iter()
            .any(|polygon| polygon.solid && baudbot_geometry::polygon::contains(&polygon.points, center));
        assert!(!inside, "{center:?} is in a block");
    }
    deepest
}

/// Runs worlds until so many robots have been in contact in a tick; the deepest that one was in something.
fn contacts(wanted: u64) -> f64 {
    let (mut seen, mut seed, mut deepest) = (0, 0, f64::NEG_INFINITY);
    while seen < wanted {
        seed += 1;
        let mut world = crowded(seed);
        let dice = &mut Dice(!seed);
        let (mut left, mut right) = (1.0, 1.0);
        for tick in 0..300 {
            if tick % 25 == 0 {
                (left, right) = (dice.within(-1.0, 1.0), dice.within(-1.0, 1.0));
            }
            run(&mut world, 1, left, right);
            seen += world.robots().filter(|robot| robot.collided()).count() as u64;
            deepest = deepest.max(deepest_m(&world));
            assert!(deepest <= 1e-9, "seed {seed}, tick {tick}: {deepest} m");
        }
    }
    deepest
}

#[test]
fn no_contact_is_deeper_than_a_nanometre() {
    contacts(10_000);
}

/// `cargo test --release -p baudbot-sim --test outside --all-features -- --ignored million_contacts --nocapture`
#[test]
#[ignore = "takes minutes: by the command above"]
fn a_million_contacts_are_not_deeper_than_a_nanometre() {
    println!("deepest: {} m", contacts(1_000_000));
}

/// Motors without current brake, and nothing else acts: no robot becomes faster over ground, by the way that it makes in a step.
#[test]
fn energy_never_grows_in_contact() {
    let mut slowed = 0;
    for seed in 0..400_u64 {
        let dice = &mut Dice(seed);
        let friction = [0.0, 0.1, 0.3, 1.0][(seed % 4) as usize];
        let shape = [
            "[[arena.circles]]\nname = \"c\"\nx_m = 0.6\ny_m = 0.0\nradius_m = 0.3\n",
            "[[arena.polygons]]\nname = \"w\"\npoints_m = [[0.3, -0.3], [0.35, -0.3], [0.35, 0.2], [0.3, 0.25]]\n",
            "[[arena.polygons]]\nname = \"v\"\nsolid = false\nclosed = false\npoints_m = [[0.2, -0.5], [0.4, 0.0], [0.3, 0.5]]\n",
        ][(seed / 4 % 3) as usize];
        let start = format!(
            "x_m = 0.0, y_m = {}, heading_rad = {}, speed_m_s = {}, turn_rate_rad_s = {}",
            dice.within(-0.3, 0.3),
            dice.within(-1.2, 1.2),
            dice.within(0.2, 2.0),
            dice.within(-2.0, 2.0)
        );
        let motors = "motors = { voltage_v = 1e-6, torque_constant_nm_a = 1e-6, emf_constant_v_s = 0.0, coulomb_friction_nm = 0.0, \
                      viscous_friction_nm_s = 0.0 }";
        let body = "body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.05 }";
        let mut world = world(&format!(
            "step_ms = 1.0\nwall_friction = {friction:?}\n{shape}[[robots]]\nname = \"a\"\n{body}\n{motors}\nlink = {{ kind = \"ideal\" }}\nstart = {{ {start} }}\n"
        ));
        let mut last = f64::INFINITY;
        for tick in 0..1000 {
            let before = at(&world, 0);
            run(&mut world, 1, 0.0, 0.0);
            let speed = (at(&world, 0) - before).norm() / 1e-3;
            assert!(speed <= last * (1.0 + 1e-9) + 1e-6, "seed {seed}, tick {tick}: {last} then {speed}");
            slowed += u64::from(speed < 0.999 * last && last.is_finite());
            last = speed;
        }
    }
    assert!(slowed > 100, "{slowed}");
}
