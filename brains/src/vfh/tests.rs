//! A robot whose wheels obey commands at once, with a laser that sees pillars and a room's walls.

use baudbot_brain::{Sweep, Turn};
use baudbot_geometry::{Circle, Segment};

use super::*;
use crate::Chance;
use crate::estimate::Estimate;
use crate::localization::Map;
use crate::process::Beliefs;
use crate::test_body::{body, turn};

const RAYS: usize = 241;
const OPENING_RAD: f64 = 4.18;
const DT_S: f64 = 0.1;

/// A body of 0.2 m with a laser in its middle.
fn robot() -> Body {
    let mut body = body(&[("urg", "laser", 0.0)]);
    body.sensors[0].range_m = Some(4.0);
    body.sensors[0].components[0].count = RAYS;
    body.sensors[0].opening_rad = Some(OPENING_RAD);
    body.sensors[0].sweep = Some(Sweep { duration_ns: 0, clockwise: false });
    body
}

fn made(more: &str) -> Result<Vfh, String> {
    let parameters = toml::from_str(more).map_err(|error| error.message().to_owned())?;
    Vfh::new(parameters, &robot()).map_err(|error| error.to_string())
}

/// A square room of 5 m × 5 m with these pillars.
fn map(pillars: &[(f64, f64, f64)]) -> Map {
    let corners = [(0.0, 0.0), (5.0, 0.0), (5.0, 5.0), (0.0, 5.0)].map(|(x, y)| Point::new(x, y));
    let walls = (0..4).map(|i| Segment { start: corners[i], end: corners[(i + 1) % 4] });
    let disc = |&(x, y, radius): &(f64, f64, f64)| Circle { center: Point::new(x, y), radius };
    Map::new(walls.collect(), pillars.iter().map(disc).collect()).unwrap()
}

fn scan(map: &Map, pose: &Pose) -> Vec<f64> {
    let ray = |i: usize| {
        let kappa = OPENING_RAD * (i as f64 / (RAYS - 1) as f64 - 0.5);
        let direction = Direction::from_angle(pose.heading + kappa);
        let hit = map.index().cast(&baudbot_geometry::Ray { origin: pose.position, direction }, 4.0);
        hit.map_or(-1.0, |hit| hit.distance)
    };
    (0..RAYS).map(ray).collect()
}

fn signals(vfh: &mut Vfh, turn: &Turn, pose: Pose) -> (Signals, Beliefs) {
    let mut beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
    let mut context =
        StepContext { turn, dt_s: DT_S, state: &[], beliefs: &mut beliefs, gammas: &mut Vec::new() };
    let signals = vfh.step(&mut context).expect("signals");
    (signals, beliefs)
}

/// Drives until it has arrived, for two minutes at most: the least room that was beside the body, in metres, and whether it
/// has arrived.
fn drive(vfh: &mut Vfh, map: &Map, mut pose: Pose) -> (f64, bool) {
    let (body, mut room_m) = (robot(), f64::INFINITY);
    for i in 0..1200 {
        let turn = turn(&body, i * 100_000_000, &[Some(&scan(map, &pose))]);
        let (Signals { left, right }, _) = signals(vfh, &turn, pose);
        // The robot goes on with its last command between two scans.
        for _ in 0..10 {
            pose.heading += (right - left) * 0.5 / 0.4 * 0.1 * DT_S;
            pose.position += pose.direction().vector() * ((left + right) * 0.25 * 0.1 * DT_S);
        }
        room_m = room_m.min(map.index().nearest_point(pose.position).map_or(9.0, |(_, m)| m) - 0.2);
        if vfh.has_arrived() {
            return (room_m, true);
        }
    }
    (room_m, false)
}

#[test]
fn it_goes_straight_where_nothing_is_in_the_way_and_round_what_is() {
    let goal = "goals_m = [[4.0, 2.5]]";
    let (room_m, arrived) = drive(&mut made(goal).unwrap(), &map(&[]), Pose::new(1.0, 2.5, 0.0));
    assert!(arrived && room_m > 0.5, "{room_m}");
    let pillar = map(&[(2.5, 2.5, 0.2)]);
    let (room_m, arrived) = drive(&mut made(goal).unwrap(), &pillar, Pose::new(1.0, 2.5, 0.0));
    assert!(arrived && room_m > 0.1, "{room_m}");
}

