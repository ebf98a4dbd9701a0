//! Scenarios with every device there is, absurd numbers, and the promise that nothing panics.

use baudbot_sim::World;
use proptest::prelude::*;

use crate::common::{run, world};

const SURROUNDINGS: &str = r#"
seed = 3
step_ms = 10.0
substeps = 2
noise = true
[end]
after_s = 1000.0
collisions = 1000000
[metrics]
cell_m = 0.2
sensed_by = "laser"
sense_ms = 100.0
[arena]
ambient_lux = 5.0
floor = 0.8
latitude_deg = 57.7
longitude_deg = 11.97
[[arena.polygons]]
name = "border"
solid = false
points_m = [[-4.0, -4.0], [6.0, -4.0], [6.0, 4.0], [-4.0, 4.0]]
[[arena.polygons]]
name = "crate"
points_m = [[2.0, 2.0], [2.4, 2.0], [2.4, 2.4], [2.0, 2.4]]
height_m = 0.3
color = [200, 10, 10]
[[arena.circles]]
name = "pillar"
x_m = 3.0
y_m = -2.0
radius_m = 0.3
height_m = 1.5
[[arena.zones]]
name = "dock"
x_m = 0.0
y_m = 0.0
radius_m = 0.6
charger_w = 20.0
floor = 0.2
slip = 0.1
compass_offset_rad = 0.1
[[arena.zones]]
name = "house"
points_m = [[-3.0, -3.0], [-1.0, -3.0], [-1.0, 3.0], [-3.0, 3.0]]
indoors = true
goal = true
[[arena.lights]]
name = "lamp"
x_m = 1.0
y_m = 1.5
height_m = 1.0
intensity_cd = 30.0
blink_ms = 70.0
lit_ms = 40.0
[[arena.fields]]
name = "scent"
background = 0.1
slope_per_m = [0.02, -0.01]
sources = [{ x_m = 1.0, y_m = 0.0, strength = 2.0, width_m = 0.7 }]
trail = { corner_m = [-3.0, -3.0], size_m = [6.0, 6.0], cell_m = 0.1, decay_s = 30.0, diffusion_m2_s = 0.01 }
[[arena.movers]]
name = "door"
outline_m = [[0.0, -0.02], [0.8, -0.02], [0.8, 0.02], [0.0, 0.02]]
x_m = 4.0
y_m = 3.0
swing = { to_rad = 1.5, rate_rad_s = 1.0, pause_s = 0.5 }
[[arena.movers]]
name = "person"
radius_m = 0.2
x_m = 4.5
y_m = 0.0
height_m = 1.7
wander = { speed_m_s = 0.5, turn_s = 2.0 }
[[arena.movers]]
name = "shuttle"
radius_m = 0.1
stops = { points_m = [[-3.5, 3.5], [1.0, 3.5]], speed_m_s = 0.4, pause_s = 0.2, then = "return" }
[[arena.movables]]
name = "box"
size_m = [0.3, 0.2]
x_m = 1.5
y_m = 0.1
mass_kg = 0.5
friction = 0.4
restitution = 0.2
height_m = 0.2
[[arena.movables]]
name = "ball"
radius_m = 0.1
x_m = 1.5
y_m = 1.0
mass_kg = 0.2
friction = 0.05
restitution = 0.8
[[arena.movables]]
name = "wedge"
outline_m = [[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]]
x_m = 3.0
y_m = 1.0
heading_rad = 0.3
mass_kg = 0.4
friction = 0.3
"#;

