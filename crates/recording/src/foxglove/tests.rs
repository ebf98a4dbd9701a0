//! Several frames of a made-up world, from beginning to end.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use baudbot_proto::v1::SensorKind;
use foxglove::Decode as _;
use foxglove::messages::{Grid, LaserScan, Log, scene_entity_deletion};

use super::*;

const SECOND_NS: u64 = 1_000_000_000;

/// A robot with a laser on a turret, an infra-red sensor and encoders; one without sensors; a door.
fn world() -> v1::DescribeWorldResponse {
    let component = |count| v1::ComponentDescription { count, ..v1::ComponentDescription::default() };
    let sensor = |name: &str, kind: SensorKind, count, turret| v1::SensorDescription {
        sensor: name.into(),
        kind: kind.into(),
        components: vec![component(count)],
        mount: Some(v1::Mount { x_m: 0.1, y_m: 0.0, heading_rad: 0.0, turret, elevation_rad: None }),
        counts_per_turn: (kind == SensorKind::Encoders).then_some(100),
        ..v1::SensorDescription::default()
    };
    let sensors = vec![
        sensor("ir", SensorKind::Ir, 1, None),
        sensor("urg", SensorKind::Laser, 3, Some(0)),
        v1::SensorDescription { mount: None, ..sensor("wheels", SensorKind::Encoders, 2, None) },
    ];
    let description = v1::RobotDescription {
        half_track_m: 0.1,
        wheel_radius_m: 0.05,
        sensors,
        ..v1::RobotDescription::default()
    };
    let robot = |name: &str, description| v1::ObservedRobot {
        robot: name.into(),
        radius_m: 0.2,
        description,
        ..v1::ObservedRobot::default()
    };
    let outline = Some(v1::Outline { radius_m: 0.3, ..v1::Outline::default() });
    v1::DescribeWorldResponse {
        robots: vec![robot("alice", Some(description)), robot("bob", None)],
        things: vec![v1::ObservedThing { thing: "door".into(), outline, ..v1::ObservedThing::default() }],
        circles: vec![v1::Disc { name: "post".into(), radius_m: 0.5, ..v1::Disc::default() }],
        ..v1::DescribeWorldResponse::default()
    }
}

fn truth(x_m: f64) -> v1::RobotTruth {
    let actuators = vec![v1::ActuatorTruth { signal: 0.0, angle_rad: FRAC_PI_2 }];
    v1::RobotTruth { x_m, heading_rad: FRAC_PI_2, actuators, ..v1::RobotTruth::default() }
}

/// The detail of alice: her scan and her counts were sampled at this time.
fn detail(sampled_at_ns: u64, counts: f64) -> v1::RobotDetail {
    let rays = Some(v1::RayFan { opening_rad: 1.0, lengths_m: vec![2.0; 3], ..v1::RayFan::default() });
    let sensor = |values: &[f64], rays| v1::SensorDetail {
        values: values.to_vec(),
        sampled_at_ns: Some(sampled_at_ns),
        rays,
        ..v1::SensorDetail::default()
    };
    let sensors =
        vec![sensor(&[0.5], rays.clone()), sensor(&[1.0, 2.0, -1.0], rays), sensor(&[counts, counts], None)];
    v1::RobotDetail { robot: 0, sensors, ..v1::RobotDetail::default() }
}

fn frame(time_ns: u64, details: Vec<v1::RobotDetail>) -> v1::WatchResponse {
    let seconds = time_ns as f64 / SECOND_NS as f64;
    let door = v1::ThingTruth { x_m: 3.0, ..v1::ThingTruth::default() };
    v1::WatchResponse {
        time_ns,
        robots: vec![truth(seconds), truth(-seconds)],
        things: vec![door],
        details,
        ..v1::WatchResponse::default()
    }
}

/// A message in words, decoded by its own schema; it must have no number that is none.
fn words(message: &FoxgloveMessage) -> String {
    let data = &message.data[..];
    let words = match message.schema.name.as_str() {
        "foxglove.SceneUpdate" => format!("{:?}", SceneUpdate::decode(data).unwrap()),
        "foxglove.FrameTransforms" => format!("{:?}", FrameTransforms::decode(data).unwrap()),
        "foxglove.LaserScan" => format!("{:?}", LaserScan::decode(data).unwrap()),
        "foxglove.Grid" => format!("{:?}", Grid::decode(data).unwrap()),
        "foxglove.Log" => format!("{:?}", Log::decode(data).unwrap()),
        other => panic!("{other}"),
    };
    for none in ["NaN", ": inf", ": -inf"] {
        assert!(!words.contains(none), "{} at {} ns: {words}", message.topic, message.time_ns);
    }
    words
}

fn on<'a>(messages: &'a [FoxgloveMessage], topic: &str) -> Option<&'a FoxgloveMessage> {
    messages.iter().find(|message| &*message.topic == topic)
}

