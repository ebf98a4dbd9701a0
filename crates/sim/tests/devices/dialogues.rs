//! Devices that answer on a cable of their own.

use std::f64::consts::TAU;

use baudbot_sim::time::SimTime;
use baudbot_sim::{Input, World};
use baudbot_wire::scip;

use crate::common::{refusal, world};
use crate::devices::scene::{block, named, scene, view, wall};

const POLLED: &str = "firmware = { mode = \"poll\" }";
const FAST: &str = "{ kind = \"uart\", baud = 750000 }";
const SLOW: &str = "{ kind = \"uart\", baud = 19200 }";

/// An URG-04LX on this cable, with more fields of its port.
fn urg(link: &str, more: &str) -> String {
    let opening = TAU * 681.0 / 1024.0;
    let laser = format!(
        "kind = \"laser\"\nmount = {{}}\nopening_rad = {opening}\nrays = 682\nmin_m = 0.02\nrange_m = 5.6\nsweep_ms = 66.6\n\
         clock = {{ period_ms = 100.0, phase_ms = 0.0 }}\nport = {{ link = {link}, first_step = 44{more} }}"
    );
    scene(&(wall(1.5) + &block("left", [-3.0, 2.0, 1.0, 2.1], "")), POLLED, &named("s", &laser))
}

fn asked(link: &str) -> World {
    world(&urg(link, ", dialogue = \"asked\""))
}

