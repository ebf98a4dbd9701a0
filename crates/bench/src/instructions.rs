//! The costs of the workloads in instructions, counted by valgrind: the same whatever else the machine does.
//!
//! A workload runs for some ticks and for more of them, each in a process of its own under `callgrind`; the difference
//! leaves out what a process needs to start. Valgrind translates what it runs for a processor of its own making, which has
//! AVX2 and no AVX-512 wherever the real one has AVX2, so that the kernels take the same way on all of those.

use std::collections::BTreeMap;
use std::io;
use std::process::{Command, Stdio};

use serde::{Deserialize, Serialize};

use crate::catalogue::Workload;

/// The cost of a workload.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Count {
    /// Name of the workload.
    pub workload: &'static str,
    /// The unit of the count: a step, a ray, …
    pub unit: &'static str,
    /// Instructions for one of them.
    pub instructions: f64,
}

/// The reason why instructions could not be counted.
#[derive(Debug, thiserror::Error)]
pub enum CountError {
    /// Valgrind is not there.
    #[error("there is no valgrind, which counts them: apt-get install valgrind")]
    NoValgrind,
    /// Valgrind could not be started.
    #[error("cannot start valgrind: {0}")]
    Start(io::Error),
    /// The program failed, or printed no number of instructions.
    #[error("valgrind ended with {status} and counted nothing: {said}")]
    Failed {
        /// The exit status.
        status: std::process::ExitStatus,
        /// The end of its output.
        said: String,
    },
    /// The workload has other processes.
    #[error("`{0}` has other processes, in which instructions are not counted; W1 to W4, G and V do without")]
    NotInProcess(&'static str),
}

/// Counts what a workload costs; `command` begins this program, which gets options.
///
/// # Errors
/// If valgrind is not there or fails.
pub fn count(command: impl Fn() -> Command, workload: &Workload) -> Result<Count, CountError> {
    let Some(scale) = workload.scale() else { return Err(CountError::NotInProcess(workload.name)) };
    let run = |ticks: u64| {
        let program = command();
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program.get_program());
        let run = valgrind
            .args(program.get_args())
            .args([workload.name, "--quiet", "--ticks", &ticks.to_string()])
            .stdin(Stdio::null())
            .output();
        let run = run.map_err(|error| {
            let is_missing = error.kind() == io::ErrorKind::NotFound;
            if is_missing { CountError::NoValgrind } else { CountError::Start(error) }
        })?;
        let said = String::from_utf8_lossy(&run.stderr);
        let counted = counted(&said).filter(|_| run.status.success());
        counted.ok_or_else(|| CountError::Failed { status: run.status, said: tail(&said, 5) })
    };
    let [few, many] = scale.ticks;
    let (before, after) = (run(few)?, run(many)?);
    let instructions = after.saturating_sub(before) as f64 / ((many - few) as f64 * scale.units_a_tick);
    Ok(Count { workload: workload.name, unit: scale.unit, instructions })
}

/// The number in callgrind's line `==123== Collected : 4567`.
fn counted(said: &str) -> Option<u64> {
    let line = said.lines().find_map(|line| line.split_once("== Collected :"))?;
    line.1.trim().parse().ok()
}

/// The last lines of a text.
pub(crate) fn tail(text: &str, lines: usize) -> String {
    let all: Vec<_> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    all[all.len().saturating_sub(lines)..].join("\n")
}

/// The counts that are known: `crates/bench/instructions.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// The output of `rustc --version` for the compiler that made the program: another one makes another program.
    pub rustc: String,
    /// The processor's architecture.
    pub arch: String,
    /// Instructions by workload.
    pub instructions: BTreeMap<String, f64>,
}

impl Known {
    /// The ratio of a workload's instructions to those that are known of it; `None` if none are.
    pub fn ratio(&self, count: &Count) -> Option<f64> {
        let known = *self.instructions.get(count.workload)?;
        (known > 0.0).then(|| count.instructions / known)
    }
}

/// No workload grows by more than this unnoticed.
pub const TOLERANCE: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_the_one_that_callgrind_collected() {
        let said = "==30== Callgrind, a call-graph generating cache profiler\n==30== \n\
                    ==30== Events    : Ir\n==30== Collected : 45674489\n==30== \n==30== I   refs:      45,674,489\n";
        assert_eq!(counted(said), Some(45_674_489));
        assert_eq!(counted("==30== Collected : none"), None);
        assert_eq!(counted("valgrind: cannot execute"), None);
        assert_eq!(tail("a\n\nb\nc\n", 2), "b\nc");
    }

    #[test]
    fn counts_are_compared_with_those_that_are_known() {
        let known = Known {
            rustc: "rustc 1".to_owned(),
            arch: "x86_64".to_owned(),
            instructions: [("W2".to_owned(), 100.0), ("W4".to_owned(), 0.0)].into(),
        };
        let ratio = |workload, instructions| known.ratio(&Count { workload, unit: "ray", instructions });
        assert_eq!([ratio("W2", 103.0), ratio("W2", 50.0)], [Some(1.03), Some(0.5)]);
        assert_eq!([ratio("W9", 1.0), ratio("W4", 0.0)], [None; 2]);
    }
}
