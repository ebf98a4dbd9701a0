//! An experiment from its file.

use std::path::Path;

use baudbot_import::embedded;
use baudbot_import::kind::Kind;
use baudbot_import::source::{self, Source, SourceError};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Setting};

/// A reason why an experiment cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Its file cannot be.
    #[error(transparent)]
    File(#[from] SourceError),
    /// Its content makes no sense.
    #[error("{path}: {error}")]
    Experiment {
        /// The file.
        path: String,
        /// The problem.
        error: Error,
    },
}

impl Experiment {
    /// Reads an experiment, with the scenario that it refers to and what that refers to. Programs of it are found from its folder.
    ///
    /// # Errors
    /// If a file cannot be read, or something in it makes no sense.
    pub fn read(file: &Path) -> Result<Self, ReadError> {
        read(file, |_, _| {}).map(|(_, experiment)| experiment)
    }
}

/// The text of a file and its experiment. `note` gets the name and the text of each program that it is put into.
pub(crate) fn read(file: &Path, mut note: impl FnMut(&str, &str)) -> Result<(String, Experiment), ReadError> {
    let path = file.display().to_string();
    // A file comes first: an experiment may be called as one that is built in.
    let toml = match embedded::experiment(&path).filter(|_| !file.exists()) {
        Some(text) => text.to_owned(),
        None => source::read(&path, Kind::Experiment)?,
    };
    let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or("experiment");
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let find = |name: &str| match Source::beside(folder, name) {
        Ok(source) => Ok(source.text),
        Err(error) => Err(error.to_string()),
    };
    let program = |name: &str| {
        let program = baudbot_import::program(&folder.join(name)).map_err(|error| error.to_string())?;
        note(name, &program);
        Ok(program)
    };
    let parsed = Experiment::parse(&toml, stem, find);
    let parsed = parsed.and_then(|experiment| put_programs(experiment, program));
    let mut experiment = parsed.map_err(|error| match source::mistaken(&path, &toml, Kind::Experiment) {
        Some(mistaken) => ReadError::File(mistaken),
        None => ReadError::Experiment { path, error },
    })?;
    experiment.folder = folder.to_owned();
    Ok((toml, experiment))
}

/// Puts programs of microcontrollers into the places of their files' names.
pub(crate) fn put_programs(
    mut experiment: Experiment,
    mut program: impl FnMut(&str) -> Result<String, String>,
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
