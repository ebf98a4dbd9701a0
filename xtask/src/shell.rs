//! Programs that sections start: what they print goes to the terminal and into a log, and Ctrl-C ends them with all that
//! they have started.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{PipeReader, PipeWriter, Read as _, Write as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::place::Place;
use crate::temporary::Temporary;

/// The time in which a program has to end after Ctrl-C.
const GRACE: Duration = Duration::from_secs(5);

/// A reason why a section fails.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// A program could not be started.
    #[error("`{program}` cannot be started: {error}")]
    Start {
        /// Its command line.
        program: String,
        /// The operating system's error.
        error: std::io::Error,
    },
    /// A program ended otherwise than it should.
    #[error("`{program}` ended with {status}")]
    Ended {
        /// Its command line.
        program: String,
        /// The status of its end.
        status: ExitStatus,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// The operating system's error.
        error: std::io::Error,
    },
    /// The section has found a fault.
    #[error("{0}")]
    Wrong(String),
    /// The structure of the code could not be measured.
    #[error(transparent)]
    House(#[from] crate::house::Error),
    /// A file of records is damaged.
    #[error(transparent)]
    Records(#[from] crate::records::Error),
    /// Something that the section cannot do without could not be had.
    #[error("{0}")]
    Missing(String),
    /// A section takes so long that it will not end.
    #[error("it was ended, as it took much longer than it should")]
    TooLong,
    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
}

impl Failure {
    /// The error of a file.
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |error| Self::File { path: path.to_owned(), error }
    }
}

/// The output of a program.
pub(crate) struct Printed {
    /// The status of its end.
    pub(crate) status: ExitStatus,
    /// Its output, with its errors if that was asked for.
    pub(crate) text: String,
}

/// The surroundings of a section's programs.
pub(crate) struct Shell {
    /// The folders.
    pub(crate) place: Place,
    log: File,
    log_path: PathBuf,
    /// When the section must have ended.
    end: Option<Instant>,
    interrupted: Arc<AtomicBool>,
    temporary: Temporary,
}

impl Shell {
    /// One that writes a log anew.
    ///
    /// # Errors
    ///
    /// The log cannot be written.
    pub(crate) fn new(place: Place, interrupted: Arc<AtomicBool>) -> Result<Self, Failure> {
        let log_path = place.target.join("test/log");
        let log = Self::log_at(&log_path)?;
        let temporary = Temporary::new().map_err(|(path, error)| Failure::File { path, error })?;
        Ok(Self { place, log, log_path, end: None, interrupted, temporary })
    }

    /// Begins another section, which may take so many seconds; the path of its log.
    ///
    /// # Errors
    ///
    /// The log cannot be written.
    pub(crate) fn begin_section(&mut self, section: &str, limit_s: u64) -> Result<PathBuf, Failure> {
        self.end = Instant::now().checked_add(Duration::from_secs(limit_s));
        self.log_path = self.place.target.join("test").join(section).with_extension("log");
        self.log = Self::log_at(&self.log_path)?;
        Ok(self.log_path.clone())
    }

