//! Scenarios of the gallery, run as people run them: by the program `baudbot run`, a process a repeat, from its start to its
//! end.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::Deserialize;

use crate::calibration;
use crate::measure::{Effort, Sample};
use crate::outcome::Outcome;

/// A scenario with its brain. Every repeat is a whole run, as the phases of a run do not cost the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Gallery {
    /// The brain of all robots.
    pub(crate) brain: &'static str,
    /// Ticks of a run, unless it ends before.
    pub(crate) ticks: u64,
    /// The scenario's text.
    pub(crate) scenario: &'static str,
}

/// The reason why a run could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// There is no program to run.
    #[error(
        "there is no program {}: `cargo build --release` makes it, or say with --program where it is",
        .0.display()
    )]
    NoProgram(PathBuf),
    /// The file with its scenario could not be written.
    #[error("cannot write the scenario into the folder of temporary files: {0}")]
    File(io::Error),
    /// The program could not be started.
    #[error("cannot start {}: {why}", program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// The system's error.
        why: io::Error,
    },
    /// The run failed.
    #[error("`baudbot run` ended with {status}: {}", said.trim())]
    Failed {
        /// The exit status.
        status: std::process::ExitStatus,
        /// The end of its output.
        said: String,
    },
    /// The output is no summary of a run.
    #[error("the summary of `baudbot run`: {0}")]
    Summary(#[from] serde_json::Error),
    /// Two runs of the same scenario were not the same.
    #[error("two runs were not the same: fingerprints {0} and {1}")]
    NotTheSame(String, String),
}

/// The used part of a run's summary.
#[derive(Debug, Deserialize)]
struct Summary {
    ticks: u64,
    simulated_s: f64,
    state_hash: String,
}

impl Gallery {
    /// Measures it with this program.
    pub(crate) fn run(
        self,
        program: &Path,
        outcome: &mut Outcome,
        effort: Effort,
        mut progress: impl FnMut(u32),
    ) -> Result<(), GalleryError> {
        if !program.is_file() {
            return Err(GalleryError::NoProgram(program.to_owned()));
        }
        let file = tempfile::Builder::new().suffix(".toml").tempfile().map_err(GalleryError::File)?;
        fs::write(&file, self.scenario).map_err(GalleryError::File)?;
        for repeat in 1..=effort.repeats {
            progress(repeat);
            let calibration_per_s = calibration::rounds_per_second();
            let start = Instant::now();
            let summary = self.once(program, file.path())?;
            let value = summary.simulated_s / start.elapsed().as_secs_f64();
            outcome.samples.push(Sample { value, calibration_per_s });
            let before = outcome.hash.replace(summary.state_hash.clone());
            if let Some(before) = before.filter(|before| *before != summary.state_hash) {
                return Err(GalleryError::NotTheSame(before, summary.state_hash));
            }
            outcome.hash_ticks = Some(summary.ticks);
        }
        Ok(())
    }

    fn once(self, program: &Path, scenario: &Path) -> Result<Summary, GalleryError> {
        let mut command = Command::new(program);
        command.arg("run").arg(scenario).args(["--brain", self.brain, "--ticks", &self.ticks.to_string()]);
        let run = command.args(["--json", "--quiet"]).stdin(Stdio::null()).output();
        let run = run.map_err(|why| GalleryError::Start { program: program.to_owned(), why })?;
        if !run.status.success() {
            let said = String::from_utf8_lossy(&run.stderr).into_owned();
            return Err(GalleryError::Failed { status: run.status, said });
        }
        Ok(serde_json::from_slice(&run.stdout)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANDER: Gallery = Gallery {
        brain: "avoid",
        ticks: 10,
        scenario: include_str!("../../../catalogue/scenarios/wander.toml"),
    };

    fn error(program: &Path) -> String {
        let mut outcome = Outcome::new("R/wander", "× real time", 1);
        let effort = Effort { seconds: 1.0, repeats: 1 };
        WANDER.run(program, &mut outcome, effort, |_| {}).unwrap_err().to_string()
    }

    #[test]
    fn a_program_that_is_not_there_is_told_with_the_mending() {
        let told =
            "there is no program /nowhere/baudbot: `cargo build --release` makes it, or say with --program";
        let error = error(Path::new("/nowhere/baudbot"));
        assert!(error.starts_with(told), "{error}");
    }

    #[test]
    fn a_program_that_fails_is_told() {
        let error = error(Path::new("/bin/false"));
        assert!(error.starts_with("`baudbot run` ended with exit status: 1"), "{error}");
    }

    #[test]
    fn a_program_that_is_another_one_is_told() {
        let error = error(Path::new("/bin/echo"));
        assert!(error.starts_with("the summary of `baudbot run`: expected value"), "{error}");
    }
}
