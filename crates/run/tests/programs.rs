//! Programs that behave badly: each is reported in a sentence, and nothing of it is left.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use baudbot_run::programs::{Crew, Failure, Held, Idle, Lifetime, Problem, Program, Task};

fn task(program: &str) -> Task {
    Task::new(Program::parse(program).unwrap(), vec!["alice".to_owned()])
}

fn start(program: &str) -> Result<Crew, Failure> {
    Crew::start(&[task(program)], "unix:/nowhere", "world", 7)
}

/// No brain holds the robot that should have one, and perhaps one holds the robot that was given none.
fn robots(other: bool) -> Vec<Held> {
    let held = |robot: &str, held, expected| Held { robot: robot.to_owned(), held, expected };
    vec![held("alice", false, true), held("bob", other, false)]
}

async fn not_attached(program: &str, patience_ms: u64, other: bool) -> Failure {
    let mut crew = start(program).unwrap();
    let look = async || Ok::<_, Failure>(robots(other));
    crew.attached(Duration::from_millis(patience_ms), look).await.unwrap_err()
}

/// Processes that have this text among their arguments.
fn processes(text: &str) -> usize {
    let of = |entry: std::fs::DirEntry| {
        let arguments = std::fs::read(entry.path().join("cmdline")).ok()?;
        String::from_utf8_lossy(&arguments).contains(text).then_some(())
    };
    std::fs::read_dir("/proc").unwrap().filter_map(|entry| of(entry.ok()?)).count()
}

#[tokio::test]
async fn what_cannot_be_started_is_told() {
    let error = start("/nowhere/follow --fast").unwrap_err();
    assert_eq!(error.problem, Problem::Missing("/nowhere/follow".to_owned()));
    assert_eq!(
        error.to_string(),
        "brain `/nowhere/follow --fast`: there is no program `/nowhere/follow`; name one that is in PATH, or its path"
    );
    let error = start(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).unwrap_err();
    assert!(matches!(error.problem, Problem::NotExecutable(_)), "{error}");
}

#[tokio::test]
async fn a_program_that_ends_at_once_is_told_with_what_it_printed() {
    let error = not_attached("sh -c 'echo in vain; echo so it is >&2; exit 3'", 60_000, false).await;
    let text = error.to_string();
    assert!(text.contains("exited with code 3 before it attached; it printed\n  "), "{text}");
    assert!(text.contains("\n  in vain") && text.contains("\n  so it is"), "{text}");
    let error = not_attached("sh -c 'kill -9 $$'", 60_000, false).await.to_string();
    assert!(error.ends_with("was ended by signal 9 before it attached; it printed nothing"), "{error}");
}

#[tokio::test]
async fn a_program_that_does_not_attach_or_holds_another_robot_is_told() {
    let error = not_attached("sleep 61", 50, false).await;
    assert!(error.to_string().contains("has not attached to alice within 0.05 s"), "{error}");
    let error = not_attached("sleep 61", 60_000, true).await.to_string();
    assert!(error.contains("was started for alice (BAUDBOT_ROBOT), but bob is attached"), "{error}");
}

#[tokio::test]
async fn a_program_finds_its_task_in_its_environment() {
    let show = "sh -c 'echo $BAUDBOT_CONNECT $BAUDBOT_WORLD $BAUDBOT_ROBOT $BAUDBOT_SEED $BAUDBOT_PARAMETERS; exit 1'";
    let mut task = task(show);
    task.robots.push("bob".to_owned());
    task.parameters.insert("speed".to_owned(), 0.5.into());
    let mut crew = Crew::start(&[task], "unix:/nowhere", "world", 7).unwrap();
    let said = crew.failed().await.said;
    assert_eq!(said, ["unix:/nowhere world alice,bob 7 {\"speed\":0.5}"]);
}

#[tokio::test]
async fn a_gigabyte_of_output_stops_nobody_and_takes_no_memory() {
    // All on one pipe: nothing says in which order two of them are read.
    let program =
        "sh -c '{ head -c 1000000000 /dev/zero | tr \"\\\\0\" x; echo; echo the end; } >&2; exit 1'";
    let mut crew = start(program).unwrap();
    let failure = crew.failed().await;
    let last = failure.said.last().map(|line| line.chars().take(100).collect::<String>());
    assert_eq!(last.as_deref(), Some("the end"));
    let peak_kb = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak_kb = peak_kb.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak_kb: u64 = peak_kb.trim().trim_end_matches(" kB").parse().unwrap();
    assert!(peak_kb < 100_000, "{peak_kb} kB");
}

#[tokio::test]
async fn nothing_is_left_of_a_program_that_ignores_signals_or_has_children_that_left_it() {
    // Odd lengths of sleep are the marks by which the processes are found.
    for (program, mark) in [
        ("sh -c 'trap \"\" TERM; sleep 86413 & while :; do sleep 0.01; done'", "86413"),
        ("sh -c 'sleep 86417 & sleep 86417'", "86417"),
        ("sh -c 'setsid sleep 86419 & (sleep 86419 &) ; exec sleep 86419'", "86419"),
    ] {
        let crew = start(program).unwrap();
        let begun = Instant::now();
        while processes(mark) == 0 && begun.elapsed().as_secs() < 60 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        assert!(processes(mark) > 0, "{program}");
        crew.end().await.unwrap();
        assert_eq!(processes(mark), 0, "{program}");
    }
    // Also where a run is given up.
    drop(start("sh -c 'setsid sleep 86423 & exec sleep 86423'").unwrap());
    assert_eq!(processes("sleep86423") + processes("86423"), 0);
}

