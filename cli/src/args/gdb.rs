//! The place at which a debugger connects, as `--gdb` names it.

use std::fmt;
use std::str::FromStr;

/// A robot, and a port of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct GdbAddress {
    /// Name of the robot.
    pub(crate) robot: String,
    /// The TCP port; 0 is any free one.
    pub(crate) port: u16,
}

impl FromStr for GdbAddress {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        // Names of robots may have a `=`; ports have none.
        let (robot, port) = text.rsplit_once('=').ok_or(FORM)?;
        let port = port.parse().map_err(|_| FORM)?;
        if robot.is_empty() {
            return Err(FORM);
        }
        Ok(Self { robot: robot.to_owned(), port })
    }
}

impl fmt::Display for GdbAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.robot, self.port)
    }
}

const FORM: &str = "write ROBOT=PORT, with a port from 0 to 65535";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses() {
        let address = GdbAddress { robot: "alice".to_owned(), port: 1234 };
        assert_eq!("alice=1234".parse(), Ok(address.clone()));
        assert_eq!(address.to_string(), "alice=1234");
        for bad in ["", "alice", "1234", "=1234", "alice=", "alice=65536", "alice=localhost:1234"] {
            assert_eq!(bad.parse::<GdbAddress>(), Err(FORM), "{bad}");
        }
    }
}
