//! Path integration: out on a winding way, straight home, and a search in growing loops (§4.4.4). The desert
//! [`Ant`] on wheels.
//!
//! *Deviation*: the ant has the sun for a compass. A robot that believes its odometry has none, and so its vector home errs
//! by the power of one and a half of the way. Landmarks are left out.

use baudbot_brain::Signals;
use baudbot_geometry::{Point, Pose, angle, math};
use serde::Deserialize;

use crate::animals::ant::{self, Ant, Phase, Sensed};
use crate::parameter::{ParameterError, check_not_negative, check_positive};
use crate::process::{MotorBehavior, StepContext};
use crate::registry::BuildContext;
use crate::senses::Source;

/// The extent of its foraging, and the sign of its home.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Length of the way out, in metres; 0 if something else has brought it out.
    pub out_m: f64,
    /// The rate at which it changes its rate of turning on its way out, per second; with 0 it goes straight on.
    pub meander_hz: f64,
    /// The reading that shows its home: `SENSOR.PART`. Without it it stops where the vector home ends.
    pub nest: Option<String>,
    /// The robot is at home if the sensor's reading is above this.
    pub nest_above: f64,
    /// The search begins once the vector home is shorter than this, in metres.
    pub near_m: f64,
    /// The distance from one loop of the search to the next, in metres.
    pub pitch_m: f64,
    /// The robot's speed, in metres a second.
    pub speed_m_s: f64,
    /// The highest rate of turning, in radians a second.
    pub turn_rad_s: f64,
    /// The rate of turning for each radian that it should turn, per second.
    pub steering_hz: f64,
    /// The speed of a wheel at a signal of 1, in metres a second.
    pub full_speed_m_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            out_m: 20.0,
            meander_hz: 0.5,
            nest: None,
            nest_above: 0.5,
            near_m: 0.1,
            pitch_m: 0.4,
            speed_m_s: 0.2,
            turn_rad_s: 1.0,
            steering_hz: 2.0,
            full_speed_m_s: 0.5,
        }
    }
}

/// A behaviour that goes out and comes home.
#[derive(Clone, Debug)]
pub struct Home {
    parameters: Parameters,
    nest: Option<Source>,
    half_track_m: f64,
    ant: Ant,
    /// The last pose.
    last: Option<Pose>,
    driven_m: f64,
}

impl Home {
    /// A `Home` for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: Parameters, context: &BuildContext<'_>) -> Result<Self, ParameterError> {
        let p = &parameters;
        check(p)?;
        let nest = p.nest.as_deref().map(|nest| Source::parse(nest, context.body)).transpose();
        let nest = nest.map_err(|error| ParameterError::value("nest", error))?;
        let gait = ant::Parameters {
            speed_m_s: p.speed_m_s,
            turn_rad_s: p.turn_rad_s,
            steering_hz: p.steering_hz,
            meander_hz: p.meander_hz,
            near_m: p.near_m,
            pitch_m: p.pitch_m,
            ..ant::Parameters::default()
        };
        let (ant, half_track_m) = (Ant::new(gait, context.chance()), context.body.half_track_m);
        Ok(Self { parameters, nest, half_track_m, ant, last: None, driven_m: 0.0 })
    }

    /// The behaviour's present activity.
    pub fn phase(&self) -> Phase {
        self.ant.phase()
    }

    /// The distance and the heading that the ant senses from one step to the next. Its compass is the believed
    /// heading, half-way between the two, by which the way was driven.
    fn moved(&mut self, pose: Pose) -> (f64, f64) {
        let last = self.last.replace(pose).unwrap_or(pose);
        let half_way_rad = last.heading + 0.5 * angle::difference(pose.heading, last.heading);
        let offset = pose.position - last.position;
        let (sin, cos) = math::sin_cos(half_way_rad);
        let distance_m = offset.x * cos + offset.y * sin;
        self.driven_m += distance_m.abs();
        (distance_m, half_way_rad)
    }

    fn is_home(&self, context: &StepContext<'_>) -> bool {
        let above =
            |nest: &Source| nest.first(context.turn).is_some_and(|value| value > self.parameters.nest_above);
        // An ant without such a sensor takes the vector's word for it.
        self.nest.as_ref().map_or_else(|| self.ant.phase() == Phase::Search, above)
    }

    /// The believed place of its home.
    fn home(&self, here: Point) -> Point {
        here + self.ant.home()
    }
}

fn check(p: &Parameters) -> Result<(), ParameterError> {
    check_positive([
        ("near_m", p.near_m),
        ("pitch_m", p.pitch_m),
        ("speed_m_s", p.speed_m_s),
        ("turn_rad_s", p.turn_rad_s),
        ("steering_hz", p.steering_hz),
        ("full_speed_m_s", p.full_speed_m_s),
    ])?;
    check_not_negative([("out_m", p.out_m), ("meander_hz", p.meander_hz)])?;
    if p.nest_above.is_nan() {
        return Err(ParameterError::value("nest_above", "must be a number"));
    }
    Ok(())
}

