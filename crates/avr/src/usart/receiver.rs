//! The receiver: it finds start bits, samples each bit three times in its middle, and keeps two characters.
//!
//! Source: data sheet, sections *Asynchronous Data Reception* and *Multi-processor Communication Mode*. Of the samples of a bit, 1 to 16, those numbered 8, 9 and 10
//! are a vote; of 8 samples with U2X, those numbered 4, 5 and 6. Sample 1 of a start bit is the first that is low after one
//! that was high. The first stop bit ends with its vote: what follows may be a start bit.
//!
//! As two samples of three are enough for a stop bit, too, the receiver takes senders that are slower by one sample than the
//! data sheet's R_slow, with which all three are right. `tests/uart_sweep.rs` has both limits to the cycle.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use super::frame::Parity;
use super::line::Line;
use super::{FRAME_ERROR, OVERRUN, PARITY_ERROR, RECEIVED};
use crate::clock::Clock;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Character {
    data: u16,
    /// FE and UPE.
    errors: u8,
}

/// The format of the frames that the receiver expects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Format {
    pub(super) data_bits: u8,
    pub(super) parity: Parity,
    /// MPCM: characters whose ninth bit is 0 are ignored, or those whose first stop bit is, if they have no ninth bit.
    pub(super) addresses_only: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum State {
    /// The receiver waits for a low sample.
    Idle,
    /// The receiver waits for a high sample first: the last stop bit was low.
    Low,
    /// The receiver samples a bit.
    Sampling(Sampling),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Sampling {
    /// The instant at which the next sample of the vote is due.
    due: u64,
    /// Samples of this bit's vote that are done.
    taken: u8,
    high: u8,
    /// The bit, counted from the start bit.
    bit: u8,
    /// Bits that have been voted, the first lowest.
    bits: u16,
}

/// The receiver with its buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Receiver {
    state: State,
    /// The last sample that was looked at.
    at: u64,
    buffer: ArrayVec<Character, 2>,
    /// A character that waits in the shift register for room in the buffer.
    waiting: Option<Character>,
    overrun: bool,
}

/// The first tick of a generator at or after a cycle; it ticks at `zero` and every `divisor` cycles.
pub(super) const fn tick_from(cycle: u64, zero: u64, divisor: u64) -> u64 {
    zero + (cycle - zero).div_ceil(divisor) * divisor
}

impl Receiver {
    pub(super) const fn new() -> Self {
        Self { state: State::Low, at: 0, buffer: ArrayVec::new_const(), waiting: None, overrun: false }
    }

    /// Whether this receiver can exist at a cycle.
    pub(super) fn is_possible(&self, now: u64) -> bool {
        self.at <= now
            && match &self.state {
                State::Idle | State::Low => true,
                State::Sampling(sampling) => {
                    sampling.due < 1 << 61
                        && sampling.taken < 3
                        && sampling.high <= sampling.taken
                        && sampling.bit < 12
                }
            }
    }

    /// The receiver is switched on.
    pub(super) fn start(&mut self, now: u64) {
        *self = Self { at: now, ..Self::new() };
    }

    /// Samples before this cycle are dropped: the line has changed with it.
    pub(super) fn look_from(&mut self, now: u64) {
        self.at = self.at.max(now.saturating_sub(1));
    }

    /// RXC, and the errors of the character that is read next.
    pub(super) fn status(&self) -> u8 {
        let overrun = if self.overrun { OVERRUN } else { 0 };
        overrun | self.buffer.first().map_or(0, |first| RECEIVED | first.errors)
    }

    pub(super) fn ninth_bit(&self) -> u8 {
        self.buffer.first().map_or(0, |first| first.data.to_le_bytes()[1])
    }

    /// Takes the first character away; 0 if there is none.
    pub(super) fn take(&mut self) -> u8 {
        let Some(first) = self.buffer.pop_at(0) else { return 0 };
        self.overrun = false;
        self.buffer.extend(self.waiting.take());
        first.data.to_le_bytes()[0]
    }

    /// The next cycle with a sample that matters.
    pub(super) fn next_event(&self, line: &Line, clock: &Clock, zero: u64, divisor: u64) -> u64 {
        let awaited = match &self.state {
            State::Sampling(sampling) => return sampling.due,
            State::Idle => false,
            State::Low => true,
        };
        let mut cycle = self.at + 1;
        loop {
            cycle = tick_from(cycle.max(zero), zero, divisor);
            let period = clock.period_of(cycle);
            if line.level(period) == awaited {
                return cycle;
            }
            let Some(change) = line.next_change(period) else { return u64::MAX };
            cycle = clock.cycle_from(change);
        }
    }

    /// Takes the sample of this cycle, if one is due.
    pub(super) fn event(
        &mut self,
        now: u64,
        line: &mut Line,
        clock: &Clock,
        (zero, divisor): (u64, u64),
        samples: u64,
        format: Format,
    ) {
        if self.next_event(line, clock, zero, divisor) != now {
            return;
        }
        self.at = now;
        let level = line.level(clock.period_of(now));
        match self.state {
            State::Low => self.state = State::Idle,
            State::Idle => {
                if self.waiting.take().is_some() {
                    self.overrun = true;
                }
                let due = now + (samples / 2 - 1) * divisor;
                self.state = State::Sampling(Sampling { due, taken: 0, high: 0, bit: 0, bits: 0 });
            }
            State::Sampling(sampling) => self.sample(sampling, level, divisor, samples, format),
        }
        line.forget_before(clock.period_of(now));
    }

    fn sample(&mut self, mut sampling: Sampling, level: bool, divisor: u64, samples: u64, format: Format) {
        sampling.taken += 1;
        sampling.high += u8::from(level);
        sampling.due += divisor;
        if sampling.taken < 3 {
            self.state = State::Sampling(sampling);
            return;
        }
        let vote = sampling.high >= 2;
        let stop = 1 + format.data_bits + format.parity.bits();
        if sampling.bit == 0 && vote {
            // Noise, not a start bit.
            self.state = State::Idle;
        } else if sampling.bit >= stop {
            // The program may have made characters shorter meanwhile.
            self.finish(sampling.bits, vote, format);
        } else {
            sampling.bits |= u16::from(vote) << sampling.bit;
            let due = sampling.due + (samples - 3) * divisor;
            self.state =
                State::Sampling(Sampling { due, taken: 0, high: 0, bit: sampling.bit + 1, ..sampling });
        }
    }

    fn finish(&mut self, bits: u16, stop: bool, format: Format) {
        let Format { data_bits, parity, addresses_only } = format;
        let data = bits >> 1 & ((1 << data_bits) - 1);
        self.state = if stop { State::Idle } else { State::Low };
        let is_address = if data_bits == 9 { data >> 8 == 1 } else { stop };
        if addresses_only && !is_address {
            return;
        }
        let wrong_parity = parity.bits() == 1 && (bits >> (1 + data_bits) & 1 == 1) != parity.bit(data);
        let errors = if stop { 0 } else { FRAME_ERROR } | if wrong_parity { PARITY_ERROR } else { 0 };
        let character = Character { data, errors };
        if self.buffer.try_push(character).is_err() {
            self.waiting = Some(character);
        }
    }
}
