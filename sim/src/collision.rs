//! Collisions of the robots' discs with the arena and with each other (§3.2.5).

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_geometry::Circle;
use serde::{Deserialize, Serialize};

use crate::arena::Arena;

/// What a collision does, the same for all robots of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CollisionPolicy {
    /// The run ends, the pose uncorrected: ARSim's rule.
    StopRun,
    /// The robot stands still where it was before the step that would have run into something. It may turn
    /// and drive away.
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

/// What the disc of robot `own` runs into, if any: the arena first, then the other robots in their order.
/// Discs that touch exactly do not collide.
pub(crate) fn partner(arena: &Arena, discs: &[Circle], own: usize) -> Option<Partner> {
    if let Some(name) = arena.obstacle_at(&discs[own]) {
        return Some(Partner::Shape(name.to_string()));
    }
    let hit = |(i, other): (usize, &Circle)| i != own && discs[own].overlaps_circle(other);
    discs.iter().enumerate().position(hit).map(Partner::Robot)
}

/// The other party of a collision.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Partner {
    Shape(String),
    Robot(usize),
}

/// Which robots must stay where they were: those that would run into the arena or into one another, and
/// those that would then run into one that stays. `before` must be free of collisions.
///
/// All robots are judged by the same picture in each round, so their order does not matter; each round stops
/// more of them or is the last.
pub(crate) fn held_back(arena: &Arena, before: &[Circle], after: &[Circle]) -> Vec<Option<Partner>> {
    let mut discs = after.to_vec();
    let mut held: Vec<Option<Partner>> = alloc::vec![None; discs.len()];
    loop {
        let found: Vec<_> = (0..discs.len())
            .filter(|&i| held[i].is_none())
            .filter_map(|i| partner(arena, &discs, i).map(|partner| (i, partner)))
            .collect();
        if found.is_empty() {
            return held;
        }
        for (i, partner) in found {
            discs[i] = before[i];
            held[i] = Some(partner);
        }
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::Point;

    use super::*;

    fn row(xs: &[f64]) -> Vec<Circle> {
        xs.iter().map(|&x| Circle { center: Point::new(x, 0.0), radius: 0.5 }).collect()
    }

    #[test]
    fn a_queue_that_runs_up_holds_back_one_after_the_other() {
        let arena = Arena::new(Vec::new(), Vec::new());
        // The first two meet head on; the third would run into the second's old place; the fourth is free.
        let (before, after) = (row(&[0.0, 1.2, 2.3, 9.0]), row(&[0.15, 1.05, 2.1, 9.2]));
        let held = held_back(&arena, &before, &after);
        assert_eq!(held[0], Some(Partner::Robot(1)));
        assert_eq!(held[1], Some(Partner::Robot(0)));
        assert_eq!(held[2], Some(Partner::Robot(1)));
        assert_eq!(held[3], None);
    }

    #[test]
    fn touching_exactly_is_no_collision() {
        let arena = Arena::new(Vec::new(), Vec::new());
        assert_eq!(partner(&arena, &row(&[0.0, 1.0]), 0), None);
        assert_eq!(partner(&arena, &row(&[0.0, 0.999]), 0), Some(Partner::Robot(1)));
    }
}
