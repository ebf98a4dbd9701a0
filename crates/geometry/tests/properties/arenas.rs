//! Random arenas and rays for the property tests, with more coincidences than chance would give.

use std::f64::consts::TAU;

use baudbot_geometry::{Circle, Direction, Point, Ray, Segment, polygon};
use proptest::prelude::*;

/// Coordinates are often on a lattice, where walls meet, overlap and run along the axes.
pub(crate) fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-4.0..4.0_f64, (-8..=8_i32).prop_map(|n| f64::from(n) * 0.5)]
}

pub(crate) fn point() -> impl Strategy<Value = Point> {
    (coordinate(), coordinate()).prop_map(|(x, y)| Point::new(x, y))
}

pub(crate) fn segment() -> impl Strategy<Value = Segment> {
    (point(), point(), any::<bool>()).prop_map(|(start, end, short)| {
        let end = if short { start + (end - start) * 0.125 } else { end };
        Segment { start, end }
    })
}

pub(crate) fn circle() -> impl Strategy<Value = Circle> {
    (point(), prop_oneof![0.0..1.5_f64, Just(0.5)]).prop_map(|(center, radius)| Circle { center, radius })
}

pub(crate) fn direction() -> impl Strategy<Value = Direction> {
    prop_oneof![
        (-TAU..TAU).prop_map(Direction::from_angle),
        (0..4_usize).prop_map(|i| {
            let (cos, sin) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][i];
            Direction { cos, sin }
        }),
        // Nearly along an axis, and on the lattice's 3-4-5 triangles.
        (-1e-9..1e-9_f64).prop_map(Direction::from_angle),
        Just(Direction { cos: 0.6, sin: -0.8 }),
    ]
}

/// A star-shaped chain around its center: the center sees every point of it.
#[derive(Clone, Debug)]
pub(crate) struct Star {
    pub(crate) center: Point,
    pub(crate) corners: Vec<Point>,
}

impl Star {
    pub(crate) fn edges(&self) -> Vec<Segment> {
        polygon::edges(&self.corners).collect()
    }
}

pub(crate) fn star() -> impl Strategy<Value = Star> {
    (point(), prop::collection::vec(0.2..3.0_f64, 3..24)).prop_map(|(center, radii)| {
        let step = TAU / radii.len() as f64;
        let corner =
            |(i, radius): (usize, f64)| center + Direction::from_angle(i as f64 * step).vector() * radius;
        Star { center, corners: radii.into_iter().enumerate().map(corner).collect() }
    })
}

#[derive(Clone, Debug)]
pub(crate) struct Arena {
    pub(crate) segments: Vec<Segment>,
    pub(crate) circles: Vec<Circle>,
}

/// Loose walls, the chain of a polygon, and pillars; moved away from the origin at times.
pub(crate) fn arena() -> impl Strategy<Value = Arena> {
    let walls = prop::collection::vec(segment(), 0..40);
    let chain = prop::option::of(star());
    let pillars = prop::collection::vec(circle(), 0..8);
    let offset = prop_oneof![3 => Just(0.0), 1 => -1e3..1e3_f64, 1 => Just(1e9)];
    (walls, chain, pillars, offset).prop_map(|(mut segments, chain, mut circles, offset)| {
        segments.extend(chain.iter().flat_map(Star::edges));
        for segment in &mut segments {
            segment.start.x += offset;
            segment.end.x += offset;
        }
        circles.iter_mut().for_each(|circle| circle.center.x += offset);
        Arena { segments, circles }
    })
}

/// The choice of a ray once the arena is known.
#[derive(Clone, Debug)]
pub(crate) enum Aim {
    /// A ray from a place, whatever comes.
    Free(Direction),
    /// Exactly at an end of a segment.
    End(prop::sample::Index),
    /// Along a segment, from a place on its line.
    Along(prop::sample::Index, f64),
    /// Touching the rim of a circle.
    Rim(prop::sample::Index),
}

pub(crate) fn aim() -> impl Strategy<Value = Aim> {
    prop_oneof![
        3 => direction().prop_map(Aim::Free),
        2 => any::<prop::sample::Index>().prop_map(Aim::End),
        1 => (any::<prop::sample::Index>(), -2.0..2.0_f64).prop_map(|(which, at)| Aim::Along(which, at)),
        1 => any::<prop::sample::Index>().prop_map(Aim::Rim),
    ]
}

/// A ray from `near`, which is relative to the arena's first point.
pub(crate) fn ray(arena: &Arena, near: Point, aim: &Aim) -> Ray {
    let anchor = arena.segments.first().map(|segment| segment.start.x);
    let anchor = anchor.or_else(|| arena.circles.first().map(|circle| circle.center.x));
    let origin = Point::new(near.x + anchor.unwrap_or(0.0), near.y);
    let free = Ray { origin, direction: Direction { cos: 1.0, sin: 0.0 } };
    match aim {
        Aim::Free(direction) => Ray { origin, direction: *direction },
        Aim::End(which) if !arena.segments.is_empty() => toward(origin, which.get(&arena.segments).end),
        Aim::Along(which, at) if !arena.segments.is_empty() => {
            let wall = which.get(&arena.segments);
            toward(wall.start + (wall.end - wall.start) * *at, wall.end)
        }
        Aim::Rim(which) if !arena.circles.is_empty() => {
            let circle = which.get(&arena.circles);
            let away = circle.center - origin;
            let angle = away.y.atan2(away.x) + (circle.radius / away.norm()).min(1.0).asin();
            Ray { origin, direction: Direction::from_angle(angle) }
        }
        Aim::End(_) | Aim::Along(..) | Aim::Rim(_) => free,
    }
}

pub(crate) fn toward(origin: Point, target: Point) -> Ray {
    let way = target - origin;
    let length = way.norm();
    let direction = if length > 0.0 {
        Direction { cos: way.x / length, sin: way.y / length }
    } else {
        Direction { cos: 1.0, sin: 0.0 }
    };
    Ray { origin, direction }
}
