//! The remedies of a robot: the scenario with a remedy's overrides has the budget that the remedy foretells.

use baudbot_scenario::Override;
use baudbot_scenario::budget::{Budget, Cost, Remedy, RobotBudget, Verdict};
use baudbot_sim::Scenario;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::budget::random::scenarios;
use crate::common::{BODY, WANDER};

fn scenario(toml: &str, changes: &[String]) -> Scenario {
    let changes: Vec<_> = changes.iter().map(|text| Override::parse(text).unwrap()).collect();
    baudbot_scenario::parse_with(toml, &changes)
        .unwrap_or_else(|error| panic!("{error}\n{changes:?}\n{toml}"))
}

fn budget(toml: &str, changes: &[&str]) -> RobotBudget {
    let changes: Vec<_> = changes.iter().map(|&text| text.to_owned()).collect();
    Budget::of(&scenario(toml, &changes)).robots.remove(0)
}

/// Makes the changes that a remedy asks for; what the budget is then.
fn mended(toml: &str, changes: &[&str], remedy: &Remedy) -> RobotBudget {
    let all: Vec<_> = changes.iter().map(|&text| text.to_owned()).chain(remedy.overrides.clone()).collect();
    let scenario = scenario(toml, &all);
    RobotBudget::without_remedies(&scenario, &scenario.robots[0])
}

/// Checks each remedy that has the form of overrides; returns all of them in words.
fn check(toml: &str, changes: &[&str]) -> Vec<String> {
    let robot = budget(toml, changes);
    assert_eq!(robot.verdict == Verdict::Misses, !robot.remedies.is_empty(), "{robot:?}");
    assert!(robot.remedies.is_sorted_by_key(|remedy| remedy.cost), "{:?}", robot.remedies);
    for remedy in robot.remedies.iter().filter(|remedy| !remedy.overrides.is_empty()) {
        let after = mended(toml, changes, remedy);
        let found = (after.step_ns, after.cycle.total, after.verdict);
        assert_eq!(found, (remedy.step_ns, remedy.total, remedy.verdict), "{remedy:?}\n{toml}");
        assert!(remedy.verdict != Verdict::Misses);
    }
    robot.remedies.into_iter().map(|remedy| remedy.what).collect()
}

fn has(remedies: &[String], what: &str) {
    assert!(remedies.iter().any(|remedy| remedy == what), "no `{what}` in {remedies:?}");
}

#[test]
fn a_faster_cable_mends_wander() {
    let remedies = check(WANDER, &[]);
    has(&remedies, "38400 baud");
    // A step of 30 ms would not do: every second message would wait for the next step.
    has(&remedies, "a step of 50 ms");
}