const DEVICES: &str = r#"
motors = { kind = "dc", noise_sigma = 0.02, noise_spread = 0.02, timeout_ms = 500.0 }
microcontroller = { framing_us_per_byte = 1.0, receiving_us_per_byte = 2.0, obeying_us = 10.0 }
firmware = { period_ms = 20.0, phase_ms = 1.0 }
link = { kind = "uart", baud = 500000, byte_error_rate = 0.0001 }
battery = { nominal_v = 12.0, capacity_mah = 20.0, internal_resistance_ohm = 0.1, idle_w = 1.0, charge = 0.9 }
[robots.actuators.head]
kind = "turret"
min_rad = -1.0
max_rad = 1.0
rate_rad_s = 3.0
dead_band_rad = 0.01
[robots.actuators.lamp]
kind = "lamp"
intensity_cd = 5.0
height_m = 0.4
[robots.actuators.voice]
kind = "speaker"
level = 1.5
[robots.actuators.gland]
kind = "dispenser"
field = "scent"
rate_per_s = 0.5
[robots.sensors.ir]
kind = "ir"
bearing_rad = 0.3
opening_rad = 0.5
rays = 3
range_m = 1.0
c1_m2 = 0.03
c2 = 0.1
sigma = 0.05
bits = 10
height_m = 0.05
[robots.sensors.lookup]
kind = "ir"
mount = { x_m = 0.1, y_m = 0.1, heading_rad = 0.7 }
opening_rad = 0.4
rays = 5
range_m = 2.0
lookup = { distances_m = [0.05, 0.5, 3.0], angles_rad = [0.0, 1.0], samples = [[[0.9, 0.8], [0.7, 0.6]], [[0.4, 0.5], [0.3]], [[0.1, 0.2], [0.05, 0.15]]] }
bits = 10
[robots.sensors.ambient]
kind = "ir"
bearing_rad = 1.5
opening_rad = 2.0
rays = 3
range_m = 1.0
ambient_saturation_lux = 50.0
noise = { uniform = 0.02 }
bits = 10
[robots.sensors.sharp]
kind = "ir-voltage"
mount = { x_m = 0.1 }
turret = "head"
opening_rad = 0.08
rays = 3
range_m = 0.8
curve_m_v = [[0.0, 0.9], [0.06, 2.9], [0.1, 2.3], [0.8, 0.4]]
idle_v = 0.3
supply_v = 5.0
clock = { period_ms = 38.3, spread_ms = 9.6, jitter_ms = 1.0, latency_ms = 2.0 }
noise = { additive = 0.015, gain_spread = 0.03 }
bits = 10
[robots.sensors.sonar]
kind = "sonar"
bearing_rad = 0.0
opening_rad = 0.7
rays = 7
min_m = 0.02
max_m = 3.0
detection = 0.9
holdoff_us = 750.0
timeout_ms = 18.5
cross_talk = true
period_ms = 60.0
noise = { additive = 0.01 }
bits = 16
[robots.sensors.laser]
kind = "laser"
mount = { heading_rad = 0.2 }
height_m = 0.25
opening_rad = 4.0
rays = 61
min_m = 0.02
range_m = 4.0
sweep_ms = 66.0
clockwise = true
clock = { period_ms = 100.0, spread_ms = 1.0, jitter_ms = 2.0 }
port = { link = { kind = "uart", baud = 115200, byte_error_rate = 0.0001 }, characters = 3, first_step = 44 }
noise = { additive = 0.005, dropout = { probability = 0.01, value = -1.0 } }
[robots.sensors.camera]
kind = "line-camera"
mount = { x_m = 0.1 }
opening_rad = 1.0
columns = 16
rows = 4
range_m = 5.0
background = [1, 2, 3]
period_ms = 50.0
port = { link = { kind = "ideal" } }
noise = { additive = 0.01 }
[robots.sensors.image]
kind = "camera"
mount = { x_m = 0.1 }
height_m = 0.3
opening_rad = 1.0
columns = 8
rows = 6
range_m = 5.0
period_ms = 50.0
port = { link = { kind = "ideal" } }
noise = { additive = 0.01 }
[robots.sensors.encoders]
kind = "encoders"
counts_per_turn = 600
quadrature = false
loss = 0.05
bits = 16
[robots.sensors.odometer]
kind = "odometer"
sigma_m = 0.001
bits = 16
[robots.sensors.flow]
kind = "optical-flow"
mount = { x_m = 0.1, y_m = -0.05, heading_rad = 1.0 }
counts_per_m = 1000000.0
max_speed_m_s = 2.0
gain_spread = 0.5
sigma_m = 0.1
bits = 8
[robots.sensors.compass]
kind = "compass"
sigma_rad = 0.02
hard_iron_rad = 0.1
hard_iron_phase_rad = 0.4
soft_iron_rad = 0.05
soft_iron_phase_rad = 0.2
clock = { period_ms = 15.0, spread_ms = 3.0 }
bits = 12
[robots.sensors.accelerometer]
kind = "accelerometer"
range_m_s2 = 20.0
bandwidth_hz = 40.0
noise = { additive = 0.05, offset_spread = 0.2 }
bits = 16
[robots.sensors.gyroscope]
kind = "gyroscope"
range_rad_s = 4.0
bandwidth_hz = 40.0
noise = { additive = 0.005, drift = { sigma = 0.02, time_constant_s = 10.0 } }
bits = 16
[robots.sensors.gps]
kind = "gps"
wander_sigma_m = 3.0
wander_time_s = 100.0
sigma_m = 0.5
speed_sigma_m_s = 0.05
reacquire_s = 0.5
satellites = true
period_ms = 200.0
port = { link = { kind = "uart", baud = 38400 } }
[robots.sensors.whisker]
kind = "whisker"
bearing_rad = -0.5
length_m = 5.0
active_low = true
bounce_ms = 40.0
bits = 1
[robots.sensors.bumper]
kind = "bumper"
opening_rad = 3.0
rays = 9
travel_m = 4.0
bounce_ms = 400.0
bits = 1
[robots.sensors.photoresistor]
kind = "photoresistor"
bearing_rad = 0.8
lag_s = 0.03
resistance_10lux_ohm = 10000.0
gamma = 0.7
capacitance_uf = 0.01
unit_us = 2.0
max_counts = 65535
period_ms = 40.0
noise = { additive = 2.0 }
bits = 16
[robots.sensors.light]
kind = "light"
bearing_rad = -0.8
opening_rad = 3.0
range_lux = 1000.0
lag_s = 0.02
noise = { multiplicative = 0.02 }
bits = 12
[robots.sensors.field]
kind = "field"
mount = { x_m = 0.1 }
field = "scent"
max = 5.0
noise = { spikes = { probability = 0.1, magnitude = 1.0 } }
bits = 12
[robots.sensors.microphone]
kind = "microphone"
axis_rad = 0.7
max = 10.0
noise = { additive = 0.01 }
bits = 12
[robots.sensors.floor]
kind = "floor"
mount = { x_m = 0.15 }
noise = { additive = 0.01 }
bits = 8
[robots.sensors.gauge]
kind = "battery"
noise = { additive = 0.02 }
bits = 10
[robots.sensors.strain]
kind = "strain-gauge"
opening_rad = 3.0
travel_m = 4.0
range_n = 50.0
bridge_mv_v = 2.0
bandwidth_hz = 20.0
noise = { additive = 0.01, offset_spread = 0.1 }
bits = 12
[robots.sensors.beacons]
kind = "ir-beacons"
mount = { x_m = 0.05 }
spots_m = [[0.0, 0.0], [0.0, 0.01]]
ceiling_m = 0.5
opening_rad = 3.0
sigma_rad = 1.0
clock = { period_ms = 30.0, jitter_ms = 5.0 }
bits = 16
"#;

