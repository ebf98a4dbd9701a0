//! A known map, and a virtual laser in it: the vLRF of Wahde 2016, §6.3.1.
//!
//! A map is lines, as in the notes, and discs, for pillars. How far a virtual ray sees is Eqs. (3.3) to (3.8), which
//! `baudbot-geometry` computes for all rays of a scan at once. A virtual ray sees the map alone: only the real laser
//! sees everything else that stands in the world.

use baudbot_geometry::{Circle, Fan, Hit, Index, Point, Pose, Ray, Segment, Shape, Sweep, Vector};
use thiserror::Error;

use crate::scan::Scan;

/// Walls and pillars.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    index: Index,
}

/// A reason why shapes are no map.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MapError {
    /// The line of this place in its list.
    #[error("line {0} of the map: must be within {MOST_M} m of the origin")]
    Line(usize),
    /// The disc of this place in its list.
    #[error(
        "disc {0} of the map: must be within {MOST_M} m of the origin, its radius too, which is not negative"
    )]
    Disc(usize),
}

impl Map {
    /// The map of these shapes, in metres in the world.
    ///
    /// # Errors
    /// If a number of a shape is not finite, or enormous, or a radius is negative.
    pub fn new(lines: Vec<Segment>, discs: Vec<Circle>) -> Result<Self, MapError> {
        let is_near = |point: &Point| point.iter().all(|coordinate| coordinate.abs() <= MOST_M);
        let is_line = |line: &Segment| is_near(&line.start) && is_near(&line.end);
        let is_disc = |disc: &Circle| is_near(&disc.center) && (0.0..=MOST_M).contains(&disc.radius);
        if let Some(i) = lines.iter().position(|line| !is_line(line)) {
            return Err(MapError::Line(i));
        }
        if let Some(i) = discs.iter().position(|disc| !is_disc(disc)) {
            return Err(MapError::Disc(i));
        }
        Ok(Self { index: Index::new(lines, discs) })
    }

    /// The shapes, arranged for queries.
    #[must_use]
    pub fn index(&self) -> &Index {
        &self.index
    }
}

/// A laser that is put anywhere in a map, with the rays and the range of a real one.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualLaser {
    robot_from_laser: Pose,
    fan: Fan,
    range_m: f64,
}

/// The hit of a virtual ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// The distance to it, in metres.
    pub distance_m: f64,
    /// The unit vector at right angles to the surface there, in the world. It may point either way.
    pub normal: Vector,
    /// The unit vector along the ray, in the world.
    pub along: Vector,
}

impl VirtualLaser {
    /// Like the laser that took this scan.
    ///
    /// # Panics
    /// If the scan has no rays.
    #[must_use]
    pub fn like(scan: &Scan) -> Self {
        let fan = Fan::new(scan.opening_rad, scan.distances_m.len());
        Self { robot_from_laser: scan.robot_from_laser, fan, range_m: scan.range_m }
    }

    /// The number of rays.
    #[must_use]
    pub fn rays(&self) -> usize {
        self.fan.len()
    }

    /// The pose of the laser if the robot has this pose.
    #[must_use]
    pub fn world_from_laser(&self, world_from_robot: &Pose) -> Pose {
        world_from_robot.compose(&self.robot_from_laser)
    }

    /// A virtual scan from a pose of the robot: for each ray the distance of what it meets first, in metres, infinite
    /// if nothing is within range.
    ///
    /// # Panics
    /// If there are not as many distances as rays.
    pub fn look(&self, map: &Map, world_from_robot: &Pose, distances_m: &mut [f64]) {
        let world_from_laser = self.world_from_laser(world_from_robot);
        let mut sweep =
            Sweep::new(&world_from_laser, &self.fan, 0..self.fan.len(), self.range_m, distances_m);
        map.index.sweep(&mut sweep);
        sweep.finish();
    }

    /// The same as a scan of its own.
    #[must_use]
    pub fn scan(&self, map: &Map, world_from_robot: &Pose) -> Scan {
        let kappas = self.fan.kappas();
        let mut scan = Scan {
            robot_from_laser: self.robot_from_laser,
            opening_rad: kappas[kappas.len() - 1] - kappas[0],
            range_m: self.range_m,
            distances_m: vec![0.0; self.rays()],
        };
        self.look(map, world_from_robot, &mut scan.distances_m);
        scan
    }

