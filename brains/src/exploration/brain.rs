//! A brain that explores: Wahde 2016, §6.1.
//!
//! It needs a laser range finder and an odometer. As in the notes it believes the odometer; with `slam` each scan corrects
//! that, see [`slam`]. For proximity it uses the laser
//! and whatever infra-red sensors and sonars look ahead; they should be mounted lower than the laser.
//!
//! Each new reading of the odometer is a step of its [`Explorer`]. Turns and ways become motor signals by proportional
//! control of heading and speed, closed over the odometer.
//!
//! *Deviations.*
//!
//! - A scan goes with the pose that the odometer says for the end of its sweep; what the robot's motion has bent is
//!   [mended](crate::localization::deskew).
//! - Something counts as near, too, if the robot ought to drive and has not moved for two seconds.
//! - Lasers on a turret are not understood.

use baudbot_client::{Action, Belief, Body, Brain, Mount, Sensor, Signals, Turn};
use baudbot_geometry::{Direction, Point, Pose, angle, math};

use super::placement::Placement;
use super::{Command, Explorer, Frontiers, Input, Nodes, approach, frontiers, nodes};
use crate::courier::within;
use crate::estimate::Estimate;
use crate::mapping::{Occupancy, PlacedScan};
use crate::navigate::ODOMETER;
use crate::odometry::{self, Odometry};
use crate::scanner::Scanner;
use crate::slam::{self, Slam};

mod parameters;
#[cfg(test)]
mod tests;

pub(crate) use parameters::PARAMETERS;
pub use parameters::Parameters;

/// A brain that explores.
pub struct Explore {
    parameters: Parameters,
    explorer: Box<dyn Explorer + Send>,
    half_track_m: f64,
    radius_m: f64,
    scanner: Scanner,
    /// The last one.
    scan: Option<PlacedScan>,
    feelers: Vec<Feeler>,
    /// Time that a command takes on the wire.
    command_ns: u64,
    /// A greater signal is refused.
    signal_limit: Option<f64>,
    wheels: odometry::Parameters,
    /// `None` until the odometer has said where it is.
    odometry: Option<Odometry>,
    /// What corrects the odometer, and its map; `None` if that is believed.
    slam: Option<(Slam, Occupancy)>,
    /// Since when, and where, the robot ought to have been driving.
    driving_since: Option<(u64, Point)>,
    command: Command,
    sent_ns: Option<u64>,
    heard_ns: Option<u64>,
}

/// A sensor for proximity.
#[derive(Clone, Copy, Debug)]
struct Feeler {
    sensor: usize,
    robot_from_sensor: Pose,
    is_sonar: bool,
    is_near: bool,
}

impl Explore {
    /// A brain at its start for a robot with this body; `None` if it has no laser of which a scan can be made, or
    /// no odometer.
    pub fn new(parameters: Parameters, body: &Body) -> Option<Self> {
        body.sensor(ODOMETER).filter(|sensor| sensor.values() >= 3)?;
        let laser = body.sensors.iter().find(|sensor| sensor.kind == "laser")?;
        let scanner = Scanner::new(body, &laser.name, usize::MAX).ok()?;
        let wheels = odometry::Parameters::of(body, ODOMETER)?;
        let explorer = explorer(&parameters, body.radius_m, laser.range_m?);
        let feeler = |(sensor, described): (usize, &Sensor)| Feeler {
            sensor,
            robot_from_sensor: mount(described),
            is_sonar: described.kind == "sonar",
            is_near: false,
        };
        let feelers = body.sensors.iter().enumerate();
        let feelers =
            feelers.filter(|(_, sensor)| ["ir", "sonar"].contains(&sensor.kind.as_str())).map(feeler);
        Some(Self {
            parameters,
            explorer,
            half_track_m: body.half_track_m,
            radius_m: body.radius_m,
            scanner,
            scan: None,
            feelers: feelers.filter(|feeler| looks_ahead(&feeler.robot_from_sensor)).collect(),
            command_ns: body.command_ns(),
            signal_limit: body.signal_limit,
            wheels: odometry::Parameters { variance_m2_per_m: WHEELS_M2_PER_M, ..wheels },
            odometry: None,
            slam: slam(&parameters),
            driving_since: None,
            command: Command::Wait,
            sent_ns: None,
            heard_ns: None,
        })
    }

    /// What the explorer last wanted.
    pub const fn command(&self) -> Command {
        self.command
    }

