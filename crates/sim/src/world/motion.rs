//! The bodies' part of a tick: motors push, things are pushed, contacts are judged, the arena moves.

use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Crowd, Point, Pose, polygon};

use super::{Ending, World};
use crate::collision::{Collision, CollisionPolicy, Found, Met, Partner, Step, Thrust, Way, swept};
use crate::model::RobotSpec;
use crate::movable::{self, Body, Fixed, Form, Pusher};
use crate::mover::Around;
use crate::parallel;
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::time::{SECOND_NS, SimTime};

/// Lists that serve all substeps of all ticks, so that these need no new memory. But for the robots' rooms nothing in them
/// lasts.
#[derive(Debug, Default)]
pub(super) struct Lists {
    at_start: Vec<Pose>,
    ways: Vec<Way>,
    crowd: Crowd,
    held: Vec<Option<Met>>,
    /// The robots that were held before anything was pushed.
    held_first: Vec<Option<Met>>,
    found: Vec<Option<Found>>,
    obstacles: Vec<Body>,
    movables: Vec<Body>,
    /// The speeds of robots that feel contacts, as their motors would make them.
    driven_m_s: Vec<Option<f64>>,
}

impl World {
    /// The bodies move, in substeps; a command that arrived within the tick acts from the next substep on.
    pub(super) fn move_all(&mut self) {
        let scenario = Arc::clone(&self.scenario);
        let mut lists = self.spare.lists.take().unwrap_or_default();
        let (now, dt_ns) = (self.time(), scenario.step_ns / u64::from(scenario.substeps));
        self.state.collisions.clear();
        let scored = scenario.rules.floor.is_some() || !scenario.surroundings.zones.is_empty();
        if scored {
            self.note_poses(&mut lists.at_start);
        }
        let is_felt = self.state.robots.iter().any(|robot| robot.parts.impulses_n_s.is_some());
        for i in 0..u64::from(scenario.substeps) {
            if self.state.ending.is_none() {
                let dt = dt_ns as f64 / SECOND_NS as f64;
                self.substep(&scenario, &mut lists, now + i * dt_ns, dt, is_felt);
            }
        }
        if scored {
            self.keep_score(&lists.at_start);
        }
        self.spare.lists = Some(lists);
    }

    fn substep(&mut self, scenario: &Scenario, lists: &mut Lists, now: SimTime, dt: f64, is_felt: bool) {
        self.drive_all(scenario, lists, now, dt);
        if is_felt {
            lists.driven_m_s.clear();
            lists.driven_m_s.extend(self.state.robots.iter().map(Robot::felt_speed_m_s));
        }
        self.note_obstacles(scenario, &mut lists.obstacles);
        lists.held_first.clear();
        lists.movables.clear();
        gather(scenario, lists);
        if !scenario.movables.is_empty() {
            self.push(scenario, lists, dt);
            for (way, robot) in lists.ways.iter_mut().zip(&self.state.robots) {
                way.after = robot.motion.pose;
            }
            if scenario.collision.friction().is_some() {
                let movables = scenario.movables.iter().zip(&self.state.movables);
                lists.movables.extend(movables.map(|(movable, state)| movable.shape.form().at(&state.pose)));
                for ((way, robot), spec) in
                    lists.ways.iter_mut().zip(&self.state.robots).zip(&scenario.robots)
                {
                    way.thrust = Thrust::of_motion(&spec.drive, &robot.motion, dt);
                }
            }
            gather(scenario, lists);
        }
        match scenario.collision {
            CollisionPolicy::StopRun => self.stop_run(scenario, lists, dt),
            CollisionPolicy::StopRobot | CollisionPolicy::Slide { .. } => {
                self.stop_robots(scenario, lists, dt);
            }
        }
        if is_felt {
            self.feel(scenario, &lists.driven_m_s);
        }
        if !scenario.movers.is_empty() {
            self.move_movers(scenario, now, dt);
        }
    }

