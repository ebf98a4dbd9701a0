//! The port that is to be opened, and its place: the value of `--port`.

use std::str::FromStr;

use baudbot_fields::endpoint::{BadEndpoint, Endpoint};
use thiserror::Error;

/// A port that is to be opened: `ROBOT[/DEVICE]=KIND:WHERE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortAddress {
    /// Name of the robot; none if there is only one.
    pub robot: Option<String>,
    /// The sensor whose own cable it is; none for the microcontroller's.
    pub device: Option<String>,
    /// The place.
    pub endpoint: Endpoint,
}

/// A text that is no port.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BadPort {
    /// The robot or the device is missing before the `=`, or the place of the port.
    #[error(
        "`{text}` is not a port; write ROBOT=pty:NAME, tcp:ADDRESS, rfc2217:ADDRESS or unix:PATH, e.g. khepera=pty:khepera.tty"
    )]
    Form {
        /// The text.
        text: String,
    },
    /// The text behind the `=` is no endpoint.
    #[error("{0}")]
    Endpoint(BadEndpoint),
}

impl FromStr for PortAddress {
    type Err = BadPort;

    fn from_str(text: &str) -> Result<Self, BadPort> {
        let form = || BadPort::Form { text: text.to_owned() };
        let (who, endpoint) = match text.split_once('=') {
            Some((who, endpoint)) if !who.is_empty() => (Some(who), endpoint),
            Some(_) => return Err(form()),
            None => (None, text),
        };
        let (robot, device) = match who.map(|who| who.split_once('/').ok_or(who)) {
            None => (None, None),
            Some(Err(robot)) => (Some(robot.to_owned()), None),
            Some(Ok((robot, device))) => {
                (Some(robot.to_owned()).filter(|name| !name.is_empty()), Some(device.to_owned()))
            }
        };
        if device.as_ref().is_some_and(String::is_empty) {
            return Err(form());
        }
        let endpoint = endpoint.parse().map_err(|error| match error {
            BadEndpoint::Form { .. } => form(),
            BadEndpoint::Kind { .. } | BadEndpoint::Address { .. } | BadEndpoint::NoPath { .. } => {
                BadPort::Endpoint(error)
            }
        })?;
        Ok(Self { robot, device, endpoint })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_read_as_the_documents_write_them() {
        let port = |text: &str| text.parse::<PortAddress>();
        let urg = port("khepera/urg=tcp:10940").unwrap();
        assert_eq!((urg.robot.as_deref(), urg.device.as_deref()), (Some("khepera"), Some("urg")));
        assert_eq!(urg.endpoint.to_string(), "tcp:127.0.0.1:10940");
        assert_eq!(port("pty:a.tty").unwrap().robot, None);
        assert_eq!(port("/gps=pty:a.tty").unwrap().device.as_deref(), Some("gps"));
        let error = |text: &str| port(text).unwrap_err().to_string();
        assert!(error("khepera").contains("is not a port; write ROBOT=pty:NAME"));
        assert!(error("=pty:x").contains("is not a port") && error("k/=pty:x").contains("is not a port"));
        assert_eq!(error("k=com:3"), "`com` is not a kind of port; there are pty, tcp, rfc2217 and unix");
    }
}
