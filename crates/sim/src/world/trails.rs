//! What robots add to fields, tick by tick.

use alloc::vec;
use alloc::vec::Vec;

use super::World;
use crate::actuator::{ActuatorKind, Dispenser};
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::sound;
use crate::trail::{TrailGrid, Trails};

impl World {
    /// What robots have added to fields.
    pub(crate) fn trails(&self) -> &Trails {
        &self.trails
    }
}

impl Scenario {
    /// The trails at the start, empty if no field has a grid.
    pub(crate) fn trails(&self) -> Trails {
        let fields = &self.surroundings.fields;
        if fields.iter().all(|field| field.trail.is_none()) {
            return Trails::new();
        }
        fields.iter().map(|field| vec![0.0; field.trail.as_ref().map_or(0, TrailGrid::count)]).collect()
    }

    /// Whether these may be the trails of a world of this scenario.
    pub(crate) fn has_trails(&self, trails: &Trails) -> bool {
        let own = self.trails();
        own.len() == trails.len()
            && own.iter().zip(trails).all(|(own, other)| {
                own.len() == other.len()
                    && sound::numbers(other.iter().copied())
                    && other.iter().all(|cell| *cell >= 0.0)
            })
    }

    /// Lets trails spread and fade for a tick, and adds what the robots lay down in it.
    pub(crate) fn pass_trails(&self, trails: &mut Trails, robots: &[Robot], rows: &mut [Vec<f64>; 2]) {
        if trails.is_empty() {
            return;
        }
        let dt_s = self.step_ns as f64 * 1e-9;
        for (field, cells) in self.surroundings.fields.iter().zip(trails.iter_mut()) {
            if let Some(grid) = &field.trail {
                grid.pass(cells, dt_s, rows);
            }
        }
        for (spec, robot) in self.robots.iter().zip(robots) {
            for (actuator, state) in spec.actuators.iter().zip(&robot.actuators) {
                let ActuatorKind::Dispenser(Dispenser { field, rate_per_s }) = actuator.kind else {
                    continue;
                };
                let grid = self.surroundings.fields.get(field).and_then(|field| field.trail.as_ref());
                if let (Some(grid), Some(cells)) = (grid, trails.get_mut(field)) {
                    let amount = rate_per_s * state.signal.clamp(0.0, 1.0) * dt_s;
                    grid.lay(cells, robot.motion.pose.position, amount);
                }
            }
        }
    }
}
