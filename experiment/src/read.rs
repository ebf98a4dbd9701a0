//! An experiment from its file.

use std::path::Path;

use baudbot_import::source::{self, Source, SourceError};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Setting};

/// Why an experiment cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Its file cannot be.
    #[error(transparent)]
    File(#[from] SourceError),
    /// What is in it makes no sense.
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
        let path = file.display().to_string();
        let toml = source::read(&path)?;
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or("experiment");
        let folder = file.parent().unwrap_or_else(|| Path::new(""));
        let find = |name: &str| match Source::beside(folder, name) {
            Ok(source) => Ok(source.text),
            Err(error) => Err(error.to_string()),
        };
        let parsed = Self::parse(&toml, stem, find);
        let wrong = |error| ReadError::Experiment { path: path.clone(), error };
        let mut experiment = parsed.map_err(wrong)?;
        put_programs(&mut experiment, folder).map_err(wrong)?;
        experiment.folder = folder.to_owned();
        Ok(experiment)
    }
}

/// Puts programs of microcontrollers into the places of their files' names, which are beside the experiment.
fn put_programs(experiment: &mut Experiment, folder: &Path) -> Result<(), Error> {
    for (i, field) in experiment.fields.iter_mut().enumerate() {
        let Choice::Levels(levels) = &mut field.choice else { continue };
        for setting in levels.iter_mut().flat_map(|level| &mut level.settings) {
            let Setting::Scenario { path, value } = setting else { continue };
            if path.ends_with(PROGRAM) && !value.starts_with('{') {
                let file = folder.join(value.trim_matches(['"', '\'']));
                *value = baudbot_import::program(&file)
                    .map_err(|error| Error::field(format!("fields[{i}]"), error))?;
            }
        }
    }
    Ok(())
}

/// The field that names a file which only a scenario's reader would read.
const PROGRAM: &str = ".microcontroller.program";
