//! What the microcontroller of a Khepera says and understands.

use baudbot_wire::Layout;
use baudbot_wire::khepera::{self, Question};

use super::{FITS, Microcontroller, Request};
use crate::firmware::{Firmware, Owed};
use crate::model::RobotSpec;

impl Microcontroller {
    /// The lines that it owes: first that a command was obeyed, then readings. Says how many bytes they are, and
    /// whether readings are in them.
    pub(super) fn write_lines(&mut self, firmware: &Firmware, out: &mut [u8]) -> (usize, bool) {
        let Owed { acknowledgement, readings } = self.decoder.settle();
        let said: &[u8] = if acknowledgement { &khepera::ACKNOWLEDGEMENT } else { &[] };
        out[..said.len()].copy_from_slice(said);
        if !readings {
            return (said.len(), false);
        }
        let layout = firmware.layout();
        let values = self.last_values(&layout);
        let told = khepera::write_readings(&layout, values, &mut out[said.len()..]).expect(FITS);
        (said.len() + told, true)
    }
}

/// What a line asks for; `None` if it makes no sense.
pub(super) fn request(spec: &RobotSpec, line: &[u8], layout: &Layout<'_>) -> Option<Request> {
    match Question::parse(line, layout).ok()? {
        Question::Poll => Some(Request::Poll),
        Question::Command(mut signals) => Request::drive(spec, &mut signals),
    }
}
