//! A robot that a program drives: its readings and its last command.

use std::sync::Arc;

use baudbot_brain::{Action, RawCommands, Signals};
use baudbot_sim::firmware::Mode;
use baudbot_sim::{SimTime, Turn, World};
use serde::{Deserialize, Serialize};
use smallvec::{SmallVec, smallvec};

use crate::learn::error::LearnError;
use crate::learn::layout::Layout;

/// An agent of an environment.
///
/// Its observation is what a brain at the laptop's end of the cable has: nothing of it is the truth.
#[derive(Clone, Debug)]
pub struct Agent {
    pub(crate) robot: usize,
    layout: Arc<Layout>,
    is_polled: bool,
    /// Signals of the wheels and of the other actuators that are to be sent at its next turn.
    pending: Option<[f64; WHEELS]>,
    others: SmallVec<[f64; 2]>,
    values: SmallVec<[f64; FEW]>,
    /// The instants at which each reading was sampled, as its message says, or else when it came; `NEVER` if none has.
    sampled_at: SmallVec<[SimTime; FEW]>,
    readable: SmallVec<[bool; FEW]>,
    /// The robot is polled at the agent's next turn, unless a command does that.
    asks: bool,
    /// A message has come since the step began.
    pub(crate) has_heard: bool,
    /// The instant of the last turn.
    now: SimTime,
}

impl Agent {
    pub(crate) fn new(world: &World, robot: usize, layout: Arc<Layout>) -> Self {
        let (values, sensors) = (layout.bounds.len(), layout.sensors.len());
        Self {
            robot,
            is_polled: world.robot(robot).spec().firmware.mode == Mode::Poll,
            pending: None,
            others: smallvec![0.0; layout.actions.len() - WHEELS],
            values: smallvec![0.0; values],
            sampled_at: smallvec![SimTime::NEVER; sensors],
            readable: smallvec![false; sensors],
            asks: false,
            has_heard: false,
            now: SimTime::ZERO,
            layout,
        }
    }

    /// The layout of its numbers.
    pub fn layout(&self) -> &Arc<Layout> {
        &self.layout
    }

    /// The last readings, 0 where none has come yet. In SI units.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether each sensor had something new in the last step.
    pub fn readable(&self) -> &[bool] {
        &self.readable
    }

    /// The age of each reading by the brain's clock, in seconds: since it was sampled, if its message has that
    /// instant, and since it came otherwise. Infinite if none has come.
    pub fn ages_s(&self) -> impl Iterator<Item = f64> {
        let age_s = |at: &SimTime| {
            if *at == SimTime::NEVER { f64::INFINITY } else { self.now.since(*at) as f64 * 1e-9 }
        };
        self.sampled_at.iter().map(age_s)
    }

    /// The instant of its last turn.
    pub fn now(&self) -> SimTime {
        self.now
    }

    /// Sends this at its next turn. Signals beyond ±1 are sent as ±1.
    ///
    /// # Errors
    /// If there are not as many signals as the robot has, or one is no number.
    pub fn act(&mut self, action: impl ExactSizeIterator<Item = f64>) -> Result<(), LearnError> {
        let names = &self.layout.actions;
        if action.len() != names.len() {
            let problem = format!(
                "has {} signals, robot `{}` takes {}: {}",
                action.len(),
                self.layout.robot,
                names.len(),
                names.join(", ")
            );
            return Err(LearnError::value("action", problem));
        }
        let mut wheels = [0.0; WHEELS];
        for (i, signal) in action.enumerate() {
            if !signal.is_finite() {
                return Err(LearnError::value(
                    format!("action[{i}]"),
                    format!("the signal for `{}` is {signal}", names[i]),
                ));
            }
            let signal = signal.clamp(-1.0, 1.0);
            match i.checked_sub(WHEELS) {
                None => wheels[i] = signal,
                Some(other) => self.others[other] = signal,
            }
        }
        self.pending = Some(wheels);
        Ok(())
    }

    /// The step begins: no message has come in it.
    pub(crate) fn begin_step(&mut self) {
        self.asks = self.is_polled;
        self.begin_stretch();
    }