#[test]
fn a_chip_that_waits_is_told_not_to() {
    let polled = |baud: u32| {
        format!(
            "step_ms = 10.0\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
             firmware = {{ protocol = \"bare\", mode = \"poll\" }}\n\
             link = {{ kind = \"uart\", baud = {baud}, adapter = {{ kind = \"ftdi\" }} }}\n\
             [robots.sensors.c]\nkind = \"compass\"\nbits = 32\n"
        )
    };
    let remedies = check(&polled(115_200), &[]);
    assert_eq!(remedies[0], "a latency timer of 1 ms");
    has(&remedies, "an adapter without a latency timer");
    // Of a chip as it was measured, too: what it adds to the frames of the bus stays.
    let real = polled(115_200).replace("kind = \"ftdi\"", "preset = \"ft232r\"");
    let remedies = check(&real, &[]);
    assert_eq!(remedies[0], "a latency timer of 1 ms");
    has(&remedies, "an adapter without a latency timer");
    let total = |toml: String| budget(&toml, &["robots.r.link.adapter.latency_ms=1"]).cycle.total;
    assert_ne!(total(polled(115_200)), total(real));
    // A latency timer of 1 ms is not enough at 1200 baud.
    let remedies = check(&polled(1200), &[]);
    assert_eq!(remedies[0], "a latency timer of 1 ms and 9600 baud");
}

#[test]
fn a_laser_is_given_a_faster_port() {
    let toml = format!(
        "step_ms = 10.0\n[[robots]]\nname = \"r\"\n{BODY}\n[robots.sensors.urg]\nkind = \"laser\"\n\
         mount = {{ x_m = 0.0 }}\nrays = 682\nopening_rad = 4.18\nrange_m = 4.0\nperiod_ms = 100.0\n\
         port = {{ link = {{ kind = \"uart\", baud = 115200 }} }}\n"
    );
    assert_eq!(check(&toml, &[])[0], "230400 baud on the port of urg");
}

#[test]
fn a_brain_on_board_gets_another_chip_or_a_laptop() {
    let toml = include_str!("../../../../catalogue/scenarios/devices/onboard.toml");
    let dc = ["robots.robot.motors={ kind = \"dc\", signal_bits = 8 }", "substeps=1000"];
    let remedies = check(toml, &dc);
    has(&remedies, "the processor basicx");
    has(&remedies, "a laptop on the robot, at 115200 baud");
}

/// Changes that make a robot slow, so that there is something to fix.
const SQUEEZES: [&str; 9] = [
    "link={ kind = \"uart\", baud = 1200 }",
    "link={ kind = \"uart\", baud = 9600, adapter = { kind = \"ftdi\" } }",
    "link={ kind = \"uart\", baud = 4800, adapter = { kind = \"bluetooth\" } }",
    "link={ kind = \"uart\", baud = 19200, bits_per_character = 8, adapter = { kind = \"cdc\", frame_ms = 20 } }",
    "brain.deadline_ms=3",
    "firmware={ protocol = \"khepera\" }",
    "firmware={ protocol = \"bare\", mode = \"poll\", gap_ms = 15.0 }",
    "link={ preset = \"uart-9600\", adapter = { preset = \"ft232r\" } }",
    "microcontroller={ preset = \"bs2\", bootloader_s = 0.3007 }",
];

/// Checks the remedies of each robot, with changes that the scenario may refuse; returns what they are.
fn check_if_sound(toml: &str, changes: &[String]) -> Vec<String> {
    let parsed: Vec<_> = changes.iter().map(|text| Override::parse(text).unwrap()).collect();
    let Ok(scenario) = baudbot_scenario::parse_with(toml, &parsed) else { return Vec::new() };
    let mut names = Vec::new();
    for (i, robot) in Budget::of(&scenario).robots.into_iter().enumerate() {
        for remedy in robot.remedies.iter().filter(|remedy| !remedy.overrides.is_empty()) {
            let all = [changes, &remedy.overrides].concat();
            let scenario = self::scenario(toml, &all);
            let after = RobotBudget::without_remedies(&scenario, &scenario.robots[i]);
            let found = (after.step_ns, after.cycle.total, after.verdict);
            assert_eq!(
                found,
                (remedy.step_ns, remedy.total, remedy.verdict),
                "{remedy:?}\n{changes:?}\n{toml}"
            );
            names.push(remedy.what.clone());
        }
    }
    names
}

#[test]
fn what_is_promised_of_each_device_is_what_comes_of_it() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../catalogue/scenarios/devices");
    let mut remedies = Vec::new();
    for file in std::fs::read_dir(folder).unwrap() {
        let toml = std::fs::read_to_string(file.unwrap().path()).unwrap();
        let Some(robot) =
            baudbot_scenario::parse(&toml).unwrap().robots.first().map(|robot| robot.name.clone())
        else {
            continue;
        };
        let at = |squeeze: &&str| format!("robots.{robot}.{squeeze}");
        remedies.extend(check_if_sound(&toml, &[]));
        for squeeze in &SQUEEZES {
            remedies.extend(check_if_sound(&toml, &[at(squeeze)]));
            remedies.extend(check_if_sound(&toml, &[at(squeeze), at(&SQUEEZES[0])]));
        }
    }
    remedies.sort_unstable();
    remedies.dedup();
    for kind in ["baud", "latency", "8 bits", "bare", "without polls", "step of", "USB", "without a latency"]
    {
        assert!(remedies.iter().any(|remedy| remedy.contains(kind)), "no remedy was `{kind}`: {remedies:?}");
    }
}

#[test]
fn a_khepera_speaks_only_when_asked_and_is_never_told_to_stream() {
    let device = include_str!("../../../../catalogue/scenarios/devices/khepera-ascii.toml");
    let mut plain = format!(
        "[[robots]]\nname = \"khepera\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         firmware = {{ protocol = \"khepera\" }}\nlink = {{ kind = \"uart\", baud = 9600 }}\n"
    );
    for i in 0..8 {
        plain += &format!("[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 10\nperiod_ms = 20.0\n");
    }
    let mut remedies = Vec::new();
    for (toml, step_ms) in [(device, 1), (device, 10), (device, 40), (&plain, 10), (&plain, 20), (&plain, 40)]
    {
        for baud in [4800, 9600, 19_200] {
            let changes = [format!("step_ms={step_ms}"), format!("robots.khepera.link.baud={baud}")];
            remedies.extend(check_if_sound(toml, &changes));
        }
    }
    assert!(remedies.iter().all(|remedy| !remedy.contains("without polls")), "{remedies:?}");
    has(&remedies, "38400 baud");
}

#[test]
fn a_cable_with_byte_errors_is_not_told_to_be_usb() {
    let toml = include_str!("../../../../catalogue/scenarios/wander.toml");
    let fault = "[{ kind = \"byte-errors\", from_s = 1.0, for_s = 1.0, byte_error_rate = 0.1 }]";
    let remedies = check(toml, &[&format!("robots.robot.faults={fault}")]);
    assert!(remedies.iter().all(|remedy| !remedy.contains("USB")), "{remedies:?}");
    has(&remedies, "38400 baud");
    has(&check(toml, &[]), "a microcontroller with USB");
}

#[test]
fn a_deadline_stays_when_the_brain_moves_to_a_laptop() {
    let toml = include_str!("../../../../catalogue/scenarios/devices/onboard.toml");
    let changes = ["robots.robot.brain.deadline_ms=25", "robots.robot.brain.on_late=\"stop\""];
    let remedies = check_if_sound(toml, &changes.map(str::to_owned));
    has(&remedies, "a laptop on the robot, at 115200 baud");
}

#[test]
fn slow_ports_are_made_faster_together() {
    let mut toml = format!("step_ms = 10.0\n[[robots]]\nname = \"r\"\n{BODY}\n");
    for (name, baud) in [("a", 115_200), ("b", 57_600), ("c", 750_000)] {
        toml += &format!(
            "[robots.sensors.{name}]\nkind = \"laser\"\nmount = {{ x_m = 0.0 }}\nrays = 682\n\
             opening_rad = 4.18\nrange_m = 4.0\nperiod_ms = 100.0\n\
             port = {{ link = {{ kind = \"uart\", baud = {baud} }} }}\n"
        );
    }
    let remedies = check(&toml, &[]);
    assert_eq!(remedies[0], "230400 baud on the ports of a, b");
}

#[test]
fn what_costs_less_comes_first() {
    let robot = budget(WANDER, &[]);
    let costs: Vec<_> = robot.remedies.iter().map(|remedy| remedy.cost).collect();
    assert_eq!(costs.first(), Some(&Cost::BothEnds), "{costs:?}");
    assert!(costs.contains(&Cost::LongerStep), "{costs:?}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 40,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_scenario_that_is_mended_has_the_budget_that_was_foretold(toml in scenarios()) {
        let robot = budget(&toml, &[]);
        for remedy in robot.remedies.iter().filter(|remedy| !remedy.overrides.is_empty()) {
            let after = mended(&toml, &[], remedy);
            let found = (after.step_ns, after.cycle.total, after.verdict);
            prop_assert_eq!(found, (remedy.step_ns, remedy.total, remedy.verdict), "{:?}\n{}", remedy, toml);
        }
    }
}
