//! Factors: a field that is varied, or several together, with their values.

use std::collections::BTreeSet;

use toml::Value;

use baudbot_run::UnknownName;

use crate::error::Error;
use crate::raw;

/// Something that is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The name of the field in tables and charts.
    pub label: String,
    /// The unit of its values; empty if it has none.
    pub unit: String,
    /// The field's values.
    pub choice: Choice,
}

/// The values that something can have.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// A list of values; at least one.
    Levels(Vec<Level>),
    /// Any number of a range.
    Range(Range),
}

/// One of the values of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The name of the level in tables and charts.
    pub name: String,
    /// The value, if it is a number.
    pub number: Option<f64>,
    /// The fields that it changes.
    pub settings: Vec<Setting>,
}

/// Something that a level changes.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A field of the scenario.
    Scenario {
        /// The field's path in the scenario.
        path: String,
        /// The field's value, as TOML.
        value: String,
    },
    /// A parameter of the brains of the catalogue that have it.
    Parameter {
        /// The name of the parameter.
        name: String,
        /// The value of the parameter.
        value: String,
    },
    /// The brain of all robots that have not one of their own.
    Brain(String),
}

/// Numbers from one to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The target that is set to them: a path or `brain.PARAMETER`.
    pub target: String,
    /// The least.
    pub from: f64,
    /// The most; more than the least.
    pub to: f64,
    /// Whether equal ratios are equally likely, and not equal differences.
    pub log: bool,
    /// The field takes only whole numbers.
    pub whole: bool,
}

impl Range {
    /// The number that so much of the range, from 0 to 1, lies below.
    pub fn at(&self, share: f64) -> f64 {
        let number = match self.log {
            true => self.from * (self.to / self.from).powf(share),
            false => self.from + (self.to - self.from) * share,
        };
        if self.whole { number.round() } else { number }.clamp(self.from, self.to)
    }

    /// The fraction of the range below a number, from 0 to 1.
    pub fn share(&self, number: f64) -> f64 {
        match self.log {
            true => (number / self.from).ln() / (self.to / self.from).ln(),
            false => (number - self.from) / (self.to - self.from),
        }
    }

    /// A level with this number.
    pub fn level(&self, number: f64) -> Level {
        // A whole number that is written with a point would be none in TOML.
        let value = if self.whole { Value::Integer(number as i64) } else { Value::Float(number) };
        Level { name: name(&value), number: Some(number), settings: vec![setting(&self.target, &value)] }
    }
}

impl Field {
    /// The field's levels, if there is a list of them.
    pub fn levels(&self) -> Option<&[Level]> {
        match &self.choice {
            Choice::Levels(levels) => Some(levels),
            Choice::Range(_) => None,
        }
    }

    /// Whether all its values are numbers.
    pub fn is_numeric(&self) -> bool {
        self.levels().is_none_or(|levels| levels.iter().all(|level| level.number.is_some()))
    }

    /// The label of the field with its unit.
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }

    pub(crate) fn new(path: &str, mut raw: raw::Field) -> Result<Self, Error> {
        let at = |name: &str| format!("{path}.{name}");
        let label = match (&raw.label, &raw.field) {
            (Some(label), _) | (None, Some(label)) => label.trim().to_owned(),
            (None, None) => {
                return Err(Error::field(at("label"), "is missing: the name of these levels in tables"));
            }
        };
        let unit = raw.unit.clone().unwrap_or_default();
        let range = raw.from.is_some() || raw.to.is_some() || raw.log.is_some() || raw.whole.is_some();
        let levels = raw.levels.take();
        let choice = match (&raw.values, levels, range) {
            (Some(values), None, false) => values_of(path, target(path, raw.field.as_deref())?, values)?,
            (None, Some(levels), false) if raw.field.is_none() => levels_of(path, levels)?,
            (None, Some(_), false) => {
                return Err(Error::field(
                    at("field"),
                    "goes with `values`; each of `levels` lists what it sets",
                ));
            }
            (None, None, true) => range_of(path, &raw)?,
            (None, None, false) => {
                return Err(Error::field(path, "has no values; give `values`, `levels`, or `from` and `to`"));
            }
            _ => {
                return Err(Error::field(path, "give one of `values`, `levels`, and `from` with `to`"));
            }
        };
        Ok(Self { label, unit, choice })
    }
}

impl Setting {
    /// The setting as an argument of `--set`, if it is a field of the scenario.
    pub fn as_override(&self) -> Option<String> {
        match self {
            Self::Scenario { path, value } => Some(format!("{path}={value}")),
            Self::Parameter { .. } | Self::Brain(_) => None,
        }
    }
}

fn target<'a>(path: &str, field: Option<&'a str>) -> Result<&'a str, Error> {
    let missing =
        || Error::field(format!("{path}.field"), "is missing: the path of the field that has these values");
    let field = field.map(str::trim).ok_or_else(missing)?;
    checked(&format!("{path}.field"), field)?;
    Ok(field)
}