/// A world of all there is, with robots of these names, whose places depend on the name alone.
pub(crate) fn everything(names: &[&str]) -> String {
    let mut toml = String::from(SURROUNDINGS);
    for name in names {
        let i = f64::from(name.as_bytes()[0] - b'a');
        let body = if i % 2.0 == 0.0 {
            "radius_m = 0.2, height_m = 0.4"
        } else {
            "outline_m = [[0.25, 0.15], [-0.15, 0.15], [-0.15, -0.15], [0.25, -0.15]], half_track_m = 0.15, height_m = 0.3, color = [0, 200, 0]"
        };
        toml += &format!(
            "[[robots]]\nname = \"{name}\"\nstart = {{ x_m = {}, y_m = {}, heading_rad = {} }}\n\
             body = {{ {body}, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }}\n{DEVICES}",
            0.9 * i - 0.4,
            0.2 * (i % 3.0),
            0.7 * i
        );
    }
    toml
}

/// Ticks of brains that drive and use all that they have.
pub(crate) fn act(world: &mut World, ticks: usize) {
    for i in 0..ticks {
        let turns = world.begin().to_vec();
        let answer = |turn: &baudbot_sim::Turn| {
            let spec = world.robot(turn.robot).spec();
            let wave = ((i / 20 + spec.name.len()) % 3) as f64 - 1.0;
            crate::devices::scene::signals(
                spec,
                &[0.5, 0.4 * wave, wave, 0.7, 0.5, 0.6][..2 + spec.actuators.len()],
            )
        };
        let bytes: Vec<_> = turns.iter().map(answer).collect();
        let inputs: Vec<_> = turns
            .iter()
            .zip(&bytes)
            .map(|(turn, bytes)| baudbot_sim::Input { robot: turn.robot, at: turn.at + 1_000_000, bytes })
            .collect();
        world.finish(&inputs);
    }
}

