//! The answers and commands of a Khepera's microcontroller: its registers, bound to the robot.
//!
//! Pulses are counts of the robot's encoders, as the microcontroller last read them. A movement to a target (`C`) goes
//! at v(e) = K e within e₀ = a / K² pulses of it, farther away at √(2 a (e − e₀ / 2)), and never beyond the speed and
//! the acceleration a of the profile (`J`): along a trapezoid whose end is rounded. It is over when both wheels stand
//! at their targets; then they get the command to stand, as in K-Team's kMatlab.
//!
//! Deviations. The real controller is not published, so K is ours. Motors obey commanded speeds as the scenario states,
//! so PID gains have no effect, and motors that hold no speed (all but `velocity`) go to no target. A pulse width is a
//! share of full signal: of a DC motor the voltage, of a `velocity` motor its speed. The control takes the processor no
//! time, and runs with every substep of the world.

use alloc::vec::Vec;
use core::f64::consts::TAU;

use baudbot_geometry::math;
use baudbot_wire::Layout;
use baudbot_wire::khepera::{self, Access, Command, LineError, Question, Register, Side};

use super::request::Request;
use super::{Condition, FITS, Microcontroller, Taken, Tells};
use crate::drive::{Motion, Wheels};
use crate::firmware::{Owed, Refusal, Registers, Say};
use crate::model::RobotSpec;
use crate::motor::Motors;
use crate::sensor::{Device, InfraredModel, Sensor};
use crate::time::SimTime;

impl Microcontroller {
    /// The line that it owes first; that a command was obeyed, positions and readings go together. Returns how many
    /// bytes they are, and which readings are in them.
    pub(super) fn write_lines(
        &mut self,
        spec: &RobotSpec,
        robot: &Condition<'_>,
        out: &mut [u8],
    ) -> (usize, Tells) {
        match self.decoder.settle() {
            Some(Say::Exchange(owed)) => self.write_exchange(spec, owed, out),
            Some(Say::Answer(command)) => {
                let read = |register| self.register(spec, robot, register);
                (khepera::write_answer(command, read, out).expect(FITS), Tells::Nothing)
            }
            Some(Say::Refusal(refusal)) => {
                let said = match refusal {
                    Refusal::NotFound => khepera::NOT_FOUND,
                    Refusal::Protocol => khepera::PROTOCOL_ERROR,
                };
                (put(said, out), Tells::Nothing)
            }
            None => (0, Tells::Nothing),
        }
    }

    fn write_exchange(&self, spec: &RobotSpec, owed: Owed, out: &mut [u8]) -> (usize, Tells) {
        let mut len = if owed.acknowledgement { put(&khepera::ACKNOWLEDGEMENT, out) } else { 0 };
        if owed.positions {
            let [left, right] = self.positions(spec);
            let tell = |register| Some(if register == Register::Position(Side::Left) { left } else { right });
            len += khepera::write_answer(Command::Position, tell, &mut out[len..]).expect(FITS);
        }
        if owed.readings {
            let layout = spec.firmware.layout();
            let values = self.last_values(&layout);
            len += khepera::write_readings(&layout, values, &mut out[len..]).expect(FITS);
        }
        (len, Tells::of(owed.positions, owed.readings))
    }

    /// A line was not understood, which firmwares with registers say.
    pub(super) fn refuse(&mut self, spec: &RobotSpec, refusal: Refusal) {
        if let Some(registers) = self.decoder.use_registers() {
            registers.refuse(refusal);
            self.answer_soon(spec);
        }
    }

    /// Sets what a line sets, and owes the answer.
    pub(super) fn access(&mut self, spec: &RobotSpec, access: &Access) -> Taken {
        if access.command == Command::Position {
            self.decoder.owe(Owed::POSITIONS);
            return Taken::Poll;
        }
        let counts = self.counts(spec);
        let Some(registers) = self.decoder.use_registers() else { return Taken::Nonsense };
        for (register, value) in access.settings() {
            registers.set(register, value, counts);
        }
        registers.owe(access.command);
        if access.command == Command::PulseWidth {
            let limit = spec.signal_limit.unwrap_or(1.0);
            let [left, right] = registers.pulse_width.map(|width| limit * f64::from(width) / 255.0);
            return self.drive(spec, Wheels { left, right }, Vec::new());
        }
        let (sets, tells) = access.command.registers();
        if !sets.is_empty() && tells.is_empty() {
            self.free_at = self.free_at + spec.processor.obeying_ns;
        }
        if access.command == Command::Move {
            registers.moving_since = Some(self.free_at);
            self.commands += 1;
            return Taken::Command(self.free_at);
        }
        Taken::Poll
    }

    /// The wheels move to no target any more.
    pub(crate) fn stand(&mut self) {
        if let Some(registers) = self.decoder.registers_mut() {
            registers.moving_since = None;
        }
    }

