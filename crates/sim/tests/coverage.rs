//! The promise of coverage: the cells that it marks are those that trying every cell would mark.

use std::f64::consts::TAU;

use baudbot_geometry::{self as geometry, Circle, Point, Segment};
use baudbot_sim::arena::{Arena, Look, Pillar, Polygon};
use baudbot_sim::coverage::{Coverage, Floor, FloorError};
use proptest::prelude::*;

fn polygon(solid: bool, points: &[(f64, f64)]) -> Polygon {
    Polygon {
        name: String::new(),
        points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(),
        solid,
        closed: true,
        look: Look::WALL,
    }
}

fn rectangle(solid: bool, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> Polygon {
    polygon(solid, &[(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
}

fn pillar(x: f64, y: f64, radius: f64) -> Pillar {
    Pillar { name: String::new(), circle: disc(x, y, radius), look: Look::WALL }
}

fn disc(x: f64, y: f64, radius: f64) -> Circle {
    Circle { center: Point::new(x, y), radius }
}

/// The robot stands just below a wall that the centre of its own cell is above of, as are those of all others but the row
/// below.
#[test]
fn a_robot_whose_cells_centre_is_behind_a_wall_covers_the_floor_on_its_own_side() {
    let room = rectangle(false, (0.0, 0.0), (2.0, 2.0));
    let wall = rectangle(true, (0.0, 1.03), (2.0, 1.04));
    let own = floor(vec![room.clone(), wall.clone()], vec![], 0.1, &[(1.05, 1.02)]);
    let below = floor(vec![room, wall], vec![], 0.1, &[(1.05, 0.55)]);
    assert!(below.free_cells() > 150, "{}", below.free_cells());
    assert_eq!(own.free_cells(), below.free_cells());
}

fn floor(polygons: Vec<Polygon>, pillars: Vec<Pillar>, cell_m: f64, starts: &[(f64, f64)]) -> Floor {
    try_floor(polygons, pillars, cell_m, starts).unwrap()
}

fn try_floor(
    polygons: Vec<Polygon>,
    pillars: Vec<Pillar>,
    cell_m: f64,
    starts: &[(f64, f64)],
) -> Result<Floor, FloorError> {
    let starts: Vec<_> = starts.iter().map(|&(x, y)| Point::new(x, y)).collect();
    Floor::new(&Arena::new(polygons, pillars), cell_m, &starts)
}

/// 4 m by 3 m with the lower left corner at (-1, -1).
fn room() -> Polygon {
    rectangle(false, (-1.0, -1.0), (3.0, 2.0))
}

/// A room that is no rectangle, with a box and a pillar in it.
fn cluttered() -> Floor {
    let outline = polygon(false, &[(0.0, 0.0), (4.1, 0.3), (3.7, 2.9), (1.9, 2.1), (-0.3, 3.3)]);
    let crate_in_it = rectangle(true, (0.9, 0.8), (1.6, 1.3));
    floor(vec![outline, crate_in_it], vec![pillar(2.8, 1.2, 0.31)], 0.07, &[(0.3, 0.3)])
}

fn cells(floor: &Floor) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..floor.rows()).flat_map(|row| (0..floor.columns()).map(move |column| (column, row)))
}

fn covered(floor: &Floor, coverage: &Coverage) -> Vec<(usize, usize)> {
    cells(floor).filter(|&(column, row)| coverage.is_covered(floor, column, row)).collect()
}

fn free_where(floor: &Floor, inside: impl Fn(Point) -> bool) -> Vec<(usize, usize)> {
    cells(floor)
        .filter(|&(column, row)| floor.is_free(column, row) && inside(floor.center(column, row)))
        .collect()
}

#[test]
fn an_empty_room_is_all_free() {
    let floor = floor(vec![room()], vec![], 0.5, &[(0.0, 0.0)]);
    assert_eq!((floor.columns(), floor.rows(), floor.free_cells()), (8, 6, 48));
    assert_eq!(floor.center(0, 0), Point::new(-0.75, -0.75));
    assert!(!floor.is_free(8, 0) && !floor.is_free(0, 6));
}

#[test]
fn a_rounding_of_the_room_makes_no_column_more() {
    let floor = floor(vec![rectangle(false, (0.0, 0.0), (2.1, 0.9))], vec![], 0.3, &[(0.5, 0.1)]);
    assert_eq!((floor.columns(), floor.rows(), floor.free_cells()), (7, 3, 21));
}

#[test]
fn what_is_solid_is_not_free() {
    let obstacle = rectangle(true, (0.0, 0.0), (1.0, 0.5));
    let floor = floor(vec![room(), obstacle], vec![pillar(2.25, 1.25, 0.3)], 0.5, &[(-0.5, -0.5)]);
    assert_eq!(floor.free_cells(), 48 - 2 - 1);
    assert!(!floor.is_free(2, 2) && !floor.is_free(3, 2), "the box");
    assert!(!floor.is_free(6, 4), "the pillar");
}

#[test]
fn a_closed_room_within_the_room_is_not_counted() {
    let closed = rectangle(false, (0.0, 0.0), (1.0, 1.0));
    let outside = floor(vec![room(), closed.clone()], vec![], 0.5, &[(-0.5, -0.5)]);
    assert_eq!(outside.free_cells(), 48 - 4);
    let inside = floor(vec![room(), closed], vec![], 0.5, &[(0.5, 0.5)]);
    assert_eq!(inside.free_cells(), 4);
}

#[test]
fn robots_in_two_rooms_count_both() {
    let rooms = || {
        let left = rectangle(false, (0.0, 0.0), (2.0, 2.0));
        vec![left, rectangle(false, (3.0, 0.0), (4.0, 2.0)), rectangle(false, (5.0, 0.0), (6.0, 2.0))]
    };
    let of = |starts: &[(f64, f64)]| floor(rooms(), vec![], 0.5, starts).free_cells();
    assert_eq!(of(&[(1.0, 1.0)]), 16);
    assert_eq!(of(&[(3.5, 1.0)]), 8);
    assert_eq!(of(&[(1.0, 1.0), (3.5, 1.0)]), 24);
    assert_eq!(of(&[(1.0, 1.0), (3.5, 1.0), (1.5, 0.3)]), 24, "two in one room");
}

#[test]
fn a_thin_wall_with_a_door_parts_nothing_and_one_without_does() {
    let wall = |top: f64| polygon(false, &[(1.13, -1.0), (1.04, top)]);
    let of = |top| floor(vec![room(), wall(top)], vec![], 0.05, &[(0.0, 0.0)]).free_cells();
    assert_eq!(of(1.5), 80 * 60);
    let west = of(2.0);
    assert!((west as f64 * 0.0025 - (2.13 + 2.04) / 2.0 * 3.0).abs() < 0.1, "{west}");
}

#[test]
fn no_path_leaks_through_a_wall_along_the_centres() {
    // Both walls run through the centres of a column, up to a rounding: 0.25 and 0.35 are 2.5 and 3.5 cells.
    for x in [0.25, 0.35] {
        let walls = vec![rectangle(false, (0.0, 0.0), (1.0, 1.0)), polygon(false, &[(x, 0.0), (x, 1.0)])];
        let columns = (x * 10.0 - 0.5).round() as usize;
        for (start, free) in [((0.1, 0.5), columns * 10), ((0.9, 0.5), (9 - columns) * 10)] {
            assert_eq!(floor(walls.clone(), vec![], 0.1, &[start]).free_cells(), free);
        }
        // In the cell that the wall divides: the robot's side is the one that it is on.
        let beside = floor(walls, vec![], 0.1, &[(x + 0.03, 0.5)]);
        assert_eq!(beside.free_cells(), (9 - columns) * 10);
    }
}

#[test]
fn what_is_refused_says_how_to_mend_it() {
    let refused = |polygons, pillars, cell_m| {
        try_floor(polygons, pillars, cell_m, &[(0.0, 0.0)]).unwrap_err().to_string()
    };
    assert_eq!(refused(vec![], vec![], 0.1), "coverage needs an arena with walls");
    assert_eq!(refused(vec![room()], vec![], -1.0), "must be between 0.000001 and 1000000, is -1");
    assert_eq!(refused(vec![room()], vec![], f64::NAN), "must be between 0.000001 and 1000000, is NaN");
    assert_eq!(
        refused(vec![room()], vec![], 0.001),
        "0.001 makes 12000000 cells, the limit is 4000000; 0.0018 would fit"
    );
    assert!(try_floor(vec![room()], vec![], 0.0018, &[(0.0, 0.0)]).is_ok());
    assert_eq!(
        refused(vec![room()], vec![], 50.0),
        "50 makes no cell whose centre a robot can reach from its start; smaller cells might"
    );
    let long = polygon(false, &[(0.0, 0.0), (3.0, 0.0)]);
    assert_eq!(
        refused(vec![long; 100], vec![], 0.000_01),
        "0.00001 makes walls and pillars pass 60000000 cells, the limit is 20000000; 0.00003 would fit"
    );
}

/// Area coverage (§6.1).
#[test]
fn a_disc_covers_the_cells_under_it() {
    let floor = floor(vec![room()], vec![], 0.5, &[(0.0, 0.0)]);
    let mut coverage = Coverage::new(&floor);
    assert_eq!(coverage.floor_fraction(&floor), 0.0);
    coverage.cover_disc(&floor, &disc(0.0, 0.0, 0.36));
    assert_eq!(covered(&floor, &coverage), [(1, 1), (2, 1), (1, 2), (2, 2)]);
    coverage.cover_disc(&floor, &disc(0.25, 0.25, 0.5));
    assert_eq!(coverage.covered_cells(), 4, "centres on the rim are not inside");
    coverage.cover_disc(&floor, &disc(0.25, 0.25, 0.51));
    assert_eq!(coverage.covered_cells(), 6);
    assert_eq!(coverage.floor_fraction(&floor), 6.0 / 48.0);
    assert_eq!(coverage.sensed_fraction(&floor), 0.0);
    coverage.cover_disc(&floor, &disc(0.0, 0.0, f64::INFINITY));
    assert_eq!(coverage.floor_fraction(&floor), 1.0);
}

/// Area coverage (§6.1) between two steps.
#[test]
fn a_fast_robot_leaves_no_gaps() {
    let floor = floor(vec![room()], vec![], 0.5, &[(0.0, 0.0)]);
    let mut coverage = Coverage::new(&floor);
    coverage.cover_swept(&floor, &disc(-0.75, 0.25, 0.3), &disc(2.75, 0.25, 0.3));
    assert_eq!(covered(&floor, &coverage), (0..8).map(|column| (column, 2)).collect::<Vec<_>>());
}

/// Sensory area coverage (§6.1).
#[test]
fn a_ray_senses_up_to_the_wall_and_not_behind_it() {
    let wall = polygon(false, &[(1.0, 0.0), (1.0, 1.0)]);
    let floor = floor(vec![room(), wall], vec![], 0.5, &[(0.0, 0.0)]);
    let mut coverage = Coverage::new(&floor);
    coverage.sense_ray(&floor, Point::new(0.1, 0.2), Point::new(1.0, 0.2));
    let sensed: Vec<_> = cells(&floor).filter(|&(c, r)| coverage.is_sensed(&floor, c, r)).collect();
    assert_eq!(sensed, [(2, 2), (3, 2)]);
    assert_eq!(coverage.sensed_fraction(&floor), 2.0 / 48.0);
    assert_eq!(coverage.covered_cells(), 0);
}

#[test]
fn a_ray_senses_no_cells_that_are_not_free() {
    let floor = floor(vec![room(), rectangle(true, (0.0, 0.0), (1.0, 1.0))], vec![], 0.5, &[(-0.5, -0.5)]);
    let mut coverage = Coverage::new(&floor);
    coverage.sense_ray(&floor, Point::new(-9.0, 0.2), Point::new(9.0, 0.2));
    assert_eq!(coverage.sensed_cells(), 6);
}

#[test]
fn a_snapshot_is_small_and_comes_back() {
    let floor = floor(vec![rectangle(false, (0.0, 0.0), (20.0, 20.0))], vec![], 0.01, &[(1.0, 1.0)]);
    assert_eq!(floor.free_cells(), 4_000_000);
    let mut coverage = Coverage::new(&floor);
    assert!(postcard::to_allocvec(&coverage).unwrap().len() < 16);
    coverage.cover_swept(&floor, &disc(3.0, 3.0, 0.2), &disc(15.0, 11.0, 0.2));
    coverage.sense_ray(&floor, Point::new(3.0, 3.0), Point::new(20.0, 5.0));
    let bytes = postcard::to_allocvec(&coverage).unwrap();
    assert!(bytes.len() < 10_000, "{}", bytes.len());
    let restored: Coverage = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(restored, coverage);
    assert_eq!(restored.covered_cells(), coverage.covered_cells());
}

#[test]
fn nonsense_marks_nothing_and_ends() {
    let floor = cluttered();
    let mut coverage = Coverage::new(&floor);
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e300];
    for (x, y) in odd.into_iter().flat_map(|x| [(x, 1.0), (1.0, x), (x, x)]) {
        coverage.cover_disc(&floor, &disc(x, y, 0.2));
        coverage.cover_swept(&floor, &disc(x, y, 0.2), &disc(x, y, 0.2));
        coverage.sense_ray(&floor, Point::new(x, y), Point::new(y, x));
    }
    coverage.cover_disc(&floor, &disc(1.0, 1.0, f64::NAN));
    coverage.cover_disc(&floor, &disc(1.0, 1.0, -1.0));
    coverage.cover_swept(&floor, &disc(f64::NAN, 1.0, 0.2), &disc(1.0, 1.0, 0.2));
    assert_eq!((coverage.covered_cells(), coverage.sensed_cells()), (0, 0));
}

#[test]
fn a_coverage_of_another_floor_does_no_harm() {
    let (large, small) = (cluttered(), floor(vec![room()], vec![], 1.0, &[(0.0, 0.0)]));
    let mut coverage = Coverage::new(&small);
    coverage.cover_disc(&large, &disc(1.0, 1.0, 9.0));
    coverage.sense_ray(&large, Point::new(0.0, 0.0), Point::new(4.0, 3.0));
    assert!(!coverage.is_covered(&large, 50, 40));
}

/// The length, in metres, of a segment within the cell made larger on each side by `grown` metres.
fn length_within(floor: &Floor, (column, row): (usize, usize), grown: f64, ray: &Segment) -> f64 {
    let (center, half) = (floor.center(column, row), floor.cell_m() / 2.0 + grown);
    let way = ray.end - ray.start;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (low, high) = (center[axis] - half - ray.start[axis], center[axis] + half - ray.start[axis]);
        if way[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return -1.0;
            }
        } else {
            let (a, b) = (low / way[axis], high / way[axis]);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
    }
    (leave - enter) * way.norm()
}