#[test]
fn the_order_of_robots_in_the_file_changes_nothing_with_every_device() {
    let hash = |names: &[&str]| {
        let mut world = world(&everything(names));
        act(&mut world, 400);
        (world.hash(), world.robots().map(|robot| robot.counters().collisions).sum::<u64>())
    };
    let sorted = hash(&["a", "b", "c", "d"]);
    assert_eq!(sorted, hash(&["d", "b", "a", "c"]));
    assert_eq!(sorted, hash(&["c", "d", "b", "a"]));
}

#[test]
fn a_clone_in_the_middle_of_a_run_goes_on_alike() {
    let mut one = world(&everything(&["a", "b", "c"]));
    act(&mut one, 137);
    let mut two = one.clone();
    assert_eq!(one.hash(), two.hash());
    // In the middle of a tick, too.
    one.begin();
    two.begin();
    let mut three = two.clone();
    for world in [&mut one, &mut two, &mut three] {
        world.finish(&[]);
        act(world, 100);
    }
    assert_eq!([two.hash(), three.hash()], [one.hash(); 2]);
}

#[test]
fn a_run_is_the_same_twice() {
    let hash = || {
        let mut world = world(&everything(&["a", "b"]));
        act(&mut world, 300);
        world.hash()
    };
    assert_eq!(hash(), hash());
}

#[test]
fn after_the_end_nothing_changes_any_more() {
    let mut world = world(&everything(&["a"]).replace("after_s = 1000.0", "after_s = 0.5"));
    act(&mut world, 60);
    assert!(world.ending().is_some());
    world.begin();
    let hash = world.hash();
    run(&mut world, 10, 0.5, 0.5);
    assert_eq!(world.hash(), hash);
}

#[test]
fn a_sensor_may_be_read_many_times_a_tick() {
    let toml =
        crate::devices::scene::with_sensor("", "kind = \"compass\"\nsigma_rad = 0.1\nperiod_ms = 0.01");
    let mut world = world(&toml);
    run(&mut world, 10, 0.0, 0.0);
    let compass = crate::devices::scene::view(&world, "s");
    assert_eq!((compass.samples, compass.missed), (10_000, 0));
}

#[test]
fn a_crowd_of_robots_with_every_device_runs() {
    let names: Vec<_> = (0..60).map(|i| format!("a{i}")).collect();
    let one = everything(&["a"]);
    let (surroundings, robot) = one.split_at(one.find("[[robots]]").unwrap());
    let mut toml =
        surroundings.replace("[-4.0, -4.0]", "[-4.0, -14.0]").replace("[6.0, -4.0]", "[6.0, -14.0]");
    for (i, name) in names.iter().enumerate() {
        let at = format!("x_m = {}, y_m = {}", -3.5 + 0.9 * (i % 10) as f64, -13.0 + 0.9 * (i / 10) as f64);
        toml +=
            &robot.replace("name = \"a\"", &format!("name = \"{name}\"")).replace("x_m = -0.4, y_m = 0", &at);
    }
    let mut world = world(&toml);
    act(&mut world, 50);
    assert!(
        world
            .robots()
            .all(|robot| robot.sensors().all(|sensor| sensor.sample.iter().all(|value| value.is_finite())))
    );
}

