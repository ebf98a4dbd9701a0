//! An experiment without its files, for machines that do not have them.

use std::collections::BTreeMap;
use std::path::Path;

use baudbot_run::assignment;
use baudbot_run::programs::{EXEC, PROGRAM};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::read::{self, ProgramError, ReadError};

/// An experiment's file, with what it names.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// The text of the file.
    pub text: String,
    /// The name that the experiment has if it gives none.
    pub name: String,
    /// The text of the scenario.
    pub scenario: String,
    /// Programs of microcontrollers in the form of scenarios, by the names of their files.
    pub programs: BTreeMap<String, String>,
}

impl Packed {
    /// Packs a file; and its experiment.
    ///
    /// # Errors
    /// If it cannot be read, something in it is invalid, or a brain of it is a file or a program.
    pub fn of_file(file: &Path) -> Result<(Self, Experiment), ReadError> {
        let mut programs = BTreeMap::new();
        let (text, experiment) = read::read(file, |name, program| {
            programs.insert(name.to_owned(), program.to_owned());
        })?;
        let path = || file.display().to_string();
        check_brains(&experiment).map_err(|error| ReadError::Content { path: path(), error })?;
        let (name, scenario) = (experiment.name.clone(), experiment.text.clone());
        Ok((Self { text, name, scenario, programs }, experiment))
    }

    /// The experiment.
    ///
    /// # Errors
    /// If something in it is invalid.
    pub fn experiment(&self) -> Result<Experiment, Error> {
        let experiment = Experiment::parse(&self.text, &self.name, |_| Ok(self.scenario.clone()))?;
        read::put_programs(experiment, |file| {
            self.programs.get(file).cloned().ok_or_else(|| ProgramError::NotSent(file.to_owned()))
        })
    }
}

/// Refuses brains that other machines do not have.
fn check_brains(experiment: &Experiment) -> Result<(), Error> {
    for brain in experiment.all_brains() {
        let brain = assignment::split(brain).1;
        if let Some(program) = brain.strip_prefix(EXEC).or_else(|| brain.strip_prefix(PROGRAM)) {
            let problem = format!("`{program}` is a program, which other machines do not have; {BY_HAND}");
            return Err(Error::field("brain.exec", problem));
        }
        let name = brain.split(':').next().unwrap_or_default();
        if Path::new(name).is_file() {
            let problem = format!("`{name}` is a file, which other machines do not have; {BY_HAND}");
            return Err(Error::field("brain", problem));
        }
    }
    Ok(())
}

const BY_HAND: &str = "copy it there, and do the shards by hand (`baudbot sweep --shard I/N`)";

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(experiment: &str) -> Result<(Packed, Experiment), ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../catalogue/scenarios/firmware.toml");
        let head = format!("scenario = \"{}\"\nseconds = 0.1\n", scenario.display());
        let file = folder.path().join("own.toml");
        std::fs::write(&file, head + experiment).unwrap();
        for program in ["one.hex", "two.hex"] {
            // A jump to itself.
            std::fs::write(folder.path().join(program), ":02000000FFCF30\n:00000001FF\n").unwrap();
        }
        Packed::of_file(&file)
    }

    #[test]
    fn programs_of_microcontrollers_are_sent_along() {
        let fields = "[[fields]]\nfield = \"robots.robot.microcontroller.program\"\nvalues = [\"one.hex\", \"two.hex\"]\n";
        let (packed, experiment) = packed(fields).unwrap();
        assert_eq!(packed.programs.len(), 2);
        let elsewhere = packed.experiment().unwrap();
        assert_eq!(elsewhere.fields, experiment.fields);
        assert!(format!("{:?}", elsewhere.fields).contains("hex = "), "{:?}", elsewhere.fields);
        let lost = Packed { programs: BTreeMap::new(), ..packed }.experiment().unwrap_err();
        assert_eq!(lost.to_string(), "fields[0]: one.hex: was not sent with the experiment");
    }

    #[test]
    fn brains_that_other_machines_do_not_have_are_refused() {
        let fields = "[[fields]]\nfield = \"step_ms\"\nvalues = [10]\n";
        let said = |text: &str| packed(&(text.to_owned() + fields)).unwrap_err().to_string();
        let program = said("brain = { exec = \"python3 follow.py\" }\n");
        assert!(program.contains("brain.exec: `python3 follow.py` is a program, which other"), "{program}");
        let file = said("brain = \"Cargo.toml\"\n");
        assert!(file.contains("brain: `Cargo.toml` is a file, which other machines do not have"), "{file}");
        let varied = "[[fields]]\nfield = \"brain\"\nvalues = [\"avoid\", \"exec:./mine\"]\n";
        let said = packed(varied).unwrap_err().to_string();
        assert!(said.contains("brain.exec: `./mine` is a program"), "{said}");
    }
}
