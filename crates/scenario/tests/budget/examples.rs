//! Well-known numbers: by the budget, and in a run.

use std::fmt::Write;

use baudbot_scenario::budget::{Budget, RobotBudget, Verdict};
use baudbot_sim::sensor::port::Format;
use baudbot_sim::timeline::What;
use baudbot_sim::{Input, World};

use crate::budget::run::{per_s, run};
use crate::common::{BODY, KHEPERA};

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
    Budget::of(&baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}"))).robots.remove(0)
}

#[test]
fn a_dead_time_is_stated_and_no_part_of_the_cycle() {
    let [with, without] = ["", "motors = { dead_time_ms = 0.0 }\n"]
        .map(|fields| budget(&format!("[[robots]]\nname = \"c\"\npreset = \"create-2\"\n{fields}")));
    assert_eq!((with.dead_time_ns, without.dead_time_ns), (100_000_000, 0));
    assert_eq!(RobotBudget { dead_time_ns: 0, ..with }, without);
}

fn most_per_s(robot: &RobotBudget, what: &str) -> f64 {
    let rate = robot.rates.iter().find(|rate| rate.what == what);
    rate.unwrap_or_else(|| panic!("no {what} in {:?}", robot.rates)).most_per_s.unwrap()
}

/// Adds a row, and returns how far the two are apart, as a share.
fn row(table: &mut String, what: &str, foretold: f64, measured: f64) -> f64 {
    writeln!(table, "{what:<52} {foretold:>10.2} {measured:>10.2}").unwrap();
    (foretold - measured).abs() / measured
}

/// A Khepera that is asked in lines of text, all of whose eight sensors have the reading `code`: compasses, which stand
/// for any.
fn lines_of_text(code: f64) -> String {
    let heading = -core::f64::consts::PI + code * core::f64::consts::TAU / 1023.0;
    let mut toml = format!(
        "step_ms = 0.5\nnoise = false\n[[robots]]\nname = \"r\"\nstart = {{ heading_rad = {heading} }}\n{BODY}\n\
         motors = {{ signal_bits = 8 }}\nfirmware = {{ protocol = \"khepera\" }}\n\
         link = {{ kind = \"uart\", baud = 9600, bits_per_character = 11 }}\n"
    );
    for i in 0..8 {
        writeln!(toml, "[robots.sensors.s{i}]\nkind = \"compass\"\nbits = 10").unwrap();
    }
    toml
}

/// A laser on a cable of its own that answers when it is asked.
fn asked_laser(baud: u32) -> String {
    format!(
        "step_ms = 0.5\nnoise = false\n[[robots]]\nname = \"r\"\n{BODY}\n[robots.sensors.urg]\nkind = \"laser\"\n\
         mount = {{ x_m = 0.0 }}\nrays = 682\nopening_rad = 4.18\nrange_m = 4.0\nclock = {{ period_ms = 100.0 }}\n\
         port = {{ dialogue = \"asked\", model = \"urg-04lx\", link = {{ kind = \"uart\", baud = {baud} }} }}\n"
    )
}

/// The rate at which such a laser answers a program that lights it, and then asks for all of the newest scan as soon
/// as it has the one before.
fn scans_per_s(toml: &str) -> f64 {
    let scenario = baudbot_scenario::parse(toml).unwrap();
    let Some(Format::Scip(format)) =
        scenario.robots[0].sensors[0].port.as_ref().map(|port| port.format.clone())
    else {
        panic!("no laser that speaks SCIP")
    };
    let question = format!("GD{:04}{:04}{:02}\n", format.first_step, format.last_step, format.cluster);
    let mut world = World::new(scenario.into());
    let (mut heard, mut answers) = (Vec::new(), Vec::new());
    for tick in 0..20_000 {
        let turn = world.begin()[0];
        heard.extend_from_slice(world.robot(0).unread_of_ports().next().unwrap().1);
        let said: &[u8] = match tick {
            0 => b"BM\n",
            // The mirror has turned by then.
            600 => question.as_bytes(),
            _ if heard.len() == format.answer_len() && heard.starts_with(b"GD") => {
                answers.push(turn.at.as_seconds());
                question.as_bytes()
            }
            _ => b"",
        };
        if !said.is_empty() {
            heard.clear();
            assert!(world.write_port(0, 0, turn.at, said));
        }
        world.finish(&[]);
    }
    per_s(&answers)
}

/// The polls a second of a brain that asks again as soon as readings have come.
fn polls_per_s(toml: &str) -> f64 {
    let mut world = World::new(baudbot_scenario::parse(toml).unwrap().into());
    let (mut asks, mut arrivals) = (true, Vec::new());
    for _ in 0..8000 {
        let turn = world.begin()[0];
        if world.robot(0).readings()[0].readable {
            arrivals.push(turn.at.as_seconds());
            asks = true;
        }
        let bytes: &[u8] = if core::mem::take(&mut asks) { b"N\r" } else { &[] };
        world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
    }
    per_s(&arrivals)
}

