//! Details of the robots for which an observer has asked.

use baudbot_sim::model::RobotSpec;
use baudbot_sim::raycast::{CastRay, RayCaster};
use baudbot_sim::{RobotView, SensorView, SimTime, World};

use super::pins::Pins;
use crate::frame::{RayFan, RobotDetail, SensorDetail};
use crate::sessions::Sessions;

/// Most robots of which one observer gets details.
pub(crate) const MAX_DETAILS: usize = 64;

/// A robot of which an observer gets details, and what the observer knows already.
pub(super) struct Detailed {
    robot: usize,
    /// The number of the last event of its timeline that has been told.
    events: u64,
    /// When the last reading of each sensor was truly sampled.
    sampled: Vec<Option<SimTime>>,
    /// What is on the pins of its chip, if the observer wants that.
    pins: Option<Pins>,
    /// Whether the observer has had a frame.
    is_known: bool,
}

impl Detailed {
    pub(super) fn new(robot: usize, pins_finest_ns: Option<u64>, world: &World) -> Self {
        let sampled = vec![None; world.robot(robot).spec().sensors.len()];
        let pins = pins_finest_ns.and_then(|finest_ns| Pins::new(robot, finest_ns, world));
        Self { robot, events: 0, sampled, pins, is_known: false }
    }

    /// The robot, if the observer looks at its pins.
    pub(super) fn pinned(&self) -> Option<usize> {
        self.pins.as_ref().map(|_| self.robot)
    }

    /// Forgets what the observer knows: the world is at another time.
    pub(super) fn reset(&mut self, world: &World) {
        let mut pins = self.pins.take();
        if let Some(pins) = &mut pins {
            pins.reset(self.robot, world);
        }
        *self = Self { pins, ..Self::new(self.robot, None, world) };
    }

    /// At the start of each tick: when a reading was sampled is known only until the brain has been given it.
    pub(super) fn note(&mut self, world: &World) {
        let robot = world.robot(self.robot);
        for (i, sampled) in self.sampled.iter_mut().enumerate() {
            *sampled = robot.sampled_at(i).or(*sampled);
        }
        if let Some(pins) = &mut self.pins {
            pins.look(self.robot, world);
        }
    }

    /// The details now.
    pub(super) fn tell(&mut self, world: &World, sessions: &Sessions, caster: &RayCaster<'_>) -> RobotDetail {
        let view = world.robot(self.robot);
        let spec = view.spec();
        let (missed_events, events) = view.timeline().since(self.events);
        // Before the first frame nothing is missed.
        let missed_events = if self.events == 0 { 0 } else { missed_events };
        let events = events.copied().collect();
        self.events = view.timeline().total();
        let is_first = std::mem::replace(&mut self.is_known, true);
        let (pin_events, missed) = self.pins.as_mut().map_or_else(Default::default, |pins| {
            pins.look(self.robot, world);
            pins.take()
        });
        let missed_pin_events = if is_first { 0 } else { missed };
        let sensors = view.sensors().enumerate();
        let sensors = sensors.map(|(i, sensor)| self.sensor(&view, (i, &sensor), caster)).collect();
        RobotDetail {
            robot: self.robot,
            sensors,
            uplink: *view.uplink(),
            downlink: *view.downlink(),
            under_way: view.under_way(),
            cycles: view.cycles().clone(),
            deadline_ns: spec.deadline.within_ns,
            events,
            missed_events,
            pin_events,
            missed_pin_events,
            brain: sessions.brain(self.robot).map(str::to_owned),
            cable_pulled: spec.link.is_pulled(),
            baud: spec.link.baud(),
        }
    }

    fn sensor(
        &self,
        view: &RobotView<'_>,
        (i, sensor): (usize, &SensorView<'_>),
        caster: &RayCaster<'_>,
    ) -> SensorDetail {
        let (reading, spec) = (&view.readings()[i], view.spec());
        SensorDetail {
            values: reading.values.to_vec(),
            sampled_at: self.sampled[i].or(reading.sampled_at),
            readable: reading.readable,
            samples: sensor.samples,
            missed: sensor.missed,
            readable_steps: sensor.freshness.readable,
            rays: self.rays(spec, i, caster),
            port: view.port(i).copied(),
        }
    }

    fn rays(&self, spec: &RobotSpec, i: usize, caster: &RayCaster<'_>) -> Option<RayFan> {
        let sensor = &spec.sensors[i];
        let mount = sensor.device.mount()?;
        let casts = caster.sees(self.robot, sensor);
        if casts.is_empty() {
            return None;
        }
        let range_m = sensor.device.range_m().unwrap_or(f64::INFINITY);
        let opening_rad = sensor.device.fan().map_or(0.0, |fan| fan.opening_rad());
        let length = |cast: &CastRay| cast.distance_m.unwrap_or(range_m) as f32;
        let lengths_m = casts.iter().map(length).collect();
        Some(RayFan { world_from_sensor: caster.place(self.robot, mount), opening_rad, lengths_m })
    }
}
