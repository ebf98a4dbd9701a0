//! A throttle for commands: a brain sends no more of them than its cable can carry.

use baudbot_brain::{Action, Body, Signals, Turn};

use crate::beat::Beat;

/// Sends signals when they change, again now and then since a cable may lose them, and never before the last command is off
/// the cable: one that waits behind others comes too late. What a message changed while the cable was taken waits for the
/// [next message](crate::beat), if that is due soon. A firmware that answers only when asked is asked once for each answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CommandThrottle {
    /// Time that a command takes on the cable.
    command_ns: u64,
    /// Whether it is commands that bring the readings.
    asks: bool,
    /// A greater signal is refused.
    limit: Option<f64>,
    sent: Option<(u64, Signals)>,
    news: bool,
    beat: Beat,
    /// The cable was taken when the last message came.
    is_out_of_step: bool,
}

impl CommandThrottle {
    pub(crate) fn new(body: &Body) -> Self {
        let (asks, limit) = (body.firmware.period_ns.is_none(), body.signal_limit);
        let beat = Beat::new(body);
        Self {
            command_ns: body.command_ns(),
            asks,
            limit,
            sent: None,
            news: false,
            beat,
            is_out_of_step: false,
        }
    }

    /// What is done in a turn in which the motors are to have these signals.
    pub(crate) fn send(&mut self, turn: &Turn, signals: Signals) -> Action {
        self.news |= turn.has_news();
        let signals = within(self.limit, signals);
        let since_ns = self.sent.map(|(sent_ns, _)| turn.at_ns.saturating_sub(sent_ns));
        let is_free = since_ns.is_none_or(|since_ns| since_ns >= self.command_ns);
        if self.beat.hear(turn) {
            self.is_out_of_step = !is_free;
        }
        let is_other = self.sent.is_none_or(|(_, sent)| sent != signals) || (self.asks && self.news);
        let is_due = is_other || since_ns.is_some_and(|since_ns| since_ns >= REPEAT_NS);
        let waits = self.is_out_of_step && self.beat.in_the_way_of(turn.at_ns).is_some();
        if !is_free || !is_due || waits {
            return Action::wait();
        }
        self.sent = Some((turn.at_ns, signals));
        (self.news, self.is_out_of_step) = (false, false);
        Action::drive(signals.left, signals.right)
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

/// So often signals are repeated that stay the same, in nanoseconds.
const REPEAT_NS: u64 = 100_000_000;

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
        assert!(!asked(40, false) && asked(50, true) && !asked(52, true) && asked(80, false));
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
