//! Sockets as ports: one program at a time has the cable.

use std::fs;
use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use crate::address::Place;
use crate::error::PortError;

/// A socket that waits for programs.
#[derive(Debug)]
pub(crate) enum Listener {
    Tcp(TcpListener),
    Unix(UnixListener, PathBuf),
}

/// A program's connection.
#[derive(Debug)]
pub(crate) enum Connection {
    Tcp(TcpStream),
    Unix(UnixStream),
}

impl Listener {
    pub(crate) fn tcp(address: SocketAddr, place: &Place) -> Result<Self, PortError> {
        let bound = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            Ok(Self::Tcp(listener))
        });
        bound.map_err(|source| PortError::Open { place: place.clone(), source })
    }

    pub(crate) fn unix(path: &Path, place: &Place) -> Result<Self, PortError> {
        check_free(path)?;
        let bound = UnixListener::bind(path).and_then(|listener| {
            fs::set_permissions(path, fs::Permissions::from_mode(0o600))?;
            listener.set_nonblocking(true)?;
            Ok(Self::Unix(listener, path.to_owned()))
        });
        bound.map_err(|source| PortError::Open { place: place.clone(), source })
    }

    /// Where it listens: port 0 has become another.
    pub(crate) fn local_addr(&self) -> Option<SocketAddr> {
        match self {
            Self::Tcp(listener) => listener.local_addr().ok(),
            Self::Unix(..) => None,
        }
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(listener) => listener.as_fd(),
            Self::Unix(listener, _) => listener.as_fd(),
        }
    }

    /// The next program that wants to connect.
    pub(crate) fn accept(&self) -> Option<Connection> {
        let connection = match self {
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept().ok()?;
                // Each byte leaves at its own instant.
                stream.set_nodelay(true).ok()?;
                Connection::Tcp(stream)
            }
            Self::Unix(listener, _) => Connection::Unix(listener.accept().ok()?.0),
        };
        connection.set_nonblocking().ok()?;
        Some(connection)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path) = self {
            drop(fs::remove_file(path));
        }
    }
}

/// A socket to which nobody listens is what a program has left that was killed.
fn check_free(path: &Path) -> Result<(), PortError> {
    let in_the_way = |what| Err(PortError::InTheWay { path: path.to_owned(), what });
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(found) if found.file_type().is_socket() && UnixStream::connect(path).is_err() => {
            drop(fs::remove_file(path));
            Ok(())
        }
        Ok(found) if found.file_type().is_socket() => in_the_way("a socket that is in use"),
        Ok(found) if found.is_dir() => in_the_way("a folder"),
        Ok(_) => in_the_way("a file"),
    }
}

impl Connection {
    fn set_nonblocking(&self) -> io::Result<()> {
        match self {
            Self::Tcp(stream) => stream.set_nonblocking(true),
            Self::Unix(stream) => stream.set_nonblocking(true),
        }
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(stream) => stream.as_fd(),
            Self::Unix(stream) => stream.as_fd(),
        }
    }

    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.read(buffer),
            Self::Unix(stream) => stream.read(buffer),
        }
    }

    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.write(bytes),
            Self::Unix(stream) => stream.write(bytes),
        }
    }
}
