//! `--vcd ROBOT=FILE`.

use std::path::PathBuf;

/// A robot, and the file for what a logic analyser on its chip sees.
#[derive(Clone, Debug)]
pub(crate) struct VcdOutput {
    pub(crate) robot: String,
    pub(crate) file: PathBuf,
}

/// Parses `ROBOT=FILE`. Names of robots have no `=`.
pub(super) fn output(text: &str) -> Result<VcdOutput, String> {
    match text.split_once('=') {
        Some((robot, file)) if !robot.is_empty() && !file.is_empty() => {
            Ok(VcdOutput { robot: robot.to_owned(), file: file.into() })
        }
        Some(_) | None => Err("write ROBOT=FILE".to_owned()),
    }
}
