//! Routes on known maps, and on random ones against a search of all ways through the same doors.

use baudbot_geometry::Vector;
use proptest::prelude::*;

use super::*;
use crate::planning::{Moves, Sketch, dijkstra, theta_star};

fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Points every centimetre or less along a path.
fn along(points: &[Point]) -> impl Iterator<Item = Point> {
    points.windows(2).flat_map(|pair| {
        let steps = ((pair[1] - pair[0]).norm() / 0.01).ceil().max(1.0);
        (0..=steps as usize).map(move |i| pair[0] + (pair[1] - pair[0]) * (i as f64 / steps))
    })
}

/// Checks the properties that all routes have.
fn check(cells: &CellGrid, route: &Route, start: Point, target: Point) {
    for path in [&route.points, &route.by_centers] {
        assert_eq!((path[0], path[path.len() - 1]), (start, target));
        for point in along(path) {
            let nearest = route.cells.iter().map(|&cell| cells.cells()[cell].distance(point));
            assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9, "{point} is not free");
        }
    }
    assert!(route.length_m <= length(&route.by_centers) + 1e-9);
    assert!((route.length_m - length(&route.points)).abs() < 1e-12);
}

/// The office: 12 m by 9 m, walls with doors, two boxes.
fn office() -> Vec<Segment> {
    let walls = [
        [4.5, 0.0, 4.5, 1.4],
        [4.5, 2.6, 4.5, 6.6],
        [4.5, 7.8, 4.5, 9.0],
        [8.0, 0.0, 8.0, 1.4],
        [8.0, 2.6, 8.0, 6.2],
        [8.0, 7.4, 8.0, 9.0],
        [4.5, 4.5, 5.6, 4.5],
        [6.8, 4.5, 8.0, 4.5],
    ];
    let boxes = [[0.0, 0.0, 12.0, 9.0], [10.0, 3.5, 11.0, 4.5], [1.0, 5.0, 1.8, 6.5]];
    let sides = boxes.into_iter().flat_map(|[x0, y0, x1, y1]| {
        [[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]]
    });
    let segment = |[x0, y0, x1, y1]: [f64; 4]| Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) };
    walls.into_iter().chain(sides).map(segment).collect()
}

