//! The processes of a brain, as Wahde 2016 has them in GPRBS (Sections 5.2 and 8.1): **motor behaviours**, of which exactly
//! one at a time has the motors, and **cognitive processes**, which use no motors and of which any number is active.
//!
//! A process is entered when it is activated, does a step in each turn of the brain while it is active, and is left when it
//! is no longer. Processes exchange data in [`Beliefs`]: a process of odometry writes the robot's pose, and one of navigation
//! reads it.

use baudbot_brain::{Signals, Turn};
use baudbot_geometry::Point;

pub use crate::awaited::Awaited;
use crate::estimate::Estimate;
use crate::mapping::Occupancy;
use crate::odometry::Odometry;

/// The context of a process in a step.
#[derive(Debug)]
pub struct StepContext<'a> {
    /// The turn: readings that have come over the cable.
    pub turn: &'a Turn,
    /// Since the brain's last step, in seconds.
    pub dt_s: f64,
    /// The state variables z, in the order of their names.
    pub state: &'a [f64],
    /// The brain's beliefs, which processes write for each other.
    pub beliefs: &'a mut Beliefs,
    /// Gamma parameters that are set in this step: the name of a process, and its Γ.
    pub gammas: &'a mut Vec<(String, f64)>,
}

impl StepContext<'_> {
    /// Sets the Γ of a process, of (8.4): a large positive one activates it soon, a large negative one stops it. It falls
    /// off by itself. Methods of decision that know no utilities do not heed it.
    pub fn set_gamma(&mut self, process: &str, gamma: f64) {
        self.gammas.push((process.to_owned(), gamma));
    }
}

/// The beliefs of a brain, in a frame of its own in which it was at (0, 0, 0) at the start unless it knows better.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beliefs {
    /// The robot's pose.
    pub pose: Option<Estimate>,
    /// The robot's way there. A process that knows better for an earlier instant, by a scan that came late, corrects
    /// this.
    pub odometry: Option<Odometry>,
    /// The map that it has made by itself.
    pub grid: Option<Occupancy>,
    /// Something is close ahead.
    pub near: bool,
    /// The places on its way, in metres.
    pub path: Vec<Point>,
    /// The intention of a behaviour, in a few words, for observers.
    pub intention: String,
    /// The sensor that a process waits for in this step, if one does.
    pub awaited: Option<Awaited>,
}

/// A process that drives.
pub trait MotorBehavior: Send {
    /// The behaviour is activated.
    fn enter(&mut self, _: &mut StepContext<'_>) {}

    /// One step. `None` leaves the motors as they are.
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals>;

    /// Another is activated instead.
    fn leave(&mut self, _: &mut StepContext<'_>) {}

    /// Whether it runs on to its end whatever is decided meanwhile: a fixed action pattern (Section 4.4.3).
    fn is_fixed(&self) -> bool {
        false
    }

    /// Whether it drives by the believed pose. While odometry is overdue the robot then stands, and the older odometry is the
    /// slower it drives.
    fn goes_by_pose(&self) -> bool {
        false
    }
}

/// A process that does not drive.
pub trait CognitiveProcess: Send {
    /// The process is activated.
    fn enter(&mut self, _: &mut StepContext<'_>) {}

    /// One step.
    fn step(&mut self, context: &mut StepContext<'_>);

    /// The process is no longer active.
    fn leave(&mut self, _: &mut StepContext<'_>) {}
}
