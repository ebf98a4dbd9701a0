//! Scenarios and brains for the tests of the world.
#![allow(missing_docs, unreachable_pub, dead_code, reason = "each program of tests uses a part of it")]

pub mod statistics;

use baudbot_scenario::Override;
use baudbot_sim::firmware::Protocol;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Input, World};
use baudbot_wire::{frame, khepera, write_command, write_values};

pub const ARSIM: &str = include_str!("../../../../catalogue/scenarios/arsim.toml");
pub const WANDER: &str = include_str!("../../../../catalogue/scenarios/wander.toml");
pub const KHEPERA: &str = include_str!("../../../../catalogue/scenarios/khepera.toml");

/// ARSim's body, for robots of test scenarios.
pub const BODY: &str = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, \
                        damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }";

pub fn world(toml: &str) -> World {
    World::new(baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}")).into())
}

pub fn world_with(toml: &str, overrides: &[&str]) -> World {
    let overrides: Vec<_> = overrides.iter().map(|text| Override::parse(text).unwrap()).collect();
    World::new(
        baudbot_scenario::parse_with(toml, &overrides).unwrap_or_else(|error| panic!("{error}")).into(),
    )
}

/// The error that a scenario is refused with.
pub fn refusal(toml: &str) -> String {
    baudbot_scenario::parse(toml).expect_err("the scenario should be refused").to_string()
}

/// A command as it goes over the robot's wire.
pub fn command(spec: &RobotSpec, left: f64, right: f64) -> Vec<u8> {
    let layout = spec.firmware.layout();
    let mut payload = [0; frame::MAX_PAYLOAD];
    let signals = [left, right];
    match spec.firmware.protocol {
        Protocol::Bare { .. } => {
            let n = write_values(layout.motors, signals, &mut payload).unwrap();
            payload[..n].to_vec()
        }
        Protocol::Khepera => {
            let n = khepera::write_exchange(&layout, signals, &mut payload).unwrap();
            payload[..n].to_vec()
        }
        Protocol::Create(_) | Protocol::Asercom => {
            let n = spec.firmware.agreement().write_command(1, signals, &mut payload).unwrap();
            payload[..n].to_vec()
        }
        Protocol::Framed { .. } => {
            let n = write_command(&layout, 0, signals, &mut payload).unwrap();
            let mut bytes = [0; frame::MAX_FRAME];
            let n = frame::encode(&payload[..n], &mut bytes).unwrap();
            bytes[..n].to_vec()
        }
    }
}

/// The first bytes of a brain of messages: none, unless its robot is a Create.
pub fn opening(spec: &RobotSpec) -> Vec<u8> {
    let mut bytes = [0; frame::MAX_PAYLOAD];
    let opens = spec.firmware.protocol.is_to_be_opened(0);
    let opening = opens.then(|| spec.firmware.agreement().write_poll(&mut 0, &mut bytes));
    let n = opening.flatten().unwrap_or(0);
    bytes[..n].to_vec()
}

/// One tick in which every brain that steps sends these signals at once.
pub fn tick(world: &mut World, left: f64, right: f64) {
    let turns = world.begin().to_vec();
    let written = |world: &World, robot: usize| {
        let view = world.robot(robot);
        let opening = if view.commands() == 0 { opening(view.spec()) } else { Vec::new() };
        [opening, command(view.spec(), left, right)].concat()
    };
    let bytes: Vec<_> = turns.iter().map(|turn| written(world, turn.robot)).collect();
    let inputs: Vec<_> = turns
        .iter()
        .zip(&bytes)
        .map(|(turn, bytes)| Input { robot: turn.robot, at: turn.at, bytes })
        .collect();
    world.finish(&inputs);
}

/// Runs so many ticks with these signals.
pub fn run(world: &mut World, ticks: u64, left: f64, right: f64) {
    for _ in 0..ticks {
        tick(world, left, right);
    }
}
