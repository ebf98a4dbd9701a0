//! A frame: the data of a world that observers get at the start of a tick; and what came over a cable.

use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::actuator::ActuatorState;
use baudbot_sim::battery::BatteryState;
use baudbot_sim::chip::Shown;
use baudbot_sim::collision::Collision;
use baudbot_sim::drive::{Motion, Wheels};
use baudbot_sim::link::LineCounters;
use baudbot_sim::robot::Cycles;
use baudbot_sim::timeline::Event;
use baudbot_sim::{Pose, RobotView, SimTime, World};
use baudbot_wire::meaning::Direction;

/// The data of a world for one observer.
pub(crate) struct Frame {
    pub(crate) truth: Truth,
    pub(crate) own: Own,
}

/// The truth at the start of a tick, which is the same for all observers.
pub(crate) struct Truth {
    pub(crate) tick: u64,
    pub(crate) time: SimTime,
    pub(crate) robots: Vec<RobotTruth>,
    /// Why the run has ended, if it has.
    pub(crate) ending: Option<String>,
    pub(crate) things: Vec<Thing>,
    /// `None` if the scenario counts nothing.
    pub(crate) score: Option<Score>,
}

/// What has happened since an observer's last frame, and what it has asked for.
pub(crate) struct Own {
    pub(crate) collisions: Vec<Collision>,
    /// Frames that the observer has missed since it began to watch.
    pub(crate) missed_frames: u64,
    pub(crate) details: Vec<RobotDetail>,
    /// By robot, what its brain has published since the last frame. The world does not look into it.
    pub(crate) beliefs: Vec<(usize, Arc<v1::Belief>)>,
}

/// The truth of one robot.
pub(crate) struct RobotTruth {
    pub(crate) motion: Motion,
    pub(crate) signals: Wheels,
    pub(crate) collided: bool,
    /// The values of all sensors, one behind the other; NaN for a sensor without a sample.
    pub(crate) samples: Vec<f64>,
    pub(crate) actuators: Vec<ActuatorState>,
    pub(crate) battery: Option<Charge>,
    /// Time in each zone of the scenario.
    pub(crate) in_zone_ns: Vec<u64>,
}

/// Something that moves by itself or is pushed.
pub(crate) struct Thing {
    pub(crate) name: String,
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) heading_rad: f64,
    /// For how long something has been in its way, in all.
    pub(crate) blocked_ns: u64,
}

/// The state of a battery.
pub(crate) struct Charge {
    /// Of its capacity, from 0 to 1.
    pub(crate) share: f64,
    pub(crate) voltage_v: f64,
    pub(crate) state: BatteryState,
}

impl Charge {
    /// The charge of a robot's battery; `None` if the robot has none.
    pub(crate) fn of(robot: &RobotView<'_>) -> Option<Self> {
        let (battery, state) = robot.battery()?;
        Some(Self { share: state.share(battery), voltage_v: state.terminal_v(battery), state: *state })
    }
}

/// The referee's counts.
pub(crate) struct Score {
    /// Share of the floor that robots have driven over.
    pub(crate) covered: Option<f64>,
    /// Share of the floor that sensors have seen.
    pub(crate) sensed: Option<f64>,
    pub(crate) zones: Vec<ZoneScore>,
}

/// The referee's counts for a zone.
pub(crate) struct ZoneScore {
    pub(crate) name: String,
    pub(crate) is_goal: bool,
    /// Whether any robot has been there.
    pub(crate) visited: bool,
}

impl Score {
    /// The score of a world; `None` if there is nothing to count.
    pub(crate) fn of(world: &World) -> Option<Self> {
        let (scenario, score) = (world.scenario(), world.score());
        let zones = scenario.surroundings.zones.iter().zip(score.visited());
        let zone = |name: &str, is_goal, visited| ZoneScore { name: name.to_owned(), is_goal, visited };
        let zones: Vec<_> = zones.map(|(spec, &visited)| zone(&spec.name, spec.goal, visited)).collect();
        let (covered, sensed) = (score.covered(&scenario.rules), score.sensed(&scenario.rules));
        let something = covered.is_some() || sensed.is_some() || !zones.is_empty();
        something.then_some(Self { covered, sensed, zones })
    }
}

/// Details of a robot, for observers that have asked for them.
pub(crate) struct RobotDetail {
    pub(crate) robot: usize,
    /// The instant of these numbers, if it is not the frame's.
    pub(crate) at: Option<SimTime>,
    pub(crate) sensors: Vec<SensorDetail>,
    pub(crate) uplink: LineCounters,
    pub(crate) downlink: LineCounters,
    /// Bytes that wait for the line or are on it, up and down.
    pub(crate) under_way: [u64; 2],
    pub(crate) cycles: Cycles,
    /// After how many nanoseconds a control cycle is late.
    pub(crate) deadline_ns: u64,
    /// Events of the robot's timeline since the last frame.
    pub(crate) events: Vec<Event>,
    /// Events since then that the timeline did not keep.
    pub(crate) missed_events: u64,
    /// What was seen on the pins of its chip since the last frame, each with the place of its signal.
    pub(crate) pin_events: Vec<(usize, Shown)>,
    /// How much is not told of that.
    pub(crate) missed_pin_events: u64,
    /// The name of its brain; `None` if it has none.
    pub(crate) brain: Option<String>,
    pub(crate) cable_pulled: bool,
    /// `None` if the link has no baud rate.
    pub(crate) baud: Option<u32>,
}

/// The detail of a sensor.
pub(crate) struct SensorDetail {
    /// The reading that the brain has; empty if none has come.
    pub(crate) values: Vec<f64>,
    /// When that reading was truly sampled.
    pub(crate) sampled_at: Option<SimTime>,
    /// The least and the most that readings were old since the last frame, in nanoseconds.
    pub(crate) ages_ns: Option<(u64, u64)>,
    /// Whether it is new since the brain's last step.
    pub(crate) readable: bool,
    pub(crate) samples: u64,
    pub(crate) missed: u64,
    /// Steps at which the reading was new.
    pub(crate) readable_steps: u64,
    pub(crate) rays: Option<RayFan>,
    /// Of a device with its own link.
    pub(crate) port: Option<LineCounters>,
}

/// The rays of a sensor as they run now.
pub(crate) struct RayFan {
    pub(crate) world_from_sensor: Pose,
    pub(crate) opening_rad: f64,
    pub(crate) lengths_m: Vec<f32>,
}

/// What came over a cable since the last news.
#[derive(Debug, Default)]
pub(crate) struct CableNews {
    pub(crate) items: Vec<CableItem>,
    /// Items that this watcher has missed since it came.
    pub(crate) missed: u64,
    /// The world is at another time than before.
    pub(crate) has_restarted: bool,
}

/// A part of what is said on a cable.
#[derive(Debug)]
pub(crate) struct CableItem {
    pub(crate) direction: Direction,
    pub(crate) from_ns: u64,
    pub(crate) to_ns: u64,
    /// The first of its bytes.
    pub(crate) bytes: Vec<u8>,
    pub(crate) size: usize,
    pub(crate) text: String,
    pub(crate) is_understood: bool,
    pub(crate) age_ns: Option<u64>,
}
