//! An exercise from its file, or from the program.

use baudbot_import::embedded;
use baudbot_import::kind::Kind;

use crate::grade::exercise::Exercise;
use crate::read::{ReadError, read_as};

impl Exercise {
    /// Reads an exercise that is built in, or a file, with the scenario that it refers to.
    ///
    /// # Errors
    /// If a file cannot be read, or something in it is invalid.
    pub fn read(name: &str) -> Result<Self, ReadError> {
        read_as((name, Kind::Exercise), embedded::exercise(name), |document| {
            Self::parse(document.toml, document.stem, |scenario| document.scenario(scenario))
        })
    }
}

/// The exercises that are built in, in the order of their sections.
///
/// # Errors
/// If one of them is invalid, which a test excludes.
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
    use baudbot_import::source::Source;

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
        Exercise::parse(text, "example", |name| Source::find(name).map(|source| source.text)).unwrap();
    }

    #[test]
    fn a_slip_of_the_pen_is_understood() {
        let error = Exercise::read("sqare").unwrap_err().to_string();
        assert!(error.contains("did you mean `square`?"), "{error}");
    }
}
