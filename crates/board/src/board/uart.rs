//! Characters that come in at RXD.

use baudbot_avr::Bare;
use baudbot_avr::usart::{Frame, LineError};
use thiserror::Error;

use super::Board;
use crate::warning::WarningKind;

/// UCSR0B.
const CONTROL_B: u16 = 0xC1;
const RECEIVER_ON: u8 = 1 << 4;
/// The character before may have begun later than asked for, by an instruction or an interrupt with which a run ended, whatever the
/// rate.
const LATEST_START_CYCLES: u64 = 8;

/// A character cannot come in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ReceiveError {
    /// No chip can be sent bits of this length.
    #[error("the chip cannot be sent characters at {baud} baud")]
    Baud {
        /// The rate.
        baud: u32,
    },
    /// The line has no room for it.
    #[error(transparent)]
    Line(#[from] LineError),
}

impl Board {
    /// A character comes in at RXD: its start bit begins at an instant, which must not be over, and the sender's bits have
    /// exactly this rate. One that would begin within the last half bit of the one before it begins behind that: instants are
    /// rounded to nanoseconds, and bits to cycles.
    ///
    /// # Errors
    ///
    /// A rate without bits, an instant at which the line is not free, too many characters on their way.
    pub fn receive(&mut self, frame: Frame, start_ns: u64, baud: u32) -> Result<(), ReceiveError> {
        let clock = self.around.clock;
        let bit = clock.bit_of(baud).ok_or(ReceiveError::Baud { baud })?;
        if self.chip.read_data(CONTROL_B, &mut Bare) & RECEIVER_ON == 0 {
            self.around.warnings.add(WarningKind::ReceiverOff, None, None, start_ns, 1);
        }
        // A run may have ended some cycles behind the step.
        let start = clock.cycle(start_ns);
        let start = if start_ns >= self.now_ns { start.max(self.chip.now()) } else { start };
        let begun = match self.chip.receive(frame, start, bit) {
            Err(LineError::Occupied { start, free })
                if free - start <= LATEST_START_CYCLES.max(bit.begin_of(1) / 2) =>
            {
                self.chip.receive(frame, free, bit).map(|()| free)
            }
            taken => taken.map(|()| start),
        }?;
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.receives(frame, begun, bit);
        }
        Ok(())
    }
}
