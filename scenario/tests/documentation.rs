//! `docs/reference/scenario.md` and its companions describe what the parser takes: no field is missing there, none is too
//! many, and their examples are scenarios.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use baudbot_sim::sensor::SensorKind;

const DOCS: [&str; 3] = [
    include_str!("../../docs/reference/scenario.md"),
    include_str!("../../docs/reference/actuators.md"),
    include_str!("../../docs/reference/sensors.md"),
];

/// The files with structs and enums that are read, by the names that [`SECTIONS`] has. Sensors are found by themselves.
const SOURCES: [(&str, &str); 10] = [
    ("raw", include_str!("../src/raw.rs")),
    ("arena", include_str!("../src/arena.rs")),
    ("things", include_str!("../src/things.rs")),
    ("actuators", include_str!("../src/actuators.rs")),
    ("motors", include_str!("../src/motors.rs")),
    ("noise", include_str!("../../sim/src/sensor/noise.rs")),
    ("lookup", include_str!("../../sim/src/sensor/lookup.rs")),
    ("faults", include_str!("../src/faults.rs")),
    ("pins", include_str!("../src/pins.rs")),
    ("sensors", include_str!("../src/sensors/raw.rs")),
];

/// Which section describes which of these structs.
const SECTIONS: [(&str, &str, &str); 47] = [
    ("raw", "Scenario", "## Top level"),
    ("raw", "End", "## `[end]`"),
    ("raw", "Goal", "### `end.goal`"),
    ("raw", "Metrics", "## `[metrics]`"),
    ("arena", "RawArena", "## `[arena]`"),
    ("arena", "RawPolygon", "### `[[arena.polygons]]`"),
    ("arena", "RawCircle", "### `[[arena.circles]]`"),
    ("arena", "RawZone", "### `[[arena.zones]]`"),
    ("arena", "RawLight", "### `[[arena.lights]]`"),
    ("arena", "RawField", "### `[[arena.fields]]`"),
    ("arena", "RawSource", "#### `arena.fields.sources`"),
    ("things", "RawMover", "### `[[arena.movers]]`"),
    ("things", "RawStops", "#### `arena.movers.stops`"),
    ("things", "RawSwing", "#### `arena.movers.swing`"),
    ("things", "RawWander", "#### `arena.movers.wander`"),
    ("things", "RawMovable", "### `[[arena.movables]]`"),
    ("raw", "Robot", "## `[[robots]]`"),
    ("raw", "Start", "### `robots.start`"),
    ("raw", "Body", "### `robots.body`"),
    ("raw", "Microcontroller", "### `robots.microcontroller`"),
    ("pins", "Options", "### `robots.pins`"),
    ("pins", "Inline", "### `program`"),
    ("raw", "Firmware", "### `robots.firmware`"),
    ("raw", "Link", "### `robots.link`"),
    ("raw", "Adapter", "#### `adapter`"),
    ("raw", "Outage", "#### `outages`"),
    ("raw", "Brain", "### `robots.brain`"),
    ("faults", "RawFault", "### `[[robots.faults]]`"),
    ("motors", "RawMotors", "## `robots.motors`"),
    ("motors", "RawDcMotor", "### `kind = \"dc\"`: voltage in, torque out"),
    ("motors", "RawVelocityMotor", "### `kind = \"velocity\"`: a regulated speed"),
    ("motors", "RawServo", "### `kind = \"servo\"`: servos for continuous rotation"),
    ("motors", "RawStepper", "### `kind = \"stepper\"`: steps"),
    ("actuators", "RawTurret", "### `kind = \"turret\"`: a servo that turns sensors"),
    ("actuators", "RawLamp", "### `kind = \"lamp\"`: a lamp"),
    ("actuators", "RawSpeaker", "### `kind = \"speaker\"`: a loudspeaker"),
    ("actuators", "RawBattery", "## `robots.battery`"),
    ("sensors", "Common", "## `[robots.sensors.NAME]`"),
    ("noise", "Noise", "### `noise`"),
    ("noise", "Drift", "#### `noise.drift`"),
    ("noise", "Spikes", "#### `noise.spikes`"),
    ("noise", "Dropout", "#### `noise.dropout`"),
    ("sensors", "Clock", "### `clock`"),
    ("sensors", "Port", "### `port`"),
    ("sensors", "Place", "## Place"),
    ("sensors", "Mount", "### `mount`"),
    ("lookup", "Sheet", "#### `lookup`"),
];

/// What examples of parts of a robot are parts of.
const ROBOT: &str = "[[robots]]\nname = \"alice\"\n\
     body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";

#[test]
fn every_field_is_described_in_its_section_and_nothing_else_is() {
    let mut sections: BTreeMap<_, _> = SECTIONS.map(|(file, name, heading)| ((file, name), heading)).into();
    for Item { file, name, lines } in items("struct ") {
        let heading = sections.remove(&(file, name));
        let heading = heading.unwrap_or_else(|| panic!("`{name}` of `{file}` has no section"));
        let expected: BTreeSet<_> = lines.iter().filter_map(|line| field(line)).collect();
        assert_eq!(described(heading), expected, "{heading} and `struct {name}` of `{file}`");
    }
    assert!(sections.is_empty(), "sections of structs that are no more: {sections:?}");
}

