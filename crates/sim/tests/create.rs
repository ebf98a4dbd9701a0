//! A robot with the Open Interface of an iRobot Create: what bytes make it do, and what it answers.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::common::{refusal, tick, world, world_with};

use baudbot_sim::{Input, Intervention, Pose, World};
use baudbot_wire::create::{Packet, Payload, Stream, Version, group};

/// A Create in the open with ticks of 1 ms, without noise and with these fields.
fn robot(preset: &str, fields: &str) -> String {
    format!("noise = false\nstep_ms = 1.0\n[[robots]]\nname = \"c\"\npreset = \"{preset}\"\n{fields}\n")
}

fn create_2() -> World {
    world(&robot("create-2", ""))
}

/// The bytes that come in so many ticks, each with the number of its tick, when this is written in the first of them.
fn hear(world: &mut World, ticks: u64, said: &[u8]) -> Vec<(u64, u8)> {
    let mut heard = Vec::new();
    let mut said = said;
    for _ in 0..ticks {
        let number = world.tick();
        let turn = world.begin().first().copied();
        heard.extend(world.robot(0).unread().iter().map(|&byte| (number, byte)));
        match turn {
            Some(turn) => world.finish(&[Input { robot: 0, at: turn.at, bytes: std::mem::take(&mut said) }]),
            None => world.finish(&[]),
        }
    }
    assert!(said.is_empty(), "nobody could write");
    heard
}

fn say(world: &mut World, ticks: u64, said: &[u8]) -> Vec<u8> {
    hear(world, ticks, said).into_iter().map(|(_, byte)| byte).collect()
}

/// The value of a packet that is asked for.
fn ask(world: &mut World, packet: Packet) -> u16 {
    let answer = say(world, 5, &[142, packet.id()]);
    assert_eq!(answer.len(), packet.size(), "{packet:?}: {answer:?}");
    packet.take(&answer).unwrap()
}

fn place(world: &World) -> [f64; 2] {
    let position = world.robot(0).motion().pose.position;
    [position.x, position.y]
}

fn drive_direct(right: i16, left: i16) -> Vec<u8> {
    [&[145][..], &right.to_be_bytes(), &left.to_be_bytes()].concat()
}

#[test]
fn drive_direct_of_200_mm_s_goes_200_mm_in_a_second() {
    for preset in ["create-1", "create-2"] {
        let mut world = world(&robot(preset, ""));
        say(&mut world, 1000, &[&[128, 131][..], &drive_direct(200, 200)].concat());
        let before = place(&world);
        say(&mut world, 1000, &[]);
        let way = place(&world)[0] - before[0];
        assert!((way - 0.2).abs() < 1e-3, "{preset}: {way}");
        assert!(place(&world)[1].abs() < 1e-6, "{preset}");
    }
}

#[test]
fn a_radius_and_a_pulse_width_drive_as_they_should() {
    // On a radius of 470 mm to the left at 200 mm/s: 0.2 / 0.47 rad/s.
    for (command, speed, turn) in [
        (&[137, 0, 200, 1, 214][..], 0.2, 0.2 / 0.47),
        (&[137, 0, 200, 0x80, 0], 0.2, 0.0),
        (&[137, 0, 100, 0, 1], 0.0, 0.1 / 0.1175),
        (&[137, 0, 100, 255, 255], 0.0, -0.1 / 0.1175),
        (&[146, 0, 51, 0, 51], 0.1, 0.0),
        (&[146, 255, 205, 0, 51], 0.0, -0.1 / 0.1175),
    ] {
        let mut world = create_2();
        say(&mut world, 2000, &[&[128, 132], command].concat());
        let motion = world.robot(0).motion();
        assert!((motion.speed_m_s - speed).abs() < 2e-3, "{command:?}: {} m/s", motion.speed_m_s);
        assert!((motion.turn_rate_rad_s - turn).abs() < 0.01, "{command:?}: {}", motion.turn_rate_rad_s);
    }
}

