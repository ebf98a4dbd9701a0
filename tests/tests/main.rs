//! The whole system: servers, brains and links together. One program, since each has most of the others' code in it.

#![allow(clippy::wildcard_enum_match_arm, reason = "what a test does not expect makes it fail")]

mod animals;
mod attachment;
mod audit;
mod avoid;
mod bad_input;
mod budget;
mod by_hand;
mod cables;
mod cloning;
mod connections;
mod coverage;
mod data_sheet;
mod determinism;
mod devices;
mod exploration;
mod figures;
mod floods;
mod goldens;
mod limits;
mod localization;
mod lookahead;
mod metrics;
mod navigation;
mod page;
mod pins;
mod potential;
mod recipes;
mod recording;
mod resetting;
mod room;
mod security;
mod self_driving;
mod services;
mod shown_test;
mod slow_cables;
mod sweeper;
mod tls;
mod training;
mod trust;
mod wayfinding;
mod worlds;

/// A file that nobody names here is no test.
#[test]
fn each_file_of_tests_is_part_of_a_program() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let alone = ["main.rs", "golden_hashes.rs", "http2_attacks.rs", "pace.rs"];
    let files =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for file in files.filter(|file| file.ends_with(".rs") && !alone.contains(&&**file)) {
        let module = format!("\nmod {};\n", file.trim_end_matches(".rs"));
        assert!(include_str!("main.rs").contains(&module), "main.rs lacks:{module}");
    }
}
