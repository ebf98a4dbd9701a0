//! `baudbot export --rosbag2`: what tools of ROS 2 find in a bag. `xtask/tools/check_rosbag.py` reads bags with a reader of others.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::fs;

use crate::cli::good;

/// A wall 0.8 m ahead of a robot that drives.
const SCENARIO: &str = r#"
    [[arena.polygons]]
    name = "wall"
    points_m = [[1.0, -1.0], [1.2, -1.0], [1.2, 1.0], [1.0, 1.0]]

    [[robots]]
    name = "r"
    start = { x_m = 0.2 }
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.02, wheel_radius_m = 0.05, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }

    [robots.sensors.eye]
    kind = "laser"
    mount = {}
    opening_rad = 6.283185307179586
    rays = 721
    range_m = 4.0
    period_ms = 100.0
    port = { link = { kind = "ideal" } }

    [robots.sensors.ping]
    kind = "sonar"
    mount = { x_m = 0.1 }
    opening_rad = 0.5
    rays = 3
    min_m = 0.03
    max_m = 3.0
    period_ms = 50.0

    [robots.sensors.sharp]
    preset = "gp2d12"
    mount = { x_m = 0.2 }
    noise = { gain_spread = 0.0, offset_spread = 0.0, additive = 0.0 }

    [robots.sensors.odometer]
    kind = "odometer"
    sigma_m = 0.001
    period_ms = 20.0

    [robots.sensors.gyro]
    kind = "gyroscope"
    range_rad_s = 10.0
    noise = { additive = 0.02 }
"#;

/// The topics of a bag: how they are offered, and their messages.
type Topics = BTreeMap<String, (String, Vec<Vec<u8>>)>;

/// The bag of a run of 2 s, and its metadata.
fn bag() -> (Topics, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("s.toml"), SCENARIO).unwrap();
    let brain = "constant:left=0.2,right=0.2";
    good(&[
        "run",
        &path("s.toml"),
        "--brain",
        brain,
        "--seconds",
        "2",
        "--quiet",
        "--record",
        &path("r.mcap"),
    ]);
    good(&["export", &path("r.mcap"), "--rosbag2", &path("bag"), "--quiet"]);
    let mut topics = Topics::new();
    for message in mcap::MessageStream::new(&fs::read(path("bag/bag_0.mcap")).unwrap()).unwrap() {
        let message = message.unwrap();
        let offered = message.channel.metadata["offered_qos_profiles"].clone();
        let entry = topics.entry(message.channel.topic.clone()).or_insert((offered, Vec::new()));
        entry.1.push(message.data.to_vec());
    }
    (topics, fs::read_to_string(path("bag/metadata.yaml")).unwrap())
}

/// Reads CDR: numbers at multiples of their size behind the header.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn of(message: &'a [u8]) -> Self {
        assert_eq!(message[..4], [0, 1, 0, 0]);
        Self { bytes: &message[4..], at: 0 }
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at = self.at.next_multiple_of(N);
        self.at += N;
        self.bytes[self.at - N..self.at].try_into().unwrap()
    }

    fn u32(&mut self) -> usize {
        u32::from_le_bytes(self.take()) as usize
    }

    fn f32(&mut self) -> f64 {
        f64::from(f32::from_le_bytes(self.take()))
    }

    fn f64s(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| f64::from_le_bytes(self.take())).collect()
    }

    fn text(&mut self) -> String {
        let length = self.u32();
        self.at += length;
        String::from_utf8(self.bytes[self.at - length..self.at - 1].to_vec()).unwrap()
    }

    /// The frame of a header.
    fn frame(&mut self) -> String {
        let _stamp = (self.u32(), self.u32());
        self.text()
    }
}

#[test]
fn who_comes_later_gets_the_frames_that_stay() {
    let (topics, metadata) = bag();
    for (topic, (offered, _)) in &topics {
        let durability = if topic == "/tf_static" { 1 } else { 2 };
        let lines = ["- history: 1\n", "\n  reliability: 1\n", &format!("\n  durability: {durability}\n")];
        assert!(lines.iter().all(|line| offered.contains(line)), "{topic}: {offered}");
        let (_, of_topic) = metadata.split_once(&format!("name: {topic}\n")).unwrap();
        let told = of_topic.lines().nth(2).unwrap().trim();
        assert_eq!(told, format!("offered_qos_profiles: \"{}\"", offered.replace('\n', "\\n")), "{topic}");
    }
    let (_, frames) = &topics["/tf_static"];
    let mut reader = Reader::of(&frames[0]);
    let children: BTreeSet<_> = (0..reader.u32())
        .map(|_| {
            let (parent, child) = (reader.frame(), reader.text());
            let _pose = reader.f64s(7);
            assert_eq!(parent, "base_link");
            child
        })
        .collect();
    assert_eq!(children, BTreeSet::from(["eye", "ping", "sharp"].map(str::to_owned)));
}

