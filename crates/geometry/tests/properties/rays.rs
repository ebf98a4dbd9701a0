//! Rays do not slip through corners, and they agree with another implementation.

use baudbot_geometry::{Circle, Index, Point, Ray, Segment, Vector, polygon};
use parry2d_f64::math::{Pose, Vec2};
use parry2d_f64::query::RayCast;
use parry2d_f64::shape;
use proptest::prelude::*;

use crate::arenas;

/// More than any ray of these tests runs.
const FAR: f64 = 1e3;

fn parry_ray(ray: &Ray) -> parry2d_f64::query::Ray {
    parry2d_f64::query::Ray::new(vec2(ray.origin), Vec2::new(ray.direction.cos, ray.direction.sin))
}

fn vec2(point: Point) -> Vec2 {
    Vec2::new(point.x, point.y)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// (3.6) and (3.7) let no ray slip through a corner.
    #[test]
    fn from_inside_a_closed_chain_every_ray_hits(
        star in arenas::star(),
        toward_corner in (any::<prop::sample::Index>(), 0.0..0.999_f64),
        direction in arenas::direction(),
    ) {
        let edges = star.edges();
        let (corner, part) = toward_corner;
        let origin = star.center + (*corner.get(&star.corners) - star.center) * part;
        let free = Ray { origin, direction };
        let at_corners = star.corners.iter().map(|&corner| arenas::toward(origin, corner));
        let index = Index::new(edges.clone(), vec![]);
        for ray in at_corners.chain([free]) {
            let by_edge: Vec<_> = edges.iter().filter_map(|edge| ray.hit_segment(edge)).collect();
            prop_assert!(!by_edge.is_empty(), "{:?}", ray);
            prop_assert!(index.cast(&ray, FAR).is_some());
        }
    }

    #[test]
    fn a_corner_is_as_far_away_for_each_of_its_walls(star in arenas::star()) {
        let edges = star.edges();
        for (i, &corner) in star.corners.iter().enumerate() {
            let ray = arenas::toward(star.center, corner);
            let walls = [edges[i], edges[(i + edges.len() - 1) % edges.len()]];
            let hits: Vec<_> = walls.iter().filter_map(|wall| ray.hit_segment(wall)).collect();
            prop_assert!(!hits.is_empty());
            for hit in hits {
                prop_assert!((hit - (corner - star.center).norm()).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn even_from_the_wall_itself(star in arenas::star(), which in any::<prop::sample::Index>(), part in 0.0..1.0_f64, direction in arenas::direction()) {
        let edges = star.edges();
        let wall = which.get(&edges);
        // Rounding puts this point on the wall, or just before or behind it.
        let origin = wall.start + (wall.end - wall.start) * part;
        let ray = Ray { origin, direction };
        prop_assert!(edges.iter().any(|edge| ray.hit_segment(edge).is_some()));
    }

    /// (3.6)–(3.8), beside the routine of others.
    #[test]
    fn segments_agree_with_parry(segment in arenas::segment(), origin in arenas::point(), direction in arenas::direction()) {
        let along = segment.end - segment.start;
        // A blunt crossing away from the ends: elsewhere rounding decides, here as in parry.
        prop_assume!(along.perp(&direction.vector()).abs() > 0.05 * along.norm().max(0.1));
        let ray = Ray { origin, direction };
        let theirs = shape::Segment::new(vec2(segment.start), vec2(segment.end))
            .cast_local_ray(&parry_ray(&ray), FAR, true);
        match (ray.hit_segment(&segment), theirs) {
            (Some(ours), Some(theirs)) => prop_assert!((ours - theirs).abs() < 1e-9, "{ours} {theirs}"),
            (None, None) => {}
            (ours, theirs) => {
                let end = ours.or(theirs).map(|distance| ray.at(distance)).expect("one of them hits");
                let to_end = (end - segment.start).norm().min((end - segment.end).norm());
                prop_assert!(to_end < 1e-9 || segment.distance(origin) < 1e-9, "{ours:?} {theirs:?}");
            }
        }
    }

    #[test]
    fn discs_agree_with_parry(circle in arenas::circle(), origin in arenas::point(), direction in arenas::direction()) {
        prop_assume!(circle.radius > 0.01);
        let ray = Ray { origin, direction };
        let aside = direction.vector().perp(&(circle.center - origin)).abs();
        // Away from touching, and from the rim, where rounding decides.
        prop_assume!((aside - circle.radius).abs() > 1e-3);
        prop_assume!(((origin - circle.center).norm() - circle.radius).abs() > 1e-6);
        let theirs = shape::Ball::new(circle.radius).cast_ray(
            &Pose::translation(circle.center.x, circle.center.y), &parry_ray(&ray), FAR, true);
        match (ray.hit_circle(&circle), theirs) {
            (Some(ours), Some(theirs)) => prop_assert!((ours - theirs).abs() < 1e-9, "{ours} {theirs}"),
            (ours, theirs) => prop_assert_eq!(ours, theirs),
        }
    }

    #[test]
    fn what_a_disc_ray_meets_is_the_rim(circle in arenas::circle(), origin in arenas::point(), direction in arenas::direction()) {
        let ray = Ray { origin, direction };
        if let Some(distance) = ray.hit_circle(&circle) {
            prop_assert!(distance >= 0.0);
            let off_rim = (ray.at(distance) - circle.center).norm() - circle.radius;
            prop_assert!(off_rim.abs() < 1e-12 || (distance == 0.0 && off_rim < 0.0));
        }
    }

    #[test]
    fn stars_are_simple_and_contain_their_center(star in arenas::star()) {
        // With three corners or more at equal angles, no turn about the center reaches half a circle.
        prop_assert!(polygon::is_simple(&star.corners));
        prop_assert!(polygon::contains(&star.corners, star.center));
        prop_assert!(!polygon::contains(&star.corners, star.center + Vector::new(9.0, 0.5)));
    }

    #[test]
    fn shapes_survive_json(circle in arenas::circle(), segment in arenas::segment()) {
        let text = serde_json::to_string(&(circle, segment)).expect("serialises");
        let back: (Circle, Segment) = serde_json::from_str(&text).expect("parses");
        prop_assert!((back.0.center - circle.center).norm() < 1e-12);
        prop_assert!((back.1.end - segment.end).norm() < 1e-12);
    }
}
