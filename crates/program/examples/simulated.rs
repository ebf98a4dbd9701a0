//! Runs a program against toy machines in simulated time: `simulated [-u] [-t] [-v] [-m MACHINE]… [-r RUNS] [-p NS] PROGRAM …`. Its
//! ports are /dev/ttySIM0 and so on. Prints, for each run, a hash of all that has happened at the port with its instants, and how fast it was.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::time::Instant;

use baudbot_program::{Port, Price, Program, Session};
use wire::{Machine, Wire};

#[path = "../tests/wire/mod.rs"]
#[allow(dead_code, unreachable_pub)]
mod wire;

fn main() {
    let mut words = std::env::args().skip(1).peekable();
    let (mut machines, mut runs, mut price) = (Vec::new(), 1, Price::default());
    let (mut is_unpinned, mut traps_clocks, mut is_logged) = (false, false, false);
    while let Some(option) = words.next_if(|word| word.starts_with('-')) {
        match option.as_str() {
            "-u" => is_unpinned = true,
            "-t" => traps_clocks = true,
            "-v" => is_logged = true,
            "-m" => machines.push(match words.next().as_deref() {
                Some("create") => Machine::Create,
                Some("echo") => Machine::Echo,
                Some("servo") => Machine::Servo,
                Some("silent") => Machine::Silent,
                Some("stream") => Machine::Stream,
                _ => Machine::Lines,
            }),
            "-r" => runs = words.next().and_then(|word| word.parse().ok()).unwrap_or(1),
            "-p" => price = Price::each(words.next().and_then(|word| word.parse().ok()).unwrap_or(1)),
            other => panic!("no such option: {other}"),
        }
    }
    if machines.is_empty() {
        machines.push(Machine::Lines);
    }
    let ports = (0..machines.len()).map(|port| Port { path: format!("/dev/ttySIM{port}") });
    let program = Program {
        words: words.map(Into::into).collect(),
        ports: ports.collect(),
        price,
        is_unpinned,
        traps_clocks,
        ..Program::default()
    };
    for _ in 0..runs {
        let began = Instant::now();
        let mut world = Wire::new(&machines);
        let mut session = match Session::start(&program) {
            Ok(session) => session,
            Err(error) => return eprintln!("{error}"),
        };
        match world.run(&mut session, 3_600_000_000_000) {
            Ok(Some(end)) => eprint!("{end:?}: "),
            Ok(None) => {
                for wait in session.waits() {
                    eprintln!("{wait}");
                }
            }
            Err(error) => eprintln!("{error}"),
        }
        if is_logged {
            world.log.iter().for_each(|(at_ns, port, event)| eprintln!("{at_ns} {port} {event:?}"));
        }
        let mut hasher = DefaultHasher::new();
        (&world.log, world.now_ns()).hash(&mut hasher);
        let (simulated, wall) = (world.now_ns() as f64 / 1e9, began.elapsed().as_secs_f64());
        let report = session.report();
        eprintln!(
            "{:016x} {simulated:.9} s in {wall:.3} s: {:.1} x, {report:?}",
            hasher.finish(),
            simulated / wall
        );
    }
}
