//! Discs and polygons as bodies: shapes, and shapes in their place. A robot's polygon is the collision geometry of Fig. 3.5.

use alloc::vec::Vec;

use baudbot_geometry::polygon::{self, ROUNDING_M};
use baudbot_geometry::{Circle, Point, Pose};

use crate::arena::{Arena, Thing};

/// A shape in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form<'a> {
    /// A disc around the origin.
    Disc {
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A simple polygon, in metres.
    Polygon(&'a [Point]),
}

/// A shape in the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// A disc.
    Disc(Circle),
    /// A simple polygon, filled.
    Polygon(Vec<Point>),
}

impl<'a> Form<'a> {
    /// The outline, or a disc where there is none.
    pub(crate) fn of(outline: &'a [Point], radius_m: f64) -> Self {
        if outline.is_empty() { Self::Disc { radius_m } } else { Self::Polygon(outline) }
    }

    /// The shape in the world.
    pub fn at(&self, world_from_form: &Pose) -> Body {
        match self {
            Self::Disc { radius_m } => {
                Body::Disc(Circle { center: world_from_form.position, radius: *radius_m })
            }
            Self::Polygon(points) => {
                let (direction, place) = (world_from_form.direction(), world_from_form.position);
                Body::Polygon(points.iter().map(|point| place + direction.apply(point.coords)).collect())
            }
        }
    }

    /// Distance from the origin to the farthest point, in metres.
    pub fn reach_m(&self) -> f64 {
        match self {
            Self::Disc { radius_m } => *radius_m,
            Self::Polygon(points) => polygon::bounding_radius(points),
        }
    }

    /// A length, in metres, that is at most the radius of the greatest disc inside, if convex, and at least
    /// half of that: area by perimeter.
    pub(crate) fn thickness_m(&self) -> f64 {
        match self {
            Self::Disc { radius_m } => 0.5 * radius_m,
            Self::Polygon(points) => polygon::area(points) / polygon::perimeter(points),
        }
    }
}

impl Body {
    /// Whether the insides of the two have a point in common, by more than rounding: [`ROUNDING_M`]. Touching is not
    /// overlapping.
    pub fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Disc(a), Self::Disc(b)) => but_for_rounding(a).overlaps_circle(b),
            (Self::Disc(disc), Self::Polygon(points)) | (Self::Polygon(points), Self::Disc(disc)) => {
                polygon::overlaps_circle(points, &but_for_rounding(disc))
            }
            (Self::Polygon(a), Self::Polygon(b)) => polygon::overlaps_polygon(a, b),
        }
    }

    /// Whether it overlaps something that stands still.
    pub(crate) fn overlaps_arena(&self, arena: &Arena) -> bool {
        self.arena_thing(arena).is_some()
    }

    /// A shape that stands still and that it overlaps, if any.
    pub fn arena_thing(&self, arena: &Arena) -> Option<Thing> {
        match self {
            Self::Disc(disc) => arena.thing_at(&but_for_rounding(disc)),
            Self::Polygon(points) => {
                if let Some(shape) = arena.index().meets_polygon(points) {
                    return Some(arena.owner_of(shape));
                }
                // No outline is inside of the body: then all of the body is where one point of it is.
                polygon::centroid(points).and_then(|place| arena.solid_at(place))
            }
        }
    }
}

fn but_for_rounding(disc: &Circle) -> Circle {
    Circle { radius: disc.radius - ROUNDING_M, ..*disc }
}
