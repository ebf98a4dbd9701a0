//! The faults of a cable: noise, floods, garbage, busy processors.

use crate::common::{BODY, WANDER, command, run, world, world_with};
use baudbot_sim::Input;

fn robot(link: &str, more: &str) -> String {
    format!("[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\nlink = {link}\n{more}\n")
}

const UART: &str = "{ kind = \"uart\", baud = 9600, receive_depth = 10, laptop_buffer_bytes = 256 }";

#[test]
fn a_flood_is_refused_beyond_the_laptops_buffer_and_harms_nothing() {
    let mut world = world(&robot(UART, ""));
    for _ in 0..100 {
        let at = world.begin()[0].at;
        world.finish(&[Input { robot: 0, at, bytes: &[0x55; 10_000] }]);
    }
    let downlink = world.robot(0).downlink();
    // 9600 baud 8N1 take 960 bytes a second, and 256 wait at the end.
    assert!(downlink.bytes <= 960 + 256, "{downlink:?}");
    let waiting = 100 * 10_000 - downlink.bytes - downlink.refused_bytes;
    assert!(waiting <= 256, "{waiting}");
    assert_eq!(downlink.messages, 0);
    // Resynchronisation: the garbage ends with the next delimiter, and the command after it is obeyed.
    let bytes = [&[0][..], &command(world.robot(0).spec(), 0.5, 0.5)].concat();
    for tick in 0..100 {
        let at = world.begin()[0].at;
        let bytes = if tick == 60 { &bytes[..] } else { &[] };
        world.finish(&[Input { robot: 0, at, bytes }]);
    }
    assert_eq!(world.robot(0).commands(), 1);
    assert_eq!(world.robot(0).downlink().bad_frames, 1);
    assert!(world.robot(0).motion().speed_m_s > 0.1);
}

#[test]
fn a_busy_processor_loses_bytes_beyond_its_receiver_and_says_so() {
    // A compass read takes 50 ms, in which 48 characters come; the receiver holds 10.
    let sensor = "[robots.sensors.slow]\nkind = \"compass\"\nperiod_ms = 60.0\nacquisition_us = 50000.0";
    let mut world = world(&robot(UART, sensor));
    run(&mut world, 300, 0.1, 0.1);
    let downlink = *world.robot(0).downlink();
    assert!(downlink.overrun_bytes > 100, "{downlink:?}");
    assert!(downlink.bad_frames > 0, "{downlink:?}");
    assert!(world.robot(0).commands() > 10, "some commands still get through: {downlink:?}");
}

#[test]
fn readings_that_come_faster_than_the_processor_are_missed_and_counted() {
    let sensor = "[robots.sensors.slow]\nkind = \"compass\"\nperiod_ms = 10.0\nacquisition_us = 25000.0";
    let mut world = world(&robot("{ kind = \"ideal\" }", sensor));
    run(&mut world, 300, 0.0, 0.0);
    let sensor = world.robot(0).sensors().next().unwrap();
    assert!(sensor.samples.abs_diff(120) < 10, "{sensor:?}");
    assert!((sensor.samples + sensor.missed).abs_diff(300) < 4, "{sensor:?}");
}

#[test]
fn more_frames_than_the_line_can_carry_wait_for_it_and_are_missed() {
    let mut world = world_with(WANDER, &["robots.robot.link.baud=4800"]);
    run(&mut world, 1000, 0.0, 0.0);
    let robot = world.robot(0);
    // 4800 baud 8N1 carry 480 bytes a second; frames of up to 19 bytes each 20 ms would be 950.
    assert!((4790..=4800).contains(&robot.uplink().bytes), "{:?}", robot.uplink());
    assert!((250..280).contains(&robot.uplink().messages), "{:?}", robot.uplink());
    let due = robot.uplink().messages + robot.frames_missed();
    assert!(due.abs_diff(500) < 8, "{due} of 500");
    assert_eq!(robot.uplink().bad_frames, 0);
}

#[test]
fn byte_errors_are_caught_by_the_checksum() {
    let mut world = world_with(WANDER, &["robots.robot.link.byte_error_rate=0.02"]);
    run(&mut world, 3000, 0.0, 0.0);
    let uplink = world.robot(0).uplink();
    assert!(uplink.corrupted_bytes > 400, "{uplink:?}");
    // 1500 frames of 19 bytes: a share of 0.98^19 = 0.68 is sound.
    assert!((0.64..0.72).contains(&(uplink.messages as f64 / 1500.0)), "{uplink:?}");
    assert!(uplink.bad_frames > 300, "{uplink:?}");
}

