//! When a tick ends, and for how long a world waits for its brains.

use std::str::FromStr;
use std::time::Duration;

use baudbot_server::{Lockstep, Pace, Timed, Watchdog, WatchdogPolicy};
use clap::{Args, ValueEnum};

use super::value::{ValueError, whole};
use crate::error::Refused;

/// A pace as the command line has it, its watchdog apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PaceName {
    Lockstep,
    Timed(f64),
    Free,
}

impl FromStr for PaceName {
    type Err = ValueError;

    fn from_str(text: &str) -> Result<Self, ValueError> {
        match text.split_once(':') {
            None if text == "lockstep" => Ok(Self::Lockstep),
            None if text == "real-time" => Ok(Self::Timed(1.0)),
            None if text == "free" => Ok(Self::Free),
            Some(("scaled", factor)) => match factor.parse() {
                Ok(factor) if f64::is_finite(factor) && factor > 0.0 => Ok(Self::Timed(factor)),
                _ => Err(ValueError::Factor(factor.to_owned())),
            },
            _ => Err(ValueError::Form("must be lockstep, real-time, scaled:X (such as scaled:2.5) or free")),
        }
    }
}

impl PaceName {
    /// The pace with its defaults.
    pub(crate) fn pace(self) -> Pace {
        match self {
            Self::Lockstep => Pace::Lockstep(Lockstep::default()),
            Self::Timed(factor) => Pace::scaled(factor),
            Self::Free => Pace::Free,
        }
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = super::PACE)]
pub(crate) struct WatchdogArgs {
    /// In lockstep: wall-clock time that a brain may take to answer, in milliseconds [default: 10000]
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=u32::MAX))]
    pub(crate) watchdog_ms: Option<u32>,
    /// In lockstep: reaction to a brain that takes longer [default: wait]
    #[arg(long, value_name = "POLICY")]
    pub(crate) on_timeout: Option<OnTimeout>,
    /// In lockstep: let the world run ahead while a brain waits for a message or its answer is still on the cable; the run is the
    /// same either way [default: on]
    #[arg(long, value_name = "on|off")]
    pub(crate) lookahead: Option<Lookahead>,
    /// In real and scaled time: maximum lag behind the wall clock that the world makes up, in milliseconds; any more is skipped
    /// [default: 100]
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=u32::MAX))]
    pub(crate) max_lag_ms: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Lookahead {
    /// The world runs ahead
    On,
    /// The world waits for the answer of every brain at each of its steps
    Off,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum OnTimeout {
    /// The world keeps waiting
    Wait,
    /// The world continues, and waits for the brain again once it has answered
    GoOn,
    /// The brain is detached
    Detach,
}

impl WatchdogArgs {
    /// A pace with what these options say in place of what it has; one for which they make no sense is refused.
    pub(crate) fn apply(&self, pace: Pace) -> anyhow::Result<Pace> {
        let any = self.watchdog_ms.is_some() || self.on_timeout.is_some() || self.lookahead.is_some();
        if any && !matches!(pace, Pace::Lockstep(_) | Pace::Stepped(_)) {
            return Err(Refused::error(
                "--watchdog-ms, --on-timeout and --lookahead need --pace lockstep: other paces do not wait for brains",
            ));
        }
        if self.max_lag_ms.is_some() && !matches!(pace, Pace::Timed(_)) {
            return Err(Refused::error(
                "--max-lag-ms needs --pace real-time or scaled:X: other paces do not follow the wall clock",
            ));
        }
        Ok(match pace {
            Pace::Lockstep(lockstep) => Pace::Lockstep(self.watch(lockstep)),
            Pace::Stepped(lockstep) => Pace::Stepped(self.watch(lockstep)),
            Pace::Timed(timed) => {
                let max_lag = self.max_lag_ms.map_or(timed.max_lag, |ms| Duration::from_millis(ms.into()));
                Pace::Timed(Timed { max_lag, ..timed })
            }
            Pace::Free => Pace::Free,
        })
    }

    fn watch(&self, lockstep: Lockstep) -> Lockstep {
        let Lockstep { watchdog: Watchdog { timeout, policy }, lookahead } = lockstep;
        let asked = self.on_timeout.map(|policy| match policy {
            OnTimeout::Wait => WatchdogPolicy::Wait,
            OnTimeout::GoOn => WatchdogPolicy::GoOn,
            OnTimeout::Detach => WatchdogPolicy::Detach,
        });
        let watchdog = Watchdog {
            timeout: self.watchdog_ms.map_or(timeout, |ms| Duration::from_millis(ms.into())),
            policy: asked.unwrap_or(policy),
        };
        Lockstep { watchdog, lookahead: self.lookahead.map_or(lookahead, |asked| asked == Lookahead::On) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces() {
        assert_eq!("scaled:2.5".parse(), Ok(PaceName::Timed(2.5)));
        for bad in ["", "scaled", "scaled:", "scaled:0", "scaled:inf", "scaled:-1", "fast", "free:1"] {
            assert!(bad.parse::<PaceName>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_watchdog_belongs_to_lockstep() {
        let lookahead = Some(Lookahead::Off);
        let on_timeout = Some(OnTimeout::Detach);
        let args = WatchdogArgs { watchdog_ms: Some(5), on_timeout, lookahead, max_lag_ms: None };
        let watchdog = Watchdog { timeout: Duration::from_millis(5), policy: WatchdogPolicy::Detach };
        let lockstep = Lockstep { watchdog, lookahead: false };
        assert_eq!(args.apply(PaceName::Lockstep.pace()).unwrap(), Pace::Lockstep(lockstep));
        assert!(args.apply(Pace::Free).is_err());
    }

    #[test]
    fn a_lag_belongs_to_the_wall_clock() {
        let args =
            |max_lag_ms| WatchdogArgs { watchdog_ms: None, on_timeout: None, lookahead: None, max_lag_ms };
        let timed = Timed { factor: 2.0, max_lag: Duration::from_millis(5) };
        assert_eq!(args(Some(5)).apply(PaceName::Timed(2.0).pace()).unwrap(), Pace::Timed(timed));
        assert_eq!(
            args(None).apply(Pace::Timed(timed)).unwrap(),
            Pace::Timed(timed),
            "as a recording has it"
        );
        assert_eq!(args(None).apply(PaceName::Timed(1.0).pace()).unwrap(), Pace::REAL_TIME);
        assert!(args(Some(5)).apply(PaceName::Lockstep.pace()).is_err());
    }
}
