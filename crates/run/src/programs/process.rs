//! A program that runs, with all its children.

use std::collections::BTreeMap;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use tokio::io::AsyncWriteExt;
use tokio::process::{Child, ChildStdin, Command};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::programs::failure::{Failure, Problem};
use crate::programs::kept::{From, Kept};
use crate::programs::program::Program;
use crate::programs::task::{Lifetime, Task};

/// A program that was started. When this is dropped, it and all its children are killed.
#[derive(Debug)]
pub struct Process {
    child: Child,
    /// The pipe from which it reads its next run, if it does more than one.
    runs: Option<ChildStdin>,
    /// The process group, which is that of the children, too, unless they leave it.
    group: Option<Pid>,
    /// A variable that all its descendants have in their environment, and nothing else has.
    mark: String,
    kept: Kept,
    /// The tasks that read the process's output.
    readers: Vec<JoinHandle<()>>,
    text: String,
}

impl Process {
    /// Starts the program in a group of its own, with what it needs to attach in its environment.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn start(task: &Task, connect: &str, world: &str, seed: u64) -> Result<Self, Failure> {
        let program = &task.program;
        let mark = format!("{:016x}", RandomState::new().build_hasher().finish());
        let mut command = Command::new(&program.words[0]);
        command
            .args(&program.words[1..])
            .envs(task.environment(connect, world, seed))
            .envs(&task.variables)
            .env(MARK, &mark);
        if let Some(folder) = &program.folder {
            command.current_dir(folder);
        }
        let stdin = match task.lifetime {
            Lifetime::Run => Stdio::null(),
            Lifetime::ManyRuns => Stdio::piped(),
        };
        command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped()).process_group(0);
        let spawned = command.spawn();
        let mut child = spawned.map_err(|error| not_started(program, &error))?;
        let kept = Kept::default();
        let output = task.output;
        let out =
            child.stdout.take().map(|out| tokio::spawn(kept.clone().read(out, From::StandardOutput, output)));
        let read = |errors| tokio::spawn(kept.clone().read(errors, From::StandardError, output));
        let errors = child.stderr.take().map(read);
        let readers = out.into_iter().chain(errors).collect();
        let runs = child.stdin.take();
        let group = child.id().and_then(|id| Pid::from_raw(id.cast_signed()));
        Ok(Self { child, runs, group, mark, kept, readers, text: program.to_string() })
    }

    /// Gives it another run. One that no longer reads is found out by its end.
    pub(crate) async fn give(&mut self, task: &Task, connect: &str, world: &str, seed: u64) {
        let variables: BTreeMap<_, _> = task.environment(connect, world, seed).into();
        let line = serde_json::to_string(&variables).expect("names are texts") + "\n";
        if let Some(runs) = &mut self.runs {
            // A program that reads nothing for long has no room for it at last.
            let _ = timeout(PATIENCE, runs.write_all(line.as_bytes())).await;
        }
    }

    /// The status of the program's own end, if it has ended.
    ///
    /// # Errors
    /// If the system does not say.
    pub fn exited(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// The failure, with what the program printed first and last.
    pub(crate) async fn failed(&mut self, problem: Problem) -> Failure {
        self.settle().await;
        Failure { program: self.text.clone(), problem, said: self.kept.lines() }
    }

    /// The last output of an ended program may still be in its pipes; a child of it may keep those open.
    async fn settle(&mut self) {
        for reader in &mut self.readers {
            if !reader.is_finished() {
                let _ = timeout(SETTLE, reader).await;
            }
        }
    }

    /// The process and all its descendants that live.
    pub(crate) fn processes(&self) -> Vec<Pid> {
        let marked = marked(&self.mark);
        if marked.is_empty() { self.group.into_iter().collect() } else { marked }
    }

    pub(crate) fn printed(&self) -> u64 {
        self.kept.printed()
    }

    /// The first and the last lines that it printed.
    pub fn lines(&self) -> Vec<String> {
        self.kept.lines()
    }

    pub(crate) fn has_traceback(&self) -> bool {
        self.kept.has_traceback()
    }

    /// Ends it: by itself within `patience`, or else by a signal, or else by one that cannot be ignored. Its children end, too.
    pub async fn end(&mut self, patience: Duration) {
        self.runs = None;
        if timeout(patience, self.child.wait()).await.is_err() {
            self.signal(Signal::TERM);
            let _ = timeout(PATIENCE, self.child.wait()).await;
        }
        self.kill();
        let _ = self.child.wait().await;
        self.settle().await;
    }

    fn signal(&self, signal: Signal) {
        if let Some(group) = self.group {
            let _ = kill_process_group(group, signal);
        }
    }

    /// Kills all that is left of it, also what has left its process group.
    fn kill(&self) {
        self.signal(Signal::KILL);
        // A process may fork while it is looked for, and has no environment for a moment while it becomes another program: so
        // none is left if none is found twice.
        let mut was_empty = false;
        for _ in 0..MOST_ROUNDS {
            let left = marked(&self.mark);
            if left.is_empty() && was_empty {
                return;
            }
            was_empty = left.is_empty();
            if was_empty {
                std::thread::sleep(A_MOMENT);
            }
            for process in left {
                let _ = kill_process(process, Signal::KILL);
            }
        }
    }
}

/// The reason why a program does not start.
fn not_started(program: &Program, error: &std::io::Error) -> Failure {
    let word = program.words[0].clone();
    let folder = program.folder.as_deref().unwrap_or_else(|| Path::new(""));
    let is_there = word.contains('/') && folder.join(&word).is_file();
    let problem = if error.kind() == ErrorKind::NotFound && is_there {
        Problem::NoInterpreter(word)
    } else if error.kind() == ErrorKind::NotFound {
        Problem::Missing(word)
    } else if error.kind() == ErrorKind::PermissionDenied {
        Problem::NotExecutable(word)
    } else {
        Problem::NotStarted(error.to_string())
    };
    Failure { program: program.to_string(), problem, said: Vec::new() }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The processes that have the mark in their environment. Where there is no `/proc`, only process groups are known.
fn marked(mark: &str) -> Vec<Pid> {
    let marked = format!("{MARK}={mark}");
    let Ok(processes) = std::fs::read_dir("/proc") else { return Vec::new() };
    let is_marked = |path: std::path::PathBuf| {
        let environment = std::fs::read(path.join("environ")).ok()?;
        let found = environment.split(|&byte| byte == 0).any(|one| one == marked.as_bytes());
        found.then_some(())
    };
    let of = |entry: std::fs::DirEntry| {
        let id = entry.file_name().to_str()?.parse().ok()?;
        is_marked(entry.path())?;
        Pid::from_raw(id)
    };
    processes.filter_map(|entry| of(entry.ok()?)).collect()
}

const MARK: &str = "BAUDBOT_STARTED";

/// The time that a program has after a signal.
const PATIENCE: Duration = Duration::from_secs(2);

/// The time that the end of a program's output may need through its pipe.
const SETTLE: Duration = Duration::from_millis(100);

const MOST_ROUNDS: usize = 100;

/// Longer than a process takes to become another program.
const A_MOMENT: Duration = Duration::from_millis(2);