/// Each child's parent, place and heading, from the messages of a frame.
fn frames_of(messages: &[FoxgloveMessage]) -> BTreeMap<String, (String, [f64; 2], f64)> {
    let Some(message) = on(messages, "/tf") else { return BTreeMap::new() };
    let transforms = FrameTransforms::decode(&message.data[..]).unwrap().transforms;
    let entry = |t: foxglove::messages::FrameTransform| {
        assert_eq!(t.timestamp, Some(time(message.time_ns)));
        let (place, turn) = (t.translation.unwrap(), t.rotation.unwrap());
        (t.child_frame_id, (t.parent_frame_id, [place.x, place.y], 2.0 * turn.z.atan2(turn.w)))
    };
    transforms.into_iter().map(entry).collect()
}

#[test]
fn an_opening_says_all_that_does_not_change() {
    let messages = FoxgloveEncoder::new(&world()).opening(SECOND_NS);
    let topics: Vec<_> = messages.iter().map(|message| &*message.topic).collect();
    assert_eq!(topics, ["/scene/arena", "/scene/robots", "/scene/things", "/tf_static"]);
    assert!(messages.iter().all(|message| message.time_ns == SECOND_NS));
    assert!(words(&messages[3]).contains("robot/alice/ir"));
    assert!(!words(&messages[3]).contains("robot/alice/urg"), "a turret turns it");
}

#[test]
fn frames_move_robots_things_turrets_and_ghosts() {
    let mut messages = FoxgloveEncoder::new(&world());
    let first = messages.frame(&frame(SECOND_NS, vec![]));
    let frames = frames_of(&first);
    let names: Vec<_> = frames.keys().map(String::as_str).collect();
    assert_eq!(names, ["robot/alice", "robot/alice/urg", "robot/bob", "thing/door"]);
    let (parent, place, heading_rad) = &frames["robot/alice"];
    assert_eq!((parent.as_str(), *place), ("world", [1.0, 0.0]));
    assert!((heading_rad - FRAC_PI_2).abs() < 1e-12, "{heading_rad}");
    let (parent, place, _) = &frames["robot/alice/urg"];
    assert_eq!(parent, "robot/alice");
    assert!(place[0].abs() < 1e-12 && (place[1] - 0.1).abs() < 1e-12, "{place:?}");
    assert_eq!(frames["thing/door"].1, [3.0, 0.0]);
    // The ghost begins where the robot was when its wheels were read, and goes a wheel's turn ahead.
    let ghosts = |messages: &[FoxgloveMessage]| {
        let scene =
            on(messages, "/scene/odometry").map(|message| SceneUpdate::decode(&message.data[..]).unwrap());
        scene.map(|scene| scene.entities.into_iter().map(|entity| entity.frame_id).collect::<Vec<_>>())
    };
    let begun = messages.frame(&frame(2 * SECOND_NS, vec![detail(SECOND_NS, 0.0)]));
    assert_eq!(ghosts(&begun), Some(vec!["odometry/alice".to_owned()]));
    let rolled = messages.frame(&frame(3 * SECOND_NS, vec![detail(3 * SECOND_NS, 100.0)]));
    assert_eq!(ghosts(&rolled), None, "it was said");
    let frames = frames_of(&rolled);
    let [x_m, y_m] = frames["odometry/alice"].1;
    assert!((x_m - 1.0).abs() < 1e-12 && (y_m - 0.1 * std::f64::consts::PI).abs() < 1e-12, "{x_m}, {y_m}");
    // Time goes back: the ghost is gone until there is news of wheels.
    let anew = messages.frame(&frame(0, vec![]));
    assert!(!frames_of(&anew).contains_key("odometry/alice"));
    assert_eq!(ghosts(&anew), Some(vec![]));
}

