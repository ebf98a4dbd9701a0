//! A robot whose wheels obey commands at once, and which knows where it is.

use super::*;
use crate::estimate::Estimate;
use crate::process::Beliefs;
use crate::test_body::{body, turn};

/// A room of 4 m × 3 m with a wall from below in its middle, and a box in its upper right corner into which no path leads.
const WALLS: &str = "walls_m = [[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0], [2, 0, 2, 1.8], \
                     [3, 3, 3, 2], [3, 2, 4, 2]]";

fn made(more: &str) -> Result<FollowPath, String> {
    let table: toml::Table = toml::from_str(&format!("{WALLS}\n{more}")).expect("it is TOML");
    let parameters = baudbot_fields::read(table).map_err(|error| error.to_string())?;
    FollowPath::new(&parameters, &body(&[])).map_err(|error| error.to_string())
}

/// One step at this pose: the wheels' speeds, in metres a second, and the stated intention.
fn step(follow: &mut FollowPath, pose: Pose, at_ns: u64) -> ([f64; 2], Beliefs) {
    let mut beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
    let turn = turn(&body(&[]), at_ns, &[]);
    let (mut gammas, state) = (Vec::new(), []);
    let mut context =
        StepContext { turn: &turn, dt_s: DT_S, state: &state, beliefs: &mut beliefs, gammas: &mut gammas };
    let Signals { left, right } = follow.step(&mut context).expect("signals");
    ([left * 0.5, right * 0.5], beliefs)
}

/// Drives for so many seconds at most: the places on the way, and where it was set down after two of them.
fn drive(follow: &mut FollowPath, mut pose: Pose, moved_to: Option<Point>) -> Vec<Point> {
    let mut places = vec![pose.position];
    for i in 0..3000 {
        if let Some(place) = moved_to.filter(|_| i == 100) {
            pose.position = place;
        }
        let ([left, right], _) = step(follow, pose, i * 20_000_000);
        if follow.has_arrived() {
            break;
        }
        pose.heading += (right - left) / 0.4 * DT_S;
        pose.position += pose.direction().vector() * ((left + right) / 2.0 * DT_S);
        places.push(pose.position);
    }
    places
}

const DT_S: f64 = 0.02;

