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
mod exchange;
mod exchanges;
mod exploration;
mod figures;
mod floods;
mod frames;
mod goldens;
mod limits;
mod localization;
mod lookahead;
mod metrics;
mod navigation;
mod page;
mod pins;
mod potential;
mod quoted;
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

use std::fs;
use std::path::Path;

/// A file that is not named is no test: where a package has one program of tests, `tests/main.rs`, that or the manifest
/// names all others.
#[test]
fn each_file_of_tests_is_part_of_a_program() {
    let entries = |folder: &Path| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut programs = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for package in ["", "crates", "viewer"].into_iter().flat_map(|around| entries(&root.join(around))) {
        let Ok(main) = fs::read_to_string(package.join("tests/main.rs")) else { continue };
        let manifest = fs::read_to_string(package.join("Cargo.toml")).unwrap();
        programs += 1;
        for path in entries(&package.join("tests")) {
            let name = path.file_stem().unwrap().to_str().unwrap();
            let is_of_tests = path.extension().is_some_and(|end| end == "rs") || path.join("mod.rs").exists();
            let is_named = main.contains(&format!("\nmod {name};\n"))
                || manifest.contains(&format!("[[test]]\nname = \"{name}\"\n"));
            assert!(!is_of_tests || name == "main" || is_named, "nobody names {}", path.display());
        }
    }
    assert!(programs > 7, "only {programs} packages have a program of tests");
}
