//! Collisions of the robots' discs with the arena and with each other (§3.2.5).
//!
//! A robot runs into something; something does not run into it: of two robots that meet, only one that moves
//! towards the other has collided. The notes test where a body is after a step; so do we, and on the way as
//! well if the step is long against the body, so that none passes through a wall.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Vector, math};
use serde::{Deserialize, Serialize};

use crate::arena::Arena;

/// What a collision does, the same for all robots of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CollisionPolicy {
    /// The run ends, the pose uncorrected: ARSim's rule.
    StopRun,
    /// The robot stays where it was before the step that would have run into something, and loses its speed.
    /// It may turn, and drive away.
    StopRobot,
}

/// A robot ran into something.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Collision {
    /// Name of the robot.
    pub robot: String,
    /// Name of the shape or of the other robot.
    pub with: String,
}

/// The other party of a collision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Partner {
    Shape(String),
    Robot(usize),
}

/// The discs of all robots before and after a step, all free of each other and of the arena before it.
pub(crate) struct Step<'a> {
    pub(crate) arena: &'a Arena,
    pub(crate) before: &'a [Circle],
    pub(crate) after: Vec<Circle>,
}

impl Step<'_> {
    /// What robot `own` runs into in this step, if anything: the arena first, then the other robots in their
    /// order. Discs that touch exactly do not collide.
    pub(crate) fn partner(&self, own: usize) -> Option<Partner> {
        if let Some(name) = self.shape_on_the_way(own) {
            return Some(Partner::Shape(name.to_string()));
        }
        let way = self.way(own);
        let hit = |(i, other): (usize, &Circle)| {
            // A disc that does not approach another cannot come to overlap it by its own motion.
            i != own
                && self.after[own].overlaps_circle(other)
                && way.dot(&(self.before[i].center - self.before[own].center)) > 0.0
        };
        self.after.iter().enumerate().position(hit).map(Partner::Robot)
    }

    /// Half a radius is the longest way between two looks: a body cannot get past anything in between.
    fn shape_on_the_way(&self, own: usize) -> Option<&str> {
        let (before, after, way) = (&self.before[own], &self.after[own], self.way(own));
        let looks = math::ceil(way.norm() / (0.5 * after.radius)).clamp(1.0, MAX_LOOKS);
        (1..=looks as u32).find_map(|i| {
            let center = if f64::from(i) == looks {
                after.center
            } else {
                before.center + way * (f64::from(i) / looks)
            };
            self.arena.obstacle_at(&Circle { center, radius: after.radius })
        })
    }

    fn way(&self, own: usize) -> Vector {
        self.after[own].center - self.before[own].center
    }

    /// Which robots must stay where they were: those that would run into the arena or into one another, and
    /// those that would then run into one that stays.
    ///
    /// All robots are judged by the same picture in each round, so their order does not matter; each round
    /// stops more of them or is the last.
    pub(crate) fn held_back(mut self) -> Vec<Option<Partner>> {
        let mut held: Vec<Option<Partner>> = alloc::vec![None; self.after.len()];
        loop {
            let found: Vec<_> = (0..self.after.len())
                .filter(|&i| held[i].is_none())
                .filter_map(|i| self.partner(i).map(|partner| (i, partner)))
                .collect();
            if found.is_empty() {
                return held;
            }
            for (i, partner) in found {
                self.after[i] = self.before[i];
                held[i] = Some(partner);
            }
        }
    }
}

/// A step of more than this many half radii is looked at in so many places; no robot is that fast.
const MAX_LOOKS: f64 = 10_000.0;

#[cfg(test)]
mod tests {
    use baudbot_geometry::Point;

    use super::*;
    use crate::arena::Polygon;

    fn row(xs: &[f64]) -> Vec<Circle> {
        xs.iter().map(|&x| Circle { center: Point::new(x, 0.0), radius: 0.5 }).collect()
    }

    fn empty() -> Arena {
        Arena::new(Vec::new(), Vec::new())
    }

    #[test]
    fn a_queue_that_runs_up_holds_back_one_after_the_other() {
        // The first two meet head on; the third would run into the second's old place; the fourth is free.
        let before = row(&[0.0, 1.2, 2.3, 9.0]);
        let held = Step { arena: &empty(), before: &before, after: row(&[0.15, 1.05, 2.1, 9.2]) }.held_back();
        assert_eq!(held, [Some(Partner::Robot(1)), Some(Partner::Robot(0)), Some(Partner::Robot(1)), None]);
    }

    #[test]
    fn only_the_robot_behind_is_held_back_in_a_rear_end_collision() {
        let before = row(&[0.0, 1.1]);
        let held = Step { arena: &empty(), before: &before, after: row(&[0.3, 1.2]) }.held_back();
        assert_eq!(held, [Some(Partner::Robot(1)), None]);
    }

    #[test]
    fn touching_exactly_is_no_collision() {
        let before = row(&[-0.1, 1.0]);
        assert_eq!(Step { arena: &empty(), before: &before, after: row(&[0.0, 1.0]) }.partner(0), None);
        let near = Step { arena: &empty(), before: &before, after: row(&[0.001, 1.0]) };
        assert_eq!(near.partner(0), Some(Partner::Robot(1)));
        assert_eq!(near.partner(1), None, "it stood still");
    }

    #[test]
    fn nothing_passes_through_a_thin_wall_in_one_long_step() {
        let points =
            [(2.0, -1.0), (2.01, -1.0), (2.01, 1.0), (2.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec();
        let wall = Polygon { name: "wall".into(), points, solid: true };
        let arena = Arena::new(alloc::vec![wall], Vec::new());
        let before = row(&[0.0]);
        let step = Step { arena: &arena, before: &before, after: row(&[4.0]) };
        assert_eq!(step.partner(0), Some(Partner::Shape("wall".into())));
    }
}
