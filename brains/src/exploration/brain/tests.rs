//! The brain's answers to readings, one turn after the other.

use super::super::Command;
use super::*;
use crate::test_body::{body, turn};

const SENSORS: [(&str, &str, f64); 3] =
    [("odometer", "odometer", 0.0), ("laser", "laser", 0.0), ("sonar", "sonar", 0.0)];

const RAYS: usize = 101;

/// A brain that gets readings of odometer, laser and sonar every 0.1 s.
struct Robot {
    brain: Explore,
    body: Body,
    at_ns: u64,
}

impl Robot {
    fn new(method: f64) -> Self {
        let mut body = body(&SENSORS);
        body.sensors[1].components[0].count = RAYS;
        let parameters = Parameters { method, ..Parameters::default() };
        Self { brain: Explore::new(parameters, &body).unwrap(), body, at_ns: 0 }
    }

    fn step(&mut self, pose: [f64; 3], rays: Option<f64>, sonar_m: f64) -> Signals {
        self.at_ns += 100_000_000;
        let rays = rays.map(|distance_m| vec![distance_m; RAYS]);
        let readings = [Some(pose.as_slice()), rays.as_deref(), Some(&[sonar_m])];
        self.brain.step(&turn(&self.body, self.at_ns, &readings)).signals.unwrap()
    }
}

#[test]
fn it_stands_until_it_has_a_scan_and_then_turns_to_look_behind() {
    for method in [0.0, 1.0] {
        let mut robot = Robot::new(method);
        assert_eq!(robot.step([0.0, 0.0, 0.0], None, 1.0), Signals { left: 0.0, right: 0.0 });
        let signals = robot.step([0.0, 0.0, 0.0], Some(0.9), 1.0);
        assert_eq!(signals, Signals { left: 0.0, right: 0.0 }, "it has only begun");
        let signals = robot.step([0.0, 0.0, 0.0], None, 1.0);
        assert_eq!(signals.left, -signals.right, "on the spot: {:?}", robot.brain.command());
        assert!(signals.right.abs() > 0.1, "{signals:?}");
    }
}

#[test]
fn it_asks_for_no_more_than_motors_take() {
    let mut robot = Robot::new(1.0);
    robot.body.signal_limit = Some(1.0);
    let parameters =
        Parameters { method: 1.0, turn_rate_rad_s: 10.0, full_speed_m_s: 0.01, ..Parameters::default() };
    robot.brain = Explore::new(parameters, &robot.body).unwrap();
    robot.step([0.0, 0.0, 0.0], None, 1.0);
    robot.step([0.0, 0.0, 0.0], Some(0.9), 1.0);
    let signals = robot.step([0.0, 0.0, 0.0], None, 1.0);
    assert_eq!(signals.left, -signals.right);
    assert!((0.99..=1.0).contains(&signals.left.abs()), "as fast as it can: {signals:?}");
}

/// A scan waits until the odometer has come to the end of its sweep, and gets the pose of that instant.
#[test]
fn a_scan_goes_with_the_pose_of_the_end_of_its_sweep() {
    let mut robot = Robot::new(0.0);
    robot.step([0.0, 0.0, 0.0], None, 1.0);
    robot.step([0.0, 0.0, 0.1], Some(0.5), 1.0);
    assert_eq!(robot.brain.scan, None, "it has only begun");
    robot.step([0.0, 0.0, 0.2], None, 1.0);
    let placed = robot.brain.scan.as_ref().unwrap();
    assert!((placed.world_from_robot().heading - 0.1665).abs() < 1e-9, "{placed:?}");
    let known: Vec<_> = placed.scan().distances_m.iter().filter(|distance_m| !distance_m.is_nan()).collect();
    assert!(known.len() > 95 && known.iter().all(|distance_m| (**distance_m - 0.5).abs() < 1e-9));
}

#[test]
fn it_stands_still_when_the_odometer_is_silent() {
    let mut robot = Robot::new(0.0);
    robot.step([0.0, 0.0, 0.0], Some(3.0), 1.0);
    robot.at_ns += 1_000_000_000;
    let action = robot.brain.step(&turn(&robot.body, robot.at_ns, &[None, None, None]));
    assert_eq!(action.signals, Some(Signals { left: 0.0, right: 0.0 }));
    assert_eq!(robot.brain.belief().unwrap().state, "waits for `odometer` since 0.10 s");
}

#[test]
fn it_says_which_sensor_it_waits_for() {
    let mut robot = Robot::new(0.0);
    let says = |robot: &mut Robot| robot.brain.belief().unwrap().state;
    assert_eq!(says(&mut robot), "waits for `odometer` since 0.00 s");
    robot.step([0.0, 0.0, 0.0], None, 1.0);
    assert_eq!(says(&mut robot), "waits for `laser` since 0.00 s");
    robot.step([0.0, 0.0, 0.0], Some(0.9), 1.0);
    assert_eq!(
        says(&mut robot),
        "waits for `odometer` since 0.20 s",
        "until it knows where the scan was taken"
    );
    robot.step([0.0, 0.0, 0.0], None, 1.0);
    let Command::Turn { heading_rad } = robot.brain.command() else { panic!("{}", says(&mut robot)) };
    for _ in 0..3 {
        robot.step([0.0, 0.0, heading_rad], None, 1.0);
    }
    assert_eq!(says(&mut robot), "waits for `laser` since 0.20 s", "which has fallen silent");
}

#[test]
fn it_needs_a_laser_and_an_odometer() {
    assert!(Explore::new(Parameters::default(), &body(&SENSORS[..1])).is_none());
    assert!(Explore::new(Parameters::default(), &body(&SENSORS[1..])).is_none());
    assert!(Explore::new(Parameters::default(), &body(&SENSORS[..2])).is_some());
}
