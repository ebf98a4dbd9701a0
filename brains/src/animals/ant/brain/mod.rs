//! A robot that goes out and finds home as a desert ant does.
//!
//! A compass, or else its odometer, is the sky; the odometer counts its steps; things that stand by themselves in the scan of
//! its laser are the landmarks. It takes its snapshot once all of these have spoken. What it finds as food is a time: it
//! turns home after so many seconds. If its compass goes by the sun, an ephemeris function corrects the heading by its clock:
//!
//! ```text
//! φ = φ_m + ω t        ω: rate of the sun's azimuth, Section 4.4.4
//! ```
//!
//! A sensor of a field smells the nest: where the smell is strong enough it is home, whatever it sees.
//!
//! Deviations: a scan comes late, and the robot may have turned since, so that the directions in it are those of the compass
//! at its instant. And a robot cannot walk over landmarks: where one is near ahead it turns aside. On its way home it then goes
//! straight on for a while, and turns to the same side if one is in the way again soon: otherwise one that stands just between
//! it and its nest would turn it aside and back again for ever.

use std::collections::VecDeque;

use baudbot_brain::{Action, Belief, BelievedPose, Body, Brain, Point, SensorKind, Turn};
use baudbot_geometry::{Direction, Vector, angle, math};

use super::landmarks::{self, Landmark};
use super::{Ant, Parameters as AntParameters, Phase, Sensed};
use crate::animals::wheel_commands::{Motion, WheelCommands, full_speed};
use crate::chance::Chance;
use crate::parameter::Parameter;

/// The robot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The parameters of the ant as a model, which the robot follows.
    pub ant: AntParameters,
    /// The ant turns home after this time, in seconds.
    pub forage_s: f64,
    /// The ant turns aside from what is nearer ahead than this, in metres from the laser.
    pub aside_m: f64,
    /// ω: the rate of the sun's azimuth that it expects, in rad/s counter-clockwise.
    pub sun_rad_s: f64,
    /// The reading of its field sensor from which on it is at the nest.
    pub smell_above: f64,
    /// Speed of the robot with the signal 1, in m/s.
    pub full_speed_m_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let ant = AntParameters { turn_rad_s: 1.0, match_below: 0.03, ..AntParameters::default() };
        Self { ant, forage_s: 60.0, aside_m: 0.6, sun_rad_s: 0.0, smell_above: 0.5, full_speed_m_s: 0.5 }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "speed_m_s",
        meaning: "speed, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.ant.speed_m_s,
    },
    Parameter {
        name: "turn_rad_s",
        meaning: "maximum turn rate, in rad/s",
        range: 0.01..=100.0,
        field: |p| &mut p.ant.turn_rad_s,
    },
    Parameter {
        name: "meander_hz",
        meaning: "changes of the turn rate on the way out, per second",
        range: 0.0..=100.0,
        field: |p| &mut p.ant.meander_hz,
    },
    Parameter {
        name: "near_m",
        meaning: "length of the home vector below which it searches, in metres",
        range: 0.01..=100.0,
        field: |p| &mut p.ant.near_m,
    },
    Parameter {
        name: "pitch_m",
        meaning: "distance between the loops of its search where it sees no landmark, in metres",
        range: 0.01..=100.0,
        field: |p| &mut p.ant.pitch_m,
    },
    Parameter {
        name: "match_below",
        meaning: "difference between view and snapshot below which it is at home, from 0 to 2",
        range: 0.0..=2.0,
        field: |p| &mut p.ant.match_below,
    },
    Parameter {
        name: "forage_s",
        meaning: "time after which it turns home, in seconds",
        range: 0.0..=1e6,
        field: |p| &mut p.forage_s,
    },
    Parameter {
        name: "aside_m",
        meaning: "distance from the laser to a landmark ahead below which it turns aside, in metres",
        range: 0.0..=100.0,
        field: |p| &mut p.aside_m,
    },
    Parameter {
        name: "sun_rad_s",
        meaning: "rate of the sun's azimuth by which it corrects its compass, in rad/s counter-clockwise",
        range: -6.3..=6.3,
        field: |p| &mut p.sun_rad_s,
    },
    Parameter {
        name: "smell_above",
        meaning: "reading of a field sensor above which it is at the nest",
        range: 0.0..=1e6,
        field: |p| &mut p.smell_above,
    },
    full_speed(|p| &mut p.full_speed_m_s),
];

/// A brain that finds home by a vector and a snapshot.
#[derive(Clone, Debug, PartialEq)]
pub struct AntBrain {
    parameters: Parameters,
    radius_m: f64,
    ant: Ant,
    wheels: WheelCommands,
    places: Places,
    /// x and y of the odometer's last reading, in metres, and its heading.
    odometer: Option<(Vector, f64)>,
    /// The same when it left: where its nest is.
    nest: Option<Vector>,
    /// The headings at past instants, by the compass, the newest last.
    headings: VecDeque<(u64, f64)>,
    /// Landmarks of the last scan, with bearings by the compass.
    landmarks: Option<Vec<Landmark>>,
    scanned_ns: u64,
    left_ns: Option<u64>,
    /// The side to which it turned aside last, 1 for left and -1 for right, and the instant.
    aside: Option<(f64, u64)>,
}

