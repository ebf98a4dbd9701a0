//! The feelings of infra-red sensors and sonars that the field does not know, kept as marks: cells of the believed
//! pose's frame in which something is.
//!
//! The part of a reading that marks explain is taken from it first (`eye` says why); the rest is put on the rays that
//! no mark explains. A mark goes where a single ray of five would have read more than the sensor does, and where the
//! body is.

mod eye;

use std::collections::BTreeSet;

use baudbot_brain::{Body, Sensor, Turn};
use baudbot_geometry::{Direction, Point, Pose, Vector, math};

use crate::parameter::ParameterError;
use crate::process::Beliefs;
use crate::vfh::sight::{self, Infrared};
use eye::{Eye, RAYS};

/// The sensors of a robot, and the marks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Felt {
    eyes: Vec<Eye>,
    radius_m: f64,
    cell_m: f64,
    marks: BTreeSet<(i64, i64)>,
    /// Marks came since the last query.
    has_news: bool,
}

impl Felt {
    /// A `Felt` of a robot with this body: by the sensors that are named, or by all infra-red sensors and sonars that
    /// sit on it.
    ///
    /// # Errors
    /// If a parameter is invalid.
    pub(super) fn new(parameters: &sight::Parameters, body: &Body) -> Result<Self, ParameterError> {
        let infrared = parameters.ir.unwrap_or(ARSIM);
        if !(infrared.c1_m2.is_finite() && infrared.c1_m2 > 0.0 && infrared.c2.is_finite()) {
            return Err(ParameterError::value("sight.ir", "c1_m2 must be positive, and c2 finite"));
        }
        if let Some(rad) = parameters.cone_rad.filter(|rad| !(*rad > 0.0 && *rad <= std::f64::consts::PI)) {
            return Err(ParameterError::range("sight.cone_rad", "above 0 and at most π", rad));
        }
        let eye = |(i, sensor): (usize, &Sensor)| Eye::new(parameters, infrared, i, sensor, body.radius_m);
        let eyes: Vec<_> = body.sensors.iter().enumerate().filter_map(eye).collect();
        for name in &parameters.names {
            if !eyes.iter().any(|eye| body.sensors[eye.sensor].name == *name) {
                let robot = &body.name;
                let problem = format_args!(
                    "robot `{robot}` has no sonar or ir called `{name}` with level rays on its body"
                );
                return Err(ParameterError::value("sight.names", problem));
            }
        }
        let radius_m = body.radius_m;
        Ok(Self { eyes, radius_m, cell_m: CELL * radius_m, marks: BTreeSet::new(), has_news: false })
    }

    /// Whether there is nothing to feel by.
    pub(super) fn is_senseless(&self) -> bool {
        self.eyes.is_empty()
    }

    /// Whether a sensor has been silent for too long, or never spoke.
    pub(super) fn is_blind(&self, at_ns: u64) -> bool {
        let is_silent =
            |eye: &Eye| eye.heard.is_none_or(|(heard_ns, _)| at_ns.saturating_sub(heard_ns) > eye.stale_ns);
        self.eyes.iter().any(is_silent)
    }

    /// Takes in what a turn brought.
    pub(super) fn feel(&mut self, turn: &Turn, beliefs: &Beliefs) {
        for i in 0..self.eyes.len() {
            let eye = &mut self.eyes[i];
            let Some(reading) = turn.readings.get(eye.sensor).and_then(Option::as_ref) else { continue };
            let Some(&value) = reading.values.first().filter(|value| reading.readable && !value.is_nan())
            else {
                continue;
            };
            eye.heard = Some((turn.at_ns, value));
            let then = reading.sampled_at_ns.and_then(|at_ns| beliefs.odometry.as_ref()?.at(at_ns));
            if let Some(estimate) = then.or(beliefs.pose) {
                self.mark(i, value, &estimate.world_from_robot);
            }
        }
        if let Some(estimate) = beliefs.pose {
            let here = estimate.world_from_robot.position;
            let (cell_m, under_m) = (self.cell_m, UNDER * self.radius_m);
            self.marks.retain(|&mark| (center(mark, cell_m) - here).norm() >= under_m);
        }
    }

    /// Takes marks away that cannot be by this reading, and sets those that must be.
    fn mark(&mut self, eye: usize, value: f64, world_from_robot: &Pose) {
        let eye = self.eyes[eye];
        let world_from_sensor = world_from_robot.compose(&eye.robot_from_sensor);
        let far_m = (FAR * self.radius_m).clamp(LEAST_FAR_M, MOST_FAR_M).min(eye.range_m);
        self.clear(&eye, eye.free_m(value, self.cell_m).min(1.5 * far_m), &world_from_sensor);
        let rays = eye.rays(&world_from_sensor);
        let hits = rays.map(|ray| self.hit_m(world_from_sensor.position, ray, far_m + 2.0 * self.cell_m));
        let Some((distance_m, is_new)) = eye.unexplained(value, &hits, self.cell_m) else { return };
        if distance_m > far_m {
            return;
        }
        // Between two rays there is something, too.
        let across = 2.0 * distance_m * eye.opening_rad / self.cell_m;
        let steps = math::ceil(across).max(1.0) as usize;
        for step in 0..=steps {
            let part = step as f64 / steps as f64;
            let ray = math::round(part * (RAYS - 1) as f64) as usize;
            if is_new[ray] {
                let bearing_rad = world_from_sensor.heading + eye.opening_rad * (part - 0.5);
                let path = Direction::from_angle(bearing_rad).vector() * distance_m;
                self.put(world_from_sensor.position + path);
            }
        }
    }

