//! A robot that is asked in lines of text: what an exchange costs, what is answered and what is not.

use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::Arc;

use crate::common::{BODY, command, refusal, world, world_with};
use baudbot_sim::{Input, World};
use baudbot_wire::khepera::{POLL, readings_len_max};

const SCENARIO: &str = include_str!("../../../catalogue/scenarios/devices/khepera-ascii.toml");

/// A robot with eight sensors of ten bits, all with the reading `code`: compasses, which stand for any.
fn robot(code: f64, link: &str) -> String {
    let heading = -PI + code * 2.0 * PI / 1023.0;
    let mut toml = format!(
        "step_ms = 0.5\n[[robots]]\nname = \"r\"\nstart = {{ heading_rad = {heading} }}\n{BODY}\n\
         motors = {{ signal_bits = 8 }}\nfirmware = {{ protocol = \"khepera\" }}\nlink = {{ {link} }}\n"
    );
    for i in 0..8 {
        writeln!(toml, "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 10").unwrap();
    }
    toml
}

fn uart(baud: u32, bits: u8) -> String {
    format!("kind = \"uart\", baud = {baud}, bits_per_character = {bits}")
}

/// Answers with readings a second, and bytes of one exchange, of a brain that speaks first, then whenever readings
/// have come.
fn rate(world: &mut World, ticks: u64, said: &[u8]) -> (f64, f64) {
    let (mut arrivals, mut bytes) = (Vec::new(), 0);
    let mut speaks = true;
    for _ in 0..ticks {
        let turn = world.begin()[0];
        let robot = world.robot(0);
        if robot.readings()[0].readable {
            bytes = robot.uplink().bytes;
            arrivals.push((turn.at.as_seconds(), bytes));
            speaks = true;
        }
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if speaks { said } else { &[] } }]);
        speaks = false;
    }
    let ((first_at, first_bytes), exchanges) = (arrivals[0], (arrivals.len() - 1) as f64);
    let answered = (bytes - first_bytes) as f64 / exchanges;
    (exchanges / (arrivals.last().unwrap().0 - first_at), answered + said.len() as f64)
}

/// The lines of the brain in each of so many ticks, and the answer to all of them.
fn conversation(world: &mut World, lines: &[&[u8]]) -> String {
    let mut heard = Vec::new();
    for said in lines {
        let turn = world.begin()[0];
        heard.extend_from_slice(world.robot(0).unread());
        world.finish(&[Input { robot: 0, at: turn.at, bytes: said }]);
    }
    world.begin();
    heard.extend_from_slice(world.robot(0).unread());
    world.finish(&[]);
    String::from_utf8(heard).unwrap()
}

#[test]
fn polls_a_second_by_baud_rate_and_digits() {
    let mut table = String::new();
    for (bits, name) in [(10, "8N1, 10 bits"), (11, "8N2, 11 bits")] {
        writeln!(table, "{name}\n{:>8} {:>8} {:>8} {:>8} {:>8}", "baud", "1 digit", "2", "3", "4").unwrap();
        for baud in [1200, 2400, 4800, 9600, 19_200, 38_400, 115_200] {
            write!(table, "{baud:>8}").unwrap();
            for (digits, code) in [(1, 5.0), (2, 50.0), (3, 500.0), (4, 1005.0)] {
                let mut world = world(&robot(code, &uart(baud, bits)));
                let (rate, bytes) = rate(&mut world, 4000, &POLL);
                assert_eq!(bytes, f64::from(2 + 1 + 8 * (1 + digits) + 2), "{digits} digits");
                let expected = f64::from(baud) / f64::from(bits) / bytes;
                assert!((rate / expected - 1.0).abs() < 1e-3, "{baud} baud: {rate}, not {expected}");
                write!(table, " {rate:>8.1}").unwrap();
            }
            table.push('\n');
        }
    }
    insta::assert_snapshot!(table);
}

#[test]
fn at_9600_baud_and_11_bits_eight_sensors_of_four_digits_come_19_times_a_second() {
    let (rate, bytes) = rate(&mut world(&robot(1023.0, &uart(9600, 11))), 4000, &POLL);
    assert_eq!(bytes, 45.0);
    assert!((rate - 19.4).abs() < 0.05, "{rate}");
}

