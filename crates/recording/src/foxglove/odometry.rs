//! Dead reckoning: where a robot would believe itself to be if it had nothing but its wheels, by readings that have
//! reached its brain. It is computed here, as in the page (viewer/src/model/odometry.ts); no brain has a part in it.
//!
//! Differential drive, Eqs. (2.1)–(2.9) of the notes: with the ways s_l, s_r of the wheels and half their distance b
//!
//! ```text
//! s = (s_l + s_r) / 2,  Δφ = (s_r - s_l) / (2 b),  along the middle heading φ + Δφ/2
//! ```

use std::collections::VecDeque;
use std::f64::consts::TAU;

use baudbot_geometry::Twist;
use baudbot_proto::v1;
use baudbot_proto::v1::SensorKind;
use baudbot_sim::Pose;

use super::parts::sound_pose;

/// Follows a robot's wheels from a true pose on.
#[derive(Clone, Debug)]
pub(super) struct DeadReckoning {
    source: Source,
    /// The sensor's place in the data sheet.
    sensor: usize,
    pose: Option<Pose>,
    counts: Option<[f64; 2]>,
    sampled_at_ns: Option<u64>,
    /// True poses until it has begun, to know where the robot was when its first reading was taken.
    past: VecDeque<(u64, Pose)>,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    /// The sensor does the sums itself.
    Odometer,
    Encoders(Wheels),
}

/// The part of a data sheet that dead reckoning needs.
#[derive(Clone, Copy, Debug)]
struct Wheels {
    way_per_count_m: f64,
    half_track_m: f64,
    /// A counter begins again at this number; 0 if it does not wrap.
    wraps_at: f64,
}

/// True poses that are kept.
const POSES: usize = 256;

impl DeadReckoning {
    /// A `DeadReckoning` by the best sensor for it that a robot has, if any: an odometer, or else encoders.
    pub(super) fn of(robot: &v1::RobotDescription) -> Option<Self> {
        let odometer = robot.sensors.iter().position(|sensor| sensor.kind() == SensorKind::Odometer);
        let encoders = || {
            let counts = |sensor: &v1::SensorDescription| {
                sensor.kind() == SensorKind::Encoders
                    && sensor.counts_per_turn.is_some_and(|counts| counts > 0)
            };
            let sensor = robot.sensors.iter().position(counts)?;
            let sound = robot.half_track_m > 0.0 && robot.wheel_radius_m.is_finite();
            sound.then(|| (Source::Encoders(Wheels::new(robot, &robot.sensors[sensor])), sensor))
        };
        let (source, sensor) = odometer.map(|sensor| (Source::Odometer, sensor)).or_else(encoders)?;
        Some(Self { source, sensor, pose: None, counts: None, sampled_at_ns: None, past: VecDeque::new() })
    }

    /// The pose so far.
    pub(super) fn pose(&self) -> Option<Pose> {
        self.pose
    }

    /// The run starts over.
    pub(super) fn forget(&mut self) {
        (self.pose, self.counts, self.sampled_at_ns) = (None, None, None);
        self.past.clear();
    }

    /// Notes the robot's true pose at a frame's time.
    pub(super) fn note(&mut self, time_ns: u64, truth: Pose) {
        if self.pose.is_some() || matches!(self.source, Source::Odometer) {
            return;
        }
        self.past.push_back((time_ns, truth));
        if self.past.len() > POSES {
            self.past.pop_front();
        }
    }

    /// The descriptions of the robot's sensors.
    pub(super) fn take(&mut self, sensors: &[v1::SensorDetail]) {
        let Some(detail) = sensors.get(self.sensor) else { return };
        let is_known = detail.sampled_at_ns.is_some() && detail.sampled_at_ns == self.sampled_at_ns;
        if !is_known && self.read(&detail.values, detail.sampled_at_ns).is_some() {
            self.sampled_at_ns = detail.sampled_at_ns;
        }
    }

