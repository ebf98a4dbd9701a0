//! `baudbot grade`: exercises, their solutions and typical mistakes, and brains that fail or hang.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::cli::{baudbot, good};

const ROOM: &str = r#"
title = "Wander"
task = "Drive about."
scenario = "wander"
seconds = 5.0
seeds = 2
limits = { answer_s = 1.0 }
[[criteria]]
name = "it drives"
needs = { distance_m_at_least = 0.1 }
"#;

/// Arguments with which the program of the tests is itself a brain that is started.
const AVOID: &str = "brain avoid --connect $BAUDBOT_CONNECT --world $BAUDBOT_WORLD --robot $BAUDBOT_ROBOT";

/// An exercise file of this text.
fn exercise(name: &str, toml: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("grading");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, toml).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Exit code and JSON.
fn graded(exercise: &str, brain: &str) -> (i32, Value) {
    let (code, out, err) = baudbot(&["grade", exercise, "--brain", brain, "--json", "--quiet"]);
    (code, serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}{err}")))
}

fn findings(json: &Value) -> Vec<&str> {
    json["findings"].as_array().unwrap().iter().map(|finding| finding.as_str().unwrap()).collect()
}

/// The exercises in Python, and those that compute much, are run by `catalogue/exercises/check.py` with a program that
/// is optimised.
#[test]
fn each_solution_passes_and_each_mistake_gets_its_word() {
    let brains: toml::Table =
        include_str!("../../../catalogue/exercises/solutions/brains.toml").parse().unwrap();
    let is_here = |brain: &str| !brain.starts_with("exec:");
    let is_slow = |name: &str| ["charge", "errands", "explore", "localize"].contains(&name);
    for (name, of) in brains.iter().filter(|(name, _)| !is_slow(name)) {
        let solution = of["solution"].as_str().unwrap();
        if is_here(solution) {
            let (code, json) = graded(name, solution);
            assert_eq!((code, &json["verdict"]), (0, &"passed".into()), "{name}: {json:#}");
            assert_eq!(json["points"], json["points_of"], "{name}");
        }
        for mistake in of["mistakes"].as_array().unwrap() {
            let [brain, says] = ["brain", "says"].map(|field| mistake[field].as_str().unwrap());
            if is_here(brain) {
                let (code, json) = graded(name, brain);
                assert_eq!((code, &json["verdict"]), (3, &"failed".into()), "{name}: {brain}: {json:#}");
                assert!(
                    findings(&json).iter().any(|finding| finding.contains(says)),
                    "{name}: {brain}: {json:#}"
                );
            }
        }
    }
}

/// §7.2.2: what a robot pays is what the closed form says of its order, and what it pays on the way between its needs.
#[test]
fn a_robot_pays_for_its_needs_what_the_closed_form_says_and_for_its_way() {
    let brains: toml::Table =
        include_str!("../../../catalogue/exercises/solutions/brains.toml").parse().unwrap();
    let cost = |brain: &toml::Value| {
        let json = graded("needs", brain.as_str().unwrap()).1;
        json["runs"][0]["measures"]["quadratic_cost"].as_f64().unwrap()
    };
    // Q x³ / 3r of both, and what the second costs while the first is satisfied.
    let (eating, drinking) = (0.36 * 120.0 / 3.0, 2.0 * 0.16 * 40.0 / 3.0);
    let of_needs = &brains["needs"];
    for (brain, closed) in [
        (&of_needs["solution"], drinking + 0.36 * 40.0 + eating),
        (&of_needs["mistakes"][0]["brain"], eating + 2.0 * 0.16 * 120.0 + drinking),
    ] {
        let cost = cost(brain);
        // Half the way costs 0.68 a second for 3 s, all of it what is left of the second need for 6 s.
        assert!(cost > closed && cost < closed + 7.0, "{cost} instead of {closed} and the way");
    }
}

