//! Instants are those of the wire, to the nanosecond.

use baudbot_program::{ModemOutputs, Port, Price, Program, Session};

use crate::harness::{Compiled, LIMIT_NS, program, run};
use crate::wire::{Event, LATENCY_NS, Machine, Wire};

fn bytes_ns(baud: u64, count: u64) -> u64 {
    count * 10 * 1_000_000_000 / baud
}

#[test]
fn an_answer_comes_when_its_last_byte_does() {
    for options in [&[][..], &["-static"]] {
        let ask = Compiled::new("ask", options);
        for baud in [1200, 9600, 115_200] {
            let outcome = run(ask.words(&["/dev/ttySIM0", "3", &baud.to_string()]), &[Machine::Lines]);
            let expected = bytes_ns(baud, 5) + LATENCY_NS + bytes_ns(baud, 8);
            assert_eq!(outcome.lines(), vec![format!("{expected} OK ELLO"); 3], "{options:?} at {baud} baud");
        }
    }
}

#[test]
fn reads_wait_as_vmin_and_vtime_say() {
    let modes = Compiled::new("modes", &[]);
    let outcome = run(modes.words(&["/dev/ttySIM0"]), &[Machine::Echo]);
    let byte = bytes_ns(9600, 1);
    // An echo of n bytes is there after the first byte's way, the latency, and n bytes' way back.
    let echo = |count: u64| byte + LATENCY_NS + bytes_ns(9600, count);
    let expected = [
        "0/0:  after 0".to_owned(),
        "0/3 silent:  after 300000000".to_owned(),
        format!("0/3: a after {}", echo(1)),
        format!("3/0: abc after {}", echo(3)),
        format!("3/0 with room for 1: d after {}", echo(4) - echo(3)),
        format!("3/2 with 2 bytes: ab after {}", echo(2) + 200_000_000),
        format!("3/2 with 4 bytes: abc after {}", echo(3)),
        format!("3/2 with 1 byte there: d after {}", echo(4) - echo(3) + 200_000_000),
        "3/0 without waiting: Resource temporarily unavailable after 0".to_owned(),
        "poll: 0 after 500000000".to_owned(),
        "3/0 without waiting, with 2 bytes: ab after 0".to_owned(),
    ];
    for (line, expected) in outcome.lines().into_iter().zip(expected) {
        let (name, after_ns) = line.rsplit_once(' ').expect("a line of words");
        let (expected_name, expected_ns) = expected.rsplit_once(' ').expect("a line of words");
        let difference_ns = after_ns.parse::<u64>().map(|ns| ns.abs_diff(expected_ns.parse().unwrap_or(0)));
        // The toy world rounds each byte's instant down.
        assert!(name == expected_name && difference_ns.is_ok_and(|ns| ns <= 1), "{line} is {expected}");
    }
}

#[test]
fn a_port_is_a_terminal_with_lines_until_it_is_set() {
    let lines = Compiled::new("lines", &[]);
    let outcome = run(lines.words(&["/dev/ttySIM0"]), &[Machine::Echo]);
    let expected = ["2: 61 62", "2: 63 0a", "poll 0", "2: 78 7a", "0:", "there 2", "2: 41 0d"];
    assert_eq!(outcome.lines(), expected);
    // With ECHO, the machine's answers are sent back to it: the end of file is not.
    let sent: Vec<u8> = outcome
        .log
        .iter()
        .filter_map(|(_, _, event)| if let Event::Sent(byte) = event { Some(*byte) } else { None })
        .collect();
    assert_eq!(sent, b"abc\rxy\x7fz\x04\x04\xc1\r");
}

