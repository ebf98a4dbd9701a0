//! The properties of every scene.

use alloc::format;
use alloc::string::String;

use baudbot_geometry::{angle, polygon};
use proptest::prelude::*;

use super::*;
use crate::arena::{Look, Pillar};

/// Numbers from a seed.
struct Dice(u64);

impl Dice {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        low + (high - low) * ((mixed >> 11) as f64 / (1_u64 << 53) as f64)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.within(0.0, n as f64) as usize).min(n - 1)
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.within(0.0, 1.0))
    }
}

struct Robot {
    polygon: Option<Vec<Point>>,
    radius: f64,
    pose: Pose,
    speed: f64,
    turn_rate: f64,
    wanted: (f64, f64),
    mass: f64,
}

impl Robot {
    fn form(&self) -> Form<'_> {
        self.polygon.as_ref().map_or(Form::Disc { radius_m: self.radius }, |points| Form::Polygon(points))
    }
}

struct Scene {
    room: Vec<Point>,
    arena: Arena,
    doors: Vec<Body>,
    movables: Vec<Movable>,
    states: Vec<MovableState>,
    robots: Vec<Robot>,
}

fn room(dice: &mut Dice) -> Vec<Point> {
    let (w, h) = (dice.within(1.5, 4.0), dice.within(1.5, 4.0));
    let corners = match dice.below(3) {
        0 => alloc::vec![(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)],
        1 => alloc::vec![(0.0, 0.0), (w, 0.0), (w, 0.6 * h), (0.5 * w, 0.5 * h), (0.5 * w, h), (0.0, h)],
        _ => alloc::vec![(0.3, 0.0), (w - 0.1, 0.2), (w, h - 0.4), (0.5 * w, h), (0.0, 0.6 * h)],
    };
    corners.into_iter().map(|(x, y)| Point::new(x, y)).collect()
}

fn convex(dice: &mut Dice, size: f64) -> Vec<Point> {
    if dice.below(2) == 0 {
        return rectangle(size * dice.within(0.3, 2.0), size);
    }
    let n = 3 + dice.below(4);
    let corner = |i: usize| {
        let direction =
            Direction::from_angle(core::f64::consts::TAU * (i as f64 + dice.within(0.0, 0.6)) / n as f64);
        Point::from(direction.vector() * size)
    };
    let points: Vec<_> = (0..n).map(corner).collect();
    let centroid = polygon::centroid(&points).unwrap();
    points.iter().map(|point| Point::from(point - centroid)).collect()
}

fn arena(dice: &mut Dice, room: &[Point]) -> Arena {
    let mut polygons = alloc::vec![Polygon {
        name: "room".to_string(),
        points: room.to_vec(),
        solid: false,
        closed: true,
        look: Look::WALL
    }];
    for i in 0..dice.below(3) {
        let pose = Pose::new(dice.within(0.2, 3.5), dice.within(0.2, 3.5), dice.within(-3.0, 3.0));
        let points = rectangle(dice.within(0.2, 1.5), dice.within(0.003, 0.1));
        let Body::Polygon(points) = Form::Polygon(&points).at(&pose) else { unreachable!() };
        polygons.push(Polygon {
            name: format!("wall {i}"),
            points,
            solid: true,
            closed: true,
            look: Look::WALL,
        });
    }
    let pillars = (0..dice.below(3)).map(|i| {
        let circle = disc(dice.within(0.0, 4.0), dice.within(0.0, 4.0), dice.within(0.02, 0.2));
        Pillar { name: format!("pillar {i}"), circle, look: Look::WALL }
    });
    let pillars = pillars.collect();
    Arena::new(polygons, pillars)
}

fn movable(dice: &mut Dice) -> (Movable, MovableState) {
    let start = Pose::new(0.0, 0.0, 0.0);
    let mass_kg = dice.log(0.05, 20.0);
    let restitution = [0.0, 1.0, dice.within(0.0, 1.0)][dice.below(3)];
    let is_ball = dice.below(2) == 0;
    let (shape, friction) = if is_ball {
        (MovableShape::Ball { radius_m: dice.log(0.02, 0.3) }, [0.0, 0.02][dice.below(2)])
    } else {
        let size = dice.log(0.03, 0.35);
        (MovableShape::Box { outline: convex(dice, size) }, [0.0, dice.within(0.0, 1.0)][dice.below(2)])
    };
    let mut state = state(0.0, 0.0, 0.0, 0.0);
    if dice.below(2) == 0 {
        let speed = dice.log(0.1, 8.0);
        state.velocity_m_s = Direction::from_angle(dice.within(-3.0, 3.0)).vector() * speed;
        state.spin_rad_s = if is_ball { 0.0 } else { dice.within(-5.0, 5.0) };
    }
    (Movable { name: String::new(), shape, mass_kg, friction, restitution, look: Look::WALL, start }, state)
}

