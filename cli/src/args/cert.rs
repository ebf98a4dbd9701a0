//! `baudbot cert`.

use std::path::PathBuf;

use baudbot_access::{GrantName, Lifetime};
use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum CertCommand {
    /// Creates a certificate authority: ca.pem, and its key ca-key.pem
    #[command(after_long_help = EXAMPLES)]
    Ca(AuthorityArgs),
    /// Creates a certificate for a server, with its key
    #[command(after_long_help = EXAMPLES)]
    Server(ServerCertificateArgs),
    /// Creates a certificate for a client, with its key
    #[command(after_long_help = EXAMPLES)]
    Client(ClientCertificateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct AuthorityArgs {
    /// The folder, which is created if needed
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Name of the authority: 1 to 64 letters, digits, _, -, . or @
    #[arg(long, default_value = "baudbot")]
    pub(crate) name: GrantName,
    /// Validity of the authority, such as 12h, 30d or 8w
    #[arg(long, value_name = "TIME", default_value = "3650d")]
    pub(crate) expires: Lifetime,
}

#[derive(Debug, Args)]
pub(crate) struct ServerCertificateArgs {
    /// The folder with the authority
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Names and addresses by which clients reach the server: robots.lab, 10.0.0.7; the files are named after the first
    #[arg(value_name = "NAME", required = true)]
    pub(crate) names: Vec<String>,
    /// Validity of the certificate, such as 12h, 30d or 8w
    #[arg(long, value_name = "TIME", default_value = "365d")]
    pub(crate) expires: Lifetime,
}

#[derive(Debug, Args)]
pub(crate) struct ClientCertificateArgs {
    /// The folder with the authority
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Name of the client and of the files: 1 to 64 letters, digits, _, -, . or @
    #[arg(value_name = "NAME")]
    pub(crate) name: GrantName,
    /// Validity of the certificate, such as 12h, 30d or 8w
    #[arg(long, value_name = "TIME", default_value = "365d")]
    pub(crate) expires: Lifetime,
}

const EXAMPLES: &str = "\
Examples:
  baudbot cert ca lab                            lab/ca.pem, for all clients, and lab/ca-key.pem, which is secret
  baudbot cert server lab robots.lab 10.0.0.7    lab/robots.lab.pem and lab/robots.lab-key.pem
  baudbot cert client lab alice                  lab/alice.pem and lab/alice-key.pem

Needs a program built with `--features certificates` (or `full`). docs/reference/trust.md lists the files that each side needs.";
