//! Brains that talk over what stands between a robot and its laptop: USB adapters, radios, USB, shared wires,
//! cables that are pulled.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::common::{BODY, command, run, world};
use baudbot_sim::{Input, World};

/// A robot with a sensor of four bytes in all, at this mode of firmware.
fn robot(link: &str, firmware: &str) -> World {
    world(&format!(
        "step_ms = 0.5\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         firmware = {{ {firmware} }}\nlink = {{ {link} }}\n\
         [robots.sensors.c]\nkind = \"compass\"\nbits = 32\n"
    ))
}

fn uart(baud: u32, more: &str) -> String {
    format!("kind = \"uart\", baud = {baud}, {more}")
}

const POLL: &str = "protocol = \"bare\", mode = \"poll\"";
const FTDI: &str = "adapter = { kind = \"ftdi\" }";

/// The instants, in milliseconds, at which the readings of a polled firmware are at a brain that answers each at
/// once, in so many seconds.
fn exchanges(world: &mut World, seconds: u32) -> Vec<f64> {
    exchanges_in(world, seconds * 2000)
}

/// The same in so many ticks.
fn exchanges_in(world: &mut World, ticks: u32) -> Vec<f64> {
    let bytes = command(world.robot(0).spec(), 0.0, 0.0);
    let mut arrivals = Vec::new();
    for tick in 0..ticks {
        let turn = world.begin()[0];
        let arrived = world.robot(0).uplink().messages > arrivals.len() as u64;
        if arrived {
            arrivals.push(turn.at.as_seconds() * 1e3);
        }
        let speaks = tick == 0 || arrived;
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if speaks { &bytes } else { &[] } }]);
    }
    arrivals
}

fn exchanges_per_second(link: &str) -> f64 {
    let arrivals = exchanges(&mut robot(link, POLL), 4);
    (arrivals.len() - 1) as f64 / (arrivals.last().unwrap() - arrivals[0]) * 1e3
}

/// The number of bytes that the brain has at each instant, in nanoseconds, of a firmware that streams without being
/// asked.
fn arrivals(world: &mut World, ticks: u64) -> BTreeMap<u64, usize> {
    let mut arrivals = BTreeMap::new();
    for _ in 0..ticks {
        let at = world.begin()[0].at.as_ns();
        let unread = world.robot(0).unread().len();
        if unread > 0 {
            *arrivals.entry(at).or_default() += unread;
        }
        world.finish(&[]);
    }
    arrivals
}

/// Runs as many ticks, with a command in each twentieth: no more than a cable carries.
fn run_calmly(world: &mut World, ticks: u64) {
    let bytes = command(world.robot(0).spec(), 0.1, 0.1);
    for tick in 0..ticks {
        let at = world.begin()[0].at;
        world.finish(&[Input { robot: 0, at, bytes: if tick % 20 == 0 { &bytes } else { &[] } }]);
    }
}

#[test]
fn exchanges_a_second_by_adapter_and_baud_rate() {
    let mut table = String::from("    baud    none     cdc ftdi 16  ftdi 2  ftdi 1 bluetooth\n");
    let adapters = [
        "",
        "adapter = { kind = \"cdc\" }",
        FTDI,
        "adapter = { kind = \"ftdi\", latency_ms = 2 }",
        "adapter = { kind = \"ftdi\", latency_ms = 1 }",
        "adapter = { kind = \"bluetooth\" }",
    ];
    for baud in [1200, 9600, 19_200, 38_400, 57_600, 115_200, 1_000_000] {
        write!(table, "{baud:>8}").unwrap();
        for adapter in adapters {
            write!(table, "{:>8.1}", exchanges_per_second(&uart(baud, adapter))).unwrap();
        }
        table.push('\n');
    }
    insta::assert_snapshot!(table);
}

/// Mean and standard deviation of the exchanges of a brain that answers each reading of a byte at once with a command of
/// two, over this adapter, with the program of an Arduino at the other end.
fn echoes(adapter: &str) -> (f64, f64) {
    let mut world = world(&format!(
        "step_ms = 0.1\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         microcontroller = {{ preset = \"atmega328p\" }}\nfirmware = {{ {POLL} }}\n\
         link = {{ preset = \"uart-115200\"{adapter} }}\n[robots.sensors.c]\nkind = \"compass\"\nbits = 8\n\
         period_ms = 100\n"
    ));
    let arrivals = exchanges_in(&mut world, 40_000);
    let took: Vec<f64> = arrivals.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = took.iter().sum::<f64>() / took.len() as f64;
    let variance = took.iter().map(|ms| (ms - mean).powi(2)).sum::<f64>() / took.len() as f64;
    (mean, variance.sqrt())
}

