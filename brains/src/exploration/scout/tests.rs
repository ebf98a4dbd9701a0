use super::*;
use crate::test_body::body;

#[test]
fn a_robot_that_does_not_move_takes_something_to_be_near() {
    let mut scout = Scout::new(Parameters::default(), &body(&[("sonar", "sonar", 0.0)]), 4.0);
    scout.command = Command::Drive { to: Point::new(1.0, 0.0) };
    let here = Point::new(0.0, 0.0);
    assert!(!scout.is_stalled(0, here, 1.0));
    assert!(!scout.is_stalled(1_900_000_000, here, 1.0));
    assert!(!scout.is_stalled(2_100_000_000, here, 0.5), "it may only drive half as fast");
    assert!(scout.is_stalled(2_100_000_000, here, 1.0));
    assert!(!scout.is_stalled(2_200_000_000, Point::new(0.1, 0.0), 1.0));
}
