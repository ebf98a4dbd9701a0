//! Programs in C, compiled and run against the toy world.

use std::fs;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::Command;

use baudbot_program::{End, Error, Output, Patience, Port, Program, Report, Session};

use crate::wire::{Event, Machine, Wire};

/// An hour: no program here takes so long.
pub(crate) const LIMIT_NS: u64 = 3_600_000_000_000;

/// A program of `tests/programs`, compiled into a folder of its own.
pub(crate) struct Compiled {
    folder: tempfile::TempDir,
}

impl Compiled {
    pub(crate) fn new(name: &str, options: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/programs/{name}.c"));
        let mut compiler = Command::new("cc");
        compiler
            .args(["-O1", "-w", "-pthread", "-o"])
            .arg(folder.path().join("program"))
            .arg(source)
            .args(options);
        assert!(compiler.status().expect("cc").success(), "{name} compiles");
        Self { folder }
    }

    pub(crate) fn path(&self) -> PathBuf {
        self.folder.path().join("program")
    }

    pub(crate) fn words(&self, words: &[&str]) -> Program {
        let first = self.path().into_os_string();
        Program { words: [first].into_iter().chain(words.iter().map(Into::into)).collect(), ..program() }
    }
}

/// The end of a program, and all that it has done.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) end: Result<Option<End>, Error>,
    pub(crate) output: String,
    pub(crate) log: Vec<(u64, usize, Event)>,
    pub(crate) report: Report,
    pub(crate) now_ns: u64,
}

impl Outcome {
    /// The output of a program that has ended well.
    pub(crate) fn lines(&self) -> Vec<&str> {
        assert!(matches!(self.end, Ok(Some(End::Exit(0)))), "{self:?}");
        self.output.lines().collect()
    }
}

/// Surroundings with one port.
pub(crate) fn program() -> Program {
    let patience = Patience { computing: std::time::Duration::from_millis(500), ..Patience::default() };
    Program { ports: vec![Port { path: "/dev/ttySIM0".to_owned() }], patience, ..Program::default() }
}

/// Runs a program to its end.
pub(crate) fn run(mut program: Program, machines: &[Machine]) -> Outcome {
    let mut file = tempfile::tempfile().expect("a file");
    program.output = Output::Given(file.try_clone().expect("a file"));
    let mut world = Wire::new(machines);
    let mut session = Session::start(&program).expect("the program starts");
    let end = world.run(&mut session, LIMIT_NS);
    let report = session.report();
    drop(session);
    let mut output = String::new();
    file.rewind().expect("a file");
    file.read_to_string(&mut output).expect("a text");
    Outcome { end, output, report, now_ns: world.now_ns(), log: world.log }
}

/// The processes of this machine whose program is this file.
pub(crate) fn processes(file: &Path) -> Vec<String> {
    let folder = fs::read_dir("/proc").expect("/proc");
    let programs = folder.filter_map(|entry| {
        let entry = entry.ok()?;
        let program = fs::read_link(entry.path().join("exe")).ok()?;
        (program == file).then(|| entry.file_name().to_string_lossy().into_owned())
    });
    programs.collect()
}
