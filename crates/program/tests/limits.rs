//! Calls and waits that have no simulated time end the session within five seconds, with their names.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use baudbot_program::{End, Error, Output, Patience, Program, Session, State};

use crate::harness::{Compiled, processes, program, run};
use crate::wire::{Machine, Wire};

fn refusal(word: &str) -> String {
    let trouble = Compiled::new("trouble", &[]);
    let lock = trouble.path().with_extension("lock");
    let began = Instant::now();
    let outcome = run(trouble.words(&[word, lock.to_str().expect("a text")]), &[Machine::Silent]);
    assert!(began.elapsed() < Duration::from_secs(7), "{:?}", began.elapsed());
    assert!(processes(&trouble.path()).is_empty(), "nothing of it is left");
    outcome.end.expect_err("it is refused").to_string()
}

#[test]
fn calls_without_simulated_time_are_refused_by_name() {
    for (word, call) in [
        ("network", "socket(AF_INET)"),
        ("timer", "timer_create(of processor time)"),
        ("old", "a 32-bit system call"),
        ("inotify", "inotify_init"),
        ("terminal", "open(/dev/ptmx)"),
        ("unix", "connect(/run/some/where)"),
    ] {
        let text = refusal(word);
        assert!(text.starts_with(&format!("program calls {call}, which has no simulated time")), "{text}");
    }
}

#[test]
fn a_task_that_only_computes_is_named() {
    let text = refusal("spin");
    assert!(text.starts_with("program has computed for 0.") && text.contains("no system call"), "{text}");
}

#[test]
fn a_call_that_does_not_return_is_named() {
    let text = refusal("hang");
    assert!(text.starts_with("program has been in fcntl for 5."), "{text}");
}

#[test]
fn a_deadlock_is_seen_and_its_waits_are_told() {
    let trouble = Compiled::new("trouble", &[]);
    let mut world = Wire::new(&[Machine::Silent]);
    let mut session = Session::start(&trouble.words(&["deadlock"])).expect("it starts");
    assert_eq!(session.run(0, &mut world).expect("it runs"), State::Waiting { until_ns: None });
    let waits: Vec<String> = session.waits().iter().map(ToString::to_string).collect();
    assert_eq!(waits, ["task 0 of program waits in read for what another task or a port does"]);
    session.kill();
    assert_eq!(session.run(1, &mut world).expect("it is over"), State::Ended(End::Signal(9)));
    assert!(processes(&trouble.path()).is_empty());
}

#[test]
fn a_session_that_is_dropped_leaves_nothing() {
    let trouble = Compiled::new("trouble", &[]);
    let mut world = Wire::new(&[Machine::Silent]);
    let mut session = Session::start(&trouble.words(&["forks"])).expect("it starts");
    session.run(0, &mut world).expect("it runs");
    assert_eq!(processes(&trouble.path()).len(), 4);
    drop(session);
    assert!(processes(&trouble.path()).is_empty());
}

#[test]
fn a_tracer_that_is_killed_leaves_nothing() {
    // The tracer to kill is this test again, in a process of its own.
    if let Some(path) = std::env::var_os("BAUDBOT_TEST_VICTIM") {
        let words = vec![path, "forks".into()];
        let mut session = Session::start(&Program { words, ..program() }).expect("it starts");
        session.run(0, &mut Wire::new(&[Machine::Silent])).expect("it runs");
        std::thread::sleep(Duration::from_secs(60));
    }
    let trouble = Compiled::new("trouble", &[]);
    let mut tracer = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "limits::a_tracer_that_is_killed_leaves_nothing"])
        .env("BAUDBOT_TEST_VICTIM", trouble.path())
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    let wait_for = |count| {
        let began = Instant::now();
        while processes(&trouble.path()).len() != count {
            assert!(began.elapsed() < Duration::from_secs(20), "{:?}", processes(&trouble.path()));
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    wait_for(4);
    tracer.kill().expect("it is killed");
    tracer.wait().expect("it has ended");
    wait_for(0);
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let named = |words: &[&str]| {
        let words = words.iter().map(Into::into).collect();
        Session::start(&Program { words, ..program() })
            .map(|_| ())
            .expect_err("it does not start")
            .to_string()
    };
    assert_eq!(
        named(&["no-such-program"]),
        "no-such-program: there is no such program in PATH; give its path, or install it"
    );
    assert!(named(&["/no/such/program"]).contains("No such file"), "{}", named(&["/no/such/program"]));
    assert!(named(&["/etc/passwd"]).contains("Permission denied"));
    assert!(matches!(Session::start(&program()), Err(Error::NoWords)));
}

#[test]
fn an_interrupt_reaches_the_program() {
    let trouble = Compiled::new("trouble", &[]);
    let mut world = Wire::new(&[Machine::Silent]);
    let mut session = Session::start(&trouble.words(&["sleep"])).expect("it starts");
    session.run(0, &mut world).expect("it runs");
    session.interrupt(2);
    assert_eq!(session.run(1, &mut world).expect("it runs"), State::Ended(End::Signal(2)));
}

#[test]
fn output_is_where_the_caller_wants_it() {
    let (mut reader, writer) = std::io::pipe().expect("a pipe");
    let words = ["sh", "-c", "echo one; echo two >&2"].map(Into::into).to_vec();
    let program = Program {
        words,
        output: Output::Given(std::os::fd::OwnedFd::from(writer).into()),
        errors: Output::Discarded,
        patience: Patience::default(),
        ..program()
    };
    let mut session = Session::start(&program).expect("it starts");
    let end = session.run(0, &mut Wire::new(&[Machine::Silent])).expect("it runs");
    assert_eq!(end, State::Ended(End::Exit(0)));
    drop(program);
    let mut text = String::new();
    std::io::Read::read_to_string(&mut reader, &mut text).expect("a text");
    assert_eq!(text, "one\n");
}
