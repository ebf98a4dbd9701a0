//! A robot that explores, once its pose is known: its readings, and signals for the commands of its explorer.
//!
//! Turns and ways become motor signals by proportional control of heading and speed, closed over the believed pose.
//!
//! *Deviations.*
//!
//! - Something counts as near, too, if the robot ought to drive and has not moved for two seconds.
//! - A sonar does not say where in its cone something is: the posts of a door that the robot fits through seem to be in its way. So
//!   an echo of what the laser sees, too, does not count: the laser says where that is.
//! - The robot stops as soon as something is near, and takes that for true if it is so for a while: single rays are
//!   wrong by more than a door leaves room.

mod watch;

use baudbot_brain::{Body, Sensor, SensorKind, Signals, Turn};
use baudbot_geometry::{Point, Pose, angle, math};

use super::brain::Parameters;
use super::placement::Placement;
use super::{Command, Explorer, Frontiers, Input, Nodes, approach, frontiers, nodes, placement, walkers};
use crate::mapping::PlacedScan;
use crate::proximity_sensors::{Echo, Near, ProximitySensors, is_in_way};
use crate::throttle::within;
use watch::{Verdict, Watch};

/// An explorer with a body.
pub(super) struct Scout {
    parameters: Parameters,
    explorer: Box<dyn Explorer + Send>,
    half_track_m: f64,
    radius_m: f64,
    /// A greater signal is refused.
    signal_limit: Option<f64>,
    proximity: ProximitySensors,
    /// Since when, and where, the robot ought to have been driving.
    driving_since: Option<(u64, Point)>,
    /// Since when something has been near.
    near_since: Option<u64>,
    watch: Watch,
    /// The instant of the last check that the explorer makes progress.
    watched_ns: Option<u64>,
    /// The last scan, and when it came.
    scan: Option<(PlacedScan, u64)>,
    /// The greatest speed that is safe with people near, in metres a second.
    safe_m_s: f64,
    command: Command,
}

impl Scout {
    /// A `Scout` of a robot with this body, and a laser of this range.
    pub(super) fn new(parameters: Parameters, body: &Body, range_m: f64) -> Self {
        let parameters = parameters.of_body(body.radius_m);
        let near = Near { near_m: parameters.near_m, near_reading: parameters.near_reading };
        let speed_m_s = parameters.speed_m_s.min(EASY_HZ * body.radius_m);
        Self {
            explorer: explorer(&parameters, body.radius_m, range_m),
            half_track_m: body.half_track_m,
            radius_m: body.radius_m,
            signal_limit: body.signal_limit,
            proximity: ProximitySensors::new(body, near),
            driving_since: None,
            near_since: None,
            watch: Watch::new(body.radius_m, speed_m_s),
            watched_ns: None,
            scan: None,
            safe_m_s: f64::INFINITY,
            command: Command::Wait,
            parameters,
        }
    }

    /// Takes in what is near.
    pub(super) fn feel(&mut self, turn: &Turn) {
        self.proximity.feel(turn);
    }

    /// One step from here, with the last scan. Signals are such that the motors take them; the robot will have a part of them,
    /// which is its `haste`.
    pub(super) fn step(&mut self, at_ns: u64, here: &Pose, scan: Option<&PlacedScan>, haste: f64) -> Signals {
        let is_stalled = self.is_stalled(at_ns, here.position, haste);
        let is_known = |echo: &Echo| scan.is_some_and(|scan| shows(scan, here, echo));
        // The way does not go beyond its end.
        let way_m = self.path().map_or(f64::INFINITY, |to| (to - here.position).norm());
        let near = self.proximity.is_near_but(way_m, is_known)
            || scan.is_some_and(|scan| self.sees_near(here, scan, way_m));
        let since_ns = near.then(|| *self.near_since.get_or_insert(at_ns));
        self.near_since = since_ns;
        let is_sure = since_ns.is_some_and(|since_ns| at_ns.saturating_sub(since_ns) >= SURE_NS);
        let input = Input { world_from_robot: *here, scan, near: is_stalled || is_sure };
        self.command = self.explorer.step(&input);
        self.watch(at_ns, here, haste);
        self.look_for_walkers(at_ns, here, scan);
        if matches!(self.command, Command::Drive { .. }) && (near || self.waits_for_somebody()) {
            if self.waits_for_somebody() {
                self.pause();
            }
            return Signals::default();
        }
        within(self.signal_limit, self.signals(here, scan))
    }

