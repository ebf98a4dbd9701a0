//! Diagrams of made-up events, parsed as XML.

use std::collections::BTreeMap;

use baudbot_sim::SimTime;
use baudbot_sim::chip::{Level, Line, Net, Pulses, Shown, Signal, Stretch, Turns};
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
    let scenario =
        baudbot_scenario::parse(include_str!("../../../../catalogue/scenarios/wander.toml")).unwrap();
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

fn level(at_ns: u64, level: Level) -> Shown {
    Shown::Stretch(Stretch::Level { at_ns, level })
}

fn pulses(from_ns: u64, until_ns: u64, count: u32, high_ns: u64, is_even: bool) -> Shown {
    Shown::Stretch(Stretch::Pulses(Pulses { from_ns, until_ns, count, high_ns, is_even }))
}

fn shot(line: Line, on: &[&str], shown: Vec<Shown>) -> Shot {
    let on = on.iter().map(|terminal| (*terminal).to_owned()).collect();
    Shot { signal: Signal { line, on }, shown }
}

fn wire(pin: u8, on: &[&str], shown: Vec<Shown>) -> Shot {
    shot(Line::Wire(Net::arduino(pin).unwrap()), on, shown)
}

const MS: u64 = 1_000_000;

/// A motor, a wire that two drive, an analog input, and a line of text.
fn shots() -> Vec<Shot> {
    let character = |i: usize, byte: u8| Shown::Number { at_ns: (2 + i as u64) * MS, number: byte.into() };
    let mut text: Vec<_> = b"Hi\n".iter().enumerate().map(|(i, byte)| character(i, *byte)).collect();
    text.push(Shown::Over { at_ns: 5 * MS });
    vec![
        wire(1, &[], vec![level(0, Level::High), level(2 * MS, Level::Low)]),
        wire(2, &[], vec![level(0, Level::Open)]),
        wire(
            7,
            &["whisker"],
            vec![level(0, Level::High), level(4 * MS, Level::Short), level(6 * MS, Level::Low)],
        ),
        wire(
            9,
            &["motors.left.pwm"],
            vec![
                level(0, Level::Low),
                pulses(MS, 9 * MS, 1000, 2 * MS, true),
                pulses(9 * MS, 17 * MS, 1000, 2 * MS, true),
                level(17 * MS, Level::High),
            ],
        ),
        wire(12, &[], vec![level(0, Level::Open), level(3 * MS, Level::High)]),
        wire(14, &["ir"], vec![level(0, Level::Open)]),
        shot(Line::Adc(0), &["ir"], vec![Shown::Number { at_ns: 3 * MS, number: 512 }]),
        shot(Line::Sent, &[], text),
        shot(Line::Received, &[], Vec::new()),
    ]
}

#[test]
fn pins_with_something_on_them_have_lanes_and_others_if_the_program_moves_them() {
    let labels = |chosen: Option<&[Net]>| -> Vec<_> {
        pin_lanes(&shots(), (0, 20 * MS), chosen).into_iter().map(|lane| lane.label).collect()
    };
    assert_eq!(labels(None), ["D7 whisker", "D9 motors.left.pwm", "D12", "adc0 ir", "uart sent"]);
    let net = |pin| Net::arduino(pin).unwrap();
    assert_eq!(labels(Some(&[net(2), net(1)])), ["D1", "D2", "uart sent"]);
    assert_eq!(labels(Some(&[net(14)])), ["adc0 ir", "uart sent"], "its level is never one");
    let later: Vec<_> =
        pin_lanes(&shots(), (6 * MS, 20 * MS), None).into_iter().map(|lane| lane.label).collect();
    assert_eq!(later, ["D7 whisker", "D9 motors.left.pwm", "adc0 ir"]);
}

