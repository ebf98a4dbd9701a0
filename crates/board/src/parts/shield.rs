//! A motor shield: bridges whose inputs are the outputs of a shift register.
//!
//! Each motor's part has a register of its own on the same wires, which all of them hear alike.
//!
//! Source: Texas Instruments, *SN74HC595*, function table; Adafruit's first motor shield and its clones connect its outputs as
//! [`inputs`](ShieldMotor::inputs) has it.

use serde::{Deserialize, Serialize};

use super::Signal;
use super::bridge::{self, BridgeKind};
use crate::role::Role;

/// A motor of the shield, M1 to M4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShieldMotor {
    /// M1, whose PWM is pin 11.
    M1,
    /// M2, whose PWM is pin 3.
    M2,
    /// M3, whose PWM is pin 6.
    M3,
    /// M4, whose PWM is pin 5.
    M4,
}

impl ShieldMotor {
    /// All of them, M1 first.
    pub const ALL: [Self; 4] = [Self::M1, Self::M2, Self::M3, Self::M4];

    /// The outputs of the register, 0 to 7, at the first and the second input of its bridge.
    const fn inputs(self) -> [u8; 2] {
        match self {
            Self::M1 => [2, 3],
            Self::M2 => [1, 4],
            Self::M3 => [5, 7],
            Self::M4 => [0, 6],
        }
    }
}

/// A motor of the shield, with its bridge and a register.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    motor: ShieldMotor,
    pub(super) bridge: bridge::State,
    register: ShiftRegister,
}

impl State {
    pub(crate) fn new(kind: BridgeKind, motor: ShieldMotor) -> Self {
        Self { motor, bridge: bridge::State::new(kind), register: ShiftRegister::default() }
    }

    pub(crate) fn is_possible(&self, kind: BridgeKind, motor: ShieldMotor, now: u64) -> bool {
        self.motor == motor && self.bridge.is_possible(kind, now)
    }

    pub(crate) fn hear(&mut self, role: Role, signal: Signal, at: u64) {
        match role {
            Role::Data | Role::Clock | Role::Latch => {
                self.register.hear(role, signal);
                self.bridge.set_inputs(self.register.inputs(self.motor), at);
            }
            Role::Signal
            | Role::A
            | Role::B
            | Role::Trigger
            | Role::Echo
            | Role::Pwm
            | Role::Direction
            | Role::In1
            | Role::In2
            | Role::Enable
            | Role::Standby
            | Role::Sda
            | Role::Scl => self.bridge.hear(role, signal, at),
        }
    }
}

/// A 74HC595, but for the enable of its outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct ShiftRegister {
    data: bool,
    clock: bool,
    latch: bool,
    /// What has been shifted in, the last bit lowest.
    shifted: u8,
    /// The levels of the outputs.
    outputs: u8,
}

impl ShiftRegister {
    /// The chip does something else to one of its inputs. A signal of a timer is none of a clock.
    fn hear(&mut self, role: Role, signal: Signal) {
        let level = signal.is_high();
        match role {
            Role::Data => self.data = level,
            Role::Clock => {
                if level && !self.clock {
                    self.shifted = self.shifted << 1 | u8::from(self.data);
                }
                self.clock = level;
            }
            Role::Latch => {
                if level && !self.latch {
                    self.outputs = self.shifted;
                }
                self.latch = level;
            }
            Role::Signal
            | Role::A
            | Role::B
            | Role::Trigger
            | Role::Echo
            | Role::Pwm
            | Role::Direction
            | Role::In1
            | Role::In2
            | Role::Enable
            | Role::Standby
            | Role::Sda
            | Role::Scl => {}
        }
    }

    /// The levels of both inputs of a motor's bridge.
    fn inputs(&self, motor: ShieldMotor) -> [f64; 2] {
        motor.inputs().map(|bit| f64::from(self.outputs >> bit & 1))
    }
}

#[cfg(test)]
mod tests {
    use std::vec;

    use baudbot_avr::{Drive, Pwm};

    use super::*;
    use crate::parts::{Decay, MotorDrive};

    const H: Signal = Signal::Steady(Drive::High);
    const L: Signal = Signal::Steady(Drive::Low);
    const QUARTER: Signal = Signal::Pwm(Pwm { high: 64, period: 256 });

    /// What the usual library does: eight bits from the highest on, then the latch.
    #[test]
    fn a_shield_drives_each_motor_by_its_two_bits() {
        let shifted = |motor, byte: u8, pwm, enable| {
            let mut inputs = vec![(Role::Enable, enable), (Role::Pwm, pwm), (Role::Latch, L)];
            for bit in (0..8).rev() {
                let data = if byte >> bit & 1 == 1 { H } else { L };
                inputs.extend([(Role::Clock, L), (Role::Data, data), (Role::Clock, H)]);
            }
            inputs.push((Role::Latch, H));
            let kind = BridgeKind::Shield { motor, drop_v: BridgeKind::L293D_DROP_V };
            let mut state = State::new(kind, motor);
            inputs.into_iter().for_each(|(role, signal)| state.hear(role, signal, 0));
            state.bridge.finish(16_000);
            state.bridge.drive()
        };
        let driven = |duty, decay| MotorDrive::Drive { duty, decay };
        for (motor, bits) in ShieldMotor::ALL.into_iter().zip([[2, 3], [1, 4], [5, 7], [0, 6]]) {
            let [forwards, backwards] = bits.map(|bit: u8| 1 << bit);
            assert_eq!(shifted(motor, forwards, QUARTER, L), driven(0.25, Decay::Coast), "{motor:?}");
            assert_eq!(shifted(motor, backwards, H, L), driven(-1.0, Decay::Brake), "{motor:?}");
            assert_eq!(shifted(motor, !(forwards | backwards), H, L), MotorDrive::Brake, "{motor:?}");
            let open = [shifted(motor, forwards, L, L), shifted(motor, forwards, H, H)];
            assert_eq!(open, [MotorDrive::Coast; 2], "{motor:?}");
        }
    }
}