    /// Ends what does not get on.
    fn watch(&mut self, at_ns: u64, here: &Pose, haste: f64) {
        let since_ns = *self.watched_ns.get_or_insert(at_ns);
        let passed_ns = at_ns.saturating_sub(since_ns);
        if matches!(self.command, Command::Done(_) | Command::Failed(_)) || passed_ns < WATCH_NS {
            return;
        }
        self.watched_ns = Some(at_ns);
        // A robot that stood for another reason has not driven in vain.
        let passed_s = passed_ns.min(2 * WATCH_NS) as f64 * 1e-9 * haste;
        let stands = matches!(self.command, Command::Wait) || self.waits_for_somebody();
        let passed_s = if stands { 0.0 } else { passed_s };
        let known_m2 = self.explorer.grid().known_m2();
        match self.watch.look(passed_s, self.explorer.goal(here), known_m2) {
            Verdict::GoesOn => {}
            Verdict::Abandon => self.explorer.abandon(),
            Verdict::Ends => self.explorer.finish(here),
        }
    }

    /// Limits the speed by walkers ahead.
    fn look_for_walkers(&mut self, at_ns: u64, here: &Pose, scan: Option<&PlacedScan>) {
        let Some(scan) = scan else { return };
        if self.scan.as_ref().is_none_or(|(old, _)| old != scan) {
            self.scan = Some((scan.clone(), at_ns));
        }
        let age_s =
            self.scan.as_ref().map_or(0.0, |(_, since_ns)| at_ns.saturating_sub(*since_ns) as f64 * 1e-9);
        let body = (self.radius_m, self.parameters.speed_m_s);
        self.safe_m_s = walkers::safe_m_s(self.explorer.grid(), scan, here, body, age_s);
    }

    /// A person is so near that the robot may not drive.
    fn waits_for_somebody(&self) -> bool {
        self.safe_m_s < CRAWL_M_S
    }

    /// The robot stands for a reason outside of exploration.
    pub(super) fn pause(&mut self) {
        self.driving_since = None;
    }

    /// Something else may have driven it.
    pub(super) fn interrupt(&mut self) {
        self.pause();
        self.proximity.forget();
        self.explorer.interrupt();
        self.watch.rest();
    }

    /// The explorer's last command.
    pub(super) const fn command(&self) -> Command {
        self.command
    }

    /// Whether it stands until a scan comes: the first, or one that was taken where it now is.
    pub(super) fn waits_for_scan(&self) -> bool {
        matches!(self.command, Command::Wait)
    }

    /// The robot's present activity, in words.
    pub(super) fn intention(&self) -> String {
        let activity = match self.command {
            Command::Wait => "waits for a scan",
            Command::Turn { .. } => "turns",
            Command::Drive { .. } if self.waits_for_somebody() => "waits for somebody",
            Command::Drive { .. } => "drives",
            Command::Done(left_out) => return left_out.to_string(),
            Command::Failed(failure) => return format!("gave up: {failure:?}"),
        };
        match self.watch.without_news_s() {
            None => activity.to_owned(),
            Some(seconds) => format!("{activity}, and has seen nothing new for {seconds} s"),
        }
    }

    /// The next place on its way, if it has one.
    pub(super) fn path(&self) -> Option<Point> {
        match self.command {
            Command::Drive { to } => Some(to),
            Command::Wait | Command::Turn { .. } | Command::Done(_) | Command::Failed(_) => None,
        }
    }

    /// Whether a scan shows something in the way that is near: sonars overlook edges, and walls that they meet at an
    /// acute angle.
    fn sees_near(&self, here: &Pose, scan: &PlacedScan, way_m: f64) -> bool {
        let forward = here.direction();
        let in_robot = |end: Point| Point::from(forward.inverse().apply(end - here.position));
        let (ahead_m, room_m) = (self.parameters.near_m.min(way_m), self.radius_m + BARELY_M);
        scan.ends().any(|(end, met)| met && is_in_way(in_robot(end), ahead_m, room_m))
    }

    /// The speed for as much room as there is: a small robot between walls is as slow as it is small, and who walks slows down any.
    fn most_m_s(&self, here: &Pose, scan: Option<&PlacedScan>) -> f64 {
        let ends = scan.iter().flat_map(|scan| scan.ends()).filter(|(_, met)| *met);
        let nearest_m = ends.map(|(end, _)| (end - here.position).norm()).fold(f64::INFINITY, f64::min);
        let room_m = (nearest_m - self.radius_m).max(0.0);
        let easy_m_s = EASY_HZ * (self.radius_m + room_m);
        self.parameters.speed_m_s.min(easy_m_s).min(self.safe_m_s)
    }

    /// Whether it ought to drive and has not moved for too long: the longer, the more slowly it may drive.
    fn is_stalled(&mut self, at_ns: u64, here: Point, haste: f64) -> bool {
        if !matches!(self.command, Command::Drive { .. }) {
            self.driving_since = None;
            return false;
        }
        let since = self.driving_since.get_or_insert((at_ns, here));
        if (here - since.1).norm() > MOVED_M {
            *since = (at_ns, here);
        }
        at_ns.saturating_sub(since.0) as f64 * haste > STALLED_NS as f64
    }

