//! H-bridges and their truth tables.
//!
//! An input that is modulated counts by the fraction of time in which it is high. Two modulated inputs count as independent
//! of each other; of the two inputs of a direction only the difference matters.
//!
//! Source: STMicroelectronics, *L298 Dual Full-Bridge Driver*, table *Electrical Characteristics* and the figure
//! *Bidirectional DC Motor Control*; Toshiba, *TB6612FNG*, table *H-SW Control Function*.

use serde::{Deserialize, Serialize};

use super::Signal;
use super::meter::Meter;
use super::shield::ShieldMotor;
use crate::role::Role;

/// One channel of a motor driver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BridgeKind {
    /// L298N: `in1`, `in2`, `enable`.
    L298N {
        /// The voltage that its two bipolar transistors take from the motor, in volts. At 1 A the data sheet has
        /// 1.35 V + 1.2 V.
        drop_v: f64,
    },
    /// TB6612FNG: `in1`, `in2`, `pwm`, `standby`.
    Tb6612 {
        /// The voltage that its MOS transistors take, in volts: at 1 A the data sheet has 0.5 V.
        drop_v: f64,
    },
    /// A driver with `pwm` and `direction`; a high direction is forwards.
    Directed {
        /// The motor's connection while `pwm` is low.
        decay: Decay,
        /// The voltage that it takes from the motor, in volts.
        drop_v: f64,
    },
    /// A motor of a shield with L293D bridges behind a shift register: `latch`, `clock`, `data`, `enable` (low is on), `pwm`.
    Shield {
        /// The motor.
        motor: ShieldMotor,
        /// The voltage that its two bipolar transistors take, in volts: the data sheet has 1.4 V + 1.2 V at 0.6 A.
        drop_v: f64,
    },
}

impl BridgeKind {
    /// An L298N at 1 A.
    pub const L298N: Self = Self::L298N { drop_v: 2.55 };
    /// The voltage that an L293D takes at 0.6 A.
    pub const L293D_DROP_V: f64 = 2.6;
    /// A TB6612FNG at 1 A.
    pub const TB6612: Self = Self::Tb6612 { drop_v: 0.5 };
}

/// The path of the motor's current while nothing drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Decay {
    /// The motor is shorted: slow decay.
    Brake,
    /// The motor is open: fast decay.
    Coast,
}

/// The effect of a channel on its motor, as the mean over a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MotorDrive {
    /// It is driven.
    Drive {
        /// The fraction of time in which it is driven forwards, less that backwards: −1 to 1.
        duty: f64,
        /// The connection during most of the rest of the time.
        decay: Decay,
    },
    /// It is shorted.
    Brake,
    /// It is open.
    Coast,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    kind: BridgeKind,
    in1: f64,
    in2: f64,
    /// PWM, and where a chip has none, always high.
    pwm: f64,
    /// Enable or standby.
    enable: f64,
    forwards: Meter,
    backwards: Meter,
    brake: Meter,
}

/// Fractions of time; the rest is coasting.
struct Fractions {
    forwards: f64,
    backwards: f64,
    brake: f64,
}

impl State {
    pub(crate) fn new(kind: BridgeKind) -> Self {
        let (pwm, enable) = match kind {
            BridgeKind::L298N { .. } => (1.0, 0.0),
            BridgeKind::Tb6612 { .. } => (0.0, 0.0),
            // A wire that nothing drives is low, and a low `enable` switches a shield's register on.
            BridgeKind::Shield { .. } | BridgeKind::Directed { .. } => (0.0, 1.0),
        };
        let meter = Meter::default();
        let in2 = if matches!(kind, BridgeKind::Directed { .. }) { 1.0 } else { 0.0 };
        let mut state =
            Self { kind, in1: 0.0, in2, pwm, enable, forwards: meter, backwards: meter, brake: meter };
        state.measure(0);
        state
    }

    pub(crate) fn is_possible(&self, kind: BridgeKind, now: u64) -> bool {
        let duties = [self.in1, self.in2, self.pwm, self.enable];
        let meters = [&self.forwards, &self.backwards, &self.brake];
        self.kind == kind
            && duties.iter().all(|duty| (0.0..=1.0).contains(duty))
            && meters.iter().all(|meter| meter.is_possible(now))
    }

    pub(crate) fn hear(&mut self, role: Role, signal: Signal, at: u64) {
        let duty = signal.duty();
        match role {
            Role::In1 => self.in1 = duty,
            Role::In2 => self.in2 = duty,
            Role::Direction => (self.in1, self.in2) = (duty, 1.0 - duty),
            Role::Pwm => self.pwm = duty,
            Role::Enable if matches!(self.kind, BridgeKind::Shield { .. }) => self.enable = 1.0 - duty,
            Role::Enable | Role::Standby => self.enable = duty,
            Role::Signal
            | Role::A
            | Role::B
            | Role::Trigger
            | Role::Echo
            | Role::Sda
            | Role::Scl
            | Role::Data
            | Role::Clock
            | Role::Latch => {}
        }
        self.measure(at);
    }

    /// The inputs of the bridge, where the chip does not drive them itself, have these levels from now on.
    pub(super) fn set_inputs(&mut self, inputs: [f64; 2], at: u64) {
        [self.in1, self.in2] = inputs;
        self.measure(at);
    }

    fn measure(&mut self, at: u64) {
        let Fractions { forwards, backwards, brake } = self.fractions();
        self.forwards.set(forwards, at);
        self.backwards.set(backwards, at);
        self.brake.set(brake, at);
    }

