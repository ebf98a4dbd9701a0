//! The commands of a Khepera other than `N` and `D`: what they do to the robot, and what is answered.

use std::sync::Arc;

use baudbot_sim::{Input, World};

use crate::common::{BODY, command, world};

/// A Khepera in the open, whose encoders count 600 times a turn of 50.27 mm: 11.94 pulses a millimetre.
fn khepera(link: &str, more: &str) -> World {
    world(&format!(
        "step_ms = 10.0\nsubsteps = 10\nnoise = false\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
         firmware = {{ protocol = \"khepera\" }}\nlink = {{ {link} }}\n{more}"
    ))
}

fn ideal() -> World {
    khepera("kind = \"ideal\"", "")
}

/// The answer to these bytes by the end of so many ticks.
fn say(world: &mut World, said: &str, ticks: usize) -> String {
    let mut heard = Vec::new();
    for tick in 0..=ticks {
        let turn = world.begin()[0];
        if tick > 0 {
            heard.extend_from_slice(world.robot(0).unread());
        }
        let bytes = if tick == 0 { said.as_bytes() } else { &[] };
        world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
    }
    String::from_utf8(heard).unwrap().replace("\r\n", ";")
}

/// The numbers in the answer to a question.
fn ask(world: &mut World, question: &str) -> Vec<i32> {
    let answer = say(world, &format!("{question}\r"), 2);
    let numbers = answer.trim_end_matches(';').split(',').skip(1);
    numbers.map(|number| number.parse().unwrap()).collect()
}

#[test]
fn a_robot_says_its_versions_takes_gains_and_has_nothing_plugged_in() {
    let mut world = ideal();
    for (said, answer) in [
        ("B\r", "b,5.02,5.01;"),
        ("A,3800,800,100\r", "a;"),
        ("F,3000,20,4000\r", "f;"),
        ("J,20,64,20,64\r", "j;"),
        ("L,0,1\r", "l;"),
        ("R,32\r", "r,255;"),
        ("W,170,63\r", "w;"),
        ("T,1,B\r", "z,Protocol error;"),
        ("I,3\r", "z,Protocol error;"),
        ("L,2,1\r", "z,Protocol error;"),
        ("R,64\r", "z,Protocol error;"),
        ("J,0,64,20,64\r", "z,Protocol error;"),
        ("P,256,0\r", "z,Protocol error;"),
        ("M\r", "Command not found;"),
    ] {
        assert_eq!(say(&mut world, said, 2), answer, "{said}");
    }
}

#[test]
fn a_speed_is_read_in_pulses_per_10_ms() {
    let mut world = ideal();
    assert_eq!(ask(&mut world, "E"), [0, 0]);
    say(&mut world, "D,40,-20\r", 100);
    assert_eq!(ask(&mut world, "E"), [40, -20]);
    assert_eq!(ask(&mut world, "K"), [1, 1, 0, 1, 1, 0]);
    // 0.5 m/s at 11.94 pulses a millimetre: 59.7 pulses in 10 ms, and no motor does more.
    say(&mut world, "D,127,-127\r", 100);
    assert_eq!(ask(&mut world, "E"), [60, -60]);
}

#[test]
fn positions_are_counted_from_what_they_are_set_to() {
    let mut world = ideal();
    assert_eq!(say(&mut world, "G,-1000,70000\r", 1), "g;");
    assert_eq!(ask(&mut world, "H"), [-1000, 70_000]);
    say(&mut world, "D,20,20\r", 200);
    say(&mut world, "D,0,0\r", 100);
    let driven_m = world.robot(0).motion().travel_m.left;
    let pulses = (driven_m / (std::f64::consts::TAU * 0.008) * 600.0).floor() as i32;
    assert!((3000..4500).contains(&pulses), "{pulses}");
    assert_eq!(ask(&mut world, "H"), [pulses - 1000, pulses + 70_000]);
}

#[test]
fn wheels_drive_to_their_targets_along_the_profile() {
    let mut world = ideal();
    // 0.25 pulses per (10 ms)²: 20 pulses per 10 ms after 0.8 s and 800 pulses. So 4000 take 0.8 + 1.2 + 0.8 s, and the
    // rounded end about twice 1/K more.
    assert_eq!(say(&mut world, "C,4000,-4000\r", 1), "c;");
    assert_eq!(ask(&mut world, "K")[..2], [0, 0]);
    say(&mut world, "", 36);
    // At 0.4 s: 10 pulses per 10 ms, which the motor follows 50 ms behind.
    let [left, right] = ask(&mut world, "E")[..] else { panic!() };
    assert!((8..=10).contains(&left) && right == -left, "{left}, {right}");
    say(&mut world, "", 80);
    assert_eq!(ask(&mut world, "E"), [20, -20]);
    let [reached, mode, missing, ..] = ask(&mut world, "K")[..] else { panic!() };
    assert!((reached, mode) == (0, 0) && (1800..2600).contains(&missing), "{missing}");
    say(&mut world, "", 158);
    let [reached, mode, missing, ..] = ask(&mut world, "K")[..] else { panic!() };
    assert!((reached, mode) == (0, 0) && (1..100).contains(&missing), "{missing}");
    say(&mut world, "", 60);
    assert_eq!(ask(&mut world, "H"), [4000, -4000]);
    assert_eq!(ask(&mut world, "K"), [1, 1, 0, 1, 1, 0]);
    assert!(world.robot(0).motion().wheel_speed_rad_s.left.abs() < 0.01);
}

#[test]
fn a_wheel_that_has_farther_to_go_is_waited_for() {
    let mut world = ideal();
    say(&mut world, "J,20,64,40,128\r", 1);
    say(&mut world, "C,50,3000\r", 100);
    // The body pulls the left wheel along a little, and it comes back.
    let status = ask(&mut world, "K");
    assert!(status[1] == 0 && status[2].abs() < 6 && status[4] == 0 && status[5] > 500, "{status:?}");
    say(&mut world, "", 300);
    assert_eq!(ask(&mut world, "H"), [50, 3000]);
    assert_eq!(ask(&mut world, "K"), [1, 1, 0, 1, 1, 0]);
}

#[test]
fn a_speed_or_a_pulse_width_ends_the_way_to_a_target() {
    for (said, speeds) in [("D,20,20\r", [20, 20]), ("P,-51,51\r", [-12, 12])] {
        let mut world = ideal();
        say(&mut world, "C,9000,9000\r", 50);
        say(&mut world, said, 100);
        assert_eq!(ask(&mut world, "E"), speeds, "{said}");
        assert_eq!(ask(&mut world, "K"), [1, 1, 0, 1, 1, 0]);
    }
}

#[test]
fn a_pulse_width_is_a_share_of_the_full_signal() {
    let mut world = ideal();
    assert_eq!(say(&mut world, "P,255,-51\r", 100), "p;");
    let speeds = world.robot(0).motion().wheel_speed_rad_s;
    assert!(
        (speeds.left * 0.008 - 0.5).abs() < 1e-3 && (speeds.right * 0.008 + 0.1).abs() < 1e-3,
        "{speeds:?}"
    );
    assert_eq!(world.robot(0).commands(), 1);
}

#[test]
fn inputs_have_names_and_light_is_told_by_sensors_for_it_or_dark() {
    let mut world = ideal();
    assert_eq!(ask(&mut world, "O"), [500; 8]);
    let more = "[robots.sensors.ad_3]\nkind = \"compass\"\nbits = 10\n\
                [robots.sensors.light]\nkind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 1.0\nrays = 3\n\
                range_m = 0.1\nambient_saturation_lux = 100.0\nbits = 10\n";
    let mut world = khepera("kind = \"ideal\"", more);
    say(&mut world, "", 5);
    // North is in the middle of 10 bits, and dark is the top of them.
    assert_eq!(ask(&mut world, "I,3"), [512]);
    assert_eq!(ask(&mut world, "O"), [1023]);
    assert_eq!(say(&mut world, "I,2\r", 2), "z,Protocol error;");
}

#[test]
fn a_robot_without_encoders_or_with_plain_motors_goes_to_no_target() {
    let mut plain = world(&format!(
        "[[robots]]\nname = \"k\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\nfirmware = {{ protocol = \"khepera\" }}\n"
    ));
    for said in ["C,10,10\r", "G,0,0\r", "H\r", "E\r", "K\r"] {
        assert_eq!(say(&mut plain, said, 10), "z,Protocol error;", "{said}");
    }
    assert_eq!(say(&mut plain, "P,255,255\r", 10), "p;");
}

#[test]
fn lines_may_come_in_halves_and_answers_take_their_time_on_the_wire() {
    let mut world = khepera("preset = \"uart-9600\"", "");
    assert_eq!(say(&mut world, "G,1", 1), "");
    assert_eq!(say(&mut world, "0,20\r", 2), "g;");
    // `H` is 2 bytes and `h,10,20` with its end 9: 11 of 1.042 ms. The processor takes 40 µs for the last byte of the
    // question, and for each of the answer.
    let turn = world.begin()[0];
    world.finish(&[Input { robot: 0, at: turn.at, bytes: b"H\r" }]);
    let arrives = loop {
        let at = world.begin()[0].at;
        let is_whole = world.robot(0).unread().ends_with(b"\r\n");
        world.finish(&[]);
        if is_whole {
            break at;
        }
    };
    let took_ms = arrives.since(turn.at) as f64 * 1e-6;
    assert!((took_ms - 11.0 * 10.0 / 9.6 - 10.0 * 0.04).abs() < 0.001, "{took_ms} ms");
    assert_eq!(world.robot(0).uplink().messages, 2);
}

#[test]
fn questions_that_come_while_the_robot_is_busy_are_answered_in_the_order_of_the_alphabet() {
    let mut world = khepera("kind = \"ideal\"", "microcontroller = { obeying_us = 300.0 }");
    let said = "D,0,0\rL,0,1\rX\rB\rH\rH\rN\rG,7,7\r";
    let heard = say(&mut world, said, 3);
    // Residual values of the six IR sensors that were read by then, with nothing near, and two others.
    let readings = format!("n{}{};", ",64".repeat(6), ",0".repeat(2));
    assert_eq!(heard, format!("b,5.02,5.01;d;h,7,7;{readings}g;l;Command not found;"));
}

#[test]
fn a_world_whose_registers_were_used_can_be_saved_and_goes_on_alike() {
    let mut world = ideal();
    say(&mut world, "G,5,5\rL,1,2\rC,400,900\r", 20);
    let scenario = Arc::clone(world.scenario());
    let mut again = World::load(scenario, &world.save(), world.hash()).unwrap();
    for world in [&mut world, &mut again] {
        say(world, "", 200);
        assert_eq!(ask(world, "H"), [400, 900]);
    }
    assert_eq!(world.hash(), again.hash());
}

#[test]
fn a_brain_of_messages_has_the_infra_red_sensors_and_the_wheels_of_one_exchange() {
    for link in ["kind = \"ideal\"", "kind = \"uart\", baud = 38400, bits_per_character = 11"] {
        let mut world = khepera(link, "");
        let mut answers = 0;
        let mut speaks = true;
        for _ in 0..200 {
            let turn = world.begin()[0];
            let readings = world.robot(0).readings();
            let is_readable: Vec<_> = readings.iter().map(|reading| reading.readable).collect();
            // All or none, and the positions have no message of their own.
            assert!(is_readable.iter().all(|readable| *readable == is_readable[0]), "{is_readable:?}");
            if is_readable[0] {
                (answers, speaks) = (answers + 1, true);
                assert_eq!(readings[8].values.len(), 2);
                assert_eq!(u64::from(readings[8].sequence), answers);
            }
            let said = command(world.robot(0).spec(), 0.5, 0.5);
            let bytes = if core::mem::take(&mut speaks) { &said[..] } else { &[] };
            world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
        }
        assert!(answers > 20, "{link}: {answers}");
        // The wheels turn at half of 0.5 m/s for nearly 2 s.
        let counts = world.robot(0).readings()[8].values[0];
        assert!((4000.0..6000.0).contains(&counts), "{link}: {counts}");
        assert_eq!((world.robot(0).downlink().bad_messages, world.robot(0).uplink().bad_messages), (0, 0));
    }
}