    /// Takes in what is new; says whether the odometer had news.
    fn look(&mut self, turn: &Turn) -> bool {
        if self.odometry.is_none() {
            self.odometry = Odometry::starting(self.wheels, turn, ODOMETER, None);
        }
        let has_news = self.odometry.as_mut().is_some_and(|odometry| odometry.read(turn, ODOMETER));
        if has_news {
            self.heard_ns = Some(turn.at_ns);
        }
        self.scanner.hear(turn);
        for feeler in &mut self.feelers {
            let reading = turn.readings.get(feeler.sensor).and_then(Option::as_ref);
            if let Some(&value) =
                reading.filter(|reading| reading.readable).and_then(|new| new.values.first())
            {
                feeler.is_near = feeler.feels(value, self.radius_m, &self.parameters);
            }
        }
        self.place_scan();
        has_news
    }

    /// Gives a scan its pose, once the odometer knows it.
    fn place_scan(&mut self) {
        let Some(odometry) = &mut self.odometry else { return };
        let Some((at_ns, scan)) = self.scanner.take(odometry) else { return };
        let Some(mut estimate) = odometry.at(at_ns) else { return };
        if let Some((slam, grid)) = &mut self.slam {
            // What fits nowhere is not explored by, either.
            let Some(found) = slam.see(grid, &scan, &estimate) else { return };
            odometry.correct(at_ns, found);
            estimate = found;
        }
        let Estimate { world_from_robot, .. } = estimate;
        self.scan = Some(PlacedScan { world_from_robot, scan });
    }

    /// Whether its last scan shows something in the way that is near: sonars overlook edges, and walls that they meet at an
    /// acute angle.
    fn sees_near(&self, here: &Pose) -> bool {
        let forward = here.direction();
        let in_robot = |end: Point| Point::from(forward.inverse().apply(end - here.position));
        let mut ends = self.scan.iter().flat_map(PlacedScan::ends);
        let room_m = self.radius_m + BARELY_M;
        ends.any(|(end, met)| met && is_in_way(in_robot(end), self.parameters.near_m, room_m))
    }

    /// Whether it ought to drive and has not moved for too long.
    fn is_stalled(&mut self, at_ns: u64, here: Point) -> bool {
        if !matches!(self.command, Command::Drive { .. }) {
            self.driving_since = None;
            return false;
        }
        let since = self.driving_since.get_or_insert((at_ns, here));
        if (here - since.1).norm() > MOVED_M {
            *since = (at_ns, here);
        }
        at_ns.saturating_sub(since.0) > STALLED_NS
    }

    /// Signals of the left and the right motor.
    fn signals(&self, here: &Pose) -> Signals {
        let p = &self.parameters;
        let (speed, turn_rate) = match self.command {
            Command::Wait | Command::Done | Command::Failed(_) => (0.0, 0.0),
            Command::Turn { heading_rad } => {
                let aside = angle::difference(heading_rad, here.heading);
                let rate = (TURN_GAIN_HZ * aside.abs())
                    .clamp(LEAST_RATE_RAD_S.min(p.turn_rate_rad_s), p.turn_rate_rad_s);
                (0.0, rate.copysign(aside))
            }
            Command::Drive { to } => {
                let aside = angle::difference(approach::heading_to(here, to), here.heading);
                let way_m = (to - here.position).norm();
                let speed = (SPEED_GAIN_HZ * way_m).clamp(LEAST_SPEED_M_S.min(p.speed_m_s), p.speed_m_s);
                let rate = (TURN_GAIN_HZ * aside).clamp(-p.turn_rate_rad_s, p.turn_rate_rad_s);
                (speed * math::cos(aside).max(0.0), rate)
            }
        };
        let wheel = |side: f64| (speed + side * turn_rate * self.half_track_m) / p.full_speed_m_s;
        Signals { left: wheel(-1.0), right: wheel(1.0) }
    }

    fn act(&mut self, turn: &Turn, has_news: bool) -> Action {
        let at_ns = turn.at_ns;
        let stale_ns = (self.parameters.stale_s * 1e9) as u64;
        let is_blind = self.heard_ns.is_none_or(|heard_ns| at_ns.saturating_sub(heard_ns) > stale_ns);
        let pause_ns = if is_blind { self.command_ns.max(REPEAT_NS) } else { self.command_ns };
        let is_free = self.sent_ns.is_none_or(|sent_ns| at_ns.saturating_sub(sent_ns) >= pause_ns);
        if !is_free || !(is_blind || has_news) {
            return Action::wait();
        }
        self.sent_ns = Some(at_ns);
        let Some(odometry) = self.odometry.as_ref().filter(|_| !is_blind) else {
            return Action::drive(0.0, 0.0);
        };
        let here = odometry.estimate().world_from_robot;
        let is_near = self.feelers.iter().any(|feeler| feeler.is_near);
        let near = self.is_stalled(at_ns, here.position) || is_near || self.sees_near(&here);
        let input = Input { world_from_robot: here, scan: self.scan.as_ref(), near };
        self.command = self.explorer.step(&input);
        let Signals { left, right } = within(self.signal_limit, self.signals(&here));
        Action::drive(left, right)
    }
}

