//! `baudbot state`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum StateCommand {
    /// Says of each world in a folder of --state whether a server can continue it, and changes nothing
    #[command(after_long_help = CHECK_EXAMPLES)]
    Check(CheckStateArgs),
    /// Makes a world of what is sound of a damaged one, which stays as it is beside it
    #[command(after_long_help = RECOVER_EXAMPLES)]
    Recover(RecoverArgs),
}

#[derive(Debug, Args)]
pub(crate) struct CheckStateArgs {
    /// The folder, which no server may use meanwhile
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The folder, which no server may use meanwhile
    pub(crate) folder: PathBuf,
    /// The world, or the folder in which it was set aside, such as wander.damaged-2 [of several the last one]
    pub(crate) world: String,
    /// The name of the recovered world [default: that of the damaged one]
    #[arg(long = "as", value_name = "NAME")]
    pub(crate) name: Option<String>,
}

const CHECK_EXAMPLES: &str = "\
Exit codes: 0 if a server continues all worlds, 1 if not.

Examples:
  baudbot state check lab";

const RECOVER_EXAMPLES: &str = "\
The world is that of the last instant of which its journal can tell that it was so. Snapshots that are sound come along.

Examples:
  baudbot state recover lab wander
  baudbot state recover lab wander.damaged-2 --as old-wander";
