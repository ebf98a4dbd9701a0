//! Scans: what has reached the brain of sensors that look along many rays, as distances by angle.

use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_proto::v1::SensorKind;
use foxglove::messages::LaserScan;

use super::frames;
use super::message::FoxgloveMessage;
use super::parts::{part, pose_at, time};

/// A sensor whose readings are distances along a fan of rays.
#[derive(Clone, Debug)]
pub(super) struct Scanner {
    topic: Arc<str>,
    frame: String,
    /// The distances among the values of a reading.
    first: usize,
    count: usize,
    /// The first ray is on the left.
    from_left: bool,
    /// The instant at which the scan was sampled that was shown last; none before there was one.
    shown: Option<Option<u64>>,
}

impl Scanner {
    /// Lasers, and the depths that a line camera sees. Where the sensor sits must be known.
    pub(super) fn of(robot: &str, sensor: &v1::SensorDescription) -> Option<Self> {
        let (component, from_left) = if sensor.kind() == SensorKind::Laser {
            ("", sensor.sweep.is_some_and(|sweep| sweep.clockwise))
        } else if sensor.kind() == SensorKind::LineCamera {
            ("depth_m", true)
        } else {
            return None;
        };
        sensor.mount.as_ref()?;
        let place = sensor.components.iter().position(|described| described.name == component)?;
        let count = |component: &v1::ComponentDescription| component.count.max(1) as usize;
        Some(Self {
            topic: format!("/scan/{}/{}", part(robot), part(&sensor.sensor)).into(),
            frame: frames::sensor(robot, &sensor.sensor),
            first: sensor.components[..place].iter().map(count).sum(),
            count: count(&sensor.components[place]),
            from_left,
            shown: None,
        })
    }

    /// The run starts over.
    pub(super) fn forget(&mut self) {
        self.shown = None;
    }

    /// The scan that the brain has, if it is another than before. It was taken where the robot was then, so that is its
    /// time; `time_ns` is the frame's.
    pub(super) fn message(&mut self, detail: &v1::SensorDetail, time_ns: u64) -> Option<FoxgloveMessage> {
        let is_known = match self.shown {
            Some(Some(_)) => self.shown == Some(detail.sampled_at_ns),
            Some(None) => detail.sampled_at_ns.is_none() && !detail.readable,
            None => false,
        };
        let opening_rad = detail.rays.as_ref()?.opening_rad;
        let distances_m = detail.values.get(self.first..self.first + self.count)?;
        if is_known || !opening_rad.is_finite() {
            return None;
        }
        self.shown = Some(detail.sampled_at_ns);
        let half_rad = 0.5 * if self.from_left { -opening_rad } else { opening_rad };
        let scan = LaserScan {
            timestamp: Some(time(detail.sampled_at_ns.unwrap_or(time_ns).min(time_ns))),
            frame_id: self.frame.clone(),
            pose: Some(pose_at(0.0, 0.0, 0.0)),
            start_angle: -half_rad,
            end_angle: half_rad,
            ranges: distances_m.iter().map(|&distance_m| range(distance_m)).collect(),
            intensities: Vec::new(),
        };
        Some(FoxgloveMessage::new(&self.topic, time_ns, &scan))
    }
}

