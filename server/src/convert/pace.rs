//! The pace of a world.

use std::time::Duration;

use baudbot_proto::v1;
use tonic::Status;

use crate::pace::{Lockstep, Pace, Timed, Watchdog, WatchdogPolicy};

/// A pace from the contract; `None` if it is absent.
pub(crate) fn pace_from(pace: Option<v1::Pace>) -> Result<Option<Pace>, Status> {
    let Some(pace) = pace else { return Ok(None) };
    let kind = pace.kind.ok_or_else(|| Status::invalid_argument("pace.kind: must be set"))?;
    Ok(Some(match kind {
        v1::pace::Kind::RealTime(v1::RealTime { max_lag_ms }) => {
            Pace::Timed(Timed { factor: 1.0, max_lag: max_lag(max_lag_ms) })
        }
        v1::pace::Kind::Scaled(v1::Scaled { factor, max_lag_ms }) if factor.is_finite() && factor > 0.0 => {
            Pace::Timed(Timed { factor, max_lag: max_lag(max_lag_ms) })
        }
        v1::pace::Kind::Scaled(v1::Scaled { factor, .. }) => {
            return Err(Status::invalid_argument(format!(
                "pace.scaled.factor: must be positive, is {factor}"
            )));
        }
        v1::pace::Kind::Lockstep(lockstep) => {
            Pace::Lockstep(lockstep_from(lockstep.watchdog, lockstep.no_lookahead)?)
        }
        v1::pace::Kind::Stepped(stepped) => {
            Pace::Stepped(lockstep_from(stepped.watchdog, stepped.no_lookahead)?)
        }
        v1::pace::Kind::Free(_) => Pace::Free,
    }))
}

fn max_lag(ms: u32) -> Duration {
    if ms == 0 { Timed::MAX_LAG } else { Duration::from_millis(ms.into()) }
}

fn lockstep_from(watchdog: Option<v1::Watchdog>, no_lookahead: bool) -> Result<Lockstep, Status> {
    Ok(Lockstep { watchdog: watchdog_from(watchdog)?, lookahead: !no_lookahead })
}

fn watchdog_from(watchdog: Option<v1::Watchdog>) -> Result<Watchdog, Status> {
    let Some(watchdog) = watchdog else { return Ok(Watchdog::default()) };
    let timeout = match watchdog.timeout_ms {
        0 => Watchdog::default().timeout,
        ms => Duration::from_millis(ms.into()),
    };
    let unknown = |_| Status::invalid_argument(format!("watchdog.policy: there is no {}", watchdog.policy));
    let policy = match v1::WatchdogPolicy::try_from(watchdog.policy).map_err(unknown)? {
        v1::WatchdogPolicy::Unspecified | v1::WatchdogPolicy::Wait => WatchdogPolicy::Wait,
        v1::WatchdogPolicy::GoOn => WatchdogPolicy::GoOn,
        v1::WatchdogPolicy::Detach => WatchdogPolicy::Detach,
    };
    Ok(Watchdog { timeout, policy })
}

/// The pace of a message of the contract; `None` if that is not valid.
pub fn pace_of(pace: v1::Pace) -> Option<Pace> {
    pace_from(Some(pace)).ok().flatten()
}

pub(crate) fn pace_to(pace: Pace) -> v1::Pace {
    use v1::pace::Kind;
    let kind = match pace {
        Pace::Timed(Timed { factor: 1.0, max_lag }) => {
            Kind::RealTime(v1::RealTime { max_lag_ms: ms(max_lag) })
        }
        Pace::Timed(Timed { factor, max_lag }) => {
            Kind::Scaled(v1::Scaled { factor, max_lag_ms: ms(max_lag) })
        }
        Pace::Lockstep(Lockstep { watchdog, lookahead }) => {
            Kind::Lockstep(v1::Lockstep { watchdog: Some(watchdog_to(watchdog)), no_lookahead: !lookahead })
        }
        Pace::Stepped(Lockstep { watchdog, lookahead }) => {
            Kind::Stepped(v1::Stepped { watchdog: Some(watchdog_to(watchdog)), no_lookahead: !lookahead })
        }
        Pace::Free => Kind::Free(v1::Free {}),
    };
    v1::Pace { kind: Some(kind) }
}

fn watchdog_to(watchdog: Watchdog) -> v1::Watchdog {
    let policy = match watchdog.policy {
        WatchdogPolicy::Wait => v1::WatchdogPolicy::Wait,
        WatchdogPolicy::GoOn => v1::WatchdogPolicy::GoOn,
        WatchdogPolicy::Detach => v1::WatchdogPolicy::Detach,
    };
    v1::Watchdog { timeout_ms: ms(watchdog.timeout), policy: policy.into() }
}

/// Whole milliseconds, at least 1, since 0 has another meaning in the contract.
fn ms(duration: Duration) -> u32 {
    u32::try_from(duration.as_millis()).unwrap_or(u32::MAX).max(1)
}