#[test]
fn a_stream_comes_every_15_ms_with_a_right_checksum_until_it_pauses() {
    let mut world = create_2();
    let ids = [7, 43, 44, 35];
    let heard = hear(&mut world, 1500, &[&[128, 131, 148, 4][..], &ids].concat());
    let mut stream = Stream::new(Version::Two, &ids);
    let mut ends = Vec::new();
    for (tick, byte) in heard {
        let Some(found) = stream.push(byte) else { continue };
        let payload = Payload { version: Version::Two, bytes: found.expect("the checksum is right") };
        assert_eq!(payload.packet(Packet::OiMode), Some(2));
        ends.push(tick);
    }
    assert!((99..=100).contains(&ends.len()), "{}", ends.len());
    let apart: Vec<_> = ends.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(apart.iter().all(|apart| *apart == 15), "{apart:?}");
    assert_eq!(world.robot(0).uplink().bad_frames, 0);
    say(&mut world, 20, &[150, 0]);
    assert_eq!(say(&mut world, 100, &[]), [] as [u8; 0]);
    assert_eq!(ask(&mut world, Packet::StreamPackets), 4);
    assert_eq!(say(&mut world, 32, &[150, 1]).iter().filter(|&&byte| byte == 19).count(), 2);
}

#[test]
fn group_100_has_80_bytes_and_a_first_create_has_52() {
    for (preset, group, len) in [("create-2", 100, 80), ("create-2", 6, 52), ("create-1", 6, 52)] {
        let mut world = world(&robot(preset, ""));
        assert_eq!(say(&mut world, 30, &[128, 142, group]).len(), len, "{preset}, {group}");
    }
    let mut first = world(&robot("create-1", ""));
    assert_eq!(say(&mut first, 30, &[128, 142, 100, 142, 43, 142, 35]), [1]);
}

/// The field of group 100 at this packet.
fn field(answer: &[u8], wanted: Packet) -> u16 {
    let packets = group(Version::Two, 100).unwrap();
    let before = packets.iter().take_while(|packet| **packet != wanted);
    wanted.take(&answer[before.map(|packet| packet.size()).sum::<usize>()..]).unwrap()
}

#[test]
fn the_bytes_of_pycreate2_drive_it_and_are_answered() {
    let mut world = create_2();
    // start(), and half a second.
    say(&mut world, 500, &[128]);
    // safe(): and then each of four songs is one note of no length.
    say(&mut world, 500, &[131]);
    for song in 0..4 {
        say(&mut world, 1, &[140, song, 1, 70, 0]);
        say(&mut world, 1, &[141, song]);
    }
    say(&mut world, 100, &[]);
    // drive_direct(100, 100), led(8), digit_led_ascii("ABCD"), get_sensors().
    say(&mut world, 1000, &[145, 0, 100, 0, 100]);
    say(&mut world, 1, &[139, 8, 0, 0]);
    say(&mut world, 1, &[164, 65, 66, 67, 68]);
    let answer = say(&mut world, 15, &[142, 100]);
    assert_eq!(answer.len(), 80);
    assert_eq!(field(&answer, Packet::OiMode), 2);
    assert_eq!(field(&answer, Packet::RequestedRight), 100);
    assert_eq!(field(&answer, Packet::SongPlaying), 0);
    let [x, _] = place(&world);
    assert!((f64::from(field(&answer, Packet::Distance)) - x * 1e3).abs() < 4.0, "{x}");
    let counts = f64::from(field(&answer, Packet::EncoderLeft));
    assert!((counts / 509.0 * TAU * 0.036 - x).abs() < 4e-3, "{counts} counts, {x} m");
    assert_eq!(field(&answer, Packet::CliffFrontLeftSignal), 4095);
    assert_eq!(field(&answer, Packet::Capacity), 3000);
    assert!((14_000..18_000).contains(&field(&answer, Packet::Voltage)), "{:?}", &answer[17..19]);
    // drive_stop(), stop().
    say(&mut world, 500, &[145, 0, 0, 0, 0]);
    assert!(world.robot(0).motion().speed_m_s.abs() < 0.01);
    say(&mut world, 500, &[173]);
    assert_eq!(say(&mut world, 30, &[142, 100]), [] as [u8; 0]);
    assert_eq!(world.robot(0).downlink().bad_messages, 0);
    // reset() reads a second later. The program takes 128 bytes of the text.
    let text = say(&mut world, 1100, &[7]);
    assert!(text.starts_with(b"bl-start\r\nSTR730"), "{text:?}");
}