    /// Robots feel what has changed the speeds that their motors gave them.
    fn feel(&mut self, scenario: &Scenario, driven_m_s: &[Option<f64>]) {
        for ((robot, spec), driven) in self.state.robots.iter_mut().zip(&scenario.robots).zip(driven_m_s) {
            robot.feel(&spec.drive, *driven);
        }
    }

    /// Each robot drives as if it were alone; where it was and where it is then.
    fn drive_all(&mut self, scenario: &Scenario, lists: &mut Lists, now: SimTime, dt: f64) {
        let still = Pose::new(0.0, 0.0, 0.0);
        let unknown = Way::new(still, still);
        let slides = scenario.collision.friction().is_some();
        lists.ways.resize(self.state.robots.len(), unknown);
        parallel::each(self.is_parallel, &mut self.state.robots, &mut lists.ways, |own, robot, way| {
            let spec = &scenario.robots[own];
            let before = robot.motion;
            way.before = before.pose;
            robot.drive(spec, scenario, now, dt);
            if slides {
                let over_ground = scenario.surroundings.share_over_ground(&spec.drive, &before);
                way.thrust = Thrust::of_step(&spec.drive, &before, &robot.motion, over_ground, dt);
            }
            way.after = robot.motion.pose;
            way.room.look(&scenario.arena, &spec.form(), way.after.position);
        });
    }

    /// Robots push what can be pushed, those first held back that something else stops: a robot that cannot move does
    /// not push.
    fn push(&mut self, scenario: &Scenario, lists: &mut Lists, dt: f64) {
        if scenario.collision != CollisionPolicy::StopRun {
            let Lists { ways, crowd, held_first, found, obstacles, movables, .. } = lists;
            let is_parallel = self.is_parallel;
            step(scenario, (obstacles, movables), ways, crowd, |mut step| {
                step.hold_back(scenario.collision.friction(), held_first, found, is_parallel);
            });
            for own in (0..held_first.len()).filter(|&own| held_first[own].is_some()) {
                self.hinder(own, &ways[own], dt);
            }
        }
        let ways = &lists.ways;
        let fixed = Fixed { arena: &scenario.arena, bodies: &lists.obstacles };
        let robots = self.state.robots.iter().zip(&scenario.robots).zip(ways);
        let pushers: Vec<_> = robots.map(|((robot, spec), way)| pusher(robot, spec, &way.before)).collect();
        let reactions = movable::step(&scenario.movables, &mut self.state.movables, &fixed, &pushers, dt);
        for (i, reaction) in reactions.into_iter().enumerate().filter(|(_, r)| r.touched.is_some()) {
            let motion = &mut self.state.robots[i].motion;
            let missed =
                (motion.pose.position - reaction.pose.position).dot(&motion.pose.direction().vector());
            motion.travel_m.left -= missed;
            motion.travel_m.right -= missed;
            let made = (reaction.pose.position - ways[i].before.position)
                .dot(&motion.pose.direction().vector())
                / dt;
            motion.pose = reaction.pose;
            motion.speed_m_s = reaction.speed_m_s;
            // A robot that is kept from moving does not keep a speed that would not move it.
            if reaction.blocked && made.abs() < motion.speed_m_s.abs() {
                motion.speed_m_s = made;
            }
            motion.turn_rate_rad_s = reaction.turn_rate_rad_s;
            scenario.robots[i].drive.roll_with(motion);
        }
    }

    fn move_movers(&mut self, scenario: &Scenario, now: SimTime, dt: f64) {
        let robots = self.state.robots.iter().zip(&scenario.robots);
        let mut bodies: Vec<_> = robots.map(|(robot, spec)| spec.form().at(&robot.motion.pose)).collect();
        let movables = scenario.movables.iter().zip(&self.state.movables);
        bodies.extend(movables.map(|(movable, state)| movable.shape.form().at(&state.pose)));
        let around = Around { arena: &scenario.arena, bodies: &bodies };
        for (mover, state) in scenario.movers.iter().zip(&mut self.state.movers) {
            mover.step(state, &around, now, dt);
        }
    }

    /// Obstacles that move by themselves.
    fn note_obstacles(&self, scenario: &Scenario, obstacles: &mut Vec<Body>) {
        obstacles.clear();
        let movers = scenario.movers.iter().zip(&self.state.movers);
        obstacles.extend(movers.map(|(mover, state)| mover.form().at(&state.pose)));
    }