#[test]
fn the_scenarios_rate_is_that_of_its_bytes_near_walls_and_far_from_them() {
    let near = ["robots.khepera.start={ x_m = 0.26, y_m = 0.16, heading_rad = 0.8 }"];
    let free = ["robots.khepera.start={ x_m = -0.1, y_m = 0.0 }"];
    for baud in [9600, 38_400] {
        let link = format!("robots.khepera.link.baud={baud}");
        // The processor's time is no byte's: it is a test of the cable.
        let idle = "robots.khepera.microcontroller={ framing_us_per_byte = 0, receiving_us_per_byte = 0 }";
        let mut rates = Vec::new();
        for place in [near, free] {
            let mut world = world_with(SCENARIO, &[place[0], &link, idle, "step_ms=0.5"]);
            let (rate, bytes) = rate(&mut world, 8000, &POLL);
            // Reading a sensor may keep the processor for 0.02 ms.
            let expected = f64::from(baud) / 11.0 / bytes;
            assert!((rate / expected - 1.0).abs() < 0.01, "{place:?}, {baud} baud: {rate}, not {expected}");
            rates.push(rate);
        }
        assert!(rates[0] < 0.9 * rates[1], "near walls {} a second, far from them {}", rates[0], rates[1]);
    }
}

#[test]
fn a_command_with_its_poll_costs_its_own_bytes_and_those_of_the_acknowledgement() {
    // `N` arrives while `d` is on its way, which is a byte longer: it costs nothing.
    for (signal, digits) in [(0.0, 1), (1.0, 3), (-1.0, 4)] {
        let mut world = world(&robot(1023.0, &uart(9600, 11)));
        let said = command(world.robot(0).spec(), signal, signal);
        let (rate, bytes) = rate(&mut world, 4000, &said);
        assert_eq!(bytes, f64::from(2 + 2 * (1 + digits) + 2 + 3 + 43));
        let expected = 9600.0 / 11.0 / (bytes - 2.0);
        assert!((rate / expected - 1.0).abs() < 0.01, "signals {signal}: {rate}, not {expected}");
    }
}

#[test]
fn every_question_has_its_answer_and_a_line_may_end_in_three_ways() {
    let readings = "n,5,5,5,5,5,5,5,5\r\n";
    let mut world = world(&robot(5.0, "kind = \"ideal\""));
    let lines: [&[u8]; 6] = [b"N\r", b"D,127,-127\r", b"N\nD,0,0\r\n", b"D,0", b",0\rN", b"\n"];
    let heard = conversation(&mut world, &lines);
    assert_eq!(heard, [readings, "d\r\n", readings, "d\r\n", "d\r\n", readings].concat());
    let robot = world.robot(0);
    assert_eq!((robot.downlink().messages, robot.downlink().bad_messages), (6, 0));
    assert_eq!((robot.uplink().messages, robot.uplink().bad_messages), (6, 0));
    assert_eq!(robot.commands(), 3);
}

#[test]
fn what_makes_no_sense_is_counted_and_refused_in_the_robots_words() {
    let mut world = world(&robot(5.0, "kind = \"ideal\""));
    let long = vec![b'7'; 4000];
    let lines: [&[u8]; 14] = [
        b"X\r",
        b"M,1\r\n",
        b"n\r",
        b"\0\0\0N\r",
        b"\xff\xfe,\r",
        b"D\r",
        b"D,1\r",
        b"D,128,0\r",
        b"D,1,2,3\r",
        b"D,1,999999999999999999999\r",
        b"D,1.0,1\r",
        b"D,0,0\0\r",
        b"K,1\r",
        &long,
    ];
    let refusals = "Command not found\r\n".repeat(5) + &"z,Protocol error\r\n".repeat(8);
    assert_eq!(conversation(&mut world, &lines), refusals);
    let downlink = world.robot(0).downlink();
    assert_eq!((downlink.messages, downlink.bad_messages, downlink.bad_frames), (0, 13, 0));
    // The end of the long line; behind it all is as new.
    assert_eq!(conversation(&mut world, &[b"\r", b"D,5,5\r"]), "z,Protocol error\r\nd\r\n");
    let downlink = world.robot(0).downlink();
    assert_eq!((downlink.messages, downlink.bad_messages, downlink.bad_frames), (1, 13, 1));
    assert_eq!(world.robot(0).uplink().bad_messages, 0);
}

