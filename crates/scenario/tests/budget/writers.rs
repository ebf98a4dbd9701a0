//! Whatever the scenario and whenever its brain writes: no cycle is longer than the bound of a budget with these times,
//! and the median is the one that was foretold.
//!
//! 200 scenarios here. A thousand, with how tight the bounds are:
//!
//! ```sh
//! PROPTEST_CASES=1000 BUDGET_SECONDS=10 cargo test --release -p baudbot-scenario --test files budget::writers -- --nocapture
//! ```

use std::sync::Arc;

use baudbot_scenario::budget::{RobotBudget, Verdict};
use baudbot_sim::Scenario;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

use crate::budget::random::{config, scenarios};
use crate::budget::run::{Measured, Writer, run_writing};

/// A scenario whose brain is stated to write as this one does.
fn told(toml: &str, writer: Writer) -> Scenario {
    let mut scenario = baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}\n{toml}"));
    let writes = writer.writes(scenario.step_ns);
    Arc::make_mut(&mut scenario.robots[0].model).writes = Some(writes);
    scenario
}

/// Whether a median can be foretold: what depends on the world or on chance has none that a scenario knows, and what has more
/// to do than time gets later and later.
fn has_median(toml: &str, budget: &RobotBudget) -> bool {
    let depends =
        ["sonar", "bluetooth", "jitter_us", "gps", "noise = true"].iter().any(|part| toml.contains(part));
    let is_overloaded = budget.loads.iter().any(|load| load.share > 1.0);
    !depends && !is_overloaded && budget.cycle.total.worst_ns.is_some()
}

/// The fault of a run, and the distance of its longest cycle from the bound.
fn held(toml: &str, budget: &RobotBudget, measured: &Measured) -> Result<Option<f64>, String> {
    let robot = measured.world.robot(0);
    let cycles = robot.cycles();
    if cycles.exceptions.writes > 0 {
        return Err(format!("wrote what is not stated: {:?}", cycles.exceptions));
    }
    // Pieces of two commands may make one if bytes were refused or lost, and then it came with the second.
    let Some(longest) = cycles.durations.max_ns().filter(|_| robot.downlink().lost() == 0) else {
        return Ok(None);
    };
    let total = budget.cycle.total;
    if let Some(worst) = total.worst_ns.filter(|worst| longest > *worst) {
        return Err(format!("{longest} is beyond {worst}"));
    }
    let quantile = |q: f64| cycles.durations.quantile_ns(q).unwrap_or(0) as f64;
    let typical = total.typical_ns.map_or(f64::NAN, |ns| ns as f64);
    // The first cycles decide between the durations in which the two halves meet.
    let is_foretold = 0.98 * quantile(0.45) <= typical && typical <= 1.02 * quantile(0.55);
    if !is_foretold && cycles.durations.count() >= 30 && has_median(toml, budget) {
        return Err(format!("typical {typical}, measured {}", quantile(0.5)));
    }
    Ok(total.worst_ns.map(|worst| longest as f64 / worst as f64))
}

#[test]
fn no_cycle_is_longer_than_the_bound_for_a_brain_that_writes_as_stated() {
    let config = config(200);
    let cases = config.cases;
    let seconds = std::env::var("BUDGET_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(1.0);
    let mut runner = TestRunner::new(config);
    let (mut ratios, mut wrong, mut medians) = (Vec::new(), Vec::new(), 0);
    for case in 0..cases {
        let toml = scenarios().new_tree(&mut runner).unwrap().current();
        for writer in Writer::ALL {
            let scenario = told(&toml, writer);
            let budget = RobotBudget::without_remedies(&scenario, &scenario.robots[0]);
            let measured = run_writing(scenario, seconds, writer);
            medians += u32::from(has_median(&toml, &budget));
            match held(&toml, &budget, &measured) {
                Ok(ratio) => ratios.extend(ratio.map(|ratio| (writer, ratio))),
                Err(what) => wrong.push(format!("{case}, {writer:?}: {what} ({:?})\n{toml}", budget.verdict)),
            }
            let has_cycles = measured.world.robot(0).cycles().durations.count() > 0;
            assert!(writer != Writer::Never || !has_cycles, "{case}: cycles without a command");
        }
    }
    wrong.iter().for_each(|wrong| println!("WRONG {wrong}"));
    println!("{cases} scenarios, {} bounds, {medians} medians; longest by bound:", ratios.len());
    for writer in Writer::ALL {
        let mut of: Vec<f64> =
            ratios.iter().filter(|(its, _)| *its == writer).map(|(_, ratio)| *ratio).collect();
        of.sort_by(f64::total_cmp);
        let share =
            |q: f64| of.get((q * of.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(f64::NAN);
        println!(
            "{writer:?}: {} bounds, median {:.3}, 5 % below {:.3}, least {:.3}",
            of.len(),
            share(0.5),
            share(0.05),
            share(0.0)
        );
    }
    assert!(
        ratios.len() > cases as usize && medians > cases / 4,
        "{} bounds, {medians} medians",
        ratios.len()
    );
    assert!(wrong.is_empty(), "{} are wrong; the first: {}", wrong.len(), wrong[0]);
}

/// A finding of a review: `wander` writes in ticks without news, and its next command waits behind those. A budget
/// for a brain that answers messages says that 13 ms are met; one for this brain must not.
#[test]
fn a_brain_that_writes_every_tick_does_not_meet_what_one_that_answers_meets() {
    let toml = include_str!("every_tick.toml");
    let of = |writer: Writer| {
        let scenario = told(toml, writer);
        let budget = RobotBudget::without_remedies(&scenario, &scenario.robots[0]);
        let measured = run_writing(scenario, 10.0, writer);
        let longest = measured.world.robot(0).cycles().durations.max_ns().unwrap();
        (budget, longest)
    };
    let (answers, longest) = of(Writer::OnMessage);
    assert_eq!(answers.verdict, Verdict::Keeps);
    assert!(longest <= 13_000_000 && Some(longest) <= answers.cycle.total.worst_ns, "{longest}");
    let (unasked, longest) = of(Writer::EveryTick);
    assert_eq!((longest, unasked.verdict != Verdict::Keeps), (15_470_334, true));
    assert!(unasked.cycle.total.worst_ns >= Some(longest), "{:?}", unasked.cycle);
}
