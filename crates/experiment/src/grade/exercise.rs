//! An exercise, as its file describes it.

use std::time::Duration;

use baudbot_brains::decision::quadratic::Need;
use baudbot_geometry::Point;
use baudbot_import::source::SourceError;
use baudbot_run::UnknownName;
use baudbot_run::assignment::{self, NONE};
use baudbot_scenario::Override;
use baudbot_sim::Scenario;

use crate::checked_fields::{fields, seconds, within};
use crate::error::Error;
use crate::grade::advice::Advice;
use crate::grade::deficits::Deficit;
use crate::grade::measure::Measure;
use crate::grade::raw;
use crate::grade::watch::Target;
use crate::seeds::Seeds;
use crate::success::Conditions;

/// An exercise. Made by parsing only; its scenario, its robot and its measures exist.
#[derive(Clone, Debug)]
pub struct Exercise {
    /// The name: its file's name without `.toml`.
    pub name: String,
    /// The subject, in one line.
    pub title: String,
    /// The section of the notes, such as `5.3.2`; may be empty.
    pub section: String,
    /// The brain's task, for its author.
    pub task: String,
    /// The name of the scenario: a file, or one that is part of the program.
    pub scenario: String,
    /// The scenario's text, with all files that it refers to in it.
    pub text: String,
    /// Changes of the scenario.
    overrides: Vec<Override>,
    /// The robot that it is about, by its place.
    pub(crate) robot: usize,
    /// Brains of other robots, as `ROBOT=BRAIN`.
    pub brains: Vec<String>,
    /// One run for each.
    pub seeds: Seeds,
    /// The share of the points that is enough, above 0 and at most 1.
    pub pass: f64,
    pub(crate) target: Option<Target>,
    /// The needs of the robot.
    pub(crate) deficits: Vec<Deficit>,
    /// The time limits for a brain.
    pub limits: Limits,
    /// The criteria that give points; at least one.
    pub criteria: Vec<Criterion>,
    /// Words for typical mistakes.
    pub advice: Vec<Advice>,
}

/// The time limits for a brain, by the wall clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The time limit for the brain's next answer.
    pub answer: Duration,
    /// The time limit for all of a run.
    pub run: Duration,
}

/// Something that is worth points.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// The criterion in words.
    pub name: String,
    /// Points if all runs fulfil it; a share of them if some do. Positive.
    pub points: f64,
    /// The conditions of a run that fulfils it.
    pub needs: Conditions<Measure>,
}

impl Exercise {
    /// Reads an exercise called `name`; `find` finds the text of a scenario.
    ///
    /// # Errors
    /// An error with the field and the remedy.
    pub fn parse(
        toml: &str,
        name: &str,
        find: impl FnOnce(&str) -> Result<String, SourceError>,
    ) -> Result<Self, Error> {
        let raw: raw::Exercise = fields(toml, "exercise")?;
        let text = find(&raw.scenario).map_err(|problem| Error::field("scenario", problem))?;
        Self::checked(raw, name, text)
    }

    fn checked(raw: raw::Exercise, name: &str, text: String) -> Result<Self, Error> {
        let overrides = overrides(&raw)?;
        let scenario = baudbot_scenario::parse_with(&text, &overrides)
            .map_err(|error| Error::field(in_scenario(&raw), format!("{}: {error}", raw.scenario)))?;
        if scenario.end.after.is_none() {
            let problem = format!("is missing, and {} sets no end.after_s; a run must end", raw.scenario);
            return Err(Error::field("seconds", problem));
        }
        if raw.title.trim().is_empty() || raw.title.contains('\n') {
            return Err(Error::field("title", "must be one line that states what the exercise is about"));
        }
        if raw.criteria.is_empty() {
            let problem = "are missing; give at least one [[criteria]] with `name` and `needs`";
            return Err(Error::field("criteria", problem));
        }
        let criteria = raw.criteria.into_iter().enumerate().map(|(i, criterion)| criterion_of(i, criterion));
        let advice = raw.advice.into_iter().enumerate().map(|(i, advice)| Advice::new(i, advice));
        let default = toml::Value::Integer(DEFAULT_SEEDS);
        Ok(Self {
            name: name.to_owned(),
            title: raw.title,
            section: raw.section,
            task: raw.task.trim().to_owned(),
            scenario: raw.scenario,
            text,
            overrides,
            robot: place(&scenario, raw.robot.as_deref())?,
            brains: other_brains(raw.brains, &scenario)?,
            seeds: Seeds::of(Some(raw.seeds.as_ref().unwrap_or(&default)))?,
            pass: within("pass", raw.pass.unwrap_or(1.0), 1.0)?,
            target: raw.target.as_ref().map(target).transpose()?,
            deficits: deficits(&raw.deficits, &scenario)?,
            limits: limits(&raw.limits)?,
            criteria: criteria.collect::<Result<_, _>>()?,
            advice: advice.collect::<Result<_, _>>()?,
        })
    }

