//! The interface with bytes in the format of its manuals, and with bytes of any kind.

use std::vec;
use std::vec::Vec;

use proptest::collection::vec as bytes_of;
use proptest::prelude::*;

use super::*;
use crate::codec::Terms;
use crate::encoding::Encoding;
use crate::layout::Layout;

/// The meaning of the bytes, command by command; `None` is a byte that is passed over.
fn meanings(version: Version, bytes: &[u8]) -> Vec<Option<std::string::String>> {
    let mut commands = Commands::new(version);
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(command) = commands.push(byte) {
            found.push(Command::parse(version, command).map(|command| std::format!("{command:?}")));
        }
    }
    found
}

/// The one command of these bytes.
fn one(version: Version, bytes: &[u8]) -> Command<'_> {
    let found = meanings(version, bytes);
    assert_eq!(found.len(), 1, "{bytes:?}: {found:?}");
    Command::parse(version, bytes).unwrap_or_else(|| panic!("{bytes:?}"))
}

#[test]
fn every_command_of_both_robots_is_understood() {
    for version in [Version::One, Version::Two] {
        for (bytes, command) in [
            (&[128][..], Command::Start),
            (&[129, 11], Command::Baud(11)),
            (&[130], Command::Safe),
            (&[131], Command::Safe),
            (&[132], Command::Full),
            (&[134], Command::Demo(134)),
            (&[135], Command::Demo(135)),
            (&[143], Command::Demo(143)),
            // The example of the manuals: backwards at 200 mm/s on a radius of 500 mm.
            (&[137, 255, 56, 1, 244], Command::Drive { velocity_mm_s: -200, radius_mm: 500 }),
            (&[137, 0, 100, 0x80, 0], Command::Drive { velocity_mm_s: 100, radius_mm: i16::MIN }),
            (&[138, 7], Command::Motors(7)),
            (&[139, 8, 0, 128], Command::Leds([8, 0, 128])),
            (&[140, 0, 1, 70, 0], Command::Song { number: 0, notes: &[70, 0] }),
            (&[141, 3], Command::Play(3)),
            (&[142, 35], Command::Sensors(35)),
            (&[144, 127, 0, 64], Command::MotorsPwm([127, 0, 64])),
            (&[145, 0, 200, 255, 56], Command::DriveDirect { right_mm_s: 200, left_mm_s: -200 }),
            (&[148, 2, 29, 13], Command::Stream(&[29, 13])),
            (&[148, 0], Command::Stream(&[])),
            (&[149, 2, 29, 13], Command::QueryList(&[29, 13])),
            (&[150, 0], Command::Resume(false)),
            (&[150, 1], Command::Resume(true)),
        ] {
            assert_eq!(one(version, bytes), command, "{version:?}");
        }
    }
}

#[test]
fn commands_of_one_robot_alone_are_understood_by_that_one() {
    for (bytes, command) in [
        (&[7][..], Command::Reset),
        (&[133], Command::Power),
        (&[136], Command::Demo(136)),
        (&[146, 0, 255, 255, 1], Command::DrivePwm { right: 255, left: -255 }),
        (&[162, 0x7f, 1], Command::ClockLeds([0x7f, 1])),
        (&[163, 1, 2, 3, 4], Command::Digits([1, 2, 3, 4])),
        (&[164, 65, 66, 67, 68], Command::Characters(*b"ABCD")),
        (&[165, 1], Command::Without(165)),
        (&[168, 1, 2, 3], Command::Without(168)),
        (&[173], Command::Stop),
    ] {
        assert_eq!(one(Version::Two, bytes), command);
    }
    for (bytes, command) in [
        (&[136, 2][..], Command::Demo(136)),
        (&[147, 1], Command::Without(147)),
        (&[151, 9], Command::Without(151)),
        (&[152, 3, 128, 132, 153], Command::Without(152)),
        (&[153], Command::Without(153)),
        (&[154], Command::Without(154)),
        (&[155, 10], Command::Without(155)),
        (&[156, 1, 144], Command::Without(156)),
        (&[157, 0, 90], Command::Without(157)),
        (&[158, 5], Command::Without(158)),
    ] {
        assert_eq!(one(Version::One, bytes), command);
    }
    // The other model's opcodes are none here, and neither are their data.
    assert_eq!(meanings(Version::One, &[7, 146, 173]), [None, None, None]);
    assert_eq!(meanings(Version::Two, &[152, 1, 2]), [None, None, None]);
    assert_eq!(meanings(Version::Two, &[167; 16]).len(), 1);
}

#[test]
fn bytes_that_are_no_opcode_are_passed_over_one_by_one() {
    let found = meanings(Version::Two, &[0, 255, 17, 128, 200, 142, 100]);
    let known: Vec<_> = found.iter().map(Option::is_some).collect();
    assert_eq!(known, [false, false, false, true, false, true]);
}

