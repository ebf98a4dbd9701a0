use baudbot_sim::sensor::SensorKind;

use super::*;
use crate::timing::Class;

const VIEWER: &str = include_str!("../../../../viewer/src/arena/palette.ts");
const VIEWER_TIMING: &str = include_str!("../../../../viewer/src/timing/kinds.ts");

#[test]
fn only_a_color_of_the_scenario_replaces_the_default() {
    assert_eq!(own_color([128, 128, 128], rgb(WALL)), [138, 147, 163]);
    assert_eq!(own_color([200, 128, 128], rgb(WALL)), [200, 128, 128]);
}

#[test]
fn a_color_is_the_same_in_letters_and_in_levels() {
    let sensors = SensorKind::ALL.map(|kind| kind.style().color);
    for color in sensors.into_iter().chain(TRAILS).chain([INK, LAMP, BELIEF]) {
        assert_eq!(css(rgb(color)), color);
    }
    assert_eq!(rgb(MOVABLE), [200, 160, 100]);
}

/// The text between two others.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let rest = text.split_once(from).unwrap_or_else(|| panic!("no `{from}` in the viewer's palette")).1;
    rest.split_once(to).unwrap_or_else(|| panic!("no `{to}` after `{from}`")).0
}

#[test]
fn the_page_has_these_colors_in_its_light_theme() {
    let light = between(VIEWER, "LIGHT: Theme = {", "};");
    let theme = [
        ("ink", INK),
        ("frame", FRAME),
        ("wall", WALL),
        ("robot", ROBOT),
        ("body", BODY),
        ("belief", BELIEF),
        ("ghost", DEAD_RECKONING),
        ("late", LATE),
    ];
    for (name, color) in theme {
        assert_eq!(between(light, &format!("  {name}: \""), "\""), color, "{name}");
    }
    let constants =
        [("MOVER", MOVER), ("LAMP", LAMP), ("LAMP_RIM", LAMP_RIM), ("HOLLOW", HOLLOW), ("INNER", INNER)];
    for (name, color) in constants {
        assert_eq!(between(VIEWER, &format!("const {name} = \""), "\""), color, "{name}");
    }
    let fields = FIELDS.map(|color| format!("\"{color}\"")).join(", ");
    assert_eq!(between(VIEWER, "const FIELDS = [", "]"), fields);
    assert_eq!(between(VIEWER, "const MOVABLE: Rgb = ", ";"), format!("{:?}", rgb(MOVABLE)));
}

#[test]
fn the_page_has_these_colors_for_sensors_and_zones() {
    let sensors = between(VIEWER, "const HUES: Partial<Record<SensorKind, string>> = {", "};");
    let there: Vec<_> = sensors.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let key = |kind: &str| format!("[SensorKind.{}]", kind.replace('-', "_").to_uppercase());
    let own = SensorKind::ALL.into_iter().filter(|kind| kind.style().color != INNER);
    let own: Vec<_> = own.map(|kind| format!("{}: \"{}\",", key(kind.name()), kind.style().color)).collect();
    assert_eq!(there, own);
    let uses = |color: &str| between(VIEWER, "const all:", "];").contains(&format!("\"{color}\""));
    let zones = [
        ZoneUses { goal: true, ..ZoneUses::default() },
        ZoneUses { charger_w: 1.0, ..ZoneUses::default() },
        ZoneUses { slip: 1.0, ..ZoneUses::default() },
        ZoneUses { indoors: true, ..ZoneUses::default() },
    ];
    assert!(zones.iter().all(|zone| uses(zone.color())), "{VIEWER}");
}

/// Only the motors differ: their bars must read on the dark theme, too.
#[test]
fn the_page_has_these_colors_and_words_for_timing_diagrams() {
    let lines: Vec<_> = VIEWER_TIMING.lines().filter(|line| line.contains("[TimelineKind.")).collect();
    let of_chip: Vec<_> = between(VIEWER_TIMING, "export const LINES = {", "} satisfies").lines().collect();
    for class in CLASSES {
        let style = class.style();
        let ink = if style.ink == WHITE { "WHITE" } else { "DARK_INK" };
        let trouble = if style.is_trouble { ", trouble: true" } else { "" };
        let row = format!("color: \"{}\", ink: {ink}, words: \"{}\"{trouble} }},", style.color, style.words);
        let words = format!("{class:?}").replace("Down", "_Down").trim_start_matches('_').to_uppercase();
        let is_of_chip = class >= Class::Round;
        let name = if is_of_chip { words.to_lowercase() } else { format!("[TimelineKind.{words}]") };
        let there = if is_of_chip { &of_chip } else { &lines };
        assert!(there.contains(&format!("  {name}: {{ {row}").as_str()), "{name}: {row}");
    }
}

/// All classes of bars but the motors'.
const CLASSES: [Class; 20] = [
    Class::Acquire,
    Class::Measure,
    Class::Frame,
    Class::Block,
    Class::Up,
    Class::Adapter,
    Class::Port,
    Class::Think,
    Class::Down,
    Class::PortDown,
    Class::Obey,
    Class::Late,
    Class::Missed,
    Class::Lost,
    Class::Fault,
    Class::Round,
    Class::Rounds,
    Class::Convert,
    Class::Sent,
    Class::Received,
];