/// The distance between two segments that do not cross.
fn gap(a: &Segment, b: &Segment) -> f64 {
    [a.distance(b.start), a.distance(b.end), b.distance(a.start), b.distance(a.end)]
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_robot_that_follows_a_route_through_an_office_touches_nothing() {
    let (walls, clearance_m) = (office(), 0.25);
    let cells = CellGrid::new(Grid::from_segments(&walls, 0.05, clearance_m).unwrap());
    assert!(cells.cells().len() < 60, "{} cells", cells.cells().len());
    let places = [(1.0, 1.0), (2.5, 8.0), (6.2, 3.0), (6.2, 8.0), (9.0, 1.0), (11.5, 8.2), (0.5, 5.7)];
    let places = places.map(|(x, y)| Point::new(x, y));
    for (i, &start) in places.iter().enumerate() {
        for &target in &places[i + 1..] {
            let route = cells.route(start, target).unwrap();
            check(&cells, &route, start, target);
            for leg in route.points.windows(2).map(|pair| Segment { start: pair[0], end: pair[1] }) {
                let nearest = walls.iter().filter(|wall| !wall.touches(&leg)).map(|wall| gap(wall, &leg));
                assert_eq!(nearest.clone().count(), walls.len(), "{leg:?} runs through a wall");
                assert!(nearest.fold(f64::INFINITY, f64::min) > clearance_m - 1e-6, "{leg:?}");
            }
        }
    }
}

#[test]
fn routes_are_about_as_short_as_theta_stars() {
    let grid = Grid::from_segments(&office(), 0.05, 0.25).unwrap();
    let cells = CellGrid::new(grid.clone());
    let free: Vec<_> = grid.cells().filter(|&cell| grid.is_free(cell)).collect();
    let mut tasks = 0;
    for i in 0..60 {
        let (start, target) = (free[i * 7919 % free.len()], free[(i * 104_729 + 5000) % free.len()]);
        // Cells within the boxes are free, and no path leads to them.
        let Ok(theta) = theta_star(&grid, start, target) else { continue };
        let route = cells.route(grid.center(start), grid.center(target)).unwrap();
        assert!(route.length_m < 1.01 * theta.length_m, "{} {}", route.length_m, theta.length_m);
        tasks += 1;
    }
    assert!(tasks > 30, "{tasks}");
}

/// Theta* goes from cell centre to cell centre, and a route from corner to corner, so it is shorter here. In the
/// empty grid both are the straight line.
#[test]
fn lengths_on_three_grids() {
    let shortest = |dx: f64, dy: f64| dx.hypot(dy);
    let figures = [
        (include_str!("../../../tests/data/grid-empty.txt"), shortest(15.0, 12.0), 1),
        // Below the wall: to its corner (10, 17), on to (11, 17), and to the target.
        (include_str!("../../../tests/data/grid-wall.txt"), shortest(7.5, 6.5) + 1.0 + shortest(6.5, 6.5), 4),
        // Above or below the trap, whose corners are (6, 5) and (13, 5) or (6, 15) and (13, 15).
        (include_str!("../../../tests/data/grid-trap.txt"), shortest(3.5, 4.5) + 7.0 + shortest(4.5, 4.5), 5),
    ];
    for (text, length_m, count) in figures {
        let Sketch { grid, start, target } = Grid::from_text(text).unwrap();
        let (start, target) = (grid.center(start.unwrap()), grid.center(target.unwrap()));
        let cells = CellGrid::new(grid);
        let route = cells.route(start, target).unwrap();
        check(&cells, &route, start, target);
        assert!((route.length_m - length_m).abs() < 1e-9, "{} {length_m}", route.length_m);
        assert_eq!(cells.cells().len(), count);
    }
}

/// The cells of Fig. 6.6 are convex.
#[test]
fn within_a_cell_the_way_is_straight() {
    let cells = CellGrid::new(Grid::new(40, 30, 0.1, Point::new(-1.0, -1.0)).unwrap());
    let (start, target) = (Point::new(-0.9, -0.7), Point::new(2.3, 1.1));
    let route = cells.route(start, target).unwrap();
    assert_eq!((route.cells, route.points), (vec![0], vec![start, target]));
    assert_eq!(cells.cell_at(Point::new(9.0, 0.0)), None);
}

#[test]
fn ends_that_are_blocked_outside_or_apart_are_errors() {
    let cells = CellGrid::new(Grid::from_text(".#.").unwrap().grid);
    let route = |x0, x1| {
        let error = cells.route(Point::new(x0, 0.5), Point::new(x1, 0.5)).unwrap_err();
        error.to_string()
    };
    assert_eq!(route(1.5, 0.5), "the start is in the blocked cell (1, 0)");
    assert_eq!(route(0.5, 1.5), "the target is in the blocked cell (1, 0)");
    assert_eq!(route(0.5, 7.0), "the target (7 m, 0.5 m) is outside the map");
    assert_eq!(route(0.5, 2.5), "no path leads from cell (0, 0) to cell (2, 0)");
}

/// The length of the shortest path through these doors in order, by trying all their ends as corners.
fn shortest(start: Point, doors: &[Segment], target: Point) -> f64 {
    let mut corners = vec![(0, start, 0.0_f64)];
    for (i, door) in doors.iter().chain([&Segment { start: target, end: target }]).enumerate() {
        for end in [door.start, door.end] {
            let free = |&&(after, from, _): &&(usize, Point, f64)| {
                let line = Segment { start: from, end };
                doors.get(after..i).is_some_and(|between| between.iter().all(|door| door.touches(&line)))
            };
            let reached = corners.iter().filter(free).map(|(_, from, length)| length + (end - from).norm());
            let best = reached.fold(f64::INFINITY, f64::min);
            corners.push((i + 1, end, best));
        }
    }
    corners[corners.len() - 1].2
}

proptest! {
    #[test]
    fn routes_exist_where_ways_do_and_are_the_shortest_through_their_doors(
        columns in 2..14_usize,
        rows in 2..14_usize,
        blocked in prop::collection::vec(prop::bool::weighted(0.25), 14 * 14),
        ends in (0..14_usize * 14, 0..14_usize * 14),
    ) {
        let mut grid = Grid::new(columns, rows, 1.0, Point::origin()).unwrap();
        let (start, target) = (grid.cell(ends.0 % grid.len()), grid.cell(ends.1 % grid.len()));
        for (number, blocked) in blocked.into_iter().enumerate().take(grid.len()) {
            let cell = grid.cell(number);
            if blocked && cell != start && cell != target {
                grid.block(cell);
            }
        }
        let cells = CellGrid::new(grid.clone());
        // Off the centres, and of whole parts, so that lines are computed without rounding.
        let off = Vector::new(0.25, -0.125);
        let (from, to) = (grid.center(start) + off, grid.center(target) + off);
        let route = cells.route(from, to);
        prop_assert_eq!(route.is_ok(), dijkstra(&grid, start, target, Moves::Four).is_ok());
        if let Ok(route) = route {
            check(&cells, &route, from, to);
            let doors: Vec<_> = route.cells.windows(2).filter_map(|pair| cells.door(pair[0], pair[1])).collect();
            prop_assert_eq!(doors.len() + 1, route.cells.len());
            let shortest = shortest(from, &doors, to);
            prop_assert!((route.length_m - shortest).abs() < 1e-9, "{} {}", route.length_m, shortest);
        }
    }
}
