//! The least clearance of a run, held against distances that are measured at every tick from points of outlines.

use baudbot_geometry::{Point, Segment, polygon};
use baudbot_sim::movable::Body;
use baudbot_sim::{Nearness, Outline, World};
use proptest::prelude::*;

use crate::common::{tick, world};

/// The outline of a body: segments, and the radius of a disc about a point.
fn outline(body: &Body) -> (Vec<Segment>, f64) {
    match body {
        Body::Disc(disc) => (vec![Segment { start: disc.center, end: disc.center }], disc.radius),
        Body::Polygon(points) => (polygon::edges(points).collect(), 0.0),
    }
}

/// The distance between two outlines, by many points of one.
fn distance_m(a: &(Vec<Segment>, f64), b: &(Vec<Segment>, f64)) -> f64 {
    let points = |edges: &[Segment]| -> Vec<Point> {
        let along = |edge: &Segment, k: u32| edge.start + (edge.end - edge.start) * (f64::from(k) / 64.0);
        edges.iter().flat_map(|edge| (0..=64).map(move |k| along(edge, k))).collect()
    };
    let one_way = |from: &[Segment], to: &[Segment]| {
        let distances =
            points(from).into_iter().flat_map(|point| to.iter().map(move |edge| edge.distance(point)));
        distances.fold(f64::INFINITY, f64::min)
    };
    (one_way(&a.0, &b.0).min(one_way(&b.0, &a.0)) - a.1 - b.1).max(0.0)
}

/// The clearance of a robot of a world in which nothing is inside of anything.
fn clearance_m(world: &World, robot: usize) -> f64 {
    let view = world.robot(robot);
    if view.collided() {
        return 0.0;
    }
    let body = |i: usize| world.robot(i).spec().form().at(&world.robot(i).motion().pose);
    let own = outline(&body(robot));
    let mut others: Vec<_> =
        (0..world.robots().len()).filter(|i| *i != robot).map(|i| outline(&body(i))).collect();
    others.extend(world.things().map(|thing| match thing.outline {
        Outline::Disc(disc) => outline(&Body::Disc(disc)),
        Outline::Polygon(points) => outline(&Body::Polygon(points)),
    }));
    let arena = &world.scenario().arena;
    others.extend(arena.polygons().iter().map(|polygon| (polygon.edges().collect(), 0.0)));
    others.extend(arena.pillars().iter().map(|pillar| outline(&Body::Disc(pillar.circle))));
    others.iter().map(|other| distance_m(&own, other)).fold(f64::INFINITY, f64::min)
}

/// A room with a solid box, a pillar, a person, a ball and two robots, one of them with corners, or without all that moves but the
/// first robot.
fn room(heading_rad: f64, size_m: f64, is_alone: bool) -> World {
    let room = format!(
        r#"
        wall_friction = 0.3
        [[arena.polygons]]
        name = "room"
        solid = false
        points_m = [[-1.5, -1.5], [1.5, -1.5], [1.5, 1.5], [-1.5, 1.5]]
        [[arena.polygons]]
        name = "box"
        points_m = [[-1.4, 0.8], [-0.8, 0.8], [-0.8, {}]]
        [[arena.circles]]
        name = "pillar"
        x_m = 0.9
        y_m = -0.8
        radius_m = 0.2
        [[robots]]
        name = "a"
        body = {{ radius_m = 0.15, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}
        start = {{ heading_rad = {heading_rad} }}
        "#,
        0.9 + size_m
    );
    world(&if is_alone { room } else { room + OTHERS })
}

const OTHERS: &str = r#"
        [[arena.movers]]
        name = "person"
        radius_m = 0.15
        stops = { points_m = [[1.2, 1.2], [-0.5, 1.1]], speed_m_s = 0.6 }
        [[arena.movables]]
        name = "ball"
        radius_m = 0.1
        mass_kg = 0.2
        friction = 0.02
        x_m = 0.5
        y_m = 0.1
        [[robots]]
        name = "b"
        body = { outline_m = [[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.1, -0.1]], half_track_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
        start = { x_m = -0.8, y_m = -0.8, heading_rad = 0.7 }
        "#;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Robots that drive anywhere, touch things and push them.
    #[test]
    fn the_least_clearance_is_that_of_all_ticks(
        heading_rad in -3.1..3.1, size_m in 0.05..0.5, is_alone in any::<bool>(),
        signals in prop::collection::vec((-1.0..1.0, -1.0..1.0, 10_u64..60), 1..8),
    ) {
        let mut world = room(heading_rad, size_m, is_alone);
        let mut nearness = Nearness::new(&world);
        let mut expected = vec![f64::INFINITY; world.robots().len()];
        for (left, right, ticks) in signals {
            for _ in 0..ticks {
                for (robot, least_m) in expected.iter_mut().enumerate() {
                    let (told_m, found_m) = (world.clearance_m(robot), clearance_m(&world, robot));
                    prop_assert!((told_m - found_m).abs() < 0.002, "{told_m} {found_m}");
                    *least_m = least_m.min(told_m);
                }
                tick(&mut world, left, right);
                nearness.see(&world);
            }
        }
        for (robot, least_m) in expected.iter_mut().enumerate() {
            *least_m = least_m.min(world.clearance_m(robot));
        }
        for (robot, least) in nearness.least().enumerate() {
            prop_assert!((least.clearance_m - expected[robot]).abs() < 1e-9, "{least:?} {expected:?}");
        }
    }
}

/// A square robot that turns beside a wall sweeps its corners past it, and one that runs into the wall has no clearance.
#[test]
fn a_corner_comes_nearer_by_turning_and_a_collision_is_no_clearance() {
    let wall = "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[0.5, -9], [0.6, -9], [0.6, 9], [0.5, 9]]\n";
    let robot = "collision = \"stop-robot\"\n[[robots]]\nname = \"a\"\nbody = { outline_m = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]], \
                 half_track_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
    let mut turning = world(&format!("{robot}{wall}"));
    let mut nearness = Nearness::new(&turning);
    assert!((turning.clearance_m(0) - 0.3).abs() < 1e-12, "{}", turning.clearance_m(0));
    for _ in 0..800 {
        tick(&mut turning, -0.3, 0.3);
        nearness.see(&turning);
    }
    let corner_m = 0.5 - 0.2 * 2.0_f64.sqrt();
    let least = nearness.least().next().unwrap();
    assert!((least.clearance_m - corner_m).abs() < 1e-4 && least.at.as_ns() > 0, "{least:?}, not {corner_m}");
    let mut driving = world(&format!("{robot}{wall}"));
    let mut nearness = Nearness::new(&driving);
    for _ in 0..2000 {
        tick(&mut driving, 1.0, 1.0);
        nearness.see(&driving);
    }
    assert!(driving.robot(0).counters().collisions > 0);
    assert_eq!(nearness.least().next().unwrap().clearance_m, 0.0);
}