    /// The scenario with a seed.
    ///
    /// # Errors
    /// If the scenario is invalid, which does not depend on the seed.
    pub fn scenario_with(&self, seed: u64) -> Result<Scenario, Error> {
        let mut overrides = self.overrides.clone();
        overrides
            .push(Override::parse(&format!("seed={seed}")).map_err(|error| Error::field("seeds", error))?);
        baudbot_scenario::parse_with(&self.text, &overrides).map_err(|error| Error::field("scenario", error))
    }

    /// All points together.
    pub fn points(&self) -> f64 {
        self.criteria.iter().map(|criterion| criterion.points).sum()
    }
}

/// The changes of the scenario; later ones win.
fn overrides(raw: &raw::Exercise) -> Result<Vec<Override>, Error> {
    let parse = |path: String, text: &str| Override::parse(text).map_err(|error| Error::field(path, error));
    let mut all = Vec::new();
    if let Some(after_s) = raw.seconds.map(seconds).transpose()? {
        all.push(parse("seconds".to_owned(), &format!("end.after_s={after_s:?}"))?);
    }
    for (i, text) in raw.set.iter().enumerate() {
        all.push(parse(format!("set[{i}]"), text)?);
    }
    Ok(all)
}

/// The field that is named for a fault of the scenario: with changes it may be one of them.
fn in_scenario(raw: &raw::Exercise) -> &'static str {
    if raw.set.is_empty() { "scenario" } else { "scenario, or set" }
}

/// The place of the robot.
fn place(scenario: &Scenario, name: Option<&str>) -> Result<usize, Error> {
    let names: Vec<_> = scenario.robots.iter().map(|spec| spec.name.as_str()).collect();
    match (name, names.as_slice()) {
        (None, [_]) => Ok(0),
        (None, []) => Err(Error::field("scenario", "has no robot; an exercise needs one")),
        (None, names) => {
            let problem = format!("is missing, and the scenario has several: {}", names.join(", "));
            Err(Error::field("robot", problem))
        }
        (Some(name), names) => {
            let unknown = || Error::field("robot", UnknownName::new("robot", name, names));
            names.iter().position(|other| *other == name).ok_or_else(unknown)
        }
    }
}

/// Only one brain is graded, which drives all robots that the file gives none.
fn other_brains(brains: Vec<String>, scenario: &Scenario) -> Result<Vec<String>, Error> {
    for (i, brain) in brains.iter().enumerate() {
        let at = format!("brains[{i}]");
        if assignment::split(brain).0.is_none() {
            let problem = format!("`{brain}` is for all robots; write ROBOT=BRAIN, as in other=wander");
            return Err(Error::field(at, problem));
        }
        // The brain that is graded is not known yet.
        let so_far: Vec<_> = brains[..=i].iter().cloned().chain([NONE.to_owned()]).collect();
        assignment::assign(&so_far, &scenario.robots).map_err(|error| Error::field(at, error))?;
    }
    Ok(brains)
}

fn target(raw: &raw::Target) -> Result<Target, Error> {
    for (name, value) in [("x_m", raw.x_m), ("y_m", raw.y_m), ("heading_rad", raw.heading_rad.unwrap_or(0.0))]
    {
        if !value.is_finite() {
            return Err(Error::field(format!("target.{name}"), format!("must be finite, is {value}")));
        }
    }
    Ok(Target { position: Point::new(raw.x_m, raw.y_m), heading_rad: raw.heading_rad })
}

fn deficits(raw: &[raw::Deficit], scenario: &Scenario) -> Result<Vec<Deficit>, Error> {
    let names: Vec<_> = scenario.surroundings.zones.iter().map(|zone| zone.name.as_str()).collect();
    let deficit = |(i, raw): (usize, &raw::Deficit)| {
        let at = |name: &str| format!("deficits[{i}].{name}");
        let unknown = || Error::field(at("zone"), UnknownName::new("zone", &raw.zone, &names));
        let need = Need {
            deficit: within(&at("deficit"), raw.deficit, 1e6)?,
            importance: within(&at("importance"), raw.importance, 1e6)?,
            rate: within(&at("rate_per_s"), raw.rate_per_s, 1e6)?,
        };
        Ok(Deficit { zone: names.iter().position(|name| *name == raw.zone).ok_or_else(unknown)?, need })
    };
    raw.iter().enumerate().map(deficit).collect()
}

fn limits(raw: &raw::Limits) -> Result<Limits, Error> {
    let seconds = |name: &str, given: Option<f64>, default: f64| {
        within(&format!("limits.{name}"), given.unwrap_or(default), 86400.0).map(Duration::from_secs_f64)
    };
    Ok(Limits { answer: seconds("answer_s", raw.answer_s, 10.0)?, run: seconds("run_s", raw.run_s, 600.0)? })
}

