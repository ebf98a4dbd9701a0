//! The schema takes whatever the project has of scenarios.

use std::fs;
use std::path::{Path, PathBuf};

use crate::schema::corpus::{SCHEMA, read};
use crate::schema::validator::findings;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Folders that have none of ours in them.
const OTHERS: [&str; 5] = ["target", "node_modules", ".git", ".venv", "presets"];

fn tomls(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if entry.is_dir() && !entry.is_symlink() && !OTHERS.contains(&&*name) {
            tomls(&entry, all);
        } else if name.ends_with(".toml") {
            all.push(entry);
        }
    }
}

#[test]
fn every_scenario_of_the_project_is_valid() {
    let mut files = Vec::new();
    tomls(Path::new(ROOT), &mut files);
    let mut checked = 0;
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let Ok(table) = text.parse::<toml::Table>() else { continue };
        if !table.contains_key("robots") && !table.contains_key("arena") {
            continue;
        }
        let found = findings(&SCHEMA, &read(&text));
        assert!(found.wrong.is_empty(), "{}: {:#?}", file.display(), found.wrong);
        checked += 1;
    }
    assert!(checked >= 60, "found only {checked}");
}

/// The examples of the manual are valid, also where a file that they refer to does not exist.
#[test]
fn every_example_of_the_manual_is_valid() {
    let mut checked = 0;
    for page in ["scenario", "actuators", "sensors", "firmware", "presets", "ports"] {
        let text = fs::read_to_string(format!("{ROOT}/docs/reference/{page}.md")).unwrap();
        for (info, block) in text.split("\n```").skip(1).step_by(2).filter_map(|block| block.split_once('\n'))
        {
            let robot = "[[robots]]\nname = \"alice\"\n\
                         body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
            let toml = match info {
                "toml" if block.contains("[[robots]]") => block.to_owned(),
                "toml" | "toml fragment" | "toml files" => format!("{robot}{block}"),
                _ => continue,
            };
            let found = findings(&SCHEMA, &read(&toml));
            assert!(found.wrong.is_empty(), "{page}: {:#?} in\n{block}", found.wrong);
            checked += 1;
        }
    }
    assert!(checked >= 50, "found only {checked}");
}

/// A preset fills what is required, and what is known of it is still checked.
#[test]
fn presets_fill_what_is_required() {
    let valid = [
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nwithout = [\"ir_0\"]\nsensors.ir_1.bits = 8",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nlink.preset = \"uart-9600\"\nbody.color = [1, 2, 3]",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nsensors.far = { preset = \"gp2d12\", bearing_rad = 0.0, bits = 8 }",
    ];
    for toml in valid {
        let found = findings(&SCHEMA, &read(toml));
        assert!(found.wrong.is_empty(), "{:#?} in\n{toml}", found.wrong);
        baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error} in\n{toml}"));
    }
    let wrong = [
        "[[robots]]\nname = \"a\"\npreset = \"gp2d12\"",
        "[[robots]]\npreset = \"e-puck\"",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nsensors.ir_1.bitts = 8",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nsensors.ir_1.bits = 40",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nsensors.far = { preset = \"gp2d12\", bearing_rad = 0.0, c2 = 0.0 }",
        "[[robots]]\nname = \"a\"\npreset = \"e-puck\"\nlink.preset = \"e-puck\"",
    ];
    for toml in wrong {
        assert!(!findings(&SCHEMA, &read(toml)).wrong.is_empty(), "{toml}");
        baudbot_scenario::parse(toml).expect_err(toml);
    }
}