    /// Signals of the left and the right motor.
    fn signals(&self, here: &Pose, scan: Option<&PlacedScan>) -> Signals {
        let p = &self.parameters;
        let (speed, turn_rate) = match self.command {
            Command::Wait | Command::Done(_) | Command::Failed(_) => (0.0, 0.0),
            Command::Turn { heading_rad } => {
                let aside = angle::difference(heading_rad, here.heading);
                let rate = (TURN_GAIN_HZ * aside.abs())
                    .clamp(LEAST_RATE_RAD_S.min(p.turn_rate_rad_s), p.turn_rate_rad_s);
                (0.0, rate.copysign(aside))
            }
            Command::Drive { to } => {
                let aside = angle::difference(approach::heading_to(here, to), here.heading);
                let way_m = (to - here.position).norm();
                let most = self.most_m_s(here, scan);
                let speed = (SPEED_GAIN_HZ * way_m)
                    .clamp((LEAST_HZ * self.radius_m).min(LEAST_SPEED_M_S).min(most), most);
                let rate = (TURN_GAIN_HZ * aside).clamp(-p.turn_rate_rad_s, p.turn_rate_rad_s);
                (speed * math::cos(aside).max(0.0), rate)
            }
        };
        let wheel = |side: f64| (speed + side * turn_rate * self.half_track_m) / p.full_speed_m_s;
        Signals { left: wheel(-1.0), right: wheel(1.0) }
    }
}

/// Whether a scan contains the object of a sonar's echo.
fn shows(scan: &PlacedScan, here: &Pose, echo: &Echo) -> bool {
    let world_from_sonar = here.compose(&echo.robot_from_sensor);
    scan.ends().any(|(end, met)| {
        let offset = end - world_from_sonar.position;
        let aside = || angle::difference(math::atan2(offset.y, offset.x), world_from_sonar.heading);
        let is_there = (offset.norm() - echo.distance_m).abs() <= SAME_M;
        met && is_there && aside().abs() <= echo.half_rad + SAME_RAD
    })
}

/// The first laser with level rays that sits on the body itself.
pub(super) fn laser(body: &Body) -> Option<&Sensor> {
    let is_fixed = |sensor: &&Sensor| sensor.mount.is_some_and(|mount| mount.is_fixed_and_level());
    body.sensors.iter().filter(|sensor| sensor.kind == SensorKind::Laser).find(is_fixed)
}

fn explorer(parameters: &Parameters, radius_m: f64, range_m: f64) -> Box<dyn Explorer + Send> {
    let Parameters { distance_m, margin_m, width_rad, separation_m, cell_m, .. } = *parameters;
    let map = frontiers::Parameters { cell_m, ..frontiers::Parameters::of_body(radius_m) };
    if parameters.method >= 0.5 {
        return Box::new(Frontiers::new(map));
    }
    let width_rad =
        if width_rad > 0.0 { width_rad } else { placement::width_rad(map.least_width_m(), distance_m) };
    Box::new(Nodes::new(nodes::Parameters {
        placement: Placement { distance_m, margin_m, width_rad, separation_m },
        sight_m: parameters.sight_m.min(range_m),
        map,
    }))
}

/// Room beside the robot for what the laser sees, which from so near is where it is seen but for half a centimetre, in metres.
const BARELY_M: f64 = 0.005;
/// An echo and the end of a ray that are no farther apart than so, in metres, ...
const SAME_M: f64 = 0.05;
/// ... and so, in radians, are of the same thing: at 0.3 m/s the robot goes 3 cm between them.
const SAME_RAD: f64 = 0.1;
/// The time, in nanoseconds, after which a near object counts as sure: two scans, and two readings of a sonar.
const SURE_NS: u64 = 250_000_000;
/// Turn rate for each radian to be turned.
const TURN_GAIN_HZ: f64 = 2.0;
/// Least rate of a turn, in rad/s: motors stand still below some signal.
const LEAST_RATE_RAD_S: f64 = 0.15;
/// Speed for each metre that is left.
const SPEED_GAIN_HZ: f64 = 1.5;
/// Least speed for each metre of the body's radius, ...
const LEAST_HZ: f64 = 0.4;
/// ... and no more than that, in m/s.
const LEAST_SPEED_M_S: f64 = 0.08;
/// Speed for each metre from the robot's centre to what is nearest.
const EASY_HZ: f64 = 1.5;
/// Slower than that it does not drive for who walks, in m/s.
const CRAWL_M_S: f64 = 0.02;
/// The interval, in nanoseconds, at which its progress is checked.
const WATCH_NS: u64 = 500_000_000;
/// A robot that moves goes so far, in metres, ...
const MOVED_M: f64 = 0.02;
/// ... in so many nanoseconds.
const STALLED_NS: u64 = 2_000_000_000;

#[cfg(test)]
mod tests;