#[tokio::test]
async fn an_exception_is_a_failure_also_of_a_program_that_ends_well() {
    let program = "sh -c 'echo \"Traceback (most recent call last):\" >&2; echo \"  in step\" >&2'";
    let error = start(program).unwrap().end().await.unwrap_err();
    assert_eq!(error.problem, Problem::Traceback);
    assert!(
        error
            .to_string()
            .ends_with("printed an exception; it printed\n  Traceback (most recent call last):\n    in step"),
        "{error}"
    );
    start("true").unwrap().end().await.unwrap();
}

async fn held(crew: &mut Crew) -> Result<(), Failure> {
    let look = async || {
        let held = Held { robot: "alice".to_owned(), held: true, expected: true };
        Ok::<_, Failure>(vec![held])
    };
    crew.attached(Duration::from_secs(60), look).await
}

#[tokio::test]
async fn a_process_reads_its_further_runs_from_its_input_and_ends_with_that() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs");
    let show = format!(
        "sh -c 'echo $$ $BAUDBOT_WORLD $BAUDBOT_REUSE > {0}; while read -r line; do echo $$ \"$line\" >> {0}; done; echo end >> {0}'",
        path.display()
    );
    let task = Task { lifetime: Lifetime::ManyRuns, ..task(&show) };
    let mut idle = Idle::default();
    for (run, world) in ["one", "two", "three"].into_iter().enumerate() {
        let crew =
            Crew::start_or_reuse(std::slice::from_ref(&task), &mut idle, "unix:/nowhere", world, 7).await;
        let mut crew = crew.unwrap();
        held(&mut crew).await.unwrap();
        assert_eq!(crew.earlier_runs(), run as u64);
        crew.release(&mut idle).await.unwrap();
    }
    idle.end().await;
    let said = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<_> = said.lines().collect();
    let process = lines[0].strip_suffix(" one 1").unwrap_or_else(|| panic!("{said}"));
    assert_eq!(lines[3..], ["end"]);
    for (line, world) in lines[1..3].iter().zip(["two", "three"]) {
        let json = line.strip_prefix(&format!("{process} ")).unwrap_or_else(|| panic!("{said}"));
        let variables: BTreeMap<String, String> = serde_json::from_str(json).unwrap();
        assert_eq!((variables["BAUDBOT_WORLD"].as_str(), variables["BAUDBOT_SEED"].as_str()), (world, "7"));
    }
}

#[tokio::test]
async fn a_process_that_ends_after_its_run_is_told_when_it_is_to_do_another() {
    let task = Task { lifetime: Lifetime::ManyRuns, ..task("sh -c 'echo once; exit 0'") };
    let mut idle = Idle::default();
    let start = async |idle: &mut Idle| {
        Crew::start_or_reuse(std::slice::from_ref(&task), idle, "unix:/nowhere", "world", 7).await.unwrap()
    };
    let mut crew = start(&mut idle).await;
    held(&mut crew).await.unwrap();
    crew.release(&mut idle).await.unwrap();
    let mut crew = start(&mut idle).await;
    let look = async || Ok::<_, Failure>(robots(false));
    let error = crew.attached(Duration::from_secs(60), look).await.unwrap_err().to_string();
    assert!(error.contains("exited with code 0 after a run; for many runs it reads the next one"), "{error}");
}

#[tokio::test]
async fn a_process_that_fails_at_its_next_run_is_told_as_one_that_fails_at_its_first() {
    let task =
        Task { lifetime: Lifetime::ManyRuns, ..task("sh -c 'read -r line; echo no such speed; exit 2'") };
    let mut idle = Idle::default();
    let tasks = std::slice::from_ref(&task);
    let mut crew = Crew::start_or_reuse(tasks, &mut idle, "unix:/nowhere", "one", 7).await.unwrap();
    held(&mut crew).await.unwrap();
    crew.release(&mut idle).await.unwrap();
    let mut crew = Crew::start_or_reuse(tasks, &mut idle, "unix:/nowhere", "two", 7).await.unwrap();
    let look = async || Ok::<_, Failure>(robots(false));
    let error = crew.attached(Duration::from_secs(60), look).await.unwrap_err().to_string();
    assert!(error.contains("exited with code 2 before it attached; it printed\n  no such speed"), "{error}");
}

#[tokio::test]
async fn a_first_line_that_names_no_interpreter_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crlf.sh");
    // A process of its own writes it: a program that a test beside starts meanwhile would inherit the open file, and a
    // file that is open for writing cannot be run: it is busy.
    let written = ["-c", "printf '#!/bin/sh\\r\\necho here\\r\\n' > \"$0\" && chmod +x \"$0\""];
    assert!(std::process::Command::new("sh").args(written).arg(&path).status().unwrap().success());
    let error = start(&path.display().to_string()).unwrap_err();
    assert!(matches!(error.problem, Problem::NoInterpreter(_)), "{error}");
    assert!(error.to_string().contains("also for a Windows line ending"), "{error}");
    // Also of one that is started in its folder.
    let program = Program::parse("./crlf.sh").unwrap().in_folder(folder.path().to_owned());
    let task = Task { program, ..task("x") };
    let error = Crew::start(&[task], "unix:/nowhere", "world", 7).unwrap_err();
    assert!(matches!(error.problem, Problem::NoInterpreter(_)), "{error}");
}

#[tokio::test]
async fn a_program_is_stopped_at_once_in_the_middle_of_a_run() {
    let begun = Instant::now();
    start("sleep 62").unwrap().stop().await;
    assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
    assert_eq!(processes("sleep\u{0}62"), 0);
}
