//! Arenas for tests, and a robot in them that obeys its commands at once: a disc with a laser, without mass or delay.

use std::f64::consts::PI;

use baudbot_geometry::{Direction, Index, Point, Pose, Ray, Segment, angle, polygon};

use super::generated::rectangle;
use super::{Command, Explorer, Input};
use crate::Chance;
use crate::mapping::PlacedScan;
use crate::scan::Scan;

/// Walls that the laser sees, and low boxes over which it looks.
pub(crate) struct Arena {
    size_m: (f64, f64),
    /// Obstacles that the laser sees.
    seen: Index,
    /// Obstacles for the robot's body.
    solid: Index,
    boxes: Vec<Vec<Point>>,
    low: Vec<Vec<Point>>,
}

/// The course of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) end: Command,
    pub(crate) sensed: f64,
    pub(crate) path_m: f64,
    pub(crate) seconds: f64,
    /// The least room that the disc had, in metres.
    pub(crate) least_room_m: f64,
}

impl Run {
    /// Whether it is over, and nothing was left out.
    pub(crate) fn has_seen_all(&self) -> bool {
        matches!(self.end, Command::Done(left_out) if left_out.is_nothing())
    }
}

impl Arena {
    pub(crate) fn new(
        size_m: (f64, f64),
        walls: &[[f64; 4]],
        boxes: Vec<Vec<Point>>,
        low: Vec<Vec<Point>>,
    ) -> Self {
        let wall =
            |&[x0, y0, x1, y1]: &[f64; 4]| Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) };
        let border = rectangle(0.0, 0.0, size_m.0, size_m.1);
        let edges = |polygons: &[Vec<Point>]| -> Vec<Segment> {
            polygons.iter().flat_map(|points| polygon::edges(points)).collect()
        };
        let mut seen: Vec<_> = polygon::edges(&border).chain(walls.iter().map(wall)).collect();
        seen.extend(edges(&boxes));
        let solid = seen.iter().copied().chain(edges(&low)).collect();
        Self { size_m, seen: Index::new(seen, vec![]), solid: Index::new(solid, vec![]), boxes, low }
    }

    /// A room of 5 m by 4 m with a box that the laser overlooks, as in Fig. 6.2.
    pub(crate) fn room() -> Self {
        Self::new((5.0, 4.0), &[], vec![], vec![rectangle(3.2, 1.2, 3.8, 1.8)])
    }

    /// An office of 12 m by 9 m, in the manner of Fig. 6.4.
    pub(crate) fn office() -> Self {
        let walls = [
            [4.5, 0.0, 4.5, 1.4],
            [4.5, 2.6, 4.5, 6.6],
            [4.5, 7.8, 4.5, 9.0],
            [8.0, 0.0, 8.0, 1.4],
            [8.0, 2.6, 8.0, 6.2],
            [8.0, 7.4, 8.0, 9.0],
            [4.5, 4.5, 5.6, 4.5],
            [6.8, 4.5, 8.0, 4.5],
        ];
        let boxes = vec![rectangle(10.0, 3.5, 11.0, 4.5), rectangle(1.0, 5.0, 1.8, 6.5)];
        Self::new((12.0, 9.0), &walls, boxes, vec![])
    }

    /// Poses at which the robot fits, with 5 cm to spare.
    pub(crate) fn starts(&self, count: usize) -> Vec<Pose> {
        let mut chance = Chance::new(1, "starts");
        let mut poses = Vec::new();
        while poses.len() < count {
            let (x, y) = (self.size_m.0 * chance.uniform(), self.size_m.1 * chance.uniform());
            let pose = Pose::new(x, y, angle::wrap(2.0 * PI * chance.uniform()));
            if self.is_floor(pose.position) && self.room_m(pose.position) > 0.05 {
                poses.push(pose);
            }
        }
        poses
    }

    /// Whether a point is between the walls, and in no box.
    fn is_floor(&self, point: Point) -> bool {
        !self.boxes.iter().chain(&self.low).any(|points| polygon::contains(points, point))
    }

    /// The room between the disc at a point and anything that it must not drive into.
    fn room_m(&self, point: Point) -> f64 {
        self.solid.nearest_point(point).map_or(f64::INFINITY, |(_, distance)| distance - RADIUS_M)
    }

    fn scan(&self, world_from_robot: Pose) -> PlacedScan {
        let mut scan = Scan {
            robot_from_laser: Pose::new(0.0, 0.0, 0.0),
            opening_rad: 4.0 * PI / 3.0,
            range_m: RANGE_M,
            distances_m: vec![f64::INFINITY; RAYS],
        };
        let forward = world_from_robot.direction();
        for i in 0..RAYS {
            let direction = forward.rotate(Direction::from_angle(scan.bearing_rad(i)));
            let ray = Ray { origin: world_from_robot.position, direction };
            scan.distances_m[i] = self.seen.cast(&ray, RANGE_M).map_or(f64::INFINITY, |hit| hit.distance);
        }
        PlacedScan::new(world_from_robot, scan)
    }

    /// Whether something would be almost touched a little farther ahead.
    fn is_near(&self, pose: &Pose) -> bool {
        self.room_m(pose.position + pose.direction().vector() * NEAR_M) < ALMOST_M
    }

    /// The cells that are visible from all places that the robot can reach from here, with a little room to spare.
    pub(crate) fn visible_from(&self, here: Point) -> Sensed {
        let mut visible = Sensed::new(self);
        let cell = |point: Point| ((point.x / CELL_M) as usize, (point.y / CELL_M) as usize);
        let mut waiting = vec![cell(here)];
        let mut reached = std::collections::BTreeSet::from([cell(here)]);
        while let Some((column, row)) = waiting.pop() {
            let point = |column: usize, row: usize| {
                Point::new((column as f64 + 0.5) * CELL_M, (row as f64 + 0.5) * CELL_M)
            };
            if (column + row) % 4 == 0 && column % 2 == 0 {
                let here = point(column, row);
                for heading in [0.0, PI] {
                    visible.mark(&self.scan(Pose { position: here, heading }));
                }
            }
            for (column, row) in [
                (column + 1, row),
                (column, row + 1),
                (column.wrapping_sub(1), row),
                (column, row.wrapping_sub(1)),
            ] {
                let is_in = column < visible.columns && row < visible.is_floor.len() / visible.columns;
                let has_room = is_in && {
                    let point = point(column, row);
                    self.is_floor(point) && self.room_m(point) > PASSABLE_M
                };
                if has_room && reached.insert((column, row)) {
                    waiting.push((column, row));
                }
            }
        }
        visible
    }

    /// Lets a robot explore from this pose to the end, at most 20 minutes; `look` sees it after each step. All the floor
    /// counts.
    pub(crate) fn run<E: Explorer>(&self, explorer: &mut E, start: Pose, look: impl Fn(&E)) -> Run {
        let mut all = Sensed::new(self);
        all.is_sensed.clone_from(&all.is_floor);
        self.run_for(explorer, start, all, look)
    }

    /// The same, but only what is marked counts.
    pub(crate) fn run_for<E: Explorer>(
        &self,
        explorer: &mut E,
        start: Pose,
        wanted: Sensed,
        look: impl Fn(&E),
    ) -> Run {
        let mut sensed = Sensed { is_floor: wanted.is_sensed, ..Sensed::new(self) };
        let mut pose = start;
        let mut scan = self.scan(pose);
        let mut run =
            Run { end: Command::Wait, sensed: 0.0, path_m: 0.0, seconds: 0.0, least_room_m: f64::INFINITY };
        for step in 0..(1200.0 / STEP_S) as usize {
            if step % STEPS_A_SCAN == 0 {
                scan = self.scan(pose);
                sensed.mark(&scan);
            }
            let input = Input { world_from_robot: pose, scan: Some(&scan), near: self.is_near(&pose) };
            run.end = explorer.step(&input);
            look(explorer);
            if matches!(run.end, Command::Done(_) | Command::Failed(_)) {
                break;
            }
            let next = moved(&pose, run.end);
            run.path_m += (next.position - pose.position).norm();
            run.seconds += STEP_S;
            pose = next;
            run.least_room_m = run.least_room_m.min(self.room_m(pose.position));
        }
        run.sensed = sensed.fraction();
        run
    }
}

