//! A step in slices: who is awake, who is about to meet whom.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Pose};

use super::body::Body;
use super::contact::{self, Chain, Touch};
use super::solve::{self, Contact, Mover};
use super::step::{Fixed, Pusher};
use super::{Form, GRAVITY_M_S2, Movable, SKIN_M};

/// All that takes part in a step.
pub(super) struct Scene<'a> {
    pub(super) fixed: &'a Fixed<'a>,
    /// The whole step, in seconds.
    pub(super) dt: f64,
    pub(super) things: Vec<Thing<'a>>,
    pub(super) bots: Vec<Bot<'a>>,
    /// The things first, then the robots.
    pub(super) movers: Vec<Mover>,
}

/// A movable in its place.
pub(super) struct Thing<'a> {
    pub(super) movable: &'a Movable,
    pub(super) pose: Pose,
    pub(super) body: Body,
    pub(super) reach_m: f64,
    pub(super) thickness_m: f64,
}

/// A robot on its way.
pub(super) struct Bot<'a> {
    pub(super) pusher: &'a Pusher<'a>,
    pub(super) pose: Pose,
    pub(super) body: Body,
    /// The pose at the start of the step, to which it may have to return.
    pub(super) home: Body,
    pub(super) reach_m: f64,
    pub(super) thickness_m: f64,
    /// The speed of its fastest corner, in m/s, if nothing hinders it.
    pub(super) rate_m_s: f64,
    /// Whether it may meet something in this step.
    pub(super) near: bool,
    pub(super) blocked: bool,
    /// Whether its speed was changed.
    pub(super) pushed: bool,
    pub(super) touched: Option<usize>,
}

impl<'a> Thing<'a> {
    pub(super) fn form(&self) -> Form<'a> {
        self.movable.shape.form()
    }

    /// Whether the two are at most `gap_m` apart, judged by the circles around them.
    pub(super) fn is_near(&self, pose: &Pose, reach_m: f64, gap_m: f64) -> bool {
        let far = self.reach_m + reach_m + gap_m;
        (self.pose.position - pose.position).norm_squared() <= far * far
    }
}

