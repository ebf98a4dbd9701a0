//! Random arenas: rooms, offices and corridors with tables and pillars, each chosen by a number.
//!
//! They are for tests of explorers, here and of the whole system, and no part of what this crate promises.

use baudbot_geometry::{Point, Segment, polygon};

use crate::Chance;

#[cfg(test)]
mod tests;

/// A corridor's course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// A straight corridor, 8 m long.
    Straight,
    /// 8 m, round a corner, and 6 m.
    Bent,
    /// A spine with four teeth of 3 m.
    Comb,
    /// A spiral inwards, round eight corners.
    Spiral,
    /// 8 m, and 5 m from its middle.
    Branching,
}

impl Course {
    /// All courses.
    pub const ALL: [Self; 5] = [Self::Straight, Self::Bent, Self::Comb, Self::Spiral, Self::Branching];
}

/// Walls, and what stands between them.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Width and height, with one corner at the origin, in metres.
    pub size_m: (f64, f64),
    /// Walls from one point to another: x, y, x, y, in metres. Those around the whole are not among them.
    pub walls: Vec<[f64; 4]>,
    /// The boxes as polygons, in metres.
    pub boxes: Vec<Vec<Point>>,
    chance: Chance,
}

impl Plan {
    /// The arena of a number: by turns a room, an office, a corridor.
    #[must_use]
    pub fn generate(number: u64) -> Self {
        let mut plan = Self::empty(number);
        match number % 3 {
            0 => {}
            1 => plan.office(),
            _ => plan.corridor(),
        }
        plan.furnish();
        plan
    }

    /// A corridor of this width, in metres, with nothing in it.
    #[must_use]
    pub fn corridor_of(course: Course, width_m: f64) -> Self {
        let w = width_m;
        let plan =
            |size_m, boxes: Vec<Vec<Point>>, walls| Self { size_m, walls, boxes, chance: Chance::new(0, "") };
        match course {
            Course::Straight => plan((8.0, w), vec![], vec![]),
            Course::Bent => plan((8.0, 6.0), vec![rectangle(0.0, w, 8.0 - w, 6.0)], vec![]),
            Course::Comb => {
                let between = |tooth: i32| {
                    let x = f64::from(tooth) * (w + TOOTH_GAP_M);
                    rectangle(x + w, w, x + w + TOOTH_GAP_M, w + 3.0)
                };
                plan((4.0 * w + 3.0 * TOOTH_GAP_M, w + 3.0), (0..3).map(between).collect(), vec![])
            }
            Course::Spiral => {
                let turns = [
                    (0.0, 1.0),
                    (5.0, 1.0),
                    (5.0, 5.0),
                    (1.0, 5.0),
                    (1.0, 2.0),
                    (4.0, 2.0),
                    (4.0, 4.0),
                    (2.0, 4.0),
                    (2.0, 3.0),
                    (3.0, 3.0),
                ];
                let wall = |pair: &[(f64, f64)]| [pair[0].0 * w, pair[0].1 * w, pair[1].0 * w, pair[1].1 * w];
                plan((6.0 * w, 6.0 * w), vec![], turns.windows(2).map(wall).collect())
            }
            Course::Branching => {
                let (left, right) = (4.0 - 0.5 * w, 4.0 + 0.5 * w);
                let top = w + 5.0;
                plan((8.0, top), vec![rectangle(0.0, w, left, top), rectangle(right, w, 8.0, top)], vec![])
            }
        }
    }

    /// Two rooms of 4 m by 4 m, and a door of this width in metres between them.
    #[must_use]
    pub fn rooms_with(door_m: f64) -> Self {
        let walls = vec![[4.0, 0.0, 4.0, 1.3], [4.0, 1.3 + door_m, 4.0, 4.0]];
        Self { size_m: (8.0, 4.0), walls, boxes: vec![], chance: Chance::new(0, "") }
    }

    fn empty(number: u64) -> Self {
        let mut chance = Chance::new(number, "arena");
        let size_m = (between(&mut chance, 5.0, 12.0), between(&mut chance, 4.0, 9.0));
        // The size is rounded to whole cells of the floor that is counted.
        let size_m = ((size_m.0 * 10.0).round() / 10.0, (size_m.1 * 10.0).round() / 10.0);
        Self { size_m, walls: vec![], boxes: vec![], chance }
    }

