//! A robot whose wheels obey commands at once, and which knows where it is.

use super::*;
use crate::estimate::Estimate;
use crate::process::Beliefs;
use crate::test_body::{body, turn};

/// A room of 4 m × 3 m without its upper right corner, and a table in it.
const WALLS: [[f64; 4]; 10] = [
    [0.0, 0.0, 4.0, 0.0],
    [4.0, 0.0, 4.0, 1.8],
    [4.0, 1.8, 3.0, 1.8],
    [3.0, 1.8, 3.0, 3.0],
    [3.0, 3.0, 0.0, 3.0],
    [0.0, 3.0, 0.0, 0.0],
    [1.2, 1.0, 2.0, 1.0],
    [2.0, 1.0, 2.0, 1.6],
    [2.0, 1.6, 1.2, 1.6],
    [1.2, 1.6, 1.2, 1.0],
];

fn made(more: &str) -> Result<CoverRows, String> {
    let toml = format!("walls_m = {WALLS:?}\n{more}");
    let parameters = toml::from_str(&toml).map_err(|error| error.message().to_owned())?;
    CoverRows::new(&parameters, &body(&[])).map_err(|error| error.to_string())
}

/// Drives until it has covered all: the places on the way.
fn drive(cover: &mut CoverRows, mut pose: Pose) -> Vec<Point> {
    let (body, mut places) = (body(&[]), Vec::new());
    for i in 0..60_000 {
        let mut beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
        let turn = turn(&body, i * 20_000_000, &[]);
        let mut context = StepContext {
            turn: &turn,
            dt_s: 0.02,
            state: &[],
            beliefs: &mut beliefs,
            gammas: &mut Vec::new(),
        };
        let Signals { left, right } = cover.step(&mut context).expect("signals");
        if cover.has_covered() {
            return places;
        }
        pose.heading += (right - left) * 0.5 / 0.4 * 0.02;
        pose.position += pose.direction().vector() * ((left + right) * 0.25 * 0.02);
        places.push(pose.position);
    }
    panic!("it does not end: at {pose:?}");
}

/// The fraction that it has covered of the points that a body of 0.2 m can cover, and the least room beside it, in
/// metres.
fn covered(cover: &CoverRows, places: &[Point]) -> (f64, f64) {
    let places: Vec<_> = places.iter().step_by(5).copied().collect();
    let grid = cover.floor.grid();
    let free: Vec<_> =
        grid.cells().filter(|&cell| grid.is_free(cell)).map(|cell| grid.center(cell)).collect();
    let points = (0..80).flat_map(|i| {
        (0..60).map(move |j| Point::new(0.025 + 0.05 * f64::from(i), 0.025 + 0.05 * f64::from(j)))
    });
    let is_within = |point: &Point, of: &[Point], m: f64| of.iter().any(|place| (place - point).norm() <= m);
    // The points that a body can cover whose centre keeps to the free cells, without the inside of the table and the
    // outside of the arena.
    let is_table = |p: &Point| (1.2..2.0).contains(&p.x) && (1.0..1.6).contains(&p.y);
    let is_outside = |p: &Point| p.x > 3.0 && p.y > 1.8;
    let is_floor = |p: &Point| !is_table(p) && !is_outside(p);
    let can_be: Vec<_> = points.filter(|point| is_floor(point) && is_within(point, &free, 0.2)).collect();
    let is_covered = can_be.iter().filter(|point| is_within(point, &places, 0.2)).count();
    let wall = |&[x, y, u, v]: &[f64; 4]| baudbot_geometry::Segment {
        start: Point::new(x, y),
        end: Point::new(u, v),
    };
    let walls: Vec<_> = WALLS.iter().map(wall).collect();
    let room = |place: &Point| walls.iter().map(|wall| wall.distance(*place)).fold(f64::INFINITY, f64::min);
    let room_m = places.iter().map(room).fold(f64::INFINITY, f64::min) - 0.2;
    (is_covered as f64 / can_be.len() as f64, room_m)
}

