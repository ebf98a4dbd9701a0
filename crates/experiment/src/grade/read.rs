//! An exercise from its file, or from the program.

use std::path::Path;

use baudbot_import::embedded;
use baudbot_import::kind::Kind;
use baudbot_import::source::{self, Source, SourceError};

use crate::error::Error;
use crate::grade::exercise::Exercise;

/// A reason why an exercise cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Its file cannot be.
    #[error(transparent)]
    File(#[from] SourceError),
    /// Its content makes no sense.
    #[error("{path}: {error}")]
    Exercise {
        /// The file.
        path: String,
        /// The problem.
        error: Error,
    },
}

impl Exercise {
    /// Reads an exercise that is built in, or a file, with the scenario that it refers to.
    ///
    /// # Errors
    /// If a file cannot be read, or something in it makes no sense.
    pub fn read(name: &str) -> Result<Self, ReadError> {
        let path = Path::new(name);
        let toml = match embedded::exercise(name).filter(|_| !path.is_file()) {
            Some(text) => text.to_owned(),
            None => source::read(name, Kind::Exercise)?,
        };
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or(name);
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        let find = |scenario: &str| match Source::beside(folder, scenario) {
            Ok(source) => Ok(source.text),
            Err(error) => Err(error.to_string()),
        };
        let parsed = Self::parse(&toml, stem, find);
        parsed.map_err(|error| match source::mistaken(name, &toml, Kind::Exercise) {
            Some(mistaken) => ReadError::File(mistaken),
            None => ReadError::Exercise { path: name.to_owned(), error },
        })
    }
}

/// The exercises that are built in, in the order of their sections.
///
/// # Errors
/// If one of them makes no sense, which a test excludes.
pub fn all() -> Result<Vec<Exercise>, ReadError> {
    let mut all =
        embedded::exercises().map(|(name, _)| Exercise::read(name)).collect::<Result<Vec<_>, _>>()?;
    let key = |exercise: &Exercise| -> Vec<u32> {
        exercise.section.split('.').map(|part| part.parse().unwrap_or(u32::MAX)).collect()
    };
    all.sort_by_key(key);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_that_are_built_in_are_sound_and_for_chapters_1_to_8() {
        let all = all().unwrap();
        let chapters: Vec<_> = all.iter().filter_map(|exercise| exercise.section.split('.').next()).collect();
        assert_eq!(chapters.first(), Some(&"1"), "{chapters:?}");
        assert_eq!(chapters.last(), Some(&"8"), "{chapters:?}");
        for exercise in &all {
            assert!(!exercise.advice.is_empty(), "{}", exercise.name);
            assert!(exercise.described().contains(&exercise.task), "{}", exercise.name);
        }
    }

    #[test]
    fn the_example_of_the_book_is_an_exercise() {
        let book = include_str!("../../../../docs/how-to/grading.md");
        let text = book.split("```toml exercise\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let find =
            |name: &str| Source::find(name).map(|source| source.text).map_err(|error| error.to_string());
        Exercise::parse(text, "example", find).unwrap();
    }

    #[test]
    fn a_slip_of_the_pen_is_understood() {
        let error = Exercise::read("sqare").unwrap_err().to_string();
        assert!(error.contains("did you mean `square`?"), "{error}");
    }
}
