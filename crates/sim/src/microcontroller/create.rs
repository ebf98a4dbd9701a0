//! The answers and commands of an iRobot Create's microcontroller: its Open Interface, bound to the robot.
//!
//! A packet has the code of the sensor of its name (`crates/wire/src/create/signals.rs`), as the microcontroller last read it. Of the
//! left and the right wheel's way s_L and s_R since the start, by the encoders' counts, the packets 19 and 20 tell
//! (s_L + s_R) / 2 in whole mm and (s_R − s_L) / 2R in whole degrees, where R is half the track, less what they told before.
//!
//! Deviations. What the robot here has no sensor for has the value that it has at rest ([`RESTING_C`] and others). A cliff is a
//! place where the floor reflects less than [`CLIFF_BELOW`] of 4095: the floor here has no edge, so a dark one stands for it. The
//! robot looks for cliffs in the mode Safe with every substep of the world, and takes the signals in force for its motion. A
//! charger of any kind is a home base. Signal 1 is 500 mm/s, whatever the motors of the scenario make of it.

use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use baudbot_geometry::math;
use baudbot_wire::create::{self, Command, FULL_MM_S, Mode, Packet, Signal, Version};

use super::condition::Condition;
use super::{Microcontroller, Taken};
use crate::drive::Wheels;
use crate::firmware;
use crate::link::Line;
use crate::model::RobotSpec;
use crate::open_interface::Deed;
use crate::sensor::Device;
use crate::time::{SECOND_NS, SimTime};

impl Microcontroller {
    /// Obeys a command of the interface, if the mode lets it.
    pub(super) fn command(&mut self, spec: &RobotSpec, bytes: &[u8]) -> Taken {
        let until = self.free_at + spec.processor.obeying_ns;
        let Some(interface) = self.decoder.open_interface_mut() else { return Taken::Nonsense };
        let Some(command) = Command::parse(interface.version, bytes) else { return Taken::Nonsense };
        let taken = match interface.obey(command, until) {
            Deed::Refused => return Taken::Nonsense,
            Deed::Turns([velocity_mm_s, radius_mm]) => {
                let track_mm = 2e3 * spec.drive.half_track_m;
                let speeds = create::wheels_mm_s(velocity_mm_s, radius_mm, track_mm);
                self.roll(spec, speeds.map(|speed| speed / FULL_MM_S))
            }
            Deed::Rolls(shares) => self.roll(spec, shares),
            Deed::Stands => self.roll(spec, [0.0; 2]),
            Deed::Boots => {
                let stands = self.roll(spec, [0.0; 2]);
                self.free_at = self.free_at + BOOT_NS;
                let deaf_until = self.free_at;
                if let Some(interface) = self.decoder.open_interface_mut() {
                    interface.deaf_until = deaf_until;
                }
                stands
            }
            Deed::Streams => {
                interface.due = first_due(spec, until);
                self.free_at = until;
                Taken::Poll
            }
            Deed::Nothing => {
                self.free_at = until;
                Taken::Poll
            }
        };
        self.speak_next();
        taken
    }

    /// The baud rate that a command has asked for since this was last called.
    pub(crate) fn take_baud(&mut self) -> Option<u32> {
        self.decoder.open_interface_mut()?.take_baud()
    }

    /// The left and the right wheel turn with these shares of full signal.
    pub(super) fn roll(&mut self, spec: &RobotSpec, shares: [f64; 2]) -> Taken {
        let limit = spec.signal_limit.unwrap_or(1.0).min(1.0);
        let [left, right] = shares.map(|share| share.clamp(-limit, limit));
        self.drive(spec, Wheels { left, right }, Vec::new())
    }

    /// Finds the next instant at which the interface sends: at once if it owes something, else when the stream is due.
    pub(super) fn speak_next(&mut self) {
        if let Some(interface) = self.decoder.open_interface() {
            self.frame.next = match (interface.owes(), interface.streams()) {
                (true, _) => self.free_at,
                (false, true) => interface.due,
                (false, false) => SimTime::NEVER,
            };
        }
    }