    /// A wall along x, if it is, or along y, from `from` to `to`, with these doors, each from one place to another.
    fn wall(&mut self, along_x: bool, at: f64, from: f64, to: f64, doors: &[[f64; 2]]) {
        let mut begin = from;
        for [end, next] in doors.iter().copied().chain([[to, to]]) {
            self.walls.push(if along_x { [begin, at, end, at] } else { [at, begin, at, end] });
            begin = next;
        }
    }

    fn door(&mut self, from: f64, to: f64) -> [f64; 2] {
        let width_m = self.one_of(DOORS_M);
        let begin = between(&mut self.chance, from + 0.4, to - 0.4 - width_m);
        [begin, begin + width_m]
    }

    fn one_of(&mut self, widths_m: [f64; 5]) -> f64 {
        widths_m[(self.chance.uniform() * 5.0) as usize % 5]
    }

    /// Rooms side by side, each with a door to the next.
    fn office(&mut self) {
        let (width, height) = self.size_m;
        let rooms = (width / 3.5).floor().max(2.0);
        for i in 1..rooms as usize {
            let door = self.door(0.0, height);
            self.wall(false, width * i as f64 / rooms, 0.0, height, &[door]);
        }
    }

    /// A corridor with rooms on both sides, each with a door to it.
    fn corridor(&mut self) {
        let half_m = 0.5 * self.one_of(CORRIDORS_M);
        let (width, height) = (self.size_m.0, self.size_m.1.max(8.0));
        self.size_m.1 = height;
        let rooms = (width / 3.0).floor().max(2.0);
        for (wall, from, to) in [
            (0.5 * height - half_m, 0.0, 0.5 * height - half_m),
            (0.5 * height + half_m, 0.5 * height + half_m, height),
        ] {
            let mut doors = vec![];
            for i in 0..rooms as usize {
                let [begin, end] = [i, i + 1].map(|i| width * i as f64 / rooms);
                doors.push(self.door(begin, end));
                if i > 0 {
                    self.wall(false, begin, from, to, &[]);
                }
            }
            self.wall(true, wall, 0.0, width, &doors);
        }
    }

    /// Tables and pillars, so far from all else that the robot can pass.
    fn furnish(&mut self) {
        for _ in 0..8 {
            let half = |chance: &mut Chance| between(chance, 0.15, 0.6);
            let (a, b) = (half(&mut self.chance), half(&mut self.chance));
            let (x, y) = (self.size_m.0 * self.chance.uniform(), self.size_m.1 * self.chance.uniform());
            let (center, reach) = (Point::new(x, y), a.hypot(b) + PASSAGE_M);
            let wall = |&[x, y, u, v]: &[f64; 4]| Segment { start: Point::new(x, y), end: Point::new(u, v) };
            let border = rectangle(0.0, 0.0, self.size_m.0, self.size_m.1);
            let edges = self.boxes.iter().chain([&border]).flat_map(|points| polygon::edges(points));
            if self.walls.iter().map(wall).chain(edges).all(|segment| segment.distance(center) > reach) {
                self.boxes.push(rectangle(x - a, y - b, x + a, y + b));
            }
        }
    }
}

/// A rectangle by two corners.
pub(super) fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Point> {
    vec![Point::new(x0, y0), Point::new(x1, y0), Point::new(x1, y1), Point::new(x0, y1)]
}

fn between(chance: &mut Chance, least: f64, most: f64) -> f64 {
    least + (most - least) * chance.uniform()
}

const DOORS_M: [f64; 5] = [0.6, 0.7, 0.8, 1.0, 1.2];
const CORRIDORS_M: [f64; 5] = [0.9, 1.0, 1.2, 1.5, 2.0];
/// The width of the solid part between two teeth of a comb.
const TOOTH_GAP_M: f64 = 0.5;
/// Room that there is at least between things.
const PASSAGE_M: f64 = 0.9;
