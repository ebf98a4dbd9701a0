//! The request of a message from the laptop, in each protocol.

use alloc::vec::Vec;

use baudbot_wire::create::Command;
use baudbot_wire::khepera::Access;
use baudbot_wire::{Message, Values};

use super::khepera;
use crate::drive::Wheels;
use crate::firmware::{Protocol, Refusal};
use crate::model::RobotSpec;

/// A request of the laptop to the microcontroller.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Request {
    Drive(Wheels, Vec<f64>),
    Poll,
    Access(Access),
    /// The bytes of a Create's command.
    OpenInterface(Vec<u8>),
}

impl Request {
    /// An error if the payload is invalid to this firmware, a signal beyond the motor's limit included.
    pub(super) fn parse(spec: &RobotSpec, payload: &[u8]) -> Result<Self, Refusal> {
        let layout = spec.firmware.layout();
        let request = match spec.firmware.protocol {
            Protocol::Bare { .. } => Self::drive(spec, &mut Values::new(layout.motors, payload)),
            Protocol::Khepera => return khepera::request(spec, payload, &layout),
            Protocol::Create(version) => {
                Command::parse(version, payload).map(|_| Self::OpenInterface(payload.to_vec()))
            }
            // Its decoder knows what each command is.
            Protocol::Asercom => None,
            Protocol::Framed { .. } => match Message::parse(payload, &layout) {
                Ok(Message::Poll { .. }) => Some(Self::Poll),
                Ok(Message::Command(command)) => Self::drive(spec, &mut command.values()),
                Ok(Message::Readings(_)) | Err(_) => None,
            },
        };
        request.ok_or(Refusal::Protocol)
    }

    pub(super) fn drive(spec: &RobotSpec, signals: &mut impl Iterator<Item = f64>) -> Option<Self> {
        let limit = spec.signal_limit.unwrap_or(f64::MAX);
        let mut next = || signals.next().filter(|signal| signal.is_finite() && signal.abs() <= limit);
        let wheels = Wheels { left: next()?, right: next()? };
        let others = spec.actuators.iter().map(|_| next()).collect::<Option<_>>()?;
        Some(Self::Drive(wheels, others))
    }
}
