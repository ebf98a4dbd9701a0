//! `baudbot diagram`.

use crate::cli::{baudbot, good, place};

const FIRMWARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/firmware.toml");

/// The error of an impossible diagram on stderr; no other line may be there.
fn refusal(args: &[&str]) -> String {
    let (code, out, err) = baudbot(&[&["diagram"], args].concat());
    assert_eq!((code, out.as_str()), (2, ""), "{err}");
    err
}

#[test]
fn what_is_not_there_cannot_be_shown() {
    let robot = refusal(&["wander", "--robot", "alice"]);
    assert_eq!(robot, "error: --robot: there is no robot `alice`; there are: robot\n");
    let brain = refusal(&["wander", "--brain", "genius"]);
    assert!(brain.contains("genius") && brain.lines().count() == 1, "{brain}");
    let sensors = refusal(&["wander", "--set", "robots.robot.body.mass_kg=0"]);
    assert_eq!(sensors, "error: wander: robots[0].body.mass_kg: must be positive, is 0\n");
}

#[test]
fn a_time_that_makes_no_sense_is_refused_with_its_range() {
    assert!(refusal(&["wander", "--at", "-1"]).contains("must be from 0 to 1000000, is -1"));
    assert!(refusal(&["wander", "--span", "0"]).contains("must be above 0 and at most 1000000, is 0"));
    for wrong in [["--at", "nan"], ["--at", "1e9"], ["--span", "inf"], ["--cycle", "0"], ["--cycle", "1.5"]] {
        assert!(refusal(&["wander", wrong[0], wrong[1]]).starts_with("error: invalid value"), "{wrong:?}");
    }
    assert!(refusal(&["wander", "--at", "1", "--cycle", "2"]).contains("cannot be used with"));
}

#[test]
fn pins_that_are_not_there_are_refused_with_those_that_are() {
    assert_eq!(
        refusal(&[FIRMWARE, "--pins", "D9,X9"]),
        "error: --pins: the chip of `robot` has no pin `X9`; there are: D0, D1, D2, D3, D4, D5, D6, D7, D8, D9, D10, \
         D11, D12, D13, A0, A1, A2, A3, A4, A5\n"
    );
    assert!(refusal(&[FIRMWARE, "--pins", "VCC"]).contains("no pin `VCC`"));
    assert_eq!(
        refusal(&["wander", "--pins", "D9"]),
        "error: --pins: `robot` has no program on its microcontroller, so it has no pins to record; give it one \
         (`microcontroller.program`, docs/reference/firmware.md)\n"
    );
    let cycle = refusal(&[FIRMWARE, "--cycle", "2"]);
    assert!(cycle.starts_with("error: --cycle: `robot` runs a program of its own"), "{cycle}");
}

#[test]
fn without_an_instant_a_diagram_of_a_chip_is_of_the_first_round_in_which_its_program_reacts() {
    let svg = good(&["diagram", FIRMWARE, "--svg", "-"]);
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("text"))
        .filter_map(|node| node.text().map(str::to_owned))
        .collect();
    let has = |text: &str| texts.iter().any(|other| other == text);
    for lane in [
        "main loop",
        "D8 motors.left.direction",
        "D9 motors.left.pwm",
        "D13 leds.builtin",
        "adc0 sensors.ir_left",
    ] {
        assert!(has(lane), "no `{lane}` in {texts:?}");
    }
    assert!(!texts.iter().any(|text| text.starts_with("D2")), "nothing is on it: {texts:?}");
    assert!(
        texts.iter().any(|text| text.starts_with("In the round of its main loop that begins at ")
            && text.contains(" ms, the program reads ir_")
            && text.contains(" and changes D")),
        "{texts:?}"
    );
    // 71 or 56 of 256 counts of 0.5 µs.
    assert!(texts.iter().any(|text| text.ends_with(" %, 7.81 kHz")), "{texts:?}");
    assert!(!has("brain") && !has("microcontroller"), "there is none: {texts:?}");
    assert!(svg.len() < 300_000, "{}", svg.len());
    // The choice of the instant does not depend on the output.
    let first = |args: &[&str]| good(&[&["diagram", FIRMWARE], args].concat());
    let (table, csv) = (first(&[]), first(&["--csv", "-"]));
    let begin = |row: &str| row.trim().split([',', ' ']).next().unwrap().parse::<f64>().unwrap();
    let of = |text: &str, what: &str| {
        text.lines()
            .filter(|line| line.contains("adc4") && line.contains(what))
            .map(begin)
            .collect::<Vec<_>>()
    };
    let [short, long] = [of(&table, "adc4"), of(&csv, "adc4")];
    assert!(short.len() == long.len() && !short.is_empty(), "{table}");
    assert!(short.iter().zip(&long).all(|(short, long)| (short - long).abs() < 1e-3), "{short:?} {long:?}");
}

