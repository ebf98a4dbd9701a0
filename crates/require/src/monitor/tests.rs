use super::*;
use crate::Formula;

fn formula(text: &str) -> Formula<usize> {
    Formula::parse(text, |name, _| ["x_m", "y_m"].iter().position(|known| *known == name).ok_or(())).unwrap()
}

fn verdict(rule: Rule<usize>, from_ns: u64, samples: &[(u64, [f64; 2])]) -> (f64, bool, u64) {
    let mut monitor = Monitor::new(Requirement { rule, from_ns });
    for (time_ns, values) in samples {
        monitor.see(*time_ns, |&quantity| values[quantity]).unwrap();
    }
    let Verdict { robustness, holds, at_ns } = monitor.verdict();
    (robustness, holds, at_ns)
}

const SAMPLES: [(u64, [f64; 2]); 5] =
    [(0, [-5.0, 0.0]), (10, [1.0, 0.0]), (13, [3.0, -1.0]), (20, [1.0, 2.0]), (40, [3.0, 1.0])];

#[test]
fn the_first_of_the_extremes_decides() {
    let always = Rule::Always(formula("x_m > 0"));
    assert_eq!(verdict(always.clone(), 0, &SAMPLES), (-5.0, false, 0));
    assert_eq!(verdict(always, 1, &SAMPLES), (1.0, true, 10));
    assert_eq!(verdict(Rule::Never(formula("x_m > 0")), 0, &SAMPLES), (-3.0, false, 13));
    let eventually = |within_ns| Rule::Eventually { formula: formula("x_m > 0"), within_ns };
    assert_eq!(verdict(eventually(None), 0, &SAMPLES), (3.0, true, 13));
    assert_eq!(verdict(eventually(None), 14, &SAMPLES), (3.0, true, 40));
    assert_eq!(verdict(eventually(Some(12)), 0, &SAMPLES), (1.0, true, 10));
    assert_eq!(verdict(eventually(Some(6)), 14, &SAMPLES), (1.0, true, 20));
}

#[test]
fn a_reaction_has_its_time_and_the_end_cuts_it_off() {
    let whenever =
        |within_ns| Rule::Whenever { formula: formula("x_m > 0"), then: formula("y_m > 0"), within_ns };
    assert_eq!(verdict(whenever(10), 0, &SAMPLES), (1.0, true, 40));
    assert_eq!(verdict(whenever(9), 0, &SAMPLES), (0.0, false, 10));
    assert_eq!(verdict(whenever(6), 11, &SAMPLES), (-1.0, false, 13));
    // The trigger at 13 had time left.
    assert_eq!(verdict(whenever(100), 0, &SAMPLES[..3]), (-1.0, false, 13));
    assert_eq!(verdict(whenever(u64::MAX), 0, &SAMPLES), (1.0, true, 40));
}

#[test]
fn a_run_on_the_bound_holds_as_the_relation_says() {
    let touch = [(0, [1.0, 0.0]), (5, [0.0, 0.0])];
    assert_eq!(verdict(Rule::Always(formula("x_m >= 0")), 0, &touch), (0.0, true, 5));
    assert_eq!(verdict(Rule::Always(formula("x_m > 0")), 0, &touch), (0.0, false, 5));
    assert_eq!(verdict(Rule::Never(formula("y_m > 0")), 0, &touch), (0.0, true, 0));
    // Of two samples on the bound the one that fails decides.
    assert_eq!(
        verdict(Rule::Always(formula("x_m > 0 or y_m >= 0 and x_m >= 1")), 0, &touch),
        (0.0, false, 5)
    );
    assert_eq!(
        verdict(Rule::Always(formula("y_m >= 0 and (x_m > 0 or y_m > 0)")), 0, &touch),
        (0.0, false, 5)
    );
}

#[test]
fn without_samples_only_what_must_happen_fails() {
    let infinity = f64::INFINITY;
    for samples in [&[][..], &SAMPLES] {
        let formula = || formula("x_m > 0");
        assert_eq!(verdict(Rule::Always(formula()), 41, samples), (infinity, true, 41));
        assert_eq!(verdict(Rule::Never(formula()), 41, samples), (infinity, true, 41));
        let whenever = Rule::Whenever { formula: formula(), then: formula(), within_ns: 9 };
        assert_eq!(verdict(whenever, 41, samples), (infinity, true, 41));
        let eventually = Rule::Eventually { formula: formula(), within_ns: None };
        assert_eq!(verdict(eventually, 41, samples), (-infinity, false, 41));
    }
}

#[test]
fn samples_must_come_in_order() {
    let mut monitor = Monitor::new(Requirement { rule: Rule::Always(formula("x_m > 0")), from_ns: 0 });
    monitor.see(7, |_| 1.0).unwrap();
    let error = monitor.see(7, |_| -1.0).unwrap_err();
    assert_eq!(error, OrderError { time_ns: 7, last_ns: 7 });
    assert_eq!(monitor.verdict(), Verdict { robustness: 1.0, holds: true, at_ns: 7 });
}

#[test]
fn a_window_remembers_no_more_than_its_time() {
    let rule = Rule::Whenever { formula: formula("x_m > 0"), then: formula("y_m > 0"), within_ns: 100 };
    let mut monitor = Monitor::new(Requirement { rule, from_ns: 0 });
    for time_ns in 0..10_000 {
        monitor.see(time_ns, |_| -(time_ns as f64)).unwrap();
        assert!(monitor.window.open().count() <= 101, "at {time_ns}");
    }
}

#[test]
fn requirements_and_verdicts_are_sentences() {
    let (x, y) = (|| formula("x_m>1"), || formula("y_m<0.1"));
    for (rule, from_ns, sentence) in [
        (Rule::Always(x()), 0, "always x_m > 1"),
        (Rule::Never(x()), 1_500_000_000, "never x_m > 1, from 1.5 s on"),
        (Rule::Eventually { formula: x(), within_ns: None }, 0, "eventually x_m > 1"),
        (Rule::Eventually { formula: x(), within_ns: Some(2) }, 0, "eventually x_m > 1 within 0.000000002 s"),
        (
            Rule::Whenever { formula: x(), then: y(), within_ns: 500_000_000 },
            1_000_000_000,
            "whenever x_m > 1 then y_m < 0.1 within 0.5 s, from 1 s on",
        ),
    ] {
        assert_eq!(Requirement { rule, from_ns }.to_string(), sentence);
    }
    let verdict = |robustness, holds| Verdict { robustness, holds, at_ns: 1_250_000_000 }.to_string();
    assert_eq!(verdict(0.05, true), "holds by 0.05 at 1.25 s");
    assert_eq!(verdict(0.0, false), "fails by 0 at 1.25 s");
    assert_eq!(verdict(f64::NEG_INFINITY, false), "fails by ∞ at 1.25 s");
}
