//! A world and its brains in one thread: the loop of all runs whose brains are in this process.

use std::convert::Infallible;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use baudbot_brain::{Action, Belief, Body, Brain, RawCommands, Signals};
use baudbot_sim::drive::Wheels;
use baudbot_sim::{Answer, SimTime, Turn, World, Written};
use smallvec::SmallVec;

/// A world whose owner makes its ticks, one half after the other, and has the brains step in between.
pub trait LockstepWorld {
    /// The reason why an action is refused.
    type Error;

    /// The world. Within a tick it shows what brains get.
    fn world(&self) -> &World;

    /// First half of a tick.
    fn begin(&mut self);

    /// The steps of those brains that are to be asked in the tick that has begun.
    fn turns(&self) -> &[Turn];

    /// Takes what the brain of this step does.
    ///
    /// # Errors
    /// If the robot cannot do it.
    fn act(&mut self, turn: Turn, action: Action) -> Result<(), Self::Error>;

    /// Second half of a tick. Whether the run goes on.
    fn finish(&mut self) -> bool;
}

/// A world with the brains that drive its robots.
pub struct DrivenWorld<W, B> {
    /// The world.
    pub world: W,
    /// The brains by their robots' places; robots without one keep still.
    pub drivers: Vec<Option<Driver<B>>>,
}

/// A brain with its robot's data sheet, in the process of its world.
pub struct Driver<B> {
    body: Arc<Body>,
    brain: B,
}

/// An action that a world has refused.
#[derive(Debug)]
pub struct Refusal<E> {
    /// Name of the robot.
    pub robot: String,
    /// The step of its brain.
    pub turn: Turn,
    /// The reason.
    pub error: E,
}

impl<B: Brain> Driver<B> {
    /// A brain for the robot with this data sheet.
    pub fn new(body: Body, brain: B) -> Self {
        Self { body: body.into(), brain }
    }
}

impl<W: LockstepWorld, B: Brain> DrivenWorld<W, B> {
    /// The belief of the brain of the robot in this place, as observers get it.
    pub fn belief(&mut self, robot: usize) -> Option<Belief> {
        self.drivers.get_mut(robot)?.as_mut()?.brain.belief()
    }

    /// The steps of the brains, in a tick that has begun.
    ///
    /// # Errors
    /// If the world refuses what one does.
    pub fn think(&mut self) -> Result<(), Refusal<W::Error>> {
        for i in 0..self.world.turns().len() {
            let turn = self.world.turns()[i];
            if let Some(Driver { body, brain }) = self.drivers.get_mut(turn.robot).and_then(Option::as_mut) {
                let action = brain.step(&self.world.world().turn_of(turn, body));
                let refusal = |error| Refusal { robot: body.name.clone(), turn, error };
                self.world.act(turn, action).map_err(refusal)?;
            }
        }
        Ok(())
    }

    /// A tick: its first half, the brains' steps, `look`, and its second half. Whether the run goes on.
    ///
    /// # Errors
    /// If the world refuses what a brain does, or that of `look`.
    pub fn advance(
        &mut self,
        look: impl FnOnce(&mut Self) -> Result<(), Refusal<W::Error>>,
    ) -> Result<bool, Refusal<W::Error>> {
        self.world.begin();
        self.think()?;
        look(self)?;
        Ok(self.world.finish())
    }
}

/// A world without anything around it. It asks each brain at each of its steps, and takes whatever they do.
#[derive(Clone)]
pub struct BareWorld {
    world: World,
    /// The ends of the cables, by robots; `None` before a brain has written something.
    commands: Vec<Option<RawCommands>>,
    /// All that is written in this tick.
    outputs: Vec<Output>,
}

/// A brain's bytes or command, with the instant at which it is written.
#[derive(Clone)]
struct Output {
    robot: usize,
    at: SimTime,
    content: Content,
}

#[derive(Clone)]
enum Content {
    Bytes(Vec<u8>),
    /// A command with the last signals of the other actuators.
    Command {
        sequence: u8,
        wheels: Wheels,
    },
}

impl Output {
    /// The answer in the form that the world takes.
    fn answer<'a>(&'a self, commands: &'a [Option<RawCommands>]) -> Answer<'a> {
        let written = match &self.content {
            Content::Bytes(bytes) => Written::Bytes(bytes),
            Content::Command { sequence, wheels } => {
                let others = commands[self.robot].as_ref().map_or(&[][..], RawCommands::others);
                Written::Command { sequence: *sequence, wheels: *wheels, others }
            }
        };
        Answer { robot: self.robot, at: self.at, written }
    }
}

impl BareWorld {
    /// A world whose robots have been written nothing.
    pub fn new(world: World) -> Self {
        let commands = world.robots().map(|_| None).collect();
        Self { world, commands, outputs: Vec::new() }
    }

    /// The world as it is.
    pub fn into_world(self) -> World {
        self.world
    }

    /// The laptop's end of a robot's cable.
    pub fn commands(&mut self, robot: usize) -> &mut RawCommands {
        let body = || Body::from(self.world.robot(robot).spec());
        let new = || RawCommands::new(&body()).expect("a scenario is read only if its messages fit the wire");
        self.commands[robot].get_or_insert_with(new)
    }
}

impl LockstepWorld for BareWorld {
    type Error = Infallible;

    fn world(&self) -> &World {
        &self.world
    }

    fn begin(&mut self) {
        self.world.begin();
    }

    fn turns(&self) -> &[Turn] {
        self.world.turns()
    }

    fn act(&mut self, turn: Turn, action: Action) -> Result<(), Infallible> {
        let spec = self.world.robot(turn.robot).spec();
        let counted = action.operations.and_then(|operations| spec.processor.thinking_ns(operations));
        let thinking_ns = action.thinking.map(|time| time.as_nanos() as u64).or(counted);
        let at = turn.at + thinking_ns.unwrap_or(spec.thinking_ns);
        let commands = self.commands(turn.robot);
        let content = match action.signals {
            Some(Signals { left, right }) => {
                let sequence = commands.next_command(&action.others);
                Content::Command { sequence, wheels: Wheels { left, right } }
            }
            None if action.poll => Content::Bytes(commands.poll().unwrap_or_default()),
            None => Content::Bytes(commands.wait()),
        };
        self.outputs.push(Output { robot: turn.robot, at, content });
        Ok(())
    }

    fn finish(&mut self) -> bool {
        // One robot's needs no memory of its own.
        let answers: SmallVec<[_; 1]> =
            self.outputs.iter().map(|output| output.answer(&self.commands)).collect();
        self.world.finish_answers(&answers);
        drop(answers);
        self.outputs.clear();
        self.world.ending().is_none()
    }
}

impl Deref for BareWorld {
    type Target = World;

    fn deref(&self) -> &World {
        &self.world
    }
}

impl DerefMut for BareWorld {
    /// Access for what makes no difference to the run, such as how much of it is kept, and for changes between two
    /// ticks.
    fn deref_mut(&mut self) -> &mut World {
        &mut self.world
    }
}
