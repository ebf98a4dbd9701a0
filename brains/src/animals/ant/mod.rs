//! The desert ant (*Cataglyphis*): out on a winding way and straight home. Wahde 2016, §4.4.4, Fig. 4.3.
//!
//! - [`PathIntegrator`]: from its steps and its compass the ant always knows the vector home.
//! - [`Spiral`]: where that vector ends without a nest, it searches in growing loops. The notes do not mention
//!   this; Wehner and Srinivasan 1981 describe it.
//! - [`Snapshot`]: when it left, it remembered what it saw about the nest, and compares.
//!
//! [`Ant`] puts them together: it forages, returns by the vector, and then searches until what it sees is what it
//! remembers. The notes give no numbers, so all are ours. [`AntBrain`] is a robot that does as it does.

pub(crate) mod brain;

mod landmarks;
mod path;
mod snapshot;
mod spiral;

pub use brain::{AntBrain, Parameters as BrainParameters};
pub use path::PathIntegrator;
pub use snapshot::Snapshot;
pub use spiral::Spiral;

use baudbot_geometry::{Vector, angle, math};

use super::wheel_commands::Motion;
use crate::Chance;

/// Parameters of an ant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The ant's speed, in m/s.
    pub speed_m_s: f64,
    /// The highest rate of turning, in rad/s.
    pub turn_rad_s: f64,
    /// The rate of turning for each radian that it should turn, per second.
    pub steering_hz: f64,
    /// The rate at which it changes its rate of turning while it forages, per second.
    pub meander_hz: f64,
    /// The search begins once the vector home is shorter than this, in metres.
    pub near_m: f64,
    /// The distance from one loop of the search to the next, in metres. Less than twice as far as it sees the nest,
    /// with room for the corners that it cuts and for its compass.
    pub pitch_m: f64,
    /// The ant is home if its view differs from the snapshot by less than this: see [`Snapshot::mismatch`].
    pub match_below: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            speed_m_s: 0.2,
            turn_rad_s: 2.0,
            steering_hz: 4.0,
            meander_hz: 1.0,
            near_m: 0.1,
            pitch_m: 0.2,
            match_below: 0.02,
        }
    }
}

/// The perception of an ant in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed<'a> {
    /// The distance since the last step, in metres.
    pub distance_m: f64,
    /// The ant's heading by its compass, in radians counter-clockwise.
    pub heading_rad: f64,
    /// The bearings of landmarks, in radians to the left of its heading; in any order, the same ones as on leaving.
    pub landmarks_rad: &'a [f64],
    /// Whether the ant has found food.
    pub food: bool,
    /// Whether the ant sees the nest.
    pub nest: bool,
}

/// The activity of an ant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// On its winding way out.
    Forage,
    /// Home by the vector.
    Return,
    /// The ant searches for the nest, which must be near.
    Search,
    /// The ant is at the nest.
    Home,
}

/// An ant: its snapshot, its vector home and its activity.
#[derive(Clone, Debug, PartialEq)]
pub struct Ant {
    parameters: Parameters,
    chance: Chance,
    path: PathIntegrator,
    spiral: Spiral,
    snapshot: Option<Snapshot>,
    phase: Phase,
    turn_rate_rad_s: f64,
}

impl Ant {
    /// An ant at its nest, about to leave.
    pub fn new(parameters: Parameters, chance: Chance) -> Self {
        Self {
            parameters,
            chance,
            path: PathIntegrator::default(),
            spiral: Spiral::new(parameters.pitch_m),
            snapshot: None,
            phase: Phase::Forage,
            turn_rate_rad_s: 0.0,
        }
    }

    /// The ant's present activity.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The way home as it knows it, in metres, along the axes of its compass.
    pub fn home(&self) -> Vector {
        self.path.home()
    }

    /// The ant's motion for `dt_s` seconds. The snapshot is taken in the first step.
    pub fn step(&mut self, sensed: &Sensed<'_>, dt_s: f64) -> Motion {
        self.path.face(sensed.heading_rad);
        self.path.walk(sensed.distance_m);
        let seen = Snapshot::take(sensed.heading_rad, sensed.landmarks_rad);
        let remembered = *self.snapshot.get_or_insert(seen);
        let landmarks = (!sensed.landmarks_rad.is_empty()).then_some((seen, remembered));
        let found = sensed.nest
            || landmarks
                .is_some_and(|(seen, remembered)| seen.mismatch(&remembered) < self.parameters.match_below);
        self.phase = match self.phase {
            Phase::Forage if sensed.food => Phase::Return,
            Phase::Return if self.home().norm() < self.parameters.near_m => Phase::Search,
            Phase::Search if found => Phase::Home,
            same @ (Phase::Forage | Phase::Return | Phase::Search | Phase::Home) => same,
        };
        match self.phase {
            Phase::Forage => self.meander(dt_s),
            Phase::Return => self.towards(self.home()),
            Phase::Search => {
                let displacement = landmarks.map(|(seen, remembered)| seen.displacement_to(&remembered));
                let displacement = displacement.unwrap_or_else(|| self.search());
                self.towards(displacement)
            }
            Phase::Home => Motion::default(),
        }
    }

    fn meander(&mut self, dt_s: f64) -> Motion {
        if self.chance.happens(self.parameters.meander_hz * dt_s) {
            self.turn_rate_rad_s = self.parameters.turn_rad_s * (2.0 * self.chance.uniform() - 1.0);
        }
        Motion { speed_m_s: self.parameters.speed_m_s, turn_rate_rad_s: self.turn_rate_rad_s }
    }

    /// The way to a point of the spiral that is a little ahead.
    fn search(&mut self) -> Vector {
        let ahead_m = 0.5 * self.parameters.pitch_m;
        loop {
            let displacement = self.path.home() + self.spiral.place();
            if displacement.norm() >= ahead_m {
                return displacement;
            }
            self.spiral.advance(0.1 * ahead_m);
        }
    }

    fn towards(&self, displacement: Vector) -> Motion {
        let p = self.parameters;
        let aside = angle::difference(math::atan2(displacement.y, displacement.x), self.path.heading_rad());
        Motion {
            speed_m_s: p.speed_m_s * math::cos(aside).max(0.0),
            turn_rate_rad_s: (p.steering_hz * aside).clamp(-p.turn_rad_s, p.turn_rad_s),
        }
    }
}

#[cfg(test)]
mod tests;
