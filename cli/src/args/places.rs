//! The addresses at which servers listen, and at which they are looked for.

use std::path::PathBuf;

use baudbot_client::Credentials;
use baudbot_server::{Address, Builder, Server, raise_descriptor_limit};
use clap::Args;

use super::access::AccessArgs;
use super::limits::LimitArgs;
use crate::viewer::Viewer;

#[derive(Debug, Args)]
#[command(next_help_heading = "Addresses")]
pub(crate) struct ListenArgs {
    /// Listen for brains, observers and operators: IP:PORT (port 0 picks a free one) or unix:/PATH
    #[arg(long, value_name = "ADDR")]
    pub(crate) listen: Vec<Address>,
    /// Serve the web page at http://IP:PORT (port 0 picks a free one); `off` disables it
    ///
    /// Prometheus metrics are at http://IP:PORT/metrics (docs/reference/metrics.md).
    #[arg(long, value_name = "IP:PORT|off")]
    pub(crate) viewer: Option<Viewer>,
    #[command(flatten)]
    pub(crate) access: AccessArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

impl ListenArgs {
    /// A server that listens so, but for its addresses.
    ///
    /// # Errors
    /// If what it is to be guarded with cannot be used.
    pub(crate) fn builder(&self) -> anyhow::Result<Builder> {
        raise_descriptor_limit();
        // After that, as the usual limit of connections follows from it.
        self.access.guard(Server::builder().limits(self.limits.limits()))
    }

    /// An option that was given and means nothing without a server, if there is one.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let own =
            [(!self.listen.is_empty(), "--listen"), (matches!(self.viewer, Some(Viewer::At(_))), "--viewer")];
        let own = own.into_iter().find(|(is_given, _)| *is_given).map(|(_, option)| option);
        own.or_else(|| self.limits.given()).or_else(|| self.access.given())
    }
}

#[derive(Debug, Args)]
pub(crate) struct ConnectArgs {
    /// The server: HOST:PORT, https://HOST:PORT or unix:/PATH
    #[arg(long, value_name = "ADDR", default_value = DEFAULT_ADDRESS, env = "BAUDBOT_CONNECT", hide_env_values = true)]
    pub(crate) connect: String,
    #[command(flatten)]
    pub(crate) credentials: CredentialArgs,
    /// Name of the world [default: the server's only world]
    #[arg(long, env = "BAUDBOT_WORLD", hide_env_values = true)]
    pub(crate) world: Option<String>,
}

/// What is shown to a server. In the environment it is `BAUDBOT_TOKEN_FILE` and `BAUDBOT_CA`.
#[derive(Debug, Default, Args)]
pub(crate) struct CredentialArgs {
    /// A file with the token to present [default: the token of your own server on this machine]
    #[arg(long, value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
    /// Trust servers with certificates from these authorities, in PEM [default: those of the system]
    #[arg(long, value_name = "FILE")]
    pub(crate) ca: Option<PathBuf>,
}

impl CredentialArgs {
    /// These in place of those of the environment.
    ///
    /// # Errors
    /// If there are unsound ones.
    pub(crate) fn read(&self) -> Result<Credentials, baudbot_client::Error> {
        let mut credentials = Credentials::from_environment()?;
        if let Some(file) = &self.token_file {
            credentials = credentials.token_file(file)?;
        }
        if let Some(file) = &self.ca {
            credentials = credentials.authorities(file);
        }
        Ok(credentials)
    }
}

/// The default address of a server, and of its clients.
pub(crate) const DEFAULT_ADDRESS: &str = "127.0.0.1:7400";
