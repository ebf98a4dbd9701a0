//! Wandering without running into what the infra-red sensors see.
//!
//! The brain decides each time that new readings have come:
//!
//! - **Drive** straight on, more slowly the nearer something is in front.
//! - **Escape**: if something is too near, turn on the spot away from the nearer side, and keep turning that
//!   way until all is clear. A disc that turns on the spot touches nothing new. Turning back because the
//!   other side has become the nearer one is what makes a robot dither in a corner for ever, so it is not
//!   done.
//! - **Stroll**: where all is clear, turn on the spot for a while now and then, at random, so that every
//!   part of the room is visited.
//!
//! Whenever a sensor has had no new reading for too long (the cable is cut, or the run has just begun) the brain sends
//! signals of 0.
//!
//! A robot runs into whatever no sensor sees: ARSim's own pair, at 45° to the left and right, looks past a box that
//! stands straight ahead.
//!
//! It answers each message, with what it has decided or, if no sensor that counts is in it, with what it said before. When
//! it may send is said in `pace`.

use baudbot_brain::{Action, Body, Brain, SensorKind, Turn};

use crate::chance::Chance;
use crate::pace::Pace;

mod parameters;
#[cfg(test)]
mod tests;

pub(crate) use parameters::PARAMETERS;
pub use parameters::Parameters;

/// A brain that wanders and avoids.
#[derive(Clone, Debug, PartialEq)]
pub struct Avoid {
    parameters: Parameters,
    chance: Chance,
    pub(crate) eyes: Vec<Eye>,
    state: State,
    /// New readings have come since the last decision.
    news: bool,
    decided_ns: u64,
    /// The brain has sent that it stands still, because a sensor gives no reading.
    stands: bool,
    pace: Pace,
}

/// A sensor that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    pub(crate) sensor: usize,
    /// The direction to the left of the robot's heading, in radians.
    pub(crate) bearing_rad: f64,
    /// The instant at which the sensor's last new reading came.
    seen_ns: Option<u64>,
    reading: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Drive,
    Escape(Way),
    Stroll(Way),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Left,
    Right,
}

impl Avoid {
    /// A brain at its start for a robot with this body; `None` if it has no infra-red sensor that looks ahead.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        let eyes: Vec<_> = eyes(body).filter(|eye| eye.bearing_rad.abs() <= parameters.field_rad).collect();
        let brain = Self {
            parameters,
            chance,
            eyes,
            state: State::Drive,
            news: false,
            decided_ns: 0,
            stands: false,
            pace: Pace::new(body),
        };
        (!brain.eyes.is_empty()).then_some(brain)
    }

    /// Takes in what is new.
    fn look(&mut self, turn: &Turn) {
        for eye in &mut self.eyes {
            let Some(reading) = turn.readings.get(eye.sensor).and_then(Option::as_ref) else { continue };
            let Some(&value) = reading.values.first().filter(|_| reading.readable) else { continue };
            eye.reading = value;
            eye.seen_ns = Some(turn.at_ns);
            self.news = true;
        }
    }

    /// Whether any sensor has had no new reading for too long.
    fn is_blind(&self, at_ns: u64) -> bool {
        let stale_ns = (self.parameters.stale_s * 1e9) as u64;
        self.eyes.iter().any(|eye| eye.seen_ns.is_none_or(|seen_ns| at_ns.saturating_sub(seen_ns) > stale_ns))
    }

    /// The next state, `seconds` after the last decision.
    fn decide(&mut self, seconds: f64) -> State {
        let nearest = self.nearest(|_| true);
        let p = self.parameters;
        match self.state {
            State::Escape(way) if nearest >= p.clear_reading => State::Escape(way),
            State::Stroll(way) if nearest >= p.turn_reading => State::Escape(way),
            State::Drive | State::Stroll(_) | State::Escape(_) if nearest >= p.turn_reading => {
                State::Escape(self.way_out())
            }
            State::Stroll(way) if !self.chance.happens(p.stop_stroll_rate_hz * seconds) => State::Stroll(way),
            State::Drive if self.chance.happens(p.stroll_rate_hz * seconds) => State::Stroll(self.any_way()),
            State::Drive | State::Stroll(_) | State::Escape(_) => State::Drive,
        }
    }

    /// Away from the nearer side.
    fn way_out(&mut self) -> Way {
        let left = self.nearest(|eye| eye.bearing_rad > 0.0);
        let right = self.nearest(|eye| eye.bearing_rad < 0.0);
        if left > right {
            Way::Right
        } else if right > left {
            Way::Left
        } else {
            self.any_way()
        }
    }

    fn any_way(&mut self) -> Way {
        if self.chance.happens(0.5) { Way::Left } else { Way::Right }
    }

    /// The largest reading of some of the sensors.
    fn nearest(&self, which: impl Fn(&Eye) -> bool) -> f64 {
        self.eyes.iter().filter(|eye| which(eye)).map(|eye| eye.reading).fold(0.0, f64::max)
    }

    fn signals(&self) -> (f64, f64) {
        let p = self.parameters;
        match self.state {
            State::Escape(Way::Left) | State::Stroll(Way::Left) => (-p.turn, p.turn),
            State::Escape(Way::Right) | State::Stroll(Way::Right) => (p.turn, -p.turn),
            State::Drive => {
                let room = (p.turn_reading - p.slow_reading).max(1e-9);
                let way = (self.nearest(|_| true) - p.slow_reading) / room;
                let signal = p.forward + (p.creep - p.forward) * way.clamp(0.0, 1.0);
                (signal, signal)
            }
        }
    }
}