#[test]
fn a_command_that_is_no_number_is_not_obeyed() {
    let toml = robot("{ kind = \"ideal\" }", "").replace("motors = { signal_bits = 8 }", "");
    let mut world = world(&toml);
    for value in [f64::NAN, f64::INFINITY] {
        let bytes = command(world.robot(0).spec(), value, 0.5);
        let at = world.begin()[0].at;
        world.finish(&[Input { robot: 0, at, bytes: &bytes }]);
    }
    assert_eq!(world.robot(0).commands(), 0);
    assert_eq!(world.robot(0).downlink().bad_messages, 2);
    assert_eq!(world.robot(0).motion().speed_m_s, 0.0);
}

#[test]
fn a_signal_beyond_the_limit_is_not_obeyed_whoever_sends_it() {
    let toml = robot("{ kind = \"ideal\" }", "").replace("motors = { signal_bits = 8 }", "");
    let mut world = world(&toml);
    run(&mut world, 10, 0.0, 1.5);
    assert_eq!((world.robot(0).commands(), world.robot(0).downlink().bad_messages), (0, 10));
    run(&mut world, 10, 0.0, 1.0);
    assert_eq!(world.robot(0).commands(), 10);
}

#[test]
fn the_age_of_a_reading_is_the_truth_where_the_wire_cannot_tell_it() {
    // Sampled each 100 ms, sent 90 ms later: the wire's largest age is 25.5 ms.
    let late = "firmware = { period_ms = 100.0, phase_ms = 90.0 }\n[robots.sensors.c]\nkind = \"compass\"\nperiod_ms = 100.0";
    let mut world = world(&robot("{ kind = \"ideal\" }", late));
    for _ in 0..100 {
        world.begin();
        assert_eq!(
            world.robot(0).readings()[0].sampled_at,
            None,
            "an age at the end of its scale tells nothing"
        );
        world.finish(&[]);
    }
    let freshness = world.robot(0).sensors().next().unwrap().freshness;
    assert_eq!(
        (freshness.readable, freshness.ages.count(), freshness.ages.max_ns().unwrap()),
        (10, 10, 90_000_000)
    );
    // Bare messages have no age at all, and repeat old values.
    let bare = late
        .replace("{ ", "{ protocol = \"bare\", ")
        .replace("phase_ms = 90.0", "phase_ms = 0.0")
        .replace("period_ms = 100.0,", "period_ms = 50.0,");
    let mut world = crate::common::world(&robot("{ kind = \"ideal\" }", &bare));
    run(&mut world, 100, 0.0, 0.0);
    let freshness = world.robot(0).sensors().next().unwrap().freshness;
    assert_eq!(
        (freshness.readable, freshness.ages.count(), freshness.ages.max_ns().unwrap()),
        (20, 20, 50_000_000)
    );
}

#[test]
fn a_frame_never_claims_to_be_closed_after_it_has_arrived() {
    // Long frames are stuffed less than at worst, and framing takes its time.
    let mut more =
        String::from("microcontroller = { framing_us_per_byte = 100.0 }\nfirmware = { period_ms = 100.0 }\n");
    for i in 0..20 {
        more += &format!("[robots.sensors.o{i}]\nkind = \"odometer\"\nperiod_ms = 100.0\n");
    }
    let mut world = world(&robot("{ kind = \"ideal\" }", &more));
    let mut seen = 0;
    for _ in 0..2000 {
        let at = world.begin()[0].at;
        for reading in world.robot(0).readings().iter().filter(|reading| reading.readable) {
            let age = at.since(reading.sampled_at.unwrap_or(at));
            assert!(age < 200_000_000, "{age} ns old at {at:?}");
            seen += 1;
        }
        world.finish(&[]);
    }
    assert!(seen > 3000, "{seen}");
}

#[test]
fn silence_ends_a_bare_message_that_was_cut_short() {
    let firmware = "firmware = { protocol = \"bare\", mode = \"poll\", gap_ms = 20.0 }";
    let mut world = world(&robot(UART, firmware));
    let both = command(world.robot(0).spec(), 0.5, 0.5);
    for tick in 0..20 {
        let at = world.begin()[0].at;
        // Half a message, then a pause of 50 ms, then a whole one.
        let bytes = match tick {
            0 => &both[..1],
            5 => &both[..],
            _ => &[],
        };
        world.finish(&[Input { robot: 0, at, bytes }]);
    }
    assert_eq!(world.robot(0).commands(), 1);
    assert_eq!(world.robot(0).downlink().bad_messages, 1);
    assert_eq!(world.robot(0).signals().left, world.robot(0).signals().right);
}
