//! The part of a floor that can be sensed, from the arena itself: all that can be seen from places where a disc can be.

use std::collections::BTreeSet;

use baudbot_sim::World;

use super::Arena;

/// A straight wall: x, y, x, y.
type Wall = [f64; 4];

/// A place on the lattice.
type Place = (i32, i32);

/// The lattice's steps, in radii of the disc.
const STEP: f64 = 0.125;
/// The number of steps between the places of the disc from which the floor is viewed.
const LOOK_EVERY: i32 = 4;

/// An arena for a disc.
pub struct Truth {
    walls: Vec<Wall>,
    radius_m: f64,
    step_m: f64,
}

impl Truth {
    /// A `Truth` of an arena, for a disc of this radius.
    pub fn new(arena: &Arena, radius_m: f64) -> Self {
        let walls = arena.outlines.iter().flat_map(|outline| {
            let points = &outline.points_m;
            let edges = if outline.is_closed { points.len() } else { points.len() - 1 };
            (0..edges).map(|i| {
                let ([x0, y0], [x1, y1]) = (points[i], points[(i + 1) % points.len()]);
                [x0, y0, x1, y1]
            })
        });
        Self { walls: walls.collect(), radius_m, step_m: STEP * radius_m }
    }

    /// Share of the cells that can be seen from where the disc can get to from here, within the range, whose sensing was counted.
    pub fn share_sensed(&self, world: &World, start: [f64; 2], range_m: f64) -> f64 {
        let floor = world.scenario().rules.floor.as_ref().expect("the floor is counted");
        let coverage = world.score().coverage().expect("the floor is counted");
        let is_lookout = |(i, j): &Place| i % LOOK_EVERY == 0 && j % LOOK_EVERY == 0;
        let reached = self.reached(start).into_iter().filter(is_lookout);
        let reached: Vec<_> = reached.map(|place| self.point(place)).collect();
        let (mut sensable, mut sensed) = (0_u32, 0_u32);
        for (column, row) in
            (0..floor.rows()).flat_map(|row| (0..floor.columns()).map(move |column| (column, row)))
        {
            let center = floor.center(column, row);
            let to = [center.x, center.y];
            let is_seen = |from: &[f64; 2]| distance(*from, to) <= range_m && self.is_clear(*from, to);
            if floor.is_free(column, row) && reached.iter().any(is_seen) {
                sensable += 1;
                sensed += u32::from(coverage.is_sensed(floor, column, row));
            }
        }
        f64::from(sensed) / f64::from(sensable)
    }

    /// The places that the disc can reach from here.
    fn reached(&self, [x, y]: [f64; 2]) -> BTreeSet<Place> {
        let start = ((x / self.step_m).round() as i32, (y / self.step_m).round() as i32);
        // The start itself may be between places with room.
        let around = (-2..=2).flat_map(|i| (-2..=2).map(move |j| (start.0 + i, start.1 + j)));
        let mut waiting: Vec<_> = around.filter(|place| self.has_room(self.point(*place))).collect();
        let mut reached: BTreeSet<_> = waiting.iter().copied().collect();
        while let Some((i, j)) = waiting.pop() {
            for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
                if !reached.contains(&next) && self.has_room(self.point(next)) {
                    reached.insert(next);
                    waiting.push(next);
                }
            }
        }
        reached
    }

    fn has_room(&self, point: [f64; 2]) -> bool {
        self.walls.iter().all(|wall| to_wall(*wall, point) >= self.radius_m)
    }

    fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        !self.walls.iter().any(|&[x0, y0, x1, y1]| {
            let (a, b) = ([x0, y0], [x1, y1]);
            side(a, b, from) * side(a, b, to) < 0.0 && side(from, to, a) * side(from, to, b) <= 0.0
        })
    }

    fn point(&self, (i, j): Place) -> [f64; 2] {
        [f64::from(i) * self.step_m, f64::from(j) * self.step_m]
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn to_wall([x0, y0, x1, y1]: Wall, [x, y]: [f64; 2]) -> f64 {
    let (along_x, along_y) = (x1 - x0, y1 - y0);
    let part = ((x - x0) * along_x + (y - y0) * along_y) / (along_x * along_x + along_y * along_y);
    let part = part.clamp(0.0, 1.0);
    distance([x, y], [x0 + part * along_x, y0 + part * along_y])
}

/// On which side of a line from `a` to `b` a point is.
fn side(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::super::Outline;
    use super::*;

    /// A wall with a gap of half a metre lets a small disc through and not a large one, which sees a part of what is behind.
    #[test]
    fn what_can_be_sensed_is_what_can_be_seen_from_where_the_disc_can_be() {
        let wall = |points: &[[f64; 2]], is_closed| Outline {
            points_m: points.to_vec(),
            is_closed,
            is_island: false,
        };
        let outlines = vec![
            wall(&[[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]], true),
            wall(&[[4.0, 0.0], [4.0, 1.3]], false),
            wall(&[[4.0, 1.8], [4.0, 4.0]], false),
        ];
        let arena = Arena { outlines, starts_m: vec![], people_m: vec![] };
        let most_x = |radius_m: f64| {
            let truth = Truth::new(&arena, radius_m);
            let reached = truth.reached([1.0, 1.0]);
            reached.into_iter().map(|place| truth.point(place)[0]).fold(0.0, f64::max)
        };
        assert!(most_x(0.2) > 7.0 && most_x(0.3) < 4.0);
        let truth = Truth::new(&arena, 0.3);
        assert!(truth.is_clear([3.0, 1.5], [5.0, 1.6]) && !truth.is_clear([3.0, 1.0], [5.0, 1.1]));
    }
}
