//! Whole journeys of ants whose compass and steps are not exact.

use baudbot_geometry::{Point, Pose};

use super::*;

const DT_S: f64 = 0.05;
const LANDMARKS: [(f64, f64); 3] = [(1.1, 0.3), (-0.7, 0.9), (-0.2, -1.2)];

/// The course of a journey.
struct Journey {
    /// Length of the way out, and distance of its end from the nest.
    out_m: f64,
    away_m: f64,
    /// Length of the way back by the vector, and how far from the nest it ended.
    return_m: f64,
    missed_m: f64,
    /// The ant's last position, once its activity is to be at home.
    home: Option<Point>,
}

/// The journey of an ant that finds food after a minute and sees its nest from `sight_m`, and whose compass turns
/// with the sun.
fn journey(seed: u64, landmarks: &[(f64, f64)], sight_m: f64, drift_rad_s: f64) -> Journey {
    let (mut ant, mut noise) =
        (Ant::new(Parameters::default(), Chance::new(seed, "ant")), Chance::new(seed, "noise"));
    let mut pose = Pose::new(0.0, 0.0, 0.0);
    let mut distance_m = 0.0;
    let mut journey = Journey { out_m: 0.0, away_m: 0.0, return_m: 0.0, missed_m: 0.0, home: None };
    for step in 0..40_000 {
        let robot_from_world = pose.inverse();
        let bearing = |&(x, y): &(f64, f64)| {
            let seen = robot_from_world.transform(Point::new(x, y));
            math::atan2(seen.y, seen.x)
        };
        // Landmarks are seen from nearby only.
        let near = pose.position.coords.norm() < 1.0;
        let bearings: Vec<_> = landmarks.iter().filter(|_| near).map(bearing).collect();
        let sensed = Sensed {
            distance_m: distance_m * (1.0 + 0.02 * noise.normal()),
            heading_rad: pose.heading + drift_rad_s * f64::from(step) * DT_S + 0.1 * noise.normal(),
            landmarks_rad: &bearings,
            food: step > 1200,
            nest: pose.position.coords.norm() < sight_m,
        };
        let motion = ant.step(&sensed, DT_S);
        distance_m = motion.speed_m_s * DT_S;
        match ant.phase() {
            Phase::Forage => {
                journey.out_m += distance_m;
                journey.away_m = pose.position.coords.norm();
            }
            Phase::Return => {
                journey.return_m += distance_m;
                journey.missed_m = pose.position.coords.norm();
            }
            Phase::Search => {}
            Phase::Home => {
                journey.home = Some(pose.position);
                break;
            }
        }
        let ahead = Pose::new(distance_m, 0.0, motion.turn_rate_rad_s * DT_S);
        pose = pose.compose(&ahead);
    }
    journey
}

/// The desert ant's way (§4.4.4, Fig. 4.3).
#[test]
fn the_way_out_winds_and_the_way_home_is_straight_as_in_figure_4_3() {
    for seed in 0..20 {
        let Journey { out_m, away_m, return_m, .. } = journey(seed, &[], 0.15, 0.0);
        assert!(out_m > 2.0 * away_m, "{seed}: {out_m} {away_m}");
        assert!(return_m < 1.2 * away_m + 0.2, "{seed}: {return_m} {away_m}");
    }
}

#[test]
fn the_vector_ends_near_the_nest() {
    for seed in 0..20 {
        let Journey { missed_m, .. } = journey(seed, &[], 0.15, 0.0);
        assert!(missed_m < 0.25, "{seed}: {missed_m}");
    }
}

#[test]
fn where_the_vector_does_not_end_at_the_nest_the_search_finds_it() {
    let mut missed = 0;
    for seed in 0..20 {
        let Journey { missed_m, home, .. } = journey(seed, &[], 0.15, 0.004);
        missed += i32::from(missed_m > 0.3);
        assert!(home.is_some_and(|place| place.coords.norm() < 0.15), "{seed}: {home:?}");
    }
    assert!(missed >= 10, "only {missed} had to search");
}

#[test]
fn landmarks_lead_to_a_nest_that_is_not_seen() {
    for seed in 0..20 {
        let Journey { home, .. } = journey(seed, &LANDMARKS, 0.0, 0.0);
        assert!(home.is_some_and(|place| place.coords.norm() < 0.1), "{seed}: {home:?}");
    }
}
