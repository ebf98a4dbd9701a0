//! The paths of the robots, for a picture.

use std::io::{self, Write};
use std::mem;
use std::sync::Arc;

use baudbot_geometry::{Point, Pose};
use baudbot_plot::arena::{self, Collision, Trail, Trails};
use baudbot_plot::quantity::duration;
use baudbot_recording::RecordedRun;
use baudbot_sim::{RobotView, Scenario, SimTime, World};

use super::Out;
use super::pass::Sink;
use super::ran::Ran;

/// A picture that is drawn at the end.
pub(super) struct Picture {
    out: Out,
    scenario: Arc<Scenario>,
    label: String,
    ran: Ran,
    /// The instants at which it begins and ends.
    span: Option<(SimTime, SimTime)>,
    /// The last tick that was seen.
    tick: u64,
    /// Ticks within the span that the recording lost.
    missing: u64,
    builders: Vec<TrailBuilder>,
    /// The number of points of each robot that are kept.
    room: usize,
}

/// The path of a robot as far as it went.
struct TrailBuilder {
    trail: Trail,
    /// Nearer points than this are not kept, in metres.
    tolerance_m: f64,
    points: usize,
}

impl Picture {
    pub(super) fn new(out: Out, recorded: &Arc<RecordedRun>) -> Self {
        let robots = recorded.scenario().robots.len();
        Self {
            out,
            scenario: Arc::clone(recorded.scenario()),
            label: recorded.header().world.clone(),
            ran: Ran::of(recorded),
            span: None,
            tick: 0,
            missing: 0,
            builders: Vec::new(),
            room: (MOST_POINTS / robots.max(1)).clamp(LEAST_ROOM, MOST_ROOM),
        }
    }
}

impl Sink for Picture {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        let now = world.time();
        self.span = Some((self.span.map_or(now, |(from, _)| from), now));
        self.ran.see(world);
        let before = mem::replace(&mut self.tick, world.tick());
        if self.builders.is_empty() {
            self.builders = world.robots().map(|robot| TrailBuilder::new(&robot)).collect();
            return Ok(());
        }
        let missing = world.tick() - before - 1;
        self.missing += missing;
        let changed = self.ran.is_changed(world.tick());
        let step_s = world.scenario().step_ns as f64 * 1e-9;
        for (builder, robot) in self.builders.iter_mut().zip(world.robots()) {
            if missing == 0 {
                builder.go_on(&robot, step_s, changed);
            } else {
                builder.leap(robot.motion().pose);
            }
            if builder.points > self.room {
                builder.thin();
            }
        }
        for collision in world.collisions() {
            let place = world.robots().position(|robot| robot.spec().name == collision.robot);
            if let Some(trail) = place.map(|place| &mut self.builders[place].trail) {
                trail.collisions += 1;
                if trail.places.len() < MOST_PLACES {
                    let with = collision.with.clone();
                    trail.places.push(Collision { at: trail.end.position, time: now, with });
                }
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        let (from, until) = self.span.unwrap_or_default();
        let robots = self.builders.into_iter().map(TrailBuilder::done).collect();
        let (about, mut facts) = (self.ran.about().to_owned(), self.ran.facts());
        if self.missing > 0 {
            let missing_ns = (self.missing * self.scenario.step_ns) as f64;
            facts += &format!(" · {} missing in the recording", duration(missing_ns));
        }
        let trails = Trails { robots, from, until, about, facts };
        let picture = arena::draw_trails(&self.scenario, &self.label, &trails);
        self.out.write_all(picture.as_bytes())?;
        self.out.flush()
    }
}

impl TrailBuilder {
    fn new(robot: &RobotView<'_>) -> Self {
        let pose = robot.motion().pose;
        Self {
            trail: Trail { pieces: vec![vec![pose.position]], ..Trail::at(pose) },
            // A fraction of a pixel, unless a robot is larger than a hand in the picture.
            tolerance_m: robot.spec().drive.radius_m / 50.0,
            points: 1,
        }
    }

    fn go_on(&mut self, robot: &RobotView<'_>, step_s: f64, changed: bool) {
        let motion = robot.motion();
        let (from, to) = (self.trail.end.position, motion.pose.position);
        let moved = (to - from).norm();
        // A robot cannot drive that far in a tick: it was moved by hand.
        let is_jump = changed && moved > 2.0 * motion.speed_m_s.abs() * step_s + self.tolerance_m;
        if is_jump {
            return self.leap(motion.pose);
        }
        self.trail.distance_m += moved;
        if self.last().is_none_or(|last| (to - last).norm() >= self.tolerance_m) {
            self.keep(to);
        }
        self.trail.end = motion.pose;
    }

