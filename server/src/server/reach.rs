//! The addresses at which clients and browsers reach a server, as it prints them.

use std::net::SocketAddr;

use super::Server;
use crate::address::Address;

impl Server {
    /// Links to the viewer. If only this machine reaches the page, they end with the token of this user's own programs,
    /// which a browser sends only to the page. The link of a server for others may be kept in logs, and has none: the
    /// page asks for one.
    pub fn viewer_links(&self) -> Vec<String> {
        let scheme = if self.is_encrypted { "https" } else { "http" };
        let link = |address: &SocketAddr| {
            let local = self.local.as_ref().filter(|_| address.ip().is_loopback() && !self.behind_proxy);
            let token = local.map(|(token, _)| format!("#token={}", token.reveal())).unwrap_or_default();
            format!("{scheme}://{}/{token}", self.reached_at(*address))
        };
        self.viewers.iter().map(link).collect()
    }

    /// The address that clients give for its first listener, and whether only this machine reaches that.
    pub fn client_address(&self) -> Option<(String, bool)> {
        let address = self.addresses.first()?;
        let shown = match address {
            Address::Tcp(tcp) if self.is_encrypted => format!("https://{}", self.reached_at(*tcp)),
            Address::Tcp(tcp) => self.reached_at(*tcp),
            Address::Unix(_) => address.to_string(),
        };
        Some((shown, address.is_local()))
    }

    /// The name at which clients reach this address: the server's, or this machine's, if it is that of all interfaces.
    fn reached_at(&self, address: SocketAddr) -> String {
        match (&self.host, address.ip()) {
            (Some(name), ip) if !ip.is_loopback() => format!("{name}:{}", address.port()),
            (_, ip) if ip.is_unspecified() => SocketAddr::from(([127, 0, 0, 1], address.port())).to_string(),
            (_, _) => address.to_string(),
        }
    }
}
