//! Details of the robots for which an observer has asked.

use baudbot_proto::v1;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::raycast::RayCaster;
use baudbot_sim::{AgeSpan, RobotView, SensorView, SimTime, World};

use super::pins::Pins;
use crate::convert;
use crate::sessions::Sessions;

/// Most robots of which one observer gets details.
pub(crate) const MAX_DETAILS: usize = 64;

/// A robot of which an observer gets details, and what the observer knows already.
pub(super) struct Detailed {
    robot: usize,
    /// The number of the last event of its timeline that has been sent.
    events: u64,
    /// The age of each sensor's reading from the last frame on.
    ages: Vec<AgeSpan>,
    /// The pins of its chip, if the observer wants them.
    pins: Option<Pins>,
    /// Whether the observer has had a frame.
    is_known: bool,
}

impl Detailed {
    pub(super) fn new(robot: usize, pins_finest_ns: Option<u64>, world: &World) -> Self {
        let ages = vec![AgeSpan::default(); world.robot(robot).spec().sensors.len()];
        let pins = pins_finest_ns.and_then(|finest_ns| Pins::new(robot, finest_ns, world));
        Self { robot, events: 0, ages, pins, is_known: false }
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

    /// Notes at the start of each tick the readings that have come in the last one.
    pub(super) fn note(&mut self, world: &World) {
        if let Some(robot) = world.robot_at_start(self.robot) {
            for (i, ages) in self.ages.iter_mut().enumerate() {
                *ages = ages.join(robot.heard(i).ages);
            }
        }
        if let Some(pins) = &mut self.pins {
            pins.look(self.robot, world);
        }
    }

    /// The details at the start of the tick. If the robot's state of then is lost, they are those of its brain's step
    /// in the tick, with a mark.
    pub(super) fn tell(
        &mut self,
        world: &World,
        sessions: &Sessions,
        caster: &RayCaster<'_>,
    ) -> v1::RobotDetail {
        let (view, at) = match world.robot_at_start(self.robot) {
            Some(view) => (view, world.time()),
            None => (world.robot(self.robot), within(world, self.robot)),
        };
        let (missed_events, events) = world.robot(self.robot).timeline().since(self.events);
        // Nothing is missed before the first frame.
        let missed_events = if self.events == 0 { 0 } else { missed_events };
        let known = view.timeline().total().saturating_sub(self.events).saturating_sub(missed_events);
        let events = events.take(known as usize).map(convert::timeline_event).collect();
        self.events = view.timeline().total();
        let is_first = std::mem::replace(&mut self.is_known, true);
        let (pin_events, missed) = self.pins.as_mut().map_or_else(Default::default, |pins| {
            pins.look(self.robot, world);
            pins.take(world.time())
        });
        let missed_pin_events = if is_first { 0 } else { missed };
        let sensors = view.sensors().enumerate();
        let sensors = sensors.map(|(i, sensor)| self.sensor(&view, at, (i, &sensor), caster)).collect();
        let [uplink_waiting_bytes, downlink_waiting_bytes] = view.under_way();
        let brain = sessions.brain(self.robot);
        v1::RobotDetail {
            robot: self.robot as u32,
            at_ns: (at != world.time()).then_some(at.as_ns()),
            sensors,
            uplink: Some(convert::line_status(view.uplink())),
            downlink: Some(convert::line_status(view.downlink())),
            uplink_waiting_bytes,
            downlink_waiting_bytes,
            cycles: Some(convert::cycle_status(&view)),
            events,
            missed_events,
            pin_events: pin_events.iter().map(convert::pin_event).collect(),
            missed_pin_events,
            attached: brain.is_some(),
            brain: brain.unwrap_or_default().to_owned(),
            cable_pulled: view.spec().link.is_pulled(),
            baud: view.spec().link.baud(),
        }
    }

    fn sensor(
        &mut self,
        view: &RobotView<'_>,
        at: SimTime,
        (i, sensor): (usize, &SensorView<'_>),
        caster: &RayCaster<'_>,
    ) -> v1::SensorDetail {
        let (reading, spec, sampled_at) = (&view.readings()[i], view.spec(), view.heard(i).sampled_at);
        let age = sampled_at
            .map_or_else(AgeSpan::default, |sampled_at| AgeSpan::default().and(at.since(sampled_at)));
        // The age now is the first one from here on.
        let ages = std::mem::replace(&mut self.ages[i], age).join(age);
        let bounds_ns = ages.bounds_ns();
        v1::SensorDetail {
            values: reading.values.to_vec(),
            sampled_at_ns: sampled_at.map(SimTime::as_ns),
            least_age_ns: bounds_ns.map(|(least_ns, _)| least_ns),
            most_age_ns: bounds_ns.map(|(_, most_ns)| most_ns),
            readable: reading.readable,
            samples: sensor.samples,
            missed: sensor.missed,
            readable_steps: sensor.freshness.readable,
            rays: self.rays(spec, i, caster),
            port: view.port(i).map(convert::line_status),
        }
    }

    fn rays(&self, spec: &RobotSpec, i: usize, caster: &RayCaster<'_>) -> Option<v1::RayFan> {
        let sensor = &spec.sensors[i];
        let mount = sensor.device.mount()?;
        let casts = caster.sees(self.robot, sensor);
        if casts.is_empty() {
            return None;
        }
        let opening_rad = sensor.device.fan().map_or(0.0, |fan| fan.opening_rad());
        let lengths_m = casts.iter().map(|cast| cast.length_m() as f32).collect();
        Some(convert::ray_fan(caster.place(self.robot, mount), opening_rad, lengths_m))
    }
}

/// The progress of a robot within the tick that has begun.
fn within(world: &World, robot: usize) -> SimTime {
    let turn = world.turns().iter().find(|turn| turn.robot == robot);
    turn.map_or_else(|| world.time(), |turn| turn.at)
}