#[test]
fn scans_and_rays_are_those_of_robots_with_details() {
    let mut messages = FoxgloveEncoder::new(&world());
    let first = messages.frame(&frame(SECOND_NS, vec![]));
    assert!(on(&first, "/scene/rays").is_none() && on(&first, "/scan/alice/urg").is_none());
    let mut rays = |time_ns, details: Vec<_>| {
        let messages = messages.frame(&frame(time_ns, details));
        let scene =
            on(&messages, "/scene/rays").map(|message| SceneUpdate::decode(&message.data[..]).unwrap());
        let scan =
            on(&messages, "/scan/alice/urg").map(|message| LaserScan::decode(&message.data[..]).unwrap());
        (scene, scan)
    };
    let (scene, scan) = rays(2 * SECOND_NS, vec![detail(SECOND_NS, 0.0)]);
    let (scene, scan) = (scene.unwrap(), scan.unwrap());
    let ids: Vec<_> = scene.entities.iter().map(|entity| entity.id.as_str()).collect();
    assert_eq!(ids, ["alice"]);
    assert_eq!(scene.entities[0].lines.len(), 1, "a laser has its scan");
    assert_eq!(scene.deletions[0].r#type(), scene_entity_deletion::Type::All);
    assert_eq!((scan.frame_id.as_str(), scan.timestamp), ("robot/alice/urg", Some(time(SECOND_NS))));
    let (scene, scan) = rays(3 * SECOND_NS, vec![detail(SECOND_NS, 0.0)]);
    assert!(scan.is_none(), "nothing new has come");
    assert!(scene.unwrap().deletions.is_empty(), "rays of the same robots are replaced by name");
    let gone = rays(4 * SECOND_NS, vec![]).0.unwrap();
    assert!(gone.entities.is_empty() && gone.deletions.len() == 1);
    assert_eq!(rays(5 * SECOND_NS, vec![]), (None, None));
}

#[test]
fn what_is_no_number_or_belongs_to_nobody_is_left_out() {
    let mut messages = FoxgloveEncoder::new(&world());
    let mut broken = detail(0, f64::NAN);
    broken.sensors[1].values[0] = f64::NAN;
    broken.sensors[0].rays.as_mut().unwrap().lengths_m[1] = f32::NAN;
    let mut frame =
        frame(SECOND_NS, vec![broken, v1::RobotDetail { robot: 9, ..v1::RobotDetail::default() }]);
    frame.robots[0].x_m = f64::NAN;
    frame.robots[0].samples = vec![f64::NAN];
    frame.robots[1].heading_rad = f64::INFINITY;
    frame.things[0].y_m = f64::NAN;
    let belief = |robot| v1::Annotation { robot, belief: Some(v1::Belief::default()) };
    frame.annotations = vec![belief(1), belief(9), v1::Annotation { robot: 0, belief: None }];
    let shown = messages.frame(&frame);
    shown.iter().for_each(|message| _ = words(message));
    let topics: Vec<_> = shown.iter().map(|message| &*message.topic).collect();
    assert_eq!(topics, ["/scan/alice/urg", "/tf", "/scene/rays", "/belief/bob"]);
    let frames = frames_of(&shown);
    assert_eq!(frames.keys().collect::<Vec<_>>(), ["robot/alice/urg"], "the turret alone is somewhere");
    // The ghost of a robot without a place does not begin.
    assert!(messages.robots[0].frames(&truth(0.0), time(0)).len() == 2);
}

#[test]
fn an_empty_world_has_nothing_to_show() {
    let mut messages = FoxgloveEncoder::new(&v1::DescribeWorldResponse::default());
    assert!(messages.opening(0).is_empty());
    assert!(messages.frame(&v1::WatchResponse::default()).is_empty());
    assert!(messages.frame(&frame(u64::MAX, vec![detail(u64::MAX, 1.0)])).is_empty());
    assert_eq!(&*messages.event(0, v1::ReplayEventKind::Ending, "over").topic, "/log");
}

#[test]
fn each_topic_has_messages_of_one_schema() {
    let mut messages = FoxgloveEncoder::new(&world());
    let mut last = frame(SECOND_NS, vec![detail(0, 0.0)]);
    let map = Some(v1::GridMap { cell_m: 1.0, columns: 1, cells: vec![0], ..v1::GridMap::default() });
    let belief = Some(v1::Belief { map, ..v1::Belief::default() });
    last.annotations = vec![v1::Annotation { robot: 0, belief }];
    let mut shown = messages.opening(0);
    shown.extend(messages.frame(&last));
    shown.push(messages.event(0, v1::ReplayEventKind::Brain, "alice has a brain"));
    let topics: BTreeSet<_> = shown.iter().map(|message| &*message.topic).collect();
    let pairs: BTreeSet<_> =
        shown.iter().map(|message| (&*message.topic, message.schema.name.as_str())).collect();
    assert_eq!((topics.len(), pairs.len()), (11, 11), "{pairs:?}");
    assert!(shown.iter().all(|message| !words(message).is_empty() && message.topic.starts_with('/')));
}

/// The layout in docs/ names topics that there are, and panels that it has.
#[test]
fn the_layout_is_one_for_these_topics() {
    let layout: serde_json::Value =
        serde_json::from_str(include_str!("../../../../docs/how-to/foxglove-layout.json")).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    let mut shown = Vec::new();
    leaves(&layout["layout"], &mut shown);
    assert_eq!(shown.iter().copied().collect::<BTreeSet<_>>(), panels.keys().map(String::as_str).collect());
    let kinds: BTreeSet<_> = shown.iter().filter_map(|panel| panel.split('!').next()).collect();
    assert_eq!(kinds, BTreeSet::from(["3D", "Plot", "RawMessages", "RosOut"]));
    let topics = panels["3D!scene"]["topics"].as_object().unwrap();
    let opening = FoxgloveEncoder::new(&world()).opening(0);
    let scenes = opening.iter().map(|message| &*message.topic).filter(|topic| topic.starts_with("/scene"));
    for topic in scenes.chain(["/scene/rays", "/scene/odometry"]) {
        assert_eq!(topics[topic]["visible"], true, "{topic}");
    }
    assert_eq!(panels["3D!scene"]["cameraState"]["perspective"], false);
    assert_eq!(panels["RosOut!log"]["topicToRender"], "/log");
}

/// Panels that a layout shows, from left to right and from above.
fn leaves<'a>(node: &'a serde_json::Value, found: &mut Vec<&'a str>) {
    match node.as_str() {
        Some(panel) => found.push(panel),
        None => ["first", "second"].iter().for_each(|side| leaves(&node[side], found)),
    }
}