/// Pillars at random, at least 0.8 m apart, and neither where it starts nor where it goes.
#[test]
fn among_pillars_at_random_it_arrives_and_touches_nothing() {
    for seed in 0..20 {
        let mut chance = Chance::new(seed, "pillars");
        let mut pillars: Vec<(f64, f64, f64)> = Vec::new();
        for _ in 0..60 {
            let (x, y) = (0.8 + 3.4 * chance.uniform(), 0.8 + 3.4 * chance.uniform());
            let far = |(u, v): (f64, f64), least_m: f64| math::hypot(x - u, y - v) > least_m;
            let is_free = far((0.6, 0.6), 0.7) && far((4.4, 4.4), 0.7);
            if is_free && pillars.iter().all(|&(u, v, _)| far((u, v), 1.1)) && pillars.len() < 6 {
                pillars.push((x, y, 0.15));
            }
        }
        let mut vfh = made("goals_m = [[4.4, 4.4]]").unwrap();
        let (room_m, arrived) = drive(&mut vfh, &map(&pillars), Pose::new(0.6, 0.6, 0.0));
        assert!(arrived && room_m > 0.05, "seed {seed}: {arrived} {room_m} {pillars:?}");
    }
}

/// A person comes from the left at 0.5 m/s, across the path. An object of the same size that stands there is passed.
#[test]
fn who_walks_into_its_way_is_waited_for() {
    let last = |walks: bool| {
        let mut vfh = made("goals_m = [[4.4, 2.5]]").unwrap();
        (0..8)
            .map(|i| {
                let y = if walks { 3.35 - 0.05 * f64::from(i) } else { 3.1 };
                let pose = Pose::new(2.0, 2.5, 0.0);
                let seen = scan(&map(&[(2.3, y, 0.15)]), &pose);
                signals(&mut vfh, &turn(&robot(), 100_000_000 * i as u64, &[Some(&seen)]), pose).0
            })
            .last()
            .unwrap()
    };
    let (for_walker, past_post) = (last(true), last(false));
    assert!(for_walker.left + for_walker.right <= 0.0, "{for_walker:?}");
    assert!(past_post.left + past_post.right > 0.5, "{past_post:?}");
}

#[test]
fn who_sees_nothing_stands_still() {
    let (body, mut vfh) = (robot(), made("goals_m = [[4.4, 4.4]]").unwrap());
    let (still, beliefs) = signals(&mut vfh, &turn(&body, 0, &[None]), Pose::new(1.0, 1.0, 0.0));
    assert_eq!((still, beliefs.intention.as_str()), (Signals::default(), "sees nothing"));
    assert!(beliefs.awaited.is_some_and(|awaited| awaited.since_ns == 0), "and says what it waits for");
    let seen = scan(&map(&[]), &Pose::new(1.0, 1.0, 0.8));
    let (moving, _) = signals(&mut vfh, &turn(&body, 0, &[Some(&seen)]), Pose::new(1.0, 1.0, 0.8));
    assert!(moving.left > 0.0);
    let late = turn(&body, 600_000_000, &[None]);
    assert_eq!(signals(&mut vfh, &late, Pose::new(1.0, 1.0, 0.8)).0, Signals::default());
}

#[test]
fn what_makes_no_sense_is_said() {
    let problem = |more: &str| made(&format!("goals_m = [[1, 1]]\n{more}")).unwrap_err();
    assert_eq!(problem("window_m = 0"), "window_m: must be positive, is 0");
    assert_eq!(problem("clearance_m = -1"), "clearance_m: must not be negative, is -1");
    assert_eq!(problem("sectors = 4"), "sectors: must be from 8 to 720, is 4");
    assert_eq!(problem("low = 0.6"), "high: must not be below low, and below 1, is 0.5");
    assert_eq!(problem("high = 1"), "high: must not be below low, and below 1, is 1");
    assert!(problem("cell_m = 0.5").starts_with("cell_m: must be at most half of the body's radius"));
    assert_eq!(
        problem("walker_m_s = 0.1"),
        "walker_m_s: must be 0, or at least 0.2, is 0.1: with cells of `cell_m` anything slower \
         cannot be told from what stands still"
    );
    // A sensor that cannot distinguish walkers allows cells of any size.
    let sonar = body(&[("ping", "sonar", 0.0)]);
    let coarse = toml::from_str("goals_m = [[1, 1]]\ncell_m = 0.17").unwrap();
    assert!(Vfh::new(coarse, &sonar).is_ok());
    assert_eq!(problem("cell_m = 0.001"), "cell_m: must be at least a thousandth of window_m, is 0.001");
}