    /// Writes the owed packets first, or else a message of the stream. Returns how many bytes they are, and whether
    /// they are of the stream.
    pub(super) fn write_packets(
        &mut self,
        spec: &RobotSpec,
        now: SimTime,
        robot: &Condition<'_>,
        out: &mut [u8],
    ) -> (usize, bool) {
        let Some(interface) = self.decoder.open_interface_mut() else { return (0, false) };
        if core::mem::take(&mut interface.boots) {
            out[..BOOT_TEXT.len()].copy_from_slice(BOOT_TEXT);
            return (BOOT_TEXT.len(), false);
        }
        let version = interface.version;
        if interface.owes() {
            let ids = interface.settle(out.len());
            let packets = ids.iter().filter_map(|&id| create::group(version, id)).flatten();
            let len = packets.fold(0, |len, &packet| {
                len + packet.put(self.packet(spec, now, robot, packet), &mut out[len..])
            });
            self.note_way(spec, &ids);
            return (len, false);
        }
        let ids = interface.streamed().to_vec();
        self.serve_stream(spec, now);
        let len = create::write_stream(version, &ids, |packet| self.packet(spec, now, robot, packet), out);
        self.note_way(spec, &ids);
        (len, true)
    }

    /// Notes that the stream is sent now, and finds the next instant.
    fn serve_stream(&mut self, spec: &RobotSpec, now: SimTime) {
        let Some(interface) = self.decoder.open_interface_mut() else { return };
        if let firmware::Mode::Stream(schedule) = spec.firmware.mode {
            let mut due = crate::schedule::Due { next: interface.due, missed: 0 };
            self.frame.missed += due.serve(&schedule, now);
            interface.due = due.next;
        }
    }

    /// Notes that way and turn were among the packets.
    fn note_way(&mut self, spec: &RobotSpec, ids: &[u8]) {
        let way = self.way(spec);
        let Some(interface) = self.decoder.open_interface_mut() else { return };
        let told = |packet| {
            let groups = ids.iter().filter_map(|&id| create::group(interface.version, id));
            groups.flatten().any(|other| *other == packet)
        };
        let [distance, angle] = [told(Packet::Distance), told(Packet::Angle)];
        if distance {
            interface.told[0] = way[0];
        }
        if angle {
            interface.told[1] = way[1];
        }
    }

    /// Way and turn since the start, in whole mm and degrees, by what the encoders have counted.
    fn way(&self, spec: &RobotSpec) -> [i64; 2] {
        let per_turn = spec.sensors.iter().find_map(|sensor| {
            let Device::Encoders(encoders) = &sensor.device else { return None };
            Some(f64::from(encoders.counts_per_turn))
        });
        let Some(per_turn) = per_turn else { return [0; 2] };
        let [left, right] =
            self.counts(spec).map(|count| count as f64 / per_turn * TAU * spec.drive.wheel_radius_m);
        let turn = (right - left) / (2.0 * spec.drive.half_track_m);
        [(left + right) / 2.0 * 1e3, turn * 180.0 / PI].map(|way| way as i64)
    }

    /// A person takes the robot up, and puts it down elsewhere.
    pub(crate) fn lift(&mut self) {
        if let Some(interface) = self.decoder.open_interface_mut() {
            interface.was_lifted = true;
        }
    }

    /// In the mode Safe the robot stands, and is Passive, when it drives towards a cliff, is charged, or was lifted.
    pub(super) fn guard(
        &mut self,
        spec: &RobotSpec,
        robot: &Condition<'_>,
        now: SimTime,
    ) -> Option<(SimTime, Wheels)> {
        let interface = self.decoder.open_interface_mut()?;
        let was_lifted = core::mem::take(&mut interface.was_lifted);
        if interface.mode != Mode::Safe {
            return None;
        }
        let cliff = CLIFFS.iter().any(|signal| self.is_cliff(spec, *signal));
        if !(was_lifted || robot.charges() || (cliff && approaches(spec, robot.signals))) {
            return None;
        }
        self.decoder.open_interface_mut()?.stand_in(Mode::Passive);
        self.orders.clear();
        Some((now, Wheels::default()))
    }

    fn is_cliff(&self, spec: &RobotSpec, signal: Packet) -> bool {
        self.code_of(spec, signal, None).is_some_and(|code| code < CLIFF_BELOW)
    }

