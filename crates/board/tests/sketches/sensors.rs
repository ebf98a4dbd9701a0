//! Encoders, sonars and whiskers.

use core::f64::consts::TAU;

use baudbot_board::{Channels, Encoder, HcSr04, Kind, Led, LitBy, Ping, Pull, Switch, Wiring};

use crate::sketches::bench::{MS, bench};

fn encoder(channels: Channels, counts_per_turn: u32) -> Kind {
    Kind::Encoder(Encoder { channels, counts_per_turn })
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn encoders_at_interrupts_are_counted_to_the_edge() {
    let wiring = Wiring::builder()
        .part("holes", encoder(Channels::Single, 16))
        .part("quadrature", encoder(Channels::Quadrature, 1440))
        .connect("2", "holes.a")
        .connect("3", "quadrature.a")
        .connect("4", "quadrature.b");
    let mut bench = bench("encoders.hex", wiring);
    bench.run(200);
    bench.world.wheels[0].rate_rad_s = 1.65 * TAU;
    bench.world.wheels[1].rate_rad_s = -3.3 * TAU;
    bench.run(10_400);
    let lines = bench.lines();
    assert_eq!(lines.len(), 10, "{lines:?}");
    for (at, line) in lines {
        let s = at as f64 / 1e9 - 0.2;
        let (holes, quarters) = line.split_once(' ').unwrap();
        let (holes, quarters): (f64, f64) = (holes.parse().unwrap(), quarters.parse().unwrap());
        assert_eq!(holes, (16.0 * 1.65 * s).floor(), "at {s}");
        // The edges of one channel; half a count of it is where the turn began.
        assert!((quarters + 720.0 * 3.3 * s).abs() <= 1.5, "{quarters} at {s}");
    }
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn pin_changes_of_a_program_in_c_count_each_step_of_a_quadrature_encoder() {
    let wiring = Wiring::builder()
        .part("wheel", encoder(Channels::Quadrature, 360))
        .connect("A0", "wheel.a")
        .connect("A1", "wheel.b");
    let mut bench = bench("quadrature.hex", wiring);
    bench.world.wheels[0].angle_rad = 0.5 / 360.0 * TAU;
    bench.run(100);
    bench.world.wheels[0].rate_rad_s = 2.0 * TAU;
    bench.run(3000);
    bench.world.wheels[0].rate_rad_s = -5.0 * TAU;
    bench.run(5000);
    let lines = bench.lines();
    assert!(lines.len() > 28, "{lines:?}");
    for (at, line) in lines {
        let s = at as f64 / 1e9 - 0.1;
        let turns = if s < 3.0 { 2.0 * s.max(0.0) } else { 6.0 - 5.0 * (s - 3.0) };
        let count: f64 = line.parse().unwrap();
        // The time from the read of the count to the first character is that of `printf`.
        let awaited = (0.5 + 360.0 * turns).floor();
        assert!((count - awaited).abs() <= 1.0, "{count} instead of {awaited} at {s}");
    }
    bench.assert_no_warnings();
}

/// `pulseIn` counts how often it looks, each microsecond. An interrupt of timer 0, each 1024 µs, takes 5 µs to 6.5 µs of that.
fn assert_pulse(shown_us: u64, us: u64) {
    let least = us - 13 * us.div_ceil(1024) / 2 - 2;
    let most = us - 5 * (us / 1024) + 2;
    assert!((least..=most).contains(&shown_us), "{shown_us} instead of {us}, {least} to {most}");
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn pulse_in_measures_both_kinds_of_sonar() {
    let wiring = Wiring::builder()
        .part("ping", Kind::Ping(Ping))
        .part("front", Kind::HcSr04(HcSr04))
        .connect("7", "ping")
        .connect("9", "front.trigger")
        .connect("10", "front.echo");
    let mut bench = bench("sonars.hex", wiring);
    for (ping_us, front_us) in [(5800, 1160), (290, 11_600), (17_400, 23_200)] {
        bench.world.echo_ns[..2].copy_from_slice(&[Some(1000 * ping_us), Some(1000 * front_us)]);
        bench.run(300);
        bench.lines();
        bench.run(1000);
        let lines = bench.lines();
        assert!(lines.len() >= 8, "{lines:?}");
        for (_, line) in lines {
            let words: Vec<&str> = line.split(' ').collect();
            let us = |word: &str| word.parse::<u64>().unwrap();
            assert_pulse(us(words[0]), ping_us);
            assert_pulse(us(words[1]), front_us);
            assert!((words[2].parse::<f64>().unwrap() - us(words[0]) as f64 / 58.0).abs() < 0.006, "{line}");
        }
    }
    // There is no object: the PING))) measures 18.5 ms, and the HC-SR04 38 ms, which is longer than the sketch waits.
    bench.world.echo_ns = [None; 16];
    bench.run(300);
    bench.lines();
    bench.run(1000);
    for (_, line) in bench.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        assert_pulse(words[0].parse().unwrap(), 18_500);
        assert_eq!(words[1], "0");
    }
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn whiskers_with_pull_ups_light_leds_and_each_touch_counts_once() {
    let whisker = |seed| Kind::Switch(Switch { pull: Pull::Internal, bounce_us: 1500, seed });
    let led = Kind::Led(Led { lit_by: LitBy::High });
    let wiring = Wiring::builder()
        .part("left", whisker(1))
        .part("right", whisker(2))
        .part("left_led", led)
        .part("right_led", led)
        .connect("5", "left")
        .connect("7", "right")
        .connect("8", "left_led")
        .connect("12", "right_led");
    let mut bench = bench("whiskers.hex", wiring);
    bench.run(200);
    assert_eq!((bench.text().as_str(), bench.brightness(0), bench.brightness(1)), ("", 0.0, 0.0));
    for touch in 1..=10 {
        for (side, name) in ["left", "right"].into_iter().enumerate() {
            bench.world.pressed[side] = true;
            let touched = bench.board.now_ns();
            bench.run(100);
            let lines = bench.lines();
            assert!(lines.len() == 1 && lines[0].1 == format!("{name} {touch}"), "{lines:?}");
            assert!(lines[0].0 - touched < MS, "{lines:?}");
            assert_eq!((bench.brightness(side), bench.brightness(1 - side)), (1.0, 0.0));
            bench.world.pressed[side] = false;
            bench.run(100);
            assert_eq!((bench.text().as_str(), bench.brightness(side)), ("", 0.0));
        }
    }
    bench.assert_no_warnings();
}