#[test]
fn a_brain_that_answers_at_once_has_the_exchanges_that_were_measured_over_real_adapters() {
    // seeraven/arduinoLatency, results/odroidxu4: 12,000 echoes of a byte at 115,200 baud. Commands have two bytes here,
    // which changes nothing where exchanges take whole frames.
    for (name, measured, deviation) in
        [("ft232r-1ms", 0.924, 0.040), ("ch340", 2.178, 0.036), ("atmega16u2", 3.177, 0.037)]
    {
        let (mean, sd) = echoes(&format!(", adapter = {{ preset = \"{name}\" }}"));
        assert!((mean / measured - 1.0).abs() < 0.1, "{name}: mean {mean}, measured {measured}");
        assert!((0.5..2.0).contains(&(sd / deviation)), "{name}: deviation {sd}, measured {deviation}");
    }
    let (mean, _) = echoes(", adapter = { preset = \"ft232r\" }");
    assert!((1e3 / mean - 62.5).abs() < 0.1, "{mean}");
}

#[test]
fn a_boards_own_uart_and_an_arduinos_program_take_24_us_besides_the_wire() {
    // An echo of a byte took 0.198 ± 0.006 ms between a Raspberry Pi's own UART and a Nano (seeraven/arduinoLatency,
    // kmod_ttyS0): two characters, 0.1736 ms, and 24 µs for both programs. Here there are three characters.
    let (mean, sd) = echoes("");
    let character = 10.0 / 115.2;
    let rest = mean - 3.0 * character;
    assert!((rest - 0.024).abs() < 1e-3, "{rest}");
    assert!((rest + 2.0 * character - 0.198).abs() < 0.006 && sd < 1e-5, "{rest} {sd}");
}

#[test]
fn frames_jitter_and_a_fixed_way_down_leave_a_snapshot_its_future_and_byte_errors_alone() {
    let wrong = |more: &str| {
        let link = uart(115_200, &format!("byte_error_rate = 0.02, adapter = {{ kind = \"cdc\"{more} }}"));
        let mut world = robot(&link, "period_ms = 10");
        run(&mut world, 777, 0.3, 0.1);
        let mut other = world.clone();
        run(&mut world, 2000, 0.1, 0.3);
        run(&mut other, 2000, 0.1, 0.3);
        assert_eq!(world.hash(), other.hash(), "{more}");
        (world.robot(0).uplink().corrupted_bytes, world.hash())
    };
    let plain = wrong("");
    for more in
        [", extra_frames = 2", ", jitter_us = 90", ", down_us = 45", ", jitter_us = 2500, extra_frames = 1"]
    {
        let other = wrong(more);
        assert!(plain.0 > 10 && plain.0 == other.0, "{more}: {plain:?} {other:?}");
        assert_ne!(plain.1, other.1, "{more}");
    }
    // A part that adds nothing draws nothing.
    assert_eq!(plain, wrong(", extra_frames = 0, jitter_us = 0"));
}

#[test]
fn a_latency_timer_of_16_ms_holds_exchanges_near_62_a_second_over_any_cable() {
    for baud in [19_200, 38_400, 57_600, 115_200, 1_000_000] {
        let rate = exchanges_per_second(&uart(baud, FTDI));
        assert!((60.0..=63.0).contains(&rate), "{rate} at {baud} baud");
    }
    let fast = exchanges_per_second(&uart(115_200, "adapter = { kind = \"ftdi\", latency_ms = 1 }"));
    assert!(fast > 400.0, "{fast} with 1 ms");
}

