//! The arena: named polygons and circles that stand still.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Bounds, Circle, Crowd, Index, Point, Segment, Shape, math, polygon};

use crate::heap::{elements, list};

/// A polygon, or a line with corners. A solid polygon is an obstacle through and through; a hollow one is a
/// wall drawn as its outline, such as the border of a room that robots are in.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Unique among the arena's shapes.
    pub name: String,
    /// Corners in order, in metres.
    pub points: Vec<Point>,
    /// Whether its inside is filled.
    pub solid: bool,
    /// Whether the last corner is joined to the first.
    pub closed: bool,
    /// The height of the polygon and its colour.
    pub look: Look,
}

/// A solid disc, such as a pillar.
#[derive(Clone, Debug, PartialEq)]
pub struct Pillar {
    /// Unique among the arena's shapes.
    pub name: String,
    /// The outline, in metres.
    pub circle: Circle,
    /// The height of the pillar and its colour.
    pub look: Look,
}

/// The visible properties of a thing besides its outline on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The height up to which it reaches from the floor, in metres; infinite for a wall. A sensor that sits higher
    /// overlooks it (§6.1).
    pub height_m: f64,
    /// The height at which it begins, in metres; 0 on the floor. A sensor that sits lower sees under it.
    pub lower_edge_m: f64,
    /// The colour: red, green and blue.
    pub color: [u8; 3],
}

impl Look {
    /// A wall as high as any sensor, in grey.
    pub const WALL: Self = Self { height_m: f64::INFINITY, lower_edge_m: 0.0, color: [128, 128, 128] };

    /// Whether an eye at this height looks at it, and neither over nor under it. Rounding puts nobody below the floor.
    pub fn is_at(&self, above_floor_m: f64) -> bool {
        self.lower_edge_m <= above_floor_m.max(0.0) && self.height_m >= above_floor_m
    }
}

/// All that stands still, with the indices that find it.
#[derive(Clone, Debug)]
pub struct Arena {
    polygons: Vec<Polygon>,
    pillars: Vec<Pillar>,
    /// The first has everything; each of the others what is seen from some height.
    layers: Vec<Layer>,
    solids: Solids,
}

/// The polygons that are solid.
#[derive(Clone, Debug, Default)]
struct Solids {
    /// The places of the solids, in order.
    places: Vec<usize>,
    /// The box around each.
    bounds: Vec<Bounds>,
    /// The disc around each.
    discs: Crowd,
}

/// One of the arena's shapes, by its place in its list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thing {
    /// A polygon.
    Polygon(usize),
    /// A pillar.
    Pillar(usize),
}

/// The height of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// In metres.
    pub above_floor_m: f64,
    /// The layer of the arena with what reaches up to there.
    pub(crate) layer: usize,
}

/// The shapes that are visible from some height.
#[derive(Clone, Debug)]
struct Layer {
    index: Index,
    /// The polygon that each of the index's segments belongs to.
    polygons: Vec<usize>,
    /// The pillar that each of the index's circles is.
    pillars: Vec<usize>,
}

impl Arena {
    /// An arena of these shapes.
    pub fn new(polygons: Vec<Polygon>, pillars: Vec<Pillar>) -> Self {
        let all = Layer::new(&polygons, &pillars, |_| true);
        let solids = Solids::of(&polygons);
        Self { polygons, pillars, layers: alloc::vec![all], solids }
    }

    /// The height of a sensor. The arena gets a layer of what reaches up to there, if it has none yet.
    pub fn height(&mut self, above_floor_m: f64) -> Height {
        Height { above_floor_m, layer: self.layer(above_floor_m) }
    }

    fn layer(&mut self, height_m: f64) -> usize {
        let same = |layer: &Layer| self.is_layer(layer, height_m);
        if let Some(i) = self.layers.iter().position(same) {
            return i;
        }
        self.layers.push(Layer::new(&self.polygons, &self.pillars, |look| look.is_at(height_m)));
        self.layers.len() - 1
    }