    /// Goes on elsewhere; the way there is unknown.
    fn leap(&mut self, to: Pose) {
        self.keep(self.trail.end.position);
        self.trail.pieces.push(vec![to.position]);
        self.points += 1;
        self.trail.end = to;
    }

    fn last(&self) -> Option<Point> {
        self.trail.pieces.last().and_then(|piece| piece.last()).copied()
    }

    fn keep(&mut self, point: Point) {
        if let Some(piece) = self.trail.pieces.last_mut() {
            piece.push(point);
            self.points += 1;
        }
    }

    /// Keeps about half of the points.
    fn thin(&mut self) {
        self.tolerance_m *= 2.0;
        let pieces = &mut self.trail.pieces;
        let excess = pieces.len().saturating_sub(MOST_PIECES);
        pieces.drain(..excess);
        for piece in pieces.iter_mut() {
            let mut kept: Option<Point> = None;
            piece.retain(|&point| {
                let keeps = kept.is_none_or(|kept| (point - kept).norm() >= self.tolerance_m);
                if keeps {
                    kept = Some(point);
                }
                keeps
            });
        }
        self.points = pieces.iter().map(Vec::len).sum();
    }

    fn done(mut self) -> Trail {
        let Pose { position, .. } = self.trail.end;
        self.keep(position);
        self.trail
    }
}

/// Points of all robots together, so that a long run takes no more memory than a short one.
const MOST_POINTS: usize = 2_000_000;
/// Points of one robot at least and at most.
const LEAST_ROOM: usize = 1000;
const MOST_ROOM: usize = 50_000;
/// Pieces of a path that was often put somewhere else.
const MOST_PIECES: usize = 400;
/// Collisions of a robot that are marked.
const MOST_PLACES: usize = 200;

#[cfg(test)]
mod tests {
    use baudbot_sim::Intervention;

    use super::*;

    /// A robot that rolls, and its path.
    fn rolling() -> (World, TrailBuilder) {
        let body = "{ radius_m = 0.1, mass_kg = 500.0, inertia_kg_m2 = 10.0, wheel_radius_m = 0.1 }";
        let toml = format!("[[robots]]\nname = \"a\"\nstart.speed_m_s = 1.0\nbody = {body}\n");
        let mut world = World::new(baudbot_scenario::parse(&toml).unwrap().into());
        world.begin();
        let builder = TrailBuilder::new(&world.robots().next().unwrap());
        (world, builder)
    }

    fn go_on(world: &mut World, builder: &mut TrailBuilder, put: Option<f64>) {
        world.finish(&[]);
        if let Some(x_m) = put {
            let pose = Pose::new(x_m, 5.0, 0.0);
            world.intervene(&Intervention::PlaceRobot { robot: "a".to_owned(), pose }).unwrap();
        }
        world.begin();
        builder.go_on(&world.robots().next().unwrap(), world.scenario().step_ns as f64 * 1e-9, put.is_some());
    }

    #[test]
    fn who_is_put_somewhere_else_has_not_driven_there() {
        let (mut world, mut builder) = rolling();
        (0..100).for_each(|_| go_on(&mut world, &mut builder, None));
        let before = builder.trail.distance_m;
        assert!(before > 0.1, "{before} m");
        go_on(&mut world, &mut builder, Some(30.0));
        (0..10).for_each(|_| go_on(&mut world, &mut builder, None));
        let trail = builder.done();
        assert_eq!(trail.pieces.len(), 2);
        assert!(trail.distance_m < before + 0.5, "{} m", trail.distance_m);
        assert_eq!(trail.pieces[1][0], Point::new(30.0, 5.0));
        assert_eq!(trail.pieces[1].last(), Some(&trail.end.position));
    }

    #[test]
    fn a_way_that_is_thinned_keeps_its_shape() {
        let (mut world, mut builder) = rolling();
        (0..200).for_each(|_| go_on(&mut world, &mut builder, None));
        let (before, distance_m) = (builder.points, builder.trail.distance_m);
        (0..5).for_each(|_| builder.thin());
        assert!(builder.points * 5 < before && builder.points > 1, "{} of {before} points", builder.points);
        let trail = builder.done();
        let piece = &trail.pieces[0];
        let length: f64 = piece.windows(2).map(|two| (two[1] - two[0]).norm()).sum();
        assert!((0.9 * distance_m..=distance_m + 1e-9).contains(&length), "{length} m, {distance_m} m");
        assert_eq!((piece[0], piece.last()), (trail.start.position, Some(&trail.end.position)));
    }
}
