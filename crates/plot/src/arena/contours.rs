//! Contours: the lines on which a function of the place has one height.
//!
//! Squares of a lattice are gone through one by one. In each, the function is linear between corners, and a line leads from one crossing of its border to
//! another (marching squares). At a saddle two lines cross none of the diagonals.

use baudbot_geometry::{Bounds, Point};

/// Lines of one height, as pieces without order.
pub type Contour = Vec<[Point; 2]>;

/// The contours of a function in a box at so many heights, from low to high, evenly spaced between its least and its greatest value there.
pub fn contours(bounds: &Bounds, heights: u32, function: impl Fn(Point) -> f64) -> Vec<Contour> {
    let size = bounds.size();
    let at = |i: u32, j: u32| {
        let part = |k: u32| f64::from(k) / f64::from(SQUARES);
        Point::new(bounds.min.x + size.x * part(i), bounds.min.y + size.y * part(j))
    };
    let corners: Vec<Vec<_>> =
        (0..=SQUARES).map(|j| (0..=SQUARES).map(|i| (at(i, j), function(at(i, j)))).collect()).collect();
    let values = || corners.iter().flatten().map(|(_, value)| *value);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let height = |k: u32| least + (most - least) * f64::from(k + 1) / f64::from(heights + 1);
    let of_height = |height: f64| -> Contour {
        let rows = corners.windows(2).flat_map(|rows| rows[0].windows(2).zip(rows[1].windows(2)));
        rows.flat_map(|(low, high)| pieces([low[0], low[1], high[1], high[0]], height)).collect()
    };
    (0..heights).map(|k| of_height(height(k))).collect()
}

/// The pieces in a square with these corners, one after the other around it.
fn pieces(corners: [(Point, f64); 4], height: f64) -> Vec<[Point; 2]> {
    let crossing = |i: usize| {
        let ((a, low), (b, high)) = (corners[i], corners[(i + 1) % 4]);
        ((low < height) != (high < height)).then(|| a + (b - a) * ((height - low) / (high - low)))
    };
    let crossings: Vec<_> = (0..4).filter_map(crossing).collect();
    crossings.chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect()
}

/// Squares along each side of the box.
const SQUARES: u32 = 120;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_of_a_cone_are_circles() {
        let bounds = Bounds { min: Point::new(-2.0, -2.0), max: Point::new(2.0, 2.0) };
        let cone = |at: Point| at.coords.norm();
        let lines = contours(&bounds, 3, cone);
        let most = 8.0_f64.sqrt();
        for (line, part) in lines.iter().zip([0.25, 0.5, 0.75]) {
            assert!(line.len() > 50, "{}", line.len());
            for point in line.iter().flatten() {
                assert!((cone(*point) - part * most).abs() < 0.005, "{point}");
            }
        }
        // The second lies within the box, so its pieces add up to a circle.
        let length: f64 = lines[1].iter().map(|[a, b]| (b - a).norm()).sum();
        assert!((length - std::f64::consts::PI * most).abs() < 0.01, "{length}");
    }

    #[test]
    fn a_plane_of_one_height_has_no_contours() {
        let bounds = Bounds { min: Point::origin(), max: Point::new(1.0, 2.0) };
        assert!(contours(&bounds, 4, |_| 3.0).iter().all(Vec::is_empty));
    }
}