fn robot(dice: &mut Dice) -> Robot {
    let radius = dice.within(0.06, 0.25);
    let polygon = (dice.below(3) == 0).then(|| {
        let mut points = convex(dice, radius);
        if dice.below(2) == 0 {
            // A dent: a simple polygon.
            points.insert(1, Point::from((points[0].coords + points[1].coords) * 0.25));
        }
        points
    });
    let wanted = (dice.within(-1.5, 1.5), dice.within(-3.0, 3.0));
    let mass = dice.log(0.5, 20.0);
    Robot { polygon, radius, pose: Pose::new(0.0, 0.0, 0.0), speed: 0.0, turn_rate: 0.0, wanted, mass }
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut dice = Dice(seed);
        let room = room(&mut dice);
        let arena = arena(&mut dice, &room);
        let mut scene = Self {
            room,
            arena,
            doors: Vec::new(),
            movables: Vec::new(),
            states: Vec::new(),
            robots: Vec::new(),
        };
        if dice.below(3) == 0 {
            let points = rectangle(0.5, 0.03);
            let pose = Pose::new(dice.within(0.0, 3.0), dice.within(0.0, 3.0), dice.within(-3.0, 3.0));
            scene.doors.push(Form::Polygon(&points).at(&pose));
        }
        for _ in 0..=dice.below(4) {
            let mut robot = robot(&mut dice);
            if let Some(pose) = scene.place(&mut dice, |form| robot.form().at(form)) {
                robot.pose = pose;
                scene.robots.push(robot);
            }
        }
        for _ in 0..=dice.below(6) {
            let (movable, mut state) = movable(&mut dice);
            if let Some(pose) = scene.place(&mut dice, |pose| movable.shape.form().at(pose)) {
                state.pose = pose;
                scene.movables.push(movable);
                scene.states.push(state);
            }
        }
        scene
    }

    fn place(&self, dice: &mut Dice, body: impl Fn(&Pose) -> Body) -> Option<Pose> {
        let mut poses =
            (0..30).map(|_| Pose::new(dice.within(0.0, 4.0), dice.within(0.0, 4.0), dice.within(-3.1, 3.1)));
        poses.find(|pose| {
            let body = body(pose);
            let others = self.bodies().chain(self.robot_bodies()).chain(self.doors.iter().cloned());
            polygon::contains(&self.room, pose.position)
                && !body.overlaps_arena(&self.arena)
                && !others.into_iter().any(|other| body.overlaps(&other))
        })
    }

    fn bodies(&self) -> impl Iterator<Item = Body> {
        self.movables.iter().zip(&self.states).map(|(movable, state)| movable.shape.form().at(&state.pose))
    }

    fn robot_bodies(&self) -> impl Iterator<Item = Body> {
        self.robots.iter().map(|robot| robot.form().at(&robot.pose))
    }

    /// A world's step in short: free motion, robots held back, the step, robots held back again.
    fn substep(&mut self, dt: f64) -> Result<(), TestCaseError> {
        let before: Vec<_> = self.robots.iter().map(|robot| robot.pose).collect();
        for robot in &mut self.robots {
            robot.speed += (robot.wanted.0 - robot.speed).clamp(-3.0 * dt, 3.0 * dt);
            robot.turn_rate += (robot.wanted.1 - robot.turn_rate).clamp(-9.0 * dt, 9.0 * dt);
            robot.pose.heading = angle::wrap(robot.pose.heading + robot.turn_rate * dt);
            robot.pose.position += robot.pose.direction().vector() * (robot.speed * dt);
        }
        self.hold_back(&before);
        let robots = core::mem::take(&mut self.robots);
        let pushers: Vec<_> =
            robots.iter().zip(&before).map(|(robot, before)| pusher_of(robot, before)).collect();
        let fixed = Fixed { arena: &self.arena, bodies: &self.doors };
        let energy = energy(&self.movables, &self.states)
            + pushers.iter().map(|p| robot_energy(p, p.speed_m_s, p.turn_rate_rad_s)).sum::<f64>();
        let found = step(&self.movables, &mut self.states, &fixed, &pushers, dt);
        let reacted = pushers.iter().zip(&found);
        let rest = self::energy(&self.movables, &self.states)
            + reacted.map(|(p, r)| robot_energy(p, r.speed_m_s, r.turn_rate_rad_s)).sum::<f64>();
        prop_assert!(rest <= energy * (1.0 + 1e-9), "{energy} J became {rest} J");
        self.robots = robots;
        for (robot, reaction) in self.robots.iter_mut().zip(&found) {
            robot.pose = reaction.pose;
            robot.speed = reaction.speed_m_s;
            robot.turn_rate = reaction.turn_rate_rad_s;
        }
        self.hold_back(&before);
        self.check()
    }

    /// Robots turn to the nearest thing, so that much is pushed.
    fn chase(&mut self) {
        for robot in &mut self.robots {
            let places = self.states.iter().map(|state| state.pose.position - robot.pose.position);
            let nearest = places.min_by(|a, b| a.norm().total_cmp(&b.norm()));
            if let Some(way) = nearest {
                let aim = Direction { cos: way.x, sin: way.y }.angle();
                let back = if robot.wanted.0 < 0.0 { core::f64::consts::PI } else { 0.0 };
                robot.wanted.1 = 5.0 * angle::difference(aim + back, robot.pose.heading);
            }
        }
    }

    fn hold_back(&mut self, before: &[Pose]) {
        loop {
            let bodies: Vec<_> = self.robot_bodies().collect();
            let stuck = |&i: &usize| {
                let others = bodies.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, body)| body);
                self.robots[i].pose != before[i]
                    && (bodies[i].overlaps_arena(&self.arena)
                        || others.chain(&self.doors).any(|other| bodies[i].overlaps(other)))
            };
            let found: Vec<_> = (0..bodies.len()).filter(stuck).collect();
            if found.is_empty() {
                return;
            }
            for i in found {
                self.robots[i].pose = before[i];
                (self.robots[i].speed, self.robots[i].turn_rate) = (0.0, 0.0);
            }
        }
    }

    fn check(&self) -> Result<(), TestCaseError> {
        let bodies: Vec<_> = self.bodies().collect();
        for (i, body) in bodies.iter().enumerate() {
            prop_assert!(!body.overlaps_arena(&self.arena), "{i} in the arena");
            prop_assert!(!self.doors.iter().any(|other| body.overlaps(other)), "{i} in a door");
            prop_assert!(!self.robot_bodies().any(|other| body.overlaps(&other)), "{i} in a robot");
            prop_assert!(!bodies[i + 1..].iter().any(|other| body.overlaps(other)), "{i} in another");
            let state = &self.states[i];
            prop_assert!(polygon::contains(&self.room, state.pose.position), "{i} left the room");
            prop_assert!(state.velocity_m_s.norm().is_finite() && state.spin_rad_s.is_finite());
        }
        Ok(())
    }
}

