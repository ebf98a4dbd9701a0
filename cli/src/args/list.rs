//! The arguments of `baudbot list`, `init`, `completions` and `man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Write JSON: for each kind, names and summaries
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InitArgs {
    /// A built-in scenario or experiment (`baudbot list`)
    pub(crate) name: String,
    /// The file to write, `-` for stdout; an existing file is not overwritten [default: NAME.toml in the current folder]
    pub(crate) file: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// The folder for the pages, which is created if needed; then try `man -M FOLDER baudbot`
    pub(crate) folder: PathBuf,
}

pub(super) const LIST_EXAMPLES: &str = "\
Examples:
  baudbot list
  baudbot run devices/laser --brain wander
  baudbot init devices/laser                     writes laser.toml, to be changed
  baudbot init baud-vs-speed my.toml && baudbot sweep my.toml";

pub(super) const SCHEMA_EXAMPLES: &str = "\
Examples:
  baudbot schema > scenario.schema.json          then, as the first line of a scenario beside it:
      #:schema ./scenario.schema.json

Visual Studio Code reads that line with the extension Even Better TOML, other editors with taplo or tombi. In place of a line in
each file, a file `.taplo.toml` in the folder can name all scenarios:
      [[rule]]
      include = [\"scenarios/**/*.toml\"]
      schema.path = \"./scenario.schema.json\"

`taplo lint FILE` and `tombi lint FILE` check a file on the command line. Only `baudbot check` finds errors that involve several
fields.";

pub(super) const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  baudbot completions bash > ~/.local/share/bash-completion/completions/baudbot
  baudbot completions zsh > ~/.zfunc/_baudbot
  baudbot completions fish > ~/.config/fish/completions/baudbot.fish";