fn criterion_of(i: usize, raw: raw::Criterion) -> Result<Criterion, Error> {
    let at = |name: &str| format!("criteria[{i}].{name}");
    if raw.name.trim().is_empty() || raw.name.contains('\n') {
        return Err(Error::field(at("name"), "must be one line that states what earns the points"));
    }
    let needs = Conditions::new(&at("needs"), &raw.needs)?;
    Ok(Criterion { name: raw.name, points: within(&at("points"), raw.points.unwrap_or(1.0), 1e6)?, needs })
}

/// The number of seeds if the file has none.
const DEFAULT_SEEDS: i64 = 5;

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
title = "Wander"
task = "Drive about."
scenario = "wander"
seconds = 5.0
[[criteria]]
name = "nothing is hit"
needs = { collisions_at_most = 0 }
"#;

    fn parse(toml: &str) -> Result<Exercise, String> {
        let scenario = include_str!("../../../../catalogue/scenarios/wander.toml");
        Exercise::parse(toml, "mine", |_| Ok(scenario.to_owned())).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_left_out_has_a_default() {
        let exercise = parse(GOOD).unwrap();
        assert_eq!((exercise.seeds.count(), exercise.pass, exercise.points()), (5, 1.0, 1.0));
        assert_eq!(exercise.scenario_with(7).unwrap().seed, 7);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_field_and_the_remedy() {
        for (from, to, expected) in [
            ("title =", "titel =", "titel: there is no field `titel`; did you mean `title`?"),
            (
                "collisions_at",
                "colisions_at",
                "criteria[0].needs.colisions_at_most: there is no measure `colisions`; did you mean `collisions`?",
            ),
            ("\"Wander\"", "\"\"", "title: must be one line"),
            ("seconds = 5.0\n", "", "seconds: is missing, and wander sets no end.after_s"),
            (
                "seconds = 5.0\n",
                "seconds = 5.0\n[[deficits]]\nzone = \"larder\"\ndeficit = 1.0\nimportance = 1.0\nrate_per_s = 0.1\n",
                "deficits[0].zone: there is no zone `larder`",
            ),
            (
                "seconds = 5.0\n",
                "seconds = 5.0\n[[deficits]]\nzone = \"larder\"\ndeficit = 1.0\nimportance = 1.0\nrate_per_s = -1.0\n",
                "deficits[0].rate_per_s: must be above 0",
            ),
            ("seconds = 5.0", "seconds = -5.0", "seconds: must be from 1e-9"),
            ("seconds = 5.0", "seconds = 5.0\npass = 1.5", "pass: must be above 0 and at most 1, is 1.5"),
            ("seconds = 5.0", "seconds = 5.0\nseeds = 0", "seeds: must be at least 1"),
            (
                "seconds = 5.0",
                "seconds = 5.0\nrobot = \"bob\"",
                "robot: there is no robot `bob`; there is only `robot`",
            ),
            (
                "seconds = 5.0",
                "seconds = 5.0\nset = [\"robots.robot.lnk.baud=5\"]",
                "scenario, or set: wander: ",
            ),
            ("seconds = 5.0", "seconds = 5.0\nset = [\"baud\"]", "set[0]: "),
            ("seconds = 5.0", "seconds = 5.0\nbrains = [\"avoid\"]", "brains[0]: `avoid` is for all robots"),
            (
                "seconds = 5.0",
                "seconds = 5.0\nbrains = [\"robot=avoid\", \"x=avoid\"]",
                "brains[1]: there is no robot `x`; there are: robot",
            ),
            (
                "seconds = 5.0",
                "seconds = 5.0\nbrains = [\"robot=avoid\", \"robot=wander\"]",
                "brains[1]: robot `robot` can have only one brain",
            ),
            ("seconds = 5.0", "seconds = 5.0\nlimits = { answer_s = 0 }", "limits.answer_s: must be above 0"),
            ("seconds = 5.0", "seconds = 5.0\ntarget = { x_m = nan, y_m = 0 }", "target.x_m: must be finite"),
            ("needs = {", "points = 0\nneeds = {", "criteria[0].points: must be above 0"),
            ("needs = { collisions_at_most = 0 }", "needs = {}", "criteria[0].needs: is empty"),
            ("[[criteria]]", "[[advice]]\nwhen = {}\nsay = \"no\"\n[[criteria]]", "advice[0].when: is empty"),
            (
                "[[criteria]]",
                "[[advice]]\nwhen = { turned_rad_at_most = 0 }\nsay = \"{trned_rad}\"\n[[criteria]]",
                "advice[0].say: there is no measure `trned_rad`; did you mean `turned_rad`?",
            ),
        ] {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD, "{from}");
            let error = parse(&text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
        let none = GOOD.split("[[criteria]]").next().unwrap();
        assert!(parse(none).unwrap_err().starts_with("criteria: are missing"));
    }
}
