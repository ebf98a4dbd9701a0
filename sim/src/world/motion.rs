//! The bodies' part of a tick: motors push, things are pushed, contacts are judged, the arena moves.

use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_geometry::{Point, Pose, polygon};

use super::{Ending, World};
use crate::actuator::ActuatorKind;
use crate::collision::{Collision, CollisionPolicy, Obstacle, Partner, Step};
use crate::drive::Wheels;
use crate::motor::Motors;
use crate::movable::{self, Body, Fixed, Form, Pusher};
use crate::mover::Around;
use crate::robot::{Robot, RobotSpec};
use crate::scenario::Scenario;
use crate::time::{SECOND_NS, SimTime};

impl World {
    /// The bodies move, in substeps; a command that arrived within the tick acts from the next substep on.
    pub(super) fn move_all(&mut self) {
        let scenario = Arc::clone(&self.scenario);
        let (now, dt_ns) = (self.time(), scenario.step_ns / u64::from(scenario.substeps));
        self.state.collisions.clear();
        for (robot, spec) in self.state.robots.iter_mut().zip(scenario.robots()) {
            robot.collided = false;
            robot.pings = [None, robot.pings[0].or(robot.pings[1])];
            if scenario.noise {
                robot.motor_noise.tick(&spec.drive.motor_noise);
            }
        }
        let forms: Vec<_> = scenario.robots().iter().map(RobotSpec::form).collect();
        let (mut at_start, mut poses) = (Vec::new(), Poses::default());
        let scored = scenario.rules.floor.is_some() || !scenario.surroundings.zones.is_empty();
        if scored {
            self.note_poses(&mut at_start);
        }
        for i in 0..u64::from(scenario.substeps) {
            if self.state.ending.is_none() {
                let dt = dt_ns as f64 / SECOND_NS as f64;
                self.substep(&scenario, &forms, &mut poses, now + i * dt_ns, dt);
            }
        }
        if scored {
            self.keep_score(&at_start);
        }
    }

