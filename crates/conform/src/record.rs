//! The record of a run: what the brain was told and what it said, in order.

use std::process::ExitStatus;

use baudbot_proto::v1;

/// What happened in a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record {
    /// The robots that the brain was to drive.
    pub(crate) robots: Vec<String>,
    /// The brain's streams.
    pub(crate) streams: Vec<Stream>,
    /// The end of the brain's program.
    pub(crate) end: Option<ProgramEnd>,
    /// The state of the world at the end of its run.
    pub(crate) state_hash: Option<String>,
}

/// The end of a program of which the kit knows the process.
#[derive(Clone, Debug)]
pub(crate) struct ProgramEnd {
    /// Its exit, if it came to its end by itself.
    pub(crate) status: Option<ExitStatus>,
    /// The lines that it printed.
    pub(crate) printed: Vec<String>,
}

/// One call of `Attach`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stream {
    /// The `authorization` that came with it.
    pub(crate) authorization: Option<String>,
    /// The Hello.
    pub(crate) hello: Option<v1::Hello>,
    /// The data sheets that the brain was given.
    pub(crate) welcome: Option<v1::Welcome>,
    /// What followed.
    pub(crate) events: Vec<Event>,
}

/// Something that was said.
#[derive(Clone, Debug)]
pub(crate) enum Event {
    /// A request that is not a Hello, before there was one.
    BeforeHello,
    /// A second Hello.
    SecondHello,
    /// A Step before the Welcome.
    BeforeWelcome,
    /// A Turn.
    Turn(v1::Turn),
    /// A Step.
    Step(v1::Step),
    /// A belief.
    Annotate(v1::Annotate),
    /// The world is reset: older Turns are over.
    Reset,
    /// The run is over.
    Ended,
    /// The brain has closed its side.
    Closed,
}

impl Record {
    /// The first stream.
    pub(crate) fn first(&self) -> Option<&Stream> {
        self.streams.first()
    }

    /// Whether the brain answers any Turn.
    pub(crate) fn answers(&self) -> bool {
        self.streams.iter().any(|stream| stream.steps().any(|step| step.turn != 0))
    }
}

impl Stream {
    /// The Turns.
    pub(crate) fn turns(&self) -> impl Iterator<Item = &v1::Turn> {
        self.events.iter().filter_map(|event| if let Event::Turn(turn) = event { Some(turn) } else { None })
    }

    /// The Steps.
    pub(crate) fn steps(&self) -> impl Iterator<Item = &v1::Step> {
        self.events.iter().filter_map(|event| if let Event::Step(step) = event { Some(step) } else { None })
    }

    /// All that Steps have for robots.
    pub(crate) fn parts(&self) -> impl Iterator<Item = &v1::RobotStep> {
        self.steps().flat_map(|step| &step.robots)
    }

    /// The commands.
    pub(crate) fn commands(&self) -> impl Iterator<Item = (u32, &v1::Command)> {
        self.parts().filter_map(|part| match &part.output {
            Some(v1::robot_step::Output::Command(command)) => Some((part.robot, command)),
            Some(v1::robot_step::Output::Raw(_) | v1::robot_step::Output::Poll(_)) | None => None,
        })
    }

    /// The number of the brain's outputs, of whatever kind.
    pub(crate) fn outputs(&self) -> usize {
        self.parts().filter(|part| part.output.is_some()).count()
    }

    /// Whether the brain reads and writes bytes.
    pub(crate) fn is_raw(&self) -> bool {
        self.hello.as_ref().is_some_and(|hello| hello.mode() == v1::PortMode::Raw)
    }

    /// What follows the last event of this kind.
    pub(crate) fn after(&self, is: impl Fn(&Event) -> bool) -> Option<&[Event]> {
        let place = self.events.iter().rposition(is)?;
        Some(&self.events[place + 1..])
    }
}
