//! Presets agree with real robots wherever the page of evidence states it.

use baudbot_experiment::evidence::{Comparison, comparisons};
use baudbot_scenario::presets::preset;

/// The parts of a comparison that differ from its statement.
fn surprises(comparison: &Comparison) -> Vec<String> {
    let points = comparison.run().unwrap_or_else(|error| panic!("{}: {error}", comparison.name));
    let is_surprise = |point: &&baudbot_experiment::evidence::Compared<'_>| {
        point.agrees == point.measured.disagrees.is_some()
    };
    let words = |point: baudbot_experiment::evidence::Compared<'_>| {
        let (measured, simulated) = (point.measured, point.simulated);
        format!(
            "{} at {}: measured {} ± {:?}, simulated {:.4} ± {:.4}",
            comparison.name, measured.at, measured.mean, measured.sd, simulated.mean, simulated.sd
        )
    };
    points.iter().filter(is_surprise).cloned().map(words).collect()
}

#[test]
fn every_point_agrees_unless_it_says_why_not() {
    let surprises: Vec<_> = comparisons().iter().flat_map(surprises).collect();
    assert!(surprises.is_empty(), "{}", surprises.join("\n"));
}

#[test]
fn every_comparison_is_about_presets() {
    for comparison in comparisons() {
        for name in &comparison.presets {
            assert!(preset(name).is_some(), "{}: there is no preset {name}", comparison.name);
        }
        assert!(!comparison.points.is_empty());
    }
}
