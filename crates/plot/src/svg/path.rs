//! Paths and rectangles, and lines with fewer points.

use std::fmt::Write;

use baudbot_geometry::math;

use super::{Element, px};

/// A place in the picture, in pixels.
pub type Place = (f64, f64);

/// A rectangle by its upper left corner and its size, in pixels.
pub fn rectangle((x, y): Place, (width, height): (f64, f64)) -> Element {
    let at = Element::new("rect").number("x", x).number("y", y);
    at.number("width", width).number("height", height)
}

/// A line through places, as the data of a path.
pub fn path(places: impl IntoIterator<Item = Place>) -> String {
    let mut data = String::new();
    for (i, (x, y)) in places.into_iter().enumerate() {
        let _ = write!(data, "{}{} {}", if i == 0 { 'M' } else { 'L' }, px(x), px(y));
    }
    data
}

/// An element that is a path.
pub fn drawn(data: &str) -> Element {
    Element::new("path").set("d", data)
}

/// The head of an arrow that comes `from` somewhere and ends at `to`, as the data of a path.
pub fn arrow_head(from: Place, to: Place, size: f64) -> String {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = math::hypot(x, y);
    if length < 1e-6 {
        return String::new();
    }
    let (x, y) = (x / length * size, y / length * size);
    let side = |share: f64| (to.0 - x - share * y, to.1 - y + share * x);
    path([side(0.5), to, side(-0.5)]) + "Z"
}

/// A line without the points that it can do without: it is off by `tolerance` pixels at most (Ramer, Douglas, Peucker).
pub fn simplified(places: &[Place], tolerance: f64) -> Vec<Place> {
    let mut keep = vec![false; places.len()];
    let mut spans = vec![(0, places.len().saturating_sub(1))];
    for end in [keep.len().checked_sub(1), (!keep.is_empty()).then_some(0)].into_iter().flatten() {
        keep[end] = true;
    }
    while let Some((first, last)) = spans.pop() {
        let off = |i: usize| (i, distance(places[i], places[first], places[last]));
        let farthest = (first + 1..last).map(off).reduce(|a, b| if b.1 > a.1 { b } else { a });
        if let Some((i, off)) = farthest
            && off > tolerance
        {
            keep[i] = true;
            spans.extend([(first, i), (i, last)]);
        }
    }
    places.iter().zip(keep).filter(|(_, keep)| *keep).map(|(&place, _)| place).collect()
}

/// The distance of a place from a piece of a line.
fn distance(p: Place, a: Place, b: Place) -> f64 {
    let (x, y) = (b.0 - a.0, b.1 - a.1);
    let squared = x * x + y * y;
    let along = if squared > 0.0 { ((p.0 - a.0) * x + (p.1 - a.1) * y) / squared } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    math::hypot(p.0 - a.0 - along * x, p.1 - a.1 - along * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_needs_no_points_between() {
        let places: Vec<_> = (0..100).map(|i| (f64::from(i), f64::from(i.min(50)))).collect();
        assert_eq!(simplified(&places, 0.1), [(0.0, 0.0), (50.0, 50.0), (99.0, 50.0)]);
        assert_eq!(simplified(&[], 0.1), []);
        assert_eq!(simplified(&[(1.0, 1.0)], 0.1), [(1.0, 1.0)]);
    }
}