impl Brain for Avoid {
    fn step(&mut self, turn: &Turn) -> Action {
        self.look(turn);
        self.pace.hear(turn);
        let action = self.act(turn.at_ns);
        action.until_message_or(self.awake_ns(turn.at_ns))
    }
}

impl Avoid {
    /// The instant of the next step that is due without a new reading: a command may be sent, or the oldest reading
    /// becomes stale.
    fn awake_ns(&self, at_ns: u64) -> u64 {
        let is_blind = self.is_blind(at_ns);
        let next_ns = self.pace.next_ns(at_ns, is_blind && !self.stands);
        if is_blind {
            return next_ns;
        }
        let stale_ns = (self.parameters.stale_s * 1e9) as u64;
        let oldest_ns = self.eyes.iter().filter_map(|eye| eye.seen_ns).min().unwrap_or(at_ns);
        next_ns.min(oldest_ns.saturating_add(stale_ns).saturating_add(1))
    }

    fn act(&mut self, at_ns: u64) -> Action {
        let is_blind = self.is_blind(at_ns);
        // A robot that sees no more stops though no message has come.
        if !self.pace.sends(at_ns, is_blind && !self.stands) {
            return Action::wait();
        }
        self.pace.sent(at_ns);
        self.stands = is_blind;
        if is_blind {
            self.state = State::Drive;
            return Action::drive(0.0, 0.0);
        }
        if self.news {
            let seconds = at_ns.saturating_sub(self.decided_ns) as f64 * 1e-9;
            self.state = self.decide(seconds);
            self.decided_ns = at_ns;
            self.news = false;
        }
        let (left, right) = self.signals();
        Action::drive(left, right)
    }
}

/// All infra-red sensors, as nothing has been seen yet.
fn eyes(body: &Body) -> impl Iterator<Item = Eye> {
    let infrared = body.sensors.iter().enumerate().filter(|(_, sensor)| sensor.kind == SensorKind::Infrared);
    infrared.map(|(sensor, described)| {
        let heading_rad = described.mount.map_or(0.0, |mount| mount.heading_rad);
        Eye { sensor, bearing_rad: wrap(heading_rad), seen_ns: None, reading: 0.0 }
    })
}

/// The same angle in [-π, π).
fn wrap(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}
