//! A tick needs no new memory once a run is under way. What other threads allocate meanwhile does not count.

use std::sync::Arc;

use baudbot_sim::{Input, World};
use baudbot_wire::{Layout, frame, message};

/// Robots that see each other, walls and pillars, on different cables, in a room that they cannot leave.
fn crowd(link: &str) -> World {
    let mut toml = String::from(
        "seed = 3\ncollision = \"stop-robot\"\n\
         [[arena.polygons]]\nname = \"room\"\nsolid = false\n\
         points_m = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]\n\
         [[arena.polygons]]\nname = \"box\"\npoints_m = [[0.1, 0.1], [0.3, 0.1], [0.3, 0.3], [0.1, 0.3]]\n\
         [[arena.circles]]\nname = \"pillar\"\nx_m = -0.5\ny_m = 0.5\nradius_m = 0.1\n",
    );
    for i in 0..12 {
        let (x_m, y_m) = (f64::from(i % 4) * 0.9 - 1.4, f64::from(i / 4) * 1.2 - 1.2);
        toml += &format!(
            "[[robots]]\nname = \"r{i}\"\nstart = {{ x_m = {x_m:?}, y_m = {y_m:?}, heading_rad = {i}.0 }}\n\
             body = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.03 }}\n\
             motors = {{ signal_bits = 8, noise_sigma = 0.05 }}\n{link}\n\
             [robots.sensors.ir]\nkind = \"ir\"\nbearing_rad = 0.0\nrays = 5\nopening_rad = 0.5\nrange_m = 0.5\n\
             c1_m2 = 0.01\nc2 = 0.0\nsigma = 0.02\nbits = 8\n\
             [robots.sensors.left]\nkind = \"sonar\"\nbearing_rad = 1.0\nopening_rad = 0.3\nrays = 3\nmin_m = 0.03\nmax_m = 2.0\n\
             [robots.sensors.compass]\nkind = \"compass\"\nbits = 8\n\
             [robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 500\nbits = 16\n",
        );
    }
    World::new(Arc::new(baudbot_scenario::parse(&toml).unwrap()))
}

/// A tick in which every brain that steps sends a command.
fn tick(world: &mut World, inputs: &mut Vec<(usize, baudbot_sim::SimTime)>, command: &[u8]) {
    inputs.clear();
    inputs.extend(world.begin().iter().map(|turn| (turn.robot, turn.at)));
    let mut given = [const { None }; 12];
    for (place, &(robot, at)) in given.iter_mut().zip(inputs.iter()) {
        *place = Some(Input { robot, at, bytes: command });
    }
    let given = given.map(|input| {
        input.unwrap_or(Input { robot: usize::MAX, at: baudbot_sim::SimTime::ZERO, bytes: &[] })
    });
    world.finish(&given);
}

#[track_caller]
fn assert_steady(mut world: World, surprises: usize) {
    let motors = [world.robot(0).spec().firmware.motor_encoding(); 2];
    let layout = Layout { components: &[], counts: &[], motors: &motors, ages: false };
    let (mut payload, mut bytes) = ([0; 32], [0; 64]);
    let n = message::write_command(&layout, 0, [0.3, 0.2], &mut payload).unwrap();
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    let mut inputs = Vec::with_capacity(12);
    // Long enough for each list to be as long as it ever gets, timelines and all.
    (0..8000).for_each(|_| tick(&mut world, &mut inputs, &bytes[..n]));
    let driven = |world: &World| world.robots().map(|robot| robot.counters().distance_m).sum::<f64>();
    let (before, mut quiet, mut with_memory) = (driven(&world), 0, 0);
    for _ in 0..1000 {
        let found = allocation_counter::measure(|| tick(&mut world, &mut inputs, &bytes[..n]));
        // Partners of a collision are named.
        if world.collisions().is_empty() {
            quiet += 1;
            with_memory += usize::from(found.count_total > 0);
        }
    }
    // Now and then a message takes longer than ever before, and a histogram grows by that.
    assert!(with_memory <= surprises, "{with_memory} of {quiet} ticks needed memory");
    assert!(
        driven(&world) > before + 1.0 && quiet > 900,
        "they drive, and seldom run into anything: {quiet}"
    );
}

#[test]
fn on_board() {
    assert_steady(crowd("link = { kind = \"onboard\" }"), 0);
}

#[test]
fn over_an_ideal_cable() {
    assert_steady(crowd(""), 0);
}

#[test]
fn over_a_serial_cable() {
    assert_steady(crowd("link = { kind = \"uart\", baud = 115200 }"), 10);
}
