//! Coming back to a server that was lost.

use std::time::Duration;

use tokio::time::{Instant, sleep_until};

/// Attempts something again and again, each time after a longer wait, until it succeeds, fails for good, or `limit` is over:
/// then its last error. A program whose connection [is lost](crate::Error::may_pass) so comes back to its robots once the server
/// is there again. Its brain starts over, as the world may have changed meanwhile.
///
/// ```no_run
/// # use std::time::Duration;
/// # use baudbot_client::{Action, Brain, Error, Turn, come_back, connect, run};
/// # struct Timid;
/// # impl Brain for Timid {
/// #     fn step(&mut self, _: &Turn) -> Action { Action::wait() }
/// # }
/// # async fn drive() -> Result<(), Error> {
/// let attach = async || connect("127.0.0.1:7400").await?.attach("wander", "robot").await;
/// let mut robot = attach().await?;
/// loop {
///     match run(&mut robot, &mut Timid).await {
///         Err(error) if error.may_pass() => {}
///         Ok(_) if robot.is_closed() => {}
///         ended => return ended.map(drop),
///     }
///     robot = come_back(Duration::from_secs(600), Error::may_pass, &attach).await?;
/// }
/// # }
/// ```
///
/// # Errors
/// The first that may not pass, or the last before the limit.
pub async fn come_back<T, E>(
    limit: Duration,
    mut may_pass: impl FnMut(&E) -> bool,
    attempt: impl AsyncFn() -> Result<T, E>,
) -> Result<T, E> {
    let end = Instant::now() + limit;
    let mut wait = FIRST_WAIT;
    loop {
        sleep_until(end.min(Instant::now() + wait)).await;
        match attempt().await {
            Err(error) if may_pass(&error) && Instant::now() < end => wait = LONGEST_WAIT.min(2 * wait),
            ended => return ended,
        }
    }
}

/// A server that only closed a connection is back at once.
const FIRST_WAIT: Duration = Duration::from_millis(250);

/// A server that is started again need not wait for its brains much longer than it was gone.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Fails so often with an error that passes, and then with one that does not.
    async fn attempts(limit_ms: u64, passing: u32) -> (Result<(), bool>, u32, Duration) {
        let (made, start) = (Cell::new(0), Instant::now());
        let attempt = async || {
            made.set(made.get() + 1);
            Err(made.get() <= passing)
        };
        let ended = come_back(Duration::from_millis(limit_ms), |passes| *passes, attempt).await;
        (ended, made.get(), start.elapsed())
    }

    #[tokio::test]
    async fn an_error_that_does_not_pass_ends_it_and_waits_grow() {
        let (ended, made, took) = attempts(60_000, 2).await;
        assert_eq!((ended, made), (Err(false), 3));
        assert!(took >= 7 * FIRST_WAIT, "{took:?}");
    }

    #[tokio::test]
    async fn the_last_attempt_is_made_at_the_limit() {
        let (ended, made, took) = attempts(400, u32::MAX).await;
        assert_eq!((ended, made), (Err(true), 2));
        assert!(took >= Duration::from_millis(400), "{took:?}");
        let at_once = come_back(Duration::ZERO, |_: &()| true, async || Ok(7)).await;
        assert_eq!(at_once, Ok(7));
    }
}