    /// The code that the sensor of this packet last had; `None` of a robot without that sensor, and before its first sample.
    fn code_of(&self, spec: &RobotSpec, packet: Packet, bit: Option<u8>) -> Option<i32> {
        let terms = spec.firmware.agreement().terms;
        let mut places = terms.places.iter();
        for (channel, components) in self.channels.iter().zip(terms.layout.sensors()) {
            for (i, (encoding, place)) in components.iter().zip(places.by_ref()).enumerate() {
                let signal = place.and_then(Signal::at);
                if signal.is_some_and(|signal| signal.packet == packet && signal.bit == bit) {
                    return encoding.number(*channel.values.get(i)?).map(|code| code as i32);
                }
            }
        }
        None
    }

    /// The value of a packet.
    fn packet(&self, spec: &RobotSpec, now: SimTime, robot: &Condition<'_>, packet: Packet) -> i32 {
        let Some(interface) = self.decoder.open_interface() else { return 0 };
        let code = |packet| self.code_of(spec, packet, None).unwrap_or(0);
        match packet {
            Packet::BumpsWheelDrops => self.bumps(spec),
            Packet::Wall => i32::from(code(Packet::WallSignal) >= SEEN_FROM),
            Packet::CliffLeft => self.is_cliff(spec, Packet::CliffLeftSignal).into(),
            Packet::CliffFrontLeft => self.is_cliff(spec, Packet::CliffFrontLeftSignal).into(),
            Packet::CliffFrontRight => self.is_cliff(spec, Packet::CliffFrontRightSignal).into(),
            Packet::CliffRight => self.is_cliff(spec, Packet::CliffRightSignal).into(),
            Packet::Distance => untold(self.way(spec)[0], interface.told[0]),
            Packet::Angle => untold(self.way(spec)[1], interface.told[1]),
            Packet::Voltage | Packet::Charge | Packet::WallSignal => code(packet),
            Packet::CliffLeftSignal | Packet::CliffFrontLeftSignal => code(packet),
            Packet::CliffFrontRightSignal | Packet::CliffRightSignal => code(packet),
            Packet::LightLeftSignal | Packet::LightFrontLeftSignal => code(packet),
            Packet::LightCenterLeftSignal | Packet::LightCenterRightSignal => code(packet),
            Packet::LightFrontRightSignal | Packet::LightRightSignal => code(packet),
            Packet::EncoderLeft => self.counts(spec)[0] as i32,
            Packet::EncoderRight => self.counts(spec)[1] as i32,
            Packet::LightBumper => self.lights(spec),
            Packet::ChargingState | Packet::Current => fed(spec, robot, packet),
            Packet::Capacity | Packet::ChargingSources => fed(spec, robot, packet),
            Packet::Temperature => RESTING_C,
            Packet::InfraredOmni => no_character(interface.version),
            Packet::OiMode => interface.mode.number().into(),
            Packet::SongNumber => interface.song.into(),
            Packet::SongPlaying => interface.plays(now).into(),
            Packet::StreamPackets => interface.streamed().len() as i32,
            Packet::RequestedVelocity => interface.requested[0].into(),
            Packet::RequestedRadius => interface.requested[1].into(),
            Packet::RequestedRight => interface.requested_wheels[0].into(),
            Packet::RequestedLeft => interface.requested_wheels[1].into(),
            Packet::VirtualWall | Packet::Overcurrents | Packet::Dirt | Packet::Unused16 => 0,
            Packet::Buttons | Packet::CargoBayInputs | Packet::CargoBayVoltage => 0,
            Packet::InfraredLeft | Packet::InfraredRight | Packet::Stasis => 0,
            Packet::LeftMotorCurrent | Packet::RightMotorCurrent => 0,
            Packet::MainBrushCurrent | Packet::SideBrushCurrent => 0,
        }
    }

    /// The bits of the bumpers that are pressed.
    fn bumps(&self, spec: &RobotSpec) -> i32 {
        let bump = |bit| self.code_of(spec, Packet::BumpsWheelDrops, Some(bit)).unwrap_or(0) << bit;
        bump(0) | bump(1)
    }

