//! The index answers as if it tried every shape.

use crate::arenas::{self, Arena};
use baudbot_geometry::{Bounds, Circle, Hit, Index, Point, Ray, Segment, Shape};
use proptest::prelude::*;

fn shapes(arena: &Arena) -> impl Iterator<Item = Shape> {
    let circles = (0..arena.circles.len()).map(Shape::Circle);
    (0..arena.segments.len()).map(Shape::Segment).chain(circles)
}

fn index(arena: &Arena) -> Index {
    Index::new(arena.segments.clone(), arena.circles.clone())
}

fn cast_by_trying_all(arena: &Arena, ray: &Ray, range: f64) -> Option<Hit> {
    shapes(arena)
        .filter_map(|shape| {
            let distance = match shape {
                Shape::Segment(i) => ray.hit_segment(&arena.segments[i]),
                Shape::Circle(i) => ray.hit_circle(&arena.circles[i]),
            };
            distance.map(|distance| Hit { distance, shape })
        })
        .filter(|hit| hit.distance <= range)
        // The first of equal elements is the minimum.
        .min_by(|a, b| a.distance.total_cmp(&b.distance))
}

fn overlaps(arena: &Arena, shape: Shape, circle: &Circle) -> bool {
    match shape {
        Shape::Segment(i) => circle.overlaps_segment(&arena.segments[i]),
        Shape::Circle(i) => circle.overlaps_circle(&arena.circles[i]),
    }
}

fn bits(hit: Option<Hit>) -> Option<(u64, Shape)> {
    hit.map(|hit| (hit.distance.to_bits(), hit.shape))
}

/// A coordinate a few roundings about the border between two cells of 1 m.
fn on_border() -> impl Strategy<Value = f64> {
    (1..=3_i32, -4..=4_i32).prop_map(|(n, jitter)| f64::from(n) - 2e-6 + f64::from(jitter) * 1e-16)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Of several hits on a ray the nearest counts (§3.2.3), with the grid of the footnote.
    #[test]
    fn cast(
        arena in arenas::arena(),
        rays in prop::collection::vec((arenas::point(), arenas::aim(), prop_oneof![Just(1.0), Just(30.0)]), 1..30),
        range in prop_oneof![0.0..8.0_f64, Just(f64::INFINITY)],
    ) {
        let index = index(&arena);
        for (near, aim, away) in rays {
            // The ray starts well outside of the arena at times.
            let ray = arenas::ray(&arena, near * away, &aim);
            let expected = cast_by_trying_all(&arena, &ray, range);
            prop_assert_eq!(bits(index.cast(&ray, range)), bits(expected), "{:?} {:?}", aim, ray);
            if let Some(hit) = expected {
                // A hit exactly at the end of the range counts.
                prop_assert_eq!(bits(index.cast(&ray, hit.distance)), bits(expected));
            }
        }
    }

    #[test]
    fn cast_along_the_borders_of_cells(
        ends in prop::collection::vec((on_border(), on_border(), on_border(), on_border()), 6),
        rays in prop::collection::vec((on_border(), on_border(), arenas::aim()), 1..30),
    ) {
        // Eight shapes in a square of 4 m have cells of 1 m. The grid begins two margins, of a millionth of a
        // cell each, before the square, and there the coordinates from `on_border` are.
        let sides = [(0.0, 0.0, 0.0, 4.0), (4.0, 4.0, 4.0, 0.0)];
        let wall = |(x0, y0, x1, y1)| Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) };
        let arena = Arena { segments: sides.into_iter().chain(ends).map(wall).collect(), circles: vec![] };
        let index = index(&arena);
        for (x, y, aim) in rays {
            let ray = arenas::ray(&arena, Point::new(x, y), &aim);
            let expected = cast_by_trying_all(&arena, &ray, 9.0);
            prop_assert_eq!(bits(index.cast(&ray, 9.0)), bits(expected), "{:?} {:?}", aim, ray);
        }
    }

    #[test]
    fn overlaps_and_near(arena in arenas::arena(), bodies in prop::collection::vec(arenas::circle(), 1..20)) {
        let index = index(&arena);
        for mut body in bodies {
            body.center.x += arena.segments.first().map_or(0.0, |segment| segment.start.x);
            let expected = shapes(&arena).find(|&shape| overlaps(&arena, shape, &body));
            prop_assert_eq!(index.overlaps(&body), expected);
            let mut visited = vec![];
            index.near(&body, |shape| visited.push(shape));
            for shape in shapes(&arena).filter(|&shape| overlaps(&arena, shape, &body)) {
                prop_assert!(visited.contains(&shape));
            }
        }
    }

    #[test]
    fn nearest_point(arena in arenas::arena(), places in prop::collection::vec((arenas::point(), 0.1..20.0_f64), 1..20)) {
        let index = index(&arena);
        for (place, away) in places {
            let anchor = arena.segments.first().map_or(0.0, |segment| segment.start.x);
            let place = Point::new(place.x * away + anchor, place.y * away);
            let walls = arena.segments.iter().map(|wall| (wall.nearest_point(place), wall.distance(place)));
            let pillars = arena.circles.iter().map(|disc| (disc.nearest_point(place), disc.distance(place)));
            let expected = walls.chain(pillars).min_by(|a, b| a.1.total_cmp(&b.1));
            prop_assert_eq!(index.nearest_point(place), expected);
        }
    }

    #[test]
    fn bounds(arena in arenas::arena()) {
        let boxes = arena.segments.iter().map(Bounds::of_segment);
        let expected = boxes.chain(arena.circles.iter().map(Bounds::of_circle)).reduce(|a, b| a.union(&b));
        prop_assert_eq!(index(&arena).bounds(), expected);
    }
}

/// Many short walls, so that rays cross many cells.
#[test]
fn a_large_arena() {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut place = |scale: f64| Point::new(random() * scale, random() * scale);
    let segments = (0..5000).map(|_| {
        let start = place(100.0);
        Segment { start, end: start + place(0.7).coords }
    });
    let arena = Arena { segments: segments.collect(), circles: vec![] };
    let index = index(&arena);
    for _ in 0..300 {
        let ray = arenas::toward(place(100.0), place(100.0));
        assert_eq!(bits(index.cast(&ray, 200.0)), bits(cast_by_trying_all(&arena, &ray, 200.0)));
    }
}
