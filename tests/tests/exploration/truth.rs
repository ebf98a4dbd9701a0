//! What could be sensed of a floor, from the arena itself: all that can be seen from where a disc can be.

use std::collections::BTreeSet;

use baudbot_brains::exploration::generated::Plan;
use baudbot_sim::World;

/// A straight wall: x, y, x, y.
type Wall = [f64; 4];

/// A place on the lattice.
type Place = (i32, i32);

const STEP_M: f64 = 0.025;
/// Of the places where the disc can be it looks around from those that are so many steps apart.
const LOOK_EVERY: i32 = 4;

/// An arena for a disc.
pub(super) struct Truth {
    walls: Vec<Wall>,
    boxes: Vec<[f64; 4]>,
    size_m: (f64, f64),
    radius_m: f64,
}

impl Truth {
    /// Of a plan whose boxes are rectangles.
    pub(super) fn new(plan: &Plan, radius_m: f64) -> Self {
        let (width, height) = plan.size_m;
        let none = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let boxes = plan.boxes.iter().map(|points| {
            points
                .iter()
                .fold(none, |[x0, y0, x1, y1], p| [x0.min(p.x), y0.min(p.y), x1.max(p.x), y1.max(p.y)])
        });
        let boxes: Vec<[f64; 4]> = boxes.collect();
        let border = [0.0, 0.0, width, height];
        let edges = |&[x0, y0, x1, y1]: &[f64; 4]| {
            [[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]]
        };
        let walls = boxes.iter().chain([&border]).flat_map(edges).chain(plan.walls.iter().copied()).collect();
        Self { walls, boxes, size_m: plan.size_m, radius_m }
    }

    /// Share of the cells that can be seen from where the disc can get to from here, within the range, whose sensing was counted.
    pub(super) fn share_sensed(&self, world: &World, start: [f64; 2], range_m: f64) -> f64 {
        let floor = world.scenario().rules.floor.as_ref().expect("the floor is counted");
        let coverage = world.score().coverage().expect("the floor is counted");
        let reached: Vec<_> = self.reached(start).into_iter().filter(is_lookout).map(point).collect();
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

    /// Where the disc can be.
    fn reached(&self, [x, y]: [f64; 2]) -> BTreeSet<Place> {
        let start = ((x / STEP_M).round() as i32, (y / STEP_M).round() as i32);
        // The start itself may be between places with room.
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (start.0 + i, start.1 + j)));
        let mut waiting: Vec<_> = around.filter(|place| self.has_room(point(*place))).collect();
        let mut reached: BTreeSet<_> = waiting.iter().copied().collect();
        while let Some((i, j)) = waiting.pop() {
            for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
                if !reached.contains(&next) && self.has_room(point(next)) {
                    reached.insert(next);
                    waiting.push(next);
                }
            }
        }
        reached
    }

    fn has_room(&self, [x, y]: [f64; 2]) -> bool {
        let is_in = |&[x0, y0, x1, y1]: &[f64; 4]| x0 < x && x < x1 && y0 < y && y < y1;
        is_in(&[0.0, 0.0, self.size_m.0, self.size_m.1])
            && !self.boxes.iter().any(is_in)
            && self.walls.iter().all(|wall| to_wall(*wall, [x, y]) >= self.radius_m)
    }

    fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        !self.walls.iter().any(|&[x0, y0, x1, y1]| {
            let (a, b) = ([x0, y0], [x1, y1]);
            side(a, b, from) * side(a, b, to) < 0.0 && side(from, to, a) * side(from, to, b) <= 0.0
        })
    }
}

fn is_lookout((i, j): &Place) -> bool {
    i % LOOK_EVERY == 0 && j % LOOK_EVERY == 0
}

fn point((i, j): Place) -> [f64; 2] {
    [f64::from(i) * STEP_M, f64::from(j) * STEP_M]
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

/// A wall with a gap of half a metre lets a small disc through and not a large one, which sees a part of what is behind.
#[test]
fn what_can_be_sensed_is_what_can_be_seen_from_where_the_disc_can_be() {
    let plan = Plan::rooms_with(0.5);
    let reached = |radius_m: f64| Truth::new(&plan, radius_m).reached([1.0, 1.0]);
    let (small, large) = (reached(0.2), reached(0.3));
    assert!(
        small.iter().any(|place| point(*place)[0] > 7.0) && large.iter().all(|place| point(*place)[0] < 4.0)
    );
    assert!(!small.contains(&(4, 4)) && small.contains(&(40, 40)));
    let truth = Truth::new(&plan, 0.3);
    assert!(truth.is_clear([3.0, 1.5], [5.0, 1.6]) && !truth.is_clear([3.0, 1.0], [5.0, 1.1]));
}