impl Brain for Explore {
    fn step(&mut self, turn: &Turn) -> Action {
        let has_news = self.look(turn);
        let action = self.act(turn, has_news);
        action.until_message_or(turn.at_ns.saturating_add(self.command_ns.max(REPEAT_NS)))
    }

    fn belief(&mut self) -> Option<Belief> {
        let (state, path) = match self.command {
            Command::Wait => ("waits for a scan".to_owned(), vec![]),
            Command::Turn { .. } => ("turns".to_owned(), vec![]),
            Command::Drive { to } => {
                ("drives".to_owned(), vec![baudbot_client::Point { x_m: to.x, y_m: to.y }])
            }
            Command::Done => ("has seen all".to_owned(), vec![]),
            Command::Failed(failure) => (format!("gave up: {failure:?}"), vec![]),
        };
        let pose = self.odometry.as_ref().map(|odometry| odometry.estimate().shown());
        let map = self.slam.as_ref().map(|(_, grid)| grid.shown());
        Some(Belief { state, path, pose, map, ..Belief::default() })
    }
}

impl Feeler {
    /// Whether what a sensor reads is near and in the way.
    fn feels(&self, value: f64, radius_m: f64, parameters: &Parameters) -> bool {
        if !self.is_sonar {
            return value >= parameters.near_reading;
        }
        let forward = self.robot_from_sensor.direction();
        let point_in_robot = self.robot_from_sensor.position + forward.vector() * value;
        is_in_way(point_in_robot, parameters.near_m, radius_m + ALMOST_M)
    }
}

/// Whether a point would be in a disc of this radius that is so far ahead.
fn is_in_way(point_in_robot: Point, ahead_m: f64, radius_m: f64) -> bool {
    let off = point_in_robot - Point::new(ahead_m, 0.0);
    point_in_robot.x > 0.0 && off.norm() < radius_m
}

fn explorer(parameters: &Parameters, radius_m: f64, range_m: f64) -> Box<dyn Explorer + Send> {
    let Parameters { distance_m, margin_m, width_rad, separation_m, cell_m, .. } = *parameters;
    let half_width_m = radius_m + ROOM_M;
    if parameters.method >= 0.5 {
        let defaults = frontiers::Parameters::default();
        return Box::new(Frontiers::new(frontiers::Parameters { cell_m, half_width_m, ..defaults }));
    }
    Box::new(Nodes::new(nodes::Parameters {
        placement: Placement { distance_m, margin_m, width_rad, separation_m },
        sight_m: parameters.sight_m.min(range_m),
        half_width_m,
        ..nodes::Parameters::default()
    }))
}

fn slam(parameters: &Parameters) -> Option<(Slam, Occupancy)> {
    let slam = (parameters.slam >= 0.5).then(|| Slam::new(slam::Parameters::default()))?;
    let grid = slam.grid();
    Some((slam, grid))
}

fn mount(sensor: &Sensor) -> Pose {
    let Mount { x_m, y_m, heading_rad, .. } = sensor.mount.unwrap_or_default();
    Pose::new(x_m, y_m, heading_rad)
}

fn looks_ahead(robot_from_sensor: &Pose) -> bool {
    Direction::from_angle(robot_from_sensor.heading).cos > AHEAD_COS
}

/// Variance of what the odometer says a wheel has gone, in square metres for each metre, if it is corrected.
const WHEELS_M2_PER_M: f64 = 1e-3;
/// Room beside the robot on its way, in metres.
const ROOM_M: f64 = 0.05;
/// Room that there must be beside a disc that is a little ahead, in metres. A sonar does not say where in its cone something
/// is: with half a cone of 0.2 rad and 0.15 m to go, 3 cm to the side.
const ALMOST_M: f64 = 0.03;
/// The same for what the laser sees, which is where it is seen but for a centimetre.
const BARELY_M: f64 = 0.01;
/// Cosine of the greatest angle at which a sensor looks ahead: 80°.
const AHEAD_COS: f64 = 0.17;
/// Turn rate for each radian to be turned.
const TURN_GAIN_HZ: f64 = 2.0;
/// Least rate of a turn, in rad/s: motors stand still below some signal.
const LEAST_RATE_RAD_S: f64 = 0.15;
/// Speed for each metre that is left.
const SPEED_GAIN_HZ: f64 = 1.5;
/// Least speed, in m/s.
const LEAST_SPEED_M_S: f64 = 0.08;
/// A robot that moves goes so far, in metres, ...
const MOVED_M: f64 = 0.02;
/// ... in so many nanoseconds.
const STALLED_NS: u64 = 2_000_000_000;
/// A blind robot says so often that it stands still, in nanoseconds.
const REPEAT_NS: u64 = 100_000_000;
