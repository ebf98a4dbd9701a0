//! A brain's answer as a command makes the world that its bytes make.

use std::sync::Arc;

use baudbot_sim::drive::Wheels;
use baudbot_sim::{Answer, Input, World, Written};
use baudbot_wire::{frame, khepera, write_command, write_values};

/// A robot on a link of this kind.
fn world(link: &str, firmware: &str, more: &str) -> World {
    let toml = format!(
        "[[arena.polygons]]\nname = \"room\"\nsolid = false\n\
         points_m = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]\n\
         [[robots]]\nname = \"r\"\nlink = {{ {link} }}\nfirmware = {{ {firmware} }}\n{more}\n\
         body = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.01, wheel_radius_m = 0.03 }}\n\
         [robots.actuators.lamp]\nkind = \"lamp\"\nintensity_cd = 1.0\n\
         [robots.sensors.compass]\nkind = \"compass\"\nbits = 8\nperiod_ms = 35.0\nphase_ms = 12.0\n\
         [robots.sensors.ir]\nkind = \"ir\"\nbearing_rad = 0.3\nrays = 3\nopening_rad = 0.5\nrange_m = 0.9\n\
         c1_m2 = 0.01\nc2 = 0.0\nsigma = 0.02\nbits = 10\nperiod_ms = 20.0\n"
    );
    World::new(Arc::new(baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}\n{toml}"))))
}

/// The bytes that a brain would write.
fn bytes(world: &World, sequence: u8, signals: &[f64]) -> Vec<u8> {
    use baudbot_sim::firmware::Protocol;
    let firmware = &world.robot(0).spec().firmware;
    let (layout, signals) = (firmware.layout(), signals.iter().copied());
    let (mut payload, mut framed) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
    let len = match firmware.protocol {
        Protocol::Bare { .. } => write_values(layout.motors, signals, &mut payload).unwrap_or(0),
        Protocol::Khepera => khepera::write_exchange(&layout, signals, &mut payload).unwrap_or(0),
        Protocol::Create(_) | Protocol::Asercom => {
            firmware.agreement().write_command(sequence, signals, &mut payload).unwrap_or(0)
        }
        Protocol::Framed { .. } => {
            let len = write_command(&layout, sequence, signals, &mut payload);
            let len = len.map_or(0, |len| frame::encode(&payload[..len], &mut framed).unwrap());
            return framed[..len].to_vec();
        }
    };
    payload[..len].to_vec()
}

/// The signals of a brain in tick `i`: mostly sensible ones, and all else that can come.
fn signals(i: u64) -> Vec<f64> {
    let turn = (i as f64 * 0.37).sin();
    match i % 11 {
        3 => vec![f64::NAN, 0.1, 0.0],
        5 => vec![1e6, 0.1, 0.0],
        7 => vec![0.1, 0.2],
        9 => vec![0.2, 0.1, f64::INFINITY],
        _ => vec![turn, 0.5, 0.25],
    }
}

const LINKS: [&str; 5] = [
    "kind = \"onboard\"",
    "kind = \"ideal\"",
    "kind = \"uart\", baud = 115200",
    "kind = \"uart\", baud = 9600, byte_error_rate = 0.02",
    "kind = \"usb\"",
];

const FIRMWARES: [(&str, &str); 6] = [
    ("period_ms = 10.0", ""),
    ("period_ms = 10.0", "motors = { signal_bits = 8 }"),
    (
        "period_ms = 25.0, phase_ms = 3.0",
        "microcontroller = { receiving_us_per_byte = 20.0, obeying_us = 300.0 }",
    ),
    ("mode = \"poll\"", "microcontroller = { framing_us_per_byte = 10.0 }"),
    ("protocol = \"bare\", period_ms = 20.0", "motors = { signal_bits = 8 }"),
    ("period_ms = 10.0, ages = false", "microcontroller = { obeying_us = 12000.0 }"),
];

#[test]
fn a_command_makes_the_world_that_its_bytes_make() {
    for link in LINKS {
        for (firmware, more) in FIRMWARES {
            let mut by_bytes = world(link, firmware, more);
            let mut by_commands = by_bytes.clone();
            // The bytes on the robot's cable are recorded.
            let mut listened = by_bytes.clone();
            listened.keep_tape(0, 1 << 12);
            for tick in 0..200 {
                let turns = by_bytes.begin().to_vec();
                assert_eq!(by_commands.begin(), turns);
                assert_eq!(listened.begin(), turns);
                // Some answers come within the tick, some later, some two at a time, some as bytes that are no message.
                let thinking_ns = [0, 4_000_000, 17_000_000][tick as usize % 3];
                let count = 1 + usize::from(tick % 4 == 1);
                let sequence = tick as u8;
                let signals = signals(tick);
                let written = bytes(&by_bytes, sequence, &signals);
                let noise: &[u8] = if tick % 10 == 8 { &[7, 1, 2] } else { &[] };
                if let Some(turn) = turns.first() {
                    let at = turn.at + thinking_ns;
                    let mut inputs = vec![Input { robot: 0, at, bytes: noise }];
                    inputs.extend((0..count).map(|_| Input { robot: 0, at, bytes: &written }));
                    let [left, right, ref others @ ..] = signals[..] else { unreachable!() };
                    let wheels = Wheels { left, right };
                    let command = Written::Command { sequence, wheels, others };
                    let mut answers = vec![Answer::from(inputs[0])];
                    answers.extend((0..count).map(|_| Answer { robot: 0, at, written: command }));
                    by_bytes.finish(&inputs);
                    by_commands.finish_answers(&answers);
                    listened.finish_answers(&answers);
                }
                if turns.is_empty() {
                    by_bytes.finish(&[]);
                    by_commands.finish_answers(&[]);
                    listened.finish_answers(&[]);
                }
                assert_eq!(by_commands.hash(), by_bytes.hash(), "tick {tick} of {link}, {firmware}, {more}");
                assert_eq!(listened.hash(), by_bytes.hash(), "tick {tick} of {link}, {firmware}, {more}");
            }
            let commands = by_bytes.robot(0).commands();
            assert!(commands > 10 || firmware.contains("bare"), "{commands} of {link}, {firmware}, {more}");
        }
    }
}
