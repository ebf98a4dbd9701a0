//! A few rays that are tried with shapes at once meet what they meet one by one, to the last bit.

use std::f64::consts::PI;

use baudbot_geometry::{Fan, Pencil, Ray};
use proptest::prelude::*;

use crate::arenas;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn as_one_by_one(
        arena in arenas::arena(),
        (near, aim) in (arenas::point(), arenas::aim()),
        opening_rad in prop_oneof![0.0..0.1, 0.0..2.0 * PI],
        rays in 1..=Pencil::RAYS,
        // The ray that is aimed: through a corner, along a wall, past a rim.
        aimed in any::<prop::sample::Index>(),
        range in prop_oneof![0.0..8.0_f64, Just(f64::INFINITY), Just(0.5)],
    ) {
        let fan = Fan::new(opening_rad, rays);
        let aimed_ray = arenas::ray(&arena, near, &aim);
        let aside = fan.relative()[aimed.index(rays)].inverse();
        let (origin, forward) = (aimed_ray.origin, aimed_ray.direction.rotate(aside));
        let mut pencil = Pencil::new(origin, forward, fan.relative(), range);
        arena.segments.iter().for_each(|segment| pencil.segment(segment));
        arena.circles.iter().for_each(|circle| pencil.circle(circle));
        for (ray, distance) in fan.rays(origin, forward).zip(pencil.distances()) {
            let expected = nearest(&ray, &arena, range);
            prop_assert_eq!(distance.to_bits(), expected.to_bits(), "{} not {}", distance, expected);
        }
    }
}

fn nearest(ray: &Ray, arena: &arenas::Arena, range: f64) -> f64 {
    let segments = arena.segments.iter().filter_map(|segment| ray.hit_segment(segment));
    let circles = arena.circles.iter().filter_map(|circle| ray.hit_circle(circle));
    segments.chain(circles).filter(|&distance| distance <= range).fold(f64::INFINITY, f64::min)
}
