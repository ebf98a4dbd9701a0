//! The device's side of SCIP 2.0: a range finder that is asked, and answers.
//!
//! | command | answer | status besides 00 |
//! |---|---|---|
//! | `VV` | vendor, product, firmware, protocol, serial number | |
//! | `PP` | model, nearest and farthest distance, steps | |
//! | `II` | laser, motor speed, mode, bit rate, time, state | |
//! | `BM` | the laser is lit | 02 it was lit, 10 asleep |
//! | `QT` | the laser is off, scans end | |
//! | `RS`, `RT` | as after power-on; `RT` leaves the bit rate alone | |
//! | `TM0` `TM1` `TM2` | time mode on, the time, time mode off | 01 other digit, 02 was on, 03 was off, 04 is off, 10 laser lit |
//! | `SS` rate | the bit rate from behind the answer on | 01 no digits, 02 no such rate, 03 it has this rate |
//! | `GD` `GS` `GE` steps | the newest scan | 01 to 05, 10 laser off |
//! | `MD` `MS` `ME` steps | an acknowledgement, then scans with status 99 | 01 to 07 |
//! | `RB` | 01, and at the second time within a second 00: power-on | 01 |
//! | `%ST` | the state in three digits | |
//! | `%SL` | the laser is off until `QT`, `RS` or `RT` | |
//!
//! `GE`, `ME`, `RT`, `RB`, `%ST` and `%SL` are those of [`Model::Ust10lx`], and undefined (0E) to the other, as `SS` is to a
//! device on a network (0F). Steps are first, last and cluster; of scans also the interval and how many, 00 without an end.
//! In time mode all but `TM`, `VV`, `II`, `RS`, `RT`, `RB` and `%ST` is refused with 0E.
//!
//! Any command may end in a semicolon and up to 16 characters, which are echoed. CR, LF, or both end a line; empty lines are
//! passed over.
//!
//! Sources: Hokuyo, SCIP 2.0, C-42-03320B (statuses, forms, rates); hokuyolx 0.9.0 (`GE` to `%SL`, and that checksums of
//! lines of text do not count the semicolon); urg_library (0E in time mode). Where none of them says it, the doc comment
//! does.

mod command;
mod machine;
mod reply;

pub use command::{Commands, Kind, Scans};
pub use machine::{Answer, Device, Effect, Newest};

use core::num::NonZeroU32;

/// A family of devices: which commands they know, and what they call themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// URG-04LX: RS-232 and USB, the commands of C-42-03320B.
    Urg04lx,
    /// UST-10LX: a network, no bit rate, intensities and states.
    Ust10lx,
}

/// A device's description of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// The family of the model.
    pub model: Model,
    /// Nearest distance in millimetres.
    pub least_mm: u32,
    /// Farthest distance in millimetres.
    pub most_mm: u32,
    /// Steps of a whole turn.
    pub steps_per_turn: u16,
    /// The step of the first measurement, at most [`last_step`](Self::last_step).
    pub first_step: u16,
    /// The step of the last measurement, at most 9999.
    pub last_step: u16,
    /// The step straight ahead.
    pub front_step: u16,
    /// Turns of the mirror a minute.
    pub turns_per_minute: u16,
}

impl Description {
    /// The last step that a command may name. There is as much beyond the last measurement as before the first: 768 of an
    /// URG-04LX (Hokuyo, SCIP 2.0, C-42-03320B, step D), where steps without a measurement read 0.
    pub const fn end_step(&self) -> u16 {
        let beyond = self.last_step.saturating_add(self.first_step).saturating_sub(1);
        let end = if beyond > self.last_step { beyond } else { self.last_step };
        if end > 9999 { 9999 } else { end }
    }
}

/// The bit rates that `SS` knows: Hokuyo, SCIP 2.0, C-42-03320B, which says of 38,400 that some models do not have it.
pub const RATES: [u32; 7] = [19_200, 38_400, 57_600, 115_200, 250_000, 500_000, 750_000];

/// The bit rate of a cable; `None` where it has none, as USB, and `SS` is accepted without an effect.
pub type Rate = Option<NonZeroU32>;

/// Intensity of any echo. How much comes back is not modelled; 0 stands for no echo. The number is a guess.
pub const INTENSITY: u32 = 2000;

/// Time from the last byte of a command to the first of its answer, in nanoseconds: a guess, as no document says it.
pub const ANSWER_NS: u64 = 1_000_000;

/// Time in which a second `RB` must come, in nanoseconds. Recalled from the makers of UTM-30LX.
const REBOOT_WITHIN_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests;
