//! The brain in front of made-up obstacles.

use super::*;
use crate::test_body::{body, turn};

const MS: u64 = 1_000_000;

/// The five sensors of the scenario `wander`, from left to right, and one that looks back.
const FIVE: [(&str, &str, f64); 6] = [
    ("ir_left", "ir", 1.05),
    ("ir_front_left", "ir", 0.52),
    ("ir_front", "ir", 0.0),
    ("ir_front_right", "ir", -0.52),
    ("ir_right", "ir", -1.05),
    ("ir_rear", "ir", 3.1),
];

struct Bench {
    body: Body,
    avoid: Avoid,
    now_ns: u64,
}

impl Bench {
    /// A robot that never strolls.
    fn new(sensors: &[(&str, &str, f64)]) -> Self {
        Self::with(sensors, Parameters { stroll_rate_hz: 0.0, ..Parameters::default() })
    }

    fn with(sensors: &[(&str, &str, f64)], parameters: Parameters) -> Self {
        let body = body(sensors);
        let avoid = Avoid::new(parameters, Chance::new(1, "alice/avoid"), &body).unwrap();
        Self { body, avoid, now_ns: 0 }
    }

    /// A step 20 ms later, with a new reading of each sensor.
    fn see<const N: usize>(&mut self, readings: [f64; N]) -> Action {
        self.now_ns += 20 * MS;
        let readings = readings.map(|reading| [reading]);
        let readings = readings.each_ref().map(|reading| Some(&reading[..]));
        self.act(&turn(&self.body, self.now_ns, &readings))
    }

    /// Acts on its state; the transitions to the next one have a test of their own.
    fn act(&mut self, turn: &Turn) -> Action {
        Action { until: None, ..self.avoid.step(turn) }
    }

    /// A step so much later, with the readings repeated.
    fn see_nothing_new(&mut self, ms: u64) -> Action {
        self.now_ns += ms * MS;
        let mut turn = turn(&self.body, self.now_ns, &[Some(&[0.0][..]); 6]);
        turn.readings.iter_mut().flatten().for_each(|reading| reading.readable = false);
        self.act(&turn)
    }
}

#[test]
fn until_the_instant_that_it_waits_for_it_would_do_nothing() {
    let parameters = Parameters { stale_s: 0.3, ..Parameters::default() };
    let mut bench = Bench::with(&FIVE, parameters);
    for i in 0..200_u64 {
        // Messages now and then, from 1 to 800 ms apart, the last one at a command's end or not.
        bench.now_ns += [1, 3, 7, 40, 150, 800][i as usize % 6] * MS + i;
        let reading = [(i % 5) as f64 * 0.1];
        let news = turn(&bench.body, bench.now_ns, &[Some(&reading[..]); 6]);
        let mut action = bench.avoid.step(&news);
        for _ in 0..3 {
            let until_ns =
                action.until.and_then(|until| until.at_latest_ns).expect("it never waits for ever");
            for at_ns in [bench.now_ns, (bench.now_ns + until_ns) / 2, until_ns.saturating_sub(1)] {
                if at_ns < bench.now_ns || at_ns >= until_ns {
                    continue;
                }
                let mut other = bench.avoid.clone();
                let mut nothing = turn(&bench.body, at_ns, &[Some(&reading[..]); 6]);
                nothing.readings.iter_mut().flatten().for_each(|reading| reading.readable = false);
                assert_eq!(other.step(&nothing), Action::wait().until_message_or(until_ns), "{i}: {at_ns}");
                assert_eq!(other, bench.avoid);
            }
            bench.now_ns = bench.now_ns.max(until_ns);
            let mut nothing = turn(&bench.body, bench.now_ns, &[Some(&reading[..]); 6]);
            nothing.readings.iter_mut().flatten().for_each(|reading| reading.readable = false);
            action = bench.avoid.step(&nothing);
        }
    }
}

