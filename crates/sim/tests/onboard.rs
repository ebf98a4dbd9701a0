//! A brain on board is handed what it would be sent: what an ideal cable brings, without the cable.

use std::sync::Arc;

use baudbot_sim::{Input, SimTime, World};
use baudbot_wire::{Layout, frame, message};

/// A robot with sensors of several periods, on a link of this kind, with this firmware.
fn world(link: &str, firmware: &str, more: &str) -> World {
    let toml = format!(
        "[[arena.polygons]]\nname = \"room\"\nsolid = false\n\
         points_m = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]\n\
         [[robots]]\nname = \"r\"\nlink = {{ kind = \"{link}\" }}\nfirmware = {{ {firmware} }}\n\
         body = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.03 }}\n\
         motors = {{ signal_bits = 8 }}\n\
         [robots.sensors.compass]\nkind = \"compass\"\nbits = 8\nperiod_ms = 35.0\nphase_ms = 12.0\n\
         [robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 500\nbits = 16\nperiod_ms = 7.0\n\
         [robots.sensors.ir]\nkind = \"ir\"\nbearing_rad = 0.3\nrays = 3\nopening_rad = 0.5\nrange_m = 0.9\n\
         c1_m2 = 0.01\nc2 = 0.0\nsigma = 0.02\nbits = 10\nperiod_ms = 20.0\nacquisition_us = 112.0\n{more}"
    );
    World::new(Arc::new(baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}"))))
}

fn command(world: &World, signals: [f64; 2]) -> Vec<u8> {
    let motors = [world.robot(0).spec().firmware.motor_encoding(); 2];
    let layout = Layout { components: &[], counts: &[], motors: &motors, ages: false };
    let (mut payload, mut bytes) = ([0; 32], [0; 64]);
    let n = message::write_command(&layout, 0, signals, &mut payload).unwrap();
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    bytes[..n].to_vec()
}

/// The brain's view in each of 300 ticks in which it drives in circles: its steps, and its readings.
fn seen(mut world: World) -> Vec<(Option<SimTime>, String)> {
    let bytes = command(&world, [0.4, 0.3]);
    let ticks = (0..300).map(|_| {
        let at = world.begin().first().map(|turn| turn.at);
        let readings = format!("{:?}", world.robot(0).readings());
        let inputs = at.map(|at| Input { robot: 0, at, bytes: &bytes });
        world.finish(inputs.as_slice());
        (at, readings)
    });
    ticks.collect()
}

#[test]
fn on_board_everything_is_as_over_an_ideal_cable() {
    for firmware in [
        "period_ms = 10.0",
        "period_ms = 25.0, phase_ms = 3.0",
        "period_ms = 10.0, ages = false",
        "protocol = \"bare\", period_ms = 20.0",
        "mode = \"poll\"",
    ] {
        // The command of the bare protocol has another form, so the robot stands in that case.
        let [ideal, onboard] = ["ideal", "onboard"].map(|link| seen(world(link, firmware, "")));
        for (tick, (ideal, onboard)) in ideal.iter().zip(&onboard).enumerate() {
            assert_eq!(onboard, ideal, "tick {tick} with {firmware}");
        }
    }
}

#[test]
fn on_board_a_scan_may_have_any_number_of_values() {
    let laser = "[robots.sensors.laser]\nkind = \"laser\"\nmount = {}\nopening_rad = 4.0\nrays = 683\nrange_m = 4.0\n";
    let mut world = world("onboard", "period_ms = 10.0", laser);
    for _ in 0..30 {
        world.begin();
        world.finish(&[]);
    }
    let laser = &world.robot(0).readings()[3];
    assert_eq!(laser.values.len(), 683);
    assert!(laser.values.iter().all(|&distance_m| (0.8..1.5).contains(&distance_m)), "{:?}", laser.values);
    assert_eq!(world.robot(0).uplink().bytes, 0, "there is no cable");
    let error = baudbot_scenario::parse(
        "[[robots]]\nname = \"r\"\n\
         body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.03 }\n\
         [robots.sensors.laser]\nkind = \"laser\"\nmount = {}\nopening_rad = 4.0\nrays = 683\nrange_m = 4.0\n",
    );
    let text = error.unwrap_err().to_string();
    assert!(text.ends_with("a sensor has at most 255, unless its brain is on board"), "{text}");
}
