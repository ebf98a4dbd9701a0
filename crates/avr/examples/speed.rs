//! Simulated megahertz of a program: `cargo run --release -p baudbot-avr --example speed [FILE [SECONDS]]`.
//!
//! With simavr's harness beside it (`crates/avr/tests/simavr/speed.c`, built here if libsimavr is installed) both run the same
//! program in turns, several times, so that what else the machine does falls on both.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use baudbot_avr::{Bare, Chip, Fuses, Part, Program, Supply};

const PAIRS: usize = 5;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let file = arguments.next().map_or_else(|| folder.join("programs/compute.hex"), Into::into);
    let seconds: u64 =
        arguments.next().map_or(20, |seconds| seconds.parse().expect("a number of simulated seconds"));
    let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let program = Program::parse(Part::Atmega328P, &bytes)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let harness = harness(&folder);
    println!("{} for {seconds} simulated seconds at 16 MHz", file.display());
    for _ in 0..PAIRS {
        let ours = ours(&program, seconds);
        match harness.as_deref().map(|harness| theirs(harness, &file, seconds)) {
            Some(theirs) => {
                println!("{ours:.0} MHz; simavr {theirs:.0} MHz; {:.1} times as fast", ours / theirs);
            }
            None => println!("{ours:.0} MHz"),
        }
    }
    if let Some(harness) = harness {
        // The harness lies in the system's folder for temporary files, and need not be removed.
        std::fs::remove_file(harness).ok();
    }
}

fn ours(program: &Program, seconds: u64) -> f64 {
    let mut chip = Chip::new(program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let begun = Instant::now();
    // A millisecond at a time, as a world would.
    for millisecond in 1..=1000 * seconds {
        chip.run(16_000 * millisecond, &mut Bare);
    }
    chip.cycles() as f64 / begun.elapsed().as_secs_f64() / 1e6
}

fn theirs(harness: &Path, file: &Path, seconds: u64) -> f64 {
    let output =
        Command::new(harness).arg(file).arg(seconds.to_string()).output().expect("the harness starts");
    String::from_utf8_lossy(&output.stdout).trim().parse().expect("the harness prints megahertz")
}

fn harness(folder: &Path) -> Option<std::path::PathBuf> {
    let program = std::env::temp_dir().join(format!("simavr-speed-{}", std::process::id()));
    let built = Command::new("cc")
        .args(["-O2", "-o"])
        .arg(&program)
        .arg(folder.join("simavr/speed.c"))
        .args(["-lsimavr", "-lelf"])
        .status();
    built.is_ok_and(|status| status.success()).then_some(program)
}