    /// The output of the section so far.
    ///
    /// # Errors
    ///
    /// The log cannot be read.
    pub(crate) fn log_text(&self) -> Result<String, Failure> {
        let bytes = std::fs::read(&self.log_path).map_err(Failure::file(&self.log_path))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn log_at(path: &Path) -> Result<File, Failure> {
        let folder = path.parent().unwrap_or(path);
        std::fs::create_dir_all(folder).map_err(Failure::file(folder))?;
        File::create(path).map_err(Failure::file(path))
    }

    /// Whether Ctrl-C was pressed.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// A line for the terminal and the log.
    pub(crate) fn say(&self, line: &str) {
        println!("{line}");
        // The terminal has it; a log that is not written shows itself as soon as a program writes there.
        let _ = writeln!(&self.log, "{line}");
    }

    /// A program in the root of the repository.
    pub(crate) fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.place.root).stdin(Stdio::null());
        // Programs for root lie where other users do not look.
        let path = std::env::var("PATH").unwrap_or_default();
        command.env("PATH", format!("{path}:/usr/sbin:/sbin"));
        command.env("TMPDIR", self.temporary.path());
        command.env("INSTA_UPDATE", "no"); // A snapshot that differs is a failure, never a new file.
        // Cargo tells this program of its own package. Build scripts of C code look at that, and would run again, with all that
        // is built upon them, between a command here and the same command typed by hand.
        for (name, _) in std::env::vars_os().filter(|(name, _)| is_of_a_package(name)) {
            command.env_remove(name);
        }
        command
    }

    /// Cargo, with the versions of the lock file.
    pub(crate) fn cargo<'a>(&self, words: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = self.command("cargo");
        let mut words = words.into_iter();
        command.args(words.next()).arg("--locked").args(words);
        command
    }

    /// Runs a program, whose output is shown.
    ///
    /// # Errors
    ///
    /// It cannot be started, does not end with 0, or Ctrl-C was pressed.
    pub(crate) fn run(&self, command: Command) -> Result<(), Failure> {
        let program = words(&command);
        let status = self.status(command)?;
        if status.success() { Ok(()) } else { Err(Failure::Ended { program, status }) }
    }

    /// Runs a program, whose output is shown, to any end.
    ///
    /// # Errors
    ///
    /// It cannot be started, or Ctrl-C was pressed.
    pub(crate) fn status(&self, command: Command) -> Result<ExitStatus, Failure> {
        let program = words(&command);
        let log = self.log.try_clone().map_err(|error| Failure::Start { program: program.clone(), error })?;
        let (reader, writer) =
            std::io::pipe().map_err(|error| Failure::Start { program: program.clone(), error })?;
        let child = piped(command, &writer, &writer).map_err(|error| Failure::Start { program, error })?;
        drop(writer);
        let shown = std::thread::spawn(move || show(reader, log));
        self.wait(child, &shown)
    }

    /// Runs a program to any end, and gives its output. Its errors are part of that, or are shown.
    ///
    /// # Errors
    ///
    /// It cannot be started, or Ctrl-C was pressed.
    pub(crate) fn printed(&self, command: Command, with_errors: bool) -> Result<Printed, Failure> {
        let program = words(&command);
        let failed = |error| Failure::Start { program: program.clone(), error };
        let (mut reader, writer) = std::io::pipe().map_err(failed)?;
        let (errors, writer_of_errors) = std::io::pipe().map_err(failed)?;
        let child =
            piped(command, &writer, if with_errors { &writer } else { &writer_of_errors }).map_err(failed)?;
        drop((writer, writer_of_errors));
        let log = self.log.try_clone().map_err(failed)?;
        std::thread::spawn(move || show(errors, log));
        let read = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            // A pipe that breaks ends the text; how the program ended is told apart.
            let _ = reader.read_to_end(&mut bytes);
            bytes
        });
        let status = self.wait(child, &read)?;
        let bytes = read.join().unwrap_or_default();
        Ok(Printed { status, text: String::from_utf8_lossy(&bytes).into_owned() })
    }

    /// The output of a program that ends well.
    ///
    /// # Errors
    ///
    /// It cannot be started, does not end with 0, or Ctrl-C was pressed.
    pub(crate) fn text(&self, command: Command) -> Result<String, Failure> {
        let program = words(&command);
        let Printed { status, text } = self.printed(command, false)?;
        if status.success() {
            return Ok(text);
        }
        self.say(text.trim_end());
        Err(Failure::Ended { program, status })
    }

    /// A program that runs until it is dropped, with all that it has started.
    ///
    /// # Errors
    ///
    /// It cannot be started.
    pub(crate) fn start(&self, mut command: Command) -> Result<Running, Failure> {
        let program = words(&command);
        let child = command.process_group(0).spawn();
        Ok(Running(child.map_err(|error| Failure::Start { program, error })?))
    }

    /// Waits until something is the case.
    ///
    /// # Errors
    ///
    /// It is not the case after `seconds`, or Ctrl-C was pressed.
    pub(crate) fn until(&self, what: &str, seconds: u64, is_so: impl Fn() -> bool) -> Result<(), Failure> {
        let end = Instant::now() + Duration::from_secs(seconds);
        while !is_so() {
            if self.is_interrupted() {
                return Err(Failure::Interrupted);
            }
            if Instant::now() > end {
                return Err(Failure::Wrong(format!("{what}: not within {seconds} s")));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// Waits for a program, and for what reads its output. What it has started and left behind ends with it.
    fn wait<T>(&self, child: Child, reader: &JoinHandle<T>) -> Result<ExitStatus, Failure> {
        let mut running = Running(child);
        let mut told = None;
        let status = loop {
            match running.0.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) => {}
                Err(error) => return Err(Failure::Start { program: "wait".to_owned(), error }),
            }
            if self.is_interrupted() || self.is_too_long() {
                let since = *told.get_or_insert_with(|| {
                    running.signal(Signal::INT);
                    Instant::now()
                });
                if since.elapsed() > GRACE {
                    running.signal(Signal::KILL);
                }
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        let end = Instant::now() + Duration::from_secs(2);
        while !reader.is_finished() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(5));
        }
        running.signal(Signal::KILL);
        match told {
            None => Ok(status),
            Some(_) if self.is_interrupted() => Err(Failure::Interrupted),
            Some(_) => Err(Failure::TooLong),
        }
    }

    fn is_too_long(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() > end)
    }
}

/// A program that ends when this is dropped.
pub(crate) struct Running(Child);

impl Running {
    /// Sends a signal to it and to what it has started.
    fn signal(&self, signal: Signal) {
        if let Some(group) = i32::try_from(self.0.id()).ok().and_then(Pid::from_raw) {
            // A group that is gone needs no signal.
            let _ = kill_process_group(group, signal);
        }
    }

    /// Ends it at once, as a crash does.
    pub(crate) fn kill(mut self) {
        self.signal(Signal::KILL);
        let _ = self.0.wait(); // Only so that no zombie is left.
    }