#[test]
fn through_an_adapter_readings_of_a_stream_arrive_in_clumps_and_none_is_missing() {
    // 4 bytes each 0.5 ms are 8000 a second, of the 11,520 that the cable carries.
    let stream = "protocol = \"bare\", period_ms = 0.5";
    let mut direct = robot(&uart(115_200, ""), stream);
    let smooth = arrivals(&mut direct, 4000);
    let mut adapted = robot(&uart(115_200, FTDI), stream);
    let clumps = arrivals(&mut adapted, 4000);
    assert_eq!(smooth.values().max(), Some(&4));
    assert!(clumps.values().filter(|bytes| **bytes == 62).count() > 240, "{clumps:?}");
    assert!(clumps.keys().all(|at| at % 1_000_000 == 0), "at the boundaries of frames: {clumps:?}");
    let (direct, adapted) = (direct.robot(0).uplink().messages, adapted.robot(0).uplink().messages);
    // All but what is in the chip at the end, or waits for a frame.
    assert!(direct - adapted <= 2 * 62 / 4, "{direct} and {adapted}");
}

#[test]
fn a_slow_stream_comes_with_the_timer() {
    // 4 bytes each 4 ms never fill a packet: what has come is sent each 16 ms.
    let mut world = robot(&uart(115_200, FTDI), "protocol = \"bare\", period_ms = 4");
    let clumps = arrivals(&mut world, 200);
    let expected: BTreeMap<u64, usize> = (1..=6).map(|i| (i * 16_000_000, 16)).collect();
    assert_eq!(clumps, expected);
}

#[test]
fn an_exchange_over_usb_takes_its_frames() {
    // The brain is first asked at 0.5 ms. Its command goes with the frame from 1 to 2 ms, is obeyed at 2 ms, and
    // the readings go with the next one; so an exchange takes two frames.
    let arrivals = exchanges(&mut robot("kind = \"usb\"", POLL), 1);
    assert_eq!(arrivals[..3], [3.0, 5.0, 7.0]);
    assert_eq!(arrivals.len(), 499);
}

#[test]
fn on_a_shared_wire_a_stream_and_commands_wait_for_each_other() {
    // 4 bytes each 10 ms and 2 bytes each 0.5 ms: a character takes 1.04 ms, so the brain would fill the wire.
    let stream = "protocol = \"bare\", period_ms = 10";
    let wires = ["", "half_duplex = true", "half_duplex = true, turnaround_us = 2000"];
    let [both, shared, slow] = wires.map(|more| {
        let mut world = robot(&uart(9600, more), stream);
        run(&mut world, 4000, 0.1, 0.1);
        let robot = world.robot(0);
        (robot.uplink().bytes, robot.downlink().bytes)
    });
    // 960 characters a second, 2 s: each way of its own,
    assert!(both.0 >= 796 && both.1.abs_diff(1920) < 4, "{both:?}");
    // or together; and with pauses between them.
    assert!(shared.0 + shared.1 <= 1920 && shared.0 + shared.1 > 1900, "{shared:?}");
    assert!(slow.0 + slow.1 < shared.0 + shared.1, "{slow:?} and {shared:?}");
    assert!(slow.0 > 100 && slow.1 > 100, "none is shut out: {slow:?}");
}

#[test]
fn an_exchange_on_a_shared_wire_pays_for_turning_around() {
    // 6 characters of 1 ms, and 0.5 ms before each of the two messages.
    let link = "kind = \"uart\", baud = 10000, half_duplex = true, turnaround_us = 500";
    let arrivals = exchanges(&mut robot(link, POLL), 1);
    assert_eq!(arrivals[..3], [7.0, 14.0, 21.0]);
}

#[test]
fn a_cable_that_is_pulled_loses_what_is_on_it_and_goes_on_when_it_is_back() {
    for kind in ["kind = \"usb\"", "kind = \"uart\", baud = 115200"] {
        let link = format!("{kind}, outages = [{{ from_s = 1.0, for_s = 0.5 }}]");
        let mut world = robot(&link, "period_ms = 10");
        run_calmly(&mut world, 4000);
        let (up, down) = (*world.robot(0).uplink(), *world.robot(0).downlink());
        // 200 frames, of which 50 were lost, or 51 if one was cut.
        assert!((148..=150).contains(&up.messages), "{up:?}");
        let each = up.bytes / 200;
        assert!(up.lost_bytes.abs_diff(50 * each) <= each, "{up:?}");
        assert!(down.lost_bytes > 0 && world.robot(0).commands().abs_diff(149) <= 1, "{down:?}");
        assert!(up.bad_frames <= 1 && down.bad_frames <= 1, "{up:?} {down:?}");
        let ages = world.robot(0).sensors().next().unwrap().freshness;
        assert_eq!(ages.readable, ages.ages.count(), "the ages of all that arrived are known");
    }
}

