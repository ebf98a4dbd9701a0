//! The programs of a run.

use std::process::ExitStatus;
use std::time::Duration;

use tokio::time::{Instant, sleep};

use crate::programs::failure::{Failure, Problem};
use crate::programs::process::Process;
use crate::programs::processor_clock::ProcessorClock;
use crate::programs::program::Program;
use crate::programs::task::{Lifetime, Task};

/// The programs that drive robots of a world.
#[derive(Debug, Default)]
pub struct Crew {
    members: Vec<Member>,
    clock: Option<ProcessorClock>,
}

/// Processes that wait for another run.
#[derive(Debug, Default)]
pub struct Idle {
    members: Vec<Member>,
}

#[derive(Debug)]
struct Member {
    process: Process,
    program: Program,
    robots: Vec<String>,
    lifetime: Lifetime,
    /// Runs that it has done before this one.
    runs: u64,
}

/// A robot, and whether a brain holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// The robot's name.
    pub robot: String,
    /// Whether a brain holds it.
    pub held: bool,
    /// Whether it is to have a brain; one that is not is to stay without.
    pub expected: bool,
}

impl Crew {
    /// Starts the programs.
    ///
    /// # Errors
    /// If one cannot be started; the others are killed then.
    pub fn start(tasks: &[Task], connect: &str, world: &str, seed: u64) -> Result<Self, Failure> {
        let start = |task: &Task| Member::start(task, connect, world, seed);
        Ok(Self { members: tasks.iter().map(start).collect::<Result<_, _>>()?, clock: None })
    }

