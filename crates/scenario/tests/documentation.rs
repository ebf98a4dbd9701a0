//! `docs/reference/scenario.md` and its companions have a section and an example of each kind of sensor, and their examples are scenarios.
//! Their tables of fields are made of the schema (`xtask/tools/reference.py`), which other tests hold against the parser.

use baudbot_sim::sensor::SensorKind;

const DOCS: [&str; 3] = [
    include_str!("../../../docs/reference/scenario.md"),
    include_str!("../../../docs/reference/actuators.md"),
    include_str!("../../../docs/reference/sensors.md"),
];

/// The rest of a robot for examples of its parts.
const ROBOT: &str = "[[robots]]\nname = \"alice\"\n\
     body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";

#[test]
fn every_kind_of_sensor_has_a_section() {
    for word in SensorKind::NAMES {
        let heading = format!("### `kind = \"{word}\"`");
        assert!(DOCS.iter().any(|doc| doc.contains(&heading)), "`{word}` has no section");
    }
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

/// The blocks of code, each with what stands behind its opening fence.
fn examples() -> Vec<(&'static str, &'static str)> {
    let blocks = DOCS.iter().flat_map(|doc| doc.split("\n```").skip(1).step_by(2));
    blocks.filter_map(|block| block.split_once('\n')).collect()
}