    /// The bits of the light bumpers that see something.
    fn lights(&self, spec: &RobotSpec) -> i32 {
        let code = |signal| self.code_of(spec, signal, None).unwrap_or(0);
        LIGHTS.iter().enumerate().map(|(bit, signal)| i32::from(code(*signal) >= SEEN_FROM) << bit).sum()
    }
}

/// The part of a way or a turn that has not been sent.
fn untold(way: i64, told: i64) -> i32 {
    way.saturating_sub(told).clamp(-32_768, 32_767) as i32
}

/// The value of a receiver of infra-red characters that sees none.
fn no_character(version: Version) -> i32 {
    match version {
        Version::One => NO_CHARACTER,
        Version::Two => 0,
    }
}

/// The values of the battery in a packet that no sensor has.
fn fed(spec: &RobotSpec, robot: &Condition<'_>, packet: Packet) -> i32 {
    let Some((battery, state)) = spec.battery.as_ref().zip(robot.battery) else { return 0 };
    let whole = |number: f64, [least, most]: [f64; 2]| math::round(number).clamp(least, most) as i32;
    if packet == Packet::Current {
        whole(-state.current_a * 1e3, [-32_768.0, 32_767.0])
    } else if packet == Packet::Capacity {
        whole(battery.capacity_c() / 3.6, [0.0, 65_535.0])
    } else {
        // Full charging, and the home base.
        2 * i32::from(robot.charges())
    }
}

/// Whether a robot with these signals may drive over a cliff: forwards, or backwards on a radius smaller than its own.
fn approaches(spec: &RobotSpec, signals: Wheels) -> bool {
    let (speed, turn) = ((signals.left + signals.right) / 2.0, (signals.right - signals.left).abs());
    speed > 0.0 || speed.abs() < turn / (2.0 * spec.drive.half_track_m) * spec.drive.radius_m
}

/// Bytes that came while a Create booted are lost, until this instant; returns whether the receiver is empty then.
pub(super) fn missed_boot(spec: &RobotSpec, (now, until): (SimTime, SimTime), downlink: &mut Line) -> bool {
    if until == SimTime::ZERO {
        return false;
    }
    downlink.lose_before(&spec.link, until);
    downlink.arrival(&spec.link) > now
}

/// The first instant of the firmware's schedule that is not before `now`.
fn first_due(spec: &RobotSpec, now: SimTime) -> SimTime {
    let firmware::Mode::Stream(schedule) = spec.firmware.mode else { return now };
    let since_ns = now.as_ns().saturating_sub(schedule.phase_ns());
    SimTime::from_ns(schedule.phase_ns()) + since_ns.div_ceil(schedule.period_ns()) * schedule.period_ns()
}

/// The cliff sensors.
const CLIFFS: [Packet; 4] = [
    Packet::CliffLeftSignal,
    Packet::CliffFrontLeftSignal,
    Packet::CliffFrontRightSignal,
    Packet::CliffRightSignal,
];

/// The light bumpers, from the least bit of packet 45.
const LIGHTS: [Packet; 6] = [
    Packet::LightLeftSignal,
    Packet::LightFrontLeftSignal,
    Packet::LightCenterLeftSignal,
    Packet::LightCenterRightSignal,
    Packet::LightFrontRightSignal,
    Packet::LightRightSignal,
];

/// A cliff sensor's signal below which there is a cliff, of 4095: a tenth. A guess; the real one is not published.
const CLIFF_BELOW: i32 = 410;

/// A signal of the wall sensor or a light bumper from which on something is seen, of 4095. A guess.
const SEEN_FROM: i32 = 100;

/// The temperature of the battery, in °C; a guess.
const RESTING_C: i32 = 25;

/// The value of a first Create's receiver while it sees no character (recalled: 255).
const NO_CHARACTER: i32 = 255;

/// The time from a reset to the first byte of its text, while it receives nothing. A guess: pycreate2 reads after one
/// second.
const BOOT_NS: u64 = SECOND_NS;

/// The text of a Create 2 when it boots (pycreate2 0.8.0, what `reset` returned).
const BOOT_TEXT: &[u8] =
    b"bl-start\r\nSTR730\r\nbootloader id: #x47186549 82ECCFFF\r\nbootloader info rev: #xF000\r\n\
                           bootloader rev: #x0001\r\n2007-05-14-1715-L   \r";
