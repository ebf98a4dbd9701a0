//! The state as sensors see it: everything that moves, as it stands at the start of the tick.

use baudbot_fields::number::Number;
use baudbot_geometry::{Circle, Pose};

use super::World;
use crate::actuator::{ActuatorKind, Lamp, Speaker};
use crate::arena::Look;
use crate::model::Part;
use crate::movable::Form;
use crate::scenario::Scenario;
use crate::scene::{Figure, Frozen, Scene, Sound};
use crate::sensor::is_heard;
use crate::surroundings::{Lit, Region};
use crate::trail::Trails;

impl World {
    pub(crate) fn frozen(&self) -> Frozen {
        let mut frozen = Frozen::default();
        self.freeze(&mut frozen);
        frozen
    }

    /// The scene as it is now, in memory that has been used before.
    pub(super) fn freeze(&self, frozen: &mut Frozen) {
        let scenario = &self.scenario;
        let robots = self.state.robots.iter().zip(&scenario.robots);
        let robots = robots.map(|(robot, spec)| (spec.form(), &robot.motion.pose, spec.look));
        let movers = scenario.movers.iter().zip(&self.state.movers);
        let movers = movers.map(|(mover, state)| (mover.form(), &state.pose, mover.look));
        let movables = scenario.movables.iter().zip(&self.state.movables);
        let movables = movables.map(|(movable, state)| (movable.shape.form(), &state.pose, movable.look));
        let mut count = 0;
        for (form, pose, look) in robots.chain(movers).chain(movables) {
            frozen.next(&mut count).take(&form, pose, look);
        }
        (frozen.first_part, count) = (count, count);
        frozen.carriers.clear();
        for (i, (robot, spec)) in self.state.robots.iter().zip(&scenario.robots).enumerate() {
            for part in &spec.parts {
                frozen.next(&mut count).take_part(part, &robot.motion.pose);
                frozen.carriers.push(i);
            }
        }
        frozen.bodies.truncate(count);
        frozen.crowd.rebuild(frozen.bodies.iter().map(|body| body.disc));
        frozen.lights.clear();
        frozen.sounds.clear();
        frozen.pings.clear();
        let now = self.time();
        frozen.lights.extend(scenario.surroundings.lights.iter().filter_map(|light| light.lit(now)));
        for i in 0..self.state.robots.len() {
            self.emissions(i, frozen);
        }
    }

    /// The light and the sound of a robot for others.
    fn emissions(&self, i: usize, frozen: &mut Frozen) {
        let (robot, spec) = (&self.state.robots[i], &self.scenario.robots[i]);
        let from = robot.motion.pose.position;
        frozen.pings.extend(robot.pings[1].filter(|ping| is_heard(ping, self.time())));
        for (actuator, state) in spec.actuators.iter().zip(&robot.actuators) {
            let strength = state.signal.clamp(0.0, 1.0);
            match actuator.kind {
                _ if strength == 0.0 => {}
                ActuatorKind::Turret(_) | ActuatorKind::Dispenser(_) => {}
                ActuatorKind::Lamp(Lamp { intensity_cd, height_m }) => frozen.lights.push(Lit {
                    position: from,
                    height_m,
                    intensity_cd: strength * intensity_cd,
                    shadows: true,
                    robot: Some(i),
                }),
                ActuatorKind::Speaker(Speaker { level, frequency_hz }) => frozen.sounds.push(Sound {
                    robot: i,
                    from,
                    level: strength * level,
                    frequency_hz: frequency_hz.map(Number::get),
                }),
            }
        }
    }
}

impl Frozen {
    /// The next body, in memory that has been used before if there is some.
    fn next(&mut self, count: &mut usize) -> &mut Figure {
        if *count == self.bodies.len() {
            self.bodies.push(Figure::default());
        }
        *count += 1;
        &mut self.bodies[*count - 1]
    }
}

impl Figure {
    /// Becomes this part of a robot.
    fn take_part(&mut self, part: &Part, pose: &Pose) {
        match &part.outline {
            Region::Polygon(points) => self.take(&Form::Polygon(points), pose, part.look),
            Region::Disc(disc) => {
                self.take(&Form::Disc { radius_m: disc.radius }, pose, part.look);
                self.disc.center += pose.direction().apply(disc.center.coords);
            }
        }
    }

    /// Becomes this body.
    fn take(&mut self, form: &Form<'_>, pose: &Pose, look: Look) {
        self.outline.clear();
        self.disc = Circle { center: pose.position, radius: form.reach_m() };
        self.look = look;
        if let Form::Polygon(points) = form {
            let direction = pose.direction();
            self.outline.extend(points.iter().map(|point| pose.position + direction.apply(point.coords)));
        }
    }
}

impl Scenario {
    /// The scene as robot `own` sees it.
    pub(crate) fn scene<'a>(&'a self, frozen: &'a Frozen, trails: &'a Trails, own: usize) -> Scene<'a> {
        Scene::new((&self.arena, &self.surroundings), (frozen, trails), own, self.robots[own].sensors.reach())
    }
}
