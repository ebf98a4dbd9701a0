use std::fmt::Write as _;

use baudbot_fit::estimate::{Outcome, Reason};
use baudbot_sim::SimTime;
use baudbot_sim::link::{Line, Link};

use crate::common::{Chance, Tally, findings, of, scenario};

const ROBOT: &str = r#"
[[robots]]
name = "a"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
link = { kind = "uart", baud = 115200, adapter = ADAPTER }
"#;

const WIRE_MS: f64 = 10.0 / 115.2;

fn log(echoes: &[(f64, f64)]) -> String {
    let mut text = "# experiment: echo\n# baud: 115200\nsent_us,received_us\n".to_owned();
    for (sent_ms, received_ms) in echoes {
        writeln!(text, "{:.3},{:.3}", sent_ms * 1e3, received_ms * 1e3).unwrap();
    }
    text
}

/// A USB adapter as `crates/sim/src/link` describes it: frames of 1 ms from the start of the run, whole frames more, a jitter, and a
/// fixed way down. The laptop's clock may run at another rate than the bus.
fn usb(seed: u64, (extra, jitter_ms, down_ms): (f64, f64, f64), rate: f64, is_locked: bool) -> String {
    let mut chance = Chance::new(seed);
    let (mut now, mut echoes) = (5.3, Vec::new());
    for _ in 0..600 {
        let sent = now;
        let at_chip = sent + down_ms + 2.0 * WIRE_MS;
        let received = at_chip.ceil() + extra + chance.between(0.0, jitter_ms);
        echoes.push((sent * (1.0 + rate), received * (1.0 + rate)));
        now = received + if is_locked { 0.01 } else { chance.between(0.5, 3.5) };
    }
    log(&echoes)
}

#[test]
fn a_usb_adapter_is_recovered() {
    let scenario = scenario(&ROBOT.replace("ADAPTER", "{ kind = \"cdc\" }"), &[]);
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(100 + seed);
        let hidden =
            (chance.between(0.0, 3.99).floor(), chance.between(0.03, 0.3), chance.between(0.02, 0.7));
        let log = usb(seed, hidden, chance.between(-5e-5, 5e-5), false);
        let found = findings(&scenario, &log, &["links.*"]);
        tally.add(&found, "link.adapter.extra_frames", hidden.0);
        tally.add(&found, "link.adapter.jitter_us", 1e3 * hidden.1);
        tally.add(&found, "link.adapter.down_us", 1e3 * hidden.2);
    }
    tally.check();
}

/// The echo of a byte, by the simulator's own lines.
fn simulated(link: &Link, seed: u64, mut pause_ms: impl FnMut() -> f64) -> String {
    let (mut up, mut down) = (Line::up(link, seed, &["a/up"]), Line::down(link, seed, &["a/down"]));
    let (mut now, mut echoes) = (SimTime::from_ns(5_300_000), Vec::new());
    for _ in 0..400 {
        down.send(link, now, b"x");
        let at_robot = down.arrival(link);
        assert!(down.take(link, at_robot).is_some());
        up.send(link, at_robot, b"x");
        let received = up.arrival(link);
        assert!(up.take(link, received).is_some());
        echoes.push((now.as_seconds() * 1e3, received.as_seconds() * 1e3));
        now = received + (pause_ms() * 1e6) as u64;
    }
    log(&echoes)
}

#[test]
fn a_latency_timer_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let latency = [1, 2, 4, 8, 16][seed as usize % 5];
        let adapter =
            |ms: u64| ROBOT.replace("ADAPTER", &format!("{{ kind = \"ftdi\", latency_ms = {ms}.0 }}"));
        let mut chance = Chance::new(seed);
        let hidden = scenario(&adapter(latency), &[]);
        let log = simulated(&hidden.robots[0].link, seed, || chance.between(0.5, 40.0));
        let found = findings(
            &scenario(&adapter(5), &[]),
            &log,
            &["link.adapter.latency_ms", "link.adapter.extra_frames"],
        );
        tally.add(&found, "link.adapter.latency_ms", latency as f64);
        tally.add(&found, "link.adapter.extra_frames", 0.0);
    }
    tally.check();
}

#[test]
fn a_radio_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let hidden = [
            chance.between(20.0, 60.0),
            chance.between(5.0, 15.0),
            chance.between(0.02, 0.1),
            chance.between(50.0, 150.0),
        ];
        let [latency, spread, probability, burst] = hidden;
        let adapter = format!(
            "{{ kind = \"bluetooth\", latency_ms = {latency}, spread_ms = {spread}, burst_probability = {probability}, burst_ms = {burst} }}"
        );
        let hidden_scenario = scenario(&ROBOT.replace("ADAPTER", &adapter), &[]);
        let log = simulated(&hidden_scenario.robots[0].link, seed, || 500.0);
        let preset = scenario(
            "[[robots]]\nname = \"a\"\nlink.preset = \"bluetooth\"\nbody = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }",
            &[],
        );
        let found = findings(&preset, &log, &["link"]);
        for (name, hidden) in ["latency_ms", "spread_ms", "burst_probability", "burst_ms"].iter().zip(hidden)
        {
            tally.add(&found, &format!("link.adapter.{name}"), hidden);
        }
    }
    tally.check();
}

/// A program that sends its next byte when the last has come back is in step with the frames.
#[test]
fn a_locked_loop_cannot_tell_the_way_down() {
    let scenario = scenario(&ROBOT.replace("ADAPTER", "{ kind = \"cdc\" }"), &[]);
    let found = findings(&scenario, &usb(1, (1.0, 0.1, 0.05), 0.0, true), &["link"]);
    let Outcome::CannotTell(reason) = of(&found, "link.adapter.down_us") else { panic!("{found:?}") };
    assert!(reason.to_string().contains("send at random times"), "{reason}");
}

#[test]
fn bursts_that_never_happened_are_not_told() {
    let adapter = "{ kind = \"bluetooth\", latency_ms = 30.0, spread_ms = 10.0, burst_probability = 0.0, burst_ms = 100.0 }";
    let scenario = scenario(&ROBOT.replace("ADAPTER", adapter), &[]);
    let found = findings(&scenario, &simulated(&scenario.robots[0].link, 1, || 500.0), &["link"]);
    let Outcome::CannotTell(Reason::Excitation { .. }) = of(&found, "link.adapter.burst_ms") else {
        panic!("{found:?}")
    };
    let Outcome::Estimate(probability) = of(&found, "link.adapter.burst_probability") else {
        panic!("{found:?}")
    };
    assert!(probability.low == 0.0 && probability.high < 0.02, "{probability:?}");
}

/// Two rows of columns that are there, and a log of another experiment.
#[test]
fn few_echoes_and_other_logs_tell_nothing() {
    let scenario = scenario(&ROBOT.replace("ADAPTER", "{ kind = \"cdc\" }"), &[]);
    let reason = |log: &str| match of(
        &findings(&scenario, log, &["link.adapter.jitter_us"]),
        "link.adapter.jitter_us",
    ) {
        Outcome::CannotTell(reason) => reason.to_string(),
        Outcome::Estimate(estimate) => panic!("{estimate:?}"),
    };
    assert_eq!(
        reason("sent_ms,received_ms\n1,2\n3,4\n5,6\n"),
        "the log has 3 echoes that came back after they were sent; 50 are needed"
    );
    assert!(
        reason("time_s,x_m\n1,2\n3,4\n")
            .starts_with("the log has no columns `sent_s` and `received_s`: instants")
    );
}