/// A ray that met nothing is endless: -1 would be a point behind the sensor.
fn range(distance_m: f64) -> f64 {
    if distance_m.is_finite() && distance_m >= 0.0 { distance_m } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use foxglove::Decode as _;

    use super::*;

    fn sensor(kind: SensorKind, components: &[(&str, u32)]) -> v1::SensorDescription {
        let component = |&(name, count): &(&str, u32)| v1::ComponentDescription {
            name: name.into(),
            count,
            ..v1::ComponentDescription::default()
        };
        v1::SensorDescription {
            sensor: "eye".into(),
            kind: kind.into(),
            mount: Some(v1::Mount::default()),
            components: components.iter().map(component).collect(),
            ..v1::SensorDescription::default()
        }
    }

    fn detail(values: &[f64], sampled_at_ns: Option<u64>) -> v1::SensorDetail {
        let rays = Some(v1::RayFan { opening_rad: 2.0, ..v1::RayFan::default() });
        v1::SensorDetail { values: values.to_vec(), sampled_at_ns, rays, ..v1::SensorDetail::default() }
    }

    fn scan(message: &FoxgloveMessage) -> LaserScan {
        assert_eq!(message.schema.name, "foxglove.LaserScan");
        LaserScan::decode(&message.data[..]).unwrap()
    }

    #[test]
    fn a_lasers_scan_goes_from_right_to_left_and_is_of_the_time_at_which_it_was_taken() {
        let mut laser = Scanner::of("alice", &sensor(SensorKind::Laser, &[("", 4)])).unwrap();
        let message =
            laser.message(&detail(&[1.0, -1.0, f64::NAN, 2.5], Some(1_500_000_000)), 2_000_000_000).unwrap();
        assert_eq!((&*message.topic, message.time_ns), ("/scan/alice/eye", 2_000_000_000));
        let scan = scan(&message);
        assert_eq!((scan.start_angle, scan.end_angle), (-1.0, 1.0));
        assert_eq!(scan.ranges, [1.0, f64::INFINITY, f64::INFINITY, 2.5]);
        assert_eq!(scan.frame_id, "robot/alice/eye");
        let at = scan.timestamp.unwrap();
        assert_eq!((at.sec(), at.nsec()), (1, 500_000_000));
    }

    #[test]
    fn a_laser_that_sweeps_clockwise_begins_on_the_left() {
        let sweep = Some(v1::Sweep { duration_ns: 100_000_000, clockwise: true });
        let sensor = v1::SensorDescription { sweep, ..sensor(SensorKind::Laser, &[("", 2)]) };
        let mut laser = Scanner::of("alice", &sensor).unwrap();
        let scan = scan(&laser.message(&detail(&[3.0, 4.0], None), 0).unwrap());
        assert_eq!((scan.start_angle, scan.end_angle, &*scan.ranges), (1.0, -1.0, &[3.0, 4.0][..]));
    }

    #[test]
    fn a_line_cameras_depths_go_from_left_to_right() {
        let camera = sensor(SensorKind::LineCamera, &[("red", 2), ("green", 2), ("blue", 2), ("depth_m", 2)]);
        let mut camera = Scanner::of("alice", &camera).unwrap();
        let message = camera.message(&detail(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 3.0, 4.0], None), 0).unwrap();
        let scan = scan(&message);
        assert_eq!((scan.start_angle, scan.end_angle), (1.0, -1.0));
        assert_eq!(scan.ranges, [3.0, 4.0]);
    }

    #[test]
    fn each_scan_is_shown_once_and_a_short_reading_never() {
        let mut laser = Scanner::of("alice", &sensor(SensorKind::Laser, &[("", 2)])).unwrap();
        assert!(laser.message(&detail(&[], None), 0).is_none(), "nothing has come yet");
        assert!(laser.message(&detail(&[1.0], Some(1)), 5).is_none());
        assert!(laser.message(&v1::SensorDetail { rays: None, ..detail(&[1.0, 2.0], Some(1)) }, 5).is_none());
        assert!(laser.message(&detail(&[1.0, 2.0], Some(1)), 5).is_some());
        assert!(laser.message(&detail(&[1.0, 2.0], Some(1)), 6).is_none());
        assert!(laser.message(&detail(&[1.0, 2.0], Some(6)), 6).is_some());
        let unknown = detail(&[1.0, 2.0], None);
        assert!(laser.message(&unknown, 7).is_some());
        assert!(laser.message(&unknown, 8).is_none());
        assert!(laser.message(&v1::SensorDetail { readable: true, ..unknown.clone() }, 9).is_some());
        laser.forget();
        assert!(laser.message(&unknown, 0).is_some());
    }

    #[test]
    fn only_what_has_a_fan_of_distances_scans() {
        assert!(Scanner::of("alice", &sensor(SensorKind::Sonar, &[("", 1)])).is_none());
        assert!(Scanner::of("alice", &sensor(SensorKind::LineCamera, &[("red", 1)])).is_none());
        let nowhere = v1::SensorDescription { mount: None, ..sensor(SensorKind::Laser, &[("", 4)]) };
        assert!(Scanner::of("alice", &nowhere).is_none());
    }
}
