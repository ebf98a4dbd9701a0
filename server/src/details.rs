//! What an observer is told about the robots that it wants to know more of.

use baudbot_sim::link::LineCounters;
use baudbot_sim::robot::{Cycles, RobotSpec};
use baudbot_sim::sight::{Glance, Onlooker};
use baudbot_sim::timeline::Event;
use baudbot_sim::{Pose, RobotView, SensorView, SimTime, World};

use crate::sessions::Sessions;

/// Most robots that one observer is told more of.
pub(crate) const MAX_DETAILS: usize = 64;

/// A robot that an observer wants to know more of, and what it knows already.
pub(crate) struct Detailed {
    robot: usize,
    /// Events of its timeline that have been told.
    events: u64,
    /// When the last reading of each sensor was truly sampled.
    sampled: Vec<Option<SimTime>>,
}

/// More about a robot.
pub(crate) struct Detail {
    pub(crate) robot: usize,
    pub(crate) sensors: Vec<SensorDetail>,
    pub(crate) uplink: LineCounters,
    pub(crate) downlink: LineCounters,
    pub(crate) under_way: [u64; 2],
    /// Its control cycles, and after how many nanoseconds each has to be over.
    pub(crate) cycles: (Cycles, u64),
    pub(crate) events: Vec<Event>,
    pub(crate) missed_events: u64,
    pub(crate) brain: Option<String>,
    pub(crate) cable_pulled: bool,
    pub(crate) baud: Option<u32>,
}

/// More about a sensor.
pub(crate) struct SensorDetail {
    pub(crate) values: Vec<f64>,
    pub(crate) sampled_at: Option<SimTime>,
    pub(crate) readable: bool,
    pub(crate) samples: u64,
    pub(crate) missed: u64,
    pub(crate) readable_steps: u64,
    pub(crate) rays: Option<RayFan>,
    pub(crate) port: Option<LineCounters>,
}

/// Rays of a sensor as they run.
pub(crate) struct RayFan {
    pub(crate) world_from_sensor: Pose,
    pub(crate) opening_rad: f64,
    pub(crate) lengths_m: Vec<f32>,
}

impl Detailed {
    pub(crate) fn new(robot: usize, world: &World) -> Self {
        Self { robot, events: 0, sampled: vec![None; world.robot(robot).spec().sensors.len()] }
    }

    /// The world is at another time.
    pub(crate) fn begin_anew(&mut self, world: &World) {
        *self = Self::new(self.robot, world);
    }

    /// At the start of each tick: what has come is known only until the brain has been given it.
    pub(crate) fn note(&mut self, world: &World) {
        let robot = world.robot(self.robot);
        for (i, sampled) in self.sampled.iter_mut().enumerate() {
            *sampled = robot.sampled_at(i).or(*sampled);
        }
    }

    /// What there is to tell now.
    pub(crate) fn tell(&mut self, world: &World, sessions: &Sessions, onlooker: &Onlooker<'_>) -> Detail {
        let view = world.robot(self.robot);
        let spec = view.spec();
        let (missed_events, events) = view.timeline().since(self.events);
        // Before the first frame nothing is missed.
        let missed_events = if self.events == 0 { 0 } else { missed_events };
        let events = events.copied().collect();
        self.events = view.timeline().total();
        let sensors = view.sensors().enumerate();
        let sensors = sensors.map(|(i, sensor)| self.sensor(&view, (i, &sensor), onlooker)).collect();
        Detail {
            robot: self.robot,
            sensors,
            uplink: *view.uplink(),
            downlink: *view.downlink(),
            under_way: view.under_way(),
            cycles: (view.cycles().clone(), spec.deadline.within_ns),
            events,
            missed_events,
            brain: sessions.brain(self.robot).map(str::to_owned),
            cable_pulled: spec.link.is_pulled(),
            baud: spec.link.baud(),
        }
    }

    fn sensor(
        &self,
        view: &RobotView<'_>,
        (i, sensor): (usize, &SensorView<'_>),
        onlooker: &Onlooker<'_>,
    ) -> SensorDetail {
        let (reading, spec) = (&view.readings()[i], view.spec());
        SensorDetail {
            values: reading.values.clone(),
            sampled_at: self.sampled[i].or(reading.sampled_at),
            readable: reading.readable,
            samples: sensor.samples,
            missed: sensor.missed,
            readable_steps: sensor.freshness.readable,
            rays: self.rays(spec, i, onlooker),
            port: view.port(i).copied(),
        }
    }

    fn rays(&self, spec: &RobotSpec, i: usize, onlooker: &Onlooker<'_>) -> Option<RayFan> {
        let sensor = &spec.sensors[i];
        let mount = sensor.device.mount()?;
        let glances = onlooker.sees(self.robot, sensor);
        if glances.is_empty() {
            return None;
        }
        let range_m = sensor.device.range_m().unwrap_or(f64::INFINITY);
        let opening_rad = sensor.device.fan().map_or(0.0, |fan| fan.opening_rad());
        let length = |glance: &Glance| glance.distance_m.unwrap_or(range_m) as f32;
        let lengths_m = glances.iter().map(length).collect();
        Some(RayFan { world_from_sensor: onlooker.place(self.robot, mount), opening_rad, lengths_m })
    }
}
