//! Experiments and exercises from their files.

use std::path::Path;

use baudbot_import::ImportError;
use baudbot_import::embedded;
use baudbot_import::kind::Kind;
use baudbot_import::source::{self, Source, SourceError};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Setting};

/// A reason why an experiment or an exercise cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Its file cannot be.
    #[error(transparent)]
    File(#[from] SourceError),
    /// Its content is invalid.
    #[error("{path}: {error}")]
    Content {
        /// The file.
        path: String,
        /// The problem.
        error: Error,
    },
}

/// A reason why there is no program for a microcontroller.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ProgramError {
    #[error(transparent)]
    File(#[from] ImportError),
    #[error("{0}: was not sent with the experiment")]
    NotSent(String),
}

/// The text of a file, and where it is from.
pub(crate) struct Document<'a> {
    pub(crate) toml: &'a str,
    /// The file's name without `.toml`.
    pub(crate) stem: &'a str,
    folder: &'a Path,
}

impl Document<'_> {
    /// The text of a scenario that the file refers to.
    pub(crate) fn scenario(&self, name: &str) -> Result<String, SourceError> {
        Source::beside(self.folder, name).map(|source| source.text)
    }
}

/// A file of this kind, or what is built in, as `parse` reads it. A file comes first: it may be called as something that is built in.
pub(crate) fn read_as<T>(
    (name, kind): (&str, Kind),
    built_in: Option<&str>,
    parse: impl FnOnce(&Document<'_>) -> Result<T, Error>,
) -> Result<T, ReadError> {
    let path = Path::new(name);
    let toml = match built_in.filter(|_| !path.is_file()) {
        Some(text) => text.to_owned(),
        None => source::read(name, kind)?,
    };
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or(name);
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    parse(&Document { toml: &toml, stem, folder }).map_err(|error| {
        match source::mistaken(name, &toml, kind) {
            Some(mistaken) => ReadError::File(mistaken),
            None => ReadError::Content { path: name.to_owned(), error },
        }
    })
}

impl Experiment {
    /// Reads an experiment, with the scenario that it refers to and what that refers to. Programs of it are found from its folder.
    ///
    /// # Errors
    /// If a file cannot be read, or something in it is invalid.
    pub fn read(file: &Path) -> Result<Self, ReadError> {
        read(file, |_, _| {}).map(|(_, experiment)| experiment)
    }
}

/// The text of a file and its experiment. `note` gets the name and the text of each program that it is put into.
pub(crate) fn read(file: &Path, mut note: impl FnMut(&str, &str)) -> Result<(String, Experiment), ReadError> {
    let path = file.display().to_string();
    read_as((&path, Kind::Experiment), embedded::experiment(&path), |document| {
        let experiment = Experiment::parse(document.toml, document.stem, |name| document.scenario(name))?;
        let program = |name: &str| {
            let program = baudbot_import::program(&document.folder.join(name))?;
            note(name, &program);
            Ok(program)
        };
        let experiment = put_programs(experiment, program)?;
        Ok((document.toml.to_owned(), Experiment { folder: document.folder.to_owned(), ..experiment }))
    })
}

/// Puts programs of microcontrollers into the places of their files' names.
pub(crate) fn put_programs(
    mut experiment: Experiment,
    mut program: impl FnMut(&str) -> Result<String, ProgramError>,
) -> Result<Experiment, Error> {
    for (i, field) in experiment.fields.iter_mut().enumerate() {
        let Choice::Levels(levels) = &mut field.choice else { continue };
        for setting in levels.iter_mut().flat_map(|level| &mut level.settings) {
            let Setting::Scenario { path, value } = setting else { continue };
            if path.ends_with(PROGRAM) && !value.starts_with('{') {
                let found = program(value.trim_matches(['"', '\'']));
                *value = found.map_err(|error| Error::field(format!("fields[{i}]"), error))?;
            }
        }
    }
    Ok(experiment)
}

/// The field that names a file which only a scenario's reader would read.
const PROGRAM: &str = ".microcontroller.program";
