//! `baudbot state`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum StateCommand {
    /// Checks whether a server can continue each world in a --state folder, and changes nothing
    #[command(after_long_help = CHECK_EXAMPLES)]
    Check(CheckStateArgs),
    /// Recovers a world from the intact part of a damaged one, which is left unchanged
    #[command(after_long_help = RECOVER_EXAMPLES)]
    Recover(RecoverArgs),
}

#[derive(Debug, Args)]
pub(crate) struct CheckStateArgs {
    /// The folder, which must not be in use by a server
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The folder, which must not be in use by a server
    pub(crate) folder: PathBuf,
    /// The damaged world, or the folder in which it was set aside, such as wander.damaged-2; WORLD alone means the last one set aside
    pub(crate) world: String,
    /// The name of the recovered world [default: that of the damaged one]
    #[arg(long = "as", value_name = "NAME")]
    pub(crate) name: Option<String>,
}

const CHECK_EXAMPLES: &str = "\
Exit codes: 0 if a server can continue all worlds, 1 if not.

Examples:
  baudbot state check lab";

const RECOVER_EXAMPLES: &str = "\
The recovered world is at the last instant that its journal proves. Intact snapshots are recovered with it.

Examples:
  baudbot state recover lab wander
  baudbot state recover lab wander.damaged-2 --as old-wander";
