//! The listeners of a server: TCP, Unix sockets, in-process pipes.

use std::fs::Permissions;
use std::io;
use std::net::SocketAddr;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use baudbot_access::Token;
use baudbot_access::local::{self, LocalFiles};
use tokio::net::{TcpListener, UnixListener, UnixStream};

use super::ServerError;
use crate::address::Address;
use crate::gate::{Incoming, TcpEntry, Tls};

/// Listens for pages, on another port that is free if this one is taken and `or_free_port`.
pub(super) async fn listen_for_pages(
    socket: SocketAddr,
    or_free_port: bool,
    tls: Option<Tls>,
) -> Result<TcpEntry, ServerError> {
    let address = Address::Tcp(socket);
    let listener = match TcpListener::bind(socket).await {
        Err(error) if or_free_port && error.kind() == io::ErrorKind::AddrInUse => {
            TcpListener::bind((socket.ip(), 0)).await
        }
        listener => listener,
    };
    let listener = listener.map_err(|source| ServerError::Bind { address, source })?;
    Ok(TcpEntry { listener, tls })
}

/// All listeners of a server.
pub(super) struct Listeners {
    /// The listeners for brains, observers and operators.
    pub(super) ordinary: Vec<Listener>,
    /// The listeners for brains only.
    pub(super) brains: Vec<Listener>,
    /// The listeners for trainers; `None` if the server takes none.
    pub(super) trainers: Option<Vec<Listener>>,
    pub(super) pages: Vec<TcpEntry>,
}

impl Listeners {
    /// Writes the token for programs of this user where they look for it.
    ///
    /// # Errors
    /// If that cannot be written.
    pub(super) fn publish(&self, token: Token) -> Result<(Token, LocalFiles), ServerError> {
        let all = self.ordinary.iter().chain(&self.brains).chain(self.trainers.iter().flatten());
        let addresses: Vec<_> = all.filter_map(|listener| Some(listener.address()?.to_string())).collect();
        let files = local::publish(addresses.iter().map(String::as_str), &token)?;
        Ok((token, files))
    }
}

/// A listener for gRPC.
pub(super) enum Listener {
    Tcp(Address, TcpEntry),
    Unix(Address, UnixListener),
    /// Connections that are accepted outside of the server.
    Other(Incoming),
}

impl Listener {
    pub(super) async fn bind(address: Address, tls: Option<&Tls>) -> Result<Self, ServerError> {
        let failed = |source| ServerError::Bind { address: address.clone(), source };
        match &address {
            Address::Tcp(socket) => {
                let listener = TcpListener::bind(socket).await.map_err(failed)?;
                let bound = listener.local_addr().map_err(failed)?;
                Ok(Self::Tcp(Address::Tcp(bound), TcpEntry { listener, tls: tls.cloned() }))
            }
            Address::Unix(path) => {
                remove_stale(path).await.map_err(failed)?;
                let listener = UnixListener::bind(path).map_err(failed)?;
                // The credentials of a connection distinguish other users, too.
                std::fs::set_permissions(path, Permissions::from_mode(0o600)).map_err(failed)?;
                Ok(Self::Unix(address, listener))
            }
        }
    }

    pub(super) fn address(&self) -> Option<&Address> {
        match self {
            Self::Tcp(address, _) | Self::Unix(address, _) => Some(address),
            Self::Other(_) => None,
        }
    }
}

/// The file of a Unix socket that this server listens on.
pub(super) struct SocketFile {
    path: PathBuf,
    device_and_inode: (u64, u64),
}

impl SocketFile {
    pub(super) fn at(path: &Path) -> Option<Self> {
        let metadata = std::fs::symlink_metadata(path).ok()?;
        Some(Self { path: path.to_owned(), device_and_inode: (metadata.dev(), metadata.ino()) })
    }

    /// Removes it, unless that of another server is there by now.
    pub(super) fn remove(&self) {
        let here = Self::at(&self.path);
        if here.is_some_and(|here| here.device_and_inode == self.device_and_inode) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A socket that refuses connections is what a killed server left behind. Any other is in use.
async fn remove_stale(path: &Path) -> io::Result<()> {
    let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
    if !metadata.file_type().is_socket() {
        return Ok(());
    }
    let answer = tokio::time::timeout(Duration::from_secs(1), UnixStream::connect(path)).await;
    match answer {
        Ok(Err(error)) if error.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path),
        _ => Ok(()),
    }
}
