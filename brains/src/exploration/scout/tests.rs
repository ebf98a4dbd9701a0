use super::*;
use crate::test_body::body;

#[test]
fn only_what_is_in_the_way_is_near() {
    let parameters = Parameters::default();
    let feels = |heading: f64, distance_m: f64| {
        let robot_from_sensor = Pose::new(0.2 * heading.cos(), 0.2 * heading.sin(), heading);
        let feeler = Feeler { sensor: 0, robot_from_sensor, is_sonar: true, is_near: false };
        feeler.feels(distance_m, 0.2, &parameters)
    };
    assert!(feels(0.0, 0.16) && !feels(0.0, 0.19));
    assert!(feels(1.0, 0.05) && !feels(1.0, 0.12), "ahead on the left");
    assert!(!feels(1.5, 0.05), "beside it");
}

#[test]
fn a_robot_that_does_not_move_takes_something_to_be_near() {
    let mut scout = Scout::new(Parameters::default(), &body(&[("sonar", "sonar", 0.0)]), 4.0);
    scout.command = Command::Drive { to: Point::new(1.0, 0.0) };
    let here = Point::new(0.0, 0.0);
    assert!(!scout.is_stalled(0, here));
    assert!(!scout.is_stalled(1_900_000_000, here));
    assert!(scout.is_stalled(2_100_000_000, here));
    assert!(!scout.is_stalled(2_200_000_000, Point::new(0.1, 0.0)) || scout.driving_since.is_some());
}