    fn stop_run(&mut self, scenario: &Scenario, lists: &mut Lists, dt: f64) {
        let Lists { ways, crowd, held, obstacles, movables, .. } = lists;
        step(scenario, (obstacles, movables), ways, crowd, |step| {
            held.clear();
            held.extend((0..step.ways.len()).map(|own| step.partner(own)));
        });
        for own in 0..lists.held.len() {
            self.note_contact(own, lists.held[own], lists);
            self.note_way(scenario, own, dt);
        }
        self.state.ending = self.state.collisions.first().cloned().map(Ending::Collision);
    }

    fn stop_robots(&mut self, scenario: &Scenario, lists: &mut Lists, dt: f64) {
        let Lists { ways, crowd, held, found, obstacles, movables, .. } = lists;
        let is_parallel = self.is_parallel;
        step(scenario, (obstacles, movables), ways, crowd, |mut step| {
            step.hold_back(scenario.collision.friction(), held, found, is_parallel);
        });
        for own in 0..lists.held.len() {
            let met = lists.held[own];
            if met.is_some() {
                self.hinder(own, &lists.ways[own], dt);
            }
            let earlier = || lists.held_first.get(own).copied().flatten();
            let met = met.or_else(earlier);
            if scenario.collision.friction().is_some() && met.is_some() {
                self.note_standing(own, &lists.ways[own].before, dt);
            }
            self.note_contact(own, met, lists);
            self.note_way(scenario, own, dt);
        }
    }

    /// Notes the way of a robot.
    fn note_way(&mut self, scenario: &Scenario, own: usize, dt: f64) {
        let robot = &mut self.state.robots[own];
        let speed = scenario.surroundings.over_ground(&scenario.robots[own].drive, &robot.motion).forward;
        robot.counters.distance_m += (speed * dt).abs();
    }

    /// Notes the time for which a robot is kept from moving.
    fn note_standing(&mut self, own: usize, before: &Pose, dt: f64) {
        let robot = &mut self.state.robots[own];
        if robot.motion.pose.position == before.position {
            *robot.parts.standing_ns.get_or_insert_default() += (dt * SECOND_NS as f64 + 0.5) as u64;
        }
    }

    /// A robot that something is in the way of slides along it, or stays where it was.
    fn hinder(&mut self, own: usize, way: &Way, dt: f64) {
        let Some(slid) = way.slid else { return self.hold(own, &way.before) };
        let (motion, spec) = (&mut self.state.robots[own].motion, &self.scenario.robots[own]);
        if slid.after.heading == way.before.heading && !spec.outline.is_empty() {
            motion.turn_rate_rad_s = 0.0;
        }
        motion.pose = slid.after;
        // The wheels have rolled as the motors turn them.
        let more_m = (way.thrust.wheels_m_s() - motion.speed_m_s) * dt;
        motion.travel_m.left += more_m;
        motion.travel_m.right += more_m;
        spec.drive.slip_with(motion, slid.speed_m_s, slid.wheels_m_s);
    }

    /// Puts a robot back to where it was. A disc keeps its turning, as it cannot run into anything by it.
    fn hold(&mut self, own: usize, before: &Pose) {
        let (motion, spec) = (&mut self.state.robots[own].motion, &self.scenario.robots[own]);
        motion.pose.position = before.position;
        if !spec.outline.is_empty() {
            motion.pose.heading = before.heading;
            motion.turn_rate_rad_s = 0.0;
        }
        spec.drive.halt(motion);
    }

    /// A contact that lasts is one collision. A robot that was stopped creeps up again without touching at
    /// once, so its contacts last until there is some room around it.
    #[inline]
    fn note_contact(&mut self, own: usize, met: Option<Met>, lists: &Lists) {
        match met {
            Some(met) => self.note_collision(own, met),
            None if self.state.robots[own].contacts.is_empty() => {}
            None => {
                if !self.is_hemmed_in(own, lists) {
                    self.state.robots[own].contacts.clear();
                }
            }
        }
    }

