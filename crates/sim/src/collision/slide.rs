//! A robot goes on along what it runs into (ours; the notes' robots stop).
//!
//! Let n be the unit vector from what it runs into to the robot, h the direction in which its wheels lead it, t the tangent
//! on the side of h, c = h t and s = −h n. Wheels that roll at a speed V press the robot on by c V along the tangent, and by s V
//! against what is there. Coulomb's friction, µ times what presses, acts against the sliding, so that the robot goes at
//!     v = k V, k = max(0, c − µ s):
//! freely without friction, and not at all within the cone of friction. The motors work on the wheels as if the robot were
//! free. In a step in which they add ΔV to V,
//!     v' = min(k V', v + k ΔV):
//! a robot that comes in loses what it loses at once; one that turns away from a wall is not faster by that, only by its
//! motors, so that its energy does not grow without them. Where it leaves, its wheels roll at v.
//!
//! Deviations.
//! - Wheels give way sideways without friction of their own: they resist nothing but the motors.
//! - Nothing turns the robot: neither friction at its rim nor a wall at its corners.
//! - No robot is pushed: a robot or mover that is slid along stays as it is. Movables have been pushed before: a robot that would slide
//!   into one stays where it was.
//! - Corners that turn into something do not turn on, as with robots that stop.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Pose, Vector, math};

use super::{Step, Way, looks};
use crate::drive::{Drive, Motion};
use crate::motor::Motors;
use crate::movable::{Body, Chain, Form, Touch, touches};

/// The thrust of a robot in a step, along its heading, in m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Thrust {
    /// The speed of its body before the step, along its heading or what it slides along: v.
    body: f64,
    /// The speed of its wheels after the step, if nothing is in the way: V'.
    wheels: f64,
    /// The motors' part in the step: ΔV.
    gain: f64,
    /// The distance over ground for each metre that its wheels roll, and the speed by its turning alone, if that is
    /// not 1 and 0.
    over_ground: Option<(f64, f64)>,
    /// The length of the step, in seconds.
    dt: f64,
}

/// The slide of a robot in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slid {
    pub(crate) after: Pose,
    /// The robot's speed, in m/s; backwards negative.
    pub(crate) speed_m_s: f64,
    /// The speed of the robot's wheels, in m/s.
    pub(crate) wheels_m_s: f64,
}

impl Thrust {
    /// The thrust of a step from one motion to another.
    pub(crate) fn of_step(
        drive: &Drive,
        before: &Motion,
        after: &Motion,
        over_ground: Option<(f64, f64)>,
        dt: f64,
    ) -> Self {
        let rolled = drive.wheels_roll_at(before);
        let gain = match drive.motor {
            Motors::Dc(_) | Motors::Velocity(_) => after.speed_m_s - before.speed_m_s,
            // These motors turn the wheels at a speed, whatever the body does.
            Motors::Servo(_) | Motors::Stepper(_) => after.speed_m_s - rolled,
        };
        Self { body: before.speed_m_s, wheels: rolled + gain, gain, over_ground, dt }
    }

    /// The thrust of a robot whose step has been judged before.
    pub(crate) fn of_motion(drive: &Drive, motion: &Motion, dt: f64) -> Self {
        let wheels = drive.wheels_roll_at(motion);
        Self { body: motion.speed_m_s, wheels, gain: 0.0, over_ground: None, dt }
    }

    /// The wheels' speed.
    pub(crate) fn wheels_m_s(&self) -> f64 {
        self.wheels
    }

    /// The speed at which it slides where the share k of its wheels' is left, and how far it comes. `sign` is that of
    /// its direction.
    fn sliding(&self, k: f64, sign: f64) -> (f64, f64) {
        let [body, wheels, gain] = [self.body, self.wheels, self.gain].map(|speed| sign * speed);
        let speed = (k * wheels).min(body + k * gain).max(0.0);
        let (share, turned) = self.over_ground.unwrap_or((1.0, 0.0));
        (speed, (share * speed + k * sign * turned).max(0.0) * self.dt)
    }
}

/// A direction in which a robot can slide.
struct Course<'a> {
    touch: &'a Touch,
    tangent: Vector,
    k: f64,
}