#[test]
fn the_picture_of_the_manual_is_what_the_program_draws() {
    let drawn = good(&["diagram", FIRMWARE, "--at", "0.595", "--span", "30", "--svg", "-"]);
    assert!(
        drawn == include_str!("../../../docs/pictures/pins.svg"),
        "look at the new one, which this makes:\n\
         cargo run -- diagram catalogue/scenarios/firmware.toml --at 0.595 --span 30 --svg docs/pictures/pins.svg"
    );
}

#[test]
fn a_table_has_pulses_in_words_and_comma_separated_values_have_each_edge() {
    let window = ["--at", "0.5", "--span", "40"];
    let of = |more: &[&str]| good(&[&["diagram", FIRMWARE], &window[..], more].concat());
    let table = of(&["--pins", "D9,A0"]);
    assert!(
        table.lines().any(|line| line.contains("D9 motors.left.pwm") && line.contains(" pulses, ")),
        "{table}"
    );
    assert!(table.contains("adc0 sensors.ir_left") && table.contains("uart sent"), "{table}");
    let rounds =
        |words: &str| table.lines().filter(|line| line.contains("main loop") && line.contains(words)).count();
    assert_eq!((rounds("a round of "), rounds(" short rounds, ")), (2, 3), "one each 20 ms: {table}");
    assert!(!table.contains("D8") && !table.contains("adc1"), "they were not chosen: {table}");
    let csv = of(&["--pins", "D9,A0", "--csv", "-"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].join(","), "start_ms,duration_ms,who,what,meaning");
    let levels: Vec<_> = rows.iter().filter(|row| row[2] == "D9 motors.left.pwm").collect();
    assert!(levels.len() > 600, "{csv}");
    assert!(levels[1..].iter().all(|row| row[3] == "high" || row[3] == "low"), "{levels:?}");
    let whole = |pair: &[&Vec<&str>]| {
        let [one, other] = [pair[0][1], pair[1][1]].map(|long| long.parse::<f64>().unwrap());
        (one + other - 0.128).abs() < 1e-6
    };
    assert!(levels[1..levels.len() - 1].windows(2).filter(|pair| whole(pair)).count() > 590, "{levels:?}");
}

#[test]
fn a_recording_is_shown_as_the_run_that_it_is_of() {
    let path = place("diagram.mcap");
    let file = path.display().to_string();
    good(&["run", FIRMWARE, "--seconds", "1", "--record", &file]);
    let window = ["--at", "0.5", "--span", "20"];
    let of = |what: &str| good(&[&["diagram", what], &window[..]].concat());
    let recorded = of(&file);
    assert_eq!(recorded, of(FIRMWARE));
    assert!(recorded.lines().count() > 20, "{recorded}");
    let svg = good(&["diagram", &file, "--svg", "-"]);
    assert!(svg.contains("recorded · ") || svg.contains("recorded, "), "{svg}");
    let refused = refusal(&[&file, "--seed", "3"]);
    assert_eq!(
        refused,
        format!(
            "error: --seed: {file} is a recorded run, and shown as it was; give the scenario for another run\n"
        )
    );
    assert!(refusal(&[&file, "--at", "7"]).contains("the run is over after 1 s"));
}
