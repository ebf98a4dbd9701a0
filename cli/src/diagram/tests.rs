//! Diagrams of made-up events, parsed as XML.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use baudbot_plot::timing::Class;

use super::record::{Place, Wanted};
use super::ticks::{View, ticks};
use super::{demo, meaning, picture, table};

const STEP_NS: u64 = 10_000_000;

/// All text of a picture.
fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{error} in\n{svg}"));
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.filter_map(|node| node.text().map(str::to_owned)).collect()
}

/// Left end, width and colour of the rectangles with this title.
fn rectangles(svg: &str, title: &str) -> Vec<(f64, f64, String)> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let is_it = |node: &roxmltree::Node<'_, '_>| {
        node.children().any(|child| child.has_tag_name("title") && child.text() == Some(title))
    };
    let groups = document.descendants().filter(|node| node.has_tag_name("g") && is_it(node));
    let rectangles = groups.flat_map(|group| group.children()).filter(|node| node.has_tag_name("rect"));
    let rectangles = rectangles.filter(|node| node.attribute("fill") != Some("#ffffff"));
    let number = |node: &roxmltree::Node<'_, '_>, name| node.attribute(name).unwrap().parse::<f64>().unwrap();
    rectangles
        .map(|node| (number(&node, "x"), number(&node, "width"), node.attribute("fill").unwrap().to_owned()))
        .collect()
}

fn of_wander(place: Place) -> String {
    let (scenario, events) = demo::wander(0, 8);
    let robot = &scenario.robots[0];
    let wanted = Wanted { place, span_ns: None };
    let kept = demo::kept(robot, events);
    let window = wanted.window(robot, &kept, scenario.step_ns);
    picture("wander", (scenario.step_ns, robot), (&kept, None, &BTreeMap::new()), &window).draw()
}

#[test]
fn every_part_of_the_robot_has_its_lane_and_bars_have_names() {
    let svg = of_wander(Place::Usual);
    let texts = texts(&svg);
    for part in
        ["ir_left", "microcontroller", "cable up", "brain", "cable down", "motors", "19 bytes", "think"]
    {
        assert!(texts.iter().any(|text| text == part), "no `{part}` in {texts:?}");
    }
    assert!(svg.contains("<title>readings, 19 bytes: 40.6 to 60.392 ms, 19.792 ms</title>"), "{svg}");
    assert!(!texts.iter().any(|text| text == "adapter" || text == "longer than Δt"));
}

#[test]
fn a_cycle_that_is_longer_than_a_step_is_red_beyond_it() {
    let svg = of_wander(Place::Cycle(3));
    let texts = texts(&svg);
    assert!(texts.iter().any(|text| text == "longer than Δt"), "{texts:?}");
    let told = "Reading, transfer, thinking and obeying take 42.7 ms: longer than the Δt of 10 ms. Other cycles are pale.";
    assert!(texts.iter().any(|text| text == told), "{texts:?}");
    let up = rectangles(&svg, "readings, 19 bytes: 40.6 to 60.392 ms, 19.792 ms");
    let [whole, late] = &up[..] else { panic!("{up:?}") };
    assert!((late.0 + late.1 - whole.0 - whole.1).abs() < 0.1 && late.2 == "#d0312d", "{up:?}");
    let think = rectangles(&svg, "think: 60.392 to 75.392 ms, 15 ms");
    assert!(think.len() == 1 && think[0].2 == "#d0312d", "{think:?}");
    // The same of another cycle is what it always is.
    let other = rectangles(&svg, "think: 40.392 to 55.392 ms, 15 ms");
    assert!(other.len() == 1 && other[0].2 == Class::Think.style().color, "{other:?}");
}

