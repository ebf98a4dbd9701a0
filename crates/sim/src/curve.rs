//! Measured curves: linear between their points, held beyond their ends.

use alloc::format;

use baudbot_fields::number::Rule;
use baudbot_fields::{FieldError, Path};

baudbot_fields::rules! {
    /// A share of something, without which nothing would be left of it.
    LeastShare: Any, 1e-3, 1.0;
}

/// Points for a JSON Schema.
#[cfg(feature = "schema")]
pub(crate) type Points<X, Y> =
    alloc::vec::Vec<(baudbot_fields::number::Number<X>, baudbot_fields::number::Number<Y>)>;

/// Most points of a motor's curve.
const MAX_POINTS: usize = 1000;

/// Whether a motor's curve has as many points as it needs, and not too many.
pub(crate) fn has_points(path: &Path, points: &[(f64, f64)], least: usize) -> Result<(), FieldError> {
    if (least..=MAX_POINTS).contains(&points.len()) {
        return Ok(());
    }
    let problem = format!("a curve has {least} to {MAX_POINTS} points; this one has {}", points.len());
    Err(path.error(problem))
}

/// Whether the points of the curve at `path` keep to the rules of their coordinates, and the first ones increase.
pub(crate) fn check<X, Y>(path: &Path, points: &[(f64, f64)], [x, y]: [&str; 2]) -> Result<(), FieldError>
where
    X: Rule<Written = f64>,
    Y: Rule<Written = f64>,
{
    for (i, point) in points.iter().enumerate() {
        let path = path.index(i);
        path.number::<X>(x, point.0)?;
        path.number::<Y>(y, point.1)?;
        if i > 0 && point.0 <= points[i - 1].0 {
            let what = x.trim_end_matches("_us");
            return Err(path.error(format!(
                "{what}s must increase, {} follows {}",
                point.0,
                points[i - 1].0
            )));
        }
    }
    Ok(())
}

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
