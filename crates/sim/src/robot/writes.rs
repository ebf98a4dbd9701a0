//! The writes of a robot's brain, compared with its statement ([`Writes`]): a budget holds only as far as that is so.
//!
//! A command is an *exception* if the statement does not allow it. A cycle is disturbed by an exception if one was written in
//! it, or since the last cycle that left the way down empty; only such a cycle may be longer than its budget says.
//!
//! *Choices.* A firmware that answers only when asked, and one that waits for a first word, may be spoken to once before
//! anything has come. What is written before a bootloader is done is lost and counts as nothing. Bytes are counted, as a brain of
//! bytes may write a command in pieces. None of this is part of the state: after a restore it is counted anew.

use crate::model::RobotSpec;
use crate::time::SimTime;
use baudbot_fields::Writes;

/// The brain's deviations from its stated writing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exceptions {
    /// Writes that the statement does not allow.
    pub writes: u64,
    /// Answered control cycles that were disturbed by these.
    pub cycles: u64,
}

/// The memory of a brain's writing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WriteWatch {
    /// The instant at which the brain's step is, and how long a tick.
    step: (SimTime, u64),
    /// Bytes that were written in it.
    bytes: u64,
    /// The last step in which something was written.
    wrote: Option<SimTime>,
    has_spoken: bool,
    is_disturbed: bool,
    /// The same all the time, and dear to count.
    command: Option<CommandSize>,
}

#[derive(Clone, Copy, Debug)]
struct CommandSize {
    /// The most bytes of a command, with the question that goes with it.
    bytes: u64,
    /// The command's time on the cable, in nanoseconds.
    time_ns: u64,
}

impl WriteWatch {
    /// The brain steps.
    pub(super) fn begin_step(&mut self, at: SimTime, step_ns: u64) {
        self.step = (at, step_ns);
        self.bytes = 0;
    }

    /// Notes so many bytes of the brain, which answer a message or do not. Returns whether that is an exception.
    pub(super) fn note(&mut self, spec: &RobotSpec, now: SimTime, bytes: usize, is_asked: bool) -> bool {
        if now.as_ns() < spec.processor.bootloader_ns {
            return false;
        }
        let before = self.bytes;
        self.bytes += bytes as u64;
        let has_spoken = core::mem::replace(&mut self.has_spoken, true);
        let (at, step_ns) = self.step;
        let last = if before > 0 { None } else { self.wrote.replace(at) };
        let waited_ns = last.map_or(u64::MAX, |last| at.since(last));
        let may_speak = is_asked || (!has_spoken && spec.firmware.is_silent_at_first());
        let writes = spec.writes.unwrap_or_default();
        let command = *self.command.get_or_insert_with(|| CommandSize::of(spec));
        let is_allowed = match writes {
            Writes::OnMessage => may_speak,
            Writes::WhenFree => before > 0 || waited_ns >= command.time_ns,
            Writes::AtMost(frequency) if writes.in_a_turn(step_ns) == 1 => {
                before > 0 || waited_ns >= frequency.period_ns()
            }
            Writes::EveryTick | Writes::AtMost(_) => true,
        };
        let most = writes.in_a_turn(step_ns).saturating_mul(command.bytes);
        let is_exception = !is_allowed || self.bytes > most;
        self.is_disturbed |= is_exception;
        is_exception
    }

    /// A command has closed a cycle; behind it the way down is empty or not. Whether that cycle was disturbed.
    pub(super) fn close(&mut self, is_empty: impl FnOnce() -> bool) -> bool {
        let was_disturbed = self.is_disturbed;
        self.is_disturbed = was_disturbed && !is_empty();
        was_disturbed
    }
}

impl CommandSize {
    fn of(spec: &RobotSpec) -> Self {
        let question = spec.firmware.agreement().question().len();
        let bytes = (spec.firmware.command_len_max() + question) as u64;
        Self { bytes, time_ns: spec.command_time_ns() }
    }
}
