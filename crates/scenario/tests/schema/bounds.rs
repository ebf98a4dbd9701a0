//! Each bound of the schema is the parser's: what is beyond it both refuse, the bound itself both take, and where there is none the parser
//! has none either.

use baudbot_scenario::ScenarioError;
use serde_json::{Value, json};

use crate::schema::corpus::{SCHEMA, parsed, path, places, scenarios};
use crate::schema::validator::{Bounds, findings, is_valid};

/// Fields of which the parser refuses more because of another field, with the reason.
const NARROWER: [(&str, &str); 38] = [
    ("/lit_ms", "`blink_ms` is longer"),
    ("/metrics/cell_m", "the arena has so many cells"),
    ("/points_m", "an outline does not cross itself"),
    ("/outline_m", "an outline does not cross itself"),
    ("/adapter/latency_ms", "an FTDI chip has 1 to 255"),
    ("/adapter/packet_bytes", "an FTDI chip has up to 510"),
    ("/adapter/spread_ms", "`latency_ms` is longer"),
    ("/laptop_buffer_bytes", "the longest message fits into it"),
    ("/firmware/gap_ms", "a character and the delays of the adapter are shorter"),
    ("/encoders/bits", "a counter has 8 to 32"),
    ("/flow/bits", "a counter has 8 to 32"),
    ("/steps/bits", "a counter has 8 to 32"),
    ("/mount/x_m", "it is near the body"),
    ("/mount/y_m", "it is near the body"),
    ("/full_scale", "`bits` have no larger code"),
    ("/converter_bits", "there are as many `bits`"),
    ("/first_step", "the last step has four digits"),
    ("/min_m", "the range is longer"),
    ("/wall_range_m", "`max_m` is shorter"),
    ("/lower_edge_m", "`height_m` is higher"),
    ("/trail/cell_m", "cells are fewer"),
    ("/trail/size_m", "cells are fewer"),
    ("/trail/diffusion_m2_s", "cells are larger"),
    ("/idle_v", "`supply_v` is higher"),
    ("/clock/spread_ms", "`period_ms` is longer"),
    ("/clock/jitter_ms", "`period_ms` is longer"),
    ("/urg/period_ms", "`sweep_ms` is shorter"),
    ("/memory_bytes", "`ram_bytes` are more"),
    ("/operations", "a step takes up to 1000 s"),
    ("/for_s", "`every_s` is longer"),
    ("/capacity_a_share", "currents increase"),
    ("/curve_share_v", "shares increase"),
    ("/curve_us_rpm", "widths increase"),
    ("/curve_signal_share", "signals increase"),
    ("/curve_m_v", "distances increase"),
    ("/distances_m", "distances increase"),
    ("/band_hz", "frequencies increase"),
    ("/angles_rad", "angles increase"),
];

#[test]
fn bounds_are_the_parsers() {
    let mut wrong = Vec::new();
    let (mut bounds, mut taken) = (0, 0);
    for scenario in scenarios() {
        let found = findings(&SCHEMA, &scenario).numbers;
        for place in places(&scenario) {
            if !scenario.pointer(&place).unwrap().is_number() {
                continue;
            }
            let of_place =
                *found.get(&place).unwrap_or_else(|| panic!("{place}: the schema has nothing of it"));
            if of_place.is_one_of {
                continue;
            }
            let tried = Tried { scenario: &scenario, place: &place, bounds: of_place };
            for (number, is_taken) in tried.numbers() {
                bounds += usize::from(is_taken);
                match tried.told(number, is_taken) {
                    Told::AsTheSchema => taken += usize::from(is_taken),
                    Told::OfAnother => {}
                    Told::Otherwise(problem) => wrong.push(problem),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // The other bounds depend on another field, by the parser's answer.
    assert!(bounds > 400 && taken * 10 > bounds * 7, "of {bounds} bounds {taken} are taken");
}

/// A number of a scenario.
struct Tried<'a> {
    scenario: &'a Value,
    place: &'a str,
    bounds: Bounds,
}

/// The parser's answer to another number there.
enum Told {
    AsTheSchema,
    /// Another field does not fit to the number.
    OfAnother,
    Otherwise(String),
}

impl Tried<'_> {
    /// Numbers to try, and whether each is in the bounds.
    fn numbers(&self) -> Vec<(f64, bool)> {
        let Bounds { least, above, most, is_whole, .. } = self.bounds;
        let step = |bound: f64| if is_whole { 1.0 } else { (bound.abs() * 1e-9).max(1e-12) };
        let far = if is_whole { 1e15 } else { 1e300 };
        let below = match (least, above) {
            (Some(least), _) => vec![(least, true), (least - step(least), false)],
            (None, Some(above)) => vec![(above, false)],
            (None, None) => vec![(-far, true)],
        };
        let beyond =
            most.map_or_else(|| vec![(far, true)], |most| vec![(most, true), (most + step(most), false)]);
        [below, beyond].concat()
    }

    fn told(&self, number: f64, is_taken: bool) -> Told {
        let mut changed = self.scenario.clone();
        let whole = self.bounds.is_whole.then(|| json!(number as i64));
        *changed.pointer_mut(self.place).unwrap() = whole.unwrap_or_else(|| json!(number));
        assert_eq!(is_valid(&SCHEMA, &changed), is_taken, "{} = {number:e}, in the schema", self.place);
        let told = parsed(&changed);
        let is_own = told.as_ref().is_err_and(|error| self.is_about_this(error));
        match (told, is_taken) {
            (Ok(()), true) => Told::AsTheSchema,
            (Err(_), false) if is_own => Told::AsTheSchema,
            (Err(_), true) if !is_own => Told::OfAnother,
            (Err(_), true) if NARROWER.iter().any(|(field, _)| self.field().ends_with(field)) => {
                Told::OfAnother
            }
            (told, _) => Told::Otherwise(format!("{} = {number:e}: {told:?}", self.place)),
        }
    }

    /// The field of the number; for a number in lists that of the lists.
    fn field(&self) -> &str {
        self.place.trim_end_matches(|c: char| c.is_ascii_digit() || c == '/')
    }

    fn is_about_this(&self, error: &ScenarioError) -> bool {
        let ScenarioError::Field { path: refused, .. } = error else { return false };
        // Of a program, which may be a text, too, the parser names the whole.
        let is_of_program = self.place.contains("/program/") && refused.ends_with(".program");
        is_of_program || refused.starts_with(&path(self.field()))
    }
}
