//! `--vcd`: what a logic analyser on the pins of a robot's chip sees.

use std::collections::BTreeMap;
use std::fs;

use vcd::{Command, Parser, Value};

use crate::cli::{baudbot, good, place};

const FIRMWARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/firmware.toml");

/// Each signal's changes, by its name.
struct Seen {
    wires: BTreeMap<String, Vec<(u64, Value)>>,
    /// The numbers of vectors; None where a bit is none.
    numbers: BTreeMap<String, Vec<(u64, Option<u64>)>>,
    end_ns: u64,
}

impl Seen {
    fn read(text: &str) -> Self {
        let mut parser = Parser::new(text.as_bytes());
        let header = parser.parse_header().unwrap();
        assert_eq!(header.timescale, Some((1, vcd::TimescaleUnit::NS)));
        let robot = header.find_scope(&["robot"]).unwrap();
        let names: BTreeMap<_, _> = robot
            .items
            .iter()
            .filter_map(|item| match item {
                vcd::ScopeItem::Var(var) => Some((var.code, var.reference.clone())),
                _ => None,
            })
            .collect();
        let mut seen = Self { wires: BTreeMap::new(), numbers: BTreeMap::new(), end_ns: 0 };
        for command in parser {
            match command.unwrap() {
                Command::Timestamp(at_ns) => {
                    assert!(at_ns >= seen.end_ns, "time goes on");
                    seen.end_ns = at_ns;
                }
                Command::ChangeScalar(code, value) => {
                    seen.wires.entry(names[&code].clone()).or_default().push((seen.end_ns, value));
                }
                Command::ChangeVector(code, value) => {
                    let bit = |number: Option<u64>, bit| match bit {
                        Value::V0 => Some(number? << 1),
                        Value::V1 => Some(number? << 1 | 1),
                        Value::X | Value::Z => None,
                    };
                    let number = value.iter().fold(Some(0), bit);
                    seen.numbers.entry(names[&code].clone()).or_default().push((seen.end_ns, number));
                }
                Command::Begin(_) | Command::End(_) => {}
                other => panic!("{other:?}"),
            }
        }
        seen
    }

    /// The level of a wire at an instant.
    fn level(&self, name: &str, at_ns: u64) -> Value {
        self.wires[name].iter().take_while(|(from_ns, _)| *from_ns <= at_ns).last().unwrap().1
    }

    /// The bits on a wire, read as a UART does.
    fn text(&self, name: &str, bit_ns: u64) -> String {
        let (mut text, mut now) = (String::new(), 0);
        let falls =
            |pair: &[(u64, Value)]| (pair[0].1 == Value::V1 && pair[1].1 == Value::V0).then_some(pair[1].0);
        for start in self.wires[name].windows(2).filter_map(falls) {
            if start < now || start + 10 * bit_ns > self.end_ns {
                continue;
            }
            let bit = |bit: u64| self.level(name, start + bit * bit_ns + bit_ns / 2) == Value::V1;
            text.push((0..8).fold(0, |byte, i| byte | u8::from(bit(i + 1)) << i).into());
            assert!(bit(9), "the stop bit at {start} ns");
            now = start + bit_ns * 19 / 2;
        }
        text
    }
}

