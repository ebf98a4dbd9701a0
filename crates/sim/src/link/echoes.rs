//! Echoes of a byte, as they were measured over real adapters and as they are on two lines.

use alloc::vec::Vec;

use super::properties::{down, line, uart, with_adapter};
use super::{Adapter, Frames, Ftdi, Line, Link};
use crate::time::SimTime;

const MS: u64 = 1_000_000;

fn frames(extra: u32, jitter_us: u64, down_us: u64) -> Frames {
    Frames { frame_ns: MS, extra, jitter_ns: jitter_us * 1000, down_ns: Some(down_us * 1000) }
}

/// The adapters of the presets `ft232r-1ms` (or with another timer), `ch340` and `atmega16u2`.
fn ft232r(latency_ms: u64) -> Adapter {
    Adapter::Ftdi(Ftdi { latency_ns: latency_ms * MS, packet_bytes: 62, frames: frames(0, 100, 80) })
}

fn ch340() -> Adapter {
    Adapter::Cdc(frames(1, 90, 43))
}

fn atmega16u2() -> Adapter {
    Adapter::Cdc(frames(2, 90, 45))
}

fn next(line: &mut Line, link: &Link) -> SimTime {
    let at = line.arrival(link);
    line.take(link, at).expect("what arrives can be taken").0
}

/// Echoes in milliseconds, the first of them left out: a program writes a byte so long after the last one has come back,
/// and what is at the other end of the cable answers after `robot_ns`.
fn echoes(link: &Link, pause_ns: impl Fn(u64) -> u64, robot_ns: u64) -> Vec<f64> {
    let (mut down, mut up) = (down(link), line(link));
    let mut now = SimTime::from_ns(7 * MS + 654_321);
    let echo = |i: u64| {
        now = now + pause_ns(i);
        down.send(link, now, &[7]);
        up.send(link, next(&mut down, link) + robot_ns, &[7]);
        let back = next(&mut up, link);
        let took_ns = back.since(now);
        now = back;
        took_ns as f64 / 1e6
    };
    (0..12_001).map(echo).skip(1).collect()
}

/// The same as [`echoes`], with a plug that connects the adapter's output with its input: the byte comes in as it goes
/// out.
fn plugged_echoes(link: &Link, pause_ns: impl Fn(u64) -> u64) -> Vec<f64> {
    let (mut down, mut up) = (down(link), line(link));
    let mut now = SimTime::from_ns(7 * MS + 654_321);
    let echo = |i: u64| {
        now = now + pause_ns(i);
        down.send(link, now, &[7]);
        let out_ns = next(&mut down, link).as_ns() - link.burst_ns(1);
        up.send(link, SimTime::from_ns(out_ns), &[7]);
        let back = next(&mut up, link);
        let took_ns = back.since(now);
        now = back;
        took_ns as f64 / 1e6
    };
    (0..2001).map(echo).skip(1).collect()
}