impl Scene<'_> {
    /// Lets the whole step pass.
    pub(super) fn run(&mut self) {
        let mut left = self.dt;
        while left > 0.0 {
            let wanted = self.slice_s().max(self.dt / MOST_SLICES);
            let last = wanted >= left * ALMOST_ONE;
            let h = if last { left } else { wanted };
            self.slice(h, last);
            left = if last { 0.0 } else { left - h };
        }
    }

    /// The longest time in which nothing moves by more than half of its thickness.
    fn slice_s(&self) -> f64 {
        let things = self.things.iter().zip(&self.movers);
        let things = things.map(|(thing, mover)| thing.thickness_m / rate(mover, thing.reach_m));
        let bots = self.bots.iter().enumerate().filter(|(_, bot)| bot.near);
        let bots = bots.map(|(i, bot)| bot.thickness_m / self.bot_rate(i));
        0.5 * things.chain(bots).fold(f64::INFINITY, f64::min)
    }

    fn bot_rate(&self, i: usize) -> f64 {
        let bot = &self.bots[i];
        rate(&self.movers[self.things.len() + i], bot.reach_m).max(bot.rate_m_s)
    }

    fn slice(&mut self, h: f64, last: bool) {
        let things = self.things.iter().zip(&self.movers).map(|(thing, mover)| rate(mover, thing.reach_m));
        let bots = (0..self.bots.len()).filter(|&i| self.bots[i].near).map(|i| self.bot_rate(i));
        // A light ball can leave at twice the speed at which it was hit, towards another that comes as fast.
        let reach = SKIN_M + 4.0 * h * things.chain(bots).fold(0.0, f64::max);
        let awake = self.awake(reach);
        let mut contacts = self.contacts(&awake, reach);
        let places = self.things.iter().map(|thing| thing.pose).chain(self.bots.iter().map(|bot| bot.pose));
        for (mover, pose) in self.movers.iter_mut().zip(places) {
            mover.center = pose.position;
            mover.pressed = false;
        }
        for ((mover, thing), &awake) in self.movers.iter_mut().zip(&self.things).zip(&awake) {
            mover.friction_left = if awake { thing.movable.friction * GRAVITY_M_S2 * h } else { 0.0 };
        }
        let before = self.movers.clone();
        solve::solve(&mut self.movers, &mut contacts, h);
        self.note(&contacts);
        self.move_things(&awake, &before, &contacts, h);
        self.move_bots(h, last);
    }

    /// The things that move, or are so near to one that does that they may be moved in this slice.
    fn awake(&self, reach_m: f64) -> Vec<bool> {
        let near_bot = |thing: &Thing<'_>| {
            let near = |(i, bot): (usize, &Bot<'_>)| {
                self.bot_rate(i) > 0.0 && thing.is_near(&bot.pose, bot.reach_m, reach_m)
            };
            self.bots.iter().enumerate().any(near)
        };
        let starts = self.things.iter().zip(&self.movers);
        let mut awake: Vec<_> = starts.map(|(thing, mover)| mover.pace() > 0.0 || near_bot(thing)).collect();
        let mut fresh: Vec<_> = (0..awake.len()).filter(|&i| awake[i]).collect();
        while let Some(i) = fresh.pop() {
            for (j, other) in self.things.iter().enumerate() {
                if !awake[j] && self.things[i].is_near(&other.pose, other.reach_m, reach_m) {
                    awake[j] = true;
                    fresh.push(j);
                }
            }
        }
        awake
    }

    fn contacts(&self, awake: &[bool], reach_m: f64) -> Vec<Contact> {
        let n = self.things.len();
        let mut found = Vec::new();
        for (i, thing) in self.things.iter().enumerate().filter(|(i, _)| awake[*i]) {
            let own = Chain::of_body(&thing.body);
            let mut meet = |chain: &Chain, b: Option<usize>, restitution: f64| {
                contact::touches(&own, thing.pose.position, chain, reach_m, |touch: Touch| {
                    found.push(Contact::new(i, b, touch, restitution));
                });
            };
            let e = thing.movable.restitution;
            let near = Circle { center: thing.pose.position, radius: thing.reach_m + reach_m };
            Chain::of_arena(self.fixed.arena, &near).iter().for_each(|chain| meet(chain, None, e));
            self.fixed.bodies.iter().for_each(|body| meet(&Chain::of_body(body), None, e));
            for (j, bot) in self.bots.iter().enumerate() {
                if thing.is_near(&bot.pose, bot.reach_m, reach_m) {
                    meet(&Chain::of_body(&bot.body), Some(n + j), e);
                }
            }
            // A thing near to one that is awake is awake, and finds it.
            for (j, other) in self.things.iter().enumerate().skip(i + 1) {
                if thing.is_near(&other.pose, other.reach_m, reach_m) {
                    meet(&Chain::of_body(&other.body), Some(j), e.min(other.movable.restitution));
                }
            }
        }
        found
    }

    fn note(&mut self, contacts: &[Contact]) {
        for contact in contacts.iter().filter(|contact| contact.struck) {
            let Some(i) = contact.b.and_then(|b| b.checked_sub(self.things.len())) else { continue };
            self.bots[i].pushed = true;
            self.bots[i].touch(contact.a);
        }
    }
}

impl Bot<'_> {
    pub(super) fn touch(&mut self, thing: usize) {
        self.touched = Some(self.touched.map_or(thing, |first| first.min(thing)));
    }
}

/// The speed of its fastest corner, in m/s.
fn rate(mover: &Mover, reach_m: f64) -> f64 {
    let turning = if mover.gyration > 0.0 { mover.spin.abs() * reach_m } else { 0.0 };
    mover.velocity.norm() + turning
}

const MOST_SLICES: f64 = 1000.0;

/// Spares a last slice of the length of a rounding error.
const ALMOST_ONE: f64 = 1.0 - 1e-9;
