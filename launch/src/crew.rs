//! The programs of a run.

use std::process::ExitStatus;
use std::time::Duration;

use tokio::time::{Instant, sleep};

use crate::failure::{Failure, Problem};
use crate::process::Process;
use crate::task::Task;

/// The programs that drive robots of a world.
#[derive(Debug, Default)]
pub struct Crew {
    members: Vec<Member>,
}

#[derive(Debug)]
struct Member {
    process: Process,
    robots: Vec<String>,
}

/// A robot, and whether a brain holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// Its name.
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
        let start = |task: &Task| {
            let process = Process::start(task, connect, world, seed)?;
            Ok(Member { process, robots: task.robots.clone() })
        };
        Ok(Self { members: tasks.iter().map(start).collect::<Result<_, _>>()? })
    }

    /// Waits until each program holds its robots; `look` says which robots of the world are held.
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
                return Ok(());
            };
            if let Some(member) = self.exited() {
                return Err(self.ended(member, Problem::ExitedUnattached).await.into());
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
        loop {
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

    /// Ends the programs and all their children after the run: first they have a while to end by themselves.
    ///
    /// # Errors
    /// If one has printed an exception.
    pub async fn end(mut self) -> Result<(), Failure> {
        for member in &mut self.members {
            member.process.end(PATIENCE).await;
        }
        match self.members.iter_mut().find(|member| member.process.has_traceback()) {
            None => Ok(()),
            Some(member) => Err(member.process.failed(Problem::Traceback).await),
        }
    }
}

/// How often is looked whether programs hold their robots, and whether they are still there.
const LOOK: Duration = Duration::from_millis(5);

/// How long a program has to end by itself once its run is over.
const PATIENCE: Duration = Duration::from_secs(2);
