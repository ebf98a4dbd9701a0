//! What a robot says on its topics.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use baudbot_sim::drive::Wheels;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::{Device, Laser, Sensor, SensorKind};
use baudbot_sim::{Pose, RobotView, SimTime};

use super::messages::{self, Inertia, Kind, Scan, Stamp};
use crate::error::Refused;

/// A message: its topic, its kind, its bytes.
pub(super) type Said = (String, &'static Kind, Vec<u8>);

/// A robot, and what it has said.
pub(super) struct Robot {
    /// What topics and frames begin with; empty if it is alone.
    prefix: String,
    /// Of each sensor, when it was read last.
    sampled_at: Vec<Option<SimTime>>,
    /// Topics and frames of lasers, by the place among the sensors.
    lasers: Vec<Option<(String, String)>>,
    /// What the odometer says, and when it said so.
    believed: Option<(u64, Pose)>,
    inertia: Inertia,
    signals: Option<Wheels>,
}

impl Robot {
    pub(super) fn of(spec: &RobotSpec, has_others: bool) -> Self {
        let prefix = if has_others { format!("{}/", token(&spec.name)) } else { String::new() };
        let count = spec.sensors.iter().filter(|sensor| is_fixed_laser(sensor)).count();
        let names = |sensor: &Sensor| {
            let name = token(&sensor.name);
            let topic = if count == 1 { format!("/{prefix}scan") } else { format!("/{prefix}{name}/scan") };
            is_fixed_laser(sensor).then(|| (topic, format!("{prefix}{name}")))
        };
        Self {
            sampled_at: vec![None; spec.sensors.len()],
            lasers: spec.sensors.iter().map(names).collect(),
            prefix,
            believed: None,
            inertia: Inertia::default(),
            signals: None,
        }
    }

    /// What it says at the start of a tick; in the first one also what stays, and of what comes with ticks only what is due.
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
            } else if let (SensorKind::Odometer, &[x, y, heading]) = (kind, values) {
                said.push(self.odometry(at, Pose::new(x, y, heading)));
            } else if self.inertia.take(kind, values) {
                has_moved = Some(at);
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
        let sensors = robot.spec().sensors.iter().zip(&self.lasers);
        let mounted = sensors.filter_map(|(sensor, laser)| {
            let (_, frame) = laser.as_ref()?;
            Some((base.as_str(), frame.as_str(), sensor.device.mount()?.pose))
        });
        let all: Vec<_> = mounted.collect();
        let said = || ("/tf_static".to_owned(), &messages::TF, messages::transforms(now_ns, &all));
        (!all.is_empty()).then(said)
    }

    /// What the motors are told, if it is speeds: those of DC motors are told voltages.
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
        let (topic, frame) = self.lasers[i].as_ref()?;
        let half_rad = 0.5 * laser.fan.opening_rad();
        let angles_rad = if laser.clockwise { [half_rad, -half_rad] } else { [-half_rad, half_rad] };
        let period_ns =
            sensor.own_clock.as_ref().map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns);
        let scan = Scan {
            angles_rad,
            sweep_s: laser.sweep_ns as f64 * 1e-9,
            period_s: period_ns as f64 * 1e-9,
            range_m: [laser.min_m, laser.range_m],
            distances_m,
        };
        let stamp = Stamp { ns: at.as_ns(), frame };
        Some((topic.clone(), &messages::LASER_SCAN, messages::laser_scan(stamp, &scan)))
    }

    /// Its speeds are those between the last two readings.
    fn odometry(&mut self, at: SimTime, pose: Pose) -> Said {
        let speeds = match self.believed.replace((at.as_ns(), pose)) {
            Some((before_ns, before)) if before_ns < at.as_ns() => {
                let dt_s = (at.as_ns() - before_ns) as f64 * 1e-9;
                let moved = before.inverse().compose(&pose);
                [moved.position.x / dt_s, baudbot_geometry::angle::wrap(moved.heading) / dt_s]
            }
            Some(_) | None => [0.0; 2],
        };
        let (frame, child) = (self.frame("odom"), self.frame("base_link"));
        let stamp = Stamp { ns: at.as_ns(), frame: &frame };
        (self.topic("odom"), &messages::ODOMETRY, messages::odometry(stamp, &child, &pose, speeds))
    }

    fn imu(&self, at: SimTime) -> Said {
        let frame = self.frame("base_link");
        let stamp = Stamp { ns: at.as_ns(), frame: &frame };
        (self.topic("imu"), &messages::IMU, messages::imu(stamp, self.inertia))
    }

    /// The true pose, and the frames that lead to it by way of what the odometer says.
    fn truth(&self, robot: &RobotView<'_>, now_ns: u64) -> [Said; 2] {
        let motion = robot.motion();
        let (odom, base) = (self.frame("odom"), self.frame("base_link"));
        let believed = self.believed.map_or(motion.pose, |(_, pose)| pose);
        let map_from_odom = motion.pose.compose(&believed.inverse());
        let all = [("map", odom.as_str(), map_from_odom), (odom.as_str(), base.as_str(), believed)];
        let stamp = Stamp { ns: now_ns, frame: "map" };
        let speeds = [motion.speed_m_s, motion.turn_rate_rad_s];
        let truth = messages::odometry(stamp, &base, &motion.pose, speeds);
        [
            ("/tf".to_owned(), &messages::TF, messages::transforms(now_ns, &all)),
            (self.topic("ground_truth"), &messages::ODOMETRY, truth),
        ]
    }
}

/// Refuses robots, and lasers of a robot, that would have one name in a bag.
pub(in crate::export) fn check_names(robots: &[RobotSpec]) -> anyhow::Result<()> {
    let same = |(one, other): (&str, &str)| format!("`{one}` and `{other}`");
    if let Some((both, token)) = same_token(robots.iter().map(|robot| robot.name.as_str())) {
        let both = same(both);
        return Err(Refused::error(format!("robots {both} would both be `{token}` in a bag; rename one")));
    }
    for robot in robots {
        let lasers = robot.sensors.iter().filter(|sensor| is_fixed_laser(sensor));
        if let Some((both, token)) = same_token(lasers.map(|sensor| sensor.name.as_str())) {
            let (both, robot) = (same(both), &robot.name);
            return Err(Refused::error(format!(
                "lasers {both} of `{robot}` would both be `{token}` in a bag; rename one"
            )));
        }
    }
    Ok(())
}

/// The first two names that ROS would not tell apart, and what both would be.
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
    mount.is_some_and(|mount| mount.turret.is_none())
}

/// A name as topics and frames of ROS may have it.
fn token(name: &str) -> String {
    let mut token: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if token.starts_with(|c: char| c.is_ascii_digit()) {
        token.insert(0, '_');
    }
    token
}