/// All that comes in so many ticks of 10 ms, at whose start a program writes this.
fn talk(world: &mut World, ticks: usize, command: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for tick in 0..ticks {
        world.begin();
        bytes.extend(world.robot(0).unread_of_ports().next().unwrap().1);
        if tick == 0 && !command.is_empty() {
            assert!(world.write_port(0, 0, world.time(), command));
        }
        world.finish(&[]);
    }
    bytes
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The messages in these bytes, each to its second line feed.
fn messages(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut all = Vec::new();
    while let Some(end) = scip::message_end(bytes) {
        let (message, rest) = bytes.split_at(end);
        all.push(message);
        bytes = rest;
    }
    assert_eq!(bytes, b"", "a rest");
    all
}

#[test]
fn a_device_that_is_asked_is_silent_until_then() {
    let mut world = asked(FAST);
    assert_eq!(talk(&mut world, 100, b""), b"");
    assert_eq!(view(&world, "s").missed, 0, "nobody wanted those scans");
    assert_eq!(text(&talk(&mut world, 3, b"BM\n")), "BM\n00P\n\n");
    let parameters = text(&talk(&mut world, 3, b"PP\n"));
    let own = "DMIN:20;4\nDMAX:5600;_\nARES:1024;\\\nAMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";
    assert!(parameters.ends_with(own), "{parameters}");
}

#[test]
fn scans_are_those_of_the_world_a_tenth_of_a_second_apart() {
    let mut world = asked(FAST);
    let bytes = talk(&mut world, 60, b"MD0044072501003\n");
    let all = messages(&bytes);
    assert_eq!(all[0], b"MD0044072501003\n00P\n\n");
    let scans: Vec<_> = all[1..].iter().map(|message| scip::parse(message).unwrap()).collect();
    // The laser is lit within the scan that began at 0, which does not count.
    let told: Vec<_> = scans.iter().map(|scan| (scan.time_ms, scan.remaining)).collect();
    assert_eq!(told, [(100, 2), (200, 1), (300, 0)]);
    let truth = view(&world, "s").sample;
    assert!(truth[341] > 1.49 && truth.contains(&-1.0));
    for scan in &scans {
        for (i, (told, &truth)) in scan.ranges_mm().zip(truth).enumerate() {
            match told {
                Some(mm) => {
                    assert!((f64::from(mm) - truth * 1e3).abs() <= 0.5 + 1e-9, "{i}: {mm} and {truth}");
                }
                None => assert_eq!(truth, -1.0, "{i}"),
            }
        }
    }
    assert_eq!(world.robot(0).readings()[0].values.len(), 682, "they are the sensor's readings, too");
    assert_eq!(world.robot(0).port(0).unwrap().bad_frames, 0);
}

#[test]
fn get_is_answered_with_the_newest_scan_and_only_with_the_laser_lit() {
    let mut world = asked(FAST);
    assert_eq!(text(&talk(&mut world, 52, b"GD0044072501\n")), "GD0044072501\n10Q\n\n");
    // At 520 ms; the first scan that begins with the laser lit is over at 666.6 ms, and 2100 characters take 28 ms.
    let waited = talk(&mut world, 3, b"BM\n").len();
    assert_eq!(waited, 8);
    assert_eq!(talk(&mut world, 11, b"GD0044072501;x\n"), b"", "until 660 ms");
    let bytes = talk(&mut world, 9, b"");
    let head = text(&bytes[..21]);
    assert!(head.starts_with("GD0044072501;x\n00P\n"), "{head}");
    let cluster = talk(&mut world, 5, b"GD0384038400\n");
    // 600 ms, and 1.5 m straight ahead.
    let expected = b"GD0384038400\n00P\n009H";
    assert_eq!(text(&cluster[..21]), text(expected));
    assert_eq!(world.robot(0).port(0).unwrap().bad_frames, 0, "an answer is no bad message");
}

#[test]
fn qt_ends_the_scans() {
    let mut world = asked(FAST);
    let bytes = talk(&mut world, 100, b"MS0044072500000\n");
    assert!(messages(&bytes).len() >= 9);
    let last = talk(&mut world, 30, b"QT\n");
    assert!(text(&last).ends_with("QT\n00P\n\n"), "{}", text(&last));
    assert!(messages(&last).len() <= 2, "a scan that was on its way, and the answer");
    assert_eq!(talk(&mut world, 50, b""), b"");
}

#[test]
fn an_interval_leaves_scans_out_and_a_slow_cable_too() {
    let mut world = asked(FAST);
    let bytes = talk(&mut world, 101, b"MD0044072501200\n");
    let times: Vec<_> =
        messages(&bytes)[1..].iter().map(|message| scip::parse(message).unwrap().time_ms).collect();
    assert_eq!(times, [100, 400, 700]);
    let mut world = asked(SLOW);
    talk(&mut world, 1000, b"MD0044072501000\n");
    let port = world.robot(0).port(0).unwrap();
    // 2137 characters take 1.113 s, so a scan in twelve is sent.
    assert!((7..=9).contains(&port.messages), "{port:?}");
    assert!(view(&world, "s").missed > 80, "{}", view(&world, "s").missed);
}

#[test]
fn ss_changes_the_rate_behind_its_answer_and_rs_brings_it_back() {
    let mut world = asked(SLOW);
    assert_eq!(world.port_baud(0, 0), Some(19_200));
    // Written at the brain's step, the tick's end: 9 characters down take 4.7 ms, then 1 ms, and 15 up 7.8 ms.
    let before = world.time();
    assert_eq!(talk(&mut world, 2, b"SS115200\n").len(), 8, "characters that have come 10 ms later: not all");
    assert_eq!(world.port_baud(0, 0), Some(19_200), "the rest is on the wire at the rate before");
    assert_eq!(text(&talk(&mut world, 2, b"")).len(), 6);
    assert_eq!(world.port_baud(0, 0), Some(115_200));
    assert_eq!(world.time(), before + 40_000_000);
    assert_eq!(text(&talk(&mut world, 3, b"SS115200\n")), "SS115200\n03S\n\n");
    let bytes = talk(&mut world, 50, b"MD0044072501001\n");
    assert_eq!(bytes.len(), 21 + 2137, "at 115200 baud a scan is there in 0.19 s");
    assert_eq!(text(&talk(&mut world, 3, b"RS\n")), "RS\n00P\n\n");
    assert_eq!(world.port_baud(0, 0), Some(19_200));
    let mut usb = asked("{ kind = \"usb\" }");
    assert_eq!(text(&talk(&mut usb, 3, b"SS115200\n")), "SS115200\n00P\n\n", "accepted without an effect");
    assert_eq!(usb.port_baud(0, 0), None);
}

#[test]
fn with_a_driver_scans_are_those_of_a_device_that_speaks_by_itself() {
    for link in [FAST, "{ kind = \"ideal\" }", "{ kind = \"usb\" }"] {
        let mut by_itself = world(&urg(link, ""));
        let mut driven = world(&urg(link, ", dialogue = \"driver\""));
        let (own, all) = (talk(&mut by_itself, 100, b""), talk(&mut driven, 100, b""));
        let answers = "BM\n00P\n\nMD0044072501000\n00P\n\n";
        assert!(text(&all).starts_with(answers), "{link}: {}", text(&all[..40]));
        let (own, driven_scans) = (messages(&own), messages(&all[answers.len()..]));
        // The laser is lit behind the beginning of the first.
        assert_eq!(own[1..], driven_scans[..], "{link}");
        let reading = &driven.robot(0).readings()[0];
        assert_eq!(reading.values, by_itself.robot(0).readings()[0].values);
        assert_eq!(reading.sampled_at, by_itself.robot(0).readings()[0].sampled_at);
        assert_eq!(driven.robot(0).port(0).unwrap().bad_frames, 0);
    }
}

#[test]
fn a_driver_goes_on_asking_when_bytes_are_damaged() {
    for seed in 1..20 {
        let link = "{ kind = \"uart\", baud = 750000, byte_error_rate = 0.02 }";
        let mut world =
            world(&format!("seed = {seed}\n{}", urg(link, ", dialogue = \"driver\", characters = 2")));
        talk(&mut world, 300, b"");
        assert!(world.robot(0).port(0).unwrap().bytes > 10_000, "seed {seed}");
    }
}

#[test]
fn a_device_that_speaks_by_itself_hears_nothing() {
    let (mut alone, mut spoken_to) = (world(&urg(FAST, "")), world(&urg(FAST, "")));
    assert_eq!(talk(&mut alone, 50, b""), talk(&mut spoken_to, 50, b"QT\n"));
    assert_eq!(alone.hash(), spoken_to.hash());
    let mut gps = world(&scene(
        "",
        POLLED,
        &named("s", "kind = \"gps\"\nport = { link = { kind = \"uart\", baud = 4800 } }"),
    ));
    assert!(!talk(&mut gps, 200, b"$PSRF103,0,0,1,1*25\r\n").is_empty(), "it goes on");
}

#[test]
fn bytes_are_taken_only_within_a_tick_and_for_a_port_that_is_there() {
    let mut world = asked(FAST);
    assert!(!world.write_port(0, 0, SimTime::ZERO, b"BM\n"));
    world.begin();
    assert!(!world.write_port(1, 0, SimTime::ZERO, b"BM\n"));
    assert!(!world.write_port(0, 1, SimTime::ZERO, b"BM\n"));
    assert!(world.write_port(0, 0, SimTime::ZERO, b"BM\n"));
    world.finish(&[Input { robot: 0, at: SimTime::ZERO, bytes: b"" }]);
}

#[test]
fn the_order_of_calls_does_not_matter_and_a_saved_world_goes_on() {
    let later = SimTime::from_ns(9_500_000);
    let (mut one, mut other) = (asked(SLOW), asked(SLOW));
    one.begin();
    other.begin();
    one.write_port(0, 0, SimTime::ZERO, b"MD0044");
    one.write_port(0, 0, later, b"072501");
    other.write_port(0, 0, later, b"072501");
    other.write_port(0, 0, SimTime::ZERO, b"MD0044");
    let within = one.clone();
    assert_eq!(within.hash(), one.hash());
    let scenario = one.scenario().clone();
    let mut loaded = World::load(scenario.clone(), &one.save(), one.hash()).unwrap();
    for world in [&mut one, &mut other, &mut loaded] {
        world.finish(&[]);
    }
    assert_eq!(one.hash(), other.hash());
    assert_eq!(one.hash(), loaded.hash());
    // In the middle of a command, of an answer, of a scan.
    for (ticks, command) in
        [(1, &b"000\n"[..]), (1, b""), (25, b""), (5, b"GD"), (40, b"0044004401\nSS115200\n"), (130, b"")]
    {
        let mut again = World::load(scenario.clone(), &one.save(), one.hash()).unwrap();
        let bytes = talk(&mut one, ticks, command);
        assert_eq!(bytes, talk(&mut again, ticks, command));
        assert_eq!(one.hash(), again.hash());
    }
    assert!(one.robot(0).port(0).unwrap().messages > 0);
}

#[test]
fn a_million_random_bytes_do_no_harm() {
    let mut world = asked("{ kind = \"uart\", baud = 1000000 }");
    let mut state = 1u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let words = [
        &b"VV\n"[..],
        b"MD0044072501000\n",
        b"GD0044072501\n",
        b"BM\n",
        b"QT\n",
        b"\n",
        b"TM0\n",
        b"%ST\r\n",
    ];
    for tick in 0..1000 {
        let mut bytes = Vec::new();
        while bytes.len() < 1000 {
            if draw() % 2 == 0 {
                bytes.extend_from_slice(words[draw() % words.len()]);
            } else {
                bytes.push(draw() as u8);
            }
        }
        world.begin();
        world.write_port(0, 0, world.time(), &bytes);
        world.finish(&[]);
        let saved = world.save().len();
        assert!(saved < 60_000, "tick {tick}: {saved}");
    }
    let scenario = world.scenario().clone();
    World::load(scenario, &world.save(), world.hash()).unwrap();
    talk(&mut world, 100, b"\nTM2\n");
    talk(&mut world, 30, b"\nRS\n");
    assert!(text(&talk(&mut world, 5, b"BM\n")).ends_with("BM\n00P\n\n"));
}

#[test]
fn dialogues_that_cannot_be_are_refused() {
    let gps = "kind = \"gps\"\nport = { link = { kind = \"ideal\" }, dialogue = \"asked\" }";
    let error = refusal(&scene("", POLLED, &named("s", gps)));
    assert!(error.contains("port.dialogue") && error.contains("a sensor of kind `gps` has none"), "{error}");
    let error = refusal(&urg(FAST, ", model = \"ust-10lx\""));
    assert!(error.contains("port.model"), "{error}");
    let half = "{ kind = \"uart\", baud = 19200, turnaround_us = 10.0 }";
    let error = refusal(&urg(half, ", dialogue = \"driver\""));
    assert!(error.contains("dialogue") || error.contains("turnaround"), "{error}");
    let error = refusal(&urg(FAST, ", dialogue = \"loud\""));
    assert!(error.contains("asked"), "{error}");
}
