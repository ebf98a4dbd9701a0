//! Impulses, so that no body approaches one that it is about to meet.
//!
//! Contacts are asked in turns (projected Gauss-Seidel), each gives or takes back so much of its impulse that
//! its bodies no longer approach. Giving and taking back never make the speed at the contact greater than it
//! is, nor turn it, so each lessens the kinetic energy. Friction with the floor takes its turn, too, until it
//! has taken all that it can in this slice: thus a robot that pushes with less than a box's friction moves
//! neither.
//!
//! Restitution is Poisson's: of the impulses that stopped bodies that met fast, the share e is given again, to
//! all at once. With one e for all this cannot give energy; with several it could, then less is given.

use alloc::vec::Vec;

use baudbot_geometry::{Point, Vector, math};

use super::SKIN_M;
use super::contact::Touch;

/// A body that impulses can move.
#[derive(Clone, Debug)]
pub(super) struct Mover {
    /// In the world, in metres.
    pub(super) center: Point,
    /// In m/s.
    pub(super) velocity: Vector,
    /// In rad/s.
    pub(super) spin: f64,
    pub(super) mass: f64,
    /// Moment of inertia by mass, in m²; 0 of discs, which cannot be turned.
    pub(super) gyration: f64,
    /// A robot's heading, a unit vector, along which alone its velocity can change.
    pub(super) rail: Option<Vector>,
    /// The remaining effect of friction in this slice, in m/s.
    pub(super) friction_left: f64,
    /// Whether it was given an impulse in this slice.
    pub(super) pressed: bool,
}

/// A contact of a mover with another, or with something that stands still.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub(super) a: usize,
    pub(super) b: Option<usize>,
    pub(super) touch: Touch,
    pub(super) restitution: f64,
    /// Given so far, along the normal to `a`, in N s; not negative.
    pub(super) impulse: f64,
    /// Whether any was given.
    pub(super) struck: bool,
    /// The speed along the normal, negative if approaching, that is let be.
    allowed: f64,
    bounces: bool,
}

impl Mover {
    /// √(v² + k² ω²), in m/s: the kinetic energy is ½ m times its square.
    pub(super) fn pace(&self) -> f64 {
        math::sqrt(self.velocity.norm_squared() + self.gyration * self.spin * self.spin)
    }

    fn energy(&self) -> f64 {
        0.5 * self.mass * (self.velocity.norm_squared() + self.gyration * self.spin * self.spin)
    }

    fn velocity_at(&self, point: Point) -> Vector {
        let arm = point - self.center;
        self.velocity + Vector::new(-arm.y, arm.x) * self.spin
    }

    /// Inverse of the mass that a contact at `point` along `normal` feels, in 1/kg.
    fn ease(&self, point: Point, normal: Vector) -> f64 {
        let along = self.rail.map_or(1.0, |rail| rail.dot(&normal));
        let lever = (point - self.center).perp(&normal);
        let turning = if self.gyration > 0.0 { lever * lever / self.gyration } else { 0.0 };
        (along * along + turning) / self.mass
    }

    fn push(&mut self, point: Point, impulse: Vector) {
        let change = self.rail.map_or(impulse, |rail| rail * rail.dot(&impulse));
        self.velocity += change / self.mass;
        if self.gyration > 0.0 {
            self.spin += (point - self.center).perp(&impulse) / (self.mass * self.gyration);
        }
    }

    fn rub(&mut self) {
        let pace = self.pace();
        if pace > 0.0 && self.friction_left > 0.0 {
            let taken = if pace < self.friction_left { pace } else { self.friction_left };
            let rest = 1.0 - taken / pace;
            self.velocity *= rest;
            self.spin *= rest;
            self.friction_left -= taken;
        }
    }
}

impl Contact {
    pub(super) fn new(a: usize, b: Option<usize>, touch: Touch, restitution: f64) -> Self {
        Self { a, b, touch, restitution, impulse: 0.0, struck: false, allowed: 0.0, bounces: false }
    }