/// The least distance of places from the walls, in metres.
fn nearest_m(follow: &FollowPath, places: &[Point]) -> f64 {
    let walls: [([f64; 2], [f64; 2]); 3] =
        [([2.0, 0.0], [2.0, 1.8]), ([3.0, 3.0], [3.0, 2.0]), ([0.0, 0.0], [4.0, 0.0])];
    assert!(follow.has_arrived(), "at {:?}", places.last());
    let distance = |place: &Point| {
        walls.map(|([x, y], [u, v])| {
            let (start, end) = (Point::new(x, y), Point::new(u, v));
            baudbot_geometry::Segment { start, end }.distance(*place)
        })
    };
    places.iter().flat_map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn it_goes_round_a_wall_and_keeps_the_clearance() {
    for method in ["theta_star", "convex_cells"] {
        let mut follow = made(&format!("goals_m = [[3.5, 0.5]]\nmethod = \"{method}\"")).unwrap();
        let places = drive(&mut follow, Pose::new(0.5, 0.5, 0.0), None);
        let length: f64 = places.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        let nearest = nearest_m(&follow, &places);
        // The body has 0.2 m, and 0.1 m is the default clearance, of which a bend may take some.
        assert!(length < 4.9 && nearest > 0.24, "{method}: {length} m, {nearest} m");
    }
}

#[test]
fn who_is_set_down_elsewhere_plans_anew() {
    let mut follow = made("goals_m = [[3.5, 0.5]]").unwrap();
    let places = drive(&mut follow, Pose::new(0.5, 0.5, 0.0), Some(Point::new(0.5, 2.6)));
    let nearest = nearest_m(&follow, &places[102..]);
    assert!(nearest > 0.24, "{nearest}");
}

#[test]
fn goals_are_visited_in_turn_and_the_way_is_shown() {
    let mut follow = made("goals_m = [[1.0, 2.5], [3.5, 0.5]]").unwrap();
    let (_, beliefs) = step(&mut follow, Pose::new(0.5, 0.5, 0.0), 0);
    assert_eq!(beliefs.path.last(), Some(&Point::new(1.0, 2.5)));
    let places = drive(&mut follow, Pose::new(0.5, 0.5, 0.0), None);
    let nearest_to_first =
        places.iter().map(|place| (place - Point::new(1.0, 2.5)).norm()).fold(9.0, f64::min);
    assert!(follow.has_arrived() && nearest_to_first <= 0.05, "{nearest_to_first}");
    let (signals, beliefs) = step(&mut follow, Pose::new(3.5, 0.5, 0.0), 0);
    assert_eq!((signals, beliefs.intention.as_str()), ([0.0, 0.0], "has arrived"));
}

#[test]
fn the_way_to_a_next_goal_is_known_and_one_from_elsewhere_is_planned_in_parts() {
    let goals = "goals_m = [[0.5, 0.5], [3.5, 0.5], [0.5, 1.0]]\ncell_m = 0.01\nstray_m = 0.1";
    let mut follow = made(goals).unwrap();
    let (_, beliefs) = step(&mut follow, Pose::new(0.5, 0.51, 0.0), 0);
    assert_eq!((beliefs.path.last(), beliefs.path.len() > 2), (Some(&Point::new(3.5, 0.5)), true));
    // A robot that is pushed away stands for some steps, and states the reason.
    let pushed = Pose::new(1.4, 0.6, 0.0);
    let planning = (1..200).take_while(|i| {
        let ([left, right], beliefs) = step(&mut follow, pushed, i * 20_000_000);
        let is_planning = beliefs.intention == "plans its path" && beliefs.path.is_empty();
        assert!(!is_planning || (left, right) == (0.0, 0.0));
        is_planning
    });
    let steps = planning.count();
    assert!((2..100).contains(&steps), "{steps}");
    let (_, beliefs) = step(&mut follow, pushed, 9_000_000_000);
    assert_eq!(beliefs.path.first(), Some(&pushed.position));
}

#[test]
fn a_goal_to_which_no_way_leads_is_named() {
    let problem = |more: &str| made(more).unwrap_err();
    assert_eq!(
        problem("goals_m = [[0.5, 0.5], [1.9, 0.5]]"),
        "goals_m[1]: (1.9 m, 0.5 m) is outside the map, or closer to a wall than the body's radius and \
         `clearance_m` allow"
    );
    assert_eq!(
        problem("goals_m = [[0.5, 0.5], [3.5, 2.5]]"),
        "goals_m[1]: no path leads to (3.5 m, 2.5 m) from (0.5 m, 0.5 m), with the body's radius and `clearance_m` \
         on both sides"
    );
    assert_eq!(problem("goals_m = []"), "goals_m: has no point");
    assert_eq!(problem("goals_m = [[1, 1]]\nlook_ahead_m = 0"), "look_ahead_m: must be positive, is 0");
    assert_eq!(problem("goals_m = [[1, 1]]\nclearance_m = -1"), "clearance_m: must not be negative, is -1");
    assert!(problem("goals_m = [[1, 1]]\nmethod = \"magic\"").contains("is `magic`"));
    // Only the robot can notice a fault of the first goal; it then stands, and states the reason.
    let mut follow = made("goals_m = [[3.5, 2.5]]").unwrap();
    let said: Vec<_> = (0..20)
        .map(|_| {
            let (signals, beliefs) = step(&mut follow, Pose::new(0.5, 0.5, 0.0), 0);
            assert_eq!(signals, [0.0, 0.0]);
            beliefs.intention
        })
        .collect();
    assert_eq!(said[0], "plans its path");
    assert_eq!(said[19], "goals_m[0]: no path leads there from (0.50 m, 0.50 m)");
}
