//! The program of the user: arguments in, text and exit codes out.

mod bags;
mod beliefs;
mod budget;
mod conform;
mod damaged;
mod devices;
mod diagrams;
mod doors;
mod export;
mod firmware;
mod fitting;
mod foxglove;
mod grading;
mod hostile;
mod list;
mod locating;
mod logs;
mod measure;
mod new;
mod otel;
mod outputs;
mod paths;
mod pins;
mod plans;
mod ports;
mod presets;
mod processes;
mod programs;
mod recordings;
mod refusals;
mod runs;
mod shards;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod simulated;
mod sweep;
mod terminal;
mod timelines;
mod tokens;
mod transcripts;
mod trust;
mod tune;
mod umbmark;
mod worst;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The program with these arguments.
fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_baudbot"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The output of the program, and its exit code.
fn said(output: Output) -> (i32, String, String) {
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("an exit code"), text(output.stdout), text(output.stderr))
}

/// Runs it to its end.
fn baudbot(args: &[&str]) -> (i32, String, String) {
    said(command(args).output().unwrap())
}

/// Runs it to its end, which must be a good one; its stdout.
fn good(args: &[&str]) -> String {
    let (code, out, err) = baudbot(args);
    assert_eq!((code, err.as_str()), (0, ""), "{args:?}");
    out
}

/// Writes a program that can be run. A process of its own does it: a program that a test beside starts meanwhile would
/// inherit the open file, and a file that is open for writing cannot be run: it is busy.
fn write_program(path: &Path, text: &str) {
    let mut writer = Command::new("sh");
    writer.args(["-c", "printf %s \"$1\" > \"$0\" && chmod +x \"$0\""]).arg(path).arg(text);
    assert!(writer.status().unwrap().success());
}

/// A program that runs meanwhile, and does not outlive its test.
struct Running(Child);

impl Running {
    fn start(args: &[&str]) -> Self {
        Self(command(args).spawn().unwrap())
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("sh").args(["-c", &format!("kill {name} {}", self.0.id())]).status().unwrap();
        assert!(sent.success());
    }

    /// The lines of its stdout up to the first that the pattern begins.
    fn lines_until(&mut self, start: &str) -> Vec<String> {
        let mut lines = Vec::new();
        let mut out = BufReader::new(self.0.stdout.as_mut().unwrap());
        loop {
            let mut line = String::new();
            assert!(out.read_line(&mut line).unwrap() > 0, "the program ended before `{start}`: {lines:?}");
            lines.push(line.trim_end().to_owned());
            if line.starts_with(start) {
                return lines;
            }
        }
    }

    /// The first line of its stderr.
    fn first_complaint(&mut self) -> String {
        let mut line = String::new();
        BufReader::new(self.0.stderr.as_mut().unwrap()).read_line(&mut line).unwrap();
        line
    }

    /// Waits for its end, but not for ever.
    fn end(mut self) -> (i32, String, String) {
        let deadline = Instant::now() + Duration::from_secs(120);
        while self.0.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "the program does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
        let (mut out, mut err) = (String::new(), String::new());
        self.0.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        self.0.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        (self.0.wait().unwrap().code().expect("an exit code"), out, err)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A place for a test's file, which is not there yet.
fn place(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}