/// Mean and standard deviation.
fn summary(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

/// seeraven/arduinoLatency, results/odroidxu4: 12,000 echoes each at 115,200 baud. Its program slept 50 ms before each
/// byte; the phase of the frames is the same after that, so a program that does not sleep has the same echoes.
#[test]
fn echoes_over_usb_have_the_mean_and_the_deviation_that_were_measured() {
    let measured = [
        ("FT232R, 1 ms", ft232r(1), 0.924, 0.040),
        ("CH340", ch340(), 2.178, 0.036),
        ("ATmega16U2", atmega16u2(), 3.177, 0.037),
    ];
    for (name, adapter, expected, deviation) in measured {
        let link = with_adapter(uart(115_200, 10), adapter);
        for pause_ns in [0, 50 * MS] {
            let (mean, sd) = summary(&echoes(&link, |_| pause_ns, 24_000));
            assert!((mean / expected - 1.0).abs() < 0.1, "{name}: mean {mean}, measured {expected}");
            assert!((0.5..2.0).contains(&(sd / deviation)), "{name}: deviation {sd}, measured {deviation}");
        }
    }
}

#[test]
fn a_boards_own_uart_takes_two_characters_and_what_the_robot_takes() {
    // Measured: 0.198 ± 0.006 ms, of which the wire takes 0.174. The deviation is the program's, and not modelled.
    let (mean, sd) = summary(&echoes(&uart(115_200, 10), |_| 0, 20_000));
    assert!((mean - 0.1936).abs() < 1e-4 && (mean / 0.198 - 1.0).abs() < 0.03, "{mean}");
    assert!(sd < 1e-9, "{sd}");
}

#[test]
fn the_timer_as_drivers_set_it_allows_62_and_a_half_echoes_a_second() {
    let link = with_adapter(uart(115_200, 10), ft232r(16));
    let (mean, _) = summary(&echoes(&link, |_| 0, 24_000));
    assert!((1e3 / mean - 62.5).abs() < 0.1, "{mean}");
}

/// heavydeck.net, "measuring serial port latency": an FTDI chip on Windows whose output is connected with its input, 256
/// bytes each. Its shortest echoes at slow rates have 1.2 times the ten bits that it assumes, so characters have 12 bits.
const HEAVYDECK: [(u32, f64, f64, f64); 3] =
    [(9600, 1.419, 2.004, 2.880), (38_400, 0.857, 1.011, 1.976), (115_200, 0.578, 1.009, 2.005)];

#[test]
fn echoes_of_a_plug_take_the_whole_frames_that_were_measured_on_windows() {
    for (baud, _, measured, _) in HEAVYDECK {
        let link = with_adapter(uart(baud, 12), ft232r(1));
        let (mean, _) = summary(&plugged_echoes(&link, |_| 0));
        assert!((mean / measured - 1.0).abs() < 0.02, "{baud} baud: {mean}, measured {measured}");
    }
}

/// A program that does not wait for the last byte to write the next is not locked to the frames. Then an echo is up to a
/// frame shorter, 0.5 ms in the middle: the means that were measured are those of a program that is locked. Its shortest
/// and longest are a frame apart and more, as a busy host writes late and misses frames, which is not modelled.
#[test]
fn echoes_of_bytes_that_are_written_at_any_time_are_spread_over_a_frame() {
    for (baud, least, measured, most) in HEAVYDECK {
        let link = with_adapter(uart(baud, 12), ft232r(1));
        // Steps of the golden section visit all phases alike.
        let found = plugged_echoes(&link, |i| 5 * MS + (i * 618_034) % MS);
        let (mean, sd) = summary(&found);
        let [shortest, longest] = [f64::min, f64::max].map(|f| found.iter().copied().reduce(f).unwrap());
        let wire = 12e3 / f64::from(baud) + 0.08;
        assert!((mean - (wire + 0.55)).abs() < 0.02 && (sd - 0.29).abs() < 0.02, "{baud}: {mean} {sd}");
        assert!(shortest - wire < 0.02 && wire + 1.1 - longest < 0.02, "{baud}: {shortest} {longest}");
        // The measured echoes are no shorter, and go on for longer.
        assert!(shortest < least && longest < most && mean < measured, "{baud}: {shortest} {mean} {longest}");
    }
}

#[test]
fn a_packet_does_not_overtake_the_one_before() {
    let own = Frames { jitter_ns: 5 * MS, ..Frames::of(MS) };
    let link = with_adapter(uart(115_200, 10), Adapter::Cdc(own));
    let mut line = line(&link);
    let mut arrivals = Vec::new();
    for i in 0..1000 {
        line.send(&link, SimTime::from_ns(i * MS + MS / 2), &[i as u8]);
    }
    while line.arrival(&link) != SimTime::NEVER {
        let at = line.arrival(&link);
        arrivals.push(line.take(&link, at).unwrap());
    }
    assert!(arrivals.is_sorted_by_key(|(at, _)| *at));
    assert!(arrivals.iter().enumerate().all(|(i, (_, byte))| *byte == i as u8), "{arrivals:?}");
    let late = |(i, (at, _)): (usize, &(SimTime, u8))| at.as_ns() - (i as u64 + 1) * MS;
    assert!(arrivals.iter().enumerate().map(late).all(|ns| ns < 5 * MS));
}

#[test]
fn bytes_that_go_with_one_frame_have_one_jitter() {
    let link = with_adapter(uart(100_000, 10), ch340());
    let mut line = line(&link);
    // The bytes come to the chip at 2.1 to 2.5 ms.
    line.send(&link, SimTime::from_ns(2 * MS), &[1, 2, 3, 4, 5]);
    let packets = super::properties::delivered(&mut line, &link, 10 * MS);
    assert_eq!(packets.len(), 1, "{packets:?}");
    assert!((4 * MS..4 * MS + 90_000).contains(&packets[0].0), "{packets:?}");
}

#[test]
fn what_is_written_is_at_the_chip_after_a_fixed_time() {
    let link = with_adapter(uart(100_000, 10), ch340());
    let mut line = down(&link);
    line.send(&link, SimTime::from_ns(1_234_000), &[1, 2]);
    line.send(&link, SimTime::from_ns(9 * MS), &[3]);
    let at = super::properties::delivered(&mut line, &link, 10 * MS).into_iter().map(|(at, _)| at);
    assert!(at.eq([1_377_000, 1_477_000, 9_143_000]));
}