#[test]
fn a_song_of_more_than_sixteen_notes_is_cut_there() {
    let mut bytes = vec![140, 1, 200];
    bytes.extend([60, 8].repeat(16));
    let Command::Song { notes, .. } = one(Version::Two, &bytes) else { panic!("no song") };
    assert_eq!(notes.len(), 32);
}

#[test]
fn groups_are_as_long_as_both_manuals_say() {
    let both = [(0, 26), (1, 10), (2, 6), (3, 10), (4, 14), (5, 12), (6, 52)];
    for (id, len) in both {
        for version in [Version::One, Version::Two] {
            assert_eq!(listed_len(version, &[id]), len, "group {id}");
        }
    }
    for (id, len) in [(100, 80), (101, 28), (106, 12), (107, 9)] {
        assert_eq!(listed_len(Version::Two, &[id]), len, "group {id}");
        assert_eq!(group(Version::One, id), None);
    }
    assert_eq!(group(Version::One, 43), None);
    assert_eq!(group(Version::Two, 59), None);
    assert_eq!(Packet::of(Version::Two, 100), None);
}

#[test]
fn packets_have_their_numbers_and_the_high_byte_first() {
    for (packet, id) in Packet::ALL.iter().zip(7..) {
        assert_eq!(packet.id(), id);
        assert_eq!(Packet::of(Version::Two, id), Some(*packet));
    }
    let mut bytes = [0; 2];
    assert_eq!((Packet::Distance.put(-200, &mut bytes), bytes), (2, [0xff, 0x38]));
    assert_eq!(Packet::Distance.take(&bytes), Some(-200_i16 as u16));
    assert_eq!((Packet::Temperature.put(-3, &mut bytes), bytes[0]), (1, 0xfd));
    assert_eq!(Packet::Distance.put(1, &mut bytes[..1]), 0);
    assert_eq!(Packet::Distance.take(&[1]), None);
}

#[test]
fn the_example_of_a_stream_has_its_checksum() {
    // Of the manuals: packets 29 and 13, a cliff signal of 537 and no virtual wall (recalled).
    let read = |packet| if packet == Packet::CliffFrontLeftSignal { 0x0219 } else { 0 };
    let mut bytes = [0; 16];
    let len = write_stream(Version::Two, &[29, 13], read, &mut bytes);
    assert_eq!(bytes[..len], [19, 5, 29, 2, 25, 13, 0, 163]);
    assert_eq!(bytes[..len].iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)), 0);
    assert_eq!(len, stream_len(Version::Two, &[29, 13]));
}

#[test]
fn a_stream_is_found_behind_noise_and_a_wrong_sum_is_told() {
    let ids = [29, 13];
    let mut message = [0; 16];
    let len = write_stream(Version::Two, &ids, |_| 19, &mut message);
    let mut stream = Stream::new(Version::Two, &ids);
    let mut bytes = vec![7, 19, 19];
    bytes.extend(&message[..len]);
    let found: Vec<_> =
        bytes.iter().filter_map(|&byte| stream.push(byte).map(|found| found.map(<[u8]>::to_vec))).collect();
    let [Ok(payload)] = &found[..] else { panic!("{found:?}") };
    let payload = Payload { version: Version::Two, bytes: payload };
    assert_eq!(payload.packet(Packet::CliffFrontLeftSignal), Some(19));
    assert_eq!(payload.packet(Packet::VirtualWall), Some(19));
    assert_eq!(payload.packet(Packet::Wall), None);
    message[3] ^= 1;
    let last = message[..len].iter().filter_map(|&byte| stream.push(byte).map(|found| found.is_err())).last();
    assert_eq!(last, Some(true));
}

#[test]
fn an_opening_starts_the_interface_and_asks_for_a_stream() {
    let sensors = [("bumper_left", 0), ("encoders", 0), ("bumper_right", 0)];
    let places = sensors.map(|(name, component)| Signal::place(Version::Two, name, component));
    let level = Encoding::Level { bits: 1, min: 0.0, max: 1.0 };
    let layout = Layout { components: &[level; 3], counts: &[1; 3], motors: &[level; 2], ages: false };
    let terms = Terms { layout, places: &places };
    let mut bytes = [0; 8];
    assert_eq!(write_opening(&terms, &mut bytes), Some(6));
    assert_eq!(bytes, [128, 132, 148, 2, 7, 43, 0, 0]);
    assert_eq!(write_opening(&terms, &mut bytes[..5]), None);
}

#[test]
fn a_radius_becomes_speeds_of_the_wheels() {
    for (velocity, radius, expected) in [
        (200, i16::MIN, [200.0, 200.0]),
        (200, i16::MAX, [200.0, 200.0]),
        (200, -1, [200.0, -200.0]),
        (200, 1, [-200.0, 200.0]),
        // The centre goes round a circle of 470 mm: the left wheel 352.5, the right one 587.5 mm from its middle.
        (200, 470, [150.0, 250.0]),
        (200, -470, [250.0, 150.0]),
        (-200, 470, [-150.0, -250.0]),
        (500, 235, [250.0, 500.0]),
    ] {
        assert_eq!(wheels_mm_s(velocity, radius, 235.0), expected, "{velocity} mm/s, {radius} mm");
    }
}