#[test]
fn a_query_list_is_answered_in_its_order_without_a_header() {
    let mut world = create_2();
    assert_eq!(say(&mut world, 10, &[128, 149, 3, 35, 13, 35]), [1, 0, 1]);
    // Bytes that are no opcode cost nothing.
    assert_eq!(say(&mut world, 10, &[0, 255, 142, 35, 3]), [1]);
    assert_eq!(world.robot(0).downlink().bad_messages, 3);
}

#[test]
fn actuators_obey_in_safe_and_full_only() {
    for (mode, obeys) in [(&[][..], false), (&[128], false), (&[128, 131], true), (&[128, 132], true)] {
        let mut world = create_2();
        say(&mut world, 600, &[mode, &drive_direct(200, 200)].concat());
        assert_eq!(place(&world)[0] > 0.01, obeys, "{mode:?}");
    }
    // Passive stops what moved.
    let mut world = create_2();
    say(&mut world, 600, &[&[128, 132][..], &drive_direct(200, 200)].concat());
    say(&mut world, 2000, &[128]);
    assert!(world.robot(0).motion().speed_m_s.abs() < 1e-3);
}

/// A pit: the floor from x = 0.6 m on.
const PIT: &str = "[arena]\n[[arena.zones]]\nname = \"pit\"\nfloor = 0.0\n\
                   points_m = [[0.6, -2.0], [3.0, -2.0], [3.0, 2.0], [0.6, 2.0]]\n";

#[test]
fn safe_stops_at_a_cliff_and_full_does_not() {
    for (mode, stops) in [(131, true), (132, false)] {
        let mut world = world(&format!("{}{PIT}", robot("create-2", "")));
        say(&mut world, 5000, &[&[128, mode][..], &drive_direct(200, 200)].concat());
        let [x, _] = place(&world);
        assert_eq!(x < 0.6, stops, "{x}");
        assert_eq!(ask(&mut world, Packet::OiMode), if stops { 1 } else { 3 });
        if stops {
            assert_eq!(ask(&mut world, Packet::CliffFrontRight), 1);
            // The robot may go backwards, in Safe again, and not forwards.
            let backwards = [&[131][..], &drive_direct(-100, -100)].concat();
            say(&mut world, 1000, &backwards);
            assert!(place(&world)[0] < x - 0.02, "{:?}", place(&world));
            assert_eq!(ask(&mut world, Packet::OiMode), 2);
        }
    }
}

#[test]
fn safe_ends_when_the_robot_is_taken_up_and_full_does_not() {
    for (mode, after) in [(131, 1), (132, 3)] {
        let mut world = create_2();
        say(&mut world, 1000, &[&[128, mode][..], &drive_direct(200, 200)].concat());
        let pose = Pose::new(-1.0, 0.0, 0.0);
        world.intervene(&Intervention::PlaceRobot { robot: "c".to_owned(), pose }).unwrap();
        say(&mut world, 1000, &[]);
        assert_eq!(ask(&mut world, Packet::OiMode), after);
        assert_eq!(place(&world)[0] > -0.95, after == 3, "{:?}", place(&world));
    }
}

#[test]
fn safe_ends_when_it_is_charged() {
    let charger =
        "[arena]\n[[arena.zones]]\nname = \"dock\"\ncharger_w = 40.0\nx_m = 0.6\ny_m = 0.0\nradius_m = 0.2\n";
    let low = robot("create-2", "battery = { charge = 0.5 }");
    let mut world = world(&format!("{low}{charger}"));
    say(&mut world, 6000, &[&[128, 131][..], &drive_direct(150, 150)].concat());
    assert!((0.4..0.55).contains(&place(&world)[0]), "{:?}", place(&world));
    assert_eq!(ask(&mut world, Packet::OiMode), 1);
    assert_eq!(ask(&mut world, Packet::ChargingSources), 2);
    assert_eq!(ask(&mut world, Packet::ChargingState), 2);
    assert!((ask(&mut world, Packet::Current) as i16) > 0);
}