    /// None if the reading is none.
    fn read(&mut self, values: &[f64], sampled_at_ns: Option<u64>) -> Option<()> {
        let (&first, &second) = (values.first()?, values.get(1)?);
        let Source::Encoders(wheels) = self.source else {
            self.pose = Some(sound_pose(first, second, values.get(2).copied().unwrap_or(0.0))?);
            return Some(());
        };
        let counts = [first, second];
        if !counts.iter().all(|count| count.is_finite()) {
            return None;
        }
        self.pose = Some(match (self.pose, self.counts) {
            (Some(pose), Some(before)) => wheels.rolled(pose, before, counts)?,
            _ => self.past_pose(sampled_at_ns)?,
        });
        self.counts = Some(counts);
        self.past.clear();
        Some(())
    }

    /// The robot's pose at an instant, as far as that is remembered; the newest if the instant is not known.
    fn past_pose(&self, at_ns: Option<u64>) -> Option<Pose> {
        let by_then = self.past.iter().rev().find(|(time_ns, _)| at_ns.is_none_or(|at_ns| *time_ns <= at_ns));
        by_then.or_else(|| self.past.front()).map(|(_, pose)| *pose)
    }
}

impl Wheels {
    fn new(robot: &v1::RobotDescription, encoders: &v1::SensorDescription) -> Self {
        let encoding = encoders.components.first().and_then(|component| component.encoding.as_ref()?.kind);
        let wraps_at = match encoding {
            Some(v1::encoding::Kind::Counter(counter)) => 2f64.powi(counter.bits.min(64) as i32),
            _ => 0.0,
        };
        let counts_per_turn = f64::from(encoders.counts_per_turn.unwrap_or(1));
        let way_per_count_m = TAU * robot.wheel_radius_m / counts_per_turn;
        Self { way_per_count_m, half_track_m: robot.half_track_m, wraps_at }
    }

    /// The pose after the counters went from some numbers to others; none if that is nowhere.
    fn rolled(&self, from: Pose, before: [f64; 2], now: [f64; 2]) -> Option<Pose> {
        let ways_m = [0, 1].map(|i| self.way_per_count_m * self.counted(before[i], now[i]));
        let Twist { forward, turn } = Twist::of_wheels(ways_m, self.half_track_m);
        let (sin, cos) = (from.heading + 0.5 * turn).sin_cos();
        let (x_m, y_m) = (from.position.x + forward * cos, from.position.y + forward * sin);
        sound_pose(x_m, y_m, (from.heading + turn).rem_euclid(TAU))
    }

