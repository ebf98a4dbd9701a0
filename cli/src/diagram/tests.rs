//! Diagrams of made-up events, looked at as XML.

use baudbot_sim::SimTime;
use baudbot_sim::timeline::{Event, What};

use super::class::Class;
use super::picture::{Bar, Diagram, Group, Lane, Mark};
use super::record::{Place, Wanted};
use super::{demo, picture, table};

const STEP_NS: u64 = 10_000_000;

fn bar(start_ns: u64, end_ns: u64, label: &str, class: Class) -> Bar {
    Bar {
        start_ns,
        end_ns,
        label: label.to_owned(),
        title: format!("title of {label}"),
        class,
        is_aside: false,
    }
}

fn lane(bars: Vec<Bar>) -> Lane {
    Lane { label: "lane".to_owned(), group: Group::Brain, bars }
}

fn diagram(lanes: Vec<Lane>, (from_ns, until_ns): (u64, u64)) -> Diagram {
    Diagram {
        title: "title".to_owned(),
        subtitle: "subtitle".to_owned(),
        ran: Vec::new(),
        lanes,
        from_ns,
        until_ns,
        step_ns: STEP_NS,
        marks: Vec::new(),
        late_from_ns: None,
    }
}

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
    let robot = &scenario.robots()[0];
    let wanted = Wanted { place, span_ns: None };
    let window = wanted.window(robot, &events, scenario.step_ns());
    picture("wander", scenario.step_ns(), robot, &events, &window).draw()
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
    assert!(other.len() == 1 && other[0].2 == Class::Think.color(), "{other:?}");
}

#[test]
fn a_bar_of_a_nanosecond_can_be_seen_and_one_of_none_is_a_mark() {
    let bars = vec![bar(1000, 1001, "short", Class::Up), bar(5000, 5000, "mark", Class::Act)];
    let svg = diagram(vec![lane(bars)], (0, 10_000_000_000)).draw();
    let short = rectangles(&svg, "title of short");
    assert!(short.len() == 1 && short[0].1 >= 1.0, "{short:?}");
    assert!(rectangles(&svg, "title of mark").is_empty());
    assert!(svg.contains("<title>title of mark</title>\n<path"), "{svg}");
}

#[test]
fn names_may_have_characters_that_xml_does_not_like() {
    let name = "<a & \"b\"> \u{1}\u{fffe}";
    let mut diagram = diagram(vec![lane(vec![bar(0, STEP_NS, name, Class::Think)])], (0, STEP_NS));
    diagram.title = name.to_owned();
    diagram.subtitle = name.to_owned();
    diagram.lanes[0].label = name.to_owned();
    diagram.marks = vec![Mark { at_ns: 5, label: name.to_owned() }];
    let texts = texts(&diagram.draw());
    assert_eq!(texts.iter().filter(|text| text.starts_with("<a & \"b\"> ")).count(), 5, "{texts:?}");
}

#[test]
fn no_instant_and_no_window_is_too_much() {
    let far = [0, 1, STEP_NS, u64::MAX - 1, u64::MAX];
    for (from, until) in far.iter().flat_map(|from| far.map(|until| (*from, until))) {
        let bars = far.iter().flat_map(|start| far.map(|end| bar(*start, end, "bar", Class::Fault)));
        let mut diagram = diagram(vec![lane(bars.collect()), lane(Vec::new())], (from, until));
        diagram.late_from_ns = Some(until / 2);
        for step_ns in far {
            diagram.step_ns = step_ns;
            let svg = diagram.draw();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{from} to {until} by {step_ns}: {svg}");
            texts(&svg);
        }
    }
    texts(&diagram(Vec::new(), (0, 0)).draw());
}

#[test]
fn a_long_window_makes_no_huge_picture() {
    let bars = (0..200_000).map(|i| bar(i * 1000, i * 1000 + 500, "bar", Class::Up)).collect();
    let svg = diagram(vec![lane(bars)], (0, 200_000_000)).draw();
    assert!(svg.len() < 300_000, "{} bytes", svg.len());
}

#[test]
fn what_cannot_be_told_from_its_neighbour_has_no_label() {
    let bars = vec![bar(0, 10, "no room in it", Class::Up), bar(11, 1000, "room", Class::Up)];
    let texts = texts(&diagram(vec![lane(bars)], (0, 1000)).draw());
    assert!(texts.iter().any(|text| text == "room") && !texts.iter().any(|text| text == "no room in it"));
}

#[test]
fn the_table_has_a_line_for_each_event_and_a_star_for_those_of_the_cycle() {
    let (scenario, events) = demo::wander(0, 8);
    let robot = &scenario.robots()[0];
    let wanted = Wanted { place: Place::Cycle(3), span_ns: Some(3_000_000) };
    let window = wanted.window(robot, &events, STEP_NS);
    let table = table::table(robot, &events, &window);
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
fn what_was_missed_and_lost_has_lanes_of_its_own_if_there_is_any() {
    let scenario = baudbot_scenario::parse(include_str!("../../../scenarios/wander.toml")).unwrap();
    let robot = &scenario.robots()[0];
    let event = |start, end, what| Event { start: SimTime::from_ns(start), end: SimTime::from_ns(end), what };
    let labels = |events: &[Event]| -> Vec<_> {
        super::timeline::lanes(robot, events, (0, 100), None).into_iter().map(|lane| lane.label).collect()
    };
    let without = labels(&[event(200, 300, What::Late), event(0, 50, What::Acquire { sensor: 0 })]);
    assert_eq!(without.last().unwrap(), "motors");
    let trouble = [
        event(5, 5, What::Missed { sensor: u16::MAX }),
        event(0, 99, What::Fault { fault: 4 }),
        event(7, 7, What::Lost { bytes: 1 }),
    ];
    assert_eq!(labels(&trouble)[without.len()..], ["late, missed, lost", "fault 4"]);
}

#[test]
fn an_adapter_a_port_and_a_device_with_a_clock_have_lanes() {
    let (scenario, events) = demo::scout(6);
    let robot = &scenario.robots()[0];
    let wanted = Wanted { place: Place::Cycle(2), span_ns: None };
    let window = wanted.window(robot, &events, STEP_NS);
    let svg = picture("lab", STEP_NS, robot, &events, &window).draw();
    let texts = texts(&svg);
    for part in ["laser", "adapter", "port of laser", "late, missed, lost", "missed frame", "2137 bytes"] {
        assert!(texts.iter().any(|text| text == part), "no `{part}` in {texts:?}");
    }
}
