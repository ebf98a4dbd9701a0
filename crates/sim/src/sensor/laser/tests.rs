//! A scan that is swept by a robot that drives on is, to the last bit, what its rays are that are cast one by one, each
//! from where the laser is at its instant.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use baudbot_geometry::{Circle, Point, Pose, Ray, angle, math};
use proptest::prelude::*;

use super::*;
use crate::actuator::ActuatorState;
use crate::arena::{Arena, Look, Pillar, Polygon};
use crate::drive::Drive;
use crate::motor::{MotorNoise, Motors, VelocityMotor};
use crate::scene::{Figure, Frozen, Scene};
use crate::surroundings::Surroundings;

/// The reading of one ray of a scan that started at `start`: by the routine for one ray.
fn one_ray(laser: &Laser, at: &Measurement<'_>, start: SimTime, i: usize) -> f64 {
    let gaps = (laser.rays() - 1).max(1) as u128;
    let instant = start + (u128::from(laser.sweep_ns) * i as u128 / gaps) as u64;
    let dt = instant.min(at.tick_end).since(at.tick_start) as f64 / SECOND_NS as f64;
    let body = at.over_ground();
    let mut robot = at.motion.pose;
    robot.heading = angle::wrap(robot.heading + body.turn * dt);
    let (sin, cos) = math::sin_cos(robot.heading);
    robot.position.x += body.forward * dt * cos;
    robot.position.y += body.forward * dt * sin;
    let pose = laser.mount.place(&robot, at.actuators);
    let place = if laser.clockwise { laser.rays() - 1 - i } else { i };
    let direction = pose.direction().rotate(laser.fan.relative()[place]);
    let viewpoint = laser.mount.look(at, &pose, laser.range_m);
    viewpoint.cast(&Ray { origin: pose.position, direction }).unwrap_or(NOTHING)
}

fn point() -> impl Strategy<Value = Point> {
    // Many on a grid, so that walls share corners and rays run along them.
    prop_oneof![
        (-4.0..4.0, -4.0..4.0).prop_map(|(x, y): (f64, f64)| Point::new(x, y)),
        (-8..=8_i32, -8..=8_i32).prop_map(|(x, y)| Point::new(f64::from(x) / 2.0, f64::from(y) / 2.0)),
    ]
}

/// Lower than the laser, as high, and higher.
fn look() -> impl Strategy<Value = Look> {
    prop_oneof![Just(f64::INFINITY), Just(0.1), Just(0.2), 0.0..0.4]
        .prop_map(|height_m| Look { height_m, ..Look::WALL })
}

fn arena() -> impl Strategy<Value = Arena> {
    let polygon = (prop::collection::vec(point(), 2..6), any::<bool>(), look());
    let pillar = (point(), 0.05..0.6, look());
    (prop::collection::vec(polygon, 0..12), prop::collection::vec(pillar, 0..6)).prop_map(
        |(polygons, pillars)| {
            let polygon = |(i, (points, closed, look)): (usize, (Vec<Point>, bool, Look))| Polygon {
                name: format!("polygon-{i}"),
                points,
                solid: false,
                closed,
                look,
            };
            let pillar = |(i, (center, radius, look)): (usize, (Point, f64, Look))| Pillar {
                name: format!("pillar-{i}"),
                circle: Circle { center, radius },
                look,
            };
            Arena::new(
                polygons.into_iter().enumerate().map(polygon).collect(),
                pillars.into_iter().enumerate().map(pillar).collect(),
            )
        },
    )
}

/// Robots and things that move: discs, and outlines in discs. The first is the laser's own.
fn figures() -> impl Strategy<Value = Vec<Figure>> {
    let figure =
        (point(), 0.02..0.5, any::<bool>(), look()).prop_map(|(center, radius, has_corners, look)| {
            let corner = |i: i32| {
                let (sin, cos) = math::sin_cos(f64::from(i) * 2.0 * PI / 3.0 + center.x);
                center + 0.99 * radius * baudbot_geometry::Vector::new(cos, sin)
            };
            let outline = if has_corners { (0..3).map(corner).collect() } else { vec![] };
            Figure { disc: Circle { center, radius }, outline, look }
        });
    prop::collection::vec(figure, 1..12)
}

fn pose(at: impl Strategy<Value = Point>) -> impl Strategy<Value = Pose> {
    let heading = prop_oneof![Just(0.0), Just(PI), Just(-0.5 * PI), -PI..PI];
    (at, heading).prop_map(|(at, heading)| Pose::new(at.x, at.y, heading))
}

