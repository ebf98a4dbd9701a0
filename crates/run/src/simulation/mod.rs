//! Programs of other people's at a robot's serial ports, in simulated time: they act within ticks, at the instants at which bytes reach
//! them, and time passes only while they wait.
//!
//! A tick of the world begins; then each program runs at each instant at which something has come for it or its own wait is over, and
//! what it writes enters the cable at that instant; then the tick ends. Robots do not meet within a tick, so programs go one after the
//! other. Computing takes no simulated time, unless a price is asked for.

mod far_end;

use std::fmt;
use std::io::pipe;
use std::os::fd::OwnedFd;
use std::thread::JoinHandle;

use baudbot_brain::Brain;
use baudbot_brains::catalogue::CatalogueError;
use baudbot_program::{End, Output, Port, Price, Program, Report, Session, State};
use baudbot_sim::model::PortUse;
use baudbot_sim::{Intervention, InterventionError, Scenario, SimTime, World};

use crate::assignment::Assigned;
use crate::driven_world::{DrivenWorld, Refusal};
use crate::in_process::InProcess;
use crate::port_world::PortWorld;
use crate::programs::kept::{From, Kept};
use crate::programs::{self, BadPort, PortTask};
use far_end::{FarEnd, PortLine};

/// The programs of a run. They are killed when this is dropped.
pub struct Simulation {
    members: Vec<Member>,
}

/// A program at the ports of one robot.
struct Member {
    text: String,
    robot: usize,
    name: String,
    session: Session,
    lines: Vec<PortLine>,
    /// The instant at which it goes on at the latest.
    wake: Option<u64>,
    end: Option<(SimTime, End)>,
    /// The microcontroller is reset when the tick is over.
    has_raised: bool,
    has_bootloader: bool,
    kept: Kept,
    output: programs::Output,
    readers: Vec<JoinHandle<()>>,
}

/// A program of a run as it is now.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The robot's name.
    pub robot: String,
    /// The program's text, without `program:`.
    pub program: String,
    /// When it has ended, if it has.
    pub ended_at: Option<SimTime>,
    /// What it has cost.
    pub report: Report,
    /// What its tasks wait for; nothing if it has ended.
    pub waits: Vec<String>,
    /// The lines that it has printed and nobody has seen.
    pub unseen_lines: u64,
}

/// A program that cannot go on. Its text is a sentence, and below it what the program printed.
#[derive(Debug)]
pub struct SimulationError {
    /// The program's text.
    pub program: String,
    /// The robot's name.
    pub robot: String,
    /// The event.
    pub problem: Box<SimulationProblem>,
    /// The first and the last lines that it printed.
    pub said: Vec<String>,
}