/// Places of sensors in the body's list.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Places {
    laser: usize,
    range_m: f64,
    /// The angle from the first ray to the last, in radians, and whether the first is the leftmost.
    opening_rad: f64,
    clockwise: bool,
    /// The laser's direction, in radians to the left of the robot.
    mount_rad: f64,
    odometer: usize,
    compass: Option<usize>,
    nose: Option<usize>,
}

impl AntBrain {
    /// A brain at its nest. `None` if the robot has no laser of which is known how it sweeps, or no odometer.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        let place = |kind: SensorKind| body.sensors.iter().position(|sensor| sensor.kind == kind);
        let laser = place(SensorKind::Laser)?;
        let places = Places {
            laser,
            range_m: body.sensors[laser].range_m.unwrap_or(f64::INFINITY),
            opening_rad: body.sensors[laser].opening_rad?,
            clockwise: body.sensors[laser].sweep?.clockwise,
            mount_rad: body.sensors[laser].mount.unwrap_or_default().heading_rad,
            odometer: place(SensorKind::Odometer)
                .filter(|&place| body.sensors[place].components.len() >= 3)?,
            compass: place(SensorKind::Compass),
            nose: place(SensorKind::Field),
        };
        Some(Self {
            parameters,
            radius_m: body.radius_m,
            ant: Ant::new(parameters.ant, chance),
            wheels: WheelCommands::new(body, parameters.full_speed_m_s),
            places,
            odometer: None,
            nest: None,
            headings: VecDeque::with_capacity(HEADINGS),
            landmarks: None,
            scanned_ns: 0,
            left_ns: None,
            aside: None,
        })
    }

    /// The ant's present activity.
    pub fn phase(&self) -> Phase {
        self.ant.phase()
    }

    /// Takes in what is new; how far it went since the last time.
    fn look(&mut self, turn: &Turn) -> f64 {
        let mut distance_m = 0.0;
        if let Some((at_ns, values)) = news(turn, self.places.odometer)
            && let [x, y, heading, ..] = *values
        {
            let now = Vector::new(x, y);
            if let Some((before, along)) = self.odometer {
                distance_m = Direction::from_angle(along).vector().dot(&(now - before));
            }
            self.odometer = Some((now, heading));
            if self.places.compass.is_none() {
                self.face(at_ns, heading);
            }
        }
        if let Some((at_ns, values)) = self.places.compass.and_then(|compass| news(turn, compass)) {
            self.face(at_ns, values[0] + self.parameters.sun_rad_s * (at_ns as f64 * 1e-9));
        }
        if let Some(heading_rad) = self.heading_at(turn.at_ns)
            && let Some((at_ns, scan)) = news(turn, self.places.laser)
        {
            let heading_rad = self.heading_at(at_ns).unwrap_or(heading_rad) + self.places.mount_rad;
            let Places { opening_rad, clockwise, range_m, .. } = self.places;
            let mut found = landmarks::find(scan, opening_rad, range_m, JUMP_M);
            for Landmark { bearing_rad, .. } in &mut found {
                // Seen from left to right, a bearing is one to the right.
                *bearing_rad = heading_rad + if clockwise { -*bearing_rad } else { *bearing_rad };
            }
            self.landmarks = Some(found);
            self.scanned_ns = turn.at_ns;
        }
        distance_m
    }

    /// Whether its last reading of the smell is that of the nest.
    fn smells_the_nest(&self, turn: &Turn) -> bool {
        let reading = self.places.nose.and_then(|nose| turn.readings.get(nose)?.as_ref());
        let smell = reading.and_then(|reading| reading.values.first());
        smell.is_some_and(|&smell| smell > self.parameters.smell_above)
    }

    fn face(&mut self, at_ns: u64, heading_rad: f64) {
        if self.headings.len() == HEADINGS {
            self.headings.pop_front();
        }
        self.headings.push_back((at_ns, heading_rad));
    }

    /// The last heading before an instant, or the first if that is forgotten.
    fn heading_at(&self, at_ns: u64) -> Option<f64> {
        let before = self.headings.iter().rev().find(|(then_ns, _)| *then_ns <= at_ns);
        before.or_else(|| self.headings.front()).map(|(_, heading_rad)| *heading_rad)
    }

    /// Goes on with the ant, once all its senses have spoken.
    fn walk(&mut self, turn: &Turn, distance_m: f64, dt_s: f64) -> Option<Motion> {
        let heading_rad = self.heading_at(turn.at_ns)?;
        let (odometer, _) = self.odometer?;
        let landmarks = self.landmarks.as_ref()?;
        let left_ns = *self.left_ns.get_or_insert(turn.at_ns);
        self.nest.get_or_insert(odometer);
        let is_old = turn.at_ns.saturating_sub(self.scanned_ns) > STALE_NS;
        let seen = if is_old { &[] } else { landmarks.as_slice() };
        let bearings: Vec<_> = seen.iter().map(|landmark| landmark.bearing_rad - heading_rad).collect();
        let food = turn.at_ns.saturating_sub(left_ns) as f64 * 1e-9 >= self.parameters.forage_s;
        let nest = self.smells_the_nest(turn);
        let sensed = Sensed { distance_m, heading_rad, landmarks_rad: &bearings, food, nest };
        let motion = self.ant.step(&sensed, dt_s);
        let near = seen
            .iter()
            .zip(&bearings)
            .map(|(landmark, bearing)| Landmark { bearing_rad: angle::wrap(*bearing), ..*landmark });
        let in_the_way = near.filter(|landmark| self.is_in_the_way(landmark));
        let nearest = in_the_way.reduce(|a, b| if b.distance_m < a.distance_m { b } else { a });
        Some(match (self.ant.phase(), nearest) {
            (Phase::Home, _) | (Phase::Forage, None) => motion,
            (_, Some(landmark)) => self.aside(motion, &landmark, turn.at_ns),
            (Phase::Return | Phase::Search, None) if self.turned_within(PASS_NS, turn.at_ns).is_some() => {
                Motion { speed_m_s: self.parameters.ant.speed_m_s, turn_rate_rad_s: 0.0 }
            }
            (Phase::Return | Phase::Search, None) => motion,
        })
    }

    /// The side to which it turned aside, if that is not longer ago than this.
    fn turned_within(&self, past_ns: u64, at_ns: u64) -> Option<f64> {
        let (side, then_ns) = self.aside?;
        (at_ns.saturating_sub(then_ns) <= past_ns).then_some(side)
    }

    /// Whether its body would meet this if it went straight on.
    fn is_in_the_way(&self, Landmark { bearing_rad, distance_m }: &Landmark) -> bool {
        let (sin, cos) = math::sin_cos(*bearing_rad);
        let aside_m = distance_m * sin.abs();
        cos > 0.0 && *distance_m < self.parameters.aside_m && aside_m < self.radius_m + CLEAR_M
    }

    /// Past something that is near, the more slowly the nearer it is.
    fn aside(&mut self, motion: Motion, landmark: &Landmark, at_ns: u64) -> Motion {
        let away = if landmark.bearing_rad > 0.0 { -1.0 } else { 1.0 };
        let side = match self.ant.phase() {
            Phase::Return | Phase::Search => self.turned_within(KEEP_NS, at_ns).unwrap_or(away),
            Phase::Forage | Phase::Home => away,
        };
        self.aside = Some((side, at_ns));
        let stop_m = self.radius_m + STOP_M;
        let room = (landmark.distance_m - stop_m) / (self.parameters.aside_m - stop_m).max(1e-3);
        let turn_rate_rad_s = side * self.parameters.ant.turn_rad_s;
        Motion { speed_m_s: room.clamp(0.0, 1.0) * motion.speed_m_s, turn_rate_rad_s }
    }
}