    /// The same, but takes processes of the same programs that wait for another run, if there are some.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub async fn start_or_reuse(
        tasks: &[Task],
        idle: &mut Idle,
        connect: &str,
        world: &str,
        seed: u64,
    ) -> Result<Self, Failure> {
        let mut crew = Self::default();
        for task in tasks {
            let waits =
                |member: &Member| task.lifetime == Lifetime::ManyRuns && member.program == task.program;
            let member = match idle.members.iter().position(waits) {
                None => Member::start(task, connect, world, seed)?,
                Some(place) => {
                    let mut member = idle.members.swap_remove(place);
                    member.robots.clone_from(&task.robots);
                    member.runs += 1;
                    member.process.give(task, connect, world, seed).await;
                    member
                }
            };
            crew.members.push(member);
        }
        Ok(crew)
    }

    /// Once these programs hold their robots the clock knows them, and all children that they have.
    #[must_use]
    pub fn timed_by(self, clock: ProcessorClock) -> Self {
        Self { clock: Some(clock), ..self }
    }

    fn tell(&self, clock: &ProcessorClock) {
        let of = |member: &Member| (member.robots.clone(), member.process.processes());
        clock.set(self.members.iter().map(of));
    }

    /// The number of earlier runs of the process that has done the most.
    pub fn earlier_runs(&self) -> u64 {
        self.members.iter().map(|member| member.runs).max().unwrap_or(0)
    }

    /// Waits until each program holds its robots; `look` returns the robots of the world, with whether they are held.
    ///
    /// # Errors
    /// If a program ends, holds another robot, or does not hold its own after `patience`; or that of `look`.
    pub async fn attached<E: From<Failure>>(
        &mut self,
        patience: Duration,
        mut look: impl AsyncFnMut() -> Result<Vec<Held>, E>,
    ) -> Result<(), E> {
        let end = Instant::now() + patience;
        loop {
            let robots = look().await?;
            let is_held = |name: &String| robots.iter().any(|robot| robot.robot == *name && robot.held);
            let Some(late) = self.members.iter().position(|member| !member.robots.iter().all(is_held)) else {
                // All that it loads is loaded, and its children are there.
                self.clock.iter().for_each(|clock| self.tell(clock));
                return Ok(());
            };
            if let Some(member) = self.exited() {
                let has_run = self.members[member].runs > 0;
                // One that ends well behind its run does not read another; one that fails has tried to.
                let problem = |status: ExitStatus| match has_run && status.success() {
                    true => Problem::NotReused(status),
                    false => Problem::ExitedUnattached(status),
                };
                return Err(self.ended(member, problem).await.into());
            }
            let member = &mut self.members[late];
            if let Some(other) = robots.iter().find(|robot| robot.held && !robot.expected) {
                let (held, robots) = (other.robot.clone(), member.robots.clone());
                return Err(member.process.failed(Problem::Elsewhere { held, robots }).await.into());
            }
            if Instant::now() > end {
                let robots = member.robots.iter().filter(|name| !is_held(name)).cloned().collect();
                return Err(member.process.failed(Problem::NotAttached { robots, patience }).await.into());
            }
            sleep(LOOK).await;
        }
    }

    /// Waits until a program has ended while its run is under way, which is a failure. If there are none it waits for ever.
    pub async fn failed(&mut self) -> Failure {
        let mut told = Instant::now();
        loop {
            if let Some(clock) = self.clock.as_ref().filter(|_| told.elapsed() > CHILDREN) {
                self.tell(clock);
                told = Instant::now();
            }
            if let Some(member) = self.exited() {
                return self.ended(member, Problem::Exited).await;
            }
            sleep(LOOK).await;
        }
    }

    /// The first program that has ended.
    fn exited(&mut self) -> Option<usize> {
        self.members.iter_mut().position(|member| !matches!(member.process.exited(), Ok(None)))
    }

    async fn ended(&mut self, member: usize, problem: impl Fn(ExitStatus) -> Problem) -> Failure {
        let process = &mut self.members[member].process;
        let problem = match process.exited() {
            Ok(status) => problem(status.unwrap_or_default()),
            Err(error) => Problem::NotStarted(error.to_string()),
        };
        process.failed(problem).await
    }

    /// Ends the programs and all their children after the run: first they have a while to end by themselves. The answer is how
    /// many lines they have printed to their standard output, without those with which baudbot's own packages end a run.
    ///
    /// # Errors
    /// If one has printed an exception.
    pub async fn end(mut self) -> Result<u64, Failure> {
        self.finish().await?;
        Ok(self.members.iter().map(|member| member.process.printed()).sum())
    }

    /// Ends them in the middle of a run, by a signal at once.
    pub async fn stop(mut self) {
        for member in &mut self.members {
            member.process.end(Duration::ZERO).await;
        }
    }

    /// The same as [`end`](Self::end), but lets those live that are for many runs.
    ///
    /// # Errors
    /// If one has printed an exception.
    pub async fn release(mut self, idle: &mut Idle) -> Result<(), Failure> {
        self.finish().await?;
        idle.members.extend(self.members.into_iter().filter(|member| member.lifetime == Lifetime::ManyRuns));
        Ok(())
    }

    /// Ends those that are for one run.
    async fn finish(&mut self) -> Result<(), Failure> {
        for member in self.members.iter_mut().filter(|member| member.lifetime == Lifetime::Run) {
            member.process.end(PATIENCE).await;
        }
        match self.members.iter_mut().find(|member| member.process.has_traceback()) {
            Some(member) => Err(member.process.failed(Problem::Traceback).await),
            None => Ok(()),
        }
    }
}

impl Idle {
    /// Ends them: first they have a while to end by themselves, as their input ends.
    pub async fn end(mut self) {
        for member in &mut self.members {
            member.process.end(PATIENCE).await;
        }
    }
}

impl Member {
    fn start(task: &Task, connect: &str, world: &str, seed: u64) -> Result<Self, Failure> {
        let process = Process::start(task, connect, world, seed)?;
        let Task { program, robots, lifetime, .. } = task.clone();
        Ok(Self { process, program, robots, lifetime, runs: 0 })
    }
}

/// The interval at which it is checked whether programs hold their robots, and whether they are still there.
const LOOK: Duration = Duration::from_millis(5);

/// The interval at which the children of programs are looked for, if their processor time is wanted.
const CHILDREN: Duration = Duration::from_secs(1);

/// The time in which a program has to end by itself once its run is over.
const PATIENCE: Duration = Duration::from_secs(2);
