//! The caution of the brain.

use crate::parameter::{PROBABILITY, Parameter, SIGNAL};

/// The caution of the brain. The defaults are for ARSim's robot: a disc of 0.2 m that does 0.39 m/s at signal 0.5
/// with a time constant of 0.09 s, and spins at about 2 rad/s with the signals ±0.5.
///
/// A sensor's reading is a nearness. With ARSim's parameters a sensor whose rays all meet a wall squarely
/// reads about 0.13 at 1 m, 0.22 at 0.5 m, 0.27 at 0.42 m, 0.43 at 0.3 m and 1 below 0.18 m; with some of its rays
/// past the wall, it reads less. The distance is that from the sensor, which sits on the rim: it is the room
/// that the robot has.
///
/// Room that the body needs: its readings are up to 50 ms old, a command takes 8 ms on a cable of 9600 baud and may
/// wait 10 ms for a step before that. So 0.07 s go by, which is 0.03 m at full speed, and the robot rolls on for 0.39
/// m/s × 0.09 s = 0.04 m: 0.07 m in all. A wall squarely ahead is noticed six times as far away. The rest is for what
/// only one of five rays meets, a corner of a box: that reads a fifth, and is noticed only where that ray is near its
/// limit of 1. In eight runs of an hour on the scenario `wander` the least room was 0.15 m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Signal of both motors when nothing is near.
    pub forward: f64,
    /// Signal of both motors when something is nearly too near.
    pub creep: f64,
    /// Size of the motors' signals when turning.
    pub turn: f64,
    /// Reading from which it drives more slowly: as soon as a wall squarely ahead is in range.
    pub slow_reading: f64,
    /// Reading from which it escapes: a wall squarely ahead is 0.41 m away.
    pub turn_reading: f64,
    /// Reading below which an escape is over: a wall squarely ahead is 0.55 m away. The robot turns on by 0.5 rad
    /// after that (2 rad/s for 0.07 s, and a time constant of 0.18 s), which in a corner may bring the other wall
    /// into view; the room between this reading and the last is for that, and for noise of 2 %.
    pub clear_reading: f64,
    /// A sensor counts if it looks no further aside than this, in radians; 70° leaves out those that see only
    /// what the robot drives past.
    pub field_rad: f64,
    /// The rate at which random turns begin, per second of driving.
    pub stroll_rate_hz: f64,
    /// The rate at which such turns end, per second of turning.
    pub stop_stroll_rate_hz: f64,
    /// The time without a new reading of a sensor after which the robot stands still, in seconds. In that time it goes
    /// 0.2 m at most, and less than the 0.41 m at which it would have turned away.
    pub stale_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            forward: 0.5,
            creep: 0.15,
            turn: 0.5,
            slow_reading: 0.13,
            turn_reading: 0.28,
            clear_reading: 0.2,
            field_rad: 1.22,
            stroll_rate_hz: 0.2,
            stop_stroll_rate_hz: 1.5,
            stale_s: 0.5,
        }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "forward",
        meaning: "signal of both motors when nothing is near",
        range: SIGNAL,
        field: |p| &mut p.forward,
    },
    Parameter {
        name: "creep",
        meaning: "signal of both motors when something is nearly too near",
        range: SIGNAL,
        field: |p| &mut p.creep,
    },
    Parameter {
        name: "turn",
        meaning: "magnitude of the motors' signals when turning",
        range: SIGNAL,
        field: |p| &mut p.turn,
    },
    Parameter {
        name: "slow_reading",
        meaning: "reading from which it drives more slowly",
        range: PROBABILITY,
        field: |p| &mut p.slow_reading,
    },
    Parameter {
        name: "turn_reading",
        meaning: "reading from which it turns away",
        range: PROBABILITY,
        field: |p| &mut p.turn_reading,
    },
    Parameter {
        name: "clear_reading",
        meaning: "reading below which it drives on",
        range: PROBABILITY,
        field: |p| &mut p.clear_reading,
    },
    Parameter {
        name: "field_rad",
        meaning: "largest angle between the robot's heading and the direction of a sensor that is used, in radians",
        range: 0.0..=std::f64::consts::PI,
        field: |p| &mut p.field_rad,
    },
    Parameter {
        name: "stroll_rate_hz",
        meaning: "rate of random turns, per second of driving",
        range: 0.0..=100.0,
        field: |p| &mut p.stroll_rate_hz,
    },
    Parameter {
        name: "stop_stroll_rate_hz",
        meaning: "rate at which a random turn ends, per second of turning",
        range: 0.0..=100.0,
        field: |p| &mut p.stop_stroll_rate_hz,
    },
    Parameter {
        name: "stale_s",
        meaning: "time without a new reading after which it stands still, in seconds",
        range: 0.01..=60.0,
        field: |p| &mut p.stale_s,
    },
];
