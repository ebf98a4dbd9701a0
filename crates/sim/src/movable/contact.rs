//! The places at which two bodies are about to meet.
//!
//! A body is a chain of edges, rounded off by a radius: a disc is one corner with its radius, a polygon has
//! none. Then there are two kinds of places: a corner before an edge, and a corner before a corner. The latter
//! counts only if the one is before the other's tip, beyond all edges that end there; otherwise things would
//! be caught on the joints of straight walls.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Segment, Shape, Vector, polygon};

use super::body::Body;
use crate::arena::Arena;

/// Corners and edges, rounded off.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    corners: Vec<Point>,
    edges: Vec<Segment>,
    rounding_m: f64,
}

/// A place where body A is about to meet body B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    /// In the world, in metres.
    pub(crate) point: Point,
    /// Unit vector from B to A.
    pub(crate) normal: Vector,
    /// Distance between the two, in metres.
    pub(crate) gap: f64,
}

impl Chain {
    pub(crate) fn of_body(body: &Body) -> Self {
        match body {
            Body::Disc(disc) => Self::of_disc(disc),
            Body::Polygon(points) => {
                Self { corners: points.clone(), edges: polygon::edges(points).collect(), rounding_m: 0.0 }
            }
        }
    }

    fn of_disc(disc: &Circle) -> Self {
        Self { corners: alloc::vec![disc.center], edges: Vec::new(), rounding_m: disc.radius }
    }

    /// The fixed obstacles in this disc: all walls together, and each pillar.
    pub(crate) fn of_arena(arena: &Arena, near: &Circle) -> Vec<Self> {
        let mut shapes = Vec::new();
        arena.index().near(near, |shape| shapes.push(shape));
        shapes.sort_unstable();
        shapes.dedup();
        let (mut walls, mut pillars) = (Self::default(), Vec::new());
        for shape in shapes {
            match shape {
                Shape::Segment(i) => walls.add(arena.index().segments()[i], near),
                Shape::Circle(i) => pillars.push(Self::of_disc(&arena.index().circles()[i])),
            }
        }
        pillars.push(walls);
        pillars
    }

    fn add(&mut self, edge: Segment, near: &Circle) {
        if near.overlaps_segment(&edge) {
            for end in [edge.start, edge.end] {
                if !self.corners.contains(&end) {
                    self.corners.push(end);
                }
            }
            self.edges.push(edge);
        }
    }

    /// Whether the place is before the tip at this corner: beyond all edges that end there.
    fn is_tip(&self, corner: Point, before: Point) -> bool {
        let beyond = |end: Point, other: Point| end != corner || (before - end).dot(&(other - end)) <= 0.0;
        self.edges.iter().all(|edge| beyond(edge.start, edge.end) && beyond(edge.end, edge.start))
    }
}

/// Places where body `a`, whose middle is at `center`, and body `b` are at most `reach_m` apart.
pub(crate) fn touches(a: &Chain, center: Point, b: &Chain, reach_m: f64, mut found: impl FnMut(Touch)) {
    let rounding = a.rounding_m + b.rounding_m;
    let mut keep = |corner: Point, of_a: bool, from_b: Vector, distance: f64| {
        let gap = distance - rounding;
        if gap <= reach_m {
            let point = if of_a { corner - from_b * a.rounding_m } else { corner + from_b * b.rounding_m };
            found(Touch { point, normal: from_b, gap });
        }
    };
    for &corner in &a.corners {
        for edge in &b.edges {
            if let Some((normal, distance)) = before_edge(corner, edge, center - corner, 1.0) {
                keep(corner, true, normal, distance);
            }
        }
    }
    for &corner in &b.corners {
        for edge in &a.edges {
            if let Some((normal, distance)) = before_edge(corner, edge, center - corner, -1.0) {
                keep(corner, false, normal, distance);
            }
        }
    }
    for &corner in &a.corners {
        for &other in &b.corners {
            let way = corner - other;
            let distance = way.norm();
            if distance > 0.0
                && distance - rounding <= reach_m
                && a.is_tip(corner, other)
                && b.is_tip(other, corner)
            {
                keep(corner, true, way / distance, distance);
            }
        }
    }
}

/// The normal from the edge to the corner, times `sign`, and the distance, if the corner is beside the edge and
/// not beyond its ends. If the distance is no more than rounding, its side is unknown: then the normal points
/// as `towards`.
fn before_edge(corner: Point, edge: &Segment, towards: Vector, sign: f64) -> Option<(Vector, f64)> {
    let along = edge.end - edge.start;
    let length = along.norm();
    let ahead = (corner - edge.start).dot(&along);
    if length <= 0.0 || ahead <= 0.0 || ahead >= length * length {
        return None;
    }
    let left = Vector::new(-along.y, along.x) / length;
    let offset = (corner - edge.start).dot(&left);
    let normal = if offset.abs() < UNKNOWN_SIDE_M {
        if towards.dot(&left) < 0.0 { -left } else { left }
    } else {
        left * if offset < 0.0 { -sign } else { sign }
    };
    Some((normal, offset.abs()))
}

const UNKNOWN_SIDE_M: f64 = 1e-9;