impl MotorBehavior for Home {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let pose = context.beliefs.pose?.world_from_robot;
        let (distance_m, heading_rad) = self.moved(pose);
        let food = self.driven_m >= self.parameters.out_m;
        let nest = self.is_home(context);
        let sensed = Sensed { distance_m, heading_rad, landmarks_rad: &[], food, nest };
        let motion = self.ant.step(&sensed, context.dt_s);
        let (intention, path) = match self.ant.phase() {
            Phase::Forage => ("goes out", Vec::new()),
            Phase::Return => ("returns", vec![self.home(pose.position)]),
            Phase::Search => ("searches", vec![self.home(pose.position)]),
            Phase::Home => ("is at home", Vec::new()),
        };
        intention.clone_into(&mut context.beliefs.intention);
        context.beliefs.path = path;
        let wheel = |side: f64| {
            (motion.speed_m_s + side * motion.turn_rate_rad_s * self.half_track_m)
                / self.parameters.full_speed_m_s
        };
        Some(Signals { left: wheel(-1.0), right: wheel(1.0) })
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Estimate;
    use crate::process::Beliefs;
    use crate::test_body::{body, turn};

    fn made(parameters: Parameters, seed: u64) -> Result<Home, String> {
        let body = body(&[("nose", "field", 0.0)]);
        let context = BuildContext { name: "home", body: &body, seed, motors: &["home"], by_utility: true };
        Home::new(parameters, &context).map_err(|error| error.to_string())
    }

    /// Drives for ten minutes at most, or until it is home; its home is moved by so much once it returns. The way by phases,
    /// how far out it was, and where it ended.
    fn drive(mut home: Home, moved_m: f64) -> ([f64; 3], f64, Point) {
        let (body, mut pose) = (body(&[("nose", "field", 0.0)]), Pose::new(1.0, 2.0, 0.5));
        let (start, mut ways_m, mut away_m) = (pose.position, [0.0; 3], 0.0);
        let nest = start + baudbot_geometry::Vector::new(moved_m, 0.0);
        for i in 0..30_000 {
            let scent = if (pose.position - nest).norm() < 0.15 { 1.0 } else { 0.0 };
            let turn = turn(&body, i * 20_000_000, &[Some(&[scent])]);
            let mut beliefs = Beliefs { pose: Some(Estimate::exact(pose)), ..Beliefs::default() };
            let mut context = StepContext {
                turn: &turn,
                dt_s: 0.02,
                state: &[],
                beliefs: &mut beliefs,
                gammas: &mut Vec::new(),
            };
            let Signals { left, right } = home.step(&mut context).expect("signals");
            let phase = match home.phase() {
                Phase::Forage => 0,
                Phase::Return => 1,
                Phase::Search => 2,
                Phase::Home => break,
            };
            let step = pose.direction().vector() * ((left + right) * 0.25 * 0.02);
            (ways_m[phase], pose.position) = (ways_m[phase] + step.norm(), pose.position + step);
            pose.heading += (right - left) * 0.5 / 0.4 * 0.02;
            if phase == 0 {
                away_m = (pose.position - start).norm();
            }
        }
        assert_eq!(home.phase(), Phase::Home, "at {pose:?}");
        (ways_m, away_m, pose.position - nest.coords)
    }

    #[test]
    fn it_winds_out_and_comes_straight_home() {
        for seed in 0..5 {
            let home = made(Parameters::default(), seed).unwrap();
            let ([out_m, return_m, _], away_m, end) = drive(home, 0.0);
            assert!(
                (out_m - 20.0).abs() < 0.1 && return_m < away_m + 0.5,
                "{seed}: {out_m} {return_m} {away_m}"
            );
            assert!(end.coords.norm() <= 0.101, "{seed}: {end}");
        }
    }

    #[test]
    fn if_home_is_elsewhere_it_is_searched_and_found() {
        let parameters = Parameters { nest: Some("nose".to_owned()), pitch_m: 0.25, ..Parameters::default() };
        for seed in 0..5 {
            let ([_, _, search_m], _, end) = drive(made(parameters.clone(), seed).unwrap(), 0.8);
            assert!(search_m > 1.0 && end.coords.norm() < 0.16, "{seed}: {search_m} {end}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let problem = |parameters| made(parameters, 1).unwrap_err();
        assert_eq!(
            problem(Parameters { pitch_m: 0.0, ..Parameters::default() }),
            "pitch_m: must be positive, is 0"
        );
        assert_eq!(
            problem(Parameters { out_m: -1.0, ..Parameters::default() }),
            "out_m: must not be negative, is -1"
        );
        let nest = Some("sun".to_owned());
        assert!(problem(Parameters { nest, ..Parameters::default() }).starts_with("nest: "));
    }
}