impl Step<'_> {
    /// The robot's way along its obstacle; `None` if it cannot slide.
    pub(super) fn slide(&self, own: usize, friction: f64) -> Option<Slid> {
        let way = &self.ways[own];
        let wanted = way.wanted.position - way.before.position;
        let length = wanted.norm();
        if length <= 0.0 || !length.is_finite() {
            return None;
        }
        let ahead = wanted / length;
        let sign = if ahead.dot(&way.wanted.direction().vector()) < 0.0 { -1.0 } else { 1.0 };
        let heading = self.heading(own, way);
        let touches = self.touches(own, &Pose { heading, ..way.before }, length);
        let is_in_the_way = |touch: &&Touch| -ahead.dot(&touch.normal) * length > touch.gap.max(0.0);
        let courses = touches.iter().filter(is_in_the_way).filter_map(|touch| course(touch, ahead, friction));
        let (mut best, mut farthest) = (None, 0.0);
        for course in courses {
            let (speed, far) = way.thrust.sliding(course.k, sign);
            let step = displacement(&course, far, &touches);
            let (along, closer) = (step.dot(&course.tangent), -step.dot(&course.touch.normal));
            // In a corner it comes neither on nor closer.
            if along.max(closer - CLOSE_M) > farthest {
                farthest = along.max(closer - CLOSE_M);
                let after = Pose { position: way.before.position + step, heading };
                let wheels_m_s = sign * speed / course.k;
                best = Some(Slid { after, speed_m_s: sign * speed, wheels_m_s });
            }
        }
        best.filter(|slid: &Slid| self.is_clear_of_movables(own, &way.before, &slid.after))
    }

    /// Whether the way leads through no movable.
    fn is_clear_of_movables(&self, own: usize, before: &Pose, after: &Pose) -> bool {
        let form = (self.form)(own);
        self.movables.is_empty()
            || looks(&form, before, after)
                .map(|pose| form.at(&pose))
                .all(|body| !self.movables.iter().any(|movable| movable.overlaps(&body)))
    }

    /// A body with corners keeps its heading if it would turn into something.
    fn heading(&self, own: usize, way: &Way) -> f64 {
        let form = (self.form)(own);
        let turned = Pose { heading: way.wanted.heading, ..way.before };
        match form {
            Form::Disc { .. } => turned.heading,
            Form::Polygon(_) if way.tries == 0 && self.met_at(&form.at(&turned)).is_none() => turned.heading,
            Form::Polygon(_) => way.before.heading,
        }
    }

    /// Places where the robot, at this pose, is next to something that it can reach in a step of this length.
    fn touches(&self, own: usize, pose: &Pose, length: f64) -> Vec<Touch> {
        let form = (self.form)(own);
        let body = Chain::of_body(&form.at(pose));
        let mut found = Vec::new();
        let mut look = |other: &Chain| {
            touches(&body, pose.position, other, length, |touch| {
                if touch.gap >= -DEEPEST_M {
                    found.push(touch);
                }
            });
        };
        let near = Circle { center: pose.position, radius: form.reach_m() + 2.0 * length + DEEPEST_M };
        Chain::of_arena(self.arena, &near).iter().for_each(&mut look);
        for obstacle in self.obstacles.iter().filter(|body| Body::Disc(near).overlaps(body)) {
            look(&Chain::of_body(obstacle));
        }
        if self.ways.len() > 1 {
            self.crowd.near(&self.crowd.discs()[own], |other| {
                if other != own {
                    // Both where it is and where it will be, as it may have to stay.
                    let (its, form) = (&self.ways[other], (self.form)(other));
                    look(&Chain::of_body(&form.at(&its.before)));
                    if its.after != its.before {
                        look(&Chain::of_body(&form.at(&its.after)));
                    }
                }
            });
        }
        found
    }
}

/// The robot's course along the obstacle that it touches; `None` if friction holds it.
fn course(touch: &Touch, ahead: Vector, friction: f64) -> Option<Course<'_>> {
    let pressing = -ahead.dot(&touch.normal);
    let along = ahead + touch.normal * pressing;
    let c = along.norm();
    let k = c - friction * pressing;
    (k > 0.0 && c > 0.0).then(|| Course { touch, tangent: along / c, k })
}

/// The displacement as far as something else lets the robot go, and up to what it slides along.
fn displacement(course: &Course<'_>, far: f64, touches: &[Touch]) -> Vector {
    // Less than rounding is nothing, so that a robot in a corner stands.
    let room = |gap: f64| if gap - CLEAR_M > ALMOST_NOTHING_M { gap - CLEAR_M } else { 0.0 };
    let limit = |far: f64, touch: &Touch| {
        let approach = -touch.normal.dot(&course.tangent);
        if approach > PARALLEL { far.min(room(touch.gap) / approach) } else { far }
    };
    let far = touches.iter().fold(far, limit);
    let closer = course.touch.gap - CLEAR_M;
    // Both together are no farther than it goes: coming closer takes a part of the step.
    let along = if closer > 0.0 { math::sqrt((far * far - closer * closer).max(0.0)) } else { far };
    let step = course.tangent * along - course.touch.normal * closer;
    let is_free =
        |touch: &Touch| step.dot(&touch.normal) >= CLEAR_M.min(touch.gap) - touch.gap - ALMOST_NOTHING_M;
    if touches.iter().all(is_free) { step } else { course.tangent * far }
}

/// A deeper contact is an overlap.
const DEEPEST_M: f64 = 1e-8;
/// The sine of an angle at which two walls are one.
const PARALLEL: f64 = 1e-9;
/// The gap between a robot and its obstacle, so that rounding does not push it in.
const CLEAR_M: f64 = 2e-10;
/// A robot that comes closer by more has not been there.
const CLOSE_M: f64 = 1e-9;
/// A length that is less than any of these.
const ALMOST_NOTHING_M: f64 = 1e-11;
