//! Events of a robot in the scenario `wander`, made up for tests.

use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::{Event, What};
use baudbot_sim::{Scenario, SimTime};

use super::pins::Pins;
use super::record::Kept;

/// The scenario and so many cycles of 20 ms from an instant on, in the order of their ends. In each the five sensors
/// are read, 19 bytes go up at 9600 baud, the brain thinks for 15 ms, and 7 bytes come down.
pub(super) fn wander(start_ns: u64, cycles: u64) -> (Scenario, Vec<Event>) {
    let scenario = baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/wander.toml")).unwrap();
    let mut events: Vec<_> =
        (0..cycles).flat_map(|cycle| one(start_ns.saturating_add(cycle * 20_000_000))).collect();
    events.sort_by_key(|event| event.end);
    (scenario, events)
}

/// These events in the form in which a run keeps them.
pub(super) fn kept(robot: &RobotSpec, events: Vec<Event>) -> Kept {
    Kept { events, said: Vec::new(), pins: Pins::new(robot) }
}

/// A cycle that begins at an instant.
fn one(start_ns: u64) -> Vec<Event> {
    let event = |from_us: u64, until_us: u64, what| Event {
        start: SimTime::from_ns(start_ns) + from_us * 1000,
        end: SimTime::from_ns(start_ns) + until_us * 1000,
        what,
    };
    let reads =
        (0..5).map(|i| event(112 * u64::from(i), 112 * u64::from(i + 1), What::Acquire { sensor: i }));
    let rest = [
        event(560, 600, What::Frame { bytes: 19 }),
        event(600, 20_392, What::Up { bytes: 19 }),
        event(20_392, 35_392, What::Think { informed: true }),
        event(35_392, 42_684, What::Down { bytes: 7 }),
        event(36_434, 42_700, What::Obey),
        event(43_000, 43_000, What::Act),
    ];
    reads.chain(rest).collect()
}

/// A robot with an adapter in its cable and a laser with a port of its own, and so many of its cycles of 40 ms, in
/// which much goes wrong.
pub(super) fn scout(cycles: u64) -> (Scenario, Vec<Event>) {
    let scenario = baudbot_scenario::parse(SCOUT).unwrap();
    let mut events: Vec<_> = (0..cycles).flat_map(|cycle| trouble(cycle * 40_000)).collect();
    events.sort_by_key(|event| event.end);
    (scenario, events)
}

/// A cycle that begins at an instant, in microseconds.
fn trouble(start_us: u64) -> Vec<Event> {
    let spans = [
        (0, 2500, What::Acquire { sensor: 0 }),
        (2500, 11_000, What::Acquire { sensor: 1 }),
        (1000, 27_000, What::Measure { sensor: 2 }),
        (11_000, 11_200, What::Frame { bytes: 12 }),
        (11_200, 13_000, What::Block),
        (11_200, 17_400, What::Up { bytes: 12 }),
        (17_400, 18_000, What::Adapter),
        (27_000, 55_500, What::Port { sensor: 2, bytes: 2137 }),
        (18_000, 24_000, What::Think { informed: true }),
        (24_000, 28_200, What::Down { bytes: 7 }),
        (28_000, 28_300, What::Obey),
        (29_000, 29_000, What::Act),
        (10_000, 10_000, What::Late),
        (13_000, 13_000, What::Missed { sensor: u16::MAX }),
        (13_000, 13_000, What::Missed { sensor: 0 }),
        (20_000, 20_000, What::Lost { bytes: 2 }),
        (15_000, 32_000, What::Fault { fault: 0 }),
    ];
    let at = |us: u64| SimTime::from_ns((start_us + us) * 1000);
    spans.map(|(start, end, what)| Event { start: at(start), end: at(end), what }).to_vec()
}

const SCOUT: &str = r#"
    [[robots]]
    name = "scout"
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
    link = { kind = "uart", baud = 19200, adapter = { kind = "ftdi" } }
    sensors.compass = { kind = "compass" }
    sensors.sonar = { kind = "sonar", mount = {}, opening_rad = 0.3, rays = 3, min_m = 0.1, max_m = 3.0 }

    [robots.sensors.laser]
    kind = "laser"
    bearing_rad = 0.0
    opening_rad = 1.0
    rays = 5
    range_m = 4.0
    period_ms = 100.0
    port = { link = { kind = "uart", baud = 19200 } }
"#;
