//! A microcontroller that is reset when its serial port is opened, and whose bootloader waits before its firmware starts.

use crate::common::{BODY, command, refusal, world};
use baudbot_sim::{Input, World};

/// A robot whose firmware starts after 0.2 s, on this link, which reads a compass every 10 ms.
fn robot(microcontroller: &str, link: &str, firmware: &str) -> World {
    world(&format!(
        "step_ms = 1.0\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         microcontroller = {{ {microcontroller} }}\nfirmware = {{ {firmware} }}\nlink = {{ {link} }}\n\
         [robots.sensors.c]\nkind = \"compass\"\nbits = 8\nperiod_ms = 10\nphase_ms = 3\nacquisition_us = 100\n"
    ))
}

const LINKS: [&str; 6] = [
    "kind = \"ideal\"",
    "kind = \"uart\", baud = 115200",
    "kind = \"uart\", baud = 115200, receive_depth = 4",
    "kind = \"uart\", baud = 115200, half_duplex = true, turnaround_us = 50",
    "kind = \"uart\", baud = 115200, adapter = { preset = \"ch340\" }",
    "kind = \"usb\"",
];

const STREAM: &str = "protocol = \"bare\", period_ms = 10, phase_ms = 5";

/// Sends a command in each fifth tick; returns how many bytes were sent.
fn run(world: &mut World, ticks: u64) -> u64 {
    let bytes = command(world.robot(0).spec(), 0.5, 0.5);
    let mut sent = 0;
    for tick in 0..ticks {
        let at = world.begin()[0].at;
        let speaks = tick % 5 == 0;
        sent += if speaks { bytes.len() as u64 } else { 0 };
        world.finish(&[Input { robot: 0, at, bytes: if speaks { &bytes } else { &[] } }]);
    }
    sent
}

#[test]
fn until_the_firmware_starts_nothing_is_read_sent_or_obeyed_and_what_is_sent_to_it_is_lost() {
    for link in LINKS {
        let mut world = robot("bootloader_s = 0.2", link, STREAM);
        let sent = run(&mut world, 190);
        let robot = world.robot(0);
        assert_eq!(robot.sensors().next().unwrap().samples, 0, "{link}");
        assert_eq!((robot.uplink().bytes, robot.commands(), robot.motion().speed_m_s), (0, 0, 0.0), "{link}");
        assert_eq!((robot.downlink().messages, robot.downlink().overrun_bytes), (0, 0), "{link}");
        let later = run(&mut world, 300);
        let robot = world.robot(0);
        let down = *robot.downlink();
        // All that came before is lost, and of what came at the start a part of a command, which is forgotten.
        assert!(down.lost_bytes + 8 >= sent && down.lost_bytes <= sent + 4, "{link}: {sent} {down:?}");
        assert_eq!(down.overrun_bytes + down.refused_bytes, 0, "{link}: {down:?}");
        assert!(robot.commands().abs_diff(later / 2) <= 4, "{link}: {} of {later}", robot.commands());
        // The compass falls due at 203, 213, … ms and the first message at 205 ms.
        assert!(robot.sensors().next().unwrap().samples.abs_diff(29) <= 1, "{link}");
        assert!(robot.uplink().messages.abs_diff(29) <= 1, "{link}: {:?}", robot.uplink());
        assert_eq!(robot.frames_missed(), 0, "{link}");
        assert!(robot.motion().speed_m_s > 0.01, "{link}");
    }
}

#[test]
fn schedules_count_from_the_start_of_the_firmware() {
    let first = |microcontroller: &str| {
        let mut world = robot(microcontroller, LINKS[0], STREAM);
        (0..1000).find_map(|_| {
            let at = world.begin()[0].at.as_ns();
            let has = world.robot(0).uplink().messages > 0;
            world.finish(&[]);
            has.then_some(at)
        })
    };
    assert_eq!(first("bootloader_s = 0"), Some(5_000_000));
    assert_eq!(first("bootloader_s = 0.2"), Some(205_000_000));
    assert_eq!(first("bootloader_s = 0.20037"), Some(205_370_000));
}

#[test]
fn a_poll_before_the_start_is_never_answered_and_one_after_it_is() {
    let mut world = robot("bootloader_s = 0.2", LINKS[1], "protocol = \"bare\", mode = \"poll\"");
    let bytes = command(world.robot(0).spec(), 0.0, 0.0);
    for tick in 0..400 {
        let at = world.begin()[0].at;
        let speaks = tick == 0 || tick == 300;
        world.finish(&[Input { robot: 0, at, bytes: if speaks { &bytes } else { &[] } }]);
        assert_eq!(world.robot(0).uplink().messages, u64::from(tick > 300), "{tick}");
    }
    assert_eq!(world.robot(0).downlink().lost_bytes, bytes.len() as u64);
}

#[test]
fn a_snapshot_before_the_start_has_the_same_future_and_may_be_restored() {
    for link in LINKS {
        let mut world = robot("bootloader_s = 0.2", link, STREAM);
        run(&mut world, 100);
        let saved = world.save();
        let loaded = World::load(world.scenario().clone(), &saved, world.hash());
        let mut other = loaded.unwrap_or_else(|error| panic!("{link}: {error}"));
        run(&mut world, 300);
        run(&mut other, 300);
        assert_eq!(world.hash(), other.hash(), "{link}");
        assert!(world.robot(0).commands() > 0, "{link}");
    }
}

#[test]
fn a_flood_before_the_start_does_not_pile_up() {
    for link in LINKS {
        let mut world = robot("bootloader_s = 60", link, STREAM);
        let mut held = 0;
        for tick in 0..2000 {
            let at = world.begin()[0].at;
            world.finish(&[Input { robot: 0, at, bytes: &[0x55; 10_000] }]);
            let down = world.robot(0).downlink();
            held = 10_000 * (tick + 1) - down.bytes - down.refused_bytes;
        }
        assert!(held <= 4096 + 10_000, "{held} over {link}");
    }
}

#[test]
fn a_bootloader_of_no_time_changes_no_bit() {
    let mut worlds = ["", "bootloader_s = 0.0"].map(|text| robot(text, LINKS[1], STREAM));
    worlds.iter_mut().for_each(|world| _ = run(world, 100));
    assert_eq!(worlds[0].hash(), worlds[1].hash());
}

#[test]
fn an_arduino_uno_starts_after_1_6_s_and_a_chip_that_is_only_powered_at_once() {
    let ns = |preset: &str| {
        let world = robot(&format!("preset = \"{preset}\""), LINKS[1], STREAM);
        world.robot(0).spec().processor.bootloader_ns
    };
    assert_eq!((ns("arduino-uno"), ns("atmega328p")), (1_600_000_000, 0));
}

#[test]
fn on_board_nothing_opens_a_serial_port() {
    let toml = format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nlink = {{ kind = \"onboard\" }}\n\
         microcontroller = {{ preset = \"arduino-uno\" }}\n"
    );
    let message = refusal(&toml);
    assert!(message.starts_with("robots[0].microcontroller.bootloader_s: "), "{message}");
    assert!(message.contains("on board nothing opens one") && message.contains("`atmega328p`"), "{message}");
    let long = toml.replace("preset = \"arduino-uno\"", "bootloader_s = 61").replace("onboard", "usb");
    assert_eq!(refusal(&long), "robots[0].microcontroller.bootloader_s: must be between 0 and 60, is 61");
}