#[test]
fn way_and_turn_are_told_since_they_were_last_asked_for() {
    let mut world = create_2();
    say(&mut world, 2000, &[&[128, 132][..], &drive_direct(200, 200)].concat());
    say(&mut world, 1000, &drive_direct(0, 0));
    let x = place(&world)[0];
    let way = ask(&mut world, Packet::Distance) as i16;
    assert!((f64::from(way) - x * 1e3).abs() < 3.0, "{way} mm, {x} m");
    assert_eq!(ask(&mut world, Packet::Distance), 0);
    // Backwards and clockwise.
    say(&mut world, 1000, &drive_direct(-200, -200));
    say(&mut world, 1000, &drive_direct(0, 0));
    let moved = (place(&world)[0] - x) * 1e3;
    let way = ask(&mut world, Packet::Distance) as i16;
    assert!((f64::from(way) - moved).abs() < 3.0, "{way}, {moved}");
    say(&mut world, 1000, &drive_direct(-100, 100));
    say(&mut world, 1000, &drive_direct(0, 0));
    let turned = world.robot(0).motion().pose.heading.to_degrees();
    let angle = ask(&mut world, Packet::Angle) as i16;
    assert!(angle < -30 && (f64::from(angle) - turned).abs() < 2.0, "{angle}, {turned}");
}

#[test]
fn bumpers_have_their_bits() {
    let wall = "[arena]\n[[arena.circles]]\nname = \"post\"\nx_m = 0.5\ny_m = 0.12\nradius_m = 0.05\n";
    let mut world = world(&format!("collision = \"stop-robot\"\n{}{wall}", robot("create-2", "")));
    say(&mut world, 4000, &[&[128, 131][..], &drive_direct(200, 200)].concat());
    assert_eq!(ask(&mut world, Packet::BumpsWheelDrops), 2);
}

#[test]
fn a_song_is_played_for_its_time() {
    let mut world = create_2();
    // A half and a quarter of a second.
    say(&mut world, 10, &[128, 131, 140, 2, 2, 60, 32, 64, 16, 141, 2]);
    assert_eq!((ask(&mut world, Packet::SongPlaying), ask(&mut world, Packet::SongNumber)), (1, 2));
    say(&mut world, 700, &[]);
    assert_eq!(ask(&mut world, Packet::SongPlaying), 1);
    say(&mut world, 50, &[]);
    assert_eq!(ask(&mut world, Packet::SongPlaying), 0);
}

#[test]
fn another_baud_rate_is_that_of_the_cable_from_the_end_of_the_tick_on() {
    let mut world = create_2();
    let baud = |world: &World| world.robot(0).spec().link.baud();
    assert_eq!((say(&mut world, 30, &[128, 142, 35]), baud(&world)), (vec![1], Some(115_200)));
    say(&mut world, 4, &[129, 0]);
    assert_eq!(baud(&world), Some(300));
    // Two bytes of a question and the answer take 10 bits each at 300 baud: 100 ms.
    assert_eq!(say(&mut world, 98, &[142, 35]), [] as [u8; 0]);
    assert_eq!(say(&mut world, 8, &[]), [1]);
    // A value that it cannot have changes nothing, and a reset leaves it alone.
    say(&mut world, 200, &[129, 12]);
    // The text of the command takes 5 s.
    say(&mut world, 8000, &[7]);
    assert_eq!(baud(&world), Some(300));
    let saved = World::load(world.origin().clone(), &world.save(), world.hash()).unwrap();
    assert_eq!(baud(&saved), Some(300));
    say(&mut world, 200, &[128, 129, 5]);
    assert_eq!(baud(&world), Some(9600));
}

