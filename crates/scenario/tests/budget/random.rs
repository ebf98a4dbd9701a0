//! Whatever the scenario, what is measured is within the bounds.

use std::fmt::Write;

use baudbot_scenario::budget::{RobotBudget, Span, Thinking};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::budget::run::{Measured, run, run_thinking};
use crate::common::BODY;

/// One of these.
fn one_of(values: &'static [&'static str]) -> impl Strategy<Value = &'static str> {
    prop::sample::select(values)
}

/// The chip's additions to the frames of the bus, with a jitter of more than a frame, too.
fn frames() -> impl Strategy<Value = String> {
    let jitter_us = prop_oneof![2 => 1_u32..200, 1 => 500_u32..4000];
    let jitter = prop_oneof![Just(String::new()), jitter_us.prop_map(|us| format!(", jitter_us = {us}"))];
    let down_us = prop_oneof![2 => 0_u32..100, 1 => 500_u32..4000];
    let down = prop_oneof![Just(String::new()), down_us.prop_map(|us| format!(", down_us = {us}"))];
    (0_u32..4, jitter, down).prop_map(|(extra, jitter, down)| {
        let extra = if extra > 0 { format!(", extra_frames = {extra}") } else { String::new() };
        format!("{extra}{jitter}{down}")
    })
}

fn adapters() -> impl Strategy<Value = String> {
    let ftdi = (1_u32..20, prop_oneof![Just(62_u32), 4_u32..64], frames());
    let ftdi = ftdi.prop_map(|(ms, bytes, frames)| {
        format!(", adapter = {{ kind = \"ftdi\", latency_ms = {ms}, packet_bytes = {bytes}{frames} }}")
    });
    let radio =
        (0_u32..30, 0.0..1.0, one_of(&["0", "0.1"]), 20_u32..400).prop_map(|(ms, spread, bursts, bytes)| {
            let spread = f64::from(ms) * spread;
            format!(
                ", adapter = {{ kind = \"bluetooth\", latency_ms = {ms}, spread_ms = {spread:.3}, \
             burst_probability = {bursts}, burst_ms = 50, packet_bytes = {bytes} }}"
            )
        });
    let cdc = frames().prop_map(|frames| format!(", adapter = {{ kind = \"cdc\"{frames} }}"));
    prop_oneof![3 => Just(String::new()), 2 => cdc, 2 => ftdi, 2 => radio]
}

fn uarts() -> impl Strategy<Value = String> {
    let baud = prop::sample::select(vec![1200_u32, 4800, 9600, 19_200, 38_400, 57_600, 115_200, 500_000]);
    let shared = one_of(&["", "", "", ", half_duplex = true", ", half_duplex = true, turnaround_us = 300"]);
    let bits = prop::sample::select(vec![8_u8, 10, 11]);
    let depth = prop::sample::select(vec![1_u32, 8, 64, 500]);
    (baud, bits, depth, shared, adapters()).prop_map(|(baud, bits, depth, shared, adapter)| {
        format!(
            "{{ kind = \"uart\", baud = {baud}, bits_per_character = {bits}, transmit_depth = {depth}{shared}{adapter} }}"
        )
    })
}

fn links() -> impl Strategy<Value = String> {
    let usb = prop_oneof![Just(1216_u32), 8_u32..200];
    let usb = usb.prop_map(|bytes| format!("{{ kind = \"usb\", bytes_per_frame = {bytes} }}"));
    prop_oneof![
        6 => uarts(),
        1 => usb,
        1 => Just("{ kind = \"ideal\" }".to_owned()),
        1 => Just("{ kind = \"onboard\" }".to_owned()),
    ]
}

/// Periods as they are usual, and as they are not.
fn periods_ms() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![2.0, 5.0, 10.0, 20.0, 25.0, 40.0, 50.0, 100.0]),
        (1.0..120.0).prop_map(|ms: f64| (ms * 1e3).round() / 1e3),
    ]
}

