//! The arena: named polygons and circles that stand still.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Index, Point, Shape, polygon};

/// A closed polygon. A solid one is an obstacle through and through; a hollow one is a wall drawn as its
/// outline, such as the border of a room that robots are in.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Unique among the arena's shapes.
    pub name: String,
    /// Corners in order, in metres.
    pub points: Vec<Point>,
    /// Whether its inside is filled.
    pub solid: bool,
}

/// A solid disc, such as a pillar.
#[derive(Clone, Debug, PartialEq)]
pub struct Pillar {
    /// Unique among the arena's shapes.
    pub name: String,
    /// Where it stands, in metres.
    pub circle: Circle,
}

/// All that stands still, with the index that finds it.
#[derive(Clone, Debug)]
pub struct Arena {
    polygons: Vec<Polygon>,
    pillars: Vec<Pillar>,
    /// Which polygon each of the index's segments belongs to.
    owners: Vec<usize>,
    index: Index,
}

impl Arena {
    /// An arena of these shapes.
    pub fn new(polygons: Vec<Polygon>, pillars: Vec<Pillar>) -> Self {
        let mut segments = Vec::new();
        let mut owners = Vec::new();
        for (owner, polygon) in polygons.iter().enumerate() {
            for edge in polygon::edges(&polygon.points) {
                segments.push(edge);
                owners.push(owner);
            }
        }
        let circles = pillars.iter().map(|pillar| pillar.circle).collect();
        Self { index: Index::new(segments, circles), polygons, pillars, owners }
    }

    /// The polygons, in the scenario's order.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// The pillars, in the scenario's order.
    pub fn pillars(&self) -> &[Pillar] {
        &self.pillars
    }

    /// Everything that rays and bodies can meet.
    pub fn index(&self) -> &Index {
        &self.index
    }

    /// The name of the shape that a disc runs into, if any: its outline is strictly nearer than the radius
    /// (touching is no collision, as in ARSim), or the disc's centre is inside a solid polygon, which ARSim
    /// does not see.
    pub fn obstacle_at(&self, disc: &Circle) -> Option<&str> {
        if let Some(shape) = self.index.overlaps(disc) {
            return Some(self.name_of(shape));
        }
        let inside = |polygon: &&Polygon| polygon.solid && polygon::contains(&polygon.points, disc.center);
        self.polygons.iter().find(inside).map(|polygon| polygon.name.as_str())
    }

    /// The name of the polygon or pillar that a shape of the index belongs to.
    pub fn name_of(&self, shape: Shape) -> &str {
        match shape {
            Shape::Segment(i) => &self.polygons[self.owners[i]].name,
            Shape::Circle(i) => &self.pillars[i].name,
        }
    }
}
