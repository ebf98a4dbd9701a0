//! `baudbot export` of what brains believed.

use std::fs;

use roxmltree::Document;

use crate::cli::{baudbot, good, place};

const SWEEPER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/sweeper.toml");

/// Records 20 s of a brain.
fn record(brain: &str, hz: &str, name: &str) -> String {
    let path = place(name).to_str().unwrap().to_owned();
    let run = ["run", SWEEPER, "--brain", brain, "--seconds", "20", "--quiet"];
    good(&[&run[..], &["--record", &path, "--record-hz", hz]].concat());
    path
}

#[test]
fn beliefs_are_a_table_and_utilities_a_chart() {
    let run = record("sweeper", "20", "believing.mcap");
    let (csv, svg) = (place("beliefs.csv"), place("utilities.svg"));
    let (csv, svg) = (csv.to_str().unwrap(), svg.to_str().unwrap());
    let both = ["--beliefs-csv", csv, "--utilities-svg", svg, "--with", "gauge.charge", "--quiet"];
    good(&[&["export", &run], &both[..]].concat());
    let table = fs::read_to_string(csv).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..6], ["t_s", "robot", "state", "x_m", "y_m", "heading_rad"]);
    let names = ["charge", "sweep", "turn_away", "odometry"];
    let own: Vec<_> =
        names.iter().flat_map(|name| [format!("{name}.utility"), format!("{name}.active")]).collect();
    assert_eq!(rows[0][6..], own);
    // The brain steps every 20 ms, and publishes at most every 50: that is in each third step.
    assert_eq!(rows.len(), 1 + 334, "rows of 20 s");
    let mut before_s = -1.0;
    for row in &rows[1..] {
        let at_s: f64 = row[0].parse().unwrap();
        assert!(at_s > before_s && (0.0..=20.0).contains(&at_s), "{at_s} after {before_s}");
        before_s = at_s;
        // The motor behaviour of the greatest utility has the motors, and the state has its name.
        let active: Vec<_> = (0..3).filter(|i| row[7 + 2 * i] == "1").collect();
        assert_eq!(active.len(), 1, "{row:?}");
        let utility = |i: usize| row[6 + 2 * i].parse::<f64>().unwrap();
        assert!((0..3).all(|i| utility(i) <= utility(active[0])), "{row:?}");
        assert!(row[2].starts_with(names[active[0]]), "{row:?}");
    }
    let picture = fs::read_to_string(svg).unwrap();
    let document = Document::parse(&picture).unwrap();
    let lines = document.descendants().filter(|node| node.attribute("class") == Some("line")).count();
    assert_eq!(lines, 5, "four utilities and a column");
    let texts: Vec<_> = document.descendants().filter_map(|node| node.text()).collect();
    for name in [&names[..], &["gauge.charge", "robot"]].concat() {
        assert!(texts.contains(&name), "{name}: {texts:?}");
    }
}

/// A recording with a frame for each step has a belief for each step, and not only as often as people look.
#[test]
fn with_more_frames_brains_say_more() {
    let patient = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/patient.toml");
    let path = place("patient.mcap").to_str().unwrap().to_owned();
    let run = ["run", patient, "--brain", "patient", "--seconds", "6", "--no-noise", "--quiet"];
    good(&[&run[..], &["--record", &path, "--record-hz", "100"]].concat());
    let table = good(&["export", &path, "--beliefs-csv", "-", "--from-s", "4.5", "--quiet"]);
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let wait = lines.next().unwrap().iter().position(|name| *name == "wait.utility").unwrap();
    let course: Vec<f64> = lines.map(|row| row[wait].parse().unwrap()).collect();
    assert_eq!(course.len(), 151, "rows of 1.5 s");
    let least = course.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((course[0] - 0.905148).abs() < 1e-4, "{}", course[0]);
    assert!((course[0] - least - 0.057223).abs() < 1e-4, "{}", course[0] - least);
}

/// Fig. 7.2 of a run: the path of hunger and thirst, their lethal boundaries and the isoclines of both behaviours.
#[test]
fn a_run_has_a_picture_in_the_space_of_its_motivation() {
    let waterhole = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/waterhole.toml");
    let path = place("waterhole.mcap").to_str().unwrap().to_owned();
    let run = ["run", waterhole, "--brain", "waterhole", "--seconds", "60", "--quiet"];
    good(&[&run[..], &["--record", &path]].concat());
    let picture = good(&["export", &path, "--space-svg", "-", "--quiet"]);
    let document = Document::parse(&picture).unwrap();
    let count =
        |class: &str| document.descendants().filter(|node| node.attribute("class") == Some(class)).count();
    assert_eq!(count("lethal"), 2);
    assert!(count("isocline") >= 6 && count("path") >= 2, "{} {}", count("isocline"), count("path"));
    let texts: Vec<_> = document.descendants().filter_map(|node| node.text()).collect();
    for name in ["hunger", "thirst", "eat", "drink", "isoclines", "lethal"] {
        assert!(texts.contains(&name), "{name}: {texts:?}");
    }
    let table = good(&["export", &path, "--beliefs-csv", "-", "--quiet"]);
    let header: Vec<_> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(header[header.len() - 4..], ["food.value", "water.value", "hunger.value", "thirst.value"]);
    let sensed = good(&["export", &path, "--space-svg", "-", "--axes", "food,hunger", "--quiet"]);
    assert!(sensed.contains(">food</text>") && !sensed.contains(">thirst</text>"));
    for (axes, problem) in [
        ("hunger,sleep", "--axes: no brain of"),
        ("hunger", "--axes hunger: must be two different variables, as hunger,thirst"),
        ("hunger,hunger", "--axes hunger,hunger: must be two different"),
    ] {
        let (code, _, err) = baudbot(&["export", &path, "--space-svg", "-", "--axes", axes, "--quiet"]);
        assert!(code == 2 && err.contains(problem), "{axes}: {code} {err}");
    }
    let sweeper = record("sweeper", "20", "space-of-nothing.mcap");
    let (code, _, err) = baudbot(&["export", &sweeper, "--space-svg", "-", "--quiet"]);
    assert!(code == 2 && err.contains("publish no two variables"), "{code} {err}");
}

#[test]
fn where_there_is_nothing_to_export_it_says_what_to_do() {
    let refusal = |args: &[&str]| {
        let (code, out, err) = baudbot(&[&["export"], args].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let blind = record("sweeper", "0", "blind.mcap");
    let none = refusal(&[&blind, "--beliefs-csv", "-"]);
    assert!(
        none.starts_with("error: --beliefs-csv: ") && none.contains("with --record-hz above 0"),
        "{none}"
    );
    let silent = record("wander", "10", "silent.mcap");
    assert!(refusal(&[&silent, "--utilities-svg", "-"]).contains("has no beliefs there"));
    let column = refusal(&[&silent, "--utilities-svg", "-", "--with", "sonar"]);
    assert!(
        column
            .starts_with("error: --with: no robot has a sensor's column `sonar`; there are: encoders.left, ")
            && column.contains("gauge.voltage_v"),
        "{column}"
    );
    assert!(refusal(&[&silent, "--with", "gauge.charge"]).contains("--utilities-svg"));
}