fn point() -> impl Strategy<Value = (f64, f64)> {
    // Places on borders and in centres of cells are as likely as others; some are out of the room.
    let coordinate = || prop_oneof![-0.8..4.5, (-20..130).prop_map(|i| f64::from(i) * 0.035)];
    (coordinate(), coordinate())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_disc_covers_what_trying_every_cell_would((x, y) in point(), radius in 0.0..2.0) {
        let floor = cluttered();
        let mut coverage = Coverage::new(&floor);
        let disc = disc(x, y, radius);
        coverage.cover_disc(&floor, &disc);
        let expected = free_where(&floor, |point| disc.contains(point));
        prop_assert_eq!(coverage.covered_cells(), expected.len());
        prop_assert_eq!(covered(&floor, &coverage), expected);
    }

    #[test]
    fn a_swept_disc_covers_what_trying_every_cell_would(from in point(), to in point(), radius in 0.0..1.0) {
        let floor = cluttered();
        let (before, after) = (disc(from.0, from.1, radius), disc(to.0, to.1, radius));
        let mut swept = Coverage::new(&floor);
        swept.cover_swept(&floor, &before, &after);
        let way = Segment { start: before.center, end: after.center };
        let under = |point| way.distance_squared(point) < radius * radius;
        prop_assert_eq!(covered(&floor, &swept), free_where(&floor, under));
        let all = swept.covered_cells();
        swept.cover_disc(&floor, &before);
        swept.cover_disc(&floor, &after);
        prop_assert_eq!(swept.covered_cells(), all, "its ends are discs");
    }

    #[test]
    fn a_ray_senses_what_trying_every_cell_would(from in point(), to in point()) {
        let floor = cluttered();
        let ray = Segment { start: Point::new(from.0, from.1), end: Point::new(to.0, to.1) };
        let mut coverage = Coverage::new(&floor);
        coverage.sense_ray(&floor, ray.start, ray.end);
        for (column, row) in cells(&floor).filter(|&(column, row)| floor.is_free(column, row)) {
            let sensed = coverage.is_sensed(&floor, column, row);
            let deep = length_within(&floor, (column, row), -1e-9, &ray) > 0.0;
            let near = length_within(&floor, (column, row), 1e-9, &ray) >= 0.0;
            prop_assert!(!deep || sensed, "{column} {row} is crossed");
            prop_assert!(!sensed || near, "{column} {row} is not touched");
        }
        prop_assert!(cells(&floor).all(|(c, r)| floor.is_free(c, r) || !coverage.is_sensed(&floor, c, r)));
    }

    #[test]
    fn fractions_only_grow_and_stay_within_0_and_1(
        moves in prop::collection::vec((point(), 0.0..1.5), 1..30)
    ) {
        let floor = cluttered();
        let mut coverage = Coverage::new(&floor);
        let mut before = disc(1.0, 0.5, 0.2);
        for ((x, y), radius) in moves {
            let (covered, sensed) = (coverage.floor_fraction(&floor), coverage.sensed_fraction(&floor));
            let after = disc(x, y, radius);
            coverage.cover_swept(&floor, &before, &after);
            coverage.sense_ray(&floor, before.center, after.center);
            prop_assert!((covered..=1.0).contains(&coverage.floor_fraction(&floor)));
            prop_assert!((sensed..=1.0).contains(&coverage.sensed_fraction(&floor)));
            before = after;
        }
        let bytes = postcard::to_allocvec(&coverage).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Coverage>(&bytes).unwrap(), coverage);
    }

    /// Whatever the angle between the walls and the grid: free is all that is inside of the room's outline
    /// and outside of the solid in it, and nothing else.
    #[test]
    fn walls_bound_what_is_free(turn in 0.0..6.3, cell_m in 0.03..0.3) {
        let at = |angle: f64, radius: f64| {
            let (sin, cos) = f64::sin_cos(angle + turn);
            (0.3 + radius * cos, 0.2 + radius * sin)
        };
        let hexagon: Vec<_> = (0..6).map(|i| at(f64::from(i) * TAU / 6.0, 1.5)).collect();
        let triangle: Vec<_> = (0..3).map(|i| at(f64::from(i) * TAU / 3.0, 0.5)).collect();
        let walls = vec![polygon(false, &hexagon), polygon(true, &triangle)];
        let floor = floor(walls.clone(), vec![], cell_m, &[at(0.5, 1.0)]);
        let within = |shape: &Polygon, at| geometry::polygon::contains(&shape.points, at);
        let is_on = |shape: &Polygon, at| {
            geometry::polygon::edges(&shape.points).any(|edge| edge.distance(at) < 1e-5 * cell_m)
        };
        for (column, row) in cells(&floor) {
            let center = floor.center(column, row);
            let expected = within(&walls[0], center) && !within(&walls[1], center);
            let free = floor.is_free(column, row);
            prop_assert!(expected || !free, "{column} {row} is behind a wall");
            // In a corner of the hexagon a cell may have no neighbours.
            let corner = (center - Point::new(0.3, 0.2)).norm() > 1.5 - 3.0 * cell_m;
            let on_wall = walls.iter().any(|shape| is_on(shape, center));
            prop_assert!(free || !expected || corner || on_wall, "{column} {row} can be reached");
        }
    }
}