    /// The signals that take the wheels on to their targets, if they are to go there, and since when. A Create has no targets,
    /// but may have to [stand](Self::guard).
    pub(crate) fn steer(
        &mut self,
        spec: &RobotSpec,
        robot: &Condition<'_>,
        now: SimTime,
        dt: f64,
    ) -> Option<(SimTime, Wheels)> {
        if self.decoder.open_interface().is_some() {
            return self.guard(spec, robot, now);
        }
        let &Condition { motion, signals, .. } = robot;
        let registers = self.decoder.registers()?;
        let since = registers.moving_since.filter(|since| *since <= now)?;
        let (pulses, full) = (Pulses::of(spec)?, Pulses::of(spec)?.full_per_s(spec)?);
        let (missing, speeds) = (registers.missing(self.counts(spec)), pulses.per_s(motion));
        if missing == [0; 2] && speeds.iter().all(|speed| speed.abs() < STANDS_PER_S) {
            self.stand();
            return Some((since, Wheels::default()));
        }
        let limit = spec.signal_limit.unwrap_or(1.0);
        let signal = |side: usize, signal: f64| {
            let profile = Profile::of(registers, side);
            let was = full * signal;
            let (most, allowed) = (profile.acceleration * dt, profile.speed(missing[side].into()));
            let brakes = allowed * was >= 0.0 && allowed.abs() <= was.abs();
            let speed = if brakes { allowed } else { was + (allowed - was).clamp(-most, most) };
            (speed / full).clamp(-limit, limit)
        };
        Some((since, Wheels { left: signal(0, signals.left), right: signal(1, signals.right) }))
    }

    /// The counts of both encoders when they were last read; 0 of a robot without.
    pub(super) fn counts(&self, spec: &RobotSpec) -> [i64; 2] {
        let values = Pulses::of(spec).map_or(&[][..], |pulses| &self.channels[pulses.sensor].values[..]);
        [0, 1].map(|side| values.get(side).copied().unwrap_or(0.0) as i64)
    }

    /// The position counters.
    fn positions(&self, spec: &RobotSpec) -> [i32; 2] {
        let counts = self.counts(spec);
        self.decoder
            .registers()
            .map_or_else(|| counts.map(|count| count as i32), |registers| registers.positions(counts))
    }

    /// The value of a register, if the robot has it.
    fn register(
        &self,
        spec: &RobotSpec,
        &Condition { motion, signals, .. }: &Condition<'_>,
        register: Register,
    ) -> Option<i32> {
        let registers = self.decoder.registers()?;
        let speed = |side: Side| Some(per_10ms(Pulses::of(spec)?.per_s(motion)[side as usize]));
        let error = |side: Side| {
            if registers.moving_since.is_some() {
                return Some(registers.missing(self.counts(spec))[side as usize]);
            }
            let signal = [signals.left, signals.right][side as usize];
            let full = Pulses::of(spec)?.full_per_s(spec);
            full.map_or(Some(0), |full| Some(per_10ms(full * signal).saturating_sub(speed(side)?)))
        };
        match register {
            Register::Speed(side) => speed(side),
            Register::Position(side) => Some(self.positions(spec)[side as usize]),
            Register::Reached(side) => error(side).map(|error| i32::from(error == 0)),
            Register::Mode(_) => Some(i32::from(registers.moving_since.is_none())),
            Register::Error(side) => error(side),
            Register::Input => self.code(spec, input(spec, registers.input)?),
            Register::Ambient(i) => match ambient(spec).nth(i.into()) {
                Some(sensor) => self.code(spec, sensor),
                None if ambient(spec).next().is_none() => infrared(spec).nth(i.into()).map(|_| DARK),
                None => None,
            },
            Register::BusByte => Some(NOBODY),
            // Nothing tells these.
            Register::SpeedGain(_) | Register::PositionGain(_) | Register::Target(_) => None,
            Register::ProfileSpeed(_) | Register::ProfileAcceleration(_) | Register::PulseWidth(_) => None,
            Register::InputNumber | Register::LedNumber | Register::LedAction => None,
            Register::BusAddress | Register::Turret => None,
        }
    }

    /// The code of a sensor's last sample.
    fn code(&self, spec: &RobotSpec, sensor: usize) -> Option<i32> {
        let value = self.channels[sensor].values.first().copied().unwrap_or(0.0);
        spec.sensors[sensor].encodings.first()?.number(value).map(|code| code as i32)
    }
}

/// Writes bytes that are always the same, and returns how many they are.
fn put(said: &[u8], out: &mut [u8]) -> usize {
    out[..said.len()].copy_from_slice(said);
    said.len()
}

/// The request of a line, or the reason why it is not obeyed.
pub(super) fn request(spec: &RobotSpec, line: &[u8], layout: &Layout<'_>) -> Result<Request, Refusal> {
    match Question::parse(line, layout) {
        Ok(Question::Poll) => Ok(Request::Poll),
        // A speed beyond what the motors do is as fast as they do.
        Ok(Question::Command(signals)) => {
            let limit = spec.signal_limit.unwrap_or(f64::MAX);
            let mut signals = signals.map(|signal| signal.clamp(-limit, limit));
            Request::drive(spec, &mut signals).ok_or(Refusal::Protocol)
        }
        Ok(Question::Access(access)) if has_parts_for(spec, &access) => Ok(Request::Access(access)),
        Err(LineError::Letter { .. }) => Err(Refusal::NotFound),
        Ok(Question::Access(_)) | Err(_) => Err(Refusal::Protocol),
    }
}

