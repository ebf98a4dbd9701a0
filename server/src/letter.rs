//! What services write to a world's thread, and what it writes back. Domain types only, which `convert` turns into the
//! contract's, but for what brains publish: that passes the world by, and nothing here looks into it.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_sim::actuator::ActuatorState;
use baudbot_sim::battery::BatteryState;
use baudbot_sim::collision::Collision;
use baudbot_sim::coverage::Coverage;
use baudbot_sim::drive::{Motion, Wheels};
use baudbot_sim::{Intervention, Reading, RobotView, Scenario, SimTime, World};
use tokio::sync::{OwnedSemaphorePermit, mpsc, oneshot};
use tonic::Status;

use crate::beliefs::Beliefs;
use crate::details::Detail;
use crate::endpoint::Write;
use crate::metrics::Measures;
use crate::pace::{Pace, Pacing};
use crate::recording::{RecordConfig, SharedTape};
use crate::registry::WorldHandle;

/// A letter to a world.
pub(crate) enum Letter {
    Order(Order, oneshot::Sender<Result<Report, Status>>),
    Describe(oneshot::Sender<Arc<Scenario>>),
    /// Asks what is being replayed, if anything is.
    DescribeReplay(oneshot::Sender<Option<SharedTape>>),
    Measure(oneshot::Sender<Measures>),
    /// Asks which cells of the floor are covered.
    Cover(oneshot::Sender<CoverageReport>),
    Watch(Watch),
    Attach(Attach, oneshot::Sender<Result<Attached, Status>>),
    Step {
        session: u64,
        turn: u64,
        writes: Vec<Write>,
        /// Given back when the letter is opened: it bounds how many of a stream wait for that.
        permit: OwnedSemaphorePermit,
    },
    Detach {
        session: u64,
        why: String,
    },
    /// The server stops.
    End,
}

/// An observer wants to see the world.
pub(crate) struct Watch {
    pub(crate) every_ticks: u64,
    /// The robots that it wants to know more of.
    pub(crate) details: Vec<usize>,
    pub(crate) frames: mpsc::Sender<Frame>,
}

/// What an operator orders.
#[derive(Debug)]
pub(crate) enum Order {
    Report,
    Start,
    Pause,
    Step {
        ticks: u64,
    },
    SetPace(Pace),
    Reset,
    Snapshot,
    Restore {
        snapshot: u64,
    },
    /// Tells how it is, or how a state was that was kept.
    Save {
        snapshot: u64,
    },
    Record(RecordConfig),
    StopRecording(oneshot::Sender<RecordingReport>),
    /// Of a world that replays.
    Seek {
        tick: u64,
    },
    /// Of a world that replays.
    Fork(Pace),
    /// Before the next tick.
    Intervene(Intervention),
    /// Throws the brain of the robot of this name off.
    DetachBrain {
        robot: String,
        /// It is to begin anew, if its program can.
        restart: bool,
    },
    Delete,
}

impl Order {
    /// What it is called in traces.
    pub(crate) fn word(&self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Start => "start",
            Self::Pause => "pause",
            Self::Step { .. } => "step",
            Self::SetPace(_) => "set_pace",
            Self::Reset => "reset",
            Self::Snapshot => "snapshot",
            Self::Restore { .. } => "restore",
            Self::Save { .. } => "save",
            Self::Record(_) => "record",
            Self::StopRecording(_) => "stop_recording",
            Self::Seek { .. } => "seek",
            Self::Fork(_) => "fork",
            Self::Intervene(_) => "intervene",
            Self::DetachBrain { .. } => "detach_brain",
            Self::Delete => "delete",
        }
    }
}

/// A world as it stands, for the operator.
pub(crate) struct Report {
    pub(crate) name: Arc<str>,
    pub(crate) world: World,
    pub(crate) pace: Pace,
    pub(crate) activity: Activity,
    pub(crate) pacing: Pacing,
    pub(crate) running: Duration,
    pub(crate) seats: Vec<SeatReport>,
    /// The number of the snapshot that was just taken.
    pub(crate) snapshot: u64,
    pub(crate) replay: Option<ReplayReport>,
    pub(crate) recording: Option<RecordingReport>,
}

/// How it goes with a replay.
pub(crate) struct ReplayReport {
    pub(crate) first_tick: u64,
    pub(crate) last_tick: u64,
    pub(crate) differs: Option<String>,
}

/// How it goes with a recording.
#[derive(Clone, Debug)]
pub(crate) struct RecordingReport {
    pub(crate) name: String,
    pub(crate) bytes: u64,
    pub(crate) ticks: u64,
    pub(crate) problem: Option<String>,
}

/// Who holds a robot.
pub(crate) struct SeatReport {
    pub(crate) brain: Option<String>,
    pub(crate) lost_deliveries: u64,
    pub(crate) lost_steps: u64,
    pub(crate) said: String,
}

/// What a world is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    WaitingForBrains,
    Running,
    Paused,
    Ended,
}

