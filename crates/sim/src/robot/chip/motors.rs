//! The effect of a chip's pins on the robot's motors and other actuators.

use baudbot_board::{Decay, MotorDrive, Pulse};
use serde::{Deserialize, Serialize};

use super::ChipState;
use crate::actuator::ActuatorState;
use crate::chip::{Attached, ChipSpec, Side};
use crate::drive::{Drive, Wheels};
use crate::motor::{Motors, Servo};
use crate::sound;
use crate::time::{SECOND_NS, SimTime};

/// The effect of bridges on both motors, as the mean over a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Output {
    /// The motor signals: fractions of the voltage, or of the range of servos' pulses.
    pub(crate) signals: Wheels,
    /// The share of the time in which each motor is open and rolls on; else it is driven or shorted.
    pub(crate) open: Wheels,
}

impl Output {
    pub(super) fn is_sound(&self) -> bool {
        sound::wheels(&self.signals) && sound::wheels(&self.open)
    }

    fn add(&mut self, other: &Self, weight: f64) {
        self.signals.left += weight * other.signals.left;
        self.signals.right += weight * other.signals.right;
        self.open.left += weight * other.open.left;
        self.open.right += weight * other.open.right;
    }
}

impl ChipState {
    /// Counts what the bridges did in the last `span_ns` of a substep.
    pub(super) fn note_output(&mut self, spec: &ChipSpec, substep: u64, span_ns: u64, substep_ns: u64) {
        let place = substep as usize;
        if self.outputs.len() <= place {
            self.outputs.resize(place + 1, Output::default());
        }
        let output = self.bridges(spec);
        self.outputs[place].add(&output, span_ns as f64 / substep_ns as f64);
    }

    fn bridges(&self, spec: &ChipSpec) -> Output {
        let mut output = Output::default();
        for motor in self.board.drives() {
            let Attached::Motor(side) = spec.attached_to(motor.part) else { continue };
            let (signal, open) = match motor.drive {
                MotorDrive::Drive { duty, decay: Decay::Brake } => (duty, 0.0),
                MotorDrive::Drive { duty, decay: Decay::Coast } => (duty, 1.0 - duty.abs()),
                MotorDrive::Brake => (0.0, 0.0),
                MotorDrive::Coast => (0.0, 1.0),
            };
            *side.of(&mut output.signals) = signal;
            *side.of(&mut output.open) = open;
        }
        output
    }

    /// The motors' supply in the substep that begins at `now`.
    pub(super) fn take_up(&mut self, spec: &ChipSpec, drive: &Drive, now: SimTime, dt_s: f64) -> &Output {
        let substep = (now.since(self.tick) as f64 / (dt_s * SECOND_NS as f64) + 0.5) as usize;
        let mut output = self.outputs.get(substep).copied().unwrap_or_default();
        match &drive.motor {
            Motors::Dc(motor) => self.lose_voltage(spec, motor.voltage_v, &mut output.signals),
            Motors::Servo(servo) => self.obey_pulses(spec, servo, now, &mut output.signals),
            Motors::Velocity(_) | Motors::Stepper(_) => {}
        }
        self.given = output;
        &self.given
    }

    /// Subtracts the loss in the bridges' transistors from motors that have this voltage at signal 1.
    fn lose_voltage(&self, spec: &ChipSpec, voltage_v: f64, signals: &mut Wheels) {
        for motor in self.board.drives() {
            if let Attached::Motor(side) = spec.attached_to(motor.part) {
                *side.of(signals) *= (1.0 - motor.drop_v / voltage_v).max(0.0);
            }
        }
    }

    /// Servos have the signals that their last pulses mean.
    fn obey_pulses(&self, spec: &ChipSpec, servo: &Servo, now: SimTime, signals: &mut Wheels) {
        for found in self.board.servos() {
            let Attached::WheelServo(side) = spec.attached_to(found.part) else { continue };
            let is_recent = |pulse: &Pulse| now.since(self.world(pulse.at_ns).min(now)) <= SILENCE_NS;
            // Without pulses it stands, whatever its trim.
            let above_us = match (found.pulse.filter(is_recent), side) {
                (None, _) => servo.trim_us,
                (Some(pulse), Side::Left) => pulse.width_us() - servo.neutral_us,
                // The servo is mounted the other way round.
                (Some(pulse), Side::Right) => servo.neutral_us - pulse.width_us(),
            };
            *side.of(signals) = above_us / servo.half_range_us;
        }
    }

    /// The motors' present supply.
    pub(crate) fn given(&self) -> &Output {
        &self.given
    }

    /// The robot's other actuators follow the pins.
    pub(super) fn move_actuators(&self, spec: &ChipSpec, actuators: &mut [ActuatorState]) {
        let lights = self.board.lights().map(|light| (light.part, light.brightness));
        let tones = self.board.tones().map(|tone| (tone.part, f64::from(u8::from(tone.hz.is_some()))));
        let servos = self.board.servos().filter_map(|servo| {
            let degrees = servo.pulse?.degrees();
            Some((servo.part, degrees / STANDARD_MIDDLE_DEG - 1.0))
        });
        for (part, signal) in lights.chain(tones).chain(servos) {
            if let Attached::Actuator(place) = spec.attached_to(part)
                && let Some(state) = actuators.get_mut(place)
            {
                state.signal = signal;
            }
        }
    }
}

/// A servo that has had no pulse for so long stands.
const SILENCE_NS: u64 = 100_000_000;

/// Half of the range of a standard servo, in degrees.
const STANDARD_MIDDLE_DEG: f64 = 90.0;
