//! The behaviour's answers to beliefs; whole explorations are among the whole system's tests.

use baudbot_brain::Body;
use baudbot_geometry::Pose;

use super::*;
use crate::estimate::Estimate;
use crate::odometry::{self, Odometry};
use crate::process::Beliefs;
use crate::test_body::{body, turn};

const RAYS: usize = 101;

fn robot() -> Body {
    let mut body = body(&[("odometer", "odometer", 0.0), ("laser", "laser", 0.0)]);
    body.sensors[1].components[0].count = RAYS;
    body
}

fn made(toml: &str) -> Result<ExploreFloor, String> {
    let parameters = toml::from_str(toml).map_err(|error| error.message().to_owned())?;
    ExploreFloor::new(parameters, &robot()).map_err(|error| error.to_string())
}

/// The behaviour's step at this instant, with a new scan of a round room if `is_seen`, for a robot whose odometry has
/// come to `known_ns`.
fn step(
    explore: &mut ExploreFloor,
    at_ns: u64,
    known_ns: Option<u64>,
    is_seen: bool,
) -> (Option<Signals>, Beliefs) {
    let odometry = known_ns.map(|known_ns| {
        let parameters = odometry::Parameters::of(&robot(), "odometer").unwrap();
        let mut odometry = Odometry::new(parameters, 0, Estimate::exact(Pose::new(2.0, 1.0, 0.3)));
        [0, known_ns].into_iter().for_each(|at_ns| odometry.odometer(at_ns, Pose::new(0.0, 0.0, 0.0)));
        odometry
    });
    let mut beliefs = Beliefs { odometry, ..Beliefs::default() };
    let rays = is_seen.then_some([0.9; RAYS]);
    let turn = turn(&robot(), at_ns, &[None, rays.as_ref().map(<[f64; RAYS]>::as_slice)]);
    let mut context =
        StepContext { turn: &turn, dt_s: 0.1, state: &[], beliefs: &mut beliefs, gammas: &mut Vec::new() };
    let signals = explore.step(&mut context);
    (signals, beliefs)
}

const MS: u64 = 1_000_000;

#[test]
fn it_goes_by_the_believed_pose_once_that_has_come_to_the_end_of_a_scan() {
    let mut explore = made("method = 1").unwrap();
    let (signals, beliefs) = step(&mut explore, 100 * MS, Some(100 * MS), true);
    assert_eq!((signals, beliefs.intention.as_str()), (Some(Signals::default()), "waits for a scan"));
    let (signals, _) = step(&mut explore, 110 * MS, Some(100 * MS), false);
    assert_eq!(signals, None, "nothing is new");
    let (signals, beliefs) = step(&mut explore, 200 * MS, Some(200 * MS), false);
    let signals = signals.unwrap();
    assert!(signals.left == -signals.right && signals.right.abs() > 0.1, "{signals:?}");
    assert_eq!(beliefs.intention, "turns");
    let placed = explore.scan.as_ref().unwrap();
    assert_eq!(placed.world_from_robot(), Pose::new(2.0, 1.0, 0.3));
}

#[test]
fn it_stands_while_nobody_says_where_it_is() {
    let mut explore = made("").unwrap();
    let lost = (Some(Signals::default()), "does not know where it is".to_owned());
    let mut said = |at_ns, known_ns| {
        let (signals, beliefs) = step(&mut explore, at_ns, known_ns, false);
        (signals, beliefs.intention)
    };
    assert_eq!(said(10 * MS, None), lost);
    // A reading that was long on its way counts as one all the same.
    assert_eq!(said(700 * MS, Some(100 * MS)).1, "waits for a scan");
    assert_eq!(said(1200 * MS, Some(100 * MS)).0, None);
    assert_eq!(said(1201 * MS, Some(100 * MS)), lost);
    assert_eq!(said(1210 * MS, Some(1200 * MS)).1, "waits for a scan");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |toml: &str| made(toml).err().unwrap();
    assert_eq!(refused("slam = 1"), "slam: a process of kind `slam` beside this one makes the map");
    assert_eq!(refused("cell_m = 11"), "cell_m: must be from 0 to 10, is 11");
    assert!(refused("metod = 1").contains("unknown field `metod`"), "{}", refused("metod = 1"));
    let blind = body(&[("odometer", "odometer", 0.0)]);
    let refused = ExploreFloor::new(Parameters::default(), &blind).err().unwrap().to_string();
    assert_eq!(refused, "robot `alice` has no sensor of kind `laser` with level rays that sits on its body");
}
