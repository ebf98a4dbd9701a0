//! A throttle for commands: a brain sends no more of them than its cable can carry, and no fewer than there are messages.

use baudbot_brain::{Action, Body, Signals, Turn};

use crate::pace::Pace;

/// Sends signals with each message and when they change, as the [pace](crate::pace) of the cable allows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CommandThrottle {
    /// A greater signal is refused.
    limit: Option<f64>,
    sent: Option<(Signals, Vec<f64>)>,
    pace: Pace,
}

impl CommandThrottle {
    pub(crate) fn new(body: &Body) -> Self {
        Self { limit: body.signal_limit, sent: None, pace: Pace::new(body) }
    }

    /// The action of a turn in which the motors are to have these signals.
    pub(crate) fn send(&mut self, turn: &Turn, signals: Signals) -> Action {
        self.send_with(turn, signals, &[])
    }

    /// The same with signals for the actuators besides the wheels, as [`Action::others`].
    pub(crate) fn send_with(&mut self, turn: &Turn, signals: Signals, others: &[f64]) -> Action {
        let signals = within(self.limit, signals);
        self.pace.hear(turn);
        let is_new = self.sent.as_ref().is_none_or(|(sent, with)| *sent != signals || with != others);
        if !self.pace.sends(turn.at_ns, is_new) {
            return Action::wait();
        }
        self.pace.sent(turn.at_ns);
        self.sent = Some((signals, others.to_vec()));
        Action::drive(signals.left, signals.right).with_others(others.to_vec())
    }

    /// The action of a turn in which nothing is known yet that signals could follow from: a firmware that answers
    /// only when asked is asked.
    pub(crate) fn ask(&mut self, turn: &Turn) -> Action {
        let request = turn.body.request();
        self.pace.hear(turn);
        if request == Action::wait() || !self.pace.sends(turn.at_ns, false) {
            return Action::wait();
        }
        self.pace.sent(turn.at_ns);
        request
    }
}

/// The same way more slowly, where a wheel would be faster than the limit; standing still, where there is no way. A greater
/// signal than the data sheet's limit throws a brain off.
pub(crate) fn within(limit: Option<f64>, Signals { left, right }: Signals) -> Signals {
    let largest = left.abs().max(right.abs());
    if !(left.is_finite() && right.is_finite()) {
        return Signals::default();
    }
    match limit.filter(|limit| largest > *limit) {
        None => Signals { left, right },
        Some(limit) => {
            // Rounding must not put it above after all.
            let slower = |signal: f64| (signal * (limit / largest)).clamp(-limit, limit);
            Signals { left: slower(left), right: slower(right) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::{body, turn};

    const MS: u64 = 1_000_000;

    #[test]
    fn a_command_waits_for_the_cable_and_is_repeated_now_and_then() {
        let body = body(&[("front", "ir", 0.0)]);
        assert!(body.command_ns() > 5 * MS && body.command_ns() < 20 * MS, "{}", body.command_ns());
        let mut throttle = CommandThrottle::new(&body);
        let mut sent = Vec::new();
        for step in 0..30 {
            let signals = if step < 2 { Signals::default() } else { Signals { left: 0.5, right: 0.5 } };
            let turn = turn(&body, step * 10 * MS, &[None]);
            if throttle.send(&turn, signals).signals.is_some() {
                sent.push(step);
            }
        }
        assert_eq!(sent, [0, 2, 12, 22]);
    }

    #[test]
    fn signals_beyond_the_limit_keep_their_way() {
        let body = body(&[]);
        let sent = |left, right| {
            let turn = turn(&body, 0, &[]);
            CommandThrottle::new(&body).send(&turn, Signals { left, right }).signals.unwrap()
        };
        assert_eq!(sent(2.0, -1.0), Signals { left: 1.0, right: -0.5 });
        assert_eq!(sent(0.5, f64::NAN), Signals::default());
    }

    #[test]
    fn a_firmware_that_answers_when_asked_is_asked_once_for_each_answer() {
        let mut body = body(&[("front", "ir", 0.0)]);
        body.firmware.period_ns = None;
        let mut throttle = CommandThrottle::new(&body);
        let mut asked = |at_ms: u64, news: bool| {
            let turn = turn(&body, at_ms * MS, &[news.then_some(&[0.1][..])]);
            throttle.send(&turn, Signals::default()).signals.is_some()
        };
        assert!(asked(0, false));
        assert!(!asked(40, false) && asked(50, true));
        assert!(!asked(52, true), "the answer to what was asked at 50 ms is still to come");
        assert!(!asked(80, false) && asked(90, true));
    }

    #[test]
    fn an_answer_without_a_new_reading_is_answered_at_once() {
        let mut body = body(&[("front", "ir", 0.0)]);
        (body.firmware.period_ns, body.baud) = (None, Some(115_200));
        let mut throttle = CommandThrottle::new(&body);
        let mut asked = |at_ms: u64, has_message: bool| {
            let turn = Turn { has_message, ..turn(&body, at_ms * MS, &[None]) };
            throttle.send(&turn, Signals::default()).signals.is_some()
        };
        assert!(
            asked(0, false) && asked(10, true) && asked(20, true) && !asked(30, false) && asked(40, true)
        );
    }

    #[test]
    fn signals_that_stay_the_same_answer_each_message() {
        let body = body(&[("front", "ir", 0.0)]);
        let mut throttle = CommandThrottle::new(&body);
        let sent = (0..50).filter(|i| {
            let turn = turn(&body, i * 20 * MS, &[Some(&[0.1][..])]);
            throttle.send(&turn, Signals::default()).signals.is_some()
        });
        assert_eq!(sent.count(), 50);
    }

    #[test]
    fn signals_that_change_with_each_message_soon_go_out_with_it_whenever_the_first_was_sent() {
        let body = body(&[("front", "ir", 0.0)]);
        for first in 0..2 {
            let mut throttle = CommandThrottle::new(&body);
            let mut in_step = 0;
            for i in first..200 {
                // 20.487 ms, 40 ms, 40.487 ms, 60 ms: a message, and the end of a tick without one.
                let is_message = i % 2 == 1;
                let at_ns = 20 * MS * (i / 2) + if is_message { 487_000 } else { 0 };
                let messages = i.div_ceil(2);
                let signals = Signals { left: 1e-3 * f64::from(messages as u32), right: 0.0 };
                let turn = turn(&body, at_ns, &[is_message.then_some(&[0.1][..])]);
                let is_sent = throttle.send(&turn, signals).signals.is_some();
                assert!(is_message || !is_sent || i < 4, "{i}: between two messages");
                in_step += u32::from(is_message && is_sent);
            }
            assert!(in_step >= 97, "{first}: {in_step}");
        }
    }
}
