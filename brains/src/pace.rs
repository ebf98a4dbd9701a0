//! The times at which a brain sends its commands, for all brains of this crate and on all cables.
//!
//! Each message of the microcontroller is answered with a command, also one without a new reading; a new message is
//! answered at once. When nothing comes, the last command is repeated now and then, since the cable may have lost it.
//! No command is sent before the last one is off the cable: one that waits behind others comes too late. What comes
//! while the cable is taken is answered with the next message, if that is due soon ([`Beat`]).
//!
//! A firmware that answers only when asked is asked once for each answer ([`Questions`]).

use baudbot_brain::{Body, Turn};

use crate::beat::{Beat, REPEAT_NS};
use crate::questions::Questions;

/// The times at which a brain may send, kept up to date by each turn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Time that a command takes on the cable, in nanoseconds.
    command_ns: u64,
    sent_ns: Option<u64>,
    /// A message has come that no command has answered.
    owes: bool,
    talk: Talk,
}

/// The source of messages.
#[derive(Clone, Debug, PartialEq)]
enum Talk {
    /// The messages come by themselves.
    Streams(Beat),
    /// Commands ask for them.
    Asks(Questions),
}

impl Pace {
    /// A `Pace` of a robot with this body, of which nothing has come.
    pub(crate) fn new(body: &Body) -> Self {
        let talk = match body.firmware.period_ns {
            Some(_) => Talk::Streams(Beat::new(body)),
            None => Talk::Asks(Questions::new(body)),
        };
        Self { command_ns: body.command_ns(), sent_ns: None, owes: false, talk }
    }

    /// Takes in a turn; each turn once, before it is asked whether anything may be sent in it.
    pub(crate) fn hear(&mut self, turn: &Turn) {
        if !turn.is_answered() {
            return;
        }
        self.owes |= match &mut self.talk {
            Talk::Streams(beat) => beat.hear(turn.at_ns),
            Talk::Asks(questions) => questions.hear(turn.at_ns),
        };
    }

    /// Whether a command goes out at this instant. `is_other`: it differs from the last one.
    pub(crate) fn sends(&self, at_ns: u64, is_other: bool) -> bool {
        if !self.is_free(at_ns) {
            return false;
        }
        self.sent_ns.is_none()
            || match &self.talk {
                Talk::Streams(beat) => {
                    let is_due = self.owes || is_other || at_ns >= self.repeat_ns(beat);
                    is_due && beat.in_the_way_of(at_ns).is_none()
                }
                Talk::Asks(questions) => self.owes || questions.is_over(at_ns),
            }
    }

    /// The earliest instant at which it [sends](Self::sends) that, if no message comes.
    pub(crate) fn next_ns(&self, at_ns: u64, is_other: bool) -> u64 {
        let Some(sent_ns) = self.sent_ns else { return at_ns };
        let due_ns = match &self.talk {
            _ if self.owes => at_ns,
            Talk::Streams(_) if is_other => at_ns,
            Talk::Streams(beat) => self.repeat_ns(beat),
            Talk::Asks(questions) => questions.over_ns(),
        };
        let free_ns = due_ns.max(sent_ns.saturating_add(self.command_ns));
        match &self.talk {
            Talk::Streams(beat) => beat.in_the_way_of(free_ns).unwrap_or(free_ns),
            Talk::Asks(_) => free_ns,
        }
    }

    /// A command has been sent at this instant.
    pub(crate) fn sent(&mut self, at_ns: u64) {
        (self.sent_ns, self.owes) = (Some(at_ns), false);
        if let Talk::Asks(questions) = &mut self.talk {
            questions.ask(at_ns);
        }
    }

    fn is_free(&self, at_ns: u64) -> bool {
        self.sent_ns.is_none_or(|sent_ns| at_ns.saturating_sub(sent_ns) >= self.command_ns)
    }

    fn repeat_ns(&self, beat: &Beat) -> u64 {
        self.sent_ns.map_or(0, |sent_ns| sent_ns.saturating_add(REPEAT_NS).max(beat.silent_ns()))
    }
}