    fn substep(
        &mut self,
        scenario: &Scenario,
        forms: &[Form<'_>],
        Poses { before, after }: &mut Poses,
        now: SimTime,
        dt: f64,
    ) {
        self.note_poses(before);
        for (robot, spec) in self.state.robots.iter_mut().zip(scenario.robots()) {
            robot.drive(spec, scenario, now, dt);
        }
        let (arena, obstacles) = (&scenario.arena, &self.obstacles(scenario)[..]);
        let mut held = Vec::new();
        if !scenario.movables.is_empty() {
            self.note_poses(after);
            held = self.push(scenario, Step { arena, obstacles, forms, before, after }, dt);
        }
        self.note_poses(after);
        let step = Step { arena, obstacles, forms, before, after };
        match scenario.collision {
            CollisionPolicy::StopRun => self.stop_run(&step),
            CollisionPolicy::StopRobot => self.stop_robots(step, &held),
        }
        for (robot, spec) in self.state.robots.iter_mut().zip(scenario.robots()) {
            let (speed, _) = scenario.surroundings.over_ground(&spec.drive, &robot.motion);
            robot.counters.distance_m += (speed * dt).abs();
        }
        if !scenario.movers.is_empty() {
            self.move_movers(scenario, now, dt);
        }
    }

    /// Robots push what can be pushed, those first held back that something else stops: nobody pushes who cannot
    /// move. Says who those are.
    fn push(&mut self, scenario: &Scenario, step: Step<'_>, dt: f64) -> Vec<Option<Partner>> {
        let before = step.before;
        let bodies: Vec<_> = step.obstacles.iter().map(|obstacle| obstacle.body.clone()).collect();
        let fixed = Fixed { arena: &scenario.arena, bodies: &bodies };
        let mut held = Vec::new();
        if scenario.collision == CollisionPolicy::StopRobot {
            held = step.held_back();
            for own in (0..held.len()).filter(|&own| held[own].is_some()) {
                self.hold(own, &before[own]);
            }
        }
        let robots = self.state.robots.iter().zip(scenario.robots()).zip(before);
        let pushers: Vec<_> = robots.map(|((robot, spec), before)| pusher(robot, spec, before)).collect();
        let reactions = movable::step(&scenario.movables, &mut self.state.movables, &fixed, &pushers, dt);
        for (i, reaction) in reactions.into_iter().enumerate().filter(|(_, r)| r.touched.is_some()) {
            let motion = &mut self.state.robots[i].motion;
            let missed =
                (motion.pose.position - reaction.pose.position).dot(&motion.pose.direction().vector());
            motion.travel_m.left -= missed;
            motion.travel_m.right -= missed;
            let made =
                (reaction.pose.position - before[i].position).dot(&motion.pose.direction().vector()) / dt;
            motion.pose = reaction.pose;
            motion.speed_m_s = reaction.speed_m_s;
            // Who is kept from moving does not keep a speed that would not move it.
            if reaction.blocked && made.abs() < motion.speed_m_s.abs() {
                motion.speed_m_s = made;
            }
            motion.turn_rate_rad_s = reaction.turn_rate_rad_s;
            scenario.robots()[i].drive.roll_with(motion);
        }
        held
    }

    fn move_movers(&mut self, scenario: &Scenario, now: SimTime, dt: f64) {
        let robots = self.state.robots.iter().zip(scenario.robots());
        let mut bodies: Vec<_> = robots.map(|(robot, spec)| spec.form().at(&robot.motion.pose)).collect();
        let movables = scenario.movables.iter().zip(&self.state.movables);
        bodies.extend(movables.map(|(movable, state)| movable.shape.form().at(&state.pose)));
        let around = Around { arena: &scenario.arena, bodies: &bodies };
        for (mover, state) in scenario.movers.iter().zip(&mut self.state.movers) {
            mover.step(state, &around, now, dt);
        }
    }

    /// What moves by itself and can be run into.
    fn obstacles(&self, scenario: &Scenario) -> Vec<Obstacle> {
        let movers = scenario.movers.iter().zip(&self.state.movers);
        movers
            .map(|(mover, state)| Obstacle { name: mover.name.clone(), body: mover.form().at(&state.pose) })
            .collect()
    }

    fn stop_run(&mut self, step: &Step<'_>) {
        for own in 0..step.before.len() {
            self.note_contact(own, step.partner(own));
        }
        self.state.ending = self.state.collisions.first().cloned().map(Ending::Collision);
    }

    /// `held` are those that have been held back already, if anybody has looked.
    fn stop_robots(&mut self, step: Step<'_>, held: &[Option<Partner>]) {
        let before = step.before;
        for (own, partner) in step.held_back().into_iter().enumerate() {
            if partner.is_some() {
                self.hold(own, &before[own]);
            }
            let earlier = || held.get(own).cloned().flatten();
            self.note_contact(own, partner.or_else(earlier));
        }
    }

    /// Puts a robot back to where it was. A disc keeps its turning, as it cannot run into anything by it.
    fn hold(&mut self, own: usize, before: &Pose) {
        let (motion, spec) = (&mut self.state.robots[own].motion, &self.scenario.robots()[own]);
        motion.pose.position = before.position;
        if !spec.outline.is_empty() {
            motion.pose.heading = before.heading;
            motion.turn_rate_rad_s = 0.0;
        }
        spec.drive.halt(motion);
    }

    /// A contact that lasts is one collision. A robot that was stopped creeps up again without touching at
    /// once, so its contacts last until there is some room around it.
    fn note_contact(&mut self, own: usize, partner: Option<Partner>) {
        let Some(partner) = partner else {
            if !self.state.robots[own].contacts.is_empty() && !self.is_hemmed_in(own) {
                self.state.robots[own].contacts.clear();
            }
            return;
        };
        let robot = &mut self.state.robots[own];
        robot.collided = true;
        if robot.contacts.contains(&partner) {
            return;
        }
        robot.counters.collisions += 1;
        robot.contacts.push(partner.clone());
        let robots = self.scenario.robots();
        let with = match partner {
            Partner::Shape(name) => name,
            Partner::Robot(i) => robots[i].name.to_string(),
        };
        self.state.collisions.push(Collision { robot: robots[own].name.clone(), with });
    }

    fn is_hemmed_in(&self, own: usize) -> bool {
        let robots = self.scenario.robots();
        let pose = &self.state.robots[own].motion.pose;
        let outline = &robots[own].outline;
        // From its middle, as the axle may be at its very back.
        let middle = polygon::centroid(outline).unwrap_or_default();
        let grown: Vec<Point> =
            outline.iter().map(|corner| middle + (corner - middle) * CONTACT_ENDS_AT).collect();
        let room = match robots[own].form() {
            Form::Disc { radius_m } => Form::Disc { radius_m: radius_m * CONTACT_ENDS_AT },
            Form::Polygon(_) => Form::Polygon(&grown),
        };
        let room: Body = room.at(pose);
        let others = self.state.robots.iter().zip(robots).enumerate().filter(|(i, _)| *i != own);
        room.overlaps_arena(&self.scenario.arena)
            || self.obstacles(&self.scenario).iter().any(|obstacle| obstacle.body.overlaps(&room))
            || others.into_iter().any(|(_, (robot, spec))| spec.form().at(&robot.motion.pose).overlaps(&room))
    }

    fn note_poses(&self, poses: &mut Vec<Pose>) {
        poses.clear();
        poses.extend(self.state.robots.iter().map(|robot| robot.motion.pose));
    }
}

/// The poses of all robots, in lists that serve all substeps of a tick.
#[derive(Default)]
struct Poses {
    before: Vec<Pose>,
    after: Vec<Pose>,
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

impl Robot {
    /// A substep of the motors and the other actuators, as if the robot were alone.
    fn drive(&mut self, spec: &RobotSpec, scenario: &Scenario, now: SimTime, dt: f64) {
        self.take_up(spec, now);
        let powered = match (&spec.battery, &self.battery) {
            (Some(battery), Some(state)) => !state.is_empty(battery),
            _ => true,
        };
        let signals = if powered { self.motor_noise.apply(self.signals) } else { Wheels::default() };
        let signals = self.under_load(spec, signals);
        let slip = scenario.surroundings.slip_of(&spec.drive, &self.motion);
        self.motion = spec.drive.step(&self.motion, signals, slip, dt);
        for (actuator, state) in spec.actuators.iter().zip(&mut self.actuators) {
            if let ActuatorKind::Turret(servo) = &actuator.kind {
                // A pulse begins in the first substep of each frame.
                if now.since(servo.frame_start(now)) < (dt * SECOND_NS as f64 + 0.5) as u64 {
                    state.pulse = state.signal;
                }
                state.angle_rad = servo.step(state.angle_rad, servo.target_rad(state.pulse), dt);
            }
        }
        if let (Some(battery), Some(state)) = (&spec.battery, &mut self.battery) {
            let charger_w = scenario.surroundings.charger_at(self.motion.pose.position);
            let motors_w = if powered { spec.drive.power_w(&self.motion, signals) } else { 0.0 };
            state.draw(battery, battery.idle_w + motors_w, dt);
            if charger_w > 0.0 {
                let drawn_a = state.current_a;
                state.charge(battery, charger_w, dt);
                state.current_a += drawn_a;
            }
        }
    }

    /// A DC motor gets what the battery still gives.
    fn under_load(&self, spec: &RobotSpec, signals: Wheels) -> Wheels {
        let (Some(battery), Some(state), Motors::Dc(_)) = (&spec.battery, &self.battery, &spec.drive.motor)
        else {
            return signals;
        };
        let share = state.terminal_v(battery) / battery.nominal_v;
        Wheels { left: share * signals.left, right: share * signals.right }
    }
}

/// A contact ends when a body of so many times the size is free; a robot stops up to a step short of what it runs
/// into, so the factor must leave room for that.
const CONTACT_ENDS_AT: f64 = 1.1;
