//! Brains that are described in TOML: those that are part of the program, and files.

use std::path::{Path, PathBuf};
use std::{fs, io};

use baudbot_brain::{Body, Brain};
use baudbot_fields::Writes;

use crate::description::{Description, DescriptionError, edited};
use crate::kinds::{CatalogueError, Entry, PLACED_SCANS};
use crate::registry::Registry;

/// The text of a description, and where it is from.
pub(super) struct Text {
    name: String,
    /// What stands before each path that is set.
    prefix: String,
    toml: String,
}

/// Kinds of processes that must know where each scan was taken.
const PLACING: &[&str] = &["explore", "laser_localization", "particle_localization", "slam", "vfh"];

/// The repertoires that are part of the program.
const BUILT_IN: &[(&str, &str)] = &[
    ("bat", include_str!("../../repertoires/bat.toml")),
    ("forager", include_str!("../../repertoires/forager.toml")),
    ("errands", include_str!("../../repertoires/errands.toml")),
    ("four-pillars", include_str!("../../repertoires/four-pillars.toml")),
    ("goose", include_str!("../../repertoires/goose.toml")),
    ("hall", include_str!("../../repertoires/hall.toml")),
    ("lantern", include_str!("../../repertoires/lantern.toml")),
    ("lobby", include_str!("../../repertoires/lobby.toml")),
    ("moth", include_str!("../../repertoires/moth.toml")),
    ("mower", include_str!("../../repertoires/mower.toml")),
    ("patient", include_str!("../../repertoires/patient.toml")),
    ("pillar", include_str!("../../repertoires/pillar.toml")),
    ("scratcher", include_str!("../../repertoires/scratcher.toml")),
    ("stickleback", include_str!("../../repertoires/stickleback.toml")),
    ("sweeper", include_str!("../../repertoires/sweeper.toml")),
    ("tour", include_str!("../../repertoires/tour.toml")),
    ("trail-ant", include_str!("../../repertoires/trail-ant.toml")),
    ("waterhole", include_str!("../../repertoires/waterhole.toml")),
    ("wedge", include_str!("../../repertoires/wedge.toml")),
    ("xanthus", include_str!("../../repertoires/xanthus.toml")),
];

/// The repertoires that are part of the program.
pub(super) fn entries() -> impl Iterator<Item = Entry> {
    BUILT_IN.iter().map(|&(name, toml)| {
        let description = Description::parse(toml);
        let summary = description.as_ref().map_or("", Description::summary).to_owned();
        let writes = description.as_ref().map_or_else(|_| Writes::default(), Description::writes);
        let mut kinds = description.iter().flat_map(Description::kinds);
        let together = PLACED_SCANS.filter(|_| kinds.any(|kind| PLACING.contains(&kind)));
        Entry { name, writes, summary, parameters: Vec::new(), together }
    })
}

impl Text {
    /// One of the program's, or a file if the name ends as the names of such files do.
    pub(super) fn find(name: &str) -> Result<Option<Self>, CatalogueError> {
        if let Some((_, toml)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
            return Ok(Some(Self {
                name: format!("brain `{name}`"),
                prefix: String::new(),
                toml: (*toml).to_owned(),
            }));
        }
        if !name.ends_with(".toml") {
            return Ok(None);
        }
        match text_of(Path::new(name)) {
            Ok(toml) => Ok(Some(Self { name: name.to_owned(), prefix: String::new(), toml })),
            Err(error) => Err(CatalogueError::File { file: PathBuf::from(name), problem: error.to_string() }),
        }
    }

    /// The description of a brain that is this kind of behaviour and nothing else.
    pub(super) fn of_kind(kind: &str) -> Self {
        let toml = format!("[motor.{kind}]\nkind = \"{kind}\"\n");
        Self { name: format!("brain `{kind}`"), prefix: format!("motor.{kind}.parameters."), toml }
    }

    /// The description with numbers set: `PATH=NUMBER,…`.
    pub(super) fn read(&self, settings: &str) -> Result<Description, CatalogueError> {
        let settings = self.settings(settings)?;
        Description::with_settings(&self.toml, &settings).map_err(|error| self.error(error))
    }

    /// The text with numbers set: `PATH=NUMBER,…`.
    pub(super) fn edited(&self, settings: &str) -> Result<String, CatalogueError> {
        edited(&self.toml, &self.settings(settings)?).map_err(|error| self.error(error))
    }

    fn settings(&self, settings: &str) -> Result<Vec<(String, f64)>, CatalogueError> {
        let settings = settings.split(',').map(str::trim).filter(|setting| !setting.is_empty());
        let settings = settings.map(|setting| {
            let (path, number) = setting.split_once('=').ok_or_else(|| {
                let problem =
                    "does not set a number; write PATH=NUMBER, such as motor.stroll.utility.bias=0.2";
                self.error(DescriptionError::new(setting, problem))
            })?;
            let (path, number) = (format!("{}{}", self.prefix, path.trim()), number.trim());
            let value = number.parse().ok().filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| {
                let problem = format!("must be a number, not `{number}`");
                self.error(DescriptionError::new(path.clone(), problem))
            })?;
            Ok((path, value))
        });
        settings.collect()
    }

    pub(super) fn brain(
        &self,
        description: &Description,
        seed: u64,
        body: &Body,
    ) -> Result<Box<dyn Brain + Send>, CatalogueError> {
        description.any_brain(seed, body, &Registry::standard()).map_err(|error| self.error(error))
    }

    pub(super) fn c_file(&self, settings: &str, seed: u64, body: &Body) -> Result<String, CatalogueError> {
        self.read(settings)?.c_file(seed, body).map_err(|error| self.error(error))
    }

    fn error(&self, error: DescriptionError) -> CatalogueError {
        CatalogueError::Description { brain: self.name.clone(), error }
    }
}

/// The text of a file. Anything but a plain file is refused: a pipe may have no writer.
pub(crate) fn text_of(file: &Path) -> io::Result<String> {
    if fs::metadata(file)?.is_file() {
        fs::read_to_string(file)
    } else {
        Err(io::Error::other("is not a file"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_are_part_of_the_program_can_be_read_and_say_what_they_do() {
        for &(name, toml) in BUILT_IN {
            let description = Description::parse(toml).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(!description.summary().is_empty(), "{name}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_file_names_it() {
        let problem = |name: &str, settings: &str| match Text::find(name) {
            Ok(Some(text)) => text.read(settings).unwrap_err().to_string(),
            Ok(None) => panic!("no text"),
            Err(error) => error.to_string(),
        };
        assert!(problem("nowhere.toml", "").starts_with("nowhere.toml: cannot be read: No such file"));
        let bias = "motor.sweep.utility.bias";
        assert_eq!(
            problem("sweeper", &format!("{bias}=much")),
            format!("brain `sweeper`: {bias}: must be a number, not `much`")
        );
        assert!(
            problem("sweeper", bias).ends_with("write PATH=NUMBER, such as motor.stroll.utility.bias=0.2")
        );
    }
}
