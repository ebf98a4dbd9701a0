//! `docs/scenario.md` and its companions describe what the parser takes: no field is missing there, none is too
//! many, and their examples are scenarios.

use std::collections::{BTreeMap, BTreeSet};

const DOCS: [&str; 3] = [
    include_str!("../../docs/scenario.md"),
    include_str!("../../docs/actuators.md"),
    include_str!("../../docs/sensors.md"),
];

/// The parser's files with structs and enums, by the names that [`SECTIONS`] has.
const SOURCES: [(&str, &str); 8] = [
    ("raw", include_str!("../src/raw.rs")),
    ("arena", include_str!("../src/arena.rs")),
    ("things", include_str!("../src/things.rs")),
    ("actuators", include_str!("../src/actuators.rs")),
    ("motors", include_str!("../src/motors.rs")),
    ("noise", include_str!("../src/noise.rs")),
    ("faults", include_str!("../src/faults.rs")),
    ("sensors", include_str!("../src/sensors/raw.rs")),
];

/// Which section describes which of the parser's structs.
const SECTIONS: [(&str, &str, &str); 62] = [
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
    ("noise", "RawNoise", "### `noise`"),
    ("noise", "RawDrift", "#### `noise.drift`"),
    ("noise", "RawSpikes", "#### `noise.spikes`"),
    ("noise", "RawDropout", "#### `noise.dropout`"),
    ("sensors", "Clock", "### `clock`"),
    ("sensors", "Port", "### `port`"),
    ("sensors", "Place", "## Place"),
    ("sensors", "Mount", "### `mount`"),
    ("sensors", "Infrared", "### `kind = \"ir\"`: an infra-red proximity sensor"),
    ("sensors", "VoltageRanger", "### `kind = \"ir-voltage\"`: a distance sensor with a voltage"),
    ("sensors", "Sonar", "### `kind = \"sonar\"`: ultrasound"),
    ("sensors", "Laser", "### `kind = \"laser\"`: a laser range finder"),
    ("sensors", "LineCamera", "### `kind = \"line-camera\"`: a row of an image"),
    ("sensors", "Encoders", "### `kind = \"encoders\"`: an encoder on each wheel"),
    ("sensors", "Odometer", "### `kind = \"odometer\"`: ARSim's odometer"),
    ("sensors", "Compass", "### `kind = \"compass\"`"),
    ("sensors", "Accelerometer", "### `kind = \"accelerometer\"`"),
    ("sensors", "Gyroscope", "### `kind = \"gyroscope\"`"),
    ("sensors", "Gps", "### `kind = \"gps\"`: a satellite receiver"),
    ("sensors", "Whisker", "### `kind = \"whisker\"`: a wire that feels"),
    ("sensors", "Bumper", "### `kind = \"bumper\"`: a bar on the rim"),
    ("sensors", "Photoresistor", "### `kind = \"photoresistor\"`: light as a time"),
    ("sensors", "Light", "### `kind = \"light\"`: light in lux"),
    ("sensors", "Field", "### `kind = \"field\"`: scent, temperature and the like"),
    ("sensors", "Microphone", "### `kind = \"microphone\"`"),
    ("noise", "RawLookup", "#### `lookup`"),
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
fn every_word_that_a_field_can_have_is_described() {
    let mut words = 0;
    for Item { file, name, lines } in items("enum ") {
        for variant in lines.iter().filter(|line| !line.starts_with(['#', '/'])) {
            let word = kebab_case(variant.trim_end_matches(','));
            let is_described = |doc: &&str| {
                doc.contains(&format!("`\"{word}\"`")) || doc.contains(&format!("`kind = \"{word}\"`"))
            };
            assert!(DOCS.iter().any(is_described), "`{word}` of `enum {name}` of `{file}`");
            words += 1;
        }
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
    let mut items = Vec::new();
    for (file, source) in SOURCES {
        let mut lines = source.lines().map(str::trim);
        let mut is_read = false;
        while let Some(line) = lines.next() {
            let item = line.trim_start_matches("pub(super) ").strip_prefix(keyword);
            match item.and_then(|item| item.strip_suffix(" {")) {
                Some(name) if is_read => {
                    items.push(Item {
                        file,
                        name,
                        lines: lines.by_ref().take_while(|line| *line != "}").collect(),
                    });
                }
                _ => {}
            }
            is_read =
                if line.starts_with("#[") { is_read || line.contains("serde::Deserialize") } else { false };
        }
    }
    items
}

/// The name in a line `name: Type,`.
fn field(line: &'static str) -> Option<&'static str> {
    let line = line.trim_start_matches("pub(super) ");
    line.split_once(": ").map(|(name, _)| name).filter(|_| line.starts_with(|c: char| c.is_ascii_lowercase()))
}

/// The fields in the table of a section, whose heading is there once.
fn described(heading: &str) -> BTreeSet<&'static str> {
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