impl Brain for AntBrain {
    fn step(&mut self, turn: &Turn) -> Action {
        let dt_s = self.wheels.seconds_since_last(turn);
        let distance_m = self.look(turn);
        let motion = self.walk(turn, distance_m, dt_s).unwrap_or_default();
        self.wheels.walk(motion, turn)
    }

    fn belief(&mut self) -> Option<Belief> {
        let state = match self.ant.phase() {
            Phase::Forage => "forage",
            Phase::Return => "return",
            Phase::Search => "search",
            Phase::Home => "home",
        };
        let nest = self.nest?;
        let at = nest - self.ant.home();
        let heading_rad = self.headings.back()?.1;
        let pose = BelievedPose { x_m: at.x, y_m: at.y, heading_rad, covariance_m2: None };
        let path = [at, nest].map(|point| Point { x_m: point.x, y_m: point.y });
        Some(Belief { state: state.to_owned(), pose: Some(pose), path: path.to_vec(), ..Belief::default() })
    }
}

/// A new reading of the sensor in this place, all of it numbers, and when it was sampled.
fn news(turn: &Turn, place: usize) -> Option<(u64, &[f64])> {
    let reading = turn.readings.get(place)?.as_ref().filter(|reading| reading.readable)?;
    let is_sound = !reading.values.is_empty() && reading.values.iter().all(|value| value.is_finite());
    is_sound.then(|| (reading.sampled_at_ns.unwrap_or(turn.at_ns), reading.values.as_slice()))
}

/// Two rays side by side meet two things if these are so much nearer and farther, in metres.
const JUMP_M: f64 = 0.3;

/// Room that it leaves between its rim and the near side of a landmark's middle, in metres.
const CLEAR_M: f64 = 0.15;

/// The ant stands still and turns where a landmark is nearer to its rim than this, in metres.
const STOP_M: f64 = 0.05;

/// So long it goes straight on after it has turned aside, in nanoseconds, ...
const PASS_NS: u64 = 1_000_000_000;

/// ... and so long it keeps to that side.
const KEEP_NS: u64 = 3_000_000_000;

/// Headings that are kept: more than come while a scan is under way.
const HEADINGS: usize = 64;

/// A scan that is older shows nothing.
const STALE_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests;
