//! The questions to a firmware that answers only when asked.
//!
//! Each command is a question, and the answer to one is what the next waits for. If none comes the question is
//! repeated, since it or its answer may be lost: after one and a half times as long as answers take, and then ever more
//! seldom. If it was only slow, two answers come. A brain that answered both would have two questions on their way for
//! ever, each behind the other; so an answer that comes too soon behind a question is taken for one that had been given
//! up.

use baudbot_brain::Body;

use crate::beat::REPEAT_NS;

/// The open questions, and the instant at which the answer is overdue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Questions {
    /// Least time from a question to the end of its answer, in nanoseconds.
    least_ns: u64,
    /// The time that the cable needs for both, in nanoseconds, if nothing else holds them up.
    cable_ns: u64,
    /// The longest time that an answer took of late, in nanoseconds.
    slowest_ns: Option<u64>,
    /// The number of answers behind that figure.
    known: u32,
    /// Answers have been given up that may only have been slow: so much longer they are waited for, in nanoseconds.
    more_ns: u64,
    /// Questions since the last answer.
    open: u32,
    /// The instant at which the last of these was asked.
    asked_ns: u64,
    /// Questions before the last answer that were given up, whose answers may come after all.
    given_up: u32,
    /// The instant at which these are not waited for any more.
    forgotten_ns: u64,
}

impl Questions {
    /// The `Questions` of a brain that has asked nothing yet.
    pub(crate) fn new(body: &Body) -> Self {
        let command_ns = body.command_ns();
        Self {
            // A line of text may be shorter.
            least_ns: if body.firmware.protocol.is_dialogue() { 0 } else { command_ns },
            cable_ns: command_ns.saturating_add(body.message_ns()),
            slowest_ns: None,
            known: 0,
            more_ns: 0,
            open: 0,
            asked_ns: 0,
            given_up: 0,
            forgotten_ns: 0,
        }
    }

    /// A question is asked at this instant.
    pub(crate) fn ask(&mut self, at_ns: u64) {
        self.asked_ns = at_ns;
        self.open = self.open.saturating_add(1);
    }

    /// An answer comes at this instant. Whether it is that to the last question, so that the next may be asked.
    pub(crate) fn hear(&mut self, at_ns: u64) -> bool {
        let took_ns = at_ns.saturating_sub(self.asked_ns);
        if self.open > 0 && took_ns < self.least_ns {
            return false;
        }
        if at_ns >= self.forgotten_ns {
            self.given_up = 0;
        }
        if self.open > 0 && self.given_up > 0 && took_ns < self.usual_ns() / 2 {
            self.given_up -= 1;
            return false;
        }
        if self.open == 1 {
            self.slowest_ns = Some(took_ns.max(self.slowest_ns.unwrap_or(0) / 32 * 31));
            self.known = self.known.saturating_add(1);
            self.more_ns = 0;
        }
        if self.open > 1 {
            // The question that it answers is unknown, and so is the time that it took.
            self.more_ns = self.more_ns.saturating_add(self.usual_ns() / 2);
            (self.given_up, self.forgotten_ns) = (self.open - 1, at_ns.saturating_add(FORGOTTEN_NS));
        }
        self.open = 0;
        true
    }

    /// Whether no answer is to be expected any more, so that it is asked again.
    pub(crate) fn is_over(&self, at_ns: u64) -> bool {
        at_ns >= self.over_ns()
    }

    /// The instant at which the wait ends.
    pub(crate) fn over_ns(&self) -> u64 {
        let overdue_ns = self.usual_ns().saturating_add(self.usual_ns() / 2).saturating_add(self.more_ns);
        let first_ns = if self.known < FEW { overdue_ns.max(REPEAT_NS) } else { overdue_ns };
        let doublings = self.open.saturating_sub(1).min(16);
        let waits_ns = first_ns.saturating_mul(1 << doublings).min(first_ns.max(REPEAT_NS));
        self.asked_ns.saturating_add(waits_ns)
    }

    /// The usual time until an answer. Before the first answer the delay between brain and cable is unknown.
    fn usual_ns(&self) -> u64 {
        self.slowest_ns.unwrap_or(REPEAT_NS).max(self.cable_ns)
    }
}

/// So few answers may all have been quick by chance.
const FEW: u32 = 4;

/// The answer to a question that was given up so long ago does not come.
const FORGOTTEN_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::body;

    const MS: u64 = 1_000_000;

    fn on_an_ideal_cable() -> Questions {
        let mut body = body(&[("front", "ir", 0.0)]);
        body.baud = None;
        Questions::new(&body)
    }

    #[test]
    fn after_an_answer_that_was_late_there_is_one_question_on_its_way_again() {
        for late_ms in [190, 250, 337, 500, 729] {
            let mut questions = on_an_ideal_cable();
            // A radio that takes so long once, and 60 ms else.
            let mut answers_ns = vec![late_ms * MS];
            questions.ask(0);
            let (mut asked, mut most) = (0, 0);
            for at_ns in (1..4000).map(|ms| ms * MS) {
                let heard = answers_ns.iter().filter(|&&answer_ns| answer_ns == at_ns).count();
                answers_ns.retain(|&answer_ns| answer_ns > at_ns);
                let mut owes = questions.is_over(at_ns);
                for _ in 0..heard {
                    owes |= questions.hear(at_ns);
                }
                if owes {
                    questions.ask(at_ns);
                    answers_ns.push(at_ns + 60 * MS);
                }
                if at_ns > 2000 * MS {
                    asked += u32::from(owes);
                    most = most.max(answers_ns.len());
                }
            }
            assert_eq!(most, 1, "{late_ms}: one at a time");
            assert!((32..=35).contains(&asked), "{late_ms}: {asked}, and as often as it answers");
        }
    }

    #[test]
    fn a_lost_answer_costs_a_little_more_than_an_answer_and_a_long_silence_a_tenth_of_a_second_each() {
        let mut questions = on_an_ideal_cable();
        for answers in 0..8 {
            questions.ask(4 * answers * MS);
            assert!(questions.hear(4 * (answers + 1) * MS));
        }
        let mut at_ns = 32 * MS;
        let mut waits_ms = Vec::new();
        for _ in 0..8 {
            questions.ask(at_ns);
            waits_ms.push((questions.over_ns() - at_ns) / MS);
            at_ns = questions.over_ns();
        }
        assert_eq!(waits_ms, [6, 12, 24, 48, 96, 100, 100, 100]);
        questions.ask(at_ns);
        assert!(questions.hear(at_ns + 3 * MS));
    }
}
