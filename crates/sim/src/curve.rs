//! Measured curves: linear between their points, held beyond their ends.

/// The value at `x` of the curve through `points`, whose first coordinates increase; 0 if there are none.
pub(crate) fn value(points: &[(f64, f64)], x: f64) -> f64 {
    let above = points.partition_point(|&(point, _)| point <= x);
    match (above.checked_sub(1).map(|below| points[below]), points.get(above)) {
        (Some((from, low)), Some(&(to, high))) => low + (high - low) * ((x - from) / (to - from)),
        (Some((_, end)), None) | (None, Some(&(_, end))) => end,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn linear_between_the_points_and_held_beyond_them() {
        let points = [(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)];
        let found = [0.0, 1.0, 1.25, 2.0, 3.0, 4.0, 5.0].map(|x| value(&points, x));
        assert_eq!(found, [10.0, 10.0, 12.5, 20.0, 10.0, 0.0, 0.0]);
        assert_eq!([value(&points[..1], 0.0), value(&points[..1], 1.0), value(&[], 1.0)], [10.0, 10.0, 0.0]);
    }
}
