//! Whether a program comes back to a server that it has lost, and for how long it tries.

use core::fmt;
use std::str::FromStr;
use std::time::Duration;

use thiserror::Error;
use tokio::time::Instant;

use crate::error::Error;

/// The time for which a program tries to come back to a server that it has lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reconnect {
    /// The program ends at once.
    Off,
    /// So long after each loss.
    For(Duration),
}

/// A text that is neither.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("must be off, or a number of whole seconds up to {MOST_S}, is {0}")]
pub struct BadReconnect(String);

impl Default for Reconnect {
    /// The default is ten minutes.
    fn default() -> Self {
        Self::For(Duration::from_secs(600))
    }
}

impl fmt::Display for Reconnect {
    /// The text in the form in which it is parsed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::For(limit) => write!(f, "{}", limit.as_secs()),
        }
    }
}

impl FromStr for Reconnect {
    type Err = BadReconnect;

    /// `off`, which 0 is, too, or whole seconds.
    fn from_str(text: &str) -> Result<Self, BadReconnect> {
        if text == "off" {
            return Ok(Self::Off);
        }
        match text.parse() {
            Ok(0) => Ok(Self::Off),
            Ok(s) if s <= MOST_S => Ok(Self::For(Duration::from_secs(s))),
            _ => Err(BadReconnect(text.to_owned())),
        }
    }
}

/// The rule for attempts to come back: which failure is worth another. A robot that is held may be held by the
/// program's own lost connection, but not for longer than the server takes to notice the loss: from then on it is
/// another brain.
#[derive(Debug, Default)]
pub(crate) struct Hope {
    held_since: Option<Instant>,
}

impl Hope {
    pub(crate) fn is_left(&mut self, error: &Error, now: Instant) -> bool {
        if !error.is_held() {
            self.held_since = None;
            return error.may_pass();
        }
        now - *self.held_since.get_or_insert(now) < NOTICED_WITHIN
    }
}

/// The seconds of a year.
const MOST_S: u64 = 31_536_000;

/// A server pings a silent connection after 20 s, and gives up one that has not answered for 20 s.
const NOTICED_WITHIN: Duration = Duration::from_secs(45);

#[cfg(test)]
mod tests {
    use tonic::Status;

    use super::*;

    #[test]
    fn coming_back_is_off_or_takes_some_seconds() {
        for (text, read) in [("off", Reconnect::Off), ("0", Reconnect::Off), ("600", Reconnect::default())] {
            assert_eq!(text.parse(), Ok(read), "{text}");
        }
        assert_eq!(
            Reconnect::For(Duration::from_secs(90)).to_string().parse(),
            Ok(Reconnect::For(Duration::from_secs(90)))
        );
        for bad in ["", "on", "-1", "1.5", "31536001", "inf"] {
            let error = bad.parse::<Reconnect>().unwrap_err().to_string();
            assert_eq!(error, format!("must be off, or a number of whole seconds up to 31536000, is {bad}"));
        }
    }

    #[test]
    fn a_robot_that_stays_held_is_held_by_another_brain() {
        let now = Instant::now();
        let after = |s: u64| now + Duration::from_secs(s);
        let held = Error::from(Status::already_exists("held by brain `avoid`"));
        let away = Error::from(Status::unavailable("too many connections"));
        let mut hope = Hope::default();
        assert!(hope.is_left(&held, after(0)) && hope.is_left(&held, after(44)));
        assert!(!hope.is_left(&held, after(45)));
        // A server that was away meanwhile has lost the connection at another time.
        assert!(hope.is_left(&away, after(50)) && hope.is_left(&held, after(51)));
        assert!(hope.is_left(&held, after(95)) && !hope.is_left(&held, after(96)));
        assert!(!hope.is_left(&Error::from(Status::not_found("no such world")), after(97)));
    }
}