#[test]
fn a_grading_is_the_same_with_any_number_of_jobs_and_its_json_has_the_fields_that_the_book_has() {
    let with = |jobs: &str| {
        good(&["grade", "wander", "--brain", "avoid", "--seeds", "3", "--json", "--quiet", "--jobs", jobs])
    };
    let text = with("1");
    assert_eq!(text, with("3"));
    let json: Value = serde_json::from_str(&text).unwrap();
    let book = include_str!("../../../docs/how-to/grading.md");
    for (name, _) in json.as_object().unwrap().iter().chain(json["runs"][0].as_object().unwrap()) {
        assert!(book.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn the_list_the_task_and_the_file_of_an_exercise_are_told() {
    let list = good(&["grade"]);
    for name in ["circle", "wander", "localize"] {
        assert!(list.lines().any(|line| line.trim_start().starts_with(&format!("{name} "))), "{list}");
        assert!(
            include_str!("../../../docs/how-to/grading.md").contains(&format!("\n| `{name}` | ")),
            "{name}"
        );
    }
    assert_eq!(list, good(&["grade", "--list"]));
    let task = good(&["grade", "circle", "--show"]);
    assert!(task.starts_with("circle: Drive a circle") && task.contains("end_error_m at most 0.1"), "{task}");
    let toml = good(&["grade", "circle", "--toml"]);
    assert_eq!(toml, include_str!("../../../catalogue/exercises/circle.toml"));
    assert!(
        serde_json::from_str::<Value>(&good(&["grade", "--json"])).unwrap().as_array().unwrap().len() >= 10
    );
}

#[test]
fn what_cannot_be_graded_is_refused_with_the_name_that_was_meant() {
    for (args, expected) in [
        (&["grade", "wandr", "--brain", "avoid"][..], "did you mean `wander`?"),
        (&["grade", "wander"], "no brain is given; add --brain"),
        (&["grade", "--brain", "avoid"], "no exercise is given"),
        (&["grade", "wander", "--brain", "avod"], "no brain `avod`; there are: avoid, "),
        (&["grade", "wander", "--brain", "bob=avoid"], "there is no robot `bob`"),
        (&["grade", "wander", "--brain", "avoid:x=1"], "brain `avoid` has no parameter `x`"),
        (&["grade", "wander", "--brain", "exec:./nothere"], "there is no program `./nothere`"),
        (&["grade", "wander", "--brain", "python3 x.py"], "named as in 'exec:python3 x.py'"),
        (&["grade", "wander", "--brain", "avoid", "--seeds", "0"], "--seeds: must be at least 1"),
    ] {
        let (code, _, err) = baudbot(args);
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(err.contains(expected), "{args:?}: {err}");
    }
    let file = exercise("wrong", &ROOM.replace("distance_m", "distnce_m"));
    let (code, _, err) = baudbot(&["grade", &file, "--brain", "avoid"]);
    assert_eq!(code, 2);
    let expected = "wrong.toml: criteria[0].needs.distnce_m_at_least: there is no measure `distnce_m`; did you mean `distance_m`?";
    assert!(err.contains(expected), "{err}");
}

#[test]
fn a_fault_in_the_brains_of_an_exercise_is_told_with_its_file() {
    for (brain, expected) in [
        ("x=avoid", "there is no robot `x`"),
        ("robot=avoid:x=1", "brain `avoid` has no parameter `x`"),
        ("robot=exec:./nothere", "there is no program `./nothere`"),
    ] {
        let toml = ROOM.replace("seeds = 2", &format!("seeds = 2\nbrains = [\"{brain}\"]"));
        let file = exercise("own-brains", &toml);
        let (code, _, err) = baudbot(&["grade", &file, "--brain", "avoid"]);
        assert_eq!(code, 2, "{err}");
        assert!(err.starts_with(&format!("error: {file}: brains[0]: {expected}")), "{err}");
    }
}

#[test]
fn values_that_miss_a_criterion_are_told_in_words_that_agree() {
    let toml =
        ROOM.replace("distance_m_at_least = 0.1", "commands_at_most = 0, first_collision_s_at_least = 0");
    let (code, out, err) = baudbot(&["grade", &exercise("agree", &toml), "--brain", "avoid", "--seeds", "1"]);
    assert_eq!(code, 3, "{err}");
    assert!(out.contains("it drives: in 0 of 1 seeds; commands: "), "{out}");
    assert!(out.contains("; first_collision_s: missing, needed: first_collision_s at least 0"), "{out}");
}

#[test]
fn a_program_that_is_not_there_is_no_failure_of_its_author() {
    let file = exercise("missing", ROOM);
    let (code, out, err) = baudbot(&["grade", &file, "--brain", "exec:there-is-no-such-program", "--json"]);
    assert_eq!((code, out.as_str()), (2, ""), "{err}");
    assert!(err.starts_with("error: there is no program `there-is-no-such-program`"), "{err}");
    let (code, json) = graded(&file, "exec:sh -c 'echo oh no >&2; exit 3'");
    assert_eq!(code, 1, "{json:#}");
    assert!(
        findings(&json)[0].contains("exited with code 3 before it attached")
            && findings(&json)[0].contains("oh no"),
        "{json:#}"
    );
}

/// The program of the tests is itself a brain: one that is stopped hangs.
#[test]
fn a_brain_that_hangs_loses_its_run_and_is_ended() {
    let file = exercise("hangs", &ROOM.replace("seconds = 5.0", "seconds = 3000.0"));
    // The brain attaches, drives for a moment, and then stands still for good.
    let program = env!("CARGO_BIN_EXE_baudbot");
    let script = format!("{program} {AVOID} & sleep 3; kill -STOP $!; sleep 600");
    let begun = Instant::now();
    let (code, json) = graded(&file, &format!("exec:sh -c '{script}'"));
    assert_eq!((code, &json["verdict"]), (3, &"failed".into()), "{json:#}");
    let found = findings(&json)[0];
    assert!(
        found.starts_with("at ") && found.contains("did not answer for 1 s by the wall clock"),
        "{json:#}"
    );
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
}

/// The brain's token allows it to drive, and nothing else.
#[test]
fn a_brain_cannot_ask_for_the_truth() {
    let file = exercise("curious", &ROOM.replace("seeds = 2", "seeds = 1"));
    let program = env!("CARGO_BIN_EXE_baudbot");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("grading");
    let said = folder.join("curious.txt");
    let said = said.to_str().unwrap();
    let script = format!(
        "{program} watch --connect $BAUDBOT_CONNECT >{said} 2>&1; echo $? >>{said}; exec {program} {AVOID}"
    );
    let (code, json) = graded(&file, &format!("exec:sh -c '{script}'"));
    assert_eq!(code, 0, "{json:#}");
    let said = std::fs::read_to_string(said).unwrap();
    assert!(said.contains("the server does not offer this call") && said.trim_end().ends_with('1'), "{said}");
}

#[test]
fn junit_has_a_case_for_each_criterion() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("grading");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("result.xml");
    let (code, out, _) = baudbot(&[
        "grade",
        "circle",
        "--brain",
        "constant:left=0.375,right=0.225",
        "--junit",
        file.to_str().unwrap(),
    ]);
    assert_eq!(code, 3);
    assert!(out.contains("not passed: ") && out.contains("\n- the robot turned to the right"), "{out}");
    let text = std::fs::read_to_string(file).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let suite = document.root_element();
    let cases: Vec<_> = suite.children().filter(|node| node.has_tag_name("testcase")).collect();
    assert_eq!((cases.len(), suite.attribute("failures")), (3, Some("1")), "{text}");
    assert!(text.contains("left comes first"), "{text}");
}

#[test]
fn a_class_is_graded_into_a_table_for_people_programs_and_continuous_integration() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(place("class")).unwrap();
    let baudbot = env!("CARGO_BIN_EXE_baudbot");
    let program = format!(
        "#!/bin/sh\nexec {baudbot} brain avoid --connect $BAUDBOT_CONNECT --world $BAUDBOT_WORLD --robot $BAUDBOT_ROBOT --seed $BAUDBOT_SEED\n"
    );
    crate::cli::write_program(place("class/ada").as_ref(), &program);
    std::fs::write(place("class/bob.toml"), "motor = 3\n").unwrap();
    std::fs::write(place("class/notes.txt"), "nobody's").unwrap();
    let arguments = ["grade", "wander", "--seeds", "1", "--class", &place("class"), "--csv", &place("a.csv")];
    let (code, out, err) = crate::cli::baudbot(&[&arguments[..], &["--junit", &place("a.xml")]].concat());
    let note = format!("note: {} is not a brain, and is skipped\n", place("class/notes.txt"));
    assert_eq!((code, err), (3, note), "{out}");
    let lines: Vec<_> = out.lines().collect();
    assert!(lines[2].starts_with("  ada  5.00") && lines[2].ends_with("passed"), "{out}");
    assert!(
        lines[3].starts_with("  bob  0.00  not-graded  ")
            && lines[3].contains("motor: must be a table, is 3"),
        "{out}"
    );
    assert!(lines[5].starts_with("1 of 2 brains passed, with "), "{out}");
    let csv = std::fs::read_to_string(place("a.csv")).unwrap();
    let heads: Vec<_> = csv.lines().map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(heads, ["name", "ada", "bob"], "{csv}");
    let xml = std::fs::read_to_string(place("a.xml")).unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let suites = document.descendants().filter(|node| node.has_tag_name("testsuite"));
    let told: Vec<_> =
        suites.map(|suite| (suite.attribute("name").unwrap(), suite.attribute("errors").unwrap())).collect();
    assert_eq!(told, [("wander.ada", "0"), ("wander.bob", "2")]);
    let (code, _, err) = crate::cli::baudbot(&["grade", "wander", "--class", &place("class/notes.txt")]);
    assert!(code == 2 && err.contains("notes.txt: is not a brain"), "{err}");
}