    /// The status of its end, once it has one.
    ///
    /// # Errors
    ///
    /// It has not ended after `seconds`, or Ctrl-C was pressed.
    pub(crate) fn end(mut self, shell: &Shell, seconds: u64) -> Result<ExitStatus, Failure> {
        let end = Instant::now() + Duration::from_secs(seconds);
        loop {
            if let Ok(Some(status)) = self.0.try_wait() {
                return Ok(status);
            }
            if shell.is_interrupted() {
                return Err(Failure::Interrupted);
            }
            if Instant::now() > end {
                return Err(Failure::Wrong(format!("a program has not ended after {seconds} s")));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.signal(Signal::TERM);
        let end = Instant::now() + GRACE;
        while matches!(self.0.try_wait(), Ok(None)) && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(10));
        }
        self.signal(Signal::KILL);
        let _ = self.0.wait(); // Only so that no zombie is left.
    }
}

/// Starts a program in a group of its own, which writes into pipes. With its command its ends of them are closed, so that their
/// readers end when it does.
fn piped(mut command: Command, output: &PipeWriter, errors: &PipeWriter) -> std::io::Result<Child> {
    command.stdout(output.try_clone()?).stderr(errors.try_clone()?).process_group(0).spawn()
}

/// Shows bytes as they come, and keeps them in a log.
fn show(mut reader: PipeReader, mut log: File) {
    let mut bytes = [0; 8192];
    while let Ok(n @ 1..) = reader.read(&mut bytes) {
        // A terminal that is gone, or a full disk, must not end the program that is watched.
        let _ = std::io::stdout().write_all(&bytes[..n]).and_then(|()| std::io::stdout().flush());
        let _ = log.write_all(&bytes[..n]);
    }
}

/// Whether a variable of the environment is about the package that `cargo run` has built.
fn is_of_a_package(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    ["CARGO_PKG_", "CARGO_MANIFEST_"].iter().any(|start| name.starts_with(start))
}

/// A command line for messages, or the beginning of a long one.
fn words(command: &Command) -> String {
    const MOST: usize = 16;
    let words = || std::iter::once(command.get_program()).chain(command.get_args());
    let text = words().take(MOST).map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ");
    if words().count() > MOST { text + " …" } else { text }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    use super::{Failure, Shell};
    use crate::place::Place;

    fn shell(name: &str) -> (Shell, Arc<AtomicBool>) {
        let flag = Arc::new(AtomicBool::new(false));
        let mut place = Place::new();
        place.target = std::env::temp_dir().join(format!("xtask-{name}-{}", std::process::id()));
        (Shell::new(place, flag.clone()).unwrap(), flag)
    }

    fn sh(shell: &Shell, script: &str) -> std::process::Command {
        let mut command = shell.command("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn what_a_program_prints_is_in_the_log_and_its_code_is_told() {
        let (mut shell, _) = shell("log");
        let log = shell.begin_section("some", 100).unwrap();
        let failure = shell.run(sh(&shell, "echo out; echo err >&2; exit 3")).unwrap_err();
        assert_eq!(failure.to_string(), "`sh -c echo out; echo err >&2; exit 3` ended with exit status: 3");
        assert_eq!(std::fs::read_to_string(log).unwrap(), "out\nerr\n");
        assert_eq!(shell.text(sh(&shell, "echo only this; echo err >&2")).unwrap(), "only this\n");
        let both = shell.printed(sh(&shell, "echo one; echo two >&2; exit 1"), true).unwrap();
        assert_eq!((both.text.as_str(), both.status.code()), ("one\ntwo\n", Some(1)));
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }

    #[test]
    fn an_interrupt_ends_a_program_with_what_it_has_started() {
        let (shell, flag) = shell("interrupt");
        let marker = shell.place.target.join("marker");
        let script = format!("trap 'exit 0' INT; (sleep 1000; touch {}) & wait", marker.display());
        let interrupts = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            flag.store(true, Ordering::Relaxed);
        });
        let begin = Instant::now();
        assert!(matches!(shell.run(sh(&shell, &script)), Err(Failure::Interrupted)));
        assert!(begin.elapsed() < Duration::from_secs(100));
        interrupts.join().unwrap();
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }

    #[test]
    fn a_section_that_never_ends_is_ended() {
        let (mut shell, _) = shell("long");
        shell.begin_section("some", 0).unwrap();
        assert!(matches!(shell.run(sh(&shell, "sleep 1000")), Err(Failure::TooLong)));
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }

    #[test]
    fn a_program_that_leaves_another_behind_is_not_waited_for() {
        let (shell, _) = shell("left");
        let begin = Instant::now();
        shell.run(sh(&shell, "sleep 1000 & echo gone")).unwrap();
        assert!(begin.elapsed() < Duration::from_secs(100));
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }

    #[test]
    fn what_is_no_program_is_named() {
        let (shell, _) = shell("none");
        let failure = shell.run(shell.command("/no/such/program")).unwrap_err().to_string();
        assert!(failure.starts_with("`/no/such/program` cannot be started: "), "{failure}");
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }
}
