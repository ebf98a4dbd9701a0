//! Well-known numbers: as the budget has them, and as they are in a run.

use std::fmt::Write;

use baudbot_sim::Scenario;
use baudbot_sim::budget::{Budget, RobotBudget, Verdict};

use crate::common::{BODY, KHEPERA};
use crate::run::{per_s, run};

/// A robot with `sensors` compasses of one byte each, as in `timing.rs`.
fn bare(sensors: usize, link: &str) -> String {
    let mut toml = format!(
        "step_ms = 0.5\n[[robots]]\nname = \"r\"\n{BODY}\nmotors = {{ signal_bits = 8 }}\n\
         firmware = {{ protocol = \"bare\", mode = \"poll\" }}\nlink = {{ kind = \"uart\", {link} }}\n"
    );
    for i in 0..sensors {
        writeln!(toml, "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 8").unwrap();
    }
    toml
}

/// A URG-04LX on a cable of its own.
fn laser(baud: u32) -> String {
    format!(
        "step_ms = 10.0\n[[robots]]\nname = \"r\"\n{BODY}\n[robots.sensors.urg]\nkind = \"laser\"\n\
         mount = {{ x_m = 0.0 }}\nrays = 682\nopening_rad = 4.18\nrange_m = 4.0\nperiod_ms = 100.0\n\
         port = {{ link = {{ kind = \"uart\", baud = {baud} }} }}\n"
    )
}

fn budget(toml: &str) -> RobotBudget {
    Budget::of(&Scenario::parse(toml).unwrap_or_else(|error| panic!("{error}"))).robots.remove(0)
}

fn most_per_s(robot: &RobotBudget, what: &str) -> f64 {
    let rate = robot.rates.iter().find(|rate| rate.what == what);
    rate.unwrap_or_else(|| panic!("no {what} in {:?}", robot.rates)).most_per_s.unwrap()
}

/// Adds a row, and says how far the two are apart, as a share.
fn row(table: &mut String, what: &str, foretold: f64, measured: f64) -> f64 {
    writeln!(table, "{what:<52} {foretold:>10.2} {measured:>10.2}").unwrap();
    (foretold - measured).abs() / measured
}

#[test]
fn known_numbers_are_foretold_and_measured() {
    let mut table = format!("{:<52} {:>10} {:>10}\n", "", "foretold", "measured");
    let polled = [
        ("6 bytes at 9600 baud, 8 bits: exchanges/s", bare(4, "baud = 9600, bits_per_character = 8")),
        ("6 bytes at 9600 baud, 8N1: exchanges/s", bare(4, "baud = 9600")),
        (
            "the same behind an FTDI chip, 16 ms: exchanges/s",
            bare(4, "baud = 38400, adapter = { kind = \"ftdi\" }"),
        ),
        (
            "6 bytes at 38400 baud on a shared wire: exchanges/s",
            bare(4, "baud = 38400, half_duplex = true, turnaround_us = 500"),
        ),
    ];
    let mut apart = Vec::new();
    for (what, toml) in polled {
        let measured = run(Scenario::parse(&toml).unwrap(), 4.0).messages_per_s();
        apart.push(row(&mut table, what, most_per_s(&budget(&toml), "exchanges"), measured));
    }
    for (what, baud) in
        [("URG-04LX at 115200 baud: scans/s", 115_200), ("URG-04LX at 750000 baud: scans/s", 750_000)]
    {
        let robot = budget(&laser(baud));
        let urg = robot.rates.iter().find(|rate| rate.what == "port urg").unwrap();
        let measured = run(Scenario::parse(&laser(baud)).unwrap(), 20.0);
        apart.push(row(&mut table, what, urg.typical_per_s.unwrap(), per_s(&measured.readable[0])));
    }
    let measured = run(Scenario::parse(KHEPERA).unwrap(), 4.0);
    let khepera = budget(KHEPERA);
    apart.push(row(
        &mut table,
        "Khepera: readings/s of an IR sensor",
        most_per_s(&khepera, "sensor ir_0"),
        per_s(&measured.readable[0]),
    ));
    insta::assert_snapshot!(table);
    assert!(apart.iter().all(|share| *share < 0.01), "{apart:?}\n{table}");
}

#[test]
fn a_laser_that_its_cable_cannot_carry_is_the_bottleneck() {
    let robot = budget(&laser(115_200));
    assert_eq!((robot.verdict, robot.bottleneck.as_str()), (Verdict::Misses, "the port urg"));
    let share = robot.loads.iter().find(|load| load.what == "port urg").unwrap().share;
    assert!((share - 1.855).abs() < 0.001, "{share}");
    assert!(budget(&laser(750_000)).verdict != Verdict::Misses);
}

#[test]
fn a_basic_stamp_does_40_operations_in_10_ms_and_has_26_bytes() {
    let toml = include_str!("../../../scenarios/devices/onboard.toml");
    let chip = budget(toml).chip;
    assert_eq!((chip.operations_per_step, chip.brain_operations), (Some(40.0), Some(120.0)));
    assert_eq!((chip.ram_bytes, chip.brain_memory_bytes), (Some(26), Some(20)));
    // 120 operations are 30 ms: the processor has three times too much to do.
    let robot = budget(toml);
    assert_eq!((robot.verdict, robot.bottleneck.as_str()), (Verdict::Misses, "the processor"));
}

#[test]
fn an_ideal_robot_keeps_its_step_in_no_time() {
    let robot = budget(crate::common::ARSIM);
    assert_eq!(robot.cycle.total.typical_ns, Some(0));
    assert!(robot.verdict != Verdict::Misses && robot.mends.is_empty(), "{robot:?}");
}