/// The truth at the start of a tick, for an observer.
pub(crate) struct Frame {
    pub(crate) tick: u64,
    pub(crate) time: SimTime,
    pub(crate) robots: Vec<Truth>,
    pub(crate) collisions: Vec<Collision>,
    pub(crate) missed_frames: u64,
    pub(crate) ending: Option<String>,
    pub(crate) things: Vec<Thing>,
    pub(crate) score: Option<Score>,
    pub(crate) details: Vec<Detail>,
    /// By robot, what its brain has published since the last frame.
    pub(crate) beliefs: Vec<(usize, Arc<v1::Belief>)>,
}

pub(crate) struct Truth {
    pub(crate) motion: Motion,
    pub(crate) signals: Wheels,
    pub(crate) collided: bool,
    pub(crate) samples: Vec<f64>,
    pub(crate) actuators: Vec<ActuatorState>,
    pub(crate) battery: Option<Charge>,
    pub(crate) in_zone_ns: Vec<u64>,
}

/// Something that moves by itself or is pushed.
pub(crate) struct Thing {
    pub(crate) name: String,
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) heading_rad: f64,
    pub(crate) blocked_ns: u64,
}

/// How a battery is.
pub(crate) struct Charge {
    pub(crate) share: f64,
    pub(crate) voltage_v: f64,
    pub(crate) state: BatteryState,
}

impl Charge {
    /// Of a robot that has a battery.
    pub(crate) fn of(robot: &RobotView<'_>) -> Option<Self> {
        let (battery, state) = robot.battery()?;
        Some(Self { share: state.share(battery), voltage_v: state.terminal_v(battery), state: *state })
    }
}

/// What the referee counted.
pub(crate) struct Score {
    pub(crate) covered: Option<f64>,
    pub(crate) sensed: Option<f64>,
    /// Name, whether it is a goal, and whether any robot has been there.
    pub(crate) zones: Vec<(String, bool, bool)>,
}

impl Score {
    /// `None` if there is nothing to count.
    pub(crate) fn of(world: &World) -> Option<Self> {
        let (scenario, score) = (world.scenario(), world.score());
        let zones = scenario.surroundings().zones.iter().zip(score.visited());
        let zones: Vec<_> = zones.map(|(zone, &visited)| (zone.name.clone(), zone.goal, visited)).collect();
        let (covered, sensed) = (score.covered(scenario.rules()), score.sensed(scenario.rules()));
        let something = covered.is_some() || sensed.is_some() || !zones.is_empty();
        something.then_some(Self { covered, sensed, zones })
    }
}

/// Which cells of the floor are covered and sensed.
pub(crate) struct CoverageReport {
    pub(crate) tick: u64,
    pub(crate) scenario: Arc<Scenario>,
    /// `None` if that is not counted.
    pub(crate) coverage: Option<Coverage>,
}

impl CoverageReport {
    /// A copy of the world's bits: what they say is found out where no world waits for it.
    pub(crate) fn of(world: &World) -> Self {
        let scenario = Arc::clone(world.scenario());
        Self { tick: world.tick(), scenario, coverage: world.score().coverage().cloned() }
    }
}

/// A brain program asks for robots.
pub(crate) struct Attach {
    pub(crate) robots: Vec<String>,
    pub(crate) brain: String,
    pub(crate) raw: bool,
    /// Memory that the program's variables need on each robot.
    pub(crate) memory_bytes: Option<u64>,
    /// It has promised to think as long as the scenario says.
    pub(crate) steady: bool,
    /// Its robots are to stand when it is gone.
    pub(crate) stop_when_gone: bool,
    pub(crate) deliveries: mpsc::Sender<Delivery>,
    /// The way back to the world, for the lease.
    pub(crate) world: WorldHandle,
}

/// It has them.
pub(crate) struct Attached {
    pub(crate) lease: Lease,
    pub(crate) scenario: Arc<Scenario>,
    /// Indices of the robots, in the order of the request.
    pub(crate) robots: Vec<usize>,
    pub(crate) lockstep: bool,
    pub(crate) beliefs: Beliefs,
    /// Counts the Steps that are thrown away.
    pub(crate) lost_steps: Arc<AtomicU64>,
}

/// A hold on robots: they are let go when it is dropped, wherever that happens.
pub(crate) struct Lease {
    pub(crate) world: WorldHandle,
    pub(crate) session: u64,
    /// Why the robots are let go, for the log.
    pub(crate) why: String,
}

impl Drop for Lease {
    fn drop(&mut self) {
        // A world that is gone holds nothing any more.
        let why = std::mem::take(&mut self.why);
        let _ = self.world.send(Letter::Detach { session: self.session, why });
    }
}

/// To a brain.
pub(crate) enum Delivery {
    Turn { number: u64, tick: u64, robots: Vec<RobotDelivery> },
    Ended { tick: u64 },
    Close(Status),
}

/// One robot's part of a turn.
pub(crate) struct RobotDelivery {
    pub(crate) slot: usize,
    pub(crate) at: SimTime,
    pub(crate) raw: Vec<u8>,
    /// With the place of the sensor.
    pub(crate) ports: Vec<(usize, Vec<u8>)>,
    /// With the place of the sensor.
    pub(crate) readings: Vec<(usize, Reading)>,
}