#[test]
fn a_drain_waits_for_the_last_byte_and_a_full_queue_for_room() {
    let drain = Compiled::new("drain", &[]);
    let outcome = run(drain.words(&["/dev/ttySIM0"]), &[Machine::Silent]);
    let all = bytes_ns(115_200, 6096);
    let room = all - bytes_ns(115_200, 4096);
    let lines = outcome.lines();
    assert_eq!(lines[1..4], ["write 0", "unsent 100", &format!("drain {}", bytes_ns(115_200, 100))]);
    let number =
        |line: &str| line.rsplit(' ').next().and_then(|word| word.parse::<u64>().ok()).expect("a number");
    assert!(number(lines[4]).abs_diff(room) <= 1, "{} is {room}", lines[4]);
    assert_eq!(number(lines[4]) + number(lines[5]), all, "the queue is empty when all is sent");
    assert_eq!(lines[6..], ["break 250000000", "lines 126", "flush 0"]);
    let breaks: Vec<_> =
        outcome.log.iter().filter(|(_, _, event)| matches!(event, Event::Break(_))).collect();
    assert_eq!(breaks[1].0 - breaks[0].0, 250_000_000, "{breaks:?}");
    let outputs: Vec<_> = outcome
        .log
        .iter()
        .filter_map(|(_, _, event)| if let Event::Outputs(outputs) = event { Some(*outputs) } else { None })
        .collect();
    let lines = |dtr, rts| ModemOutputs { dtr, rts };
    assert_eq!(
        outputs,
        [lines(true, true), lines(false, true), lines(false, false)],
        "open, TIOCMBIC, close"
    );
}

#[test]
fn threads_wait_for_each_other_and_for_time() {
    let threads = Compiled::new("threads", &[]);
    let outcome = run(threads.words(&[]), &[Machine::Silent]);
    let mut expected: Vec<(u64, String)> = (0..4u64)
        .flat_map(|worker| (1..4).map(move |turn| (turn * (10 + worker), worker)))
        .map(|(at_ms, worker)| (at_ms, format!("worker {worker} at {}", at_ms * 1_000_000)))
        .collect();
    expected.sort_by_key(|(at_ms, _)| *at_ms);
    let mut expected: Vec<String> = expected.into_iter().map(|(_, line)| line).collect();
    expected.push("-1 1 at 2039000000".to_owned());
    expected.push("joined at 2040000000".to_owned());
    assert_eq!(outcome.lines(), expected);
    assert_eq!(outcome.report.tasks_at_most, 5);
    assert!(!outcome.report.has_random_addresses, "this system allows fixed addresses");
}

#[test]
fn children_pipes_and_signals_take_the_time_that_they_should() {
    let processes = Compiled::new("processes", &[]);
    let outcome = run(processes.words(&[]), &[Machine::Silent]);
    let lines: Vec<&str> = outcome.output.lines().collect();
    let expected = [
        "300000 bytes, exit 7 at 250000000",
        "300000 bytes, exit 7 at 500000000",
        "sleep -1 1 left 3 at 2500000000",
        "pause -1 1 signal 14 at 3500000000",
        "read -1 1 signal 1 at 3600000000",
        "killed 9 at 3600000000",
        "poll 1 10 at 3650000000",
    ];
    assert_eq!(lines, expected);
    assert!(matches!(outcome.end, Ok(Some(baudbot_program::End::Exit(3)))), "{:?}", outcome.end);
    assert_eq!(outcome.now_ns, 3_900_000_000);
}

#[test]
fn timers_ring_when_they_are_due() {
    let timers = Compiled::new("timers", &["-lrt"]);
    let outcome = run(timers.words(&[]), &[Machine::Silent]);
    let expected = [
        "left 70000000 every 50000000",
        "signal 3 value 42 timer 1 at 100000000",
        "signal 3 value 42 timer 1 at 150000000",
        "signal 3 value 42 timer 1 at 200000000",
        "deleted 0",
        "thread value 7 at 1000000000",
        "late 0 at 1200000000",
        "thread value 7 at 1200000000",
        "1 rings at 1451000000",
        "1 rings at 1551000000",
        "3 rings at 1901000000",
        "poll 0 at 1921000000",
        "poll 1 at 1951000000",
        "epoll 1 at 1951000000",
        "epoll 0 at 2951000000",
        "epoll 0 at 3951000000",
        "left 100000000 every 100000000",
        "epoll 0 at 4951000000",
        "read -1 1",
    ];
    assert_eq!(outcome.lines(), expected);
    for (script, code, ended_ns) in
        [("timeout 5 sleep 100", 124, 5_000_000_000), ("timeout 5 sleep 1", 0, 1_000_000_000)]
    {
        let outcome = run(
            Program { words: ["sh", "-c", script].map(Into::into).to_vec(), ..program() },
            &[Machine::Silent],
        );
        assert!(
            matches!(outcome.end, Ok(Some(baudbot_program::End::Exit(ended))) if ended == code),
            "{outcome:?}"
        );
        assert_eq!(outcome.now_ns, ended_ns, "{script}");
    }
}