/// A sensor's table, without its name.
fn sensors() -> impl Strategy<Value = String> {
    let when = (periods_ms(), 0.0..30.0, 0_u32..2000).prop_map(|(period, phase, acquisition_us)| {
        format!("period_ms = {period}\nphase_ms = {phase:.3}\nacquisition_us = {acquisition_us}\n")
    });
    let compass = (when, one_of(&["", "bits = 8\n", "bits = 16\n"]));
    let compass = compass.prop_map(|(when, bits)| format!("kind = \"compass\"\n{bits}{when}"));
    let own = (periods_ms(), periods_ms(), 0.0..0.3, 0.0..0.3, any::<bool>(), 0_u32..500);
    let own = own.prop_map(|(read, clock, jitter, latency, known, acquisition_us)| {
        let phase = if known { "phase_ms = 0.7, " } else { "" };
        // The first read is behind the first measurement.
        let (first, jitter, latency) = (3.0 * clock, jitter * clock, latency * clock);
        format!(
            "kind = \"compass\"\nperiod_ms = {read}\nphase_ms = {first}\nacquisition_us = {acquisition_us}\n\
             clock = {{ period_ms = {clock}, {phase}spread_ms = {:.4}, jitter_ms = {jitter:.4}, latency_ms = {latency:.4} }}\n",
            0.1 * clock
        )
    });
    let sonar = periods_ms().prop_map(|period| {
        format!(
            "kind = \"sonar\"\nbearing_rad = 0.0\nrays = 3\nopening_rad = 0.3\nmin_m = 0.02\nmax_m = 3.0\nbits = 16\n\
             period_ms = {period}\ntimeout_ms = 18.5\nholdoff_us = 750.0\n"
        )
    });
    let baud = prop::sample::select(vec![115_200_u32, 500_000]);
    let laser = (periods_ms(), baud, adapters()).prop_map(|(period, baud, adapter)| {
        format!(
            "kind = \"laser\"\nmount = {{ x_m = 0.0 }}\nrays = 60\nopening_rad = 4.18\nrange_m = 4.0\n\
             period_ms = {period}\nport = {{ link = {{ kind = \"uart\", baud = {baud}{adapter} }} }}\n"
        )
    });
    let gps = "preset = \"gps-garmin-15\"\nport = { link = { kind = \"uart\", baud = 4800 } }\n";
    prop_oneof![8 => compass, 2 => own, 1 => sonar, 1 => laser, 1 => Just(gps.to_owned())]
}

fn firmwares() -> impl Strategy<Value = String> {
    let mode = (any::<bool>(), periods_ms(), 0.0..20.0).prop_map(|(polls, period, phase)| match polls {
        true => "mode = \"poll\"".to_owned(),
        false => format!("mode = \"stream\", period_ms = {period}, phase_ms = {phase:.3}"),
    });
    (one_of(&["protocol = \"bare\"", "ages = true", "ages = false"]), mode)
        .prop_map(|(protocol, mode)| format!("firmware = {{ {protocol}, {mode} }}\n"))
}

