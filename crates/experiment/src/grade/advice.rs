//! Words that an exercise has for a typical mistake, and the conditions under which they are shown.

use crate::error::Error;
use crate::success::{Conditions, Quantity};

use crate::grade::measure::Measure;
use crate::grade::raw;
use crate::grade::watch::Measures;

/// Words for a mistake. They are shown only if an exercise is not passed.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The conditions of a run in which the mistake was made.
    pub when: Conditions<Measure>,
    /// The words, with names of measures in braces for their values.
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
enum Part {
    Text(String),
    Value(Measure),
}

impl Advice {
    pub(crate) fn new(i: usize, raw: raw::Advice) -> Result<Self, Error> {
        let at = format!("advice[{i}].say");
        let when = Conditions::new(&format!("advice[{i}].when"), &raw.when)?;
        if raw.say.trim().is_empty() {
            return Err(Error::field(at, "is empty; describe the mistake, and its remedy"));
        }
        let mut parts = Vec::new();
        for (place, piece) in raw.say.trim().split('{').enumerate() {
            let text = match (place, piece.split_once('}')) {
                (0, _) => piece,
                (_, Some((name, rest))) => {
                    let measure = Measure::named(name).map_err(|error| Error::field(&at, error))?;
                    parts.push(Part::Value(measure));
                    rest
                }
                (_, None) => {
                    let problem = "has a brace that is not closed; write {MEASURE}, such as {turned_rad}";
                    return Err(Error::field(at, problem));
                }
            };
            parts.push(Part::Text(text.to_owned()));
        }
        Ok(Self { when, parts })
    }

    /// The words for a run, if the mistake was made in it.
    pub fn words(&self, measures: &Measures) -> Option<String> {
        let word = |part: &Part| match part {
            Part::Text(text) => text.clone(),
            Part::Value(measure) => match measures.get(*measure) {
                None => "?".to_owned(),
                Some(share) if measure.is_share() => format!("{} %", shown(100.0 * share)),
                Some(value) => shown(value),
            },
        };
        let is_meant = self.when.hold(|measure| measures.get(measure));
        is_meant.then(|| self.parts.iter().map(word).collect())
    }
}

/// A value as people want to read it: three digits, or all before the point.
pub(crate) fn shown(value: f64) -> String {
    let digits = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        _ => 3,
    };
    let text = format!("{value:.digits$}");
    let text = if digits > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_three_digits() {
        for (value, expected) in
            [(0.0, "0"), (-0.0, "0"), (0.1234, "0.123"), (1.25, "1.25"), (-12.34, "-12.3"), (2000.0, "2000")]
        {
            assert_eq!(shown(value), expected);
        }
    }

    #[test]
    fn a_brace_must_be_closed() {
        let when: toml::Table = "collisions_at_least = 1".parse().unwrap();
        let raw = raw::Advice { when, say: "turned {turned_rad".to_owned() };
        let error = Advice::new(2, raw).unwrap_err().to_string();
        assert!(error.starts_with("advice[2].say: has a brace that is not closed"), "{error}");
    }
}
