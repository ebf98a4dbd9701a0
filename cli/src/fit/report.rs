//! The results, as TOML for a scenario and as JSON.

use baudbot_fit::estimate::{Estimate, Finding, Fitted, Outcome, Remark, digits};
use baudbot_fit::fields::catalogue;
use baudbot_fit::log::{Log, Quantity};
use baudbot_scenario::ScenarioError;
use serde_json::{Value, json};

use super::subject::Subject;

/// A finding, and how it is written.
struct Line<'a> {
    finding: &'a Finding,
    /// Path and value that the scenario takes, or why it takes none.
    setting: Option<Result<(String, String), ScenarioError>>,
}

/// The findings of a fit.
pub(super) struct Report<'a> {
    subject: &'a Subject,
    log: &'a Log,
    lines: Vec<Line<'a>>,
    remarks: &'a [Remark],
}

impl<'a> Report<'a> {
    pub(super) fn new(subject: &'a Subject, log: &'a Log, fitted: &'a Fitted) -> Self {
        let found = fitted.findings.iter().filter(|finding| finding.is_field);
        let found = found.filter_map(|finding| match &finding.outcome {
            Outcome::Estimate(estimate) => Some((finding.path.as_str(), value(estimate))),
            Outcome::CannotTell(_) => None,
        });
        let found: Vec<_> = found.collect();
        let line = |finding: &'a Finding| {
            let setting = match &finding.outcome {
                Outcome::Estimate(estimate) if finding.is_field => {
                    let value = value(estimate);
                    Some(subject.setting(&finding.path, &value, &found).map(|path| (path, value)))
                }
                Outcome::Estimate(_) | Outcome::CannotTell(_) => None,
            };
            Line { finding, setting }
        };
        Self { subject, log, lines: fitted.findings.iter().map(line).collect(), remarks: &fitted.remarks }
    }

    pub(super) fn toml(&self) -> String {
        let rows = self.log.len();
        let mut text = format!("# {}, {rows} rows, {}; 95 % intervals\n", self.log.file, self.subject.label);
        for remark in self.remarks {
            text += &format!("# note: {remark}\n");
        }
        for line in &self.lines {
            text += &line.toml();
            text.push('\n');
        }
        text
    }

    pub(super) fn json(&self) -> Value {
        let lines = self.lines.iter().map(|line| line.json(self.subject));
        json!({
            "log": self.log.file,
            "rows": self.log.len(),
            "of": self.subject.label,
            "numbers": lines.collect::<Value>(),
            "notes": self.remarks.iter().map(ToString::to_string).collect::<Value>(),
            "warnings": self.log.warnings.iter().map(ToString::to_string).collect::<Value>(),
        })
    }
}

impl Line<'_> {
    fn toml(&self) -> String {
        let path = &self.finding.path;
        match (&self.finding.outcome, &self.setting) {
            (Outcome::Estimate(estimate), Some(Ok((path, value)))) => {
                format!("{path} = {value} # {}", interval(estimate))
            }
            (Outcome::Estimate(estimate), Some(Err(problem))) => {
                format!(
                    "# {path} is {}, {}; the scenario does not accept it: {problem}",
                    value(estimate),
                    interval(estimate)
                )
            }
            (Outcome::Estimate(estimate), None) => {
                format!("# {path}: {}, {}", value(estimate), interval(estimate))
            }
            (Outcome::CannotTell(reason), _) => format!("# cannot determine {path}: {reason}"),
        }
    }

    fn json(&self, subject: &Subject) -> Value {
        let mut object = json!({ "path": self.finding.path, "field": self.finding.is_field });
        match &self.finding.outcome {
            Outcome::Estimate(estimate) => {
                object["value"] = json!(estimate.value);
                object["low"] = json!(estimate.low);
                object["high"] = json!(estimate.high);
            }
            Outcome::CannotTell(reason) => object["cannot_tell"] = json!(reason.to_string()),
        }
        if let Some(Ok((path, value))) = &self.setting {
            object["set"] = json!(format!("{}={value}", subject.whole(path)));
        }
        object
    }
}

fn interval(estimate: &Estimate) -> String {
    let Estimate { low, high, whole, .. } = *estimate;
    let number =
        |number: f64| if whole { format!("{number:.0}") } else { digits(number, needed(estimate).max(4)) };
    if low == high { "no other".to_owned() } else { format!("{} to {}", number(low), number(high)) }
}

/// The number, with no more digits than the interval is worth.
fn value(estimate: &Estimate) -> String {
    if estimate.whole {
        return format!("{:.0}", estimate.value);
    }
    let text = digits(estimate.value, needed(estimate));
    if text.contains(['.', 'e']) { text } else { text + ".0" }
}

/// The number of digits with which the interval's ends are distinct.
fn needed(Estimate { value, low, high, .. }: &Estimate) -> usize {
    let width = (high - low).max(value.abs() * 1e-9);
    let needed = if *value == 0.0 { 1.0 } else { (value.abs() / width).log10().ceil() + 2.0 };
    needed.clamp(3.0, 12.0) as usize
}

/// The fields of a robot that can be fitted, and the columns that are understood.
pub(super) fn list(subject: &Subject) -> String {
    let robot = subject.robot().model;
    let mut text = format!("fields of {}\n", subject.label);
    for field in catalogue(robot) {
        text += &format!("  {}\n", field.path(robot));
    }
    text += "columns\n";
    for quantity in Quantity::ALL {
        let stem = quantity.stems()[0];
        let units = quantity.dimension().units().iter();
        let names: Vec<_> = units.map(|unit| format!("{stem}_{}", unit.suffix)).collect();
        text += &format!("  {}\n", names.join(" ").trim_end_matches('_'));
    }
    text += "  robot\n  sensor specimen\n";
    for reading in baudbot_fit::readings(robot) {
        text += &format!("  {reading}\n");
    }
    text
}
