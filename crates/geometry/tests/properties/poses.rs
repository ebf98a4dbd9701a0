//! Angles and poses.

use std::f64::consts::{PI, TAU};

use baudbot_geometry::{Direction, Fan, Pose, angle};
use proptest::prelude::*;

use crate::arenas;

fn pose() -> impl Strategy<Value = Pose> {
    (arenas::point(), -PI..PI).prop_map(|(position, heading)| Pose { position, heading })
}

proptest! {
    #[test]
    fn wrap_stays_in_range_and_keeps_the_direction(angle in -1e6..1e6_f64) {
        let wrapped = angle::wrap(angle);
        prop_assert!(-PI < wrapped && wrapped <= PI);
        prop_assert_eq!(angle::wrap(wrapped).to_bits(), wrapped.to_bits());
        let turns = (angle - wrapped) / TAU;
        prop_assert!((turns - turns.round()).abs() < 1e-9);
    }

    #[test]
    fn wrap_is_the_identity_in_range(angle in -PI..PI) {
        prop_assume!(angle > -PI);
        prop_assert_eq!(angle::wrap(angle).to_bits(), angle.to_bits());
    }

    #[test]
    fn difference_leads_from_one_to_the_other(to in -10.0..10.0_f64, from in -10.0..10.0_f64) {
        let turn = angle::difference(to, from);
        prop_assert!(-PI < turn && turn <= PI);
        let there = Direction::from_angle(from).rotate(Direction::from_angle(turn));
        prop_assert!((there.vector() - Direction::from_angle(to).vector()).norm() < 1e-14);
    }

    #[test]
    fn inverse_undoes(world_from_robot in pose(), point in arenas::point()) {
        let back = world_from_robot.inverse().transform(world_from_robot.transform(point));
        prop_assert!((back - point).norm() < 1e-14 * 16.0);
        let still = world_from_robot.compose(&world_from_robot.inverse());
        prop_assert!(still.position.coords.norm() < 1e-14 && still.heading == 0.0);
    }

    #[test]
    fn compose_is_one_transform_after_the_other(a in pose(), b in pose(), point in arenas::point()) {
        let together = a.compose(&b).transform(point);
        prop_assert!((together - a.transform(b.transform(point))).norm() < 1e-13);
    }

    #[test]
    fn composing_is_associative(a in pose(), b in pose(), c in pose()) {
        let (left, right) = (a.compose(&b).compose(&c), a.compose(&b.compose(&c)));
        prop_assert!((left.position - right.position).norm() < 1e-13);
        prop_assert!(angle::difference(left.heading, right.heading).abs() < 1e-14);
    }

    #[test]
    fn fans_open_as_wide_as_asked(opening in 0.0..TAU, rays in 2..40_usize) {
        let fan = Fan::new(opening, rays);
        let kappas = fan.kappas();
        prop_assert!((kappas[rays - 1] - opening / 2.0).abs() < 1e-14);
        prop_assert_eq!(kappas[0], -kappas[rays - 1]);
        prop_assert!(kappas.is_sorted());
    }
}
