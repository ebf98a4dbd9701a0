//! The effects of a board on the world.

use serde::{Deserialize, Serialize};

use super::Board;
use crate::parts::{Instant, MotorDrive, Part, Pulse, ServoKind};
use crate::physics::PartId;
use crate::sent::Sent;

/// A motor at a channel of an H-bridge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// The channel.
    pub part: PartId,
    /// The drive of the motor in the last step.
    pub drive: MotorDrive,
    /// The voltage that the bridge takes from the motor while it drives it, in volts.
    pub drop_v: f64,
}

/// A servo.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoOutput {
    /// The servo.
    pub part: PartId,
    /// The meaning of its pulses.
    pub kind: ServoKind,
    /// The last pulse that it obeys.
    pub pulse: Option<Pulse>,
}

/// A light-emitting diode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// The diode.
    pub part: PartId,
    /// The fraction of the last step in which it was lit, 0 to 1.
    pub brightness: f64,
}

/// A piezo buzzer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tone {
    /// The buzzer.
    pub part: PartId,
    /// The frequency of its tone, in hertz; None: it is silent.
    pub hz: Option<f64>,
}

impl Board {
    /// The drives of the motors by H-bridges in the last step, in the order of the parts.
    pub fn drives(&self) -> impl Iterator<Item = Motor> {
        self.parts().filter_map(|(part, state)| {
            let bridge = state.bridge()?;
            Some(Motor { part, drive: bridge.drive(), drop_v: bridge.drop_v() })
        })
    }

    /// The last pulses of the servos, in the order of the parts.
    pub fn servos(&self) -> impl Iterator<Item = ServoOutput> {
        self.parts().filter_map(|(part, state)| {
            let Part::Servo(servo) = state else { return None };
            Some(ServoOutput { part, kind: servo.kind(), pulse: servo.last() })
        })
    }

    /// The brightness of the light-emitting diodes in the last step, in the order of the parts.
    pub fn lights(&self) -> impl Iterator<Item = Light> {
        self.parts().filter_map(|(part, state)| {
            let Part::Led(led) = state else { return None };
            Some(Light { part, brightness: led.brightness() })
        })
    }

    /// The tones of the piezo buzzers now, in the order of the parts.
    pub fn tones(&self) -> impl Iterator<Item = Tone> {
        let now = Instant { cycle: self.chip.now(), clock: &self.around.clock };
        self.parts().filter_map(move |(part, state)| {
            let Part::Piezo(piezo) = state else { return None };
            Some(Tone { part, hz: piezo.hz(now) })
        })
    }

    /// Takes the characters that the chip has sent since they were last taken, in the order of time. There is room for 256.
    pub fn sent(&mut self) -> impl Iterator<Item = Sent> {
        self.around.sent.drain()
    }

    fn parts(&self) -> impl Iterator<Item = (PartId, &Part)> {
        (0..).map(PartId).zip(&self.around.parts)
    }
}
