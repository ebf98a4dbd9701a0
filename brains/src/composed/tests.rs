use super::*;
use crate::description::Description;
use crate::registry::Registry;
use crate::test_body::{body, turn};

const MS: u64 = 1_000_000;

fn robot() -> Body {
    body(&[("odometer", "odometer", 0.0)])
}

/// Goes straight on, with signals of 0.4.
fn going() -> Composed {
    let toml = "motor.go = { kind = \"go_to\", parameters = { points_m = [[9.0, 0.0]] } }\n\
                cognitive.odometry = { kind = \"odometry\" }";
    Description::parse(toml).unwrap().brain(1, &robot(), &Registry::standard()).unwrap()
}

/// The brain's stated intention, and the signal of the left wheel if it sends one, in a turn with a reading of this
/// age, or with none.
fn step(brain: &mut Composed, at_ms: u64, age_ms: Option<u64>) -> (String, Option<f64>) {
    let mut turn = turn(&robot(), at_ms * MS, &[age_ms.map(|_| &[0.0; 3][..])]);
    if let (Some(age_ms), Some(reading)) = (age_ms, &mut turn.readings[0]) {
        reading.sampled_at_ns = Some(at_ms.saturating_sub(age_ms) * MS);
    }
    let signals = brain.step(&turn).signals;
    (brain.belief().unwrap().state, signals.map(|signals| signals.left))
}

#[test]
fn who_goes_by_odometry_that_is_overdue_stands_and_says_what_it_waits_for() {
    let mut brain = going();
    assert_eq!(step(&mut brain, 0, None), ("go: waits for `odometer` since 0.00 s".to_owned(), Some(0.0)));
    for at_ms in (100..=1000).step_by(100) {
        assert_eq!(step(&mut brain, at_ms, Some(5)), ("go".to_owned(), Some(0.4)));
    }
    assert_eq!(step(&mut brain, 1500, None), ("go".to_owned(), Some(0.4)));
    assert_eq!(step(&mut brain, 1510, None), ("go: waits for `odometer` since 1.00 s".to_owned(), Some(0.0)));
    assert_eq!(step(&mut brain, 1800, Some(5)), ("go".to_owned(), Some(0.4)));
}

/// A cable on which a reading takes 0.7 s.
#[test]
fn odometry_that_always_comes_seldom_is_not_overdue() {
    let mut brain = going();
    for at_ms in (100..5000).step_by(700) {
        step(&mut brain, at_ms, Some(5));
    }
    let (state, signal) = step(&mut brain, 6000, None);
    assert!(state == "go" && signal.is_some_and(|signal| signal > 0.0), "{state}, {signal:?}");
}

#[test]
fn the_older_odometry_is_the_slower_it_drives() {
    let last = |age_ms: u64| {
        let mut brain = going();
        (1..20).map(|i| step(&mut brain, 1000 + 100 * i, Some(age_ms)).1.unwrap()).last().unwrap()
    };
    assert_eq!([last(0), last(140)], [0.4, 0.4]);
    let command_s = robot().command_ns() as f64 * 1e-9;
    for age_s in [0.2, 0.4, 0.9] {
        let (found, expected) = (last((1e3 * age_s) as u64), 0.4 * 0.25 / (age_s + 0.1 + command_s));
        assert!((found - expected).abs() < 1e-9, "{age_s} s: {found} is not {expected}");
    }
}