/// The number of readings that open_karto computes in slam_toolbox, which drops a scan with another number.
fn expected_by_karto(first: f64, last: f64, gap: f64) -> usize {
    let span = (last - first).abs();
    let is_360 = (span - TAU).abs() < gap.abs() - f64::from(f32::EPSILON) * TAU;
    (span / gap.abs()).round() as usize + usize::from(!is_360)
}

#[test]
fn a_full_turn_has_no_ray_twice() {
    let (topics, _) = bag();
    for scan in &topics["/scan"].1 {
        let mut reader = Reader::of(scan);
        assert_eq!(reader.frame(), "eye");
        let (first, last, gap) = (reader.f32(), reader.f32(), reader.f32());
        let [_, _, _, range_m] = [reader.f32(), reader.f32(), reader.f32(), reader.f32()];
        let count = reader.u32();
        assert_eq!((count, range_m), (720, 4.0));
        assert_eq!(count, expected_by_karto(first, last, gap));
        assert!((first + PI).abs() < 1e-6 && (last - (PI - TAU / 720.0)).abs() < 1e-6, "{first} to {last}");
        assert!((first + gap * 719.0 - last).abs() < 1e-4);
    }
    // The scan is as it was: it has both ends.
    assert_ne!(expected_by_karto(-PI, PI, TAU / 720.0), 721);
}

#[test]
fn sonars_and_ir_sensors_say_how_far_away_something_is() {
    let (topics, _) = bag();
    // The robot has just started.
    for (topic, radiation, mount_m) in [("/ping/range", 0, 0.1), ("/sharp/range", 1, 0.2)] {
        // A device with a clock of its own has nothing before it has measured.
        let distances = topics[topic].1.iter().map(|message| {
            let mut reader = Reader::of(message);
            assert_eq!(reader.frame(), topic.trim_start_matches('/').trim_end_matches("/range"));
            assert_eq!(reader.take::<1>(), [radiation], "{topic}");
            let [view_rad, least_m, most_m] = [reader.f32(), reader.f32(), reader.f32()];
            assert!(view_rad >= 0.0 && least_m < most_m, "{topic}");
            reader.f32()
        });
        let distance_m = distances.into_iter().find(|distance_m| distance_m.is_finite()).unwrap();
        let wall_m = 0.8 - mount_m;
        assert!((distance_m - wall_m).abs() < 0.02, "{topic}: {distance_m} m in place of {wall_m} m");
    }
}

#[test]
fn what_is_measured_has_a_covariance_that_filters_can_use() {
    let (topics, _) = bag();
    let diagonals = |message: &Vec<u8>| {
        let mut reader = Reader::of(message);
        let _frames = (reader.frame(), reader.text());
        let _pose = reader.f64s(7);
        let pose = reader.f64s(36);
        let _twist = reader.f64s(6);
        let twist = reader.f64s(36);
        [pose, twist].map(|all| (0..6).map(|axis| all[axis * 7]).collect::<Vec<_>>())
    };
    for topic in ["/odom", "/ground_truth"] {
        for message in &topics[topic].1 {
            assert!(diagonals(message).concat().iter().all(|&variance| variance > 0.0), "{topic}");
        }
    }
    let odom = &topics["/odom"].1;
    let [first, last] =
        [odom.first().unwrap(), odom.last().unwrap()].map(|message| diagonals(message)[0].clone());
    // Each reading adds σ² / 2 to the square of the error along the way: 1e-6 / 2.
    let added = 0.5e-6 * (odom.len() - 1) as f64;
    assert!((last[0] - first[0] - added).abs() < 0.2 * added, "{first:?} to {last:?}, expected {added} more");
    assert!(last[5] > first[5], "{first:?} to {last:?}");
    let mut reader = Reader::of(&topics["/imu"].1[0]);
    let _frame = reader.frame();
    let _orientation = reader.f64s(4);
    assert_eq!(reader.f64s(9)[0], -1.0, "there is no compass");
    let _rate = reader.f64s(3);
    let of_rate = reader.f64s(9);
    assert!((of_rate[8] - 0.0004).abs() < 1e-6 && of_rate[0] > 0.0 && of_rate[4] > 0.0, "{of_rate:?}");
}
