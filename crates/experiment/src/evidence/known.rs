//! The summary of a preset's sources, in a line.

use baudbot_plot::quantity::count;
use baudbot_scenario::presets::{Preset, Standing};

use crate::evidence::comparison::comparisons;
use crate::evidence::fields::fields;

/// The sources of a preset's numbers: how many have one, and the comparisons with a real robot. Parts that are
/// presets of their own have a line of their own.
pub fn known(preset: &Preset) -> String {
    let standings: Vec<_> = preset.facts().into_iter().filter_map(|fact| fact.standing).collect();
    let guesses = standings.iter().filter(|standing| **standing == Standing::Guess).count();
    let sourced = match (standings.len(), guesses) {
        (0, _) => "no numbers of its own".into(),
        (n, 0) => format!("{} from a source", count(n, "number")),
        (n, _) => format!("{} of {} from a source", n - guesses, count(n, "number")),
    };
    match compared(preset.name) {
        (0, 0) => format!("{sourced}; not compared with a real one"),
        (agree, 0) => format!("{sourced}; agrees with a real one in {}", count(agree, "point")),
        (agree, differ) => {
            format!("{sourced}; agrees with a real one in {agree} of {}", count(agree + differ, "point"))
        }
    }
}

/// Points and fields of a preset that agree with measurements, and those that do not.
fn compared(preset: &str) -> (usize, usize) {
    let of_preset = |names: &[String]| names.iter().any(|name| name == preset);
    let points = comparisons().into_iter().filter(|comparison| of_preset(&comparison.presets));
    let points = points.flat_map(|comparison| comparison.points).map(|point| point.disagrees.is_none());
    let fields = fields().into_iter().filter(|field| field.preset == preset);
    let fields = fields.map(|field| field.disagrees.is_none());
    let (agree, differ): (Vec<bool>, _) = points.chain(fields).partition(|agrees| *agrees);
    (agree.len(), differ.len())
}