    fn put(&mut self, at: Point) {
        let number = |m: f64| math::floor(m / self.cell_m) as i64;
        self.has_news |= self.marks.insert((number(at.x), number(at.y)));
    }

    /// Takes the marks away in the part of a cone that must be free.
    fn clear(&mut self, eye: &Eye, free_m: f64, world_from_sensor: &Pose) {
        let (cell_m, sensor_from_world) = (self.cell_m, world_from_sensor.inverse());
        self.marks.retain(|&mark| {
            let at = sensor_from_world.transform(center(mark, cell_m));
            let aside_rad = math::atan2(at.y, at.x).abs();
            at.coords.norm() + cell_m >= free_m || aside_rad > 0.5 * eye.opening_rad
        });
    }

    /// The distance that a ray goes until it meets a mark, in metres, if it meets one so near.
    fn hit_m(&self, from: Point, ray: Vector, far_m: f64) -> Option<f64> {
        let steps = (far_m / (0.5 * self.cell_m)) as u32;
        let mut along = (0..=steps).map(|i| 0.5 * self.cell_m * f64::from(i));
        let number = |m: f64| math::floor(m / self.cell_m) as i64;
        along.find(|&m| {
            let at = from + ray * m;
            self.marks.contains(&(number(at.x), number(at.y)))
        })
    }

    /// The middles of the marks.
    pub(super) fn marks(&self) -> impl Iterator<Item = Point> + Clone + '_ {
        self.marks.iter().map(|&mark| center(mark, self.cell_m))
    }

    /// The possible distance between a mark and the object, in metres.
    pub(super) fn blur_m(&self) -> f64 {
        self.eyes.iter().map(Eye::blur_m).fold(0.0, f64::max)
    }

    /// Whether marks came since the last time.
    pub(super) fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.has_news)
    }

    /// All marks may be wrong.
    pub(super) fn forget(&mut self) {
        self.marks.clear();
        self.has_news = true;
    }

    /// The distance that the body can go straight on in a direction before it meets an object that is felt now, or a
    /// mark, in metres. Of an object that an infra-red sensor feels now half of the cone is taken to be full.
    pub(super) fn room_m(&self, world_from_robot: &Pose, direction_rad: f64) -> f64 {
        let world_from_way = Pose { heading: direction_rad, ..*world_from_robot };
        let way_from_world = world_from_way.inverse();
        let marks = self.marks().map(|mark| room_m(way_from_world.transform(mark), GRAZE * self.radius_m));
        let felt = self.near_by(world_from_robot);
        let felt = felt.map(|at| room_m(way_from_world.transform(at), BESIDE * self.radius_m));
        marks.chain(felt).fold(f64::INFINITY, f64::min)
    }

    /// The nearest places of objects that are sensed now.
    fn near_by(&self, world_from_robot: &Pose) -> impl Iterator<Item = Point> + use<'_> {
        let world_from_robot = *world_from_robot;
        self.eyes.iter().flat_map(move |eye| {
            let world_from_sensor = world_from_robot.compose(&eye.robot_from_sensor);
            let near_m = eye.heard.map_or(f64::INFINITY, |(_, value)| eye.near_m(value));
            let rays = eye.rays(&world_from_sensor).into_iter();
            rays.filter(move |_| near_m.is_finite()).map(move |ray| world_from_sensor.position + ray * near_m)
        })
    }

    /// Marks what may be in the way ahead: the robot has stood before it for a while, and no mark explains that.
    pub(super) fn mark_ahead(&mut self, world_from_robot: &Pose) {
        let robot_from_world = world_from_robot.inverse();
        let is_ahead = |at: &Point| {
            room_m(robot_from_world.transform(*at), BESIDE * self.radius_m) < 2.0 * self.radius_m
        };
        let ahead: Vec<_> = self.near_by(world_from_robot).filter(is_ahead).collect();
        let forward = world_from_robot.direction().vector();
        let before = world_from_robot.position + forward * (self.radius_m + self.cell_m);
        ahead.into_iter().chain([before]).for_each(|at| self.put(at));
    }
}

/// The distance that a disc of this radius, in metres, can go along x until a point is in it; without end if it
/// passes the point.
fn room_m(at: Point, radius_m: f64) -> f64 {
    if at.x <= 0.0 || at.y.abs() >= radius_m {
        return f64::INFINITY;
    }
    at.x - math::sqrt(radius_m * radius_m - at.y * at.y)
}

/// The middle of a mark.
fn center((column, row): (i64, i64), cell_m: f64) -> Point {
    Point::new((column as f64 + 0.5) * cell_m, (row as f64 + 0.5) * cell_m)
}