/// The cells of the runs, and the number of cells that they are of.
fn told(floor: &Floor, runs: &[u32]) -> (Vec<(usize, usize)>, usize) {
    let each = runs.iter().enumerate().flat_map(|(i, &run)| std::iter::repeat_n(i % 2 == 1, run as usize));
    let all: Vec<_> = each.collect();
    let present = cells(floor).zip(&all).filter(|(_, present)| **present);
    (present.map(|(cell, _)| cell).collect(), all.len())
}

#[test]
fn runs_tell_every_cell_of_the_grid() {
    let floor = cluttered();
    let mut coverage = Coverage::new(&floor);
    coverage.cover_swept(&floor, &disc(0.3, 0.3, 0.2), &disc(2.0, 0.5, 0.2));
    coverage.sense_ray(&floor, Point::new(0.3, 0.4), Point::new(3.1, 0.6));
    let all = floor.columns() * floor.rows();
    assert!(!all.is_multiple_of(64), "the last word is not full");
    assert_eq!(told(&floor, &floor.free_runs()), (free_where(&floor, |_| true), all));
    assert_eq!(told(&floor, &coverage.covered_runs(&floor)), (covered(&floor, &coverage), all));
    let sensed = cells(&floor).filter(|&(column, row)| coverage.is_sensed(&floor, column, row));
    assert_eq!(told(&floor, &coverage.sensed_runs(&floor)), (sensed.collect(), all));
    assert_eq!(Coverage::new(&floor).covered_runs(&floor), [all as u32]);
    assert_eq!(floor.corner(), Point::new(-0.3, 0.0));
}
