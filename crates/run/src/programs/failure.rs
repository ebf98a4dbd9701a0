//! The failures of a program.

use std::fmt;
use std::process::ExitStatus;
use std::time::Duration;

use baudbot_fields::printable::Printable;

/// A program that cannot go on as a brain. Its text is a sentence, and below it what the program printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The program's text.
    pub program: String,
    /// The event.
    pub problem: Problem,
    /// The first and the last lines that it printed.
    pub said: Vec<String>,
}

/// A program's failure.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// There is no such program.
    Missing(String),
    /// The file is there, and the program named in its first line is not.
    NoInterpreter(String),
    /// The program may not be started.
    NotExecutable(String),
    /// The program cannot be started for another reason.
    NotStarted(String),
    /// The program does not hold its robots after so long.
    NotAttached {
        /// Robots that it does not hold.
        robots: Vec<String>,
        /// The time that it had.
        patience: Duration,
    },
    /// The program ended before it held its robots.
    ExitedUnattached(ExitStatus),
    /// The program ended after a run instead of doing the next one.
    NotReused(ExitStatus),
    /// The program ended before the run was over.
    Exited(ExitStatus),
    /// The program ended well, but printed an exception.
    Traceback,
    /// A robot that no brain was given is held, and one that the program was to drive is not.
    Elsewhere {
        /// The robot that is held.
        held: String,
        /// Robots that the program was started for.
        robots: Vec<String>,
    },
}

impl std::error::Error for Failure {}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "brain `{}`: {}", Printable(&self.program), self.problem)?;
        if self.said.is_empty() {
            return f.write_str(if self.problem.is_of_a_process() { "; it printed nothing" } else { "" });
        }
        f.write_str("; it printed")?;
        self.said.iter().try_for_each(|line| write!(f, "\n  {line}"))
    }
}

impl Problem {
    /// Whether there was a process, which may have printed something.
    fn is_of_a_process(&self) -> bool {
        match self {
            Self::Missing(_) | Self::NoInterpreter(_) | Self::NotExecutable(_) | Self::NotStarted(_) => false,
            Self::NotAttached { .. }
            | Self::ExitedUnattached(_)
            | Self::NotReused(_)
            | Self::Exited(_)
            | Self::Traceback
            | Self::Elsewhere { .. } => true,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(program) => write!(
                f,
                "there is no program `{}`; name one that is in PATH, or its path",
                Printable(program)
            ),
            Self::NoInterpreter(program) => write!(
                f,
                "the interpreter in the first line of `{}` does not exist; check that line, also for a Windows line ending",
                Printable(program)
            ),
            Self::NotExecutable(program) => write!(
                f,
                "`{0}` is not executable; run chmod +x on it, or name its interpreter, as in exec:python3 {0}",
                Printable(program)
            ),
            Self::NotStarted(reason) => write!(f, "cannot be started: {reason}"),
            Self::NotAttached { robots, patience } => {
                let (robots, s) = (robots.join(", "), patience.as_secs_f64());
                write!(
                    f,
                    "has not attached to {robots} within {s} s; it must attach as given by BAUDBOT_CONNECT, BAUDBOT_WORLD and BAUDBOT_ROBOT"
                )
            }
            Self::ExitedUnattached(status) => write!(f, "{} before it attached", Ended(*status)),
            Self::NotReused(status) => write!(
                f,
                "{} after a run; for many runs it reads the next one from its standard input (BAUDBOT_REUSE), else leave out `reuse = true`",
                Ended(*status)
            ),
            Self::Exited(status) => write!(f, "{} before the run was over", Ended(*status)),
            Self::Traceback => f.write_str("has driven to the end of the run, but printed an exception"),
            Self::Elsewhere { held, robots } => write!(
                f,
                "was started for {} (BAUDBOT_ROBOT), but {held} is attached, to which no brain was assigned",
                robots.join(", ")
            ),
        }
    }
}

/// The end of a process.
struct Ended(ExitStatus);

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use std::os::unix::process::ExitStatusExt;
        match (self.0.code(), self.0.signal()) {
            (Some(code), _) => write!(f, "exited with code {code}"),
            (None, Some(signal)) => write!(f, "was ended by signal {signal}"),
            (None, None) => f.write_str("ended"),
        }
    }
}