    /// The change of a counter, the shorter way round if it wraps.
    fn counted(&self, before: f64, now: f64) -> f64 {
        let difference = now - before;
        if self.wraps_at > 0.0 {
            difference - self.wraps_at * (difference / self.wraps_at).round()
        } else {
            difference
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn robot(kind: SensorKind) -> v1::RobotDescription {
        let kind_of = v1::encoding::Kind::Counter(v1::encoding::Counter { bits: 8 });
        let encoding = Some(v1::Encoding { kind: Some(kind_of) });
        let component = v1::ComponentDescription { encoding, ..v1::ComponentDescription::default() };
        let other = v1::SensorDescription { kind: SensorKind::Ir.into(), ..v1::SensorDescription::default() };
        let sensor = v1::SensorDescription {
            kind: kind.into(),
            counts_per_turn: (kind == SensorKind::Encoders).then_some(100),
            components: vec![component],
            ..v1::SensorDescription::default()
        };
        v1::RobotDescription {
            half_track_m: 0.1,
            wheel_radius_m: 1.0 / TAU,
            sensors: vec![other, sensor],
            ..v1::RobotDescription::default()
        }
    }

    fn reading(values: &[f64], sampled_at_ns: Option<u64>) -> [v1::SensorDetail; 2] {
        let detail =
            v1::SensorDetail { values: values.to_vec(), sampled_at_ns, ..v1::SensorDetail::default() };
        [v1::SensorDetail::default(), detail]
    }

    #[test]
    fn encoders_roll_on_from_where_the_robot_was_when_the_first_reading_was_taken() {
        let mut dead_reckoning = DeadReckoning::of(&robot(SensorKind::Encoders)).unwrap();
        dead_reckoning.note(0, Pose::new(1.0, 2.0, FRAC_PI_2));
        dead_reckoning.note(100, Pose::new(9.0, 9.0, 0.0));
        dead_reckoning.take(&reading(&[], None));
        dead_reckoning.take(&reading(&[f64::NAN, 0.0], Some(10)));
        assert_eq!(dead_reckoning.pose(), None);
        dead_reckoning.take(&reading(&[250.0, 250.0], Some(50)));
        assert_eq!(dead_reckoning.pose(), Some(Pose::new(1.0, 2.0, FRAC_PI_2)));
        // Half a turn of both wheels, over the counter's end at 256, is half a metre straight on.
        dead_reckoning.take(&reading(&[44.0, 44.0], Some(150)));
        dead_reckoning.take(&reading(&[77.0, 77.0], Some(150)));
        let pose = dead_reckoning.pose().unwrap();
        assert!((pose.position.y - 2.5).abs() < 1e-12 && (pose.position.x - 1.0).abs() < 1e-12, "{pose:?}");
    }

    #[test]
    fn wheels_that_go_against_each_other_turn_it_on_the_spot() {
        let wheels = Wheels::new(&robot(SensorKind::Encoders), &robot(SensorKind::Encoders).sensors[1]);
        // A quarter turn: each wheel goes half_track · π/2.
        let counts = 0.1 * FRAC_PI_2 * 100.0;
        let turned = wheels.rolled(Pose::new(0.0, 0.0, 0.0), [0.0, 0.0], [-counts, counts]).unwrap();
        assert!((turned.heading - FRAC_PI_2).abs() < 1e-12, "{turned:?}");
        assert!(turned.position.coords.norm() < 1e-12, "{turned:?}");
    }

    #[test]
    fn a_jump_to_nowhere_is_no_way() {
        let mut dead_reckoning = DeadReckoning::of(&robot(SensorKind::Encoders)).unwrap();
        dead_reckoning.note(0, Pose::new(0.0, 0.0, 0.0));
        dead_reckoning.take(&reading(&[0.0, 0.0], Some(0)));
        dead_reckoning.take(&reading(&[f64::MAX, -f64::MAX], Some(1)));
        dead_reckoning.take(&reading(&[100.0, 100.0], Some(2)));
        let pose = dead_reckoning.pose().unwrap();
        assert!(pose.position.coords.norm().is_finite() && pose.heading.is_finite(), "{pose:?}");
    }

    #[test]
    fn an_odometer_is_believed_and_a_reset_forgets() {
        let mut dead_reckoning = DeadReckoning::of(&robot(SensorKind::Odometer)).unwrap();
        dead_reckoning.take(&reading(&[1.0, 2.0, PI], None));
        assert_eq!(dead_reckoning.pose(), Some(Pose::new(1.0, 2.0, PI)));
        dead_reckoning.take(&reading(&[f64::NAN, 2.0, PI], None));
        assert_eq!(dead_reckoning.pose(), Some(Pose::new(1.0, 2.0, PI)));
        dead_reckoning.forget();
        assert_eq!(dead_reckoning.pose(), None);
    }

    #[test]
    fn a_robot_whose_sensors_tell_nothing_of_wheels_has_no_ghost() {
        assert!(DeadReckoning::of(&robot(SensorKind::Compass)).is_none());
        let broken = v1::RobotDescription { half_track_m: 0.0, ..robot(SensorKind::Encoders) };
        assert!(DeadReckoning::of(&broken).is_none());
    }
}
