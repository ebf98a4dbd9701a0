//! Scenarios: files, and those that are part of this program.

use std::borrow::Cow;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

use baudbot_scenario::MAX_BYTES;
use baudbot_scenario::Override;
use baudbot_sim::Scenario;

use crate::error::Refused;
use crate::opened;
use crate::text::tell;

/// The scenarios that the program can run anywhere.
pub(crate) const EMBEDDED: [(&str, &str); 3] = [
    ("arsim", include_str!("../../scenarios/arsim.toml")),
    ("khepera", include_str!("../../scenarios/khepera.toml")),
    ("wander", include_str!("../../scenarios/wander.toml")),
];

/// The scenario of a command that names none.
pub(crate) const DEFAULT: &str = "wander";

/// The text of a scenario, not yet parsed.
#[derive(Debug)]
pub(crate) struct Source {
    /// The name given to the command: a path, or that of an embedded scenario.
    label: String,
    text: String,
}

impl Source {
    /// Finds an embedded scenario of this name, or reads a file, and what that refers to by file.
    pub(crate) fn find(name: &str) -> anyhow::Result<Self> {
        let text = match EMBEDDED.iter().find(|(embedded, _)| *embedded == name) {
            Some((_, text)) => (*text).to_owned(),
            None => inline(name, &read(name)?)?,
        };
        Ok(Self { label: name.to_owned(), text })
    }

    /// As [`find`](Self::find), of a file that another file refers to, which is in `folder`.
    pub(crate) fn beside(folder: &Path, name: &str) -> anyhow::Result<Self> {
        if EMBEDDED.iter().any(|(embedded, _)| *embedded == name) {
            return Self::find(name);
        }
        Self::find(&folder.join(name).display().to_string())
    }

    pub(crate) fn into_text(self) -> String {
        self.text
    }

    /// Parses it, some of its fields changed.
    pub(crate) fn parse(&self, overrides: &[Override]) -> anyhow::Result<Scenario> {
        let parsed = baudbot_scenario::parse_with(&self.text, overrides);
        parsed.map_err(|error| Refused::error(format!("{}: {error}", self.label)))
    }

    pub(crate) fn label(&self) -> &str {
        &self.label
    }

    /// A name for the scenario's world on a server: its own name, or else that of the file. What a world's
    /// name cannot have becomes `-`.
    pub(crate) fn world_name(&self, scenario: &Scenario) -> String {
        let stem = Path::new(&self.label).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let name = if scenario.name.is_empty() { stem } else { &scenario.name };
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let name: String = name.chars().take(64).map(|c| if fits(c) { c } else { '-' }).collect();
        if name.is_empty() { "world".to_owned() } else { name }
    }
}

/// Tells what is allowed and yet hardly meant.
pub(crate) fn warn(scenario: &Scenario) {
    for warning in baudbot_scenario::warnings(scenario) {
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

pub(crate) fn read(path: &str) -> anyhow::Result<String> {
    let unreadable = |error: io::Error| Refused::error(unreadable(path, &error));
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(Refused::error(format!("{path}: is a directory, not a scenario file")));
    }
    if metadata.len() > MAX_BYTES as u64 {
        let problem = format!("{path}: has {} bytes, a scenario has at most {MAX_BYTES}", metadata.len());
        return Err(Refused::error(problem));
    }
    // A device or a pipe has no length, and may have no end.
    let mut bytes = Vec::new();
    let file = opened::any(Path::new(path)).map_err(unreadable)?;
    file.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() > MAX_BYTES {
        let problem = format!("{path}: has more than {MAX_BYTES} bytes, the most that a scenario may have");
        return Err(Refused::error(problem));
    }
    String::from_utf8(bytes).map_err(|_| unreadable(io::ErrorKind::InvalidData.into()))
}

/// Puts the maps and tables that a scenario refers to into their places.
fn inline(path: &str, text: &str) -> anyhow::Result<String> {
    let folder = Path::new(path).parent().unwrap_or_else(|| Path::new(""));
    let whole = baudbot_import::inline(text, folder);
    whole.map(Cow::into_owned).map_err(|error| Refused::error(format!("{path}: {error}")))
}

fn unreadable(path: &str, error: &io::Error) -> String {
    let names: Vec<_> = EMBEDDED.iter().map(|(name, _)| *name).collect();
    if error.kind() == io::ErrorKind::NotFound {
        format!("{path}: there is no such file; built-in scenarios: {}", names.join(", "))
    } else if error.kind() == io::ErrorKind::InvalidData {
        format!("{path}: is not text in UTF-8")
    } else {
        format!("{path}: {error}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_are_named_after_the_scenario_or_its_file() {
        let source = |label: &str, text: &str| Source { label: label.into(), text: text.into() };
        let name = |source: Source| source.world_name(&source.parse(&[]).unwrap());
        assert_eq!(name(source("dir/two robots.toml", "")), "two-robots");
        assert_eq!(name(source("a.toml", "name = \"maze 1\"")), "maze-1");
        assert_eq!(name(source("", "")), "world");
    }

    #[test]
    fn every_embedded_scenario_is_sound() {
        for (name, _) in EMBEDDED {
            assert_eq!(&Source::find(name).unwrap().parse(&[]).unwrap().name, name);
        }
    }
}