/// A reason why a program cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SimulationProblem {
    /// The robot has no such port.
    #[error(transparent)]
    Port(#[from] BadPort),
    /// The ports cannot be opened.
    #[error("the world does not open its ports: {0}")]
    Open(#[from] InterventionError),
    /// There is no pipe for its output.
    #[error("its output has no pipe: {0}")]
    Pipe(#[from] std::io::Error),
    /// The program does something that has no simulated time, or cannot be started.
    #[error(transparent)]
    Program(#[from] baudbot_program::Error),
    /// The program has failed.
    #[error("it ended {} at {} s", Ended(*.end), .at.as_seconds())]
    Failed {
        /// The instant.
        at: SimTime,
        /// How it ended.
        end: End,
    },
}

impl Simulation {
    /// Starts the programs of a run, between two ticks of its world.
    ///
    /// # Errors
    /// If one cannot be started, or its robot has no such ports.
    pub fn start<W: PortWorld>(
        world: &mut W,
        tasks: &[PortTask],
        seed: u64,
    ) -> Result<Self, SimulationError> {
        let members = tasks.iter().map(|task| Member::start(world, task, seed)).collect::<Result<_, _>>()?;
        Ok(Self { members })
    }

    /// The programs act in a tick that has begun.
    ///
    /// # Errors
    /// If one does what it cannot do here, or ends with a failure.
    fn act<W: PortWorld>(&mut self, world: &mut W) -> Result<(), SimulationError> {
        self.members.iter_mut().try_for_each(|member| member.act(world))
    }

    /// What programs ask for that happens between two ticks: a board is reset by DTR.
    ///
    /// # Errors
    /// If the world refuses it.
    fn change<W: PortWorld>(&mut self, world: &mut W) -> Result<(), SimulationError> {
        self.members.iter_mut().try_for_each(|member| member.change(world))
    }

    /// Whether there are programs, and all of them have ended.
    pub fn is_over(&self) -> bool {
        !self.members.is_empty() && self.members.iter().all(|member| member.end.is_some())
    }

    /// The programs as they are now.
    pub fn progress(&self) -> Vec<Progress> {
        self.members.iter().map(Member::progress).collect()
    }
}

impl Member {
    fn start<W: PortWorld>(world: &mut W, task: &PortTask, seed: u64) -> Result<Self, SimulationError> {
        Self::started(world, task, seed).map_err(|problem| SimulationError {
            program: task.program.to_string(),
            robot: task.robot.clone(),
            problem: Box::new(problem),
            said: Vec::new(),
        })
    }

    fn started<W: PortWorld>(world: &mut W, task: &PortTask, seed: u64) -> Result<Self, SimulationProblem> {
        let robots = &world.world().scenario().robots;
        let unknown = || BadPort::Robot(task.robot.clone());
        let robot = robots.iter().position(|spec| spec.name == task.robot).ok_or_else(unknown)?;
        let spec = robots[robot].clone();
        let cables = task.program.cables(&spec)?;
        world.change(&Intervention::OpenPort { robot: spec.name.clone(), port_use: PortUse::Simulated })?;
        let lines = cables.iter().map(|(_, cable)| PortLine::new(world.world(), robot, *cable)).collect();
        let (kept, mut readers) = (Kept::default(), Vec::new());
        let mut output = |from| kept_output(&kept, &mut readers, (from, task.output));
        let program = Program {
            words: task.words(&spec, seed).into_iter().map(Into::into).collect(),
            folder: task.program.folder.clone(),
            ports: cables.into_iter().map(|(path, _)| Port { path }).collect(),
            seed,
            price: task.program.price_ns().map_or_else(Price::default, Price::each),
            output: output(From::StandardOutput)?,
            errors: output(From::StandardError)?,
            ..Program::default()
        };
        let session = Session::start(&program)?;
        // The ends of its pipes that are here would keep them open.
        drop(program);
        Ok(Self {
            text: task.program.to_string(),
            robot,
            name: spec.name.clone(),
            session,
            lines,
            wake: Some(0),
            end: None,
            has_raised: false,
            has_bootloader: spec.processor.bootloader_ns > 0,
            kept,
            output: task.output,
            readers,
        })
    }

    /// Runs within the tick, from one instant to the next at which there is something to do.
    fn act<W: PortWorld>(&mut self, world: &mut W) -> Result<(), SimulationError> {
        let start = world.world().time();
        let last_ns = (start + world.world().scenario().step_ns).as_ns() - 1;
        let mut now_ns = start.as_ns();
        loop {
            self.far_end(world, now_ns).pass();
            let is_due = self.wake.is_some_and(|wake| wake <= now_ns);
            if self.end.is_none() && (is_due || self.lines.iter().any(|line| line.has_come(now_ns))) {
                self.run(world, now_ns)?;
            }
            if now_ns == last_ns {
                return Ok(());
            }
            let own = self.wake.filter(|_| self.end.is_none());
            let on_its_way = self.lines.iter().filter_map(|line| line.next_ns(now_ns));
            let until_ns = own.into_iter().chain(on_its_way).min().unwrap_or(last_ns).clamp(now_ns, last_ns);
            now_ns = world.hear(self.robot, SimTime::from_ns(until_ns)).map_or(until_ns, SimTime::as_ns);
        }
    }

    fn far_end<'a, W: PortWorld>(&'a mut self, world: &'a mut W, now_ns: u64) -> FarEnd<'a, W> {
        let Self { robot, lines, has_raised, .. } = self;
        FarEnd { world, robot: *robot, now_ns, lines, has_raised }
    }

    fn run<W: PortWorld>(&mut self, world: &mut W, now_ns: u64) -> Result<(), SimulationError> {
        let Self { robot, lines, has_raised, session, .. } = self;
        let mut cables = FarEnd { world, robot: *robot, now_ns, lines, has_raised };
        match session.run(now_ns, &mut cables) {
            Ok(State::Waiting { until_ns }) => self.wake = until_ns,
            Ok(State::Ended(end)) => {
                let at = SimTime::from_ns(now_ns);
                self.end = Some((at, end));
                self.lines.iter_mut().for_each(PortLine::abandon);
                // All that had its pipes is dead, so its last lines are there.
                self.readers.drain(..).for_each(|reader| drop(reader.join()));
                if end != End::Exit(0) {
                    return Err(self.failed(SimulationProblem::Failed { at, end }));
                }
            }
            Err(error) => return Err(self.failed(error.into())),
        }
        Ok(())
    }

    fn change<W: PortWorld>(&mut self, world: &mut W) -> Result<(), SimulationError> {
        if std::mem::take(&mut self.has_raised) && self.has_bootloader && world.world().ending().is_none() {
            let reset = Intervention::ResetBoard { robot: self.name.clone() };
            world.change(&reset).map_err(|error| self.failed(error.into()))?;
        }
        Ok(())
    }

    /// The failure, with what the program has printed.
    fn failed(&mut self, problem: SimulationProblem) -> SimulationError {
        self.session.kill();
        // All that has its pipes is dead.
        self.readers.drain(..).for_each(|reader| drop(reader.join()));
        SimulationError {
            program: self.text.clone(),
            robot: self.name.clone(),
            problem: Box::new(problem),
            said: self.kept.lines(),
        }
    }

    fn progress(&self) -> Progress {
        let waits = if self.end.is_some() { Vec::new() } else { self.session.waits() };
        Progress {
            robot: self.name.clone(),
            program: self.text.clone(),
            ended_at: self.end.map(|(at, _)| at),
            report: self.session.report(),
            waits: waits.iter().map(ToString::to_string).collect(),
            unseen_lines: if self.output == programs::Output::Kept { self.kept.printed() } else { 0 },
        }
    }
}

/// A pipe for what a program prints, which a thread reads.
fn kept_output(
    kept: &Kept,
    readers: &mut Vec<JoinHandle<()>>,
    (from, output): (From, programs::Output),
) -> std::io::Result<Output> {
    let (read, write) = pipe()?;
    let kept = kept.clone();
    readers.push(std::thread::spawn(move || kept.read_here(read, from, output)));
    Ok(Output::Given(OwnedFd::from(write).into()))
}

impl std::error::Error for SimulationError {}

impl fmt::Display for SimulationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use baudbot_fields::printable::Printable;
        write!(
            f,
            "program `{}` of robot `{}`: {}",
            Printable(&self.program),
            Printable(&self.robot),
            self.problem
        )?;
        if self.said.is_empty() {
            return Ok(());
        }
        f.write_str("; it printed")?;
        self.said.iter().try_for_each(|line| write!(f, "\n  {line}"))
    }
}

/// The end of a program, in words.
struct Ended(End);

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            End::Exit(code) => write!(f, "with code {code}"),
            End::Signal(signal) => write!(f, "by signal {signal}"),
        }
    }
}

