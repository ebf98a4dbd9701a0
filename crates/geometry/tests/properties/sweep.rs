//! A fan that is cast at once meets what its rays meet one by one, to the last bit.

use std::f64::consts::{PI, TAU};

use baudbot_geometry::{Bundle, Carried, Fan, Index, Pose, Ray, Sweep, Twist};
use proptest::prelude::*;

use crate::arenas;

/// Openings of a single beam up to a full turn, where the first ray and the last coincide.
fn opening() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..TAU, Just(TAU), Just(PI), Just(0.5 * PI), 0.0..0.1]
}

fn rays() -> impl Strategy<Value = usize> {
    prop_oneof![1..6_usize, 5..60_usize, 100..400_usize]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn as_one_by_one(
        arena in arenas::arena(),
        (near, aim) in (arenas::point(), arenas::aim()),
        away in prop_oneof![3 => Just(1.0), 1 => Just(30.0)],
        (opening_rad, rays) in (opening(), rays()),
        which in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
        // The ray that is aimed: through a corner, along a wall, past a rim.
        aimed in any::<prop::sample::Index>(),
        range in prop_oneof![0.0..8.0_f64, Just(f64::INFINITY), Just(0.5)],
    ) {
        let index = Index::new(arena.segments.clone(), arena.circles.clone());
        let fan = Fan::new(opening_rad, rays);
        let ray = arenas::ray(&arena, near * away, &aim);
        let heading = ray.direction.angle() - fan.kappas()[aimed.index(rays)];
        let pose = Pose::new(ray.origin.x, ray.origin.y, heading);
        let (a, b) = (which.0.index(rays + 1), which.1.index(rays + 1));
        let part = a.min(b)..a.max(b);
        let mut distances = vec![f64::NAN; part.len()];
        let mut sweep = Sweep::new(&pose, &fan, part.clone(), range, &mut distances);
        index.sweep(&mut sweep);
        sweep.finish();
        for (i, distance) in part.zip(distances) {
            let ray = Ray { origin: pose.position, direction: pose.direction().rotate(fan.relative()[i]) };
            let expected = index.cast(&ray, range).map_or(f64::INFINITY, |hit| hit.distance);
            prop_assert_eq!(distance.to_bits(), expected.to_bits(), "ray {}: {} not {}", i, distance, expected);
        }
    }

    #[test]
    fn of_something_else_as_well(
        disc in arenas::circle(),
        pose in (arenas::point(), -PI..PI),
        (opening_rad, rays) in (opening(), rays()),
        range in prop_oneof![0.0..8.0_f64, Just(f64::INFINITY)],
    ) {
        let fan = Fan::new(opening_rad, rays);
        let pose = Pose::new(pose.0.x, pose.0.y, pose.1);
        let mut distances = vec![0.0; rays];
        let mut sweep = Sweep::new(&pose, &fan, 0..rays, range, &mut distances);
        sweep.other(&disc, |ray| ray.hit_circle(&disc));
        sweep.finish();
        for (ray, distance) in fan.rays(pose.position, pose.direction()).zip(distances) {
            let expected = ray.hit_circle(&disc).filter(|&distance| distance <= range).unwrap_or(f64::INFINITY);
            prop_assert_eq!(distance.to_bits(), expected.to_bits());
        }
    }
}

/// Motions from standing to faster than robots go, straight on and in place.
fn motion() -> impl Strategy<Value = Twist> {
    let forward = prop_oneof![Just(0.0), -0.5..0.5_f64, -0.5..0.5_f64, -20.0..20.0_f64];
    let turn = prop_oneof![Just(0.0), -2.0..2.0_f64, -2.0..2.0_f64, -100.0..100.0_f64];
    (forward, turn).prop_map(|(forward, turn)| Twist { forward, turn })
}

