//! The report of a budget: plain data, with the unit in each name.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_sim::model::Writes;
use serde::Serialize;

/// A time of which the least, the usual and the most is known, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Span {
    /// The least duration.
    pub best_ns: u64,
    /// The expected time; `None` if there is none, because nothing gets through.
    pub typical_ns: Option<u64>,
    /// The greatest duration; `None` if it has no bound.
    pub worst_ns: Option<u64>,
}

/// The measured thinking time of a brain, in nanoseconds: with that a budget is computed in place of the time that
/// the scenario states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Thinking {
    /// The shortest that was measured.
    pub least_ns: u64,
    /// The median.
    pub typical_ns: u64,
    /// The longest that was measured; no bound, as another run may need longer.
    pub most_ns: u64,
}

/// A part of a control cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// The microcontroller reads the sensors that are new in the message.
    Acquisition,
    /// The microcontroller frames the message.
    Framing,
    /// The bytes of the message on the wire.
    WireUp,
    /// The message waits: for the wire, in the adapter, for a frame of USB.
    WaitUp,
    /// The message waits for the brain's step.
    Step,
    /// The brain thinks; on board it waits for the processor first.
    Thinking,
    /// The command's way down: queue, adapter and wire.
    Down,
    /// The microcontroller takes the command from its receiver and obeys it.
    Obeying,
    /// Servos wait for their next pulse.
    Actuation,
}

impl Part {
    /// All parts, in the order in which they follow each other.
    pub const ALL: [Self; 9] = [
        Self::Acquisition,
        Self::Framing,
        Self::WireUp,
        Self::WaitUp,
        Self::Step,
        Self::Thinking,
        Self::Down,
        Self::Obeying,
        Self::Actuation,
    ];

    /// The part's name for people.
    pub const fn phrase(self) -> &'static str {
        match self {
            Self::Acquisition => "reading the sensors",
            Self::Framing => "framing",
            Self::WireUp => "cable up",
            Self::WaitUp => "adapter and waiting, up",
            Self::Step => "waiting for the brain's step",
            Self::Thinking => "thinking",
            Self::Down => "cable down",
            Self::Obeying => "receiving and obeying",
            Self::Actuation => "waiting for the next pulse",
        }
    }
}

/// A row of the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// The part of the cycle.
    pub part: Part,
    /// The part's duration.
    #[serde(flatten)]
    pub span: Span,
}

/// One control cycle: from the reading of the sensors that are new in a message to the command that answers it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cycle {
    /// The cycle's parts, in their order. The typical ones are those of one cycle, so that they add up.
    pub rows: Vec<Row>,
    /// All of it.
    pub total: Span,
    /// The reason why there is no worst case, if there is none.
    pub unbounded: Option<String>,
}

/// The highest rate of something.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// The name: `exchanges`, `messages up`, `sensor front`, …
    pub what: String,
    /// The highest rate a second; `None` if nothing limits it.
    pub most_per_s: Option<f64>,
    /// The expected rate a second; `None` if that is not foretold.
    pub typical_per_s: Option<f64>,
    /// Whether this is what limits the exchanges.
    pub limits: bool,
}

/// The age of a sensor's readings at the brain's step in which they are readable, from the true instant of the
/// measurement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Age {
    /// The sensor.
    pub sensor: String,
    /// The reading's age.
    #[serde(flatten)]
    pub span: Span,
    /// The reason why there is no worst case, if there is none.
    pub unbounded: Option<String>,
}

/// The load of a resource.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Load {
    /// The name: `uplink`, `downlink`, `wire`, `processor`, `radio up`, `radio down`, `port urg`.
    pub what: String,
    /// 1 is all of it.
    pub share: f64,
}

/// Memory and operations that a brain's program has on its chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Chip {
    /// Memory for the brain's variables, in bytes, if the scenario states it.
    pub ram_bytes: Option<u64>,
    /// The part of it that the brain declares to need.
    pub brain_memory_bytes: Option<u64>,
    /// Operations that the processor does in one step Δt, if the scenario states how fast it is.
    pub operations_per_step: Option<f64>,
    /// Operations that the brain's thinking takes, if it is on board.
    pub brain_operations: Option<f64>,
}