#[test]
fn signals_become_drive_direct() {
    assert_eq!(drive_direct([-0.4, 0.4]), [145, 0, 200, 255, 56]);
    assert_eq!(drive_direct([9.0, -9.0]), [145, 254, 12, 1, 244]);
    assert_eq!(drive_direct([f64::NAN, 0.0011]), [145, 0, 1, 0, 0]);
}

#[test]
fn sensors_stand_in_their_packets() {
    let counter = Encoding::Counter { bits: 16 };
    let level = Encoding::Level { bits: 1, min: 0.0, max: 1.0 };
    let encoders = Signal::of(Version::Two, "encoders", 0).unwrap();
    assert_eq!(encoders.value(0xffff, counter), Some(-1.0));
    let [left, right] =
        ["bumper_left", "bumper_right"].map(|name| Signal::of(Version::One, name, 0).unwrap());
    assert_eq!((left.value(2, level), right.value(2, level)), (Some(1.0), Some(0.0)));
    // The first Create has no counters to be read.
    assert_eq!(Signal::of(Version::One, "encoders", 0), None);
    assert_eq!(Signal::of(Version::Two, "bumper_left", 1), None);
    let place = |name, component| Signal::place(Version::Two, name, component);
    let places = [place("bumper_left", 0), None, place("bumper_right", 0), place("encoders", 0)];
    let layout = Layout { components: &[level; 4], counts: &[1; 4], motors: &[level; 2], ages: false };
    assert_eq!(streamed(&Terms { layout, places: &places }).used(), [7, 43]);
}

#[test]
fn a_layout_must_fit_the_packets() {
    let places = [Signal::place(Version::Two, "cliff_left", 0), None];
    let level = |bits| Encoding::Level { bits, min: 0.0, max: 1.0 };
    let signal = Encoding::Signed { bits: 10, limit: 1.0 };
    let found = |components: &[Encoding; 2], motors: &[Encoding]| {
        let layout = Layout { components, counts: &[1, 1], motors, ages: false };
        check(&Terms { layout, places: &places })
    };
    assert_eq!(found(&[level(12), Encoding::Float64], &[signal; 2]), Ok(()));
    assert!(found(&[level(10), level(8)], &[signal; 2]).is_err());
    assert!(found(&[Encoding::Float64, level(8)], &[signal; 2]).is_err());
    assert!(found(&[level(12), level(8)], &[signal; 3]).is_err());
}

proptest! {
    #[test]
    fn bytes_of_any_kind_are_cut_into_commands_and_come_to_an_end(
        second in any::<bool>(), bytes in bytes_of(any::<u8>(), 0..2000),
    ) {
        let version = if second { Version::Two } else { Version::One };
        let (new, mut commands, mut total) = (Commands::new(version), Commands::new(version), 0);
        for &byte in &bytes {
            if let Some(command) = commands.push(byte) {
                total += command.len();
                let _ = Command::parse(version, command);
            }
            prop_assert!(new.may_become(&commands));
        }
        prop_assert!(total <= bytes.len() && bytes.len() - total < MAX_COMMAND);
        let understood = (0..=MAX_COMMAND).any(|_| {
            commands.push(128).is_some_and(|command| Command::parse(version, command) == Some(Command::Start))
        });
        prop_assert!(understood, "it never listens again");
    }

    #[test]
    fn a_stream_survives_any_bytes_before_it(noise in bytes_of(any::<u8>(), 0..600), value in any::<i32>()) {
        let ids = [7, 28, 100];
        let mut stream = Stream::new(Version::Two, &ids);
        let mut message = [0; 128];
        let len = write_stream(Version::Two, &ids, |_| value, &mut message);
        for &byte in &noise {
            let _ = stream.push(byte);
        }
        prop_assert!(Stream::new(Version::Two, &ids).may_become(&stream));
        // Bytes that look like the beginning of a message may cost the next one.
        let found = message[..len].repeat(3).iter().filter(|&&byte| matches!(stream.push(byte), Some(Ok(_)))).count();
        prop_assert!(found >= 1, "{found}");
    }

    #[test]
    fn payloads_of_any_bytes_are_read(bytes in bytes_of(any::<u8>(), 0..255)) {
        let payload = Payload { version: Version::Two, bytes: &bytes };
        for packet in Packet::ALL {
            let _ = payload.packet(*packet);
        }
    }

    #[test]
    fn a_reader_survives_being_saved(bytes in bytes_of(any::<u8>(), 0..300)) {
        let mut commands = Commands::new(Version::Two);
        for &byte in &bytes {
            let _ = commands.push(byte);
        }
        let saved = postcard::to_allocvec(&commands).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Commands>(&saved).unwrap(), commands);
    }
}
