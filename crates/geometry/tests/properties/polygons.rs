//! Overlaps of polygons, against an independent implementation and against each other.

use baudbot_geometry::{Circle, Direction, Index, Point, Segment, Shape, polygon};
use parry2d_f64::math::{Pose, Vec2};
use parry2d_f64::query;
use parry2d_f64::shape::{self, ConvexPolygon};
use proptest::prelude::*;

use crate::arenas;

fn vec2(point: Point) -> Vec2 {
    Vec2::new(point.x, point.y)
}

/// Corners on an ellipse, so convex.
fn convex() -> impl Strategy<Value = Vec<Point>> {
    let angles = prop::collection::btree_set(0..60_u32, 3..9);
    (arenas::point(), angles, 0.2..2.0_f64, 0.2..2.0_f64).prop_map(|(center, angles, a, b)| {
        let corner = |angle: u32| {
            let direction = Direction::from_angle(f64::from(angle) * std::f64::consts::TAU / 60.0);
            Point::new(center.x + a * direction.cos, center.y + b * direction.sin)
        };
        angles.into_iter().map(corner).collect()
    })
}

fn parry(points: &[Point]) -> ConvexPolygon {
    ConvexPolygon::from_convex_polyline(points.iter().map(|&p| vec2(p)).collect()).expect("it is convex")
}

/// Positive if apart, negative if overlapping, in metres; the oracle's own tolerance is about 1e-7.
fn oracle(a: &dyn shape::Shape, b: &dyn shape::Shape) -> f64 {
    let still = Pose::identity();
    query::contact(&still, a, &still, b, 1e3).expect("it is supported").map_or(1e3, |contact| contact.dist)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn convex_polygons_as_parry_sees_them(a in convex(), b in convex(), wall in arenas::segment(), disc in arenas::circle()) {
        let shape = parry(&a);
        let agree = |ours: bool, gap: f64| gap.abs() < 1e-5 || ours == (gap < 0.0);
        let gap = oracle(&shape, &parry(&b));
        prop_assert!(agree(polygon::overlaps_polygon(&a, &b), gap), "polygon, gap {gap}");
        prop_assert_eq!(polygon::overlaps_polygon(&a, &b), polygon::overlaps_polygon(&b, &a));
        if disc.radius > 0.01 {
            let still = Pose::identity();
            let at = Pose::translation(disc.center.x, disc.center.y);
            let ball = shape::Ball::new(disc.radius);
            let gap = query::contact(&still, &shape, &at, &ball, 1e3).unwrap().map_or(1e3, |contact| contact.dist);
            prop_assert!(agree(polygon::overlaps_circle(&a, &disc), gap), "disc, gap {gap}");
        }
        if (wall.end - wall.start).norm() > 0.01 {
            let gap = oracle(&shape, &shape::Segment::new(vec2(wall.start), vec2(wall.end)));
            prop_assert!(agree(polygon::overlaps_segment(&a, &wall), gap), "segment, gap {gap}");
        }
    }

    #[test]
    fn stars_overlap_where_samples_of_both_insides_meet(a in arenas::star(), b in arenas::star(), samples in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64, any::<prop::sample::Index>()), 20)) {
        // Points of a: between its centre, which sees all of it, and its outline.
        let inner = samples.iter().map(|(out, along, which)| {
            let edge = which.get(&a.edges()).to_owned();
            a.center + (edge.start + (edge.end - edge.start) * *along - a.center) * (0.999 * out)
        });
        let found = inner.filter(|&p| polygon::contains(&b.corners, p)).count();
        if found > 0 {
            prop_assert!(polygon::overlaps_polygon(&a.corners, &b.corners));
            prop_assert!(polygon::overlaps_polygon(&b.corners, &a.corners));
        }
    }

    #[test]
    fn sizes_as_those_of_parry(points in convex()) {
        use parry2d_f64::shape::Shape as _;
        let mass = parry(&points).mass_properties(1.0);
        prop_assert!((polygon::area(&points) - mass.mass()).abs() < 1e-9);
        let centroid = polygon::centroid(&points).unwrap();
        prop_assert!((vec2(centroid) - mass.local_com).length() < 1e-9);
        prop_assert!((polygon::second_moment(&points) - mass.principal_inertia() / mass.mass()).abs() < 1e-9);
        prop_assert!(polygon::is_convex(&points));
    }

    #[test]
    fn the_index_meets_what_trying_all_meets(arena in arenas::arena(), bodies in prop::collection::vec(arenas::star(), 1..8)) {
        let index = Index::new(arena.segments.clone(), arena.circles.clone());
        let offset = arena.segments.first().map_or(0.0, |segment| segment.start.x);
        for body in bodies {
            let points: Vec<_> = body.corners.iter().map(|p| Point::new(p.x + offset, p.y)).collect();
            let wall = arena.segments.iter().position(|wall: &Segment| polygon::overlaps_segment(&points, wall));
            let pillar = arena.circles.iter().position(|disc: &Circle| polygon::overlaps_circle(&points, disc));
            prop_assert_eq!(index.meets_polygon(&points), wall.map(Shape::Segment).or_else(|| pillar.map(Shape::Circle)));
        }
    }
}