pub(crate) fn scenarios() -> impl Strategy<Value = String> {
    let step = prop::sample::select(vec![0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
    let processor = (0_u32..60, 0_u32..60, 0_u32..500).prop_map(|(framing, receiving, obeying)| {
        format!(
            "framing_us_per_byte = {framing}, receiving_us_per_byte = {receiving}, obeying_us = {obeying}, "
        )
    });
    let bootloader_s = prop_oneof![3 => Just(0.0), 1 => 0.0..0.4];
    let processor = (prop_oneof![Just(String::new()), processor], bootloader_s);
    let thinking = prop_oneof![3 => Just(0_u32), 1 => 0_u32..30_000];
    let sensors = prop::collection::vec(sensors(), 1..8);
    let motors =
        one_of(&["motors = { signal_bits = 8 }\n", "", "motors = { kind = \"servo\", signal_bits = 8 }\n"]);
    (step, any::<bool>(), links(), firmwares(), processor, thinking, motors, sensors).prop_map(
        |(step, noise, link, firmware, (processor, bootloader_s), thinking, motors, sensors)| {
            // On board nothing resets the chip.
            let bootloader_s = if link.contains("onboard") { 0.0 } else { bootloader_s };
            let mut toml = format!(
                "step_ms = {step}\nnoise = {noise}\n[[robots]]\nname = \"r\"\n{BODY}\n{motors}{firmware}\
                 microcontroller = {{ {processor}bootloader_s = {bootloader_s:.6} }}\nlink = {link}\nbrain = {{ thinking_us = {thinking} }}\n"
            );
            for (i, sensor) in sensors.iter().enumerate() {
                write!(toml, "[robots.sensors.s{i}]\n{sensor}").unwrap();
            }
            toml
        },
    )
}

/// The same robots each time; more or others with `PROPTEST_CASES` and `PROPTEST_RNG_SEED`.
pub(crate) fn config(cases: u32) -> ProptestConfig {
    let mut config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    // 256 is proptest's own number.
    config.cases = if config.cases > 256 { config.cases } else { cases };
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(1);
    }
    config
}

proptest! {
    #![proptest_config(config(500))]

    #[test]
    fn what_is_measured_is_within_the_bounds(toml in scenarios()) {
        let scenario = match baudbot_scenario::parse(&toml) {
            Ok(scenario) => scenario,
            Err(error) => panic!("{error}\n{toml}"),
        };
        let budget = RobotBudget::without_remedies(&scenario, &scenario.robots[0]);
        let measured = run(scenario, 1.0);
        check(&budget, &measured).map_err(|what| TestCaseError::fail(format!("{what}\n{toml}")))?;
    }
}

proptest! {
    // Remedies are looked for, too.
    #![proptest_config(config(100))]

    #[test]
    fn a_brain_that_thinks_as_measured_is_within_the_bounds(
        toml in scenarios(),
        least_ns in 0_u64..20_000_000,
        width_ns in 0_u64..20_000_000,
    ) {
        let scenario = baudbot_scenario::parse(&toml).map_err(|error| TestCaseError::fail(format!("{error}\n{toml}")))?;
        let spec = &scenario.robots[0];
        prop_assume!(!spec.is_onboard());
        let (most_ns, typical_ns) = (least_ns + width_ns, least_ns + width_ns / 2);
        let budget = RobotBudget::of_measured(&scenario, spec, Thinking { least_ns, typical_ns, most_ns });
        // Short, long and in between, without a pattern that goes with the ticks.
        let thinking_ns = |tick: u64| least_ns + width_ns * (tick.wrapping_mul(0x9E37_79B9) % 7) / 6;
        let measured = run_thinking(scenario, 1.0, thinking_ns);
        check(&budget, &measured).map_err(|what| TestCaseError::fail(format!("{what}\n{least_ns} to {most_ns}\n{toml}")))?;
    }
}

fn within(what: &str, ns: u64, span: Span) -> Result<(), String> {
    let ok = ns >= span.best_ns && span.worst_ns.is_none_or(|worst| ns <= worst);
    if ok { Ok(()) } else { Err(format!("{what}: {ns} is not within {span:?}")) }
}

fn check(budget: &RobotBudget, measured: &Measured) -> Result<(), String> {
    for (i, sensor) in measured.world.robot(0).spec().sensors.iter().enumerate() {
        let age = budget.ages.iter().find(|age| age.sensor == sensor.name).ok_or("an age is missing")?;
        for &ns in &measured.ages[i] {
            within(&format!("age of {}", sensor.name), ns, age.span)?;
        }
        if let Some(ns) = age.span.typical_ns {
            within(&format!("typical age of {}", sensor.name), ns, age.span)?;
        }
    }
    for row in &budget.cycle.rows {
        row.span.typical_ns.map_or(Ok(()), |ns| within(row.part.phrase(), ns, row.span))?;
    }
    let total = budget.cycle.total;
    total.typical_ns.map_or(Ok(()), |ns| within("cycle", ns, total))?;
    let robot = measured.world.robot(0);
    let durations = &robot.cycles().durations;
    // Pieces of two commands may make one if bytes were refused or lost, and then it came with the second.
    let whole = robot.downlink().lost() == 0;
    for ns in [durations.min_ns(), durations.max_ns()].into_iter().flatten().filter(|_| whole) {
        within("measured cycle", ns, total)?;
    }
    rates(budget, measured)
}

/// The numbers of a run: what has begun when it ends is counted, and what was counted when it began.
fn rates(budget: &RobotBudget, measured: &Measured) -> Result<(), String> {
    let robot = measured.world.robot(0);
    let no_more = |what: &str, count: u64, spare: f64| {
        let rate = budget.rates.iter().find(|rate| rate.what == what);
        let most = rate.and_then(|rate| rate.most_per_s).unwrap_or(f64::INFINITY);
        let most = most * measured.seconds * spare + 2.0;
        if count as f64 <= most { Ok(()) } else { Err(format!("{count} {what}, at most {most}")) }
    };
    // Until the last sensor has begun to be read, the processor has more time than later.
    no_more("exchanges", measured.messages.min(measured.commands), 1.05)?;
    no_more("round trips", measured.messages, 1.0)?;
    no_more("messages up", measured.messages, 1.0)?;
    no_more("frames", measured.messages, 1.0)?;
    no_more("commands down", measured.commands, 1.0)?;
    no_more("steps of the brain", measured.commands, 1.0)?;
    for (i, (sensor, view)) in robot.spec().sensors.iter().zip(robot.sensors()).enumerate() {
        match robot.port(i) {
            Some(port) => no_more(&format!("port {}", sensor.name), port.messages, 1.0)?,
            None => no_more(&format!("sensor {}", sensor.name), view.samples, 1.0)?,
        }
    }
    Ok(())
}
