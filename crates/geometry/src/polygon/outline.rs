//! Whether a chain of corners bounds one region, and what keeps it from that.

use alloc::vec::Vec;

use super::overlap::ROUNDING_M;
use crate::pose::Point;
use crate::segment::Segment;

/// A reason why a chain of corners does not bound one region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Defect {
    /// The outline has so many corners, and a region has at least three.
    TooFew(usize),
    /// All its corners are on one line.
    Flat,
    /// The outline turns back at this corner and runs along the side that it came by.
    FoldsBack(Point),
    /// The outline passes this place twice without crossing itself there.
    Touches(Point),
    /// These two sides of the outline cross.
    Crosses([Segment; 2]),
}

/// The corners without those that repeat the one before them; of a closed chain without a last one that repeats the first
/// either, as a ring in GeoJSON or WKT ends.
#[must_use]
pub fn without_repeats(points: &[Point], closed: bool) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::with_capacity(points.len());
    for &point in points {
        if kept.last().is_none_or(|&last| !is_same_place(last, point)) {
            kept.push(point);
        }
    }
    while closed && kept.len() > 1 && is_same_place(kept[0], kept[kept.len() - 1]) {
        kept.pop();
    }
    kept
}

/// Whether the chain bounds one region: three corners or more, and no two edges meet but neighbours at
/// their common corner. It takes time proportional to the square of the number of corners.
///
/// As for [`Segment::touches`], a defect of the size of a rounding error may be judged either way.
#[must_use]
pub fn is_simple(points: &[Point]) -> bool {
    defect(points).is_none()
}

/// The defect that keeps the chain from being [simple](is_simple), if it has one. Straight corners do not.
#[must_use]
pub fn defect(points: &[Point]) -> Option<Defect> {
    let n = points.len();
    if n < 3 {
        return Some(Defect::TooFew(n));
    }
    if is_flat(points) {
        return Some(Defect::Flat);
    }
    let edge = |i: usize| Segment { start: points[i % n], end: points[(i + 1) % n] };
    (0..n).find_map(|i| {
        let (this, next) = (edge(i), edge(i + 1));
        if this.start == this.end {
            return Some(Defect::Touches(this.start));
        }
        if folds_back(&this, &next) {
            return Some(Defect::FoldsBack(this.end));
        }
        // The last edge is the first one's neighbour; all others from i + 2 on are strangers.
        let mut strangers = ((i + 2)..if i == 0 { n - 1 } else { n }).map(edge);
        strangers.find(|other| this.touches(other)).map(|other| meeting(&this, &other))
    })
}

/// The kind of defect that two edges make that meet and are no neighbours.
fn meeting(a: &Segment, b: &Segment) -> Defect {
    let ends = [(b, a.start), (b, a.end), (a, b.start), (a, b.end)];
    let touching = ends.into_iter().find(|(edge, end)| is_same_place(edge.nearest_point(*end), *end));
    touching.map_or(Defect::Crosses([*a, *b]), |(_, end)| Defect::Touches(end))
}

/// Whether all corners are on one line, but for rounding.
fn is_flat(points: &[Point]) -> bool {
    let first = points[0];
    let farther =
        |a: Point, b: Point| if (b - first).norm_squared() > (a - first).norm_squared() { b } else { a };
    let along = points.iter().copied().fold(first, farther) - first;
    points.iter().all(|point| along.perp(&(point - first)).abs() <= ROUNDING * along.norm_squared())
}

/// Whether the second of two edges that share a corner runs back along the first.
fn folds_back(first: &Segment, second: &Segment) -> bool {
    let (u, v) = (first.end - first.start, second.end - second.start);
    let ahead = u.dot(&v);
    ahead < 0.0 && u.perp(&v).abs() <= -ROUNDING * ahead
}

fn is_same_place(a: Point, b: Point) -> bool {
    (b - a).norm_squared() <= ROUNDING_M * ROUNDING_M
}

/// The sine of an angle that is no more than rounding.
pub(super) const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    fn points<const N: usize>(corners: [(f64, f64); N]) -> Vec<Point> {
        corners.map(|(x, y)| Point::new(x, y)).to_vec()
    }

    #[test]
    fn simple_and_not() {
        assert!(is_simple(&points([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])));
        assert!(is_simple(&points([(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (0.0, 4.0)])), "a straight corner");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)])), "a bow tie");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 0.0), (2.0, 0.0)])), "flat");
        assert!(!is_simple(&points([(0.0, 0.0), (0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])), "a corner twice");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 0.0)])));
        let pinched = points([(0.0, 0.0), (2.0, 1.0), (4.0, 0.0), (4.0, 2.0), (2.0, 1.0), (0.0, 2.0)]);
        assert!(!is_simple(&pinched), "two corners in one place");
    }

    #[test]
    fn each_defect_has_its_name() {
        let at = Point::new;
        assert_eq!(defect(&points([(0.0, 0.0), (4.0, 0.0)])), Some(Defect::TooFew(2)));
        assert_eq!(defect(&points([(0.1, 0.1), (0.7, 0.7), (0.3, 0.3), (0.2, 0.2)])), Some(Defect::Flat));
        let spike = points([(0.0, 0.0), (4.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
        assert_eq!(defect(&spike), Some(Defect::FoldsBack(at(4.0, 0.0))));
        let pinched = points([(0.0, 0.0), (2.0, 1.0), (4.0, 0.0), (4.0, 2.0), (2.0, 1.0), (0.0, 2.0)]);
        assert_eq!(defect(&pinched), Some(Defect::Touches(at(2.0, 1.0))));
        let bow_tie = points([(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)]);
        let sides = [[0, 1], [2, 3]].map(|[i, j]| Segment { start: bow_tie[i], end: bow_tie[j] });
        assert_eq!(defect(&bow_tie), Some(Defect::Crosses(sides)));
    }

    /// Sides cut into pieces of which no two are exactly on one line, in all directions.
    #[test]
    fn corners_on_straight_sides_are_no_defect_in_any_direction() {
        for turn in 0..360 {
            let (sin, cos) = crate::math::sin_cos(f64::from(turn) * 0.0175);
            let square = [(0.0, 0.0), (1.3, 0.0), (1.3, 0.7), (0.0, 0.7), (0.0, 0.0)];
            let mut corners = Vec::new();
            for side in square.windows(2) {
                let [(x0, y0), (x1, y1)] = [side[0], side[1]];
                for i in 0..30 {
                    let part = f64::from(i) / 30.0;
                    let (x, y) = (x0 + (x1 - x0) * part, y0 + (y1 - y0) * part);
                    corners.push(Point::new(5.1 + x * cos - y * sin, x * sin + y * cos));
                }
            }
            assert_eq!(defect(&corners), None, "{turn}");
            assert!(super::super::is_convex(&corners), "{turn}");
        }
    }

    #[test]
    fn repeats_are_left_out() {
        let square = points([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let ring = points([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]);
        assert_eq!(without_repeats(&ring, true), square);
        assert_eq!(without_repeats(&ring, false), [&square[..], &square[..1]].concat());
        let nearly = points([(0.3, 0.0), (1.0, 0.0), (1.0, 1.0), (0.1 + 0.2, 0.0)]);
        assert_eq!(without_repeats(&nearly, true).len(), 3);
        assert_eq!(without_repeats(&points([(1.0, 1.0); 3]), true).len(), 1);
        assert!(without_repeats(&[], true).is_empty());
    }
}