#[test]
fn every_field_of_every_sensor_is_described_in_its_section_and_nothing_else_is() {
    let mut kinds: BTreeSet<_> = SensorKind::NAMES.into();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../sim/src/sensor");
    for file in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let Ok(source) = fs::read_to_string(&file) else { continue };
        let source = String::leak(source);
        let sheets = items_of("", source, "struct ");
        for block in source.split("\nimpl Sense for ").skip(1) {
            let constant = |start: &str| block.split_once(start).unwrap().1.split_once([';', '"']).unwrap().0;
            let (kind, sheet) = (constant("const NAME: &str = \""), constant("type Sheet = "));
            let start = format!("### `kind = \"{kind}\"`");
            let heading = DOCS.iter().flat_map(|doc| doc.lines()).find(|line| line.starts_with(&start));
            let heading = heading.unwrap_or_else(|| panic!("no section `{start}`"));
            let lines = sheets.iter().find(|item| item.name == sheet).map(|item| &item.lines[..]);
            assert!(lines.is_some() || sheet == "NoFields", "{file:?} has no `struct {sheet}`");
            let expected: BTreeSet<_> = lines.into_iter().flatten().filter_map(|line| field(line)).collect();
            assert_eq!(described_if_any(heading), expected, "{heading} and {file:?}");
            assert!(kinds.remove(kind), "{kind}");
        }
    }
    assert!(kinds.is_empty(), "not found: {kinds:?}");
}

#[test]
fn every_word_that_a_field_can_have_is_described() {
    let mut words = SensorKind::ALL.len();
    for Item { file, name, lines } in items("enum ") {
        let mut renamed = None;
        for line in lines {
            if line.starts_with(['#', '/']) {
                renamed =
                    line.split_once("(rename = \"").and_then(|(_, rest)| rest.split_once('"')).or(renamed);
                continue;
            }
            let named = renamed.take().map(|(word, _)| word.to_owned());
            let word = named.unwrap_or_else(|| kebab_case(line.trim_end_matches(',')));
            let is_described = |doc: &&str| {
                doc.contains(&format!("`\"{word}\"`")) || doc.contains(&format!("`kind = \"{word}\"`"))
            };
            assert!(DOCS.iter().any(is_described), "`{word}` of `enum {name}` of `{file}`");
            words += 1;
        }
    }
    for word in SensorKind::NAMES {
        let heading = format!("### `kind = \"{word}\"`");
        assert!(DOCS.iter().any(|doc| doc.contains(&heading)), "`{word}` has no section");
    }
    assert!(words >= 40, "found only {words}");
}

#[test]
fn every_kind_has_an_example() {
    let fragments: Vec<_> = examples().into_iter().map(|(_, text)| text).collect();
    for doc in DOCS {
        for kind in doc.lines().filter_map(|line| line.strip_prefix("### `kind = ")?.split_once('`')) {
            let line = format!("kind = {}", kind.0);
            let has_it = fragments.iter().any(|text| text.lines().any(|other| other == line));
            assert!(has_it || line == "kind = \"dc\"", "no example of `{line}`");
        }
    }
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
        if let Err(error) = baudbot_scenario::parse(&toml) {
            panic!("{error} in:\n{text}");
        }
        parsed += 1;
    }
    assert!(parsed >= 40, "found only {parsed}");
}

/// A struct or an enum of the parser.
struct Item {
    file: &'static str,
    name: &'static str,
    lines: Vec<&'static str>,
}

/// The parser's structs or enums that are read from a file and have a body.
fn items(keyword: &str) -> Vec<Item> {
    SOURCES.iter().flat_map(|(file, source)| items_of(file, source, keyword)).collect()
}

/// Those of one file. The attributes of serde for files tell them from what is only saved.
fn items_of(file: &'static str, source: &'static str, keyword: &str) -> Vec<Item> {
    let mut items = Vec::new();
    let mut lines = source.lines().map(str::trim);
    let mut is_read = false;
    while let Some(line) = lines.next() {
        let item = without_visibility(line).strip_prefix(keyword);
        if let Some(name) = item.and_then(|item| item.strip_suffix(" {")).filter(|_| is_read) {
            items.push(Item { file, name, lines: lines.by_ref().take_while(|line| *line != "}").collect() });
        }
        let is_for_files = || line.contains("deny_unknown_fields") || line.contains("rename_all");
        is_read = line.starts_with("#[") && (is_read || is_for_files());
    }
    items
}

fn without_visibility(line: &str) -> &str {
    ["pub(super) ", "pub(crate) ", "pub "].iter().find_map(|word| line.strip_prefix(word)).unwrap_or(line)
}

/// The name in a line `name: Type,`.
fn field(line: &'static str) -> Option<&'static str> {
    let line = without_visibility(line);
    line.split_once(": ").map(|(name, _)| name).filter(|_| line.starts_with(|c: char| c.is_ascii_lowercase()))
}

/// The fields in the table of a section, whose heading is there once.
fn described(heading: &str) -> BTreeSet<&'static str> {
    let names = described_if_any(heading);
    assert!(!names.is_empty(), "{heading} has no table of fields");
    names
}

fn described_if_any(heading: &str) -> BTreeSet<&'static str> {
    let docs: Vec<_> = DOCS.iter().flat_map(|doc| doc.lines()).collect();
    let headings = docs.iter().filter(|line| **line == heading).count();
    assert_eq!(headings, 1, "sections that are called {heading}");
    let lines = docs.into_iter().skip_while(|line| *line != heading).skip(1);
    let section = lines.take_while(|line| !line.starts_with('#'));
    section.filter_map(|line| line.strip_prefix("| `")?.split_once('`')).map(|(name, _)| name).collect()
}

/// The blocks of code, each with what stands behind its opening fence.
fn examples() -> Vec<(&'static str, &'static str)> {
    let blocks = DOCS.iter().flat_map(|doc| doc.split("\n```").skip(1).step_by(2));
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
