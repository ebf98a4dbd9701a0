//! The same past with another future.

use std::collections::BTreeSet;

use baudbot_sim::World;

use crate::common::{run, world};

/// A robot with everything that has chance in it: noise, motors, cables, a radio, a receiver, a thing that wanders.
fn noisy() -> World {
    world(
        r#"
        [[arena.movers]]
        name = "person"
        radius_m = 0.2
        x_m = 3.0
        y_m = 3.0
        wander = { speed_m_s = 0.5, turn_s = 1.0 }
        [[robots]]
        name = "a"
        body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
        link = { kind = "uart", baud = 9600, byte_error_rate = 0.01, adapter = { kind = "bluetooth", latency_ms = 5.0, spread_ms = 3.0 } }
        motors = { noise_sigma = 0.05, noise_spread = 0.02 }
        [robots.sensors.ir]
        kind = "ir"
        bearing_rad = 0.0
        rays = 5
        opening_rad = 0.5
        range_m = 1.0
        c1_m2 = 0.03
        c2 = 0.1
        sigma = 0.02
        [robots.sensors.urg]
        preset = "urg-04lx"
        [robots.sensors.gps]
        kind = "gps"
        satellites = true
        "#,
    )
}

/// The keys of all streams of a world, wherever they are, as it shows them to a debugger.
fn keys(world: &World) -> BTreeSet<u64> {
    let text = format!("{world:?}");
    let numbers = text.split("Place { key: ").skip(1).filter_map(|rest| rest.split(',').next()?.parse().ok());
    numbers.collect()
}

#[test]
fn no_stream_goes_on_as_it_was() {
    let mut world = noisy();
    run(&mut world, 50, 0.3, 0.2);
    let before = keys(&world);
    // Of sensors, motors, the thing, and of two directions of the cable the damage of bytes and the radio.
    assert!(before.len() >= 3 + 1 + 1 + 4, "{before:?}");
    let (mut again, hash) = (world.clone(), world.hash());
    world.reseed(1);
    let after = keys(&world);
    assert_eq!(after.len(), before.len());
    assert!(
        after.is_disjoint(&before),
        "{:?} were left out",
        after.intersection(&before).collect::<Vec<_>>()
    );
    assert_ne!(world.hash(), hash);
    again.reseed(1);
    assert_eq!(again.hash(), world.hash());
    let mut other = again.clone();
    other.reseed(2);
    assert!(keys(&other).is_disjoint(&after));
    for world in [&mut world, &mut again, &mut other] {
        run(world, 50, 0.3, 0.2);
    }
    assert_eq!(again.hash(), world.hash());
    assert_ne!(other.hash(), world.hash());
}