/// The rate at which a Khepera answers a program that sends this line as soon as it has the answer to the one before.
fn lines_per_s(toml: &str, line: &[u8]) -> f64 {
    let mut world = World::new(baudbot_scenario::parse(toml).unwrap().into());
    let (mut asks, mut arrivals) = (true, Vec::new());
    for _ in 0..40_000 {
        let turn = world.begin()[0];
        if world.robot(0).unread().ends_with(b"\n") {
            arrivals.push(turn.at.as_seconds());
            asks = true;
        }
        let bytes = if core::mem::take(&mut asks) { line } else { b"" };
        world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
    }
    per_s(&arrivals)
}

/// The rate at which a Create answers a program that asks for this group as soon as it has the answer, of so many bytes.
fn queries_per_s(toml: &str, group: u8, len: usize) -> f64 {
    let mut world = World::new(baudbot_scenario::parse(toml).unwrap().into());
    let (mut asks, mut heard, mut answers, mut starts) = (true, 0, Vec::new(), true);
    for _ in 0..40_000 {
        let turn = world.begin()[0];
        heard += world.robot(0).unread().len();
        if heard == len {
            answers.push(turn.at.as_seconds());
            (heard, asks) = (0, true);
        }
        let said =
            if core::mem::take(&mut starts) { [128, 142, group].to_vec() } else { [142, group].to_vec() };
        let bytes: &[u8] = if core::mem::take(&mut asks) { &said } else { &[] };
        world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
    }
    per_s(&answers)
}

