//! The options of `baudbot brain`.

use std::str::FromStr;
use std::time::Duration;

use clap::Args;

use super::ConnectArgs;

#[derive(Debug, Args)]
pub(crate) struct BrainArgs {
    /// Name of a brain, or a description file in TOML; with parameters if needed
    #[arg(value_name = "BRAIN[:K=V,…]")]
    pub(crate) brain: Option<String>,
    /// List the brains and their parameters
    #[arg(long)]
    pub(crate) list: bool,
    #[command(flatten)]
    pub(crate) server: ConnectArgs,
    /// A robot to drive, or robots by a pattern such as 'cell-*'; may be given several times [default: the world's only robot]
    #[arg(long = "robot", value_name = "ROBOT")]
    pub(crate) robots: Vec<String>,
    /// Seed of the brain's own random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// For how many seconds to try to reconnect when the server is lost; `off` is not at all
    #[arg(long, value_name = "S|off", default_value = "600")]
    pub(crate) reconnect: Reconnect,
}

/// For how long a brain tries to come back to a server that it has lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reconnect {
    /// It ends at once.
    Off,
    /// So long after each loss.
    For(Duration),
}

impl FromStr for Reconnect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "off" {
            return Ok(Self::Off);
        }
        match text.parse() {
            Ok(s) if (1..=MOST_S).contains(&s) => Ok(Self::For(Duration::from_secs(s))),
            _ => Err(format!("must be off, or a number of whole seconds from 1 to {MOST_S}, is {text}")),
        }
    }
}

/// A year.
const MOST_S: u64 = 31_536_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coming_back_is_off_or_takes_some_seconds() {
        assert_eq!("off".parse(), Ok(Reconnect::Off));
        assert_eq!("90".parse(), Ok(Reconnect::For(Duration::from_secs(90))));
        for bad in ["", "on", "0", "-1", "1.5", "31536001", "inf"] {
            assert!(bad.parse::<Reconnect>().is_err(), "{bad}");
        }
    }
}
