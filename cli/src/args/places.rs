//! Where servers listen, and where they are looked for.

use baudbot_server::{Address, Builder, Server, raise_descriptor_limit};
use clap::Args;

use crate::viewer::Viewer;

#[derive(Debug, Args)]
pub(crate) struct ListenArgs {
    /// Listen for brains, observers and operators: IP:PORT (port 0 picks a free one) or unix:/PATH
    #[arg(long, value_name = "ADDR")]
    pub(crate) listen: Vec<Address>,
    /// Serve the viewer for browsers at http://IP:PORT (port 0 picks a free one); `off` disables it
    ///
    /// Metrics for Prometheus are at http://IP:PORT/metrics (docs/metrics.md).
    #[arg(long, value_name = "IP:PORT|off")]
    pub(crate) viewer: Option<Viewer>,
    /// Allow addresses that other machines can reach; anyone who reaches them has full control of this server
    #[arg(long)]
    pub(crate) insecure: bool,
    /// Maximum number of connections at a time, including pages
    ///
    /// At the limit, a new connection replaces one that has made no request yet; if there is none, the new one is refused.
    /// The default is three quarters of the files that the program may have open (`ulimit -Hn`), with at least 32 kept
    /// free, and at most 16,384.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_connections: Option<u32>,
}

impl ListenArgs {
    /// A server that listens so, but for its addresses.
    pub(crate) fn builder(&self) -> Builder {
        raise_descriptor_limit();
        let builder = Server::builder().insecure(self.insecure);
        match self.max_connections {
            Some(connections) => builder.connections(connections as usize),
            None => builder,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct ConnectArgs {
    /// The server: HOST:PORT or unix:/PATH
    #[arg(long, value_name = "ADDR", default_value = DEFAULT_ADDRESS)]
    pub(crate) connect: String,
    /// Name of the world [default: the server's only world]
    #[arg(long)]
    pub(crate) world: Option<String>,
}

/// Where a server listens, and where one is looked for.
pub(crate) const DEFAULT_ADDRESS: &str = "127.0.0.1:7400";
