//! The times of messages, so that the cable is free when a command has to answer the next message.
//!
//! A command that is sent between two messages is still on a slow cable when the second comes. Its answer then goes out
//! late, between that message and the next, and so on for ever: each command answers a message that is nearly a period old.
//! So between two messages a brain sends only what is off the cable before the next can come.

use baudbot_brain::Body;

/// The arrival times of the messages of a microcontroller that streams them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beat {
    /// Time that a command takes on the cable, in nanoseconds.
    command_ns: u64,
    /// The instant at which the last message came.
    heard_ns: Option<u64>,
    /// The intervals between the last ones, the newest first.
    intervals_ns: [Option<u64>; 4],
}

impl Beat {
    /// A `Beat` of a robot with this body, of which nothing has come.
    pub(crate) fn new(body: &Body) -> Self {
        Self { command_ns: body.command_ns(), heard_ns: None, intervals_ns: [None; 4] }
    }

    /// A message comes at this instant. It wants an answer, as each does.
    pub(crate) fn hear(&mut self, at_ns: u64) -> bool {
        if let Some(before_ns) = self.heard_ns {
            self.intervals_ns.rotate_right(1);
            self.intervals_ns[0] = Some(at_ns.saturating_sub(before_ns));
        }
        self.heard_ns = Some(at_ns);
        true
    }

    /// The instant until which a command waits for the next message, in nanoseconds, if one that is sent at this
    /// instant could still be on the cable then. A message that has just come is answered.
    pub(crate) fn in_the_way_of(&self, at_ns: u64) -> Option<u64> {
        let (heard_ns, [shortest_ns, longest_ns]) = (self.heard_ns?, self.usual_ns()?);
        let soonest_ns = heard_ns.saturating_add(shortest_ns);
        // A longer wait does not pay.
        let worth_ns = soonest_ns.saturating_add(self.command_ns.saturating_mul(4));
        let latest_ns = heard_ns.saturating_add(longest_ns).saturating_add(longest_ns / 4).min(worth_ns);
        // Messages that come faster than commands go cannot be answered each, whenever one is sent.
        let is_too_fast = longest_ns <= self.command_ns;
        let is_in_the_way = at_ns < latest_ns && at_ns.saturating_add(self.command_ns) > soonest_ns;
        (heard_ns != at_ns && !is_too_fast && is_in_the_way).then_some(latest_ns)
    }

    /// The instant from which on the microcontroller is silent for too long, so that the last command is repeated.
    pub(crate) fn silent_ns(&self) -> u64 {
        let twice_ns = |[_, longest_ns]: [u64; 2]| longest_ns.saturating_mul(2).min(10 * REPEAT_NS);
        let silence_ns = self.usual_ns().map_or(0, twice_ns);
        self.heard_ns.map_or(0, |heard_ns| heard_ns.saturating_add(silence_ns))
    }

    /// The shortest and the longest time between two messages of late. One that was much longer had a message lost in it.
    fn usual_ns(&self) -> Option<[u64; 2]> {
        let known_ns = || self.intervals_ns.iter().flatten().copied();
        let shortest_ns = known_ns().min()?;
        Some([shortest_ns, known_ns().max()?.min(shortest_ns.saturating_mul(2))])
    }
}

/// So often a command is repeated when nothing comes, in nanoseconds.
pub(crate) const REPEAT_NS: u64 = 100_000_000;