#[test]
fn a_robot_drives_as_it_is_told() {
    let mut world = world(&robot(5.0, &uart(9600, 11)));
    conversation(&mut world, &[b"D,100,100\r"]);
    for _ in 0..400 {
        world.begin();
        world.finish(&[]);
    }
    assert!(world.robot(0).motion().speed_m_s > 0.1, "{:?}", world.robot(0).motion());
    assert_eq!(world.robot(0).commands(), 1);
}

#[test]
fn only_readings_make_a_brain_step_before_the_ticks_end() {
    let mut world = world(&robot(5.0, &uart(115_200, 10)).replace("step_ms = 0.5", "step_ms = 10.0"));
    let say = |world: &mut World, said: &[u8]| {
        let turn = world.begin()[0];
        world.finish(&[Input { robot: 0, at: turn.at, bytes: said }]);
        turn.at.as_ns()
    };
    assert_eq!(say(&mut world, b"D,1,1\r"), 10_000_000);
    // `d` has come, and is no news.
    assert_eq!(say(&mut world, b"D,1,1\rN\r"), 20_000_000);
    assert_eq!(world.robot(0).uplink().messages, 1);
    // 6 bytes of the command, then 3 of its acknowledgement and 19 of readings, each rounded up.
    assert_eq!(say(&mut world, b""), 20_000_000 + 520_834 + 1_909_723);
    assert_eq!(world.robot(0).uplink().messages, 3);
}

#[test]
fn polls_that_come_while_an_answer_waits_share_it() {
    let text = robot(5.0, "kind = \"ideal\"");
    let busy = format!("{text}[robots.microcontroller]\nobeying_us = 300.0");
    let mut world = world(&busy);
    let heard = conversation(&mut world, &[b"D,1,1\rN\rN\rD,2,2\rN\r", b"", b"", b""]);
    assert_eq!(heard, "d\r\nn,5,5,5,5,5,5,5,5\r\n");
    assert_eq!((world.robot(0).downlink().messages, world.robot(0).commands()), (5, 2));
}

#[test]
fn every_value_that_arrives_is_readable_and_only_the_truth_knows_its_age() {
    // Each sensor is read every 20 ms, and an exchange takes 5.2 to 11.7 ms: answers repeat.
    let mut world = world_with(SCENARIO, &["robots.khepera.link.baud=38400"]);
    let (mut answers, mut speaks) = (0, true);
    for _ in 0..1000 {
        let turn = world.begin()[0];
        let readings = world.robot(0).readings();
        if readings[0].readable {
            answers += 1;
            speaks = true;
            // Encoders have a question of their own.
            let infrared = &readings[..8];
            assert!(infrared.iter().all(|reading| reading.readable && reading.sampled_at.is_none()));
            assert_eq!(u64::from(readings[7].sequence), answers % 256);
        }
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if speaks { &POLL } else { &[] } }]);
        speaks = false;
    }
    assert!(answers > 70, "{answers}");
    for sensor in world.robot(0).sensors().take(8) {
        let freshness = sensor.freshness;
        // The first answers come before the last sensors are first read, and have 0 for them.
        assert_eq!(freshness.readable, answers);
        assert!(answers - freshness.ages.count() <= 3, "{freshness:?} of {answers}");
        assert!((20_000_000..40_000_000).contains(&freshness.ages.max_ns().unwrap()), "{freshness:?}");
    }
}

#[test]
fn it_answers_over_every_cable() {
    for link in [
        "kind = \"ideal\"",
        "kind = \"onboard\"",
        "kind = \"usb\"",
        "kind = \"uart\", baud = 9600, half_duplex = true",
        "kind = \"uart\", baud = 9600, receive_depth = 2, transmit_depth = 1",
        "kind = \"uart\", baud = 9600, adapter = { kind = \"ftdi\" }",
        "kind = \"uart\", baud = 9600, adapter = { kind = \"bluetooth\" }",
    ] {
        let mut world = world(&robot(500.0, link));
        let said = command(world.robot(0).spec(), 0.0, 0.0);
        let (rate, bytes) = rate(&mut world, 4000, &said);
        assert!(rate > 4.0 && bytes == 8.0 + 3.0 + 35.0, "{link}: {rate} a second, {bytes} bytes");
        assert_eq!(world.robot(0).downlink().bad_messages, 0, "{link}");
    }
}

