//! The internal state.

use super::fragment::Fragment;
use super::writer::{Writer, c, plain};
use crate::internal::{InternalState, InternalVariable};

/// The function `brain_feel`, which lets the internal state go on, scales what is sensed by it, and puts it behind that.
pub(super) fn write(writer: &mut Writer, internal: &InternalState, sensed: usize) {
    writer.field(format_args!("brain_real h[{}]", internal.variables.len()), "the internal state");
    writer.field("uint8_t is_dead", "a variable has come to a lethal boundary");
    let signature = "void brain_feel(struct brain *brain, brain_real seconds)";
    writer.function("The internal state.", signature, |writer| {
        writer.line("brain_real during, inflow_hz, next;");
        for (place, variable) in internal.variables.iter().enumerate() {
            writer.start(format_args!("h[{place}]"), c(variable.initial));
            self::variable(writer, place, variable);
        }
        for (place, variable) in internal.variables.iter().enumerate() {
            for (sensed, gain) in weighted(&variable.gain) {
                writer.line(format_args!("brain->z[{sensed}] *= 1 + {} * brain->h[{place}];", c(gain)));
            }
        }
        for place in 0..internal.variables.len() {
            writer.line(format_args!("brain->z[{}] = brain->h[{place}];", sensed + place));
        }
    });
}

fn variable(writer: &mut Writer, place: usize, variable: &InternalVariable) {
    let h = format!("brain->h[{place}]");
    writer.line(format_args!("/* {} */", plain(&variable.name)));
    writer.line("during = -0.0;");
    for (motor, rate_hz) in weighted(&variable.during) {
        writer.line(format_args!("if (brain->driving[{motor}]) during += {};", c(rate_hz)));
    }
    let release = sum(&variable.release).map_or_else(String::new, |sum| format!(" + ({sum})"));
    writer.line(format_args!("inflow_hz = {}{release} + during;", c(variable.rate_hz)));
    match variable.decay_s.map(c) {
        Some(decay_s) => writer.line(format_args!(
            "next = seconds >= {decay_s} ? {decay_s} * inflow_hz : {h} + seconds * (inflow_hz - {h} / {decay_s});"
        )),
        None => writer.line(format_args!("next = {h} + seconds * inflow_hz;")),
    }
    let [least, most] = variable.range.map(c);
    writer.uses(Fragment::Clamp);
    writer.line(format_args!("if (next == next) {h} = brain_clamp(next, {least}, {most});"));
    for (bound, comparison) in variable.lethal.iter().zip(["<=", ">="]) {
        if let Some(bound) = bound {
            writer.line(format_args!("if ({h} {comparison} {}) brain->is_dead = 1;", c(*bound)));
        }
    }
}

/// The places of the weights that count, with these.
fn weighted(weights: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    weights.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0)
}

/// The weighted sum of the state variables; `None` if none counts.
fn sum(weights: &[f64]) -> Option<String> {
    let terms: Vec<_> =
        weighted(weights).map(|(place, weight)| format!("{} * brain->z[{place}]", c(weight))).collect();
    (!terms.is_empty()).then(|| terms.join(" + "))
}
