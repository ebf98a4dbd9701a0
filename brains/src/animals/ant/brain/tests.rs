//! The robot on a plain with pillars, without dynamics or delays.

use std::f64::consts::{PI, TAU};

use baudbot_geometry::{Point as Place, Pose};

use super::*;
use crate::test_body::{body, turn};

const PILLARS: [(f64, f64); 5] = [(1.4, 0.5), (-0.2, 1.5), (-1.5, 0.3), (-0.7, -1.2), (0.9, -1.1)];
const RAYS: usize = 721;
const STEP_NS: u64 = 50_000_000;

/// A scan from a pose: the pillars are discs of 8 cm.
fn scan(pose: &Pose) -> Vec<f64> {
    let ray = |i: usize| {
        let bearing_rad = i as f64 * TAU / (RAYS - 1) as f64 - PI;
        let along = Direction::from_angle(pose.heading + bearing_rad).vector();
        let meets = |&(x, y): &(f64, f64)| {
            let to = Place::new(x, y) - pose.position;
            let (ahead, aside) = (along.dot(&to), along.x * to.y - along.y * to.x);
            (ahead > 0.0 && aside.abs() < 0.08).then(|| ahead - math::sqrt(0.0064 - aside * aside))
        };
        PILLARS
            .iter()
            .filter_map(meets)
            .fold(-1.0, |least: f64, d| if least < 0.0 { d } else { least.min(d) })
    };
    (0..RAYS).map(ray).collect()
}

/// A run of so many seconds, with a compass that drifts as far as this: where it is when it begins to search, and at its end.
fn run(seed: u64, drift_rad: f64, seconds: u64) -> (Option<Pose>, Pose, AntBrain) {
    let mut body = body(&[("eye", "laser", 0.0), ("odometer", "odometer", 0.0), ("sky", "compass", 0.0)]);
    body.sensors[0].range_m = Some(4.0);
    body.sensors[0].opening_rad = Some(TAU);
    let parameters = Parameters { forage_s: 40.0, ..Parameters::default() };
    let mut brain = AntBrain::new(parameters, Chance::new(seed, "alice/ant"), &body).unwrap();
    let (mut pose, mut search) = (Pose::new(0.0, 0.0, 0.3), None);
    let (mut signals, dt_s) = (Default::default(), STEP_NS as f64 * 1e-9);
    for step in 0..seconds * 1_000_000_000 / STEP_NS {
        let sky = angle::wrap(pose.heading + drift_rad * math::sin(step as f64 * dt_s / 8.0));
        let odometer = [pose.position.x, pose.position.y, pose.heading];
        let (scan, sky) = (scan(&pose), [sky]);
        let readings = [&scan[..], &odometer[..], &sky[..]].map(Some);
        signals = brain.step(&turn(&body, step * STEP_NS, &readings)).signals.unwrap_or(signals);
        let baudbot_brain::Signals { left, right } = signals;
        let (left, right) = (left * 0.5, right * 0.5);
        let displacement = Place::new(0.5 * (left + right) * dt_s, 0.0);
        pose = pose.compose(&Pose { position: displacement, heading: (right - left) / 0.4 * dt_s });
        if brain.phase() == Phase::Search {
            search.get_or_insert(pose);
        }
    }
    (search, pose, brain)
}

#[test]
fn it_goes_out_and_comes_home_by_vector_and_snapshot() {
    for seed in 0..6 {
        let (search, end, brain) = run(seed, 0.0, 120);
        assert_eq!(brain.phase(), Phase::Home, "{seed}");
        assert!(search.unwrap().position.coords.norm() < 0.2, "{seed}: {search:?}");
        assert!(end.position.coords.norm() < 0.15, "{seed}: {end:?}");
    }
}

#[test]
fn where_the_vector_is_wrong_the_snapshot_leads_home() {
    let (mut vector_m, mut home_m) = (0.0, 0.0);
    for seed in 0..6 {
        let (search, end, brain) = run(seed, 0.35, 140);
        assert_eq!(brain.phase(), Phase::Home, "{seed}");
        vector_m += search.unwrap().position.coords.norm() / 6.0;
        home_m += end.position.coords.norm() / 6.0;
    }
    assert!(home_m < 0.5 * vector_m && vector_m > 0.2, "{home_m} instead of {vector_m}");
}

#[test]
fn it_waits_until_all_its_senses_have_spoken() {
    let body = body(&[("eye", "laser", 0.0), ("odometer", "odometer", 0.0)]);
    let mut brain = AntBrain::new(Parameters::default(), Chance::new(1, "alice/ant"), &body).unwrap();
    let odometer: &[f64] = &[1.0, 2.0, 0.0];
    assert_eq!(brain.step(&turn(&body, 0, &[None, Some(odometer)])), Action::drive(0.0, 0.0));
    assert_eq!(brain.belief(), None);
    brain.step(&turn(&body, 200_000_000, &[Some(&[-1.0, 0.5, -1.0]), Some(odometer)]));
    let belief = brain.belief().unwrap();
    assert_eq!((belief.state.as_str(), belief.pose.unwrap().x_m), ("forage", 1.0));
}

#[test]
fn without_a_laser_or_an_odometer_there_is_no_such_brain() {
    let make = |sensors: &[_]| AntBrain::new(Parameters::default(), Chance::new(1, ""), &body(sensors));
    assert_eq!(make(&[("eye", "laser", 0.0)]), None);
    assert_eq!(make(&[("odometer", "odometer", 0.0)]), None);
}