/// The places of the numbers in a file.
fn numbers(toml: &str) -> Vec<(usize, usize)> {
    let (mut found, mut quoted) = (Vec::new(), false);
    let bytes = toml.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        quoted ^= bytes[i] == b'"';
        let begins =
            !quoted && (bytes[i].is_ascii_digit() || bytes[i] == b'-') && matches!(bytes[i - 1], b' ' | b'[');
        let mut end = i + 1;
        if begins {
            while bytes[end].is_ascii_digit() || bytes[end] == b'.' {
                end += 1;
            }
            found.push((i, end));
        }
        i = end;
    }
    found
}

const FLOATS: [&str; 24] = [
    "0.0", "-0.0", "-1.0", "1e-9", "1e-320", "1e-30", "0.001", "0.01", "0.5", "1.0", "2.5", "10.0", "99.0",
    "1000.0", "1e5", "1e6", "1e9", "1e12", "1e38", "1e300", "-1e300", "nan", "inf", "-inf",
];
const WHOLE: [&str; 14] = [
    "0",
    "1",
    "2",
    "7",
    "8",
    "31",
    "32",
    "33",
    "255",
    "256",
    "4096",
    "65536",
    "4294967295",
    "9223372036854775807",
];

/// The file with these of its numbers, counted round, replaced by those.
fn spoilt(toml: &str, changes: &[(usize, usize)]) -> String {
    let places = numbers(toml);
    let mut changes: Vec<_> =
        changes.iter().map(|&(place, value)| (places[place % places.len()], value)).collect();
    changes.sort();
    changes.dedup_by_key(|change| change.0);
    let mut spoilt = toml.to_string();
    for ((start, end), value) in changes.into_iter().rev() {
        let whole = !toml[start..end].contains('.');
        let value = if whole { WHOLE[value % WHOLE.len()] } else { FLOATS[value % FLOATS.len()] };
        spoilt.replace_range(start..end, value);
    }
    spoilt
}

/// Parses and, if that is a scenario, runs it for a while, in which every reading is a number. Returns how that ended.
fn survives(toml: &str) -> Option<u64> {
    let scenario = baudbot_scenario::parse(toml).ok()?;
    let mut world = World::new(scenario.into());
    act(&mut world, 20);
    for robot in world.robots() {
        for (sensor, view) in robot.spec().sensors.iter().zip(robot.sensors()) {
            assert!(view.sample.iter().all(|value| !value.is_nan()), "{}: {:?}", sensor.name, view.sample);
        }
    }
    Some(world.hash())
}

#[test]
fn numbers_are_found_and_replaced() {
    let toml = everything(&["a"]);
    assert!(numbers(&toml).len() > 250, "{}", numbers(&toml).len());
    assert!(survives(&toml).is_some());
    let spoilt = spoilt("a = 1.5\nb = [2, 3]\nc = \"x 4\"\n", &[(0, 0), (2, 5)]);
    assert_eq!(spoilt, "a = 0.0\nb = [2, 31]\nc = \"x 4\"\n");
}

#[test]
fn no_number_in_any_field_makes_anything_panic_or_a_reading_none() {
    let toml = everything(&["a"]);
    let mut ran = 0;
    for place in 0..numbers(&toml).len() {
        // Each number is tried in half of all fields.
        for value in (0..FLOATS.len()).filter(|value| (place + value) % 2 == 0) {
            ran += usize::from(survives(&spoilt(&toml, &[(place, value)])).is_some());
        }
    }
    assert!(ran > 500, "{ran}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_numbers_together_make_anything_panic(changes in proptest::collection::vec((0usize..1000, 0usize..100), 1..4)) {
        survives(&spoilt(&everything(&["a", "b"]), &changes));
    }
}
