//! The memory that a scenario takes, walked by hand: a scenario is not serialised.

use alloc::collections::BTreeSet;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::mem::size_of;

use crate::chip::ChipSpec;
use crate::firmware::Firmware;
use crate::heap::{SHARED, elements, list};
use crate::model::{RobotModel, RobotSpec};
use crate::movable::{Movable, MovableShape};
use crate::scenario::Scenario;
use crate::sensor::Sensors;
use crate::surroundings::{Region, Surroundings};

impl Scenario {
    /// The bytes that it takes in memory: itself, its text, and all that was made of that.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let source = &self.source;
        let texts = SHARED + source.toml.len() + list(&source.overrides, String::capacity);
        let names = self.name.capacity() + self.description.capacity();
        let arena = SHARED + size_of_val(&*self.arena) + self.arena.heap_bytes();
        let movers = list(&self.movers, |mover| mover.name.capacity() + mover.heap_bytes());
        let movables = list(&self.movables, movable);
        let rules = self.rules.floor.as_ref().map_or(0, crate::coverage::Floor::heap_bytes)
            + elements(&self.rules.sensed_by);
        let ports = list(&self.serial_ports, |port| port.robot.capacity());
        let robots = robots(&self.robots);
        size_of::<Self>()
            + texts
            + names
            + arena
            + surroundings(&self.surroundings)
            + movers
            + movables
            + rules
            + ports
            + robots
    }
}

fn surroundings(Surroundings { zones, lights, fields, .. }: &Surroundings) -> usize {
    let zones = list(zones, |zone| {
        let region = match &zone.region {
            Region::Disc(_) => 0,
            Region::Polygon(points) => elements(points),
        };
        zone.name.capacity() + region
    });
    let lights = list(lights, |light| light.name.capacity());
    zones + lights + list(fields, |field| field.name.capacity() + elements(&field.sources))
}

fn movable(Movable { name, shape, .. }: &Movable) -> usize {
    let outline = match shape {
        MovableShape::Ball { .. } => 0,
        MovableShape::Box { outline, .. } => elements(outline),
    };
    name.len() + outline
}

/// Robots with their models; what several share is counted once.
fn robots(robots: &Vec<RobotSpec>) -> usize {
    let mut seen = Seen::default();
    let model = |robot: &RobotSpec| {
        let group = robot
            .group
            .as_ref()
            .map_or(0, |group| if seen.is_new(Arc::as_ptr(group).addr()) { SHARED + group.len() } else { 0 });
        let is_new = seen.is_new(Arc::as_ptr(&robot.model).addr());
        robot.name.capacity() + group + if is_new { SHARED + size_of::<RobotModel>() } else { 0 }
    };
    let own: usize = elements(robots) + robots.iter().map(model).sum::<usize>();
    let mut seen = Seen::default();
    let mut parts = 0;
    for robot in robots {
        if seen.is_new(Arc::as_ptr(&robot.model).addr()) {
            parts += model_parts(&robot.model, &mut seen);
        }
    }
    own + parts
}

fn model_parts(model: &RobotModel, seen: &mut Seen) -> usize {
    let sensors = if seen.is_new(model.sensors.address()) { Sensors::heap_bytes(&model.sensors) } else { 0 };
    let chip = model.chip.as_ref().map_or(0, |chip| {
        let is_new = seen.is_new(Arc::as_ptr(chip).addr());
        if is_new { SHARED + size_of::<ChipSpec>() + chip.heap_bytes() } else { 0 }
    });
    elements(&model.outline)
        + list(&model.parts, |part| match &part.outline {
            Region::Disc(_) => 0,
            Region::Polygon(points) => elements(points),
        })
        + list(&model.actuators, |actuator| actuator.name.capacity())
        + elements(&model.faults)
        + Firmware::heap_bytes(&model.firmware)
        + sensors
        + chip
}

/// Addresses of what was counted.
#[derive(Default)]
struct Seen(BTreeSet<usize>);

impl Seen {
    fn is_new(&mut self, address: usize) -> bool {
        self.0.insert(address)
    }
}