    /// Whether the layer has just what reaches up to `height_m`.
    fn is_layer(&self, layer: &Layer, height_m: f64) -> bool {
        let seen = |look: &Look| look.is_at(height_m);
        let polygons = (0..self.polygons.len()).filter(|&i| seen(&self.polygons[i].look));
        let pillars = (0..self.pillars.len()).filter(|&i| seen(&self.pillars[i].look));
        let mut known = layer.polygons.iter().copied();
        let same = |i: usize| {
            let sides = self.polygons[i].edges().count();
            known.by_ref().take(sides).eq(core::iter::repeat_n(i, sides))
        };
        let mut polygons = polygons;
        polygons.all(same) && known.next().is_none() && pillars.eq(layer.pillars.iter().copied())
    }

    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        let polygons = list(&self.polygons, |polygon| polygon.name.capacity() + elements(&polygon.points));
        let pillars = list(&self.pillars, |pillar| pillar.name.capacity());
        let Solids { places, bounds, discs } = &self.solids;
        let solids = elements(places) + elements(bounds) + discs.heap_bytes();
        polygons + pillars + solids + list(&self.layers, Layer::heap_bytes)
    }

    /// The polygons, in the scenario's order.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// The pillars, in the scenario's order.
    pub fn pillars(&self) -> &[Pillar] {
        &self.pillars
    }

    /// Everything that bodies can meet.
    pub fn index(&self) -> &Index {
        &self.layers[0].index
    }

    /// Everything that rays of a layer can meet.
    pub(crate) fn seen(&self, layer: usize) -> &Index {
        &self.layers[layer].index
    }

    /// The look of a shape of a layer.
    pub(crate) fn look_of(&self, layer: usize, shape: Shape) -> Look {
        let layer = &self.layers[layer];
        match shape {
            Shape::Segment(i) => self.polygons[layer.polygons[i]].look,
            Shape::Circle(i) => self.pillars[layer.pillars[i]].look,
        }
    }

    /// The name of the shape that a disc runs into, if any: its outline is strictly nearer than the radius
    /// (touching is no collision, as in ARSim), or the disc's centre is inside a solid polygon, which ARSim
    /// does not see. The collision of §3.2.5.
    pub fn obstacle_at(&self, disc: &Circle) -> Option<&str> {
        self.thing_at(disc).map(|thing| self.name_of(thing))
    }

    /// The shape of [`obstacle_at`](Self::obstacle_at).
    pub(crate) fn thing_at(&self, disc: &Circle) -> Option<Thing> {
        self.index().overlaps(disc).map(|shape| self.owner_of(shape)).or_else(|| self.solid_at(disc.center))
    }

    /// The first solid polygon that a point is in, if any.
    pub(crate) fn solid_at(&self, point: Point) -> Option<Thing> {
        let Solids { places, bounds, discs } = &self.solids;
        let mut first = None;
        let mut look = |i: usize| {
            let place = places[i];
            // Of a long wall the disc is large, and most of it is beside the wall.
            if first.is_none_or(|first| place < first)
                && bounds[i].contains(point)
                && polygon::contains(&self.polygons[place].points, point)
            {
                first = Some(place);
            }
        };
        if places.len() <= FEW {
            (0..places.len()).for_each(look);
        } else {
            discs.near(&Circle { center: point, radius: 0.0 }, &mut look);
        }
        first.map(Thing::Polygon)
    }

    /// A radius around a point within which nothing stands, by more than any rounding; not positive if there is none.
    pub(crate) fn free_around(&self, point: Point) -> f64 {
        let (Some((_, distance)), Some(bounds)) = (self.index().nearest_point(point), self.index().bounds())
        else {
            return f64::INFINITY;
        };
        if self.solid_at(point).is_some() {
            return 0.0;
        }
        let largest = [point, bounds.min, bounds.max].map(|corner| corner.coords.abs().sum());
        distance - ROUNDING * largest.into_iter().sum::<f64>()
    }

    /// The polygon or pillar that a shape of the index belongs to.
    pub(crate) fn owner_of(&self, shape: Shape) -> Thing {
        match shape {
            Shape::Segment(i) => Thing::Polygon(self.layers[0].polygons[i]),
            Shape::Circle(i) => Thing::Pillar(self.layers[0].pillars[i]),
        }
    }

    /// A shape's name.
    pub fn name_of(&self, thing: Thing) -> &str {
        match thing {
            Thing::Polygon(i) => &self.polygons[i].name,
            Thing::Pillar(i) => &self.pillars[i].name,
        }
    }
}

/// The number of polygons up to which all boxes are compared, as that is faster than to find the cells in which their
/// discs lie.
const FEW: usize = 16;

