//! The messages of a robot on its topics.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use baudbot_geometry::Fan;
use baudbot_sim::drive::Wheels;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::{Device, Laser, Odometer, Sensor, SensorKind};
use baudbot_sim::{Pose, RobotView, SimTime};

use super::covariance::{CERTAIN, Planar, variance};
use super::messages::{self, Inertia, Kind, Measured, Moving, Scan, Stamp};
use super::ranger::{Ranger, is_fixed};
use crate::error::Refused;

/// A message: its topic, its kind, its bytes.
pub(super) type Said = (String, &'static Kind, Vec<u8>);

/// A robot, and the last readings of its sensors.
pub(super) struct Robot {
    /// The prefix of topics and frames; empty if it is alone.
    prefix: String,
    /// The instants at which each sensor was read last.
    sampled_at: Vec<Option<SimTime>>,
    /// Topics and frames of those that have them, by the place among the sensors.
    placed: Vec<Option<Placed>>,
    /// The pose by the odometer, and its instant.
    believed: Option<(u64, Pose)>,
    /// The certainty of that.
    certainty: Planar,
    has_noise: bool,
    inertia: Inertia,
    signals: Option<Wheels>,
}

/// A sensor with a frame and a topic of its own.
struct Placed {
    topic: String,
    frame: String,
    /// The sensor, if it is no laser.
    ranger: Option<Ranger>,
}

impl Robot {
    pub(super) fn of(spec: &RobotSpec, has_others: bool, has_noise: bool) -> Self {
        let prefix = if has_others { format!("{}/", token(&spec.name)) } else { String::new() };
        let count = spec.sensors.iter().filter(|sensor| is_fixed_laser(sensor)).count();
        let names = |sensor: &Sensor| {
            let name = token(&sensor.name);
            let ranger = Ranger::of(&sensor.device);
            let topic = match &ranger {
                Some(_) => format!("/{prefix}{name}/range"),
                None if count == 1 => format!("/{prefix}scan"),
                None => format!("/{prefix}{name}/scan"),
            };
            let has_frame = ranger.is_some() || is_fixed_laser(sensor);
            has_frame.then(|| Placed { topic, frame: format!("{prefix}{name}"), ranger })
        };
        Self {
            sampled_at: vec![None; spec.sensors.len()],
            placed: spec.sensors.iter().map(names).collect(),
            prefix,
            believed: None,
            certainty: Planar::certain(),
            has_noise,
            inertia: Inertia::default(),
            signals: None,
        }
    }

    /// The messages at the start of a tick; the first one also has those that stay, and of those that come with ticks
    /// only the ones that are due.
    pub(super) fn say(
        &mut self,
        robot: &RobotView<'_>,
        now_ns: u64,
        (is_first, is_due): (bool, bool),
    ) -> Vec<Said> {
        let mut said = Vec::new();
        if is_first {
            said.extend(self.static_frames(robot, now_ns));
        }
        said.extend(self.command(robot));
        let mut has_moved = None;
        for (i, (view, sensor)) in robot.sensors().zip(robot.spec().sensors.iter()).enumerate() {
            let at = view.sampled_at;
            if view.samples == 0 || self.sampled_at[i].replace(at) == Some(at) {
                continue;
            }
            let (kind, values) = (sensor.device.sensor_kind(), view.sample);
            if let Device::Laser(laser) = &sensor.device {
                said.extend(self.scan(i, (laser, sensor), at, values));
            } else if let Some(range) = self.range(i, at, values) {
                said.push(range);
            } else if let (Device::Odometer(odometer), &[x, y, heading]) = (&sensor.device, values) {
                let half_track_m = robot.spec().drive.half_track_m;
                said.push(self.odometry(at, Pose::new(x, y, heading), (odometer, sensor, half_track_m)));
            } else {
                let measured = self.measured(sensor, values);
                has_moved = self.inertia.take(kind, &measured).then_some(at).or(has_moved);
            }
        }
        said.extend(has_moved.map(|at| self.imu(at)));
        if is_due {
            said.extend(self.truth(robot, now_ns));
        }
        said
    }

    fn frame(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    fn topic(&self, name: &str) -> String {
        format!("/{}{name}", self.prefix)
    }

    fn static_frames(&self, robot: &RobotView<'_>, now_ns: u64) -> Option<Said> {
        let base = self.frame("base_link");
        let sensors = robot.spec().sensors.iter().zip(&self.placed);
        let mounted = sensors.filter_map(|(sensor, placed)| {
            Some((base.as_str(), placed.as_ref()?.frame.as_str(), sensor.device.mount()?.pose))
        });
        let all: Vec<_> = mounted.collect();
        let said = || ("/tf_static".to_owned(), &messages::TF, messages::transforms(now_ns, &all));
        (!all.is_empty()).then(said)
    }

    /// The command of the motors, if it is speeds: those of DC motors are voltages.
    fn command(&mut self, robot: &RobotView<'_>) -> Option<Said> {
        let signals = robot.signals();
        if self.signals.replace(signals) == Some(signals) {
            return None;
        }
        let drive = &robot.spec().drive;
        let rim_m_s = |signal: f64| match &drive.motor {
            Motors::Dc(_) => None,
            Motors::Velocity(motor) => Some(motor.reference_m_s(signal)),
            Motors::Servo(servo) => Some(drive.wheel_radius_m * servo.target_rad_s(signal)),
            Motors::Stepper(stepper) => {
                Some(drive.wheel_radius_m * TAU * stepper.full_rate_steps_s * signal / stepper.steps_per_turn)
            }
        };
        let (left, right) = (rim_m_s(signals.left)?, rim_m_s(signals.right)?);
        let twist = [0.5 * (left + right), 0.5 * (right - left) / drive.half_track_m];
        Some((self.topic("cmd_vel"), &messages::TWIST, messages::twist(twist)))
    }

    fn scan(
        &self,
        i: usize,
        (laser, sensor): (&Laser, &Sensor),
        at: SimTime,
        distances_m: &[f64],
    ) -> Option<Said> {
        let Placed { topic, frame, .. } = self.placed[i].as_ref()?;
        let half_rad = 0.5 * laser.fan.opening_rad();
        let ends_rad = if laser.clockwise { [half_rad, -half_rad] } else { [-half_rad, half_rad] };
        let period_ns =
            sensor.own_clock.as_ref().map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns);
        let scan = Scan {
            ends_rad,
            sweep_s: laser.sweep_ns as f64 * 1e-9,
            period_s: period_ns as f64 * 1e-9,
            range_m: [laser.min_m, laser.range_m],
            distances_m,
            ends_meet: ends_meet(&laser.fan),
        };
        let stamp = Stamp { ns: at.as_ns(), frame };
        Some((topic.clone(), &messages::LASER_SCAN, messages::laser_scan(stamp, &scan)))
    }

    fn range(&self, i: usize, at: SimTime, values: &[f64]) -> Option<Said> {
        let Placed { topic, frame, ranger } = self.placed[i].as_ref()?;
        let reading = ranger.as_ref()?.reading(*values.first()?);
        let stamp = Stamp { ns: at.as_ns(), frame };
        Some((topic.clone(), &messages::RANGE, messages::range(stamp, &reading)))
    }

    /// The values with their variances.
    fn measured(&self, sensor: &Sensor, values: &[f64]) -> Vec<Measured> {
        let of = |(i, &value)| (value, variance(sensor, i, value, self.has_noise));
        values.iter().enumerate().map(of).collect()
    }

    /// Its speeds are those between the last two readings. The certainty of its pose follows from the noise of its
    /// wheels' ways; wheels that slip or are not as large as they should be cannot be noticed on board.
    fn odometry(
        &mut self,
        at: SimTime,
        pose: Pose,
        (odometer, sensor, half_track_m): (&Odometer, &Sensor, f64),
    ) -> Said {
        let wheel_variance = if self.has_noise { odometer.sigma_m * odometer.sigma_m } else { 0.0 };
        // Half the sum of the ways is the way, and their difference over the track the turn.
        let variances = [0.5 * wheel_variance, 0.5 * wheel_variance / (half_track_m * half_track_m)];
        let mut speeds = [0.0; 2];
        let mut of_speeds = [CERTAIN; 2];
        if let Some((before_ns, before)) = self.believed.replace((at.as_ns(), pose))
            && before_ns < at.as_ns()
        {
            let dt_s = (at.as_ns() - before_ns) as f64 * 1e-9;
            let moved = before.inverse().compose(&pose);
            speeds = [moved.position.x / dt_s, baudbot_geometry::angle::wrap(moved.heading) / dt_s];
            of_speeds = variances.map(|variance| CERTAIN + variance / (dt_s * dt_s));
            self.certainty = self.certainty.after(pose.heading, moved.position.x, variances);
        }
        let of_reading = self.measured(sensor, &[pose.position.x, pose.position.y, pose.heading]);
        let pose_covariance = self.certainty.plus([of_reading[0].1, of_reading[1].1, of_reading[2].1]);
        let speed_covariance = Planar::diagonal([of_speeds[0], CERTAIN, of_speeds[1]]);
        let (frame, child) = (self.frame("odom"), self.frame("base_link"));
        let stamp = Stamp { ns: at.as_ns(), frame: &frame };
        let moving = Moving { pose, pose_covariance, speeds, speed_covariance };
        (self.topic("odom"), &messages::ODOMETRY, messages::odometry(stamp, &child, &moving))
    }

    fn imu(&self, at: SimTime) -> Said {
        let frame = self.frame("base_link");
        let stamp = Stamp { ns: at.as_ns(), frame: &frame };
        (self.topic("imu"), &messages::IMU, messages::imu(stamp, self.inertia))
    }

    /// The true pose, and the frames that lead to it by way of the odometer's pose.
    fn truth(&self, robot: &RobotView<'_>, now_ns: u64) -> [Said; 2] {
        let motion = robot.motion();
        let (odom, base) = (self.frame("odom"), self.frame("base_link"));
        let believed = self.believed.map_or(motion.pose, |(_, pose)| pose);
        let map_from_odom = motion.pose.compose(&believed.inverse());
        let all = [("map", odom.as_str(), map_from_odom), (odom.as_str(), base.as_str(), believed)];
        let stamp = Stamp { ns: now_ns, frame: "map" };
        let speeds = [motion.speed_m_s, motion.turn_rate_rad_s];
        let [pose_covariance, speed_covariance] = [Planar::certain(); 2];
        let moving = Moving { pose: motion.pose, pose_covariance, speeds, speed_covariance };
        let truth = messages::odometry(stamp, &base, &moving);
        [
            ("/tf".to_owned(), &messages::TF, messages::transforms(now_ns, &all)),
            (self.topic("ground_truth"), &messages::ODOMETRY, truth),
        ]
    }
}

/// Refuses robots, and sensors of a robot with frames of their own, that would have one name in a bag.
pub(in crate::export) fn check_names(robots: &[RobotSpec]) -> anyhow::Result<()> {
    let same = |(one, other): (&str, &str)| format!("`{one}` and `{other}`");
    if let Some((both, token)) = same_token(robots.iter().map(|robot| robot.name.as_str())) {
        let both = same(both);
        return Err(Refused::error(format!("robots {both} would both be `{token}` in a bag; rename one")));
    }
    for robot in robots {
        let has_frame = |sensor: &&Sensor| is_fixed_laser(sensor) || Ranger::of(&sensor.device).is_some();
        let sensors = robot.sensors.iter().filter(has_frame);
        if let Some((both, token)) = same_token(sensors.map(|sensor| sensor.name.as_str())) {
            let (both, robot) = (same(both), &robot.name);
            return Err(Refused::error(format!(
                "sensors {both} of `{robot}` would both be `{token}` in a bag; rename one"
            )));
        }
    }
    Ok(())
}

/// The first two names that would be the same to ROS, and what both would be.
fn same_token<'a>(names: impl Iterator<Item = &'a str>) -> Option<((&'a str, &'a str), String)> {
    let mut before = BTreeMap::new();
    for name in names {
        if let Some(other) = before.insert(token(name), name) {
            return Some(((other, name), token(name)));
        }
    }
    None
}

/// Whether it is a laser whose place on the robot does not change.
fn is_fixed_laser(sensor: &Sensor) -> bool {
    let mount = sensor.device.mount().filter(|_| sensor.device.sensor_kind() == SensorKind::Laser);
    mount.is_some_and(is_fixed)
}

/// Whether the last ray of a fan stands where the first does, a full turn on.
pub(crate) fn ends_meet(fan: &Fan) -> bool {
    let gap_rad = fan.opening_rad() / (fan.len().max(2) - 1) as f64;
    fan.len() > 2 && TAU - fan.opening_rad() < NO_GAP * gap_rad
}

/// Two rays that are less than this part of a gap apart are one.
const NO_GAP: f64 = 0.01;

/// A name as topics and frames of ROS may have it.
fn token(name: &str) -> String {
    let mut token: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if token.starts_with(|c: char| c.is_ascii_digit()) {
        token.insert(0, '_');
    }
    token
}