/// The pose of a robot a step later.
fn moved(pose: &Pose, command: Command) -> Pose {
    let toward = |heading_rad: f64| {
        let most_rad = TURN_RATE_RAD_S * STEP_S;
        angle::wrap(pose.heading + angle::difference(heading_rad, pose.heading).clamp(-most_rad, most_rad))
    };
    match command {
        Command::Turn { heading_rad } => Pose { heading: toward(heading_rad), ..*pose },
        Command::Drive { to } => {
            let offset = to - pose.position;
            let heading = toward(offset.y.atan2(offset.x));
            let step_m = (SPEED_M_S * STEP_S).min(offset.norm());
            Pose { position: pose.position + Direction::from_angle(heading).vector() * step_m, heading }
        }
        Command::Wait | Command::Done(_) | Command::Failed(_) => *pose,
    }
}

/// Cells of the floor that a ray has touched.
pub(crate) struct Sensed {
    columns: usize,
    is_floor: Vec<bool>,
    is_sensed: Vec<bool>,
}

impl Sensed {
    fn new(arena: &Arena) -> Self {
        let (columns, rows) =
            ((arena.size_m.0 / CELL_M).round() as usize, (arena.size_m.1 / CELL_M).round() as usize);
        let center = |i: usize| (i as f64 + 0.5) * CELL_M;
        let point = |cell: usize| Point::new(center(cell % columns), center(cell / columns));
        let is_floor: Vec<_> = (0..columns * rows).map(|cell| arena.is_floor(point(cell))).collect();
        Self { columns, is_sensed: vec![false; is_floor.len()], is_floor }
    }

    fn mark(&mut self, scan: &PlacedScan) {
        let from = scan.world_from_laser().position;
        for (end, _) in scan.ends() {
            let offset = end - from;
            let steps = (offset.norm() / (0.5 * CELL_M)) as usize;
            for i in 0..steps {
                let point = from + offset * (i as f64 / steps as f64);
                let cell = (point.y / CELL_M) as usize * self.columns + (point.x / CELL_M) as usize;
                self.is_sensed[cell] = true;
            }
        }
    }

    fn fraction(&self) -> f64 {
        let floor = self.is_floor.iter().filter(|is_floor| **is_floor).count();
        let sensed = self.is_floor.iter().zip(&self.is_sensed).filter(|(floor, sensed)| **floor && **sensed);
        sensed.count() as f64 / floor as f64
    }
}

const RADIUS_M: f64 = 0.2;
const RANGE_M: f64 = 4.0;
const RAYS: usize = 161;
/// So far ahead proximity looks, in metres.
const NEAR_M: f64 = 0.1;
/// Less room than this there, in metres, is near.
const ALMOST_M: f64 = 0.01;
const SPEED_M_S: f64 = 0.4;
const TURN_RATE_RAD_S: f64 = 1.0;
const STEP_S: f64 = 0.05;
const STEPS_A_SCAN: usize = 4;
const CELL_M: f64 = 0.1;
/// A robot can get to where it has so much room, in metres.
const PASSABLE_M: f64 = 0.15;