/// A generous bound on the rounding error of a distance, as a part of the coordinates that it is computed from.
const ROUNDING: f64 = 1e-12;

impl Solids {
    fn of(polygons: &[Polygon]) -> Self {
        let bounded = |i: usize| Some((i, Bounds::of_points(&polygons[i].points)?));
        let solid = (0..polygons.len()).filter(|&i| polygons[i].solid);
        let (places, bounds): (Vec<_>, Vec<_>) = solid.filter_map(bounded).unzip();
        let around = |bounds: &Bounds| {
            let half = bounds.size() * 0.5;
            Circle { center: bounds.center(), radius: math::sqrt(half.norm_squared()) }
        };
        let mut discs = Crowd::default();
        discs.rebuild(bounds.iter().map(around));
        Self { places, bounds, discs }
    }
}

impl Layer {
    fn heap_bytes(&self) -> usize {
        self.index.heap_bytes() + elements(&self.polygons) + elements(&self.pillars)
    }

    fn new(polygons: &[Polygon], pillars: &[Pillar], is_seen: impl Fn(&Look) -> bool) -> Self {
        let mut segments = Vec::new();
        let mut owners = Vec::new();
        for (owner, polygon) in polygons.iter().enumerate().filter(|(_, polygon)| is_seen(&polygon.look)) {
            for edge in polygon.edges() {
                segments.push(edge);
                owners.push(owner);
            }
        }
        let seen = pillars.iter().enumerate().filter(|(_, pillar)| is_seen(&pillar.look));
        let (pillars, circles) = seen.map(|(i, pillar)| (i, pillar.circle)).unzip();
        Self { index: Index::new(segments, circles), polygons: owners, pillars }
    }
}

impl Polygon {
    /// The polygon's sides, in order.
    pub fn edges(&self) -> impl Iterator<Item = Segment> {
        let sides = if self.closed { self.points.len() } else { self.points.len().saturating_sub(1) };
        polygon::edges(&self.points).take(sides)
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Direction, Ray};

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_high_sensor_overlooks_a_low_box() {
        let points = [(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)].map(|(x, y)| Point::new(x, y));
        let look = Look { height_m: 0.3, ..Look::WALL };
        let low = Polygon { name: "box".into(), points: points.to_vec(), solid: true, closed: true, look };
        let circle = Circle { center: Point::new(5.0, 0.0), radius: 1.0 };
        let pillar = Pillar { name: "pillar".into(), circle, look: Look::WALL };
        let mut arena = Arena::new(alloc::vec![low], alloc::vec![pillar]);
        let (infrared, laser) = (arena.layer(0.1), arena.layer(0.9));
        assert_eq!((infrared, laser, arena.layer(0.2), arena.layer(2.0)), (0, 1, 0, 1));
        let ray = Ray { origin: Point::origin(), direction: Direction::from_angle(0.0) };
        let sees = |layer| arena.seen(layer).cast(&ray, 10.0).map(|hit| hit.distance);
        assert_eq!((sees(infrared), sees(laser)), (Some(1.0), Some(4.0)));
    }

    #[test]
    fn an_open_line_has_no_last_side() {
        let points: Vec<_> = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec();
        let line = Polygon { name: "l".into(), points, solid: false, closed: false, look: Look::WALL };
        assert_eq!(line.edges().count(), 2);
    }

    proptest! {
        /// The arenas have few solids or many.
        #[test]
        fn the_first_solid_around_a_point_is_found(
            boxes in prop::collection::vec((-5.0..5.0, -5.0..5.0, 0.1..6.0, 0.1..6.0, any::<bool>()), 0..3 * FEW),
            x in -6.0..6.0, y in -6.0..6.0,
        ) {
            let polygon = |(left, low, wide, high, solid): (f64, f64, f64, f64, bool)| {
                let corners = [(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)];
                let points = corners.iter().map(|(x, y)| Point::new(left + x, low + y)).collect();
                Polygon { name: String::new(), points, solid, closed: true, look: Look::WALL }
            };
            let polygons: Vec<_> = boxes.into_iter().map(polygon).collect();
            let point = Point::new(x, y);
            let expected = polygons.iter().position(|one| one.solid && polygon::contains(&one.points, point));
            let arena = Arena::new(polygons, Vec::new());
            prop_assert_eq!(arena.solid_at(point), expected.map(Thing::Polygon));
        }
    }
}