/// Whether the robot has what a command is about.
fn has_parts_for(spec: &RobotSpec, access: &Access) -> bool {
    let pulses = Pulses::of(spec);
    match access.command {
        Command::Move => pulses.is_some_and(|pulses| pulses.full_per_s(spec).is_some()),
        Command::Speed | Command::SetPosition | Command::Position | Command::Status => pulses.is_some(),
        Command::Input => access.settings().all(|(_, number)| input(spec, number).is_some()),
        Command::Ambient => infrared(spec).next().is_some(),
        Command::Turret => false,
        Command::SpeedGains | Command::Version | Command::PositionGains | Command::Profile => true,
        Command::Led | Command::PulseWidth | Command::ReadBus | Command::WriteBus => true,
    }
}

/// The sensor at an analog input: the one of the name `ad_` and its number.
fn input(spec: &RobotSpec, number: i32) -> Option<usize> {
    let is_there = |sensor: &Sensor| {
        let digits = sensor.name.strip_prefix("ad_").filter(|_| sensor.is_on_wire());
        digits.and_then(|digits| digits.parse().ok()) == Some(number)
    };
    spec.sensors.iter().position(is_there)
}

/// The infra-red sensors, in order, and their models.
fn infrared(spec: &RobotSpec) -> impl Iterator<Item = (usize, &InfraredModel)> {
    spec.sensors.iter().enumerate().filter(|(_, sensor)| sensor.is_on_wire()).filter_map(|(i, sensor)| {
        let Device::Infrared(infrared) = &sensor.device else { return None };
        Some((i, &infrared.model))
    })
}

/// The sensors that measure the ambient light.
fn ambient(spec: &RobotSpec) -> impl Iterator<Item = usize> {
    let tells = |(i, model)| matches!(model, &InfraredModel::Ambient { .. }).then_some(i);
    infrared(spec).filter_map(tells)
}

/// Pulses of the robot's encoders.
#[derive(Clone, Copy)]
struct Pulses {
    /// The sensor with the counts.
    sensor: usize,
    per_turn: f64,
}

impl Pulses {
    fn of(spec: &RobotSpec) -> Option<Self> {
        spec.sensors.iter().enumerate().find_map(|(sensor, found)| {
            let Device::Encoders(encoders) = &found.device else { return None };
            Some(Self { sensor, per_turn: encoders.counts_per_turn.into() })
        })
    }

    /// The speed of the wheels, in pulses a second.
    fn per_s(self, motion: &Motion) -> [f64; 2] {
        let Wheels { left, right } = motion.wheel_speed_rad_s;
        [left, right].map(|speed| speed / TAU * self.per_turn)
    }

    /// The speed at signal 1, in pulses a second, of motors that regulate the speed.
    fn full_per_s(self, spec: &RobotSpec) -> Option<f64> {
        let Motors::Velocity(motor) = &spec.drive.motor else { return None };
        let turns_per_s = motor.full_speed_m_s / (TAU * spec.drive.wheel_radius_m);
        Some(turns_per_s * self.per_turn)
    }
}

/// In units of the protocol.
fn per_10ms(per_s: f64) -> i32 {
    math::round(per_s / 100.0) as i32
}

/// The profile by which a wheel goes to its target.
struct Profile {
    /// Largest speed, in pulses a second.
    speed: f64,
    /// In pulses / s².
    acceleration: f64,
}

impl Profile {
    fn of(registers: &Registers, side: usize) -> Self {
        Self {
            speed: 100.0 * f64::from(registers.profile_speed[side]),
            acceleration: 1e4 / 256.0 * f64::from(registers.profile_acceleration[side]),
        }
    }

    /// The speed at which a wheel may go that has so many pulses to its target, in pulses a second.
    fn speed(&self, missing: f64) -> f64 {
        let (e, rounded) = (missing.abs(), self.acceleration / (GAIN_PER_S * GAIN_PER_S));
        let allowed = if e < rounded {
            GAIN_PER_S * e
        } else {
            math::sqrt(2.0 * self.acceleration * (e - rounded / 2.0))
        };
        allowed.min(self.speed).copysign(missing)
    }
}

/// K: the speed close to a target, per pulse that is missing. Motors that follow 50 ms behind do not overshoot with it.
const GAIN_PER_S: f64 = 5.0;

/// Below so many pulses a second a wheel stands: it does not come a pulse farther.
const STANDS_PER_S: f64 = 10.0;

/// The value of an infra-red sensor in the dark, roughly (manual of the Khepera II, 3.1.7).
const DARK: i32 = 500;

/// The value of a bus that is not driven; a guess.
const NOBODY: i32 = 255;
