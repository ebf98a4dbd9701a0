//! Where servers listen, and where they are looked for.

use baudbot_server::{Address, Builder, Server, raise_descriptor_limit};
use clap::Args;

use crate::viewer::Viewer;

#[derive(Debug, Args)]
pub(crate) struct ListenArgs {
    /// Take brains, observers and operators here: IP:PORT (port 0 takes a free one) or unix:/PATH
    #[arg(long, value_name = "ADDR")]
    pub(crate) listen: Vec<Address>,
    /// Show the worlds in a browser at http://IP:PORT (port 0 takes a free one), or not: off
    ///
    /// At http://IP:PORT/metrics are numbers for Prometheus (docs/metrics.md).
    #[arg(long, value_name = "IP:PORT|off")]
    pub(crate) viewer: Option<Viewer>,
    /// Allow addresses that other machines reach; whoever reaches them may do anything here
    #[arg(long)]
    pub(crate) insecure: bool,
    /// Take at most so many connections at a time, pages included
    ///
    /// When there are as many, a new one gets the place of whoever has asked for nothing since it came; if nobody has, it is
    /// refused. The default is three quarters of the files that the program may have open (`ulimit -Hn`), with 32 left at
    /// least, and 16,384 at most.
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