    /// Speed along the normal: negative if the bodies approach.
    fn speed(&self, movers: &[Mover]) -> f64 {
        let other = self.b.map_or_else(Vector::zeros, |b| movers[b].velocity_at(self.touch.point));
        (movers[self.a].velocity_at(self.touch.point) - other).dot(&self.touch.normal)
    }

    fn give(&self, movers: &mut [Mover], impulse: f64) {
        let push = self.touch.normal * impulse;
        movers[self.a].push(self.touch.point, push);
        movers[self.a].pressed = true;
        if let Some(b) = self.b {
            movers[b].push(self.touch.point, -push);
            movers[b].pressed = true;
        }
    }

    /// Gives or takes back what is needed. Returns by how much this changed the speed.
    fn relax(&mut self, movers: &mut [Mover]) -> f64 {
        let speed = self.speed(movers);
        let wanted = if speed < self.allowed {
            self.allowed
        } else if speed > 0.0 && self.impulse > 0.0 {
            0.0
        } else {
            return 0.0;
        };
        let (point, normal) = (self.touch.point, self.touch.normal);
        let ease = movers[self.a].ease(point, normal) + self.b.map_or(0.0, |b| movers[b].ease(point, normal));
        let given = self.impulse;
        self.impulse = (given + (wanted - speed) / ease).max(0.0);
        self.give(movers, self.impulse - given);
        self.struck |= self.impulse > given;
        (self.impulse - given).abs() * ease
    }

    /// Bodies that are farther apart than they come in `h` seconds may approach.
    fn prepare(&mut self, movers: &[Mover], h: f64, may_bounce: bool) {
        let speed = self.speed(movers);
        self.allowed = -(self.touch.gap - SKIN_M).max(0.0) / h;
        self.bounces = may_bounce && speed < self.allowed && -self.restitution * speed >= SLOW_M_S;
        self.impulse = 0.0;
        if self.bounces {
            self.allowed = 0.0;
        }
    }
}

/// Changes the velocities so that after `h` seconds all contacts are still apart, as nearly as some rounds can.
pub(super) fn solve(movers: &mut [Mover], contacts: &mut [Contact], h: f64) {
    let most = energy(movers);
    compress(movers, contacts, h, true);
    if contacts.iter().any(|contact| contact.bounces && contact.impulse > 0.0) {
        rebound(movers, contacts, most);
        compress(movers, contacts, h, false);
    }
}

fn compress(movers: &mut [Mover], contacts: &mut [Contact], h: f64, may_bounce: bool) {
    contacts.iter_mut().for_each(|contact| contact.prepare(movers, h, may_bounce));
    for _ in 0..ROUNDS {
        movers.iter_mut().for_each(Mover::rub);
        let changes = contacts.iter_mut().map(|contact| contact.relax(movers));
        let greatest = changes.fold(0.0, f64::max);
        if greatest < SETTLED_M_S {
            break;
        }
    }
}

fn rebound(movers: &mut [Mover], contacts: &[Contact], most: f64) {
    let stopped: Vec<_> = movers.to_vec();
    for share in [1.0, 0.75, 0.5, 0.25] {
        for contact in contacts.iter().filter(|contact| contact.bounces) {
            contact.give(movers, share * contact.restitution * contact.impulse);
        }
        // Rounding alone must not cost an elastic ball its bounce.
        if energy(movers) <= most * (1.0 + 1e-14) {
            return;
        }
        movers.clone_from_slice(&stopped);
    }
}

fn energy(movers: &[Mover]) -> f64 {
    movers.iter().map(Mover::energy).sum()
}

const ROUNDS: usize = 40;

/// A round that changes no speed by more ends the search.
const SETTLED_M_S: f64 = 1e-12;

/// The speed of parting below which nothing bounces.
const SLOW_M_S: f64 = 0.01;
