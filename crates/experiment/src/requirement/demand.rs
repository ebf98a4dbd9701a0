//! The requirements of an experiment.

use std::str::FromStr;
use std::sync::Arc;

use baudbot_require::{Formula, FormulaError, Requirement, Rule};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::observable::{NameError, Observable};
use crate::checked_fields::fields_of;
use crate::error::Error;
use crate::raw;

/// All requirements of an experiment.
pub type Demands = Arc<[Demand]>;

/// A requirement on one robot, or on each.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// What must hold.
    pub requirement: Requirement<Observable>,
    /// The name of the robot; `None` is each.
    pub robot: Option<String>,
}

/// How a run keeps to the requirement that it keeps to least.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fall {
    /// Its place among the requirements.
    pub requirement: u32,
    /// The place of the robot.
    pub robot: u32,
    /// By how much the run keeps to it; below 0, by how much it does not. Finite.
    pub robustness: f64,
    /// Whether it keeps to it, which a robustness of 0 leaves open.
    pub holds: bool,
    /// The instant that decides, in nanoseconds.
    pub at_ns: u64,
    /// The robot's forward speed then, in m/s; at a collision the one with which it came.
    pub speed_m_s: f64,
    /// The place of the sensor whose reading was the oldest that the brain had in the second before, and its age then, in milliseconds.
    pub stalest: Option<(u32, f64)>,
    /// The longest of the robot's control cycles until then that were answered, in nanoseconds.
    pub longest_cycle_ns: Option<u64>,
}

impl Demand {
    /// What a robot must not do if nothing is required: run into something.
    fn usual() -> Self {
        let formula =
            formula("require.always", "clearance_m > 0").expect("it is a formula, and a test reads it");
        Self { requirement: Requirement { rule: Rule::Always(formula), from_ns: 0 }, robot: None }
    }

    /// The requirements of a file: of one table, or of a list of them.
    pub(crate) fn all(value: Option<Value>) -> Result<Demands, Error> {
        let tables = match value {
            None => return Ok(Arc::new([])),
            Some(Value::Array(list)) => {
                list.into_iter().enumerate().map(|(i, value)| (format!("require[{i}]"), value)).collect()
            }
            Some(value) => vec![("require".to_owned(), value)],
        };
        let mut demands = Vec::new();
        for (place, value) in tables {
            let Value::Table(table) = value else {
                return Err(Error::field(
                    place,
                    "must be a table, such as [require] with always = \"clearance_m > 0.05\"",
                ));
            };
            demands.extend(of_table(&place, table)?);
        }
        Ok(demands.into())
    }

    /// These, or what is usual if there are none.
    pub(crate) fn or_usual(demands: &Demands) -> Demands {
        if demands.is_empty() { Arc::new([Self::usual()]) } else { Arc::clone(demands) }
    }
}

impl std::fmt::Display for Demand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.requirement.fmt(f)?;
        self.robot.iter().try_for_each(|robot| write!(f, " (of {robot})"))
    }
}

/// A text that states no requirement.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DemandError {
    /// It does not begin with how the formula is meant.
    #[error(
        "must begin with always, never, eventually or whenever, as in 'always clearance_m > 0.05'; is `{0}`"
    )]
    Rule(String),
    /// A part that is missing.
    #[error("`{text}` lacks `{missing}`; write whenever FORMULA then FORMULA within S s")]
    Missing {
        /// The text.
        text: String,
        /// The word that should be there.
        missing: &'static str,
    },
    /// A time that is no number of seconds.
    #[error("`{0}` is no number of seconds from 0 to 10^9, as in 0.5 s")]
    Seconds(String),
    /// A formula that is none.
    #[error("`{formula}`: {error}")]
    Formula {
        /// Its text.
        formula: String,
        /// What is wrong with it.
        error: FormulaError<NameError>,
    },
}

impl FromStr for Demand {
    type Err = DemandError;