fn pusher_of<'a>(robot: &'a Robot, before: &Pose) -> Pusher<'a> {
    Pusher {
        form: robot.form(),
        before: *before,
        after: robot.pose,
        mass_kg: robot.mass,
        inertia_kg_m2: 0.5 * robot.mass * robot.radius * robot.radius,
        heading: robot.pose.direction(),
        speed_m_s: robot.speed,
        turn_rate_rad_s: robot.turn_rate,
    }
}

fn robot_energy(pusher: &Pusher<'_>, speed: f64, turn_rate: f64) -> f64 {
    0.5 * pusher.mass_kg * speed * speed + 0.5 * pusher.inertia_kg_m2 * turn_rate * turn_rate
}

fn energy(movables: &[Movable], states: &[MovableState]) -> f64 {
    let one = |(movable, state): (&Movable, &MovableState)| {
        let gyration = match &movable.shape {
            MovableShape::Ball { .. } => 0.0,
            MovableShape::Box { outline } => polygon::second_moment(outline),
        };
        let squares = state.velocity_m_s.norm_squared() + gyration * state.spin_rad_s * state.spin_rad_s;
        0.5 * movable.mass_kg * squares
    };
    movables.iter().zip(states).map(one).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn nothing_overlaps_nothing_gains_energy_and_nothing_leaves(seed in any::<u64>(), dt in prop_oneof![-4.0..-2.0_f64, -2.0..-1.3_f64]) {
        let mut scene = Scene::new(seed);
        let (dt, mut dice) = (10.0_f64.powf(dt).min(0.05), Dice(!seed));
        for _ in 0..200 {
            if dice.below(40) == 0 {
                for robot in &mut scene.robots {
                    robot.wanted = (dice.within(-1.5, 1.5), dice.within(-3.0, 3.0));
                }
            }
            if seed % 4 != 0 {
                scene.chase();
            }
            scene.substep(dt)?;
        }
    }
}
