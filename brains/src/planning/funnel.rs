//! The shortest path through a corridor of convex cells: a string through its doors, pulled tight.
//!
//! The funnel algorithm (Chazelle 1982; Lee and Preparata 1984). From the last corner of the string, the apex, one
//! looks through door after door. What can be seen through all of them is a funnel, which gets narrower. Once the
//! next door is wholly outside of it, the string bends at the side of the funnel that is in the way, and that
//! corner is the next apex.

use baudbot_geometry::{Point, Segment};

/// The corners of the shortest path from `start` through all doors, in order, to `target`, both included. A door
/// goes from its left end to its right one, as one passes through.
pub(super) fn tighten(start: Point, doors: &[Segment], target: Point) -> Vec<Point> {
    let last = Segment { start: target, end: target };
    let doors: Vec<_> = doors.iter().chain([&last]).copied().collect();
    let mut path = vec![start];
    let mut first = 0;
    while let Some((corner, door)) = next_corner(path[path.len() - 1], &doors[first..]) {
        path.push(corner);
        first += door + 1;
    }
    path.push(target);
    // The start may be an end of the first door, and the target one of the last.
    path.dedup();
    path
}

/// The corner at which the string from the apex bends first, and at which door; `None` if it runs straight to the
/// end.
fn next_corner(apex: Point, doors: &[Segment]) -> Option<(Point, usize)> {
    // Ends of doors, and which door: the sides of the funnel.
    let (mut left, mut right) = (None::<(Point, usize)>, None::<(Point, usize)>);
    for (i, door) in doors.iter().enumerate() {
        if let Some(side) = left.filter(|(left, _)| is_left_of(apex, *left, door.end)) {
            return Some(side);
        }
        if let Some(side) = right.filter(|(right, _)| is_left_of(apex, door.start, *right)) {
            return Some(side);
        }
        // An end at the apex itself bounds no view.
        if door.start != apex && left.is_none_or(|(left, _)| !is_left_of(apex, left, door.start)) {
            left = Some((door.start, i));
        }
        if door.end != apex && right.is_none_or(|(right, _)| !is_left_of(apex, door.end, right)) {
            right = Some((door.end, i));
        }
    }
    None
}

/// Whether a point is to the left of the line from the apex through another point.
fn is_left_of(apex: Point, through: Point, point: Point) -> bool {
    (through - apex).perp(&(point - apex)) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points<const N: usize>(points: [(f64, f64); N]) -> Vec<Point> {
        points.map(|(x, y)| Point::new(x, y)).to_vec()
    }

    fn door(left: (f64, f64), right: (f64, f64)) -> Segment {
        Segment { start: Point::new(left.0, left.1), end: Point::new(right.0, right.1) }
    }

    #[test]
    fn a_string_bends_where_a_door_is_in_its_way() {
        let (start, target) = (Point::new(0.0, 0.0), Point::new(4.0, 0.0));
        let wide = door((2.5, 1.0), (2.5, -1.0));
        assert_eq!(tighten(start, &[wide], target), points([(0.0, 0.0), (4.0, 0.0)]));
        let high = door((2.0, 3.0), (2.0, 2.0));
        assert_eq!(tighten(start, &[high], target), points([(0.0, 0.0), (2.0, 2.0), (4.0, 0.0)]));
        let low = door((3.0, -2.0), (3.0, -3.0));
        let bent = points([(0.0, 0.0), (2.0, 2.0), (3.0, -2.0), (4.0, 0.0)]);
        assert_eq!(tighten(start, &[high, wide, low], target), bent);
        assert_eq!(tighten(start, &[], target), points([(0.0, 0.0), (4.0, 0.0)]));
    }

    #[test]
    fn round_a_wall_it_touches_both_its_corners() {
        // Up, over the wall's end from x = 2 to 3, and down again.
        let doors =
            [door((0.0, 4.0), (2.0, 4.0)), door((3.0, 5.0), (3.0, 4.0)), door((5.0, 4.0), (3.0, 4.0))];
        let path = tighten(Point::new(1.0, 0.0), &doors, Point::new(4.0, 0.0));
        assert_eq!(path, points([(1.0, 0.0), (2.0, 4.0), (3.0, 4.0), (4.0, 0.0)]));
    }
}