    /// Reads the form in which a requirement is shown.
    fn from_str(text: &str) -> Result<Self, DemandError> {
        let text = text.trim();
        let (rest, robot) = match text.strip_suffix(')').and_then(|text| text.rsplit_once(" (of ")) {
            Some((rest, robot)) => (rest, Some(robot.to_owned())),
            None => (text, None),
        };
        let (rest, from_ns) = match rest.strip_suffix(" on").and_then(|text| text.rsplit_once(", from ")) {
            Some((rest, from)) => (rest, nanoseconds(from)?),
            None => (rest, 0),
        };
        let (word, formulas) = rest.split_once(' ').unwrap_or((rest, ""));
        let (formulas, within_ns) =
            match formulas.rsplit_once(" within ").filter(|_| matches!(word, "eventually" | "whenever")) {
                Some((formulas, within)) => (formulas, Some(nanoseconds(within)?)),
                None => (formulas, None),
            };
        let read = |formula: &str| {
            let failed = |error| DemandError::Formula { formula: formula.to_owned(), error };
            Formula::parse(formula, Observable::named).map_err(failed)
        };
        let missing = |missing| DemandError::Missing { text: text.to_owned(), missing };
        let rule = match word {
            "always" => Rule::Always(read(formulas)?),
            "never" => Rule::Never(read(formulas)?),
            "eventually" => Rule::Eventually { formula: read(formulas)?, within_ns },
            "whenever" => {
                let (trigger, then) = formulas.split_once(" then ").ok_or_else(|| missing("then"))?;
                let within_ns = within_ns.ok_or_else(|| missing("within"))?;
                Rule::Whenever { formula: read(trigger)?, then: read(then)?, within_ns }
            }
            _ => return Err(DemandError::Rule(text.to_owned())),
        };
        Ok(Self { requirement: Requirement { rule, from_ns }, robot })
    }
}

/// Nanoseconds of a text such as `0.5 s`.
fn nanoseconds(text: &str) -> Result<u64, DemandError> {
    let seconds = text.strip_suffix('s').map(str::trim).and_then(|text| text.parse::<f64>().ok());
    let seconds = seconds.filter(|seconds| (0.0..=MOST_S).contains(seconds));
    Ok((seconds.ok_or_else(|| DemandError::Seconds(text.to_owned()))? * 1e9).round() as u64)
}

/// The longest time in a requirement, in seconds.
const MOST_S: f64 = 1e9;

/// The requirements of a table: each of its rules is one.
fn of_table(place: &str, table: Table) -> Result<Vec<Demand>, Error> {
    let at = |field: &str| if field.is_empty() { place.to_owned() } else { format!("{place}.{field}") };
    let raw: raw::Require = fields_of(table, at)?;
    let seconds = |field: &str, seconds: Option<f64>| match seconds {
        Some(s) if !(0.0..=MOST_S).contains(&s) => {
            Err(Error::field(at(field), format!("must be from 0 to 10^9, is {s}")))
        }
        seconds => Ok(seconds.map(|s| (s * 1e9).round() as u64)),
    };
    let (within_ns, from_ns) =
        (seconds("within_s", raw.within_s)?, seconds("from_s", raw.from_s)?.unwrap_or(0));
    let rules = rules(&raw, within_ns, at)?;
    if rules.is_empty() {
        return Err(Error::field(place, "is empty; give always, never, eventually, or whenever with then"));
    }
    let demand = |rule| Demand { requirement: Requirement { rule, from_ns }, robot: raw.robot.clone() };
    Ok(rules.into_iter().map(demand).collect())
}

/// The rules of a table; `at` is the path of a field.
fn rules(
    raw: &raw::Require,
    within_ns: Option<u64>,
    at: impl Fn(&str) -> String,
) -> Result<Vec<Rule<Observable>>, Error> {
    let read =
        |field: &str, text: &Option<String>| text.as_ref().map(|text| formula(&at(field), text)).transpose();
    let mut rules = Vec::new();
    rules.extend(read("always", &raw.always)?.map(Rule::Always));
    rules.extend(read("never", &raw.never)?.map(Rule::Never));
    let (eventually, whenever) = (read("eventually", &raw.eventually)?, read("whenever", &raw.whenever)?);
    let problem = match (&eventually, &whenever, read("then", &raw.then)?, within_ns) {
        (Some(_), Some(_), ..) => {
            ("within_s", "would be of both `eventually` and `whenever`; write two tables: [[require]]")
        }
        (_, Some(formula), Some(then), Some(within_ns)) => {
            rules.push(Rule::Whenever { formula: formula.clone(), then, within_ns });
            return Ok(rules);
        }
        (_, Some(_), Some(_), None) => {
            ("within_s", "is missing: the time from `whenever` to `then`, in seconds; 0 is at once")
        }
        (_, Some(_), None, _) => ("then", "is missing: what must hold soon after `whenever`"),
        (_, None, Some(_), _) => ("whenever", "is missing: what `then` must follow"),
        (None, None, None, Some(_)) => ("within_s", "goes with `eventually` or `whenever`"),
        (_, None, None, within_ns) => {
            rules.extend(eventually.map(|formula| Rule::Eventually { formula, within_ns }));
            return Ok(rules);
        }
    };
    Err(Error::field(at(problem.0), problem.1))
}

