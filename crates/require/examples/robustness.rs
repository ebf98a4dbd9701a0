//! Requirements held against traces: reads a case in JSON from each line of the standard input, and prints its robustness and
//! the instant that decides, in nanoseconds.
//!
//! ```json
//! {"rule": "whenever", "formula": "x_m > 1", "then": "age_ms(ir) < 3", "within_ns": 5, "from_ns": 0,
//!  "times_ns": [0, 10], "values": {"x_m": [0.5, 2], "age_ms(ir)": [null, 2]}}
//! ```
//!
//! `null` is ∞.

use std::collections::BTreeMap;
use std::error::Error;
use std::io;

use baudbot_require::{Formula, Monitor, Requirement, Rule};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    rule: Kind,
    formula: String,
    then: Option<String>,
    within_ns: Option<u64>,
    from_ns: u64,
    times_ns: Vec<u64>,
    values: BTreeMap<String, Vec<Option<f64>>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Always,
    Never,
    Eventually,
    Whenever,
}

fn main() -> Result<(), Box<dyn Error>> {
    for line in io::stdin().lines() {
        let case: Case = serde_json::from_str(&line?)?;
        let mut monitor = Monitor::new(Requirement { rule: rule(&case)?, from_ns: case.from_ns });
        for (i, time_ns) in case.times_ns.iter().enumerate() {
            monitor
                .see(*time_ns, |name| case.values[name].get(i).copied().flatten().unwrap_or(f64::INFINITY))?;
        }
        let verdict = monitor.verdict();
        println!("{} {}", verdict.robustness, verdict.at_ns);
    }
    Ok(())
}

fn rule(case: &Case) -> Result<Rule<String>, Box<dyn Error>> {
    let parse = |text: &str| {
        let formula = Formula::parse(text, |name, argument| {
            let whole = argument.map_or_else(|| name.to_owned(), |argument| format!("{name}({argument})"));
            if case.values.contains_key(&whole) { Ok(whole) } else { Err(format!("no values of {whole}")) }
        });
        formula.map_err(|error| error.to_string())
    };
    let formula = parse(&case.formula)?;
    Ok(match case.rule {
        Kind::Always => Rule::Always(formula),
        Kind::Never => Rule::Never(formula),
        Kind::Eventually => Rule::Eventually { formula, within_ns: case.within_ns },
        Kind::Whenever => Rule::Whenever {
            formula,
            then: parse(case.then.as_deref().ok_or("whenever takes a `then`")?)?,
            within_ns: case.within_ns.ok_or("whenever takes `within_ns`")?,
        },
    })
}