    /// The same of a stretch of time without requests.
    pub(crate) fn begin_stretch(&mut self) {
        self.has_heard = false;
        self.readable.fill(false);
    }

    /// Takes what has come at a turn of its robot's.
    pub(crate) fn listen(&mut self, world: &World, turn: Turn) {
        self.now = turn.at;
        if world.has_message(self.robot) {
            self.has_heard = true;
            self.take(world);
        }
    }

    /// Takes what has come by now.
    pub(crate) fn take(&mut self, world: &World) {
        let Self { values, sampled_at, readable, .. } = self;
        let (values, sampled_at, readable) = (&mut values[..], &mut sampled_at[..], &mut readable[..]);
        let parts = world.robot(self.robot).readings().iter().zip(&self.layout.sensors);
        for ((reading, part), (sampled_at, is_readable)) in parts.zip(sampled_at.iter_mut().zip(readable)) {
            if reading.readable {
                *is_readable = true;
                *sampled_at = reading.sampled_at.unwrap_or(self.now);
                // Most sensors have one value.
                match (&mut values[part.values.clone()], &*reading.values) {
                    ([to], [value]) => *to = *value,
                    (to, values) => to.iter_mut().zip(values).for_each(|(to, value)| *to = *value),
                }
            }
        }
    }

    /// The state for a copy elsewhere.
    pub(crate) fn save(&self, commands: &RawCommands) -> SavedAgent {
        SavedAgent {
            sequence: commands.sequence(),
            sent_others: commands.others().into(),
            pending: self.pending,
            others: self.others.clone(),
            values: self.values.clone(),
            sampled_at: self.sampled_at.clone(),
            readable: self.readable.clone(),
            asks: self.asks,
            has_heard: self.has_heard,
            now: self.now,
        }
    }

    /// Becomes what was saved, if that is of such an agent.
    pub(crate) fn load(&mut self, commands: &mut RawCommands, saved: SavedAgent) -> bool {
        let fits = self.values.len() == saved.values.len()
            && self.sampled_at.len() == saved.sampled_at.len()
            && self.readable.len() == saved.readable.len()
            && self.others.len() == saved.others.len();
        if fits {
            commands.go_on(saved.sequence, &saved.sent_others);
            (self.pending, self.others, self.values) = (saved.pending, saved.others, saved.values);
            (self.sampled_at, self.readable) = (saved.sampled_at, saved.readable);
            (self.asks, self.has_heard, self.now) = (saved.asks, saved.has_heard, saved.now);
        }
        fits
    }

    /// The run is over: its readings are those that had come by then.
    pub(crate) fn end(&mut self, world: &World) {
        self.now = self.now.max(world.time());
        self.take(world);
    }

    /// The action at this turn: the command that is to be sent, or nothing. A robot that answers only when asked is
    /// asked once a step if it has not been by a command.
    pub(crate) fn choose(&mut self) -> Action {
        let asks = std::mem::take(&mut self.asks);
        match self.pending.take() {
            Some([left, right]) => {
                let signals = Some(Signals { left, right });
                Action { signals, others: self.others.to_vec(), ..Action::wait() }
            }
            None => Action { poll: asks, ..Action::wait() },
        }
    }
}

/// An agent by value. What follows from its robot is not in it.
#[derive(Serialize, Deserialize)]
pub(crate) struct SavedAgent {
    sequence: u8,
    sent_others: SmallVec<[f64; 2]>,
    pending: Option<[f64; WHEELS]>,
    others: SmallVec<[f64; 2]>,
    values: SmallVec<[f64; FEW]>,
    sampled_at: SmallVec<[SimTime; FEW]>,
    readable: SmallVec<[bool; FEW]>,
    asks: bool,
    has_heard: bool,
    now: SimTime,
}

/// Readings of so few sensors need no memory of their own, which keeps those of many worlds together.
const FEW: usize = 8;

/// An action begins with the signals of the wheels.
pub(crate) const WHEELS: usize = 2;