/// A BASIC Stamp whose program does 40 operations a step.
fn onboard_thinking() -> String {
    format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nmicrocontroller = {{ preset = \"bs2\" }}\n\
         link = {{ kind = \"onboard\" }}\nbrain = {{ operations = 40 }}\n\
         firmware = {{ period_ms = 10.0 }}\n[robots.sensors.c]\nkind = \"compass\"\nperiod_ms = 10.0\n"
    )
}

/// The operations by the shortest thought on the timeline, one that did not wait for the processor.
fn operations_in_10_ms(toml: &str) -> f64 {
    let world = run(baudbot_scenario::parse(toml).unwrap(), 2.0).world;
    let thoughts =
        world.robot(0).timeline().events().filter(|event| matches!(event.what, What::Think { .. }));
    40.0 * 10e6 / thoughts.map(|event| event.end.since(event.start)).min().unwrap() as f64
}

#[test]
fn exchanges_over_real_adapters_are_foretold() {
    // Whole frames: 1, 2 and 3 ms, and the timer of 16 ms as drivers set it.
    for (preset, expected) in
        [("ft232r-1ms", 1000.0), ("ch340", 500.0), ("atmega16u2", 333.3), ("ft232r", 62.5)]
    {
        let toml = bare(1, &format!("baud = 115200, adapter = {{ preset = \"{preset}\" }}"));
        let measured = run(baudbot_scenario::parse(&toml).unwrap(), 4.0).messages_per_s();
        let robot = budget(&toml);
        let typical = robot.rates[0].typical_per_s.unwrap();
        assert!((measured / expected - 1.0).abs() < 0.01, "{preset}: {measured}");
        assert!((typical / measured - 1.0).abs() < 0.01, "{preset}: foretold {typical}, measured {measured}");
        assert!(most_per_s(&robot, "exchanges") >= measured, "{preset}");
    }
}

#[test]
fn a_bootloader_is_no_part_of_a_cycle_and_the_report_says_how_long_it_waits() {
    for mode in ["mode = \"poll\"", "period_ms = 10.0"] {
        let toml = bare(4, "baud = 9600").replace("mode = \"poll\"", mode);
        let uno = toml.replace("\nfirmware", "\nmicrocontroller = { bootloader_s = 1.6 }\nfirmware");
        let (plain, uno) = (budget(&toml), budget(&uno));
        assert_eq!((plain.starts_after_ns, uno.starts_after_ns), (0, 1_600_000_000));
        assert_eq!(
            (&plain.cycle, &plain.ages, plain.verdict),
            (&uno.cycle, &uno.ages, uno.verdict),
            "{mode}"
        );
    }
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
        let measured = run(baudbot_scenario::parse(&toml).unwrap(), 4.0).messages_per_s();
        apart.push(row(&mut table, what, most_per_s(&budget(&toml), "exchanges"), measured));
    }
    for (what, baud) in
        [("URG-04LX at 115200 baud: scans/s", 115_200), ("URG-04LX at 750000 baud: scans/s", 750_000)]
    {
        let robot = budget(&laser(baud));
        let urg = robot.rates.iter().find(|rate| rate.what == "port urg").unwrap();
        let measured = run(baudbot_scenario::parse(&laser(baud)).unwrap(), 20.0);
        apart.push(row(&mut table, what, urg.typical_per_s.unwrap(), per_s(&measured.readable[0])));
    }
    for (what, rate, code) in [
        ("Khepera's N at 9600 baud, 8N2, one digit: polls/s", "polls alone, shortest answer", 5.0),
        ("Khepera's N at 9600 baud, 8N2, four digits: polls/s", "polls alone, longest answer", 1020.0),
    ] {
        let toml = lines_of_text(code);
        apart.push(row(&mut table, what, most_per_s(&budget(&toml), rate), polls_per_s(&toml)));
    }
    let toml = "step_ms = 0.05\nnoise = false\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
                microcontroller = { framing_us_per_byte = 0.0, receiving_us_per_byte = 0.0, obeying_us = 0.0 }\n";
    for (what, rate, line) in [
        ("khepera-1: `D,0,0` and nothing else, a second", "commands alone, shortest", &b"D,0,0\r"[..]),
        ("khepera-1: `H` at 0 pulses, a second", "positions alone, shortest answer", b"H\r"),
    ] {
        apart.push(row(&mut table, what, most_per_s(&budget(toml), rate), lines_per_s(toml, line)));
    }
    for baud in [19_200, 115_200] {
        let toml = asked_laser(baud);
        let robot = budget(&toml);
        let rate = robot.rates.iter().find(|rate| rate.what.starts_with("port urg, asked")).unwrap();
        let what = format!("URG-04LX asked at {baud} baud: scans/s");
        apart.push(row(&mut table, &what, rate.most_per_s.unwrap(), scans_per_s(&toml)));
    }
    for (preset, group, len) in [("create-1", 6, 52), ("create-2", 100, 80)] {
        let toml = format!("step_ms = 0.05\n[[robots]]\nname = \"c\"\npreset = \"{preset}\"\n");
        let foretold = most_per_s(&budget(&toml), &format!("queries of group {group}, {len} bytes"));
        let what = format!("{preset}: queries/s of group {group}");
        apart.push(row(&mut table, &what, foretold, queries_per_s(&toml, group, len)));
    }
    let create = "step_ms = 1.0\n[[robots]]\nname = \"c\"\npreset = \"create-2\"\n";
    let measured = run(baudbot_scenario::parse(create).unwrap(), 4.0).messages_per_s();
    apart.push(row(
        &mut table,
        "create-2: messages/s of its stream",
        most_per_s(&budget(create), "exchanges"),
        measured,
    ));
    let stamp = onboard_thinking();
    let foretold = budget(&stamp).chip.operations_per_step.unwrap();
    apart.push(row(&mut table, "BASIC Stamp 2: operations in 10 ms", foretold, operations_in_10_ms(&stamp)));
    let measured = run(baudbot_scenario::parse(KHEPERA).unwrap(), 4.0);
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
    let toml = include_str!("../../../../catalogue/scenarios/devices/onboard.toml");
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
    assert!(robot.verdict != Verdict::Misses && robot.remedies.is_empty(), "{robot:?}");
}

/// Robots of one table are computed once.
#[test]
fn robots_of_one_table_have_a_budget_each_under_their_own_names() {
    let toml = format!(
        "step_ms = 10.0\n[[robots]]\nname = \"r\"\nstarts = [{{ x_m = 1.0 }}, {{ x_m = 2.0 }}]\n{BODY}\n\
         [robots.sensors.compass]\nkind = \"compass\"\n"
    );
    let scenario = baudbot_scenario::parse(&toml).unwrap();
    let budgets = Budget::of(&scenario).robots;
    let names: Vec<_> = budgets.iter().map(|budget| budget.robot.as_str()).collect();
    assert_eq!(names, scenario.robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>());
    assert!(names.len() == 2 && budgets[0].cycle == budgets[1].cycle, "{names:?}");
}

/// Half of the readings are no older than that when the brain gets them.
#[test]
fn a_readings_typical_age_lies_between_the_least_and_the_most() {
    let robot = budget(&bare(3, "baud = 38400"));
    for age in &robot.ages {
        let (least, typical, most) =
            (age.span.best_ns, age.span.typical_ns.unwrap(), age.span.worst_ns.unwrap());
        assert!(0 < typical && least <= typical && typical <= most, "{age:?}");
    }
    assert_eq!(robot.ages.len(), 3);
}