/// Mounts and turrets, of which many look straight ahead.
fn frame() -> impl Strategy<Value = Pose> {
    let heading = prop_oneof![Just(0.0), Just(0.5 * PI), Just(PI), -PI..PI, -20.0..20.0_f64];
    (-0.3..0.3_f64, -0.3..0.3_f64, heading).prop_map(|(x, y, heading)| Pose::new(x, y, heading))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn each_ray_from_its_own_place(
        arena in arenas::arena(),
        (near, aim) in (arenas::point(), arenas::aim()),
        away in prop_oneof![3 => Just(1.0), 1 => Just(30.0)],
        (opening_rad, rays) in (opening(), rays()),
        which in (any::<prop::sample::Index>(), 1..=Bundle::MOST_RAYS),
        aimed in any::<prop::sample::Index>(),
        (body, sensor, turret) in (motion(), frame(), prop::option::of(frame())),
        // From the start of the sweep, and from one ray to the next, in seconds; a mirror may turn the other way.
        (from_s, step_s) in (0.0..0.1, prop_oneof![Just(1e-4), -1e-4..1e-4, -1e-2..1e-2]),
        range in prop_oneof![0.0..8.0_f64, Just(f64::INFINITY), Just(0.5)],
    ) {
        let index = Index::new(arena.segments.clone(), arena.circles.clone());
        let fan = Fan::new(opening_rad, rays);
        let first = which.0.index(rays);
        let part = first..(first + which.1).min(rays);
        let after_s: Vec<_> = (0..part.len()).map(|i| from_s + step_s * i as f64).collect();
        // A ray is aimed from where its sensor is when it is taken: the robot is moved there.
        let ray = arenas::ray(&arena, near * away, &aim);
        let aimed = aimed.index(part.len());
        let heading = ray.direction.angle() - fan.kappas()[first + aimed];
        let mut carried = Carried { robot: Pose::default(), body, turret, sensor };
        carried.robot.heading = baudbot_geometry::angle::wrap(heading - carried.place(after_s[aimed]).heading);
        carried.robot.position += ray.origin - carried.place(after_s[aimed]).position;
        let bundle = Bundle::new(&carried, &fan, part.clone(), &after_s);
        let mut distances = vec![f64::NAN; part.len()];
        let mut sweep = Sweep::of_bundle(&bundle, range, &mut distances);
        index.sweep(&mut sweep);
        // Movers are given to the sweep with the disc around them.
        let mover = arena.circles.first().map(|&circle| baudbot_geometry::Circle { center: [circle.center.y, circle.center.x].into(), ..circle });
        if let Some(mover) = mover {
            sweep.other(&mover, |ray| ray.hit_circle(&mover));
        }
        sweep.finish();
        for (place, (i, distance)) in part.zip(distances).enumerate() {
            let pose = carried.place(after_s[place]);
            let ray = Ray { origin: pose.position, direction: pose.direction().rotate(fan.relative()[i]) };
            prop_assert_eq!(bundle.ray(place), ray, "ray {}", i);
            let fixed = index.cast(&ray, range).map_or(f64::INFINITY, |hit| hit.distance);
            let moving = mover.and_then(|mover| ray.hit_circle(&mover)).filter(|&distance| distance <= range);
            let expected = moving.map_or(fixed, |moving| moving.min(fixed));
            prop_assert_eq!(distance.to_bits(), expected.to_bits(), "ray {}: {} not {}", i, distance, expected);
        }
    }
}

#[test]
fn in_a_large_arena_only_what_is_near_is_tried() {
    // A row of 10,000 short walls: the index's cells are used, and a wall in several of them is no trouble.
    let wall = |i: i32| {
        let x = f64::from(i);
        let (start, end) = ([x, 1.0], [x + 0.7, 1.5]);
        baudbot_geometry::Segment { start: start.into(), end: end.into() }
    };
    let index = Index::new((0..10_000).map(wall).collect(), vec![]);
    let (fan, pose) = (Fan::new(TAU, 500), Pose::new(5000.3, 0.4, 0.3));
    let mut distances = vec![0.0; 500];
    let mut sweep = Sweep::new(&pose, &fan, 0..500, 4.0, &mut distances);
    index.sweep(&mut sweep);
    sweep.finish();
    for (ray, distance) in fan.rays(pose.position, pose.direction()).zip(&distances) {
        assert_eq!(index.cast(&ray, 4.0).map_or(f64::INFINITY, |hit| hit.distance), *distance);
    }
    assert!(distances.iter().filter(|distance| distance.is_finite()).count() > 100);
}

#[test]
fn nonsense_meets_nothing() {
    let wall = baudbot_geometry::Segment { start: [1.0, -1.0].into(), end: [1.0, 1.0].into() };
    let index = Index::new(vec![wall], vec![]);
    let fan = Fan::new(1.0, 7);
    for (pose, range) in [
        (Pose::new(f64::NAN, 0.0, 0.0), 5.0),
        (Pose::new(0.0, 0.0, f64::NAN), 5.0),
        (Pose::new(0.0, 0.0, 0.0), f64::NAN),
    ] {
        let mut distances = [0.0; 7];
        let mut sweep = Sweep::new(&pose, &fan, 0..7, range, &mut distances);
        index.sweep(&mut sweep);
        sweep.finish();
        assert_eq!(distances, [f64::INFINITY; 7]);
    }
}
