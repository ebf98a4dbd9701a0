//! Scenarios: files, and those that are part of this program.

use std::path::Path;

use baudbot_brains::catalogue;
use baudbot_import::embedded;
use baudbot_import::kind::Kind;
use baudbot_import::source::{self, SourceError};
use baudbot_import::{Note, Weight};
use baudbot_scenario::{Override, presets};
use baudbot_sim::Scenario;

use crate::error::Refused;
use crate::text::tell;

/// The scenario of a command that names none.
pub(crate) const DEFAULT: &str = "wander";

/// The text of a scenario, not yet parsed.
#[derive(Debug)]
pub(crate) struct Source(source::Source);

impl Source {
    /// Finds an embedded scenario of this name, or reads a file, and what that refers to by file.
    pub(crate) fn find(name: &str) -> anyhow::Result<Self> {
        source::Source::find(name).map(Self).map_err(|error| {
            let is = brain_or_preset(name).map_or_else(String::new, |is| format!("; {is}"));
            Refused::error(format!("{error}{is}"))
        })
    }

    pub(crate) fn into_text(self) -> String {
        self.0.text
    }

    /// Parses it, some of its fields changed.
    pub(crate) fn parse(&self, overrides: &[Override]) -> anyhow::Result<Scenario> {
        let parsed = baudbot_scenario::parse_with(&self.0.text, overrides);
        parsed.map_err(|error| match source::mistaken(&self.0.label, &self.0.text, Kind::Scenario) {
            Some(mistaken) => refused(mistaken),
            None => Refused::error(format!("{}: {error}", self.0.label)),
        })
    }

    /// The brains that the comment of its file shows.
    pub(crate) fn shown_brains(&self) -> Vec<&str> {
        embedded::shown_brains(&self.0.text)
    }

    pub(crate) fn label(&self) -> &str {
        &self.0.label
    }

    /// The notes on the files that it refers to.
    pub(crate) fn notes(&self, weight: Weight) -> impl Iterator<Item = &Note> {
        self.0.notes.iter().filter(move |note| note.weight == weight)
    }

    /// A name for the scenario's world on a server: its own name, or else that of the file. What a world's
    /// name cannot have becomes `-`.
    pub(crate) fn world_name(&self, scenario: &Scenario) -> String {
        let stem = Path::new(&self.0.label).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let name = if scenario.name.is_empty() { stem } else { &scenario.name };
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let name: String = name.chars().take(64).map(|c| if fits(c) { c } else { '-' }).collect();
        if name.is_empty() { "world".to_owned() } else { name }
    }
}

/// The message that a name is a brain's or a preset's, with the command for that.
pub(crate) fn brain_or_preset(name: &str) -> Option<String> {
    if presets::preset(name).is_some() {
        return Some(format!("`{name}` is a preset: `baudbot preset {name}`"));
    }
    let is_brain = !Path::new(name).exists() && catalogue::check(name).is_ok();
    is_brain.then(|| format!("`{name}` is a brain: `baudbot run --brain {name}`"))
}

/// The warnings: permitted and yet hardly meant values, in the files that the scenario refers to, and in itself.
pub(crate) fn warnings(source: &Source, scenario: &Scenario) -> Vec<String> {
    let of_files = source.notes(Weight::Warning).map(ToString::to_string);
    let of_scenario = baudbot_scenario::warnings(scenario).into_iter().map(|warning| warning.to_string());
    of_files.chain(of_scenario).collect()
}

/// Prints warnings about what is allowed and yet hardly intended.
pub(crate) fn warn(source: &Source, scenario: &Scenario) {
    for warning in warnings(source, scenario) {
        tell!("warning: {warning}");
    }
}

/// Parses `--set` arguments.
pub(crate) fn parse_sets(sets: &[String]) -> anyhow::Result<Vec<Override>> {
    let parse =
        |text: &String| Override::parse(text).map_err(|error| Refused::error(format!("--set: {error}")));
    sets.iter().map(parse).collect()
}

/// The override of a `--firmware` argument, with the program in it.
pub(crate) fn firmware(argument: &str) -> anyhow::Result<Override> {
    let wrong = |problem: &dyn std::fmt::Display| Refused::error(format!("--firmware {argument}: {problem}"));
    let parts = argument.split_once('=').filter(|(robot, file)| !robot.is_empty() && !file.is_empty());
    let (robot, file) = parts.ok_or_else(|| wrong(&"write ROBOT=FILE"))?;
    let program = baudbot_import::program(Path::new(file)).map_err(|error| wrong(&error))?;
    Override::parse(&format!("robots.{robot}.microcontroller.program={program}"))
        .map_err(|error| wrong(&error))
}

/// An override of this program's own making.
pub(crate) fn set(path: &str, value: impl std::fmt::Display) -> Override {
    Override::parse(&format!("{path}={value}")).expect("a path of our own has no empty part")
}

fn refused(error: SourceError) -> anyhow::Error {
    Refused::error(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_are_named_after_the_scenario_or_its_file() {
        let source = |label: &str, text: &str| {
            Source(source::Source { label: label.into(), text: text.into(), notes: Vec::new() })
        };
        let name = |source: Source| source.world_name(&source.parse(&[]).unwrap());
        assert_eq!(name(source("dir/two robots.toml", "")), "two-robots");
        assert_eq!(name(source("a.toml", "name = \"maze 1\"")), "maze-1");
        assert_eq!(name(source("", "")), "world");
    }

    #[test]
    fn every_embedded_scenario_is_sound() {
        for (name, _) in embedded::scenarios() {
            let scenario = Source::find(name).unwrap().parse(&[]).unwrap();
            assert!(!scenario.name.is_empty(), "{name}");
        }
    }
}