/// A brain or a program that ends a run.
#[derive(Debug)]
pub enum TickError<E> {
    /// The world has refused what a brain does.
    Brain(Refusal<E>),
    /// A program cannot go on.
    Program(SimulationError),
}

/// A reason why a run with programs is not done.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The catalogue has no such brain for a robot.
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    /// A program cannot go on.
    #[error(transparent)]
    Program(#[from] SimulationError),
}

/// The same as [`in_process::run`](crate::in_process::run), with programs at ports among the drivers.
///
/// # Errors
/// If the catalogue has no such brain for a robot, or a program cannot go on.
pub fn run(scenario: Scenario, assigned: &Assigned, mut look: impl FnMut(&World)) -> Result<World, RunError> {
    let seed = scenario.seed;
    let mut local = InProcess::with_assignments(scenario, &assigned.brains)?;
    local.world.keep_timeline(0);
    let mut programs = Simulation::start(&mut local.world, &assigned.at_ports, seed)?;
    loop {
        let ticked = tick(&mut local, &mut programs, |driven| {
            look(&driven.world);
            Ok(())
        });
        match ticked {
            Ok(true) => {}
            Ok(false) => break,
            Err(TickError::Program(error)) => return Err(error.into()),
            Err(TickError::Brain(Refusal { error, .. })) => match error {},
        }
    }
    local.world.begin();
    look(&local.world);
    Ok(local.world.into_world())
}

/// A tick: its first half, the brains' steps, the programs, `look`, and its second half. Whether the run goes on: it is over, too, when
/// all programs have ended.
///
/// # Errors
/// If the world refuses what a brain does, or that of `look`; if a program cannot go on.
pub fn tick<W: PortWorld, B: Brain>(
    driven: &mut DrivenWorld<W, B>,
    programs: &mut Simulation,
    look: impl FnOnce(&mut DrivenWorld<W, B>) -> Result<(), Refusal<W::Error>>,
) -> Result<bool, TickError<W::Error>> {
    programs.change(&mut driven.world).map_err(TickError::Program)?;
    driven.world.begin();
    driven.think().map_err(TickError::Brain)?;
    programs.act(&mut driven.world).map_err(TickError::Program)?;
    look(driven).map_err(TickError::Brain)?;
    Ok(driven.world.finish() && !programs.is_over())
}