#[test]
fn the_table_has_a_line_for_each_event_and_a_star_for_those_of_the_cycle() {
    let (scenario, events) = demo::wander(0, 8);
    let robot = &scenario.robots[0];
    let wanted = Wanted { place: Place::Cycle(3), span_ns: Some(3_000_000) };
    let kept = demo::kept(robot, events);
    let window = wanted.window(robot, &kept, STEP_NS);
    let table = table::text(&table::rows(robot, (&kept, None), &window, &BTreeMap::new()));
    let expected = "\
start ms  duration ms  who              what
  20.600       19.792  cable up         readings, 19 bytes
  35.392        7.292  cable down       command, 7 bytes
  36.434        6.266  microcontroller  obey
  40.000        0.112  ir_left          read ir_left *
  40.112        0.112  ir_front_left    read ir_front_left *
  40.224        0.112  ir_front         read ir_front *
  40.336        0.112  ir_front_right   read ir_front_right *
  40.392       15.000  brain            think
  40.448        0.112  ir_right         read ir_right *
  40.560        0.040  microcontroller  frame, 19 bytes *
  40.600       19.792  cable up         readings, 19 bytes *
";
    assert_eq!(table, expected);
}

#[test]
fn an_adapter_a_port_and_a_device_with_a_clock_have_lanes() {
    let (scenario, events) = demo::scout(6);
    let robot = &scenario.robots[0];
    let wanted = Wanted { place: Place::Cycle(2), span_ns: None };
    let kept = demo::kept(robot, events);
    let window = wanted.window(robot, &kept, STEP_NS);
    let svg = picture("lab", (STEP_NS, robot), (&kept, None, &BTreeMap::new()), &window).draw();
    let texts = texts(&svg);
    for part in ["laser", "adapter", "port of laser", "late, missed, lost", "missed frame", "2137 bytes"] {
        assert!(texts.iter().any(|text| text == part), "no `{part}` in {texts:?}");
    }
}

#[test]
fn what_was_said_is_in_the_title_of_its_bar_and_in_the_table() {
    let (scenario, events) = demo::wander(0, 8);
    let robot = &scenario.robots[0];
    let wanted = Wanted { place: Place::Cycle(3), span_ns: None };
    let kept = demo::kept(robot, events);
    let window = wanted.window(robot, &kept, STEP_NS);
    let up = kept.events.iter().position(|event| event.start.as_ns() == 40_600_000).unwrap();
    let meanings = BTreeMap::from([(up, "readings #2".to_owned() + &" 1".repeat(100))]);
    let svg = picture("wander", (STEP_NS, robot), (&kept, None, &meanings), &window).draw();
    assert!(
        svg.contains("<title>readings, 19 bytes: 40.6 to 60.392 ms, 19.792 ms; readings #2 1 1"),
        "{svg}"
    );
    let table = table::text(&table::rows(robot, (&kept, None), &window, &meanings));
    assert!(table.contains("  readings, 19 bytes *: readings #2 1 1 1"), "{table}");
    assert!(table.lines().any(|line| line.ends_with('…')), "{table}");
}

#[test]
fn a_diagram_tells_what_a_range_finder_was_asked_and_answered() {
    let scenario = baudbot_scenario::parse(LASER).unwrap();
    let robot = scenario.robots[0].clone();
    let stop = AtomicBool::new(false);
    let wanted = Wanted { place: Place::At(0), span_ns: Some(300_000_000) };
    let brains = crate::assignment::assign(&["scout=constant".to_owned()], &scenario.robots, &[]).unwrap();
    let tick = ticks(scenario, &brains, (0, View::Signals(0)), &stop).unwrap();
    let kept = wanted.record(&robot, STEP_NS, tick).unwrap();
    let window = wanted.window(&robot, &kept, STEP_NS);
    let meanings = meaning::meanings(&kept.events, &kept.said);
    let table = table::text(&table::rows(&robot, (&kept, None), &window, &meanings));
    for line in [
        "to port of laser  message to laser, 3 bytes: BM: laser on",
        "port of laser     message of laser, 8 bytes: BM: status 00 (accepted)",
        "MD0000000401000: measure distances of steps 0 to 4, without an end",
        "5 distances, checksums right",
    ] {
        assert!(table.contains(line), "no `{line}` in\n{table}");
    }
}

/// A robot that asks its laser for scans.
const LASER: &str = r#"
    [[robots]]
    name = "scout"
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
    [robots.sensors.laser]
    kind = "laser"
    bearing_rad = 0.0
    opening_rad = 1.0
    rays = 5
    range_m = 4.0
    period_ms = 100.0
    port = { link = { kind = "uart", baud = 19200 }, dialogue = "driver" }
"#;