/// The constants of ARSim's sensors.
const ARSIM: Infrared = Infrared { c1_m2: 0.03, c2: 0.1 };
/// Side of a mark, in radii of the body.
const CELL: f64 = 0.2;
/// The distance, in radii of the body and in metres, beyond which no object is marked: its place is unknown.
const FAR: f64 = 3.0;
const LEAST_FAR_M: f64 = 0.3;
const MOST_FAR_M: f64 = 0.6;
/// No mark is within this part of the body's radius.
const UNDER: f64 = 0.95;
/// Room beside the body on its way, in its radii: to marks, and to what is felt.
const GRAZE: f64 = 1.03;
const BESIDE: f64 = 1.1;
#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Estimate;
    use crate::test_body::{body, turn};

    /// Three infra-red sensors at the middle of a body of 0.2 m, side by side.
    fn robot() -> Body {
        let mut body = body(&[("left", "ir", 0.5), ("ahead", "ir", 0.0), ("right", "ir", -0.5)]);
        body.sensors.iter_mut().for_each(|sensor| sensor.opening_rad = Some(0.5));
        body
    }

    /// Readings that are no number did not come.
    fn feel(felt: &mut Felt, pose: Pose, readings: [f64; 3]) {
        let beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
        let readings = readings.map(|reading| [reading]);
        let came = readings.each_ref().map(|reading| (!reading[0].is_nan()).then_some(reading.as_slice()));
        felt.feel(&turn(&robot(), 0, &came), &beliefs);
    }

    const NONE: f64 = f64::NAN;

    fn felt() -> Felt {
        Felt::new(&sight::Parameters::default(), &robot()).unwrap()
    }

    const HERE: Pose = Pose { position: Point::new(1.0, 2.0), heading: 0.0 };

    #[test]
    fn what_is_felt_is_marked_where_it_is_until_nothing_is_felt_there() {
        let mut felt = felt();
        // (3.13) at 0.5 m is 0.12 + 0.1.
        feel(&mut felt, HERE, [NONE, 0.22, NONE]);
        let marks: Vec<_> = felt.marks().map(|mark| mark - HERE.position).collect();
        assert!(felt.take_news() && !felt.take_news() && marks.len() >= 5, "{marks:?}");
        assert!(marks.iter().all(|at| (at.norm() - 0.5).abs() < 0.04 && at.y.abs() < 0.16), "{marks:?}");
        feel(&mut felt, HERE, [NONE, 0.22, NONE]);
        assert!(!felt.take_news(), "the marks explain it");
        feel(&mut felt, Pose { heading: 0.5, ..HERE }, [NONE, NONE, 0.22]);
        assert!(!felt.take_news(), "from another sensor, too");
        feel(&mut felt, HERE, [0.0; 3]);
        assert_eq!(felt.marks().count(), 0);
    }

    #[test]
    fn what_few_rays_may_meet_clears_no_mark_and_what_is_nearer_is_marked() {
        let mut felt = felt();
        feel(&mut felt, HERE, [NONE, 0.22, NONE]);
        let before = felt.marks().count();
        // One ray of five at 0.5 m, or all five far away.
        feel(&mut felt, HERE, [NONE, 0.044, NONE]);
        assert_eq!(felt.marks().count(), before);
        feel(&mut felt, HERE, [NONE, 0.4333, NONE]);
        let nearest = felt.marks().map(|mark| (mark - HERE.position).norm()).fold(9.0, f64::min);
        assert!((nearest - 0.3).abs() < 0.04, "{nearest}");
    }

    #[test]
    fn room_ends_at_marks_and_at_what_may_fill_half_of_a_cone() {
        let mut felt = felt();
        assert_eq!(felt.room_m(&HERE, 0.0), f64::INFINITY);
        // The whole cone at 0.5 m, or half of it at √(0.03 / 0.34) m.
        feel(&mut felt, HERE, [0.0, 0.22, 0.0]);
        let room_m = felt.room_m(&HERE, 0.0);
        assert!((room_m - (0.29704 - 0.22)).abs() < 1e-4, "{room_m}");
        assert_eq!(felt.room_m(&HERE, 2.0), f64::INFINITY, "elsewhere there is room");
        feel(&mut felt, HERE, [0.0, 0.0, 0.0]);
        assert_eq!(felt.room_m(&HERE, 0.0), f64::INFINITY);
    }

    #[test]
    fn who_hears_nothing_of_a_sensor_is_blind() {
        let mut felt = felt();
        assert!(felt.is_blind(0) && !felt.is_senseless());
        feel(&mut felt, HERE, [0.0; 3]);
        assert!(!felt.is_blind(500_000_000) && felt.is_blind(500_000_001));
        assert!(Felt::new(&sight::Parameters::default(), &body(&[])).unwrap().is_senseless());
        let named = |name: &str| sight::Parameters { names: vec![name.to_owned()], ..Default::default() };
        let problem = Felt::new(&named("eye"), &robot()).unwrap_err().to_string();
        assert_eq!(
            problem,
            "sight.names: robot `alice` has no sonar or ir called `eye` with level rays on its body"
        );
    }
}
