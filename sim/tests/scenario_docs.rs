//! `docs/scenario.md` describes what the parser takes: no field is missing there, none is too many, and its
//! examples are scenarios.

use std::collections::{BTreeMap, BTreeSet};

use baudbot_sim::Scenario;

const DOCS: &str = include_str!("../../docs/scenario.md");
const SOURCES: [&str; 7] = [
    include_str!("../src/scenario/raw.rs"),
    include_str!("../src/scenario/arena.rs"),
    include_str!("../src/scenario/things.rs"),
    include_str!("../src/scenario/actuators.rs"),
    include_str!("../src/scenario/motors.rs"),
    include_str!("../src/scenario/noise.rs"),
    include_str!("../src/scenario/sensors/raw.rs"),
];

/// Which section describes which of the parser's structs.
const SECTIONS: [(&str, &str); 22] = [
    ("Scenario", "## Top level"),
    ("End", "## `[end]`"),
    ("Goal", "### `end.goal`"),
    ("Arena", "## `[arena]`"),
    ("Polygon", "### `[[arena.polygons]]`"),
    ("Circle", "### `[[arena.circles]]`"),
    ("Robot", "## `[[robots]]`"),
    ("Start", "### `robots.start`"),
    ("Body", "### `robots.body`"),
    ("Motors", "### `robots.motors`"),
    ("Common", "### `[robots.sensors.NAME]`"),
    ("RawInfrared", "#### `kind = \"ir\"`: an infra-red proximity sensor"),
    ("RawMount", "##### `mount`"),
    ("RawEncoders", "#### `kind = \"encoders\"`: a quadrature encoder on each wheel"),
    ("RawOdometer", "#### `kind = \"odometer\"`: ARSim's odometer"),
    ("RawCompass", "#### `kind = \"compass\"`"),
    ("Microcontroller", "### `robots.microcontroller`"),
    ("Firmware", "### `robots.firmware`"),
    ("Link", "### `robots.link`"),
    ("Adapter", "#### `adapter`"),
    ("Outage", "#### `outages`"),
    ("Brain", "### `robots.brain`"),
];

/// What examples of parts of a robot are parts of.
const ROBOT: &str = "[[robots]]\nname = \"alice\"\n\
     body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";

#[test]
fn every_field_is_described_in_its_section_and_nothing_else_is() {
    let mut sections: BTreeMap<_, _> = SECTIONS.into();
    for (name, fields) in items("struct ") {
        let heading = sections.remove(name).unwrap_or_else(|| panic!("`{name}` has no section"));
        let expected: BTreeSet<_> = fields.iter().filter_map(|line| field(line)).collect();
        assert_eq!(described(heading), expected, "{heading} and `struct {name}`");
    }
    assert!(sections.is_empty(), "sections of structs that are no more: {sections:?}");
}

#[test]
fn every_word_that_a_field_can_have_is_described() {
    let mut words = 0;
    for (name, variants) in items("enum ") {
        for variant in variants.iter().filter(|line| !line.starts_with('#')) {
            let word = kebab_case(variant.trim_end_matches(','));
            assert!(DOCS.contains(&format!("`\"{word}\"`")), "`{word}` of `enum {name}`");
            words += 1;
        }
    }
    assert!(words >= 12, "found only {words}");
}

#[test]
fn every_example_is_a_scenario() {
    let mut parsed = 0;
    for (info, text) in examples() {
        let toml = match info {
            "toml" => text.to_owned(),
            "toml fragment" => format!("{ROBOT}{text}"),
            _ => continue,
        };
        if let Err(error) = Scenario::parse(&toml) {
            panic!("{error} in:\n{text}");
        }
        parsed += 1;
    }
    assert!(parsed >= 6, "found only {parsed}");
}

/// The parser's structs or enums that have a body, each with the lines of it.
fn items(keyword: &str) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut items = Vec::new();
    for source in SOURCES {
        let mut lines = source.lines().map(str::trim);
        while let Some(line) = lines.next() {
            let item = line.trim_start_matches("pub(super) ").strip_prefix(keyword);
            if let Some(name) = item.and_then(|item| item.strip_suffix(" {")) {
                items.push((name, lines.by_ref().take_while(|line| *line != "}").collect()));
            }
        }
    }
    items
}

/// The name in a line `name: Type,`.
fn field(line: &'static str) -> Option<&'static str> {
    let line = line.trim_start_matches("pub(super) ");
    line.split_once(": ").map(|(name, _)| name).filter(|_| line.starts_with(|c: char| c.is_ascii_lowercase()))
}

/// The fields in the table of a section.
fn described(heading: &str) -> BTreeSet<&'static str> {
    let lines = DOCS.lines().skip_while(|line| *line != heading).skip(1);
    let section = lines.take_while(|line| !line.starts_with('#'));
    section.filter_map(|line| line.strip_prefix("| `")?.split_once('`')).map(|(name, _)| name).collect()
}

/// The blocks of code, each with what stands behind its opening fence.
fn examples() -> Vec<(&'static str, &'static str)> {
    let blocks = DOCS.split("\n```").skip(1).step_by(2);
    blocks.filter_map(|block| block.split_once('\n')).collect()
}

/// `StopRobot` becomes `stop-robot`.
fn kebab_case(name: &str) -> String {
    let mut word = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !word.is_empty() {
            word.push('-');
        }
        word.push(c.to_ascii_lowercase());
    }
    word
}
