//! Sockets as ports: one program at a time has the cable.

use std::fs;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixDatagram, UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use baudbot_fields::endpoint::Endpoint;

use crate::error::PortError;
use baudbot_access::peer::Reach;

/// A socket that waits for programs.
#[derive(Debug)]
pub(crate) enum Listener {
    Tcp(TcpListener, Reach),
    /// The listener with its file, and which one that is: another server may have taken the name since.
    Unix(UnixListener, PathBuf, FileId),
}

/// Device and inode of a file.
type FileId = (u64, u64);

/// A program's connection.
#[derive(Debug)]
pub(crate) enum Connection {
    Tcp(TcpStream),
    Unix(UnixStream),
}

impl Listener {
    pub(crate) fn tcp(address: SocketAddr, reach: Reach, place: &Endpoint) -> Result<Self, PortError> {
        let bound = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            Ok(Self::Tcp(listener, reach))
        });
        bound.map_err(|source| PortError::Open { place: place.clone(), source })
    }

    pub(crate) fn unix(path: &Path, place: &Endpoint) -> Result<Self, PortError> {
        check_free(path)?;
        let bound = UnixListener::bind(path).and_then(|listener| {
            fs::set_permissions(path, fs::Permissions::from_mode(0o600))?;
            listener.set_nonblocking(true)?;
            let file = fs::symlink_metadata(path)?;
            Ok(Self::Unix(listener, path.to_owned(), (file.dev(), file.ino())))
        });
        bound.map_err(|source| PortError::Open { place: place.clone(), source })
    }

    /// The address of the listener: port 0 has become another.
    pub(crate) fn local_addr(&self) -> Option<SocketAddr> {
        match self {
            Self::Tcp(listener, _) => listener.local_addr().ok(),
            Self::Unix(..) => None,
        }
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(listener, _) => listener.as_fd(),
            Self::Unix(listener, ..) => listener.as_fd(),
        }
    }

    /// The next program that wants to connect.
    pub(crate) fn accept(&self) -> Option<Connection> {
        let connection = match self {
            Self::Tcp(listener, reach) => {
                // Programs that may not have it are sent away.
                let stream = loop {
                    let (stream, _) = listener.accept().ok()?;
                    if reach.allows(&stream) {
                        break stream;
                    }
                };
                // Each byte leaves at its own instant.
                stream.set_nodelay(true).ok()?;
                Connection::Tcp(stream)
            }
            Self::Unix(listener, ..) => Connection::Unix(listener.accept().ok()?.0),
        };
        connection.set_nonblocking().ok()?;
        Some(connection)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path, own) = self
            && fs::symlink_metadata(&*path).is_ok_and(|found| (found.dev(), found.ino()) == *own)
        {
            drop(fs::remove_file(path));
        }
    }
}

/// A socket without a listener is one of a server that was killed.
///
/// The check for a listener is made with a datagram: a socket that is alive refuses its type (`EPROTOTYPE`, unix(7)),
/// and its server takes no notice; a dead one refuses the connection. A connection of its own type would be a program
/// to the other server, and reset its robot's board.
fn check_free(path: &Path) -> Result<(), PortError> {
    let in_the_way = |what| Err(PortError::InTheWay { path: path.to_owned(), what });
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(found) if found.file_type().is_socket() => {
            let asked = UnixDatagram::unbound().and_then(|probe| probe.connect(path));
            if asked.is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
                drop(fs::remove_file(path));
                return Ok(());
            }
            in_the_way("a socket that is in use")
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unix_socket_that_lives_is_refused_without_its_notice_and_a_dead_one_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.sock");
        let place = Endpoint::Unix(path.display().to_string());
        let first = Listener::unix(&path, &place).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let error = Listener::unix(&path, &place).unwrap_err().to_string();
        assert!(error.contains("a socket that is in use already exists"), "{error}");
        assert!(first.accept().is_none(), "the first one saw no program");
        UnixStream::connect(&path).unwrap();
        drop(first);
        assert!(!path.exists());
        drop(UnixListener::bind(&path).unwrap());
        assert!(path.exists(), "as a server leaves it that is killed");
        let second = Listener::unix(&path, &place).unwrap();
        fs::remove_file(&path).unwrap();
        fs::write(&path, "precious").unwrap();
        drop(second);
        assert!(path.exists(), "what is not the listener's own stays");
        assert!(Listener::unix(&path, &place).is_err());
    }
}
