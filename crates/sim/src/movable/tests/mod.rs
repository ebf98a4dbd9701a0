//! Single contacts against numbers worked out by hand, and random scenes.

mod contacts;
mod scenes;

use alloc::string::ToString;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Direction, Point, Pose, Vector};

use super::*;
use crate::arena::{Arena, Look, Polygon};

pub(super) fn rectangle(width: f64, height: f64) -> Vec<Point> {
    let (x, y) = (0.5 * width, 0.5 * height);
    [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Point::new(x, y)).to_vec()
}

pub(super) fn ball(radius_m: f64, mass_kg: f64, restitution: f64) -> Movable {
    let shape = MovableShape::Ball { radius_m };
    Movable {
        name: "ball".to_string(),
        shape,
        mass_kg,
        friction: 0.0,
        restitution,
        look: Look::WALL,
        start: Pose::new(0.0, 0.0, 0.0),
    }
}

pub(super) fn crate_of(width: f64, height: f64, mass_kg: f64, friction: f64) -> Movable {
    let shape = MovableShape::Box { outline: rectangle(width, height) };
    Movable { shape, friction, ..ball(1.0, mass_kg, 0.0) }
}

pub(super) fn empty() -> Arena {
    Arena::new(Vec::new(), Vec::new())
}

pub(super) fn wall_at(x: f64) -> Arena {
    let points = [(x, -5.0), (x + 0.01, -5.0), (x + 0.01, 5.0), (x, 5.0)];
    let points = points.map(|(x, y)| Point::new(x, y)).to_vec();
    Arena::new(
        alloc::vec![Polygon {
            name: "wall".to_string(),
            points,
            solid: true,
            closed: true,
            look: Look::WALL
        }],
        Vec::new(),
    )
}

pub(super) fn state(x: f64, y: f64, vx: f64, vy: f64) -> MovableState {
    MovableState { pose: Pose::new(x, y, 0.0), velocity_m_s: Vector::new(vx, vy), spin_rad_s: 0.0 }
}

/// A robot of 3 kg, a disc of 20 cm, that drives freely for `dt` seconds.
pub(super) fn robot(x: f64, y: f64, heading: f64, speed_m_s: f64, dt: f64) -> Pusher<'static> {
    let direction = Direction::from_angle(heading);
    let before = Pose::new(x, y, heading);
    let after = Pose { position: before.position + direction.vector() * (speed_m_s * dt), heading };
    Pusher {
        form: Form::Disc { radius_m: 0.2 },
        before,
        after,
        mass_kg: 3.0,
        inertia_kg_m2: 0.1,
        heading: direction,
        speed_m_s,
        turn_rate_rad_s: 0.0,
    }
}

pub(super) fn run(
    movables: &[Movable],
    states: &mut [MovableState],
    arena: &Arena,
    pushers: &[Pusher<'_>],
    dt: f64,
) -> Vec<Reaction> {
    step(movables, states, &Fixed { arena, bodies: &[] }, pushers, dt)
}

pub(super) fn disc(x: f64, y: f64, radius: f64) -> Circle {
    Circle { center: Point::new(x, y), radius }
}
