//! Clocks that our vDSO tells, and those that are calls, cannot be told apart.

use baudbot_program::{Price, Program};

use crate::harness::{Compiled, run};
use crate::wire::Machine;

/// Runs a program with and without our vDSO. Returns the stops with it and without.
fn compared(program: impl Fn() -> Program) -> (u64, u64) {
    let told = run(program(), &[Machine::Echo]);
    let trapped = run(Program { traps_clocks: true, ..program() }, &[Machine::Echo]);
    assert_eq!(told.lines(), trapped.lines());
    assert_eq!((&told.log, told.now_ns), (&trapped.log, trapped.now_ns));
    assert_eq!(told.report.trapped, 0, "this system lets us change the vDSO");
    let (told_stops, trapped_stops) = (told.report.stops, trapped.report.stops);
    let without_stops = |mut report: baudbot_program::Report| {
        report.stops = 0;
        report
    };
    assert_eq!(without_stops(told.report), without_stops(trapped.report));
    (told_stops, trapped_stops)
}

#[test]
fn clocks_that_are_told_in_the_process_give_the_same_answers_and_charges() {
    let programs = [Compiled::new("looks", &[]), Compiled::new("looks", &["-static"])];
    let prices = [Price::default(), Price { free_looks: 7, look_ns: 3000 }, Price::each(1000)];
    let mut saved = 0;
    for seed in 0..12 {
        for (program, price) in programs.iter().zip(prices.iter().cycle().skip(seed % 3)) {
            let words = ["/dev/ttySIM0", &seed.to_string()];
            let (told, trapped) = compared(|| Program { price: *price, ..program.words(&words) });
            assert!(told <= trapped, "{told} {trapped}");
            saved += trapped - told;
        }
    }
    assert!(saved > 5000, "{saved}");
}

/// It is a program that makes no call, for the kernel; but it is none that waits for something in a loop.
#[test]
fn a_task_that_computes_and_looks_at_a_clock_goes_on() {
    let computes = Compiled::new("trouble", &[]);
    assert_eq!(run(computes.words(&["compute"]), &[Machine::Silent]).lines(), Vec::<&str>::new());
}