#[test]
fn a_room_with_a_corner_and_a_table_is_covered() {
    let mut cover = made("cell_m = 0.05").unwrap();
    let places = drive(&mut cover, Pose::new(0.5, 0.5, 0.3));
    let (share, room_m) = covered(&cover, &places);
    let length_m: f64 = places.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    // The rest lies beside the walls, between the ends of rows. 10 m² with rows 0.3 m apart are some 34 m.
    assert!(share > 0.95 && room_m > 0.0 && length_m < 45.0, "{share} {room_m} m, {length_m} m");
}

#[test]
fn who_is_on_no_floor_waits_until_it_is_and_who_is_close_to_a_wall_begins_there() {
    let body = body(&[]);
    let step = |cover: &mut CoverRows, at: [f64; 2]| {
        let pose = Some(Estimate::exact(Pose::new(at[0], at[1], 0.0)));
        let mut beliefs = Beliefs { pose, ..Beliefs::default() };
        let (turn, gammas) = (turn(&body, 0, &[]), &mut Vec::new());
        let mut context = StepContext { turn: &turn, dt_s: 0.02, state: &[], beliefs: &mut beliefs, gammas };
        let signals = cover.step(&mut context).expect("signals");
        (signals, beliefs.intention)
    };
    let mut cover = made("cell_m = 0.05").unwrap();
    assert_eq!(step(&mut cover, [9.0, 9.0]), (Signals::default(), "is not on its map".to_owned()));
    assert!(!cover.has_covered());
    let (_, intention) = step(&mut cover, [2.8, 0.5]);
    assert!(intention.ends_with(" regions left"), "{intention}");
    // Half-way it believes to be off the map: it stands, and forgets nothing.
    let left = cover.left.clone();
    let (signals, _) = step(&mut cover, [9.0, 9.0]);
    assert!(signals == Signals::default() && cover.left == left && cover.pursuit.is_some());
    let mut close = made("cell_m = 0.05").unwrap();
    let (_, intention) = step(&mut close, [0.15, 0.5]);
    assert!(intention.ends_with(" regions left") && !close.has_covered(), "{intention}");
}

/// A plan with small cells takes many steps. The robot stands meanwhile, and may be interrupted.
#[test]
fn who_plans_for_many_steps_stands_and_has_not_covered_all() {
    let (body, mut cover) = (body(&[]), made("cell_m = 0.005\nrow_m = 1.0").unwrap());
    let (mut planning, mut interrupted, mut pose) = (0, 0, Pose::new(0.5, 0.5, 0.0));
    for i in 0..60_000_u64 {
        let mut beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
        let (turn, gammas) = (turn(&body, i * 20_000_000, &[]), &mut Vec::new());
        let mut context = StepContext { turn: &turn, dt_s: 0.02, state: &[], beliefs: &mut beliefs, gammas };
        let Signals { left, right } = cover.step(&mut context).expect("signals");
        if context.beliefs.intention.starts_with("plans its path") {
            assert!((left, right) == (0.0, 0.0) && !cover.has_covered());
            planning += 1;
            // Something else drives it elsewhere, now and then.
            if planning % 5 == 2 && interrupted < 3 {
                interrupted += 1;
                pose = Pose::new(0.5 + 0.4 * f64::from(interrupted), 0.5, 1.0);
                cover.enter(&mut context);
            }
        }
        if cover.has_covered() {
            assert!(planning > 10 && interrupted == 3, "{planning} {interrupted}");
            return;
        }
        pose.heading += (right - left) * 0.5 / 0.4 * 0.02;
        pose.position += pose.direction().vector() * ((left + right) * 0.25 * 0.02);
    }
    panic!("it does not end: at {pose:?}");
}

#[test]
fn what_makes_no_sense_is_said() {
    assert_eq!(made("row_m = 0").unwrap_err(), "row_m: must be positive, is 0");
    assert_eq!(made("clearance_m = -0.1").unwrap_err(), "clearance_m: must not be negative, is -0.1");
    assert_eq!(made("cell_m = -0.1").unwrap_err(), "cell_m: must be positive, is -0.1");
}
