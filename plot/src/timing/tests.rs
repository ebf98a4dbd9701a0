//! Diagrams of made-up events, parsed as XML.

use std::collections::BTreeMap;

use baudbot_sim::SimTime;
use baudbot_sim::timeline::{Event, What};

use super::*;

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
    Lane { label: "lane".to_owned(), group: Group::Brain, bars, wave: Vec::new() }
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
fn what_was_missed_and_lost_has_lanes_of_its_own_if_there_is_any() {
    let scenario = baudbot_scenario::parse(include_str!("../../../scenarios/wander.toml")).unwrap();
    let robot = &scenario.robots[0];
    let event = |start, end, what| Event { start: SimTime::from_ns(start), end: SimTime::from_ns(end), what };
    let labels = |events: &[Event]| -> Vec<_> {
        lanes(robot, events, (0, 100), None, &BTreeMap::new()).into_iter().map(|lane| lane.label).collect()
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
