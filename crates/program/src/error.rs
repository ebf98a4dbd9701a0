//! The reasons why a program does not run in simulated time.

use std::io;
use std::time::Duration;

use thiserror::Error;

/// A reason why a program does not run in simulated time. The session has ended then: nothing of the program runs on.
#[derive(Debug, Error)]
pub enum Error {
    /// Another system or processor.
    #[error(
        "programs run in simulated time on Linux on x86-64 only; run this one in real time, at a port of `baudbot port`"
    )]
    Platform,
    /// There are no words.
    #[error("there is no program to run: give its name and arguments")]
    NoWords,
    /// A word, a variable or a path has a zero byte in it, or is no absolute path.
    #[error("{text:?}: {problem}")]
    Text {
        /// The text.
        text: String,
        /// The thing that is wrong with it.
        problem: &'static str,
    },
    /// No such program.
    #[error("{program}: there is no such program in PATH; give its path, or install it")]
    NoProgram {
        /// Its name.
        program: String,
    },
    /// The program does not start.
    #[error(
        "{program}: does not start in simulated time: {source}; its file has to be one that this user may run, and the system has to allow ptrace and seccomp"
    )]
    Start {
        /// Its name.
        program: String,
        /// The system's error.
        source: io::Error,
    },
    /// The tracer itself fails.
    #[error("{program}: {step} fails: {source}; run it in real time, at a port of `baudbot port`")]
    Tracer {
        /// The name of the task's program.
        program: String,
        /// The thing that was tried.
        step: &'static str,
        /// The system's error.
        source: io::Error,
    },
    /// A call for which there is no simulated time.
    #[error("{program} calls {call}, which has no simulated time: {remedy}")]
    Unsupported {
        /// The name of the task's program.
        program: String,
        /// The call, and the argument that matters.
        call: String,
        /// The way out.
        remedy: &'static str,
    },
    /// A task that computes and makes no call.
    #[error(
        "{program} has computed for {} s and made no system call; if it waits for another thread in a loop, let it sleep or yield; if it \
         does compute so long, raise the patience",
        .computing.as_secs_f64()
    )]
    Spinner {
        /// The name of the task's program.
        program: String,
        /// The processor time that it has had.
        computing: Duration,
    },
    /// A call that does not return.
    #[error(
        "{program} has been in {call} for {} s of wall time; simulated time stands still meanwhile; if it does take so long, raise the \
         patience",
        .wall.as_secs_f64()
    )]
    Hang {
        /// The name of the task's program.
        program: String,
        /// The call.
        call: String,
        /// The wall time.
        wall: Duration,
    },
    /// An earlier call of the session has failed.
    #[error("the program has ended by an error")]
    Over,
}