/// Checks that a path can be varied.
fn checked(at: &str, field: &str) -> Result<(), Error> {
    if field.is_empty() || field.contains('=') {
        return Err(Error::field(at, format!("`{field}` is not a path such as robots.robot.link.baud")));
    }
    if field == "seed" {
        return Err(Error::field(at, "the seed is varied by `seeds`"));
    }
    Ok(())
}

fn values_of(path: &str, target: &str, values: &[Value]) -> Result<Choice, Error> {
    let at = format!("{path}.values");
    let level = |value: &Value| Level {
        name: name(value),
        number: number(value),
        settings: vec![setting(target, value)],
    };
    some(&at, values.iter().map(level).collect())
}

fn levels_of(path: &str, levels: Vec<raw::Level>) -> Result<Choice, Error> {
    let mut all = Vec::new();
    for (i, level) in levels.into_iter().enumerate() {
        let at = format!("{path}.levels[{i}].set");
        let parse = |text: &String| {
            let problem = || {
                Error::field(&at, format!("`{text}` is not PATH=VALUE, such as robots.robot.link.baud=9600"))
            };
            let (target, value) = text.split_once('=').ok_or_else(problem)?;
            checked(&at, target.trim())?;
            Ok(written(target.trim(), value.trim()))
        };
        let settings = level.set.iter().map(parse).collect::<Result<_, Error>>()?;
        all.push(Level { name: level.name, number: None, settings });
    }
    some(&format!("{path}.levels"), all)
}

fn some(at: &str, levels: Vec<Level>) -> Result<Choice, Error> {
    if levels.is_empty() {
        return Err(Error::field(at, "is empty, so there is nothing to run; give at least one"));
    }
    let mut names = BTreeSet::new();
    if let Some(again) = levels.iter().find(|level| !names.insert(&level.name)) {
        return Err(Error::field(at, format!("`{}` appears twice", again.name)));
    }
    Ok(Choice::Levels(levels))
}

fn range_of(path: &str, raw: &raw::Field) -> Result<Choice, Error> {
    let at = |name: &str| format!("{path}.{name}");
    let target = target(path, raw.field.as_deref())?.to_owned();
    let end = |name, value: Option<f64>| {
        let value = value
            .ok_or_else(|| Error::field(at(name), "is missing: a range goes `from` a number `to` another"))?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Error::field(at(name), format!("must be a number, is {value}")))
        }
    };
    let (from, to) = (end("from", raw.from)?, end("to", raw.to)?);
    let (log, whole) = (raw.log.unwrap_or(false), raw.whole.unwrap_or(false));
    if from >= to {
        return Err(Error::field(at("to"), format!("must be more than `from`, {from}, is {to}")));
    }
    if log && from <= 0.0 {
        return Err(Error::field(at("from"), format!("must be positive for `log`, is {from}")));
    }
    if whole && (from.fract() != 0.0 || to.fract() != 0.0 || from.abs().max(to.abs()) > MOST_WHOLE) {
        return Err(Error::field(
            at("whole"),
            format!("`from` and `to` must then be whole numbers of moderate size, are {from} and {to}"),
        ));
    }
    Ok(Choice::Range(Range { target, from, to, log, whole }))
}

fn setting(target: &str, value: &Value) -> Setting {
    match value.as_str() {
        Some(text) if target == BRAIN => Setting::Brain(text.to_owned()),
        _ => written(target, &value.to_string()),
    }
}

fn written(target: &str, value: &str) -> Setting {
    match target.strip_prefix("brain.") {
        Some(name) => Setting::Parameter { name: name.to_owned(), value: value.to_owned() },
        None if target == BRAIN => Setting::Brain(value.trim_matches('"').to_owned()),
        None => Setting::Scenario { path: target.to_owned(), value: value.to_owned() },
    }
}

/// The text of a value for tables, without quotes.
fn name(value: &Value) -> String {
    let text = value.as_str().map(str::to_owned);
    text.or_else(|| value.as_float().map(|number| number.to_string())).unwrap_or_else(|| value.to_string())
}

/// A finite number.
pub(crate) fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|number| number as f64);
    whole.or_else(|| value.as_float().filter(|number| number.is_finite()))
}

/// The word for the brain itself in the place of a field.
const BRAIN: &str = "brain";

/// Above it not every whole number is an `f64`.
const MOST_WHOLE: f64 = 9e15;

/// The place of a field by its label, or by the path that it varies.
///
/// # Errors
/// If there is none, with those that there are.
pub(crate) fn place(fields: &[Field], name: &str) -> Result<usize, UnknownName> {
    let is_target = |field: &Field| {
        let first = match &field.choice {
            Choice::Range(range) => return range.target == name,
            Choice::Levels(levels) => levels.first(),
        };
        matches!(first.map(|level| level.settings.as_slice()), Some([Setting::Scenario { path, .. }]) if path == name)
            || matches!(
                first.map(|level| level.settings.as_slice()),
                Some([Setting::Parameter { name: own, .. }]) if name.strip_prefix("brain.") == Some(own)
            )
    };
    let labels: Vec<_> = fields.iter().map(|field| field.label.as_str()).collect();
    let found = labels.iter().position(|label| *label == name).or_else(|| fields.iter().position(is_target));
    found.ok_or_else(|| UnknownName::new("field", name, &labels))
}