    fn note_collision(&mut self, own: usize, met: Met) {
        let (scenario, robots) = (&self.scenario, &self.scenario.robots);
        let with = match met {
            Met::Arena(thing) => scenario.arena.name_of(thing),
            Met::Obstacle(i) => &scenario.movers[i].name,
            Met::Robot(i) => &robots[i].name,
        };
        let robot = &mut self.state.robots[own];
        robot.collided = true;
        let is_known = |partner: &Partner| match (partner, met) {
            (Partner::Robot(i), Met::Robot(j)) => *i == j,
            (Partner::Shape(name), Met::Arena(_) | Met::Obstacle(_)) => name == with,
            _ => false,
        };
        if robot.contacts.iter().any(is_known) {
            return;
        }
        robot.counters.collisions += 1;
        robot.contacts.push(match met {
            Met::Robot(i) => Partner::Robot(i),
            Met::Arena(_) | Met::Obstacle(_) => Partner::Shape(with.to_string()),
        });
        self.state.collisions.push(Collision { robot: robots[own].name.clone(), with: with.to_string() });
    }

    fn is_hemmed_in(&self, own: usize, lists: &Lists) -> bool {
        let robots = &self.scenario.robots;
        let pose = &self.state.robots[own].motion.pose;
        let outline = &robots[own].outline;
        // From its middle, as the axle may be at its very back.
        let middle = polygon::centroid(outline).unwrap_or_default();
        let grown: Vec<Point> =
            outline.iter().map(|corner| middle + (corner - middle) * CONTACT_ENDS_AT).collect();
        let form = match robots[own].form() {
            Form::Disc { radius_m } => Form::Disc { radius_m: radius_m * CONTACT_ENDS_AT },
            Form::Polygon(_) => Form::Polygon(&grown),
        };
        let room: Body = form.at(pose);
        if room.overlaps_arena(&self.scenario.arena)
            || lists.obstacles.iter().any(|obstacle| obstacle.overlaps(&room))
        {
            return true;
        }
        let mut is_met = false;
        lists.crowd.near(&Circle { center: pose.position, radius: form.reach_m() }, |i| {
            let body = || robots[i].form().at(&self.state.robots[i].motion.pose);
            is_met = is_met || (i != own && body().overlaps(&room));
        });
        is_met
    }

    fn note_poses(&self, poses: &mut Vec<Pose>) {
        poses.clear();
        poses.extend(self.state.robots.iter().map(|robot| robot.motion.pose));
    }
}

/// Lists the neighbours on the way.
#[inline(always)]
fn gather(scenario: &Scenario, lists: &mut Lists) {
    if lists.ways.len() < 2 {
        return;
    }
    let ways = lists.ways.iter().zip(&scenario.robots);
    lists.crowd.rebuild(ways.map(|(way, spec)| swept(&spec.form(), way)));
}

/// Calls `look` with a step of all robots, and returns its result.
fn step<T>(
    scenario: &Scenario,
    (obstacles, movables): (&[Body], &[Body]),
    ways: &mut [Way],
    crowd: &Crowd,
    look: impl FnOnce(Step<'_>) -> T,
) -> T {
    let form = |i: usize| scenario.robots[i].form();
    look(Step { arena: &scenario.arena, obstacles, movables, form: &form, ways, crowd })
}

fn pusher<'a>(robot: &Robot, spec: &'a RobotSpec, before: &Pose) -> Pusher<'a> {
    Pusher {
        form: spec.form(),
        before: *before,
        after: robot.motion.pose,
        mass_kg: spec.drive.mass_kg,
        inertia_kg_m2: spec.drive.inertia_kg_m2,
        heading: robot.motion.pose.direction(),
        speed_m_s: robot.motion.speed_m_s,
        turn_rate_rad_s: robot.motion.turn_rate_rad_s,
    }
}

/// A contact ends when a body of so many times the size is free; a robot stops up to a step short of what it runs
/// into, so the factor must leave room for that.
const CONTACT_ENDS_AT: f64 = 1.1;