#[test]
fn a_noisy_cable_costs_lines_and_nothing_else() {
    let mut world = world(&robot(500.0, &format!("{}, byte_error_rate = 0.02", uart(38_400, 10))));
    for tick in 0..8000 {
        let turn = world.begin()[0];
        let bytes: &[u8] = if tick % 40 == 0 { b"D,5,5\rN\r" } else { &[] };
        world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
    }
    let robot = world.robot(0);
    for counters in [robot.downlink(), robot.uplink()] {
        assert!(counters.messages > 100 && counters.bad_messages > 10, "{counters:?}");
    }
}

#[test]
fn a_world_between_a_question_and_its_answer_can_be_kept_and_goes_on_alike() {
    let scenario = Arc::new(baudbot_scenario::parse(&robot(500.0, &uart(9600, 10))).unwrap());
    let mut world = World::new(Arc::clone(&scenario));
    let turn = world.begin()[0];
    world.finish(&[Input { robot: 0, at: turn.at, bytes: b"D,5,5\rN\r" }]);
    for _ in 0..12 {
        world.begin();
        world.finish(&[]);
    }
    let mut again = world.clone();
    for world in [&mut world, &mut again] {
        for _ in 0..200 {
            world.begin();
            world.finish(&[]);
        }
        assert_eq!(world.robot(0).uplink().messages, 2);
    }
    assert_eq!(world.hash(), again.hash());
}

#[test]
fn robots_that_lines_cannot_speak_of_are_refused() {
    let sound = robot(5.0, "kind = \"ideal\"");
    let firmware = |more: &str| sound.replace("\"khepera\" }", &format!("\"khepera\", {more} }}"));
    let protocol = "robots[0].firmware.protocol: \"khepera\"";
    for (toml, problem) in [
        (
            firmware("mode = \"stream\""),
            "robots[0].firmware.mode: must be \"poll\": the khepera protocol answers when asked; to stream, take \
             `protocol` = \"framed\"".to_owned(),
        ),
        (firmware("ages = true"), "robots[0].firmware.ages: the khepera protocol carries no ages".into()),
        (
            firmware("gap_ms = 20.0"),
            "robots[0].firmware.gap_ms: only the bare protocol separates messages by silence".into(),
        ),
        (
            firmware("period_ms = 20.0"),
            "robots[0].firmware.period_ms: a polled firmware has no period".into(),
        ),
        (
            format!("{sound}[robots.actuators.horn]\nkind = \"speaker\"\nlevel = 1.0"),
            format!(
                "{protocol} has no command for actuators besides the wheels, and there are 1; take another \
                 protocol, or leave them out"
            ),
        ),
        (
            sound.replace("s3]\nkind = \"compass\"\nbits = 10", "s3]\nkind = \"compass\""),
            format!("{protocol} sends whole numbers; give sensor `s3` a number of `bits`"),
        ),
        (
            sound.replace("motors = { signal_bits = 8 }", ""),
            format!("{protocol} sends whole numbers; give the motors a number of `signal_bits`"),
        ),
        (
            sound.replace("kind = \"ideal\"", "kind = \"usb\", laptop_buffer_bytes = 45"),
            "robots[0].link.laptop_buffer_bytes: must hold the longest message, 46 bytes, is 45".into(),
        ),
    ] {
        assert_eq!(refusal(&toml), problem);
    }
    let many: String =
        (0..64).map(|i| format!("[robots.sensors.t{i}]\nkind = \"compass\"\nbits = 23\n")).collect();
    assert_eq!(
        refusal(&format!("{sound}{many}")),
        "robots[0].sensors: lines of all readings have up to 555 bytes, the limit is 512"
    );
    let spec = world(&firmware("mode = \"poll\"")).robot(0).spec().clone();
    assert_eq!(readings_len_max(&spec.firmware.layout()), 43);
}