const RIGHT: Action = Action::drive(0.5, -0.5);
const LEFT: Action = Action::drive(-0.5, 0.5);
const ON: Action = Action::drive(0.5, 0.5);

#[test]
fn it_turns_away_from_the_nearer_side() {
    assert_eq!(Bench::new(&FIVE).see([0.4, 0.2, 0.0, 0.0, 0.0, 0.0]), RIGHT);
    assert_eq!(Bench::new(&FIVE).see([0.0, 0.0, 0.3, 0.1, 0.0, 0.0]), LEFT);
    // Objects behind it do not matter, nor does the turn in which a heading is written.
    assert_eq!(Bench::new(&FIVE).see([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), ON);
    let two = [("a", "ir", -0.785), ("b", "ir", 0.785 - std::f64::consts::TAU)];
    assert_eq!(Bench::new(&two).see([0.0, 0.5]), RIGHT);
}

#[test]
fn it_keeps_turning_the_same_way_until_all_is_clear() {
    let mut bench = Bench::new(&FIVE);
    assert_eq!(bench.see([0.4, 0.0, 0.0, 0.0, 0.3, 0.0]), RIGHT);
    for _ in 0..100 {
        // In a corner, where now the one side and now the other is nearer.
        assert_eq!(bench.see([0.3, 0.0, 0.0, 0.0, 0.4, 0.0]), RIGHT);
        assert_eq!(bench.see([0.0, 0.0, 0.0, 0.0, 0.21, 0.0]), RIGHT);
    }
    let Some(signals) = bench.see([0.0, 0.0, 0.0, 0.0, 0.19, 0.0]).signals else { panic!("no command") };
    assert!(signals.left > 0.0 && signals.left == signals.right);
}

#[test]
fn it_slows_down_as_something_comes_near() {
    let mut bench = Bench::new(&FIVE);
    let mut speed = |reading| bench.see([0.0, 0.0, reading, 0.0, 0.0, 0.0]).signals.unwrap().left;
    let speeds = [0.0, 0.13, 0.2, 0.27].map(&mut speed);
    assert_eq!(speeds[..2], [0.5, 0.5]);
    assert!(speeds[2] < 0.5 && speeds[3] < speeds[2] && speeds[3] > 0.15, "{speeds:?}");
}

#[test]
fn it_strolls_where_all_is_clear_and_its_strolls_end() {
    let parameters = Parameters { stroll_rate_hz: 0.5, stop_stroll_rate_hz: 2.0, ..Parameters::default() };
    let mut bench = Bench::with(&FIVE, parameters);
    let steps = 100_000;
    let actions: Vec<_> = (0..steps).map(|_| bench.see([0.0; 6])).collect();
    let count = |action| actions.iter().filter(|&a| *a == action).count() as f64 / f64::from(steps);
    // On the average it drives for 2 s and turns for 0.5 s.
    assert!((count(ON) - 0.8).abs() < 0.03, "{}", count(ON));
    assert!((count(LEFT) - 0.1).abs() < 0.03 && (count(RIGHT) - 0.1).abs() < 0.03);
}

#[test]
fn it_stands_still_until_it_has_seen_something_and_when_it_sees_no_more() {
    let stop = Action::drive(0.0, 0.0);
    let mut bench = Bench::new(&FIVE);
    assert_eq!(bench.see_nothing_new(0), stop);
    assert_eq!(bench.see_nothing_new(10), Action::wait());
    assert_eq!(bench.see_nothing_new(90), stop);
    assert_eq!(bench.see([0.0; 6]), ON);
    assert_eq!(bench.see_nothing_new(490), ON, "said again");
    assert_eq!(bench.see_nothing_new(11), stop);
    assert_eq!(bench.see([0.0; 6]), ON);
}

#[test]
fn one_sensor_that_falls_silent_is_enough_to_stop() {
    let mut bench = Bench::new(&FIVE);
    assert_eq!(bench.see([0.0; 6]), ON);
    let mut last = ON;
    for _ in 0..30 {
        bench.now_ns += 20 * MS;
        let mut turn = turn(&bench.body, bench.now_ns, &[Some(&[0.0][..]); 6]);
        turn.readings[2].as_mut().unwrap().readable = false;
        last = bench.avoid.step(&turn);
    }
    assert_ne!(last, ON);
    assert_eq!(bench.avoid.state, State::Drive);
}

#[test]
fn it_does_not_command_faster_than_the_cable_carries() {
    let mut bench = Bench::new(&FIVE);
    bench.body.baud = Some(1200);
    bench.avoid = Avoid::new(Parameters::default(), Chance::new(1, ""), &bench.body).unwrap();
    // A command takes 67 ms, and readings come every 20 ms.
    let sent = (0..40).filter(|_| bench.see([0.0; 6]) != Action::wait()).count();
    assert_eq!(sent, 10);
}

#[test]
fn without_eyes_there_is_no_brain() {
    let chance = Chance::new(1, "");
    let bodies = [body(&[("ir_rear", "ir", 3.0)]), body(&[("odometer", "odometer", 0.0)])];
    for body in bodies {
        assert_eq!(Avoid::new(Parameters::default(), chance.clone(), &body), None);
    }
}

/// The turns of the scenario `wander` in 10 s: a message 0.487 ms after each second tick, and the ends of ticks without one.
/// Whether each brings a message, and its instant.
fn turns_at_9600_baud() -> impl Iterator<Item = (bool, u64)> {
    (0..500_u64).flat_map(|i| [(false, 20 * i * MS), (true, 20 * i * MS + 487_000)])
}

/// A brain reports at the end of a tick, after a stall, that it stands still, and half a millisecond later, while that
/// is on the cable, the next message comes.
#[test]
fn after_a_stall_it_soon_answers_each_message_with_its_command_again() {
    for stall_ms in [1, 10, 33, 100, 110, 600, 1500] {
        for begun_ms in [0, 1, 15, 2000, 2013] {
            let mut bench = Bench::new(&FIVE);
            let stalled = begun_ms * MS..(begun_ms + stall_ms) * MS;
            let mut unanswered = Vec::new();
            for (is_message, at_ns) in turns_at_9600_baud().filter(|(_, at_ns)| !stalled.contains(at_ns)) {
                let mut turn = turn(&bench.body, at_ns, &[Some(&[0.1 + 1e-12 * at_ns as f64][..]); 6]);
                turn.readings.iter_mut().flatten().for_each(|reading| reading.readable = is_message);
                let is_answered = bench.avoid.step(&turn).signals.is_some();
                if is_message && !is_answered {
                    unanswered.push(at_ns / MS);
                }
            }
            let few = unanswered.len() <= 4;
            assert!(few, "{stall_ms} ms from {begun_ms} ms on: {} unanswered", unanswered.len());
        }
    }
}

#[test]
fn if_the_next_message_is_lost_it_answers_the_last_one_late_rather_than_never() {
    let mut bench = Bench::new(&FIVE);
    let mut said = |is_message: bool, at_us: u64| {
        let mut turn = turn(&bench.body, 1000 * at_us, &[Some(&[0.1][..]); 6]);
        turn.readings.iter_mut().flatten().for_each(|reading| reading.readable = is_message);
        let action = bench.avoid.step(&turn);
        (action.signals.is_some(), action.until.and_then(|until| until.at_latest_ns).unwrap() / 1000)
    };
    assert_eq!(said(false, 0), (true, 100_000), "blind");
    assert!(!said(true, 487).0, "the stop is on the cable");
    assert!(said(true, 20_487).0);
    let waits = (false, 43_282);
    assert_eq!(
        said(true, 27_000),
        waits,
        "it is free before that, but the next message may come from 33.5 ms on"
    );
    assert_eq!(said(false, 40_000), waits);
    assert!(said(false, 44_000).0);
}