/// Whether a robot keeps its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// A whole cycle fits into Δt, always, and nothing is overloaded.
    Keeps,
    /// The typical cycle fits, the worst does not, or has no bound.
    Sometimes,
    /// The typical cycle does not fit, or something is overloaded.
    Misses,
}

/// The cost of a remedy, the cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cost {
    /// A setting of the laptop's software.
    Setting,
    /// A setting at both ends of a cable.
    BothEnds,
    /// Another firmware.
    Firmware,
    /// The brain is asked less often.
    LongerStep,
    /// Another cable or adapter.
    Cable,
    /// Another processor.
    Processor,
    /// Another layout: a laptop on the robot, a sensor with a cable of its own.
    Layout,
    /// Something is given up.
    Loss,
}

/// A change that removes the problem: what the budget is with it was computed again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Remedy {
    /// The remedy, in words.
    pub what: String,
    /// The cost of the remedy.
    pub cost: Cost,
    /// The same as changes of the scenario, `PATH=VALUE`; empty if there is no such form.
    pub overrides: Vec<String>,
    /// The step that the robot is then held to, in nanoseconds.
    pub step_ns: u64,
    /// The whole cycle then.
    pub total: Span,
    /// The verdict then.
    pub verdict: Verdict,
}

/// The cost of one robot's control cycle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotBudget {
    /// The name of the robot.
    pub robot: String,
    /// Δt, in nanoseconds.
    pub step_ns: u64,
    /// The writing of the brain, on which all the rest depends.
    pub writes: Writes,
    /// The time within which a cycle must be over, in nanoseconds: Δt, or the deadline that the scenario states.
    pub deadline_ns: u64,
    /// Until when after the start of the run nothing happens, in nanoseconds, because a bootloader waits; no part of a cycle.
    pub starts_after_ns: u64,
    /// The cycle.
    pub cycle: Cycle,
    /// The time from the end of the cycle until a command reaches the motors, in nanoseconds: it is no part of the cycle.
    pub dead_time_ns: u64,
    /// The rates of things; the exchanges first.
    pub rates: Vec<Rate>,
    /// The ages of readings, in the order of the robot's sensors.
    pub ages: Vec<Age>,
    /// The loads of the resources.
    pub loads: Vec<Load>,
    /// Memory and operations of the chip.
    pub chip: Chip,
    /// Whether it keeps its step.
    pub verdict: Verdict,
    /// The bottleneck: the part that takes longest, or that is overloaded.
    pub bottleneck: String,
    /// The remedies, the cheapest first; none if the robot meets its deadline.
    pub remedies: Vec<Remedy>,
    /// The part that was not computed, with the reason; `None` if everything was.
    pub left_out: Option<String>,
}

/// The budget of each robot of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// In the order of their names.
    pub robots: Vec<RobotBudget>,
}

impl Thinking {
    /// The difference between the longest and the shortest.
    pub(super) const fn width_ns(self) -> u64 {
        self.most_ns.saturating_sub(self.least_ns)
    }

    /// Always the same.
    pub(super) const fn exactly(ns: u64) -> Self {
        Self { least_ns: ns, typical_ns: ns, most_ns: ns }
    }
}

impl Span {
    /// Always the same.
    pub(super) const fn exactly(ns: u64) -> Self {
        Self { best_ns: ns, typical_ns: Some(ns), worst_ns: Some(ns) }
    }

    /// The span from the least to the most, with nothing typical yet.
    pub(super) const fn between(best_ns: u64, worst_ns: Option<u64>) -> Self {
        Self { best_ns, typical_ns: None, worst_ns }
    }

    /// One after the other; what is typical of the whole is not known then.
    pub(super) fn then(self, next: Self) -> Self {
        let worst_ns = self.worst_ns.zip(next.worst_ns).map(|(a, b)| a.saturating_add(b));
        Self::between(self.best_ns.saturating_add(next.best_ns), worst_ns)
    }
}
