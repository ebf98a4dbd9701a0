//! The arguments of `baudbot preset` and `baudbot evidence`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct PresetArgs {
    /// A preset [default: list them all]
    pub(crate) name: Option<String>,
    /// Write JSON: the list, or a preset's values, each with its source and its standing, such as datasheet, measured or guess
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct EvidenceArgs {
    /// Comparisons to show in full, or presets whose comparisons to show [default: all comparisons, one line each]
    pub(crate) names: Vec<String>,
    /// Write JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the page `evidence.md` and its pictures into this folder
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["names", "json"])]
    pub(crate) write: Option<PathBuf>,
    /// Fail if the page in this folder is not up to date
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["names", "json", "write"])]
    pub(crate) check: Option<PathBuf>,
    /// Suppress the progress bar
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
