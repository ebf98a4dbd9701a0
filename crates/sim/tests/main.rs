//! The world from outside: what robots do and sense, cables, what brains may change. One program, so that all that they share is built once;
//! what is allocated is counted for each thread.

mod adapters;
mod ages;
mod airtight;
mod answers;
mod asercom;
mod bootloader;
mod cable;
mod chip;
mod common;
mod contact;
mod coverage;
mod create;
mod cycles;
mod deviation;
mod devices;
mod devices_scenarios;
mod faults;
mod forged;
mod intervention;
mod khepera;
mod khepera_commands;
mod link;
mod lookahead;
mod memory;
mod motors;
mod named_tests;
mod nearness;
mod onboard;
mod reseed;
mod ring;
mod saved;
mod serial_ports;
mod sight;
mod statistics;
mod steady_tick;
mod timing;
mod within_ticks;
mod world;

/// A file that is not named here is no test.
#[test]
fn each_file_of_tests_is_part_of_a_program() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let files =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for file in files.filter(|file| file.ends_with(".rs") && file != "main.rs") {
        let module = format!("\nmod {};\n", file.trim_end_matches(".rs"));
        assert!(include_str!("main.rs").contains(&module), "main.rs lacks:{module}");
    }
}
