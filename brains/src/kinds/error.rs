//! Errors in a text that describes a brain.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use thiserror::Error;

use crate::description::DescriptionError;

/// A reason why a text describes no brain for a body.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CatalogueError {
    /// There is no such brain.
    #[error("no brain `{name}`; there are: {}{}", known.join(", "), hint(name))]
    Brain {
        /// The name given.
        name: String,
        /// The brains that exist, the nearest name first.
        known: Vec<&'static str>,
    },
    /// The brain has no such parameter.
    #[error("brain `{brain}` has no parameter `{name}`; it has: {}", known.join(", "))]
    Parameter {
        /// Name of the brain.
        brain: &'static str,
        /// The name given.
        name: String,
        /// The parameters of the brain, the nearest name first.
        known: Vec<&'static str>,
    },
    /// A setting without a value.
    #[error("brain `{brain}`: `{found}` does not set a parameter; write NAME=NUMBER")]
    Setting {
        /// Name of the brain.
        brain: &'static str,
        /// The text given.
        found: String,
    },
    /// A value that is no number.
    #[error("brain `{brain}`: {parameter} must be a number, not `{found}`")]
    Number {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The text given.
        found: String,
    },
    /// An invalid number.
    #[error("brain `{brain}`: {parameter} must be from {} to {}, not {found}", range.start(), range.end())]
    Range {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The numbers that make sense.
        range: RangeInclusive<f64>,
        /// The number given.
        found: f64,
    },
    /// The robot has not the sensors that the brain needs.
    #[error("brain `{brain}` needs {needed}, but robot `{robot}` has only: {}", found.join(", "))]
    Sensor {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the robot.
        robot: String,
        /// The sensors that the brain needs.
        needed: &'static str,
        /// Names of the sensors that there are.
        found: Vec<String>,
    },
    /// A file that cannot be read.
    #[error("{}: cannot be read: {problem}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        problem: String,
    },
    /// A description in TOML that is wrong, or wrong for this robot.
    #[error("{brain}: {error}")]
    Description {
        /// The file, or the name of one that is part of the program.
        brain: String,
        /// The problem.
        error: DescriptionError,
    },
}

/// A suggestion: a command line, or a name with a folder or an ending, may have been meant.
fn hint(name: &str) -> String {
    if name.trim().contains(char::is_whitespace) {
        format!("; a program of your own is named as in 'exec:{name}'")
    } else if name.contains(['/', '.']) {
        format!("; a program of your own is named as in 'exec:python3 {name}'")
    } else if name == "exec" {
        "; a program drives in `baudbot run --brain 'exec:…'`, or attaches by itself".to_owned()
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_without_exec_is_told_as_it_is_to_be_written() {
        for (name, hinted) in [
            ("python3 x.py", "; a program of your own is named as in 'exec:python3 x.py'"),
            ("node x", "; a program of your own is named as in 'exec:node x'"),
            ("./x.py", "; a program of your own is named as in 'exec:python3 ./x.py'"),
            ("avod", ""),
        ] {
            assert_eq!(hint(name), hinted);
        }
    }
}