#[test]
fn over_a_radio_all_messages_arrive_late_and_in_bunches() {
    let radio = "adapter = { kind = \"bluetooth\", burst_probability = 0.1 }";
    let mut world = robot(&uart(115_200, radio), "period_ms = 10");
    run_calmly(&mut world, 8000);
    let robot = world.robot(0);
    assert!((380..400).contains(&robot.uplink().messages), "{:?}", robot.uplink());
    assert_eq!((robot.uplink().bad_frames, robot.downlink().bad_frames), (0, 0));
    let freshness = robot.sensors().next().unwrap().freshness;
    let mean_ms = freshness.ages.sum_ns() / freshness.ages.count() / 1_000_000;
    assert!((25..60).contains(&mean_ms), "{mean_ms}");
    assert!(freshness.ages.max_ns().unwrap() > 100_000_000, "{freshness:?}");
    assert!((380..400).contains(&robot.commands()), "{}", robot.commands());
}

#[test]
fn a_radio_changes_no_byte_error() {
    let wrong = |more: &str| {
        let link = uart(115_200, &format!("byte_error_rate = 0.02, {more}"));
        let mut world = robot(&link, "period_ms = 10");
        run(&mut world, 2000, 0.1, 0.1);
        (world.robot(0).uplink().corrupted_bytes, world.hash())
    };
    let (direct, radio) = (wrong(""), wrong("adapter = { kind = \"bluetooth\" }"));
    assert!(direct.0 > 10 && direct.0 == radio.0, "{direct:?} {radio:?}");
    assert_ne!(direct.1, radio.1);
    assert_eq!(radio, wrong("adapter = { kind = \"bluetooth\" }"));
}

#[test]
fn a_snapshot_has_the_same_future_whatever_the_link() {
    let links = [
        "kind = \"usb\", outages = [{ from_s = 0.1, for_s = 0.1 }]".to_owned(),
        uart(115_200, FTDI),
        uart(115_200, "adapter = { kind = \"bluetooth\", packet_bytes = 20 }"),
        uart(19_200, "half_duplex = true, turnaround_us = 100, adapter = { kind = \"bluetooth\" }"),
        uart(
            19_200,
            "half_duplex = true, adapter = { kind = \"cdc\" }, outages = [{ from_s = 0.3, for_s = 1 }]",
        ),
    ];
    for link in links {
        let mut world = robot(&link, "period_ms = 10");
        run(&mut world, 777, 0.3, 0.1);
        let mut other = world.clone();
        run(&mut world, 2000, 0.1, 0.3);
        run(&mut other, 2000, 0.1, 0.3);
        assert_eq!(world.hash(), other.hash(), "{link}");
        assert!(world.robot(0).commands() > 0 && world.robot(0).uplink().messages > 0, "{link}");
    }
}

#[test]
fn a_flood_over_any_link_is_refused_beyond_the_driver_and_harms_nothing() {
    let links = [
        "kind = \"usb\", laptop_buffer_bytes = 256".to_owned(),
        uart(9600, "laptop_buffer_bytes = 256, adapter = { kind = \"bluetooth\" }"),
        uart(9600, "laptop_buffer_bytes = 256, half_duplex = true"),
        uart(9600, "laptop_buffer_bytes = 256, adapter = { kind = \"ftdi\" }"),
    ];
    for link in links {
        let mut world = robot(&link, "period_ms = 10");
        for _ in 0..1000 {
            let at = world.begin()[0].at;
            world.finish(&[Input { robot: 0, at, bytes: &[0x55; 10_000] }]);
        }
        let down = *world.robot(0).downlink();
        let waiting = 1000 * 10_000 - down.bytes - down.refused_bytes;
        // The bytes wait in the driver and in the receiver.
        assert!(waiting <= 256 + 64, "{waiting} over {link}");
        assert!(world.robot(0).uplink().messages > 3, "{:?} over {link}", world.robot(0).uplink());
    }
}
