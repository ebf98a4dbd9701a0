//! The end of a slice: things and robots take new poses, if these are free.

use alloc::vec::Vec;

use baudbot_geometry::{Pose, Vector, angle};

use super::body::Body;
use super::slice::{Bot, Scene, Thing};
use super::solve::{Contact, Mover};
use super::{GRAVITY_M_S2, SKIN_M};

/// A way and a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Move {
    way: Vector,
    turn: f64,
}

impl Move {
    fn scaled(&self, part: f64) -> Self {
        Self { way: self.way * part, turn: self.turn * part }
    }

    fn from(&self, pose: &Pose) -> Pose {
        Pose { position: pose.position + self.way, heading: angle::wrap(pose.heading + self.turn) }
    }
}

impl Scene<'_> {
    /// A thing whose pose is taken tries again when others have moved on; at last it takes a part of its way.
    pub(super) fn move_things(&mut self, awake: &[bool], before: &[Mover], contacts: &[Contact], h: f64) {
        let mut moves: Vec<_> = (0..self.things.len()).map(|i| self.way(i, &before[i], h)).collect();
        self.part(&mut moves, contacts);
        let mut waiting: Vec<_> = (0..moves.len())
            .filter(|&i| awake[i] && (moves[i].way != Vector::zeros() || moves[i].turn != 0.0))
            .collect();
        loop {
            let count = waiting.len();
            waiting.retain(|&i| !self.try_thing(i, &moves[i]));
            if waiting.is_empty() {
                return;
            }
            if waiting.len() == count {
                break;
            }
        }
        for i in waiting {
            if ![0.5, 0.25, 0.125].iter().any(|&part| self.try_thing(i, &moves[i].scaled(part))) {
                self.movers[i].velocity *= 0.5;
                self.movers[i].spin *= 0.5;
            }
        }
    }

    /// The way of a thing in the slice. A thing that only slides is slowed evenly and may stop in it.
    fn way(&self, i: usize, before: &Mover, h: f64) -> Move {
        let (thing, now) = (&self.things[i], &self.movers[i]);
        let turn = |spin: f64| if now.gyration > 0.0 { spin } else { 0.0 };
        let wanted = if now.pressed {
            Move { way: now.velocity * h, turn: turn(now.spin) * h }
        } else {
            let (pace, rest) = (before.pace(), now.pace());
            let slowing = thing.movable.friction * GRAVITY_M_S2;
            let time = if rest > 0.0 || slowing <= 0.0 { h } else { (pace / slowing).min(h) };
            let mean = 0.5 * time;
            Move { way: (before.velocity + now.velocity) * mean, turn: turn(before.spin + now.spin) * mean }
        };
        let length = wanted.way.norm() + wanted.turn.abs() * thing.reach_m;
        if length > thing.thickness_m { wanted.scaled(thing.thickness_m / length) } else { wanted }
    }

    /// Things that press on something closer than half the skin back off a little.
    fn part(&self, moves: &mut [Move], contacts: &[Contact]) {
        for contact in contacts.iter().filter(|contact| contact.impulse > 0.0) {
            let lacking = 0.5 * SKIN_M - contact.touch.gap;
            if lacking > 0.0 {
                let back = contact.touch.normal * (0.5 * lacking);
                moves[contact.a].way += back;
                if let Some(other) = contact.b.and_then(|b| moves.get_mut(b)) {
                    other.way -= back;
                }
            }
        }
    }

    fn try_thing(&mut self, i: usize, wanted: &Move) -> bool {
        let pose = wanted.from(&self.things[i].pose);
        let body = self.things[i].form().at(&pose);
        let free = self.is_free(i, &pose, &body);
        if free {
            self.things[i].pose = pose;
            self.things[i].body = body;
        }
        free
    }

    fn is_free(&self, i: usize, pose: &Pose, body: &Body) -> bool {
        let (own, reach) = (self.things[i].pose.position, self.things[i].reach_m);
        let near = SKIN_M + (pose.position - own).norm();
        let hits_thing = |(j, other): (usize, &Thing<'_>)| {
            j != i && other.is_near(pose, reach, SKIN_M) && body.overlaps(&other.body)
        };
        // A robot may have to return to where it was.
        let hits_bot = |bot: &Bot<'_>| {
            let meets = |place: &Pose, other: &Body| {
                self.things[i].is_near(place, bot.reach_m, near) && body.overlaps(other)
            };
            meets(&bot.pusher.before, &bot.home)
                || (bot.pose != bot.pusher.before && meets(&bot.pose, &bot.body))
        };
        !self.things.iter().enumerate().any(hits_thing)
            && !self.bots.iter().any(hits_bot)
            && !self.fixed.bodies.iter().any(|other| body.overlaps(other))
            && !body.overlaps_arena(self.fixed.arena)
    }

    /// The robots' order does not matter, as each is tried with things alone.
    pub(super) fn move_bots(&mut self, h: f64, last: bool) {
        for i in 0..self.bots.len() {
            let wanted = self.roll(i, h);
            let bot = &self.bots[i];
            if last && bot.touched.is_none() && self.try_bot(i, bot.pusher.after) {
                continue;
            }
            let tries = [1.0, 0.5, 0.25].map(|part| wanted.scaled(part).from(&self.bots[i].pose));
            let taken = tries.into_iter().position(|pose| self.try_bot(i, pose));
            self.bots[i].blocked |= taken != Some(0);
        }
    }

    /// The robot's part of the step, changed as its speeds were.
    fn roll(&self, i: usize, h: f64) -> Move {
        let (bot, mover) = (&self.bots[i], &self.movers[self.things.len() + i]);
        let (before, after) = (&bot.pusher.before, &bot.pusher.after);
        let part = h / self.dt;
        let mut wanted = Move {
            way: (after.position - before.position) * part,
            turn: angle::difference(after.heading, before.heading) * part,
        };
        if bot.pushed {
            let heading = bot.pusher.heading.vector();
            wanted.way -= heading * ((bot.pusher.speed_m_s - mover.velocity.dot(&heading)) * h);
            wanted.turn -= (bot.pusher.turn_rate_rad_s - mover.spin) * h;
        }
        wanted
    }

    fn try_bot(&mut self, i: usize, pose: Pose) -> bool {
        let bot = &self.bots[i];
        let body = bot.pusher.form.at(&pose);
        let hit = self
            .things
            .iter()
            .position(|thing| thing.is_near(&pose, bot.reach_m, SKIN_M) && body.overlaps(&thing.body));
        let bot = &mut self.bots[i];
        if let Some(thing) = hit {
            bot.touch(thing);
            return false;
        }
        bot.pose = pose;
        bot.body = body;
        true
    }
}
