//! A server in a process of its own, which is killed.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::state::operator::Operator;
use crate::state::text;

/// A server, which does not outlive its test.
pub(crate) struct Server {
    child: Child,
    pub(crate) address: String,
    log: PathBuf,
}

impl Server {
    /// Starts a server with these arguments, and waits until it listens. `name` is that of its socket and its log.
    pub(crate) fn start(folder: &Path, name: &str, args: &[&str]) -> Self {
        Self::start_by(Command::new(env!("CARGO_BIN_EXE_baudbot")), folder, name, args)
    }

    /// The same by a command that takes the program's arguments.
    pub(crate) fn start_by(mut command: Command, folder: &Path, name: &str, args: &[&str]) -> Self {
        let beside = |end: &str| folder.with_file_name(format!("{name}.{end}"));
        let (socket, log) = (beside("sock"), beside("log"));
        let address = format!("unix:{}", text(&socket));
        let errors = File::create(&log).unwrap();
        command.args(["serve", "--listen", &address, "--viewer", "off", "--state", text(folder)]).args(args);
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(errors).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let said = lines.next().and_then(Result::ok);
        let server = Self { child, address: address.clone(), log };
        assert_eq!(said, Some(format!("listening on {address}")), "{}", server.log());
        // The later output is drained, as otherwise the pipe would fill.
        std::thread::spawn(move || lines.for_each(drop));
        server
    }

    pub(crate) fn operator(&self) -> Operator {
        Operator::new(&self.address)
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// The server's output on stderr.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap()
    }

    /// Kills it, as `kill -9` does.
    pub(crate) fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub(crate) fn signal(&self, name: &str) {
        let sent = Command::new("sh").args(["-c", &format!("kill {name} {}", self.id())]).status().unwrap();
        assert!(sent.success());
    }

    /// Waits for its end; its exit code, its stderr, and how long it took.
    pub(crate) fn end(mut self) -> (Option<i32>, String, Duration) {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return (status.code(), self.log(), start.elapsed());
            }
            assert!(start.elapsed() < Duration::from_secs(120), "the server does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