#[test]
fn a_run_shows_pwm_the_uart_the_adc_and_the_lamp() {
    let path = place("pins.vcd");
    let with =
        good(&["run", FIRMWARE, "--seconds", "2", "--json", "--vcd", &format!("robot={}", path.display())]);
    let without = good(&["run", FIRMWARE, "--seconds", "2", "--json"]);
    let hash = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["state_hash"].clone();
    assert_eq!(hash(&with), hash(&without));
    let seen = Seen::read(&fs::read_to_string(&path).unwrap());
    assert!(seen.end_ns >= 1_980_000_000, "{}", seen.end_ns);

    // Fast PWM with counts of 0.5 µs, 256 in a period: high for 71 of them when it goes ahead.
    let pwm = &seen.wires["D9_PB1_motors_left_pwm"];
    let rises: Vec<_> =
        pwm.windows(3).filter(|edges| edges[0].1 == Value::V1 && edges[1].1 == Value::V0).collect();
    assert!(rises.len() > 10_000, "{}", rises.len());
    let ahead = rises.iter().filter(|edges| edges[1].0 - edges[0].0 == 71 * 500).count();
    let whole = rises.iter().filter(|edges| edges[2].0 - edges[0].0 == 256 * 500).count();
    assert!(ahead * 10 > rises.len() * 5, "{ahead} of {}", rises.len());
    assert!(whole + 10 > rises.len(), "{whole} of {}", rises.len());

    // UBRR0 = 103: bits of 104 µs.
    let text = seen.text("D1_PD1_txd", 104_000);
    let whole_lines = text.matches('\n').count();
    assert!(whole_lines >= 15, "{text}");
    let parse = |line: &str| line.split(' ').map(|number| number.parse().unwrap()).collect();
    let numbers: Vec<Vec<u64>> = text.lines().take(whole_lines).map(parse).collect();
    assert!(numbers.iter().all(|line| line.len() == 5), "{text}");
    let sent = seen.numbers["uart_sent"].iter().filter_map(|(_, number)| *number);
    let sent: String = sent.map(|byte| char::from(byte as u8)).collect();
    assert!(sent.starts_with(&text), "{sent}");
    let levels = seen.wires["D1_PD1_txd"].windows(2).filter(|pair| pair[0].1 != Value::Z);
    let bits: Vec<u64> = levels.map(|pair| pair[1].0 - pair[0].0).filter(|ns| *ns < 1_040_000).collect();
    assert!(bits.len() > 1000 && bits.iter().all(|ns| ns % 104_000 == 0), "{bits:?}");

    // A reported value was measured: it is one of the results before the line.
    for (place, name) in [(0, "adc0_sensors_ir_left"), (2, "adc2_sensors_ir_front")] {
        let results: Vec<_> = seen.numbers[name].iter().filter_map(|(_, result)| *result).collect();
        assert!((90..=101).contains(&results.len()), "every 20 ms: {}", results.len());
        for line in &numbers {
            assert!(results.contains(&line[place]), "{name}: {line:?}");
        }
    }
    // Each 20 ms it measures in a long round, and between these the short ones are drawn together.
    let rounds = &seen.wires["loop"];
    assert!(rounds[1..].windows(2).all(|pair| pair[1].0 - pair[0].0 >= 62_500 && pair[0].1 != pair[1].1));
    assert!((20_000..32_000).contains(&rounds.len()), "{}", rounds.len());
    // Nothing is near at first, and the lamp is off.
    let lamp = &seen.wires["D13_PB5_leds_builtin"];
    assert_eq!(seen.level("D13_PB5_leds_builtin", 10_000_000), Value::V0, "{lamp:?}");
    assert_eq!(seen.level("D12_PB4", 1_000_000_000), Value::Z);
    assert_eq!(seen.level("D0_PD0_rxd", 1_000_000_000), Value::V1);
}

#[test]
fn an_export_is_the_file_of_the_run_and_a_window_is_a_part_of_it() {
    let [run, export, part, tape] = ["run.vcd", "export.vcd", "part.vcd", "pins.mcap"].map(place);
    let tape = tape.to_str().unwrap();
    let to = |path: &std::path::Path| format!("robot={}", path.display());
    good(&[
        "run",
        FIRMWARE,
        "--seconds",
        "1",
        "--quiet",
        "--record",
        tape,
        "--record-hz",
        "0",
        "--vcd",
        &to(&run),
    ]);
    good(&["export", tape, "--vcd", &to(&export)]);
    good(&["export", tape, "--vcd", &to(&part), "--from-s", "0.5", "--to-s", "0.6"]);
    let [run, export, part] = [run, export, part].map(|path| fs::read_to_string(path).unwrap());
    assert!(run == export, "{} and {} bytes", run.len(), export.len());
    let [whole, part] = [&run, &part].map(|text| Seen::read(text));
    let pin = "D1_PD1_txd";
    let within = |seen: &Seen| {
        let edges = seen.wires[pin].iter().filter(|(at_ns, _)| *at_ns > 500_000_000 && *at_ns <= 600_000_000);
        edges.copied().collect::<Vec<_>>()
    };
    assert!(!within(&whole).is_empty());
    assert_eq!(within(&whole), within(&part));
    for pin in whole.wires.keys().filter(|pin| !pin.ends_with("_pwm")) {
        assert_eq!(part.level(pin, 500_000_000), whole.level(pin, 500_000_000), "{pin}");
    }
    assert_eq!(part.wires[pin][0].0, 500_000_000);
}

#[test]
fn a_robot_without_pins_is_refused_with_its_name() {
    let refusal = |args: &[&str]| {
        let (code, _, err) = baudbot(args);
        assert_eq!(code, 2, "{err}");
        err
    };
    let err = refusal(&["run", FIRMWARE, "--seconds", "1", "--vcd", "bob=/dev/null"]);
    assert!(err.contains("--vcd: there is no robot `bob`; there are: `robot`"), "{err}");
    let err = refusal(&["run", "wander", "--seconds", "1", "--vcd", "robot=/dev/null"]);
    assert!(err.contains("--vcd: `robot` has no program on its microcontroller"), "{err}");
    let err = refusal(&["run", FIRMWARE, "--vcd", "pins.vcd"]);
    assert!(err.contains("write ROBOT=FILE"), "{err}");
    let err = refusal(&["run", FIRMWARE, "--json", "--vcd", "robot=-"]);
    assert!(err.contains("--vcd ROBOT=- needs stdout for itself"), "{err}");
    let (code, _, err) = baudbot(&["run", FIRMWARE, "--seconds", "1", "--vcd", "robot=/dev/full"]);
    assert!(code == 1 && err.contains("cannot write /dev/full"), "{err}");
}