    /// A virtual scan with the angle at which each ray meets its surface; `None` where nothing is within range.
    pub fn echoes<'a>(
        &'a self,
        map: &'a Map,
        world_from_robot: &Pose,
    ) -> impl ExactSizeIterator<Item = Option<Echo>> + 'a {
        let world_from_laser = self.world_from_laser(world_from_robot);
        let rays = self.fan.rays(world_from_laser.position, world_from_laser.direction());
        rays.map(|ray| map.index.cast(&ray, self.range_m).map(|hit| echo(&map.index, &ray, &hit)))
    }
}

fn echo(index: &Index, ray: &Ray, hit: &Hit) -> Echo {
    let normal = match hit.shape {
        Shape::Segment(i) => {
            let along = index.segments()[i].end - index.segments()[i].start;
            Vector::new(-along.y, along.x)
        }
        Shape::Circle(i) => ray.at(hit.distance) - index.circles()[i].center,
    };
    let along = ray.direction.vector();
    // A wall that is only a point is met head on.
    let normal = normal.try_normalize(0.0).unwrap_or(along);
    Echo { distance_m: hit.distance, normal, along }
}

/// No map reaches farther from its origin, in metres.
const MOST_M: f64 = 1e6;

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::localization::test_arena::rectangle;

    fn room() -> Map {
        let pillar = Circle { center: Point::new(3.0, 1.0), radius: 0.5 };
        Map::new(rectangle([0.0, 0.0, 4.0, 3.0]), vec![pillar]).unwrap()
    }

    fn laser(robot_from_laser: Pose, range_m: f64) -> VirtualLaser {
        let distances_m = vec![0.0; 5];
        VirtualLaser::like(&Scan { robot_from_laser, opening_rad: PI, range_m, distances_m })
    }

    #[test]
    fn a_virtual_scan_sees_walls_pillars_and_nothing() {
        let scan = laser(Pose::new(0.0, 0.0, 0.0), 1.75).scan(&room(), &Pose::new(1.0, 1.0, 0.0));
        let expected = [1.0, 2.0_f64.sqrt(), 1.5, f64::INFINITY, f64::INFINITY];
        for (found, expected) in scan.distances_m.iter().zip(expected) {
            assert!(*found == expected || (found - expected).abs() < 1e-12, "{:?}", scan.distances_m);
        }
        assert_eq!((scan.opening_rad, scan.range_m), (PI, 1.75));
    }

    #[test]
    fn the_laser_looks_from_where_it_sits() {
        // On the robot's left side, looking to the left; the robot looks up.
        let scan = laser(Pose::new(0.0, 0.2, FRAC_PI_2), 9.0).scan(&room(), &Pose::new(1.0, 1.0, FRAC_PI_2));
        assert!((scan.distances_m[2] - 0.8).abs() < 1e-12, "{:?}", scan.distances_m);
        assert!((scan.distances_m[0] - 2.0).abs() < 1e-12, "{:?}", scan.distances_m);
    }

    #[test]
    fn echoes_are_the_scan_with_the_surfaces() {
        let (room, laser, pose) = (room(), laser(Pose::new(0.1, 0.0, 0.3), 2.5), Pose::new(1.0, 1.2, -0.4));
        let scan = laser.scan(&room, &pose);
        let echoes: Vec<_> = laser.echoes(&room, &pose).collect();
        assert!(echoes.iter().flatten().count() >= 3);
        for (echo, distance) in echoes.iter().zip(&scan.distances_m) {
            assert_eq!(echo.map_or(f64::INFINITY, |echo| echo.distance_m), *distance);
            let is_unit = |v: &Vector| (v.norm() - 1.0).abs() < 1e-12;
            assert!(echo.is_none_or(|echo| is_unit(&echo.normal) && is_unit(&echo.along)));
        }
    }

    #[test]
    fn nonsense_is_no_map() {
        let endless = Segment { start: Point::origin(), end: Point::new(f64::NAN, 0.0) };
        let found = Map::new(vec![rectangle([0.0, 0.0, 1.0, 1.0])[0], endless], vec![]);
        assert_eq!(found, Err(MapError::Line(1)));
        let hole = Circle { center: Point::origin(), radius: -1.0 };
        assert_eq!(Map::new(vec![], vec![hole]), Err(MapError::Disc(0)));
        assert!(Map::new(vec![], vec![]).is_ok());
    }
}
