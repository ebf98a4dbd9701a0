//! Whether a robot that goes down a field gets anywhere.

use baudbot_geometry::Point;

/// The lowest place so far, in the field as it is now.
#[derive(Clone, Debug, Default)]
pub(super) struct Lock {
    lowest: Option<Low>,
}

#[derive(Clone, Copy, Debug)]
struct Low {
    height: f64,
    /// The place at which the robot got lower last.
    place: Point,
    /// The instant, in nanoseconds.
    at_ns: u64,
}

impl Lock {
    /// Whether it has got no lower for so long. A robot that creeps into a hollow, or circles in it, gets lower for ever and
    /// not on: lower counts a few centimetres from the place where it did the last time.
    pub(super) fn holds(&mut self, at: Point, height: f64, at_ns: u64, after_s: f64) -> bool {
        let Some(low) = &mut self.lowest else {
            self.lowest = Some(Low { height, place: at, at_ns });
            return false;
        };
        if height < low.height {
            low.height = height;
            if (at - low.place).norm() >= ON_M {
                (low.place, low.at_ns) = (at, at_ns);
            }
        }
        at_ns.saturating_sub(low.at_ns) as f64 * 1e-9 >= after_s
    }

    /// The field is another one, or the robot was led somewhere else.
    pub(super) fn begin(&mut self) {
        self.lowest = None;
    }
}

/// A robot that stays within this distance makes no progress, even if it gets lower, in metres.
const ON_M: f64 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_creeps_or_circles_is_locked_and_who_gets_on_is_not() {
        let held = |place: fn(f64) -> (Point, f64)| {
            let mut lock = Lock::default();
            (0..200_u64).position(|i| {
                let (at, height) = place(0.1 * i as f64);
                lock.holds(at, height, i * 100_000_000, 5.0)
            })
        };
        assert_eq!(held(|t| (Point::new(0.02 * t, 0.0), -t)), None, "on it goes, slowly");
        // 1 − e^−t: for the last time it is 5 cm farther down than before after 2.5 s or so.
        let creeps = held(|t| (Point::new(0.6 * (1.0 - (-t).exp()), 0.0), -1.0 + (-t).exp()));
        assert!(creeps.is_some_and(|i| (60..90).contains(&i)), "{creeps:?}");
        let circles = held(|t| (Point::new(0.3 * t.cos(), 0.3 * t.sin()), -t.min(1.0)));
        assert!(circles.is_some_and(|i| (50..65).contains(&i)), "{circles:?}");
    }
}
