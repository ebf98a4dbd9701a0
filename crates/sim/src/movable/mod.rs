//! Things on the floor that robots push: boxes and balls.
//!
//! One step of `dt` is cut into slices so short that nothing moves by more than a fraction of its own
//! thickness in one. In each slice
//!
//! 1. contacts are found: places where two bodies are about to meet (`contact`),
//! 2. impulses J at them, along the normal n, change velocities, Δv = J n / m and Δω = (r × n) J / I, until
//!    no bodies approach any more; the floor takes from moving things what friction can take (`solve`):
//!    μ g h of u = √(v² + k² ω²), where k = √(I/m) is the radius of gyration and h the slice; where bodies
//!    met fast, a share e of each impulse is given back,
//! 3. things move by their new velocities, each only to a pose that is free, then the robots (`step`).
//!
//! A robot rolls and does not slide: it changes its speed V along its heading h and its turn rate only, so that
//! a contact feels the inverse mass (n·h)²/M + (r × n)²/I of it. For a disc r × n is 0.
//!
//! These properties always hold, as no pose is taken unless it is free:
//! - no thing overlaps the arena, another thing or a robot, if none did before;
//! - the kinetic energy of things and robots, ½ m v² + ½ I ω² summed, does not grow within a step: each
//!   impulse lessens it, and what is given back at the end is given only as far as the sum allows.
//!
//! *Deviations* from how bodies really meet:
//! - Contacts are without friction. A box does not drag along what it slides past, and a robot cannot turn a
//!   box by rubbing; a ball gets no spin.
//! - A ball is a disc that slides with little friction. The energy of its rolling is left out, which for a
//!   solid ball would be 2/7 of the whole.
//! - Friction with the floor is one number for resting and sliding. It acts on the way and on the turning
//!   together as if all weight were on a ring of radius k (an ellipsoid as limit surface); for a square that
//!   spins on its place this is 7 % more than an even pressure gives.
//! - No body tips over or is lifted, whatever the height.
//! - A body that meets another with restitution e stops and bounces up to one slice's way before that, not at it.
//!   Below 1 cm/s nothing bounces. Two things meet with the smaller of their two e.
//! - Contacts of one slice are simultaneous: of a row of touching balls that is hit at one end, the last does
//!   not fly off alone. Energy and momentum are right, their distribution is one of several possible.
//! - Between bodies that press on each other stays a gap of up to a tenth of a millimetre.
//! - If the way is not free though velocities say so (a corner that turns), a thing moves by a part, or not
//!   and loses half its velocity; a robot waits for a slice, and keeps its speed.
//! - Within one step a thing does not enter the place where a robot was at its beginning.
//! - A robot's sideways grip has no limit: pushed from the side, it is a wall.
//! - Obstacles that move, such as doors, stand still within a step. The code that moves one asks `Form::at` and
//!   `Body::overlaps` whether it would run into a thing, and then leaves it.
//! - Something so fast that it would need more than a thousand slices moves less than it should.

mod advance;
mod body;
mod contact;
mod slice;
mod solve;
mod step;
#[cfg(test)]
mod tests;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Point, Pose, Vector};
use serde::{Deserialize, Serialize};

pub use body::{Body, Form};
pub(crate) use contact::{Chain, Touch, touches};
#[cfg(test)]
use step::Reaction;
pub(crate) use step::{Fixed, Pusher, step};

use crate::arena::Look;
use crate::sound;

/// A thing on the floor that robots can push.
#[derive(Clone, Debug, PartialEq)]
pub struct Movable {
    /// Unique in its world.
    pub name: String,
    /// The outline from above.
    pub shape: MovableShape,
    /// In kg; positive.
    pub mass_kg: f64,
    /// Coulomb's coefficient of friction with the floor, without unit; of a ball: its rolling resistance. Not
    /// negative.
    pub friction: f64,
    /// The fraction of the speed of meeting that is left when parting again, 0 to 1.
    pub restitution: f64,
    /// The look from the side.
    pub look: Look,
    /// World from thing, at the start.
    pub start: Pose,
}

/// The outline of a [`Movable`].
#[derive(Clone, Debug, PartialEq)]
pub enum MovableShape {
    /// Round, and rolling any way.
    Ball {
        /// In metres; positive.
        radius_m: f64,
    },
    /// A movable with corners.
    Box {
        /// The corners in metres, in the thing's own frame: convex, counter-clockwise, the centroid at the
        /// origin.
        outline: Vec<Point>,
    },
}

/// The pose and the motion of a [`Movable`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovableState {
    /// World from thing.
    pub pose: Pose,
    /// Velocity of its centre in the world's frame, in m/s.
    pub velocity_m_s: Vector,
    /// Turn rate in rad/s, counter-clockwise.
    pub spin_rad_s: f64,
}

impl MovableState {
    pub(crate) fn is_sound(&self) -> bool {
        sound::pose(&self.pose) && sound::numbers([self.velocity_m_s.x, self.velocity_m_s.y, self.spin_rad_s])
    }
}

impl Movable {
    /// The state at the start, at rest.
    pub fn at_start(&self) -> MovableState {
        MovableState { pose: self.start, velocity_m_s: Vector::zeros(), spin_rad_s: 0.0 }
    }
}

impl MovableShape {
    /// The shape without a place.
    pub fn form(&self) -> Form<'_> {
        match self {
            Self::Ball { radius_m } => Form::Disc { radius_m: *radius_m },
            Self::Box { outline } => Form::Polygon(outline),
        }
    }
}

/// Acceleration of free fall g, in m/s².
const GRAVITY_M_S2: f64 = 9.80665;

/// Bodies that press on each other are kept this far apart, in metres, so that rounding and the bend of a
/// turning corner's way do not make them overlap.
const SKIN_M: f64 = 1e-4;
