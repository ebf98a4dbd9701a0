//! The nearest that each robot of a run has come to anything, for observers.
//!
//! To measure the clearance of a robot takes a search, which most ticks do not need: it changes by no more than the robot and
//! whatever is nearest to it move. So it is measured again only when it may have become less than it ever was.

use alloc::vec::Vec;

use baudbot_geometry::{Pose, angle, math};

use crate::clearance::Nearest;
use crate::movable::Form;
use crate::time::SimTime;
use crate::world::World;

/// The least clearances of a run so far. It belongs to one world, which it is shown tick by tick.
#[derive(Clone, Debug)]
pub struct Nearness {
    robots: Vec<Near>,
    things: Vec<Course>,
}

/// The least clearance of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    /// Its distance from what was nearest, in metres; 0 from what it ran into.
    pub clearance_m: f64,
    /// The instant of it, the first of several.
    pub at: SimTime,
}

#[derive(Clone, Copy, Debug)]
struct Near {
    course: Course,
    least: Least,
    /// The way that may pass, in metres, before the clearance can be less than the least.
    room_m: f64,
    /// The shape that is nearest to a disc.
    nearest: Option<Nearest>,
}

/// The last pose of a body.
#[derive(Clone, Copy, Debug)]
struct Course {
    pose: Pose,
    /// The distance from the origin to the farthest point that a turn moves, in metres; 0 of a disc.
    lever_m: f64,
}

impl Nearness {
    /// The nearness of a world that has been seen now, for the first time.
    pub fn new(world: &World) -> Self {
        let at = world.time();
        let near = |robot: usize| {
            let view = world.robot(robot);
            let course = Course::new(&view.spec().form(), view.motion().pose);
            let least = Least { clearance_m: world.clearance_m(robot), at };
            Near { course, least, room_m: 0.0, nearest: None }
        };
        let (scenario, state) = (world.scenario(), world.state());
        let movers = scenario.movers.iter().zip(&state.movers);
        let movables = scenario.movables.iter().zip(&state.movables);
        let movers = movers.map(|(mover, state)| Course::new(&mover.form(), state.pose));
        let movables = movables.map(|(movable, state)| Course::new(&movable.shape.form(), state.pose));
        Self {
            robots: (0..world.robots().len()).map(near).collect(),
            things: movers.chain(movables).collect(),
        }
    }

    /// Sees the world as it is now.
    #[inline]
    pub fn see(&mut self, world: &World) {
        match self.robots.as_mut_slice() {
            [near] if self.things.is_empty() => near.see_alone(world),
            _ => self.see_all(world),
        }
    }

    fn see_all(&mut self, world: &World) {
        let state = world.state();
        let poses = state.movers.iter().map(|mover| mover.pose);
        let poses = poses.chain(state.movables.iter().map(|movable| movable.pose));
        let things = self.things.iter_mut().zip(poses).map(|(course, pose)| course.way_m(pose));
        // The longest way of others is that of a thing, or of the robot with the longest or, for that one, the second longest.
        let mut longest = [things.fold(0.0, f64::max); 2];
        let mut fastest = None;
        for (i, near) in self.robots.iter_mut().enumerate() {
            let way_m = near.course.way_m(world.robot(i).motion().pose);
            near.room_m -= way_m;
            if way_m > longest[0] {
                longest = [way_m, longest[0]];
                fastest = Some(i);
            } else {
                longest[1] = longest[1].max(way_m);
            }
        }
        for (i, near) in self.robots.iter_mut().enumerate() {
            near.room_m -= longest[usize::from(fastest == Some(i))];
            if near.room_m < 0.0 || world.robot(i).collided() {
                near.look(world, i);
            }
        }
    }

    /// The least clearance of each robot so far, in the order of their names.
    pub fn least(&self) -> impl ExactSizeIterator<Item = Least> {
        self.robots.iter().map(|near| near.least)
    }
}

impl Near {
    /// The same for a robot beside which nothing moves: what counts is how far it is from where it was when its clearance was measured.
    #[inline]
    fn see_alone(&mut self, world: &World) {
        let view = world.robot(0);
        let pose = view.motion().pose;
        if view.collided() || !self.course.is_within(pose, self.room_m) {
            self.course.pose = pose;
            self.look(world, 0);
        }
    }

    fn look(&mut self, world: &World, robot: usize) {
        let clearance_m = world.clearance_beside_m(robot, &mut self.nearest);
        if clearance_m < self.least.clearance_m {
            self.least = Least { clearance_m, at: world.time() };
        }
        self.room_m = clearance_m - self.least.clearance_m;
    }
}

impl Course {
    fn new(form: &Form<'_>, pose: Pose) -> Self {
        let lever_m = match form {
            Form::Disc { .. } => 0.0,
            Form::Polygon(_) => form.reach_m(),
        };
        Self { pose, lever_m }
    }

    /// Whether no point of the body is farther than this from where it was in its last pose.
    #[inline]
    fn is_within(&self, pose: Pose, room_m: f64) -> bool {
        let turned_m = match self.lever_m {
            0.0 => 0.0,
            lever_m => lever_m * angle::difference(pose.heading, self.pose.heading).abs(),
        };
        let room_m = room_m - turned_m;
        room_m >= 0.0 && (pose.position - self.pose.position).norm_squared() <= room_m * room_m
    }

    /// The longest way, in metres, of any point of the body from its last pose to this one.
    fn way_m(&mut self, pose: Pose) -> f64 {
        let last = core::mem::replace(&mut self.pose, pose);
        let way_m = math::sqrt((pose.position - last.position).norm_squared());
        if self.lever_m == 0.0 {
            way_m
        } else {
            way_m + self.lever_m * angle::difference(pose.heading, last.heading).abs()
        }
    }
}