fn formula(place: &str, text: &str) -> Result<Formula<Observable>, Error> {
    Formula::parse(text, Observable::named).map_err(|error| Error::field(place, format!("`{text}`: {error}")))
}

impl Fall {
    /// The instant that decides, in seconds.
    pub fn at_s(&self) -> f64 {
        self.at_ns as f64 / 1e9
    }

    /// Worse falls come first; of equal ones, that which does not hold.
    pub fn order(&self, other: &Self) -> std::cmp::Ordering {
        self.holds.cmp(&other.holds).then(self.robustness.total_cmp(&other.robustness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn demands(toml: &str) -> Result<Vec<String>, String> {
        let mut table: Table = toml.parse().unwrap();
        let all = Demand::all(table.remove("require")).map_err(|error| error.to_string())?;
        Ok(all.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn a_table_has_a_requirement_for_each_rule() {
        let toml = "[require]\nalways = \"clearance_m > 0.05\"\nnever = \"age_ms(ir) > 200 and speed_m_s > 0.3\"\n\
                    eventually = \"goals_reached >= 2\"\nwithin_s = 60\nrobot = \"a\"";
        let expected = [
            "always clearance_m > 0.05 (of a)",
            "never age_ms(ir) > 200 and speed_m_s > 0.3 (of a)",
            "eventually goals_reached >= 2 within 60 s (of a)",
        ];
        assert_eq!(demands(toml).unwrap(), expected);
        let toml = "[[require]]\nwhenever = \"age_ms(ir) > 300\"\nthen = \"speed_m_s < 0.05\"\nwithin_s = 0.5\nfrom_s = 1\n\
                    [[require]]\nalways = \"battery > 0.1\"";
        assert_eq!(demands(toml).unwrap().len(), 2);
        assert_eq!(Demand::usual().to_string(), "always clearance_m > 0");
    }

    #[test]
    fn a_requirement_is_read_as_it_is_shown() {
        for text in [
            "always clearance_m > 0.05",
            "never age_ms(ir) > 200 and speed_m_s > 0.3 (of a)",
            "eventually goals_reached >= 2",
            "eventually goals_reached >= 2 within 60 s",
            "whenever age_ms(ir) > 300 then speed_m_s < 0.05 within 0.5 s, from 1 s on (of cell-2)",
        ] {
            assert_eq!(text.parse::<Demand>().map(|demand| demand.to_string()).as_deref(), Ok(text));
        }
        for (text, expected) in [
            ("clearance_m > 0", "must begin with always, never"),
            ("always clearence_m > 0", "`clearence_m > 0`: column 1: "),
            (
                "whenever battery > 0 then battery > 0",
                "`whenever battery > 0 then battery > 0` lacks `within`",
            ),
            ("whenever battery > 0 within 3 s", "`whenever battery > 0 within 3 s` lacks `then`"),
            ("eventually battery > 0 within 3 m", "`3 m` is no number of seconds"),
        ] {
            let error = text.parse::<Demand>().unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (toml, expected) in [
            ("[require]", "require: is empty; give always"),
            ("[require]\nalways = \"clearence_m > 0\"", "require.always: `clearence_m > 0`: column 1: "),
            (
                "[[require]]\nalways = \"battery > 0\"\n[[require]]\nthen = \"battery > 0\"",
                "require[1].whenever: is missing",
            ),
            ("[require]\nwhenever = \"battery > 0\"\nwithin_s = 1", "require.then: is missing"),
            ("[require]\nwhenever = \"battery > 0\"\nthen = \"battery > 0\"", "require.within_s: is missing"),
            ("[require]\nalways = \"battery > 0\"\nwithin_s = 1", "require.within_s: goes with"),
            ("[require]\neventually = \"battery > 0\"\nwithin_s = -1", "require.within_s: must be from 0"),
            ("require = 3", "require: must be a table"),
            ("[require]\nallways = \"battery > 0\"", "require"),
        ] {
            let error = demands(toml).unwrap_err();
            assert!(error.starts_with(expected), "{error}\nnot {expected}");
        }
    }
}
