//! Scenarios that would take too long: they are refused, or their budget states what it left out.

use std::fmt::Write;

use baudbot_scenario::budget::{Allowance, Budget, RobotBudget, Verdict};
use baudbot_sim::Scenario;

use crate::common::{BODY, WANDER, refusal};

/// Robots with slow sensors and slow ports, so that a dry run has much to do and hardly anything helps.
fn hostile(robots: usize, ports: usize) -> Scenario {
    let mut toml = "step_ms = 1.0\n".to_owned();
    for r in 0..robots {
        write!(
            toml,
            "[[robots]]\nname = \"r{r}\"\nstart = {{ x_m = {r} }}\n{BODY}\nmotors = {{ signal_bits = 16 }}\n\
             microcontroller = {{ framing_us_per_byte = 10, receiving_us_per_byte = 10, obeying_us = 5000 }}\n\
             link = {{ kind = \"uart\", baud = 1200, adapter = {{ kind = \"ftdi\" }} }}\n\
             firmware = {{ protocol = \"bare\", mode = \"poll\" }}\n"
        )
        .unwrap();
        for i in 0..20 {
            writeln!(
                toml,
                "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 16\nperiod_ms = {}\nacquisition_us = 40",
                1.0 + f64::from(i) / 10.0
            )
            .unwrap();
        }
        for i in 0..ports {
            writeln!(
                toml,
                "[robots.sensors.p{i}]\nkind = \"laser\"\nmount = {{ x_m = 0.0 }}\nrays = 20\nopening_rad = 4.0\n\
                 range_m = 4.0\nperiod_ms = 100.0\nport = {{ link = {{ kind = \"uart\", baud = 57600 }} }}"
            )
            .unwrap();
        }
    }
    baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}"))
}

fn onboard(operations: u64) -> String {
    format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nlink = {{ kind = \"onboard\" }}\n\
         microcontroller = {{ operations_per_s = 1.0 }}\nbrain = {{ operations = {operations} }}\n\
         [robots.sensors.c]\nkind = \"compass\"\nperiod_ms = 10.0\n"
    )
}

#[test]
fn operations_that_take_longer_than_thinking_may_are_refused() {
    let message = refusal(&onboard(9_000_000_000_000_000_000));
    assert!(message.starts_with("robots[0].brain.operations: must be done in 1000 s or less"), "{message}");
    assert!(
        message.contains("operations_per_s = 1, 9000000000000000000 take 9000000000000000000 s"),
        "{message}"
    );
    assert!(refusal(&onboard(1001)).contains("take 1001 s"));
    let longest = baudbot_scenario::parse(&onboard(1000)).unwrap();
    assert_eq!(Budget::of(&longest).robots[0].verdict, Verdict::Misses);
}

#[test]
fn a_robot_for_which_too_much_could_be_tried_says_that_not_all_was() {
    for ports in [100, 200] {
        let scenario = hostile(1, ports);
        let mut allowance = Allowance::of_a_call();
        let robot = RobotBudget::within(&scenario, &scenario.robots[0], &mut allowance);
        assert_eq!(robot.verdict, Verdict::Misses);
        let left_out = robot.left_out.unwrap_or_default();
        assert!(left_out.starts_with("not every possible fix was tried"), "{ports} ports: {left_out:?}");
        // One robot uses up no more than its part of a call.
        assert!(!allowance.is_used_up(), "{ports} ports: {allowance:?}");
    }
}

#[test]
fn robots_that_come_after_the_allowance_of_a_call_get_no_mends_and_say_so() {
    let scenario = hostile(7, 100);
    let mut allowance = Allowance::of_a_call();
    let of = |spec| RobotBudget::within(&scenario, spec, &mut allowance);
    let robots: Vec<_> = scenario.robots.iter().map(of).collect();
    let beyond = robots.iter().filter(|robot| {
        robot.left_out.as_ref().is_some_and(|why| why.starts_with("no fixes were searched for"))
    });
    assert_eq!(beyond.map(|robot| robot.remedies.len()).collect::<Vec<_>>(), [0, 0, 0]);
    assert!(allowance.is_used_up());
}

#[test]
fn an_ordinary_robot_has_everything_tried() {
    let robot = Budget::of(&baudbot_scenario::parse(WANDER).unwrap()).robots.remove(0);
    assert!(robot.left_out.is_none() && !robot.remedies.is_empty(), "{robot:?}");
}

/// A robot that answers polls with 20 bytes by radio.
fn by_radio(packet_bytes: u32, laptop_buffer_bytes: u32) -> RobotBudget {
    let mut toml = format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         firmware = {{ protocol = \"bare\", mode = \"poll\" }}\n\
         link = {{ kind = \"uart\", baud = 115200, laptop_buffer_bytes = {laptop_buffer_bytes}, \
         adapter = {{ kind = \"bluetooth\", packet_bytes = {packet_bytes} }} }}\n"
    );
    for i in 0..20 {
        writeln!(toml, "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 8").unwrap();
    }
    let scenario = baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}"));
    Budget::of(&scenario).robots.remove(0)
}

#[test]
fn a_cycle_by_radio_has_a_bound_if_a_message_fits_into_a_packet_and_three_into_the_laptops_buffer() {
    let has_bound = |robot: RobotBudget| robot.cycle.total.worst_ns.is_some();
    assert!(has_bound(by_radio(20, 60)));
    assert!(!has_bound(by_radio(19, 60)));
    assert!(!has_bound(by_radio(20, 59)));
}