#[test]
fn the_system_s_own_tools_find_a_terminal() {
    let script = "stty -F /dev/ttySIM0 57600 raw -echo && stty -F /dev/ttySIM0 speed && test -c /dev/ttySIM0 && \
                  exec 3<>/dev/ttySIM0 && echo ELLO >&3 && head -c 8 <&3 && tty <&3 && (cd /dev; ls -d tty[SUA]*[0-9]) && ls /dev/ttyUSB0 /dev/ttyS0 2>&1 | wc -l";
    let words = ["sh", "-c", script].map(Into::into).to_vec();
    let outcome = run(Program { words, ..program() }, &[Machine::Lines]);
    assert_eq!(outcome.lines(), ["57600", "OK ELLO", "/dev/ttySIM0", "ttySIM0", "2"]);
    assert_eq!(outcome.now_ns, bytes_ns(57_600, 5) + LATENCY_NS + bytes_ns(57_600, 8));
}

#[test]
fn twenty_runs_give_one_log_under_load_too() {
    let ask = Compiled::new("ask", &[]);
    let stop = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let first = run(ask.words(&["/dev/ttySIM0"]), &[Machine::Lines]);
        for count in 1..20 {
            let is_unpinned = count % 2 == 1;
            let next = run(Program { is_unpinned, ..ask.words(&["/dev/ttySIM0"]) }, &[Machine::Lines]);
            assert_eq!((&next.log, &next.output), (&first.log, &first.output), "run {count}");
            assert_eq!(next.report, first.report);
        }
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
    });
}

#[test]
fn two_programs_live_on_one_thread() {
    let ask = Compiled::new("ask", &[]);
    let alone = run(ask.words(&["/dev/ttySIM0"]), &[Machine::Lines]);
    let start = || {
        let program = Program { output: baudbot_program::Output::Discarded, ..ask.words(&["/dev/ttySIM0"]) };
        (Session::start(&program).expect("it starts"), Wire::new(&[Machine::Lines]))
    };
    let mut pairs = [start(), start(), start()];
    for limit_ns in (10_000_000..500_000_000).step_by(10_000_000) {
        for (session, world) in &mut pairs {
            world.run(session, limit_ns).expect("it runs");
        }
    }
    for (session, world) in &mut pairs {
        world.run(session, LIMIT_NS).expect("it runs");
        assert_eq!(world.log, alone.log);
    }
}

#[test]
fn a_busy_poller_pays_for_each_look() {
    let trouble = Compiled::new("trouble", &[]);
    let free = run(trouble.words(&["poll"]), &[Machine::Silent]);
    // The C library has looked at the processor's counter before.
    assert!((900..910).contains(&free.report.charged), "{free:?}");
    assert_eq!(free.now_ns, free.report.charged * 100_000);
    let words = trouble.words(&["poll"]);
    let paid = run(Program { price: Price::each(5000), ..words }, &[Machine::Silent]);
    assert!((1000..1020).contains(&paid.report.charged), "{paid:?}");
    assert_eq!(paid.now_ns, paid.report.charged * 5000);
}

#[test]
fn a_port_may_have_any_path_and_there_may_be_several() {
    let ask = Compiled::new("ask", &[]);
    let ports = ["/dev/robot", "/run/arm/port"].map(|path| Port { path: path.to_owned() }).to_vec();
    let outcome =
        run(Program { ports, ..ask.words(&["/run/arm/../arm/port"]) }, &[Machine::Silent, Machine::Lines]);
    assert_eq!(outcome.lines().len(), 3);
    assert!(outcome.log.iter().all(|(_, port, _)| *port == 1), "{:?}", outcome.log);
}

#[test]
fn a_link_leads_to_a_port_and_other_ports_of_the_machine_are_absent() {
    let ask = Compiled::new("ask", &[]);
    let link = ask.path().with_extension("link");
    std::os::unix::fs::symlink("/dev/ttySIM0", &link).expect("a link");
    let outcome = run(ask.words(&[link.to_str().expect("a text"), "1"]), &[Machine::Lines]);
    assert_eq!(outcome.lines().len(), 1);
    let outcome = run(ask.words(&["/dev/ttyS0"]), &[Machine::Lines]);
    assert!(matches!(outcome.end, Ok(Some(baudbot_program::End::Exit(1)))), "{outcome:?}");
}
