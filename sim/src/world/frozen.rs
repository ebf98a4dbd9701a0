//! What sensors see of the state: everything that moves, as it stands at the start of the tick.

use baudbot_geometry::{Circle, Point, Pose};

use super::World;
use crate::actuator::ActuatorKind;
use crate::arena::Look;
use crate::movable::{Body, Form};
use crate::scenario::Scenario;
use crate::scene::{Figure, Frozen, Scene, Sound};
use crate::sensor::is_heard;
use crate::surroundings::Lit;

impl World {
    pub(crate) fn frozen(&self) -> Frozen {
        let scenario = &self.scenario;
        let mut frozen = Frozen::default();
        for (robot, spec) in self.state.robots.iter().zip(scenario.robots()) {
            frozen.bodies.push(figure(&spec.form(), &robot.motion.pose, spec.look));
        }
        for (mover, state) in scenario.movers.iter().zip(&self.state.movers) {
            frozen.bodies.push(figure(&mover.form(), &state.pose, mover.look));
        }
        for (movable, state) in scenario.movables.iter().zip(&self.state.movables) {
            frozen.bodies.push(figure(&movable.shape.form(), &state.pose, movable.look));
        }
        let now = self.time();
        frozen.lights.extend(scenario.surroundings.lights.iter().filter_map(|light| light.lit(now)));
        for i in 0..self.state.robots.len() {
            self.emissions(i, &mut frozen);
        }
        frozen
    }

    /// What a robot lets others see and hear.
    fn emissions(&self, i: usize, frozen: &mut Frozen) {
        let (robot, spec) = (&self.state.robots[i], &self.scenario.robots()[i]);
        let from = robot.motion.pose.position;
        frozen.pings.extend(robot.pings[1].filter(|ping| is_heard(ping, self.time())));
        for (actuator, state) in spec.actuators.iter().zip(&robot.actuators) {
            let strength = state.signal.clamp(0.0, 1.0);
            match actuator.kind {
                _ if strength == 0.0 => {}
                ActuatorKind::Turret(_) => {}
                ActuatorKind::Lamp { intensity_cd, height_m } => frozen.lights.push(Lit {
                    position: from,
                    height_m,
                    intensity_cd: strength * intensity_cd,
                    shadows: true,
                    robot: Some(i),
                }),
                ActuatorKind::Speaker { level } => {
                    frozen.sounds.push(Sound { robot: i, from, level: strength * level });
                }
            }
        }
    }
}

fn figure(form: &Form<'_>, pose: &Pose, look: Look) -> Figure {
    match form.at(pose) {
        Body::Disc(disc) => Figure { disc, outline: alloc::vec::Vec::new(), look },
        Body::Polygon(outline) => {
            let center: Point = pose.position;
            Figure { disc: Circle { center, radius: form.reach_m() }, outline, look }
        }
    }
}

impl Scenario {
    /// The scene as robot `own` sees it.
    pub(crate) fn scene<'a>(&'a self, frozen: &'a Frozen, own: usize) -> Scene<'a> {
        Scene { arena: &self.arena, surroundings: &self.surroundings, frozen, own }
    }
}