fn laser() -> impl Strategy<Value = Laser> {
    let opening_rad = prop_oneof![Just(TAU), Just(PI), 0.0..TAU, 0.0..0.1];
    let rays = prop_oneof![1..12_usize, 100..700_usize];
    let mounted = pose((-0.2..0.2, -0.2..0.2).prop_map(|(x, y)| Point::new(x, y)));
    let sweep_ns = prop_oneof![Just(66_503_900), 1..200_000_000_u64, Just(1)];
    let rest = (prop_oneof![0.3..6.0_f64, Just(1e6)], any::<bool>(), any::<bool>());
    (opening_rad, rays, mounted, sweep_ns, rest).prop_map(
        |(opening_rad, rays, pose, sweep_ns, (range_m, clockwise, on_turret))| {
            // The arena gives it its layer.
            let height = Arena::new(vec![], vec![]).height(0.2);
            Laser {
                mount: Mount { pose, turret: on_turret.then_some(0), height, elevation_rad: None },
                fan: Fan::new(opening_rad, rays),
                min_m: 0.0,
                range_m,
                sweep_ns,
                clockwise,
            }
        },
    )
}

/// A body whose wheels do what they are commanded.
fn drive() -> Drive {
    let motor = VelocityMotor {
        gain_n_s: 1.0,
        max_torque_nm: 1.0,
        full_speed_m_s: 1.0,
        efficiency: 1.0,
        reached: Vec::new(),
    };
    Drive {
        radius_m: 0.1,
        half_track_m: 0.1,
        wheel_radius_m: 0.03,
        mass_kg: 1.0,
        inertia_kg_m2: 0.01,
        damping_n_s_m: 0.0,
        turn_damping_nm_s: 0.0,
        forward_gain: 1.0,
        turn_gain: 1.0,
        motor: Motors::Velocity(motor),
        motor_noise: MotorNoise::default(),
        motor_track_factor: 1.0,
        deviation: None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_swept_scan_is_that_of_its_rays(
        mut arena in arena(),
        bodies in figures(),
        mut laser in laser(),
        robot in pose(point()),
        (speed_m_s, turn_rate_rad_s) in (
            prop_oneof![Just(0.0), -1.0..1.0_f64, -20.0..20.0_f64],
            prop_oneof![Just(0.0), -3.0..3.0_f64, -60.0..60.0_f64],
        ),
        turret_rad in prop_oneof![Just(0.0), -PI..PI],
        (tick_ms, began_ms) in (prop_oneof![Just(10), Just(1), Just(100)], 0..60_u64),
        which in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
    ) {
        laser.mount.height = arena.height(0.2);
        let (surroundings, drive) = (Surroundings::default(), drive());
        let mut frozen = Frozen::default();
        frozen.crowd.rebuild(bodies.iter().map(|figure| figure.disc));
        frozen.bodies = bodies;
        let (frozen, trails) = (&frozen, Vec::new());
        let scene = Scene::new((&arena, &surroundings), (frozen, &trails), 0, None);
        let motion = drive.place(robot, speed_m_s, turn_rate_rad_s);
        let actuators = [ActuatorState { signal: 0.0, pulse: 0.0, angle_rad: turret_rad }];
        // A scan that may have begun before the tick, of which some rays are taken.
        let tick_start = SimTime::from_ns(100_000_000);
        let tick_end = tick_start + tick_ms * 1_000_000;
        let start = SimTime::from_ns(100_000_000 - began_ms * 1_000_000);
        let at = Measurement {
            scene: &scene,
            drive: &drive,
            motion: &motion,
            actuators: &actuators,
            battery: None,
            noise: false,
            now: tick_start,
            tick_start,
            tick_end,
            near: None,
            impulses_n_s: [0.0; 2],
        };
        let (a, b) = (which.0.index(laser.rays() + 1), which.1.index(laser.rays() + 1));
        let which = a.min(b)..a.max(b);
        let mut values = vec![f64::NAN; laser.rays()];
        laser.take(&at, which.clone(), start, &mut values);
        for (i, value) in values.iter().enumerate() {
            if which.contains(&i) {
                let expected = one_ray(&laser, &at, start, i);
                prop_assert_eq!(value.to_bits(), expected.to_bits(), "ray {}: {} not {}", i, value, expected);
            } else {
                prop_assert!(value.is_nan(), "ray {} is not asked for", i);
            }
        }
    }

    #[test]
    fn rays_before_an_end_are_those_whose_instants_are(
        laser in laser(),
        (start, end) in (0..400_000_000_u64, 0..400_000_000_u64),
    ) {
        let (start, end) = (SimTime::from_ns(start), SimTime::from_ns(end));
        let before = (0..laser.rays()).take_while(|&i| laser.instant(start, i) < end).count();
        prop_assert_eq!(laser.taken_before(start, end), before);
    }
}
