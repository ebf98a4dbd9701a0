//! The user of the program at the other end of a connection on this machine.
//!
//! An address of loopback keeps other machines out, and no other user of this one. Doors without tokens, as debuggers and programs
//! with serial ports know none, ask the system who has connected.

use std::fs;
use std::net::{IpAddr, SocketAddr, TcpStream};

use crate::private::user;

/// The users whose programs may connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// The programs of this user may connect.
    OwnUser,
    /// All programs that reach the address may connect.
    Anyone,
}

impl Reach {
    /// Whether the program at the other end of a connection may come in.
    pub fn allows(self, stream: &TcpStream) -> bool {
        match self {
            Self::Anyone => true,
            Self::OwnUser => user_of(stream) == Some(user()),
        }
    }
}

/// The user whose program is at the other end of a connection on this machine, by the kernel's list of connections; `None` if it is
/// not there, as a connection is not any more that has been closed.
fn user_of(stream: &TcpStream) -> Option<u32> {
    // The peer's end has our addresses the other way round.
    let (peer, own) = (stream.peer_addr().ok()?, stream.local_addr().ok()?);
    let file = if peer.is_ipv4() { "/proc/net/tcp" } else { "/proc/net/tcp6" };
    let list = fs::read_to_string(file).ok()?;
    let wanted = format!("{} {} ", hexadecimal(peer), hexadecimal(own));
    let line = list.lines().find_map(|line| line.split_once(": ")?.1.strip_prefix(&wanted))?;
    // The fields behind it: state, queues, timer, retransmits, and the user.
    line.split_whitespace().nth(4)?.parse().ok()
}

/// An address as the kernel lists it: words of 32 bits in the byte order of the processor, and the port.
fn hexadecimal(address: SocketAddr) -> String {
    let words = |bytes: &[u8]| -> String {
        bytes
            .chunks_exact(4)
            .map(|word| format!("{:08X}", u32::from_ne_bytes([word[0], word[1], word[2], word[3]])))
            .collect()
    };
    let ip = match address.ip() {
        IpAddr::V4(ip) => words(&ip.octets()),
        IpAddr::V6(ip) => words(&ip.octets()),
    };
    format!("{ip}:{:04X}", address.port())
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn the_user_at_the_other_end_is_found() {
        for address in ["127.0.0.1:0", "[::1]:0"] {
            let listener = TcpListener::bind(address).unwrap();
            let near = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (far, _) = listener.accept().unwrap();
            assert_eq!(user_of(&far), Some(user()), "{address}");
            assert!(Reach::OwnUser.allows(&far));
            drop(near);
        }
    }

    #[test]
    fn addresses_are_written_as_the_kernel_does() {
        let address = "127.0.0.1:8080".parse().unwrap();
        let expected = if cfg!(target_endian = "little") { "0100007F:1F90" } else { "7F000001:1F90" };
        assert_eq!(hexadecimal(address), expected);
    }
}
