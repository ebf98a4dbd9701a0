//! `baudbot token`.

use std::path::PathBuf;

use baudbot_access::{DrivePattern, GrantName, Lifetime};
use clap::{ArgGroup, Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum TokenCommand {
    /// Creates a token and prints it; it cannot be shown again
    #[command(after_long_help = NEW_EXAMPLES)]
    New(NewTokenArgs),
    /// Lists the tokens of a file: their names, rights and dates
    List(ListTokensArgs),
    /// Revokes a token
    Revoke(RevokeTokenArgs),
    /// Prints the token of your own server on this machine, for programs that do not find it automatically
    Local(LocalTokenArgs),
}

#[derive(Debug, Args)]
pub(crate) struct LocalTokenArgs {
    /// The server: HOST:PORT or unix:/PATH
    #[arg(long, value_name = "ADDR", default_value = super::DEFAULT_ADDRESS)]
    pub(crate) connect: String,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("rights").required(true).multiple(true)))]
pub(crate) struct NewTokenArgs {
    /// Name of the token in lists and logs: 1 to 64 letters, digits, _, -, . or @
    #[arg(long)]
    pub(crate) name: GrantName,
    /// Allow watching worlds with their true poses
    #[arg(long, group = "rights")]
    pub(crate) observe: bool,
    /// Allow creating, running and deleting worlds, and observing
    #[arg(long, group = "rights")]
    pub(crate) operate: bool,
    /// Allow training (driving robots in lockstep and getting their true poses), and observing
    #[arg(long, group = "rights")]
    pub(crate) train: bool,
    /// Allow driving robots; `*` matches any characters of a name, as in 'class-*/robot1' and '*/*'
    #[arg(long, value_name = "WORLD/ROBOT", group = "rights")]
    pub(crate) drive: Vec<DrivePattern>,
    /// Validity of the token, such as 12h, 30d or 8w [default: until it is revoked]
    #[arg(long, value_name = "TIME")]
    pub(crate) expires: Option<Lifetime>,
    #[command(flatten)]
    pub(crate) file: TokenFileArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ListTokensArgs {
    /// Write JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) file: TokenFileArgs,
}

#[derive(Debug, Args)]
pub(crate) struct RevokeTokenArgs {
    /// Name of the token
    pub(crate) name: GrantName,
    #[command(flatten)]
    pub(crate) file: TokenFileArgs,
}

#[derive(Debug, Args)]
pub(crate) struct TokenFileArgs {
    /// The token file, which contains only hashes of the tokens [default: ~/.config/baudbot/tokens.toml]
    ///
    /// The default is $XDG_CONFIG_HOME/baudbot/tokens.toml if that variable is set. docs/reference/trust.md describes the file.
    #[arg(long, value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}

const NEW_EXAMPLES: &str = "\
Examples:
  baudbot token new --name alice --observe --drive wander/alice
  baudbot token new --name course --drive 'class-*/*' --expires 26w
  baudbot token new --name ci --operate --train --expires 1d > ci.token    only the token goes to stdout";