/// A random byte of a simple generator, so that the test can be rebuilt elsewhere.
fn noise(seed: &mut u64) -> u8 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 56) as u8
}

#[test]
fn a_million_bytes_of_any_kind_harm_nothing_and_it_still_answers() {
    for preset in ["create-1", "create-2"] {
        let mut world =
            world_with(&robot(preset, "link = { kind = \"ideal\" }"), &["step_ms=100.0", "substeps=20"]);
        let (mut seed, mut largest) = (1, 0);
        for _ in 0..1000 {
            let bytes: Vec<_> = (0..1000).map(|_| noise(&mut seed)).collect();
            let turn = world.begin().first().copied();
            let inputs = turn.map(|turn| Input { robot: 0, at: turn.at, bytes: &bytes });
            world.finish(inputs.as_slice());
            largest = largest.max(world.save().len());
        }
        assert!(largest < 512 << 10, "{largest}");
        // The robot's wait ends, and then the interface receives.
        say(&mut world, 20, &[0; 300]);
        let mut answer = String::new();
        write!(answer, "{:?}", say(&mut world, 20, &[128, 148, 0, 142, 35])).unwrap();
        assert!(answer.ends_with("1]"), "{preset}: {answer}");
    }
}

#[test]
fn a_brain_of_messages_drives_it_and_is_told() {
    let mut world = world(&robot("create-2", "start = { x_m = 1.0 }"));
    for _ in 0..200 {
        tick(&mut world, 0.4, 0.4);
    }
    let view = world.robot(0);
    assert!(view.commands() > 150, "{}", view.commands());
    let reading = |name: &str| {
        let i = view.spec().sensors.iter().position(|sensor| sensor.name == name).unwrap();
        view.readings()[i].values.to_vec()
    };
    let counts = reading("encoders");
    let way = (place(&world)[0] - 1.0) / TAU / 0.036 * 509.0;
    assert!((counts[0] - way).abs() < 15.0 && counts[0] == counts[1], "{counts:?}, {way}");
    assert_eq!((reading("bumper_left"), reading("cliff_left")), (vec![0.0], vec![1.0]));
    let battery = reading("battery");
    let (real, state) = view.battery().unwrap();
    assert!((battery[0] - state.terminal_v(real)).abs() < 0.2, "{battery:?}");
    assert!((battery[1] - 1.0).abs() < 1e-3, "{battery:?}");
    assert_eq!(view.uplink().bad_frames, 0);
}

#[test]
fn a_copy_of_a_world_goes_on_alike() {
    let mut world = create_2();
    say(&mut world, 37, &[128, 131, 148, 2, 100, 19, 142, 6, 145, 0, 100]);
    let mut copy = world.clone();
    let [one, other] = [&mut world, &mut copy].map(|world| (say(world, 100, &[0, 100]), world.hash()));
    assert_eq!(one, other);
    assert!(!one.0.is_empty());
}

#[test]
fn what_the_interface_cannot_tell_is_refused() {
    for (fields, problem) in [
        ("sensors.compass = { kind = \"compass\", bits = 8 }", "has no packet for sensor `compass`"),
        ("sensors.cliff_left = { bits = 8 }", "in 12 bits"),
        ("actuators.lamp = { kind = \"lamp\", intensity_cd = 1.0 }", "no command for actuators"),
        ("firmware.mode = \"poll\"", "must be \"stream\""),
        ("firmware.ages = true", "carries no ages"),
    ] {
        let refused = refusal(&robot("create-2", fields));
        assert!(refused.contains(problem), "{fields}: {refused}");
    }
    // The encoders of a first Create are for its motors.
    let first = world(&robot("create-1", ""));
    // Start, Full, and a stream of so many packets.
    let packets = |world: &World| crate::common::opening(world.robot(0).spec())[4..].to_vec();
    assert_eq!(packets(&first), [7, 28, 29, 30, 31, 22, 25]);
    assert_eq!(packets(&create_2()), [43, 44, 7, 28, 29, 30, 31, 22, 25]);
}
