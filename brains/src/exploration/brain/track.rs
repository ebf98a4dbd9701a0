//! Where the robot was a moment ago, by its odometer.

use std::collections::VecDeque;

use baudbot_geometry::{Pose, angle};

/// The odometer's last readings.
///
/// A scan comes late: it takes its time on its cable, and that is not the odometer's. So it belongs to a pose of the
/// past.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Track {
    /// When each was sampled, in nanoseconds, and the pose in the world; the last one is the latest.
    poses: VecDeque<(u64, Pose)>,
}

impl Track {
    /// Adds a reading, unless it is older than the last one.
    pub(super) fn add(&mut self, sampled_ns: u64, world_from_robot: Pose) {
        if self.poses.back().is_some_and(|(last_ns, _)| sampled_ns <= *last_ns) {
            return;
        }
        if self.poses.len() == MOST_POSES {
            self.poses.pop_front();
        }
        self.poses.push_back((sampled_ns, world_from_robot));
    }

    /// The last reading.
    pub(super) fn last(&self) -> Option<(u64, Pose)> {
        self.poses.back().copied()
    }

    /// The pose at an instant between two readings, and the turn rate there in rad/s; `None` before the first reading
    /// that is kept, and after the last.
    pub(super) fn at(&self, at_ns: u64) -> Option<(Pose, f64)> {
        let place = self.poses.partition_point(|(ns, _)| *ns < at_ns);
        let &(after_ns, after) = self.poses.get(place)?;
        if after_ns == at_ns && place == 0 {
            return Some((after, 0.0));
        }
        let &(before_ns, before) = self.poses.get(place.checked_sub(1)?)?;
        let part = (at_ns - before_ns) as f64 / (after_ns - before_ns) as f64;
        let turn = angle::difference(after.heading, before.heading);
        let pose = Pose {
            position: before.position + (after.position - before.position) * part,
            heading: angle::wrap(before.heading + turn * part),
        };
        Some((pose, turn / ((after_ns - before_ns) as f64 * 1e-9)))
    }
}

/// More than two seconds at 50 readings a second.
const MOST_POSES: usize = 128;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_between_two_readings_is_between_them() {
        let mut track = Track::default();
        track.add(1_000_000_000, Pose::new(0.0, 0.0, 3.0));
        track.add(1_500_000_000, Pose::new(1.0, 2.0, -3.0));
        track.add(1_400_000_000, Pose::new(9.0, 9.0, 0.0));
        let (pose, turn_rate) = track.at(1_250_000_000).unwrap();
        assert!((pose.position - baudbot_geometry::Point::new(0.5, 1.0)).norm() < 1e-12);
        assert!((pose.heading.abs() - std::f64::consts::PI).abs() < 1e-12, "the short way: {}", pose.heading);
        assert!((turn_rate - 2.0 * (std::f64::consts::TAU - 6.0)).abs() < 1e-12);
        assert_eq!((track.at(999_999_999), track.at(1_500_000_001)), (None, None));
    }

    #[test]
    fn only_so_many_are_kept() {
        let mut track = Track::default();
        (0..1000).for_each(|i| track.add(i, Pose::new(i as f64, 0.0, 0.0)));
        assert_eq!(track.poses.len(), MOST_POSES);
        assert_eq!(track.last().map(|(ns, _)| ns), Some(999));
        assert_eq!(track.at(3), None);
    }
}
