//! The timing of §3.2.1: how often a brain and a microcontroller can speak, and when a sensor is readable.

use std::fmt::Write;

use crate::common::{BODY, KHEPERA, command, world, world_with};
use baudbot_sim::{Input, SimTime};

/// A robot with `sensors` compasses of one byte each, which stand for any sensor of one byte.
fn bare_robot(sensors: usize, baud: u32, bits: u8) -> String {
    let mut toml = format!(
        "step_ms = 1.0\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         firmware = {{ protocol = \"bare\", mode = \"poll\" }}\n\
         link = {{ kind = \"uart\", baud = {baud}, bits_per_character = {bits} }}\n"
    );
    for i in 0..sensors {
        writeln!(toml, "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 8").unwrap();
    }
    toml
}

/// Exchanges a second of a brain that answers each message of readings at once with two motor bytes.
fn exchanges_per_second(sensors: usize, baud: u32, bits: u8) -> f64 {
    let mut world = world(&bare_robot(sensors, baud, bits).replace("step_ms = 1.0", "step_ms = 0.5"));
    let bytes = command(world.robot(0).spec(), 0.0, 0.0);
    let mut arrivals = Vec::new();
    for tick in 0..4000 {
        let turn = world.begin()[0];
        // The brain speaks first, then whenever a message has come; `messages` counts those.
        let arrived = world.robot(0).uplink().messages > arrivals.len() as u64;
        if arrived {
            arrivals.push(turn.at.as_seconds());
        }
        let speaks = tick == 0 || arrived;
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if speaks { &bytes } else { &[] } }]);
    }
    (arrivals.len() - 1) as f64 / (arrivals.last().unwrap() - arrivals[0])
}

/// The exchanges of §3.2.1 at other rates.
#[test]
fn exchanges_a_second_by_baud_rate_sensors_and_bits() {
    let mut table = String::new();
    for (bits, name) in [(8, "8 bits, as the notes count"), (10, "8N1, 10 bits"), (11, "8E1 or 8N2, 11 bits")]
    {
        writeln!(table, "{name}\n{:>8} {:>8} {:>8} {:>8} {:>8}", "baud", "1 sensor", "2", "4", "8").unwrap();
        for baud in [1200, 2400, 4800, 9600, 19_200, 38_400] {
            write!(table, "{baud:>8}").unwrap();
            for sensors in [1, 2, 4, 8] {
                write!(table, " {:>8.1}", exchanges_per_second(sensors, baud, bits)).unwrap();
            }
            table.push('\n');
        }
    }
    insta::assert_snapshot!(table);
}

/// Six bytes at 9600 baud, by §3.2.1.
#[test]
fn the_notes_example_is_200_exchanges_with_8_bits_and_160_with_8n1() {
    assert!((exchanges_per_second(4, 9600, 8) - 200.0).abs() < 0.5);
    assert!((exchanges_per_second(4, 9600, 10) - 160.0).abs() < 0.5);
}

/// The readability of §3.2.1.
#[test]
fn each_ir_sensor_of_a_khepera_is_readable_at_every_second_step_and_not_more() {
    for overrides in [&["robots.khepera.link={ kind = \"ideal\" }"][..], &[]] {
        let mut world = world_with(KHEPERA, overrides);
        let mut readable: Vec<Vec<u64>> = vec![Vec::new(); 8];
        for tick in 0..200 {
            world.begin();
            for (i, reading) in world.robot(0).readings()[..8].iter().enumerate() {
                if reading.readable {
                    readable[i].push(tick);
                }
            }
            world.finish(&[]);
        }
        for (i, ticks) in readable.iter().enumerate() {
            assert!(ticks.len() >= 98, "sensor {i} was readable {} times in 200 steps", ticks.len());
            assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] == 2), "sensor {i}: {ticks:?}");
        }
    }
}

/// Sensors that are read one after the other (§3.2.1).
#[test]
fn a_reading_says_when_it_was_sampled() {
    let mut world = world(KHEPERA);
    for _ in 0..50 {
        let turn = world.begin()[0];
        for (i, reading) in world.robot(0).readings()[..8].iter().enumerate() {
            let Some(at) = reading.sampled_at else { continue };
            // The wire has time in units of 0.1 ms: the frame's and the age, each rounded down.
            let phase = (at.as_ns() + 100_000) % 20_000_000;
            let due = i as u64 * 2_500_000;
            assert!(phase.abs_diff(due + 100_000) <= 100_000, "sensor {i} sampled at {at:?}");
            assert!(at <= turn.at);
        }
        world.finish(&[]);
    }
}

/// Steps 1 to 3 of Fig. 3.1 take their time on a real robot (§3.2.1).
#[test]
fn an_answer_that_fits_into_the_tick_acts_in_it_and_one_that_does_not_acts_later() {
    // One byte of readings up and two of signals down: 0.78 ms at 38,400 baud, 25 ms at 1200.
    for (baud, acts_at_tick) in [(38_400, 1), (1200, 3)] {
        let toml = bare_robot(1, baud, 10)
            .replace("step_ms = 1.0", "step_ms = 10.0\nsubsteps = 10")
            .replace("mode = \"poll\"", "mode = \"stream\", period_ms = 30.0");
        let mut world = world(&toml);
        let mut moved = None;
        for tick in 1..10 {
            crate::common::tick(&mut world, 0.5, 0.5);
            if world.robot(0).motion().speed_m_s > 0.0 {
                moved = moved.or(Some(tick));
            }
        }
        assert_eq!(moved, Some(acts_at_tick), "{baud} baud");
    }
}

#[test]
fn a_brain_steps_when_a_message_has_arrived_and_at_the_latest_when_the_tick_ends() {
    let toml = bare_robot(4, 9600, 8)
        .replace("step_ms = 1.0", "step_ms = 10.0")
        .replace("mode = \"poll\"", "mode = \"stream\", period_ms = 20.0");
    let mut world = world(&toml);
    // Four bytes of 8 bits at 9600 baud arrive after 3.333… ms; in the second tick nothing does.
    let turn = world.begin()[0];
    assert_eq!(turn.at, SimTime::from_ns(3_333_334));
    assert_eq!(world.robot(0).unread().len(), 4);
    world.finish(&[]);
    assert_eq!(world.begin()[0].at, SimTime::from_ns(20_000_000));
    assert!(world.robot(0).unread().is_empty());
}

#[test]
fn a_brain_that_thinks_is_not_asked_until_it_is_done() {
    let mut world = world(&bare_robot(1, 38_400, 10));
    let at = world.begin()[0].at;
    world.finish(&[Input { robot: 0, at: at + 5_500_000, bytes: &[] }]);
    let mut asked = Vec::new();
    for _ in 0..10 {
        asked.extend(world.begin().iter().map(|turn| turn.at));
        world.finish(&[]);
    }
    // The brain stepped at the end of the first tick, 1 ms, and thought until 6.5 ms.
    assert_eq!(asked[0], SimTime::from_ns(7_000_000));
    assert_eq!(asked.len(), 5);
}