#[test]
fn rounds_of_the_main_loop_have_a_lane_in_which_short_ones_are_one_block() {
    let turns = |from_ns: u64, until_ns: u64, count, cycles, are_short| {
        Shown::Turns(Turns { from_ns, until_ns, count, cycles, are_short })
    };
    let shown = vec![
        turns(0, 2 * MS, 1000, 32_000, true),
        turns(2 * MS, 6 * MS, 1, 64_000, false),
        turns(6 * MS, 30 * MS, 1, 384_000, false),
    ];
    let mut shots = shots();
    shots.insert(0, shot(Line::MainLoop, &[], shown));
    let lanes = pin_lanes(&shots, (MS, 20 * MS), None);
    assert_eq!((lanes[0].label.as_str(), lanes[0].group), ("main loop", Group::Microcontroller));
    let bars: Vec<_> = lanes[0].bars.iter().map(|bar| (bar.label.as_str(), bar.title.as_str())).collect();
    let expected = [
        ("1000 rounds", "1000 short rounds, 32 cycles on average: 0 to 2 ms, 2 ms"),
        ("4 ms", "a round of 64000 cycles: 2 to 6 ms, 4 ms"),
        ("24 ms", "a round of 384000 cycles: 6 to 30 ms, 24 ms"),
    ];
    assert_eq!(bars, expected);
    let svg = diagram(lanes, (MS, 20 * MS)).draw();
    let texts = texts(&svg);
    for words in ["a round of the main loop", "short rounds", "4 ms"] {
        assert!(texts.iter().any(|text| text == words), "no `{words}` in {texts:?}");
    }
    let later = pin_lanes(&shots, (31 * MS, 40 * MS), None);
    assert!(later.iter().all(|lane| lane.label != "main loop"), "none of it is seen");
}

#[test]
fn a_pin_is_a_wave_and_fast_pulses_are_a_block_with_their_duty() {
    let lanes = pin_lanes(&shots(), (0, 20 * MS), None);
    let svg = diagram(lanes, (0, 20 * MS)).draw();
    let texts = texts(&svg);
    for text in ["25 %, 125 kHz", "512", "H", "i", "\\n", "high, low", "driven against each other"] {
        assert!(texts.iter().any(|other| other == text), "no `{text}` in {texts:?}");
    }
    assert!(svg.contains("<title>2000 pulses, 25 %, 125 kHz: 1 to 17 ms</title>"), "they go on: {svg}");
    assert!(svg.contains("<title>driven against each other: 4 to 6 ms</title>"), "{svg}");
    // The lines of D7, D9 and D12, and the dashes of D12 before it is driven.
    let lines =
        |dash: &str| svg.matches(&format!("stroke-width=\"1.4\" stroke-dasharray=\"{dash}\"")).count();
    assert_eq!((lines("none"), lines("2 3")), (3 + 1, 1 + 1), "with those of the key: {svg}");
    let narrow = pin_lanes(&shots(), (0, 200 * MS), None);
    let sent = narrow.iter().find(|lane| lane.label == "uart sent").unwrap();
    assert_eq!((sent.bars.len(), sent.bars[0].end_ns), (1, 5 * MS), "characters without room are together");
    assert!(sent.bars[0].title.starts_with("Hi\\n: 2"), "{}", sent.bars[0].title);
}

#[test]
fn no_instant_of_a_pin_is_too_much() {
    let far = [0, 1, STEP_NS, u64::MAX - 1, u64::MAX];
    let levels = [Level::Low, Level::High, Level::Open, Level::Short];
    for (from, until) in far.iter().flat_map(|from| far.map(|until| (*from, until))) {
        let mut shown: Vec<_> = far.iter().flat_map(|at| levels.map(|one| level(*at, one))).collect();
        shown.push(pulses(0, u64::MAX, 7, 3, false));
        let lanes = pin_lanes(&[wire(9, &["motor"], shown)], (from, until), None);
        let svg = diagram(lanes, (from, until)).draw();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{from} to {until}: {svg}");
        texts(&svg);
    }
}