    fn fractions(&self) -> Fractions {
        let (in1, in2) = (self.in1, self.in2);
        let driven = self.enable * self.pwm;
        let (forwards, backwards) = match self.kind {
            BridgeKind::Directed { .. } => (driven * in1, driven * in2),
            BridgeKind::L298N { .. } | BridgeKind::Tb6612 { .. } | BridgeKind::Shield { .. } => {
                (driven * in1 * (1.0 - in2), driven * (1.0 - in1) * in2)
            }
        };
        let brake = match self.kind {
            BridgeKind::L298N { .. } | BridgeKind::Shield { .. } => {
                driven * (in1 * in2 + (1.0 - in1) * (1.0 - in2))
            }
            // Both inputs low: stop. Else a low PWM brakes.
            BridgeKind::Tb6612 { .. } => {
                self.enable * (in1 * in2 + (1.0 - self.pwm) * (in1 * (1.0 - in2) + (1.0 - in1) * in2))
            }
            BridgeKind::Directed { decay: Decay::Brake, .. } => 1.0 - self.pwm,
            BridgeKind::Directed { decay: Decay::Coast, .. } => 0.0,
        };
        Fractions { forwards, backwards, brake }
    }

    pub(crate) fn finish(&mut self, now: u64) {
        for meter in [&mut self.forwards, &mut self.backwards, &mut self.brake] {
            meter.finish(now);
        }
    }

    /// The drive in the last step.
    pub(crate) fn drive(&self) -> MotorDrive {
        let (forwards, backwards) = (self.forwards.mean(), self.backwards.mean());
        let brake = self.brake.mean();
        let coast = 1.0 - forwards - backwards - brake;
        match (forwards + backwards > 0.0, brake >= coast) {
            (true, brakes) => {
                let decay = if brakes { Decay::Brake } else { Decay::Coast };
                MotorDrive::Drive { duty: forwards - backwards, decay }
            }
            (false, true) => MotorDrive::Brake,
            (false, false) => MotorDrive::Coast,
        }
    }

    pub(crate) const fn drop_v(&self) -> f64 {
        match self.kind {
            BridgeKind::L298N { drop_v }
            | BridgeKind::Tb6612 { drop_v }
            | BridgeKind::Shield { drop_v, .. }
            | BridgeKind::Directed { drop_v, .. } => drop_v,
        }
    }
}

#[cfg(test)]
mod tests {
    use baudbot_avr::{Drive, Pwm};

    use super::*;

    const H: Signal = Signal::Steady(Drive::High);
    const L: Signal = Signal::Steady(Drive::Low);
    const QUARTER: Signal = Signal::Pwm(Pwm { high: 64, period: 256 });

    fn drive(kind: BridgeKind, inputs: &[(Role, Signal)]) -> MotorDrive {
        let mut state = State::new(kind);
        for &(role, signal) in inputs {
            state.hear(role, signal, 0);
        }
        state.finish(16_000);
        state.drive()
    }

    #[test]
    fn an_l298n_has_the_truth_table_of_its_data_sheet() {
        let table = |in1, in2, enable| {
            drive(BridgeKind::L298N, &[(Role::In1, in1), (Role::In2, in2), (Role::Enable, enable)])
        };
        let driven = |duty, decay| MotorDrive::Drive { duty, decay };
        assert_eq!(table(H, L, H), driven(1.0, Decay::Brake));
        assert_eq!(table(L, H, H), driven(-1.0, Decay::Brake));
        assert_eq!([table(H, H, H), table(L, L, H)], [MotorDrive::Brake; 2]);
        assert_eq!([table(H, L, L), table(L, L, L)], [MotorDrive::Coast; 2]);
        assert_eq!(table(H, L, QUARTER), driven(0.25, Decay::Coast));
        assert_eq!(table(QUARTER, L, H), driven(0.25, Decay::Brake));
        assert_eq!(table(H, QUARTER, H), driven(0.75, Decay::Brake));
    }

    #[test]
    fn a_tb6612_has_the_truth_table_of_its_data_sheet() {
        let table = |in1, in2, pwm, standby| {
            drive(
                BridgeKind::TB6612,
                &[(Role::In1, in1), (Role::In2, in2), (Role::Pwm, pwm), (Role::Standby, standby)],
            )
        };
        let driven = |duty, decay| MotorDrive::Drive { duty, decay };
        assert_eq!(
            [table(H, H, H, H), table(H, H, L, H), table(L, H, L, H), table(H, L, L, H)],
            [MotorDrive::Brake; 4]
        );
        assert_eq!(table(L, H, H, H), driven(-1.0, Decay::Brake));
        assert_eq!(table(H, L, H, H), driven(1.0, Decay::Brake));
        assert_eq!([table(L, L, H, H), table(H, L, H, L), table(H, H, L, L)], [MotorDrive::Coast; 3]);
        assert_eq!(table(L, H, QUARTER, H), driven(-0.25, Decay::Brake));
    }

    #[test]
    fn a_directed_driver_has_a_sign_and_its_own_decay() {
        for decay in [Decay::Brake, Decay::Coast] {
            let kind = BridgeKind::Directed { decay, drop_v: 0.0 };
            let table = |pwm, direction| drive(kind, &[(Role::Pwm, pwm), (Role::Direction, direction)]);
            assert_eq!(table(QUARTER, H), MotorDrive::Drive { duty: 0.25, decay });
            assert_eq!(table(QUARTER, L), MotorDrive::Drive { duty: -0.25, decay });
            let idle = if decay == Decay::Brake { MotorDrive::Brake } else { MotorDrive::Coast };
            assert_eq!(table(L, H), idle);
        }
    }
}
