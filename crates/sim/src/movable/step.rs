//! One step of the physics for movables and the robots that push them.

use alloc::vec::Vec;

use baudbot_geometry::{Direction, Pose, Vector, angle, polygon};

use super::slice::{Bot, Scene, Thing};
use super::solve::Mover;
use super::{Body, Form, Movable, MovableState, SKIN_M};
use crate::arena::Arena;

/// The things that stand still during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fixed<'a> {
    pub(crate) arena: &'a Arena,
    /// Other obstacles, such as doors.
    pub(crate) bodies: &'a [Body],
}

/// A robot and the step that it is about to do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pusher<'a> {
    pub(crate) form: Form<'a>,
    /// World from robot, before the step: free of everything.
    pub(crate) before: Pose,
    /// World from robot, after the step, if nothing is pushed.
    pub(crate) after: Pose,
    pub(crate) mass_kg: f64,
    /// About the origin of its frame.
    pub(crate) inertia_kg_m2: f64,
    /// The way along which it can change its speed.
    pub(crate) heading: Direction,
    /// Along the heading, negative backwards.
    pub(crate) speed_m_s: f64,
    pub(crate) turn_rate_rad_s: f64,
}

/// The result of a robot's step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reaction {
    /// World from robot: `after` to the bit if it met nothing; it is free of all movables, as is `before`.
    pub(crate) pose: Pose,
    pub(crate) speed_m_s: f64,
    pub(crate) turn_rate_rad_s: f64,
    /// Something that did not yield kept it from moving for all or a part of the step.
    pub(crate) blocked: bool,
    /// The first, by index, of the movables that it pushed, was hit or was blocked by.
    pub(crate) touched: Option<usize>,
}

/// Moves the movables through `dt` seconds, and the robots among them.
///
/// Robots are judged against movables only. The caller then has to judge the robots among each other and
/// against the arena, from `before` to the pose of their reaction, as some move less far than they wanted; one
/// that must stay has to stay exactly at `before`, which no movable has entered.
pub(crate) fn step(
    movables: &[Movable],
    states: &mut [MovableState],
    fixed: &Fixed<'_>,
    pushers: &[Pusher<'_>],
    dt: f64,
) -> Vec<Reaction> {
    let near: Vec<_> = pushers.iter().map(|pusher| may_meet(pusher, movables, states, dt)).collect();
    let moves = |state: &MovableState| state.velocity_m_s != Vector::zeros() || state.spin_rad_s != 0.0;
    let idle = !near.contains(&true) && !states.iter().any(moves);
    if idle || dt.is_nan() || dt <= 0.0 {
        return pushers.iter().map(unhindered).collect();
    }
    let bots = pushers.iter().zip(near).map(|(pusher, near)| bot(pusher, near, dt)).collect();
    let pairs = || movables.iter().zip(states.iter());
    let things = pairs().map(|(movable, state)| thing(movable, state)).collect();
    let robots = pushers.iter().map(rolling);
    let movers = pairs().map(|(movable, state)| mover(movable, state)).chain(robots).collect();
    let mut scene = Scene { fixed, dt, things, bots, movers };
    scene.run();
    for ((state, thing), mover) in states.iter_mut().zip(&scene.things).zip(&scene.movers) {
        *state = MovableState { pose: thing.pose, velocity_m_s: mover.velocity, spin_rad_s: mover.spin };
    }
    let robots = scene.bots.iter().zip(&scene.movers[scene.things.len()..]);
    robots.map(|(bot, mover)| reaction(bot, mover)).collect()
}

/// The speed of the robot's fastest corner, in m/s, if nothing hinders it.
fn rate_m_s(pusher: &Pusher<'_>, dt: f64) -> f64 {
    let way = (pusher.after.position - pusher.before.position).norm();
    let turning = match pusher.form {
        Form::Disc { .. } => 0.0,
        Form::Polygon(_) => {
            let turn = angle::difference(pusher.after.heading, pusher.before.heading).abs();
            (turn / dt).max(pusher.turn_rate_rad_s.abs()) * pusher.form.reach_m()
        }
    };
    (way / dt).max(pusher.speed_m_s.abs()) + turning
}

/// Whether the robot moves, and so near to something that they might meet.
fn may_meet(pusher: &Pusher<'_>, movables: &[Movable], states: &[MovableState], dt: f64) -> bool {
    let (own, own_m) = (rate_m_s(pusher, dt), pusher.form.reach_m());
    let near = |(movable, state): (&Movable, &MovableState)| {
        let thing_m = movable.shape.form().reach_m();
        let rate = own + state.velocity_m_s.norm() + state.spin_rad_s.abs() * thing_m;
        let reach = thing_m + own_m + 2.0 * (rate * dt + SKIN_M);
        (state.pose.position - pusher.before.position).norm_squared() <= reach * reach
    };
    own > 0.0 && movables.iter().zip(states).any(near)
}

fn bot<'a>(pusher: &'a Pusher<'a>, near: bool, dt: f64) -> Bot<'a> {
    let (form, before) = (pusher.form, pusher.before);
    Bot {
        pusher,
        pose: before,
        body: form.at(&before),
        home: form.at(&before),
        reach_m: form.reach_m(),
        thickness_m: form.thickness_m(),
        rate_m_s: rate_m_s(pusher, dt),
        near,
        blocked: false,
        pushed: false,
        touched: None,
    }
}

fn unhindered(pusher: &Pusher<'_>) -> Reaction {
    Reaction {
        pose: pusher.after,
        speed_m_s: pusher.speed_m_s,
        turn_rate_rad_s: pusher.turn_rate_rad_s,
        blocked: false,
        touched: None,
    }
}

fn reaction(bot: &Bot<'_>, mover: &Mover) -> Reaction {
    let free = unhindered(bot.pusher);
    if bot.touched.is_none() {
        return free;
    }
    Reaction {
        pose: bot.pose,
        // Rounding must not change the speed of who was only blocked.
        speed_m_s: if bot.pushed { mover.velocity.dot(&bot.pusher.heading.vector()) } else { free.speed_m_s },
        turn_rate_rad_s: mover.spin,
        blocked: bot.blocked,
        touched: bot.touched,
    }
}

fn thing<'a>(movable: &'a Movable, state: &MovableState) -> Thing<'a> {
    let form = movable.shape.form();
    Thing {
        movable,
        pose: state.pose,
        body: form.at(&state.pose),
        reach_m: form.reach_m(),
        thickness_m: form.thickness_m(),
    }
}

fn mover(movable: &Movable, state: &MovableState) -> Mover {
    let (gyration, spin) = match movable.shape.form() {
        Form::Disc { .. } => (0.0, 0.0),
        Form::Polygon(points) => (polygon::second_moment(points), state.spin_rad_s),
    };
    Mover {
        center: state.pose.position,
        velocity: state.velocity_m_s,
        spin,
        mass: movable.mass_kg,
        gyration,
        rail: None,
        friction_left: 0.0,
        pressed: false,
    }
}

fn rolling(pusher: &Pusher<'_>) -> Mover {
    let rail = pusher.heading.vector();
    Mover {
        center: pusher.before.position,
        velocity: rail * pusher.speed_m_s,
        spin: pusher.turn_rate_rad_s,
        mass: pusher.mass_kg,
        gyration: match pusher.form {
            Form::Disc { .. } => 0.0,
            Form::Polygon(_) => pusher.inertia_kg_m2 / pusher.mass_kg,
        },
        rail: Some(rail),
        friction_left: 0.0,
        pressed: false,
    }
}
