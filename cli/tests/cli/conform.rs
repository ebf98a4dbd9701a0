//! `baudbot conform`: brains of the catalogue keep to the contract, and brains with one fault fail in exactly the cases of that.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::cli::{baudbot, good};

/// The cases of an examination, each with its verdict.
fn examined(brain: &str, more: &[&str]) -> Vec<(String, String, String)> {
    let (_, out, err) =
        baudbot(&[&["conform", brain, "--json", "--quiet", "--patience", "10"], more].concat());
    let json: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{out}{err}"));
    let word = |case: &Value, key: &str| case[key].as_str().unwrap_or_default().to_owned();
    let cases = json["cases"].as_array().unwrap().iter();
    cases.map(|case| (word(case, "name"), word(case, "verdict"), word(case, "why"))).collect()
}

/// The names of the cases with a verdict.
fn named<'a>(cases: &'a [(String, String, String)], verdict: &str) -> BTreeSet<&'a str> {
    cases.iter().filter(|case| case.1 == verdict).map(|case| case.0.as_str()).collect()
}

fn wrong_brain(fault: &str) -> String {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_baudbot")).with_file_name("examples/wrong_brain");
    format!("exec:{} {fault}", program.display())
}

#[test]
fn a_brain_of_the_catalogue_does_all_that_it_uses() {
    let cases = examined(&format!("exec:{} brain avoid", env!("CARGO_BIN_EXE_baudbot")), &[]);
    assert_eq!(named(&cases, "does not"), BTreeSet::new(), "{cases:#?}");
    assert!(named(&cases, "does").len() >= 40, "{cases:#?}");
}

/// Each fault, and the cases that it fails.
const FAULTS: &[(&str, &[&str])] = &[
    ("none", &[]),
    ("stays", &[]),
    ("greets-twice", &["hello-once"]),
    ("steps-before-the-welcome", &["welcome-before-step"]),
    ("answers-twice", &["no-second-answer"]),
    ("ignores-readable", &["answers-what-is-readable"]),
    ("forgets-the-token", &["token", "token-again"]),
    ("blocks-on-a-missing-reading", &["missing-sensor"]),
    ("sends-nan", &["finite-signals"]),
    ("loses-the-second-robot", &["second-robot"]),
    ("answers-an-old-world", &["old-turn"]),
    ("never-reconnects", &["lost-connection"]),
    ("floods", &["no-flood", "no-step-unasked", "silent-in-pause"]),
];

#[test]
fn a_wrong_brain_fails_in_exactly_the_cases_of_its_fault() {
    // Most of the time they wait.
    std::thread::scope(|scope| {
        for (fault, expected) in FAULTS {
            scope.spawn(move || {
                let cases = examined(&wrong_brain(fault), &[]);
                let expected: BTreeSet<_> = expected.iter().copied().collect();
                assert_eq!(named(&cases, "does not"), expected, "{fault}: {cases:#?}");
            });
        }
    });
}

/// A brain may leave when the run is over, or stay for a reset.
#[test]
fn a_brain_that_stays_drives_again_after_a_reset() {
    let after_reset = |fault: &str| {
        let cases = examined(&wrong_brain(fault), &[]);
        cases.into_iter().find(|case| case.0 == "reset-after-end").map(|case| case.1)
    };
    assert_eq!(after_reset("stays").as_deref(), Some("does"));
    assert_eq!(after_reset("none").as_deref(), Some("not used"));
}

/// On an ideal cable whole frames arrive at once, so that this brain drives where nothing is split.
#[test]
fn a_brain_of_bytes_that_takes_each_piece_for_a_whole_dies_where_they_are_split() {
    let cases = examined(&wrong_brain("dies-at-a-split-byte"), &["--scenario", "arsim"]);
    assert_eq!(named(&cases, "does not"), BTreeSet::from(["split-bytes"]), "{cases:#?}");
}

#[test]
fn the_result_is_a_text_and_a_file_for_continuous_integration() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("conform.xml");
    let brain = wrong_brain("answers-twice");
    let (code, out, err) = baudbot(&[
        "conform",
        &brain,
        "--patience",
        "3",
        "--junit",
        file.to_str().unwrap(),
        "--scenario",
        "wander",
    ]);
    assert_eq!(code, 1, "{err}");
    assert!(
        out.contains("does not  no-second-answer: ") && out.contains("contract: Each Turn takes one Step."),
        "{out}"
    );
    assert!(err.contains("] a lost connection"), "{err}");
    let xml = std::fs::read_to_string(file).unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let suite = document.root_element();
    let cases = suite.children().filter(|node| node.has_tag_name("testcase")).count();
    assert_eq!(suite.attribute("tests"), Some(cases.to_string().as_str()));
    assert_eq!(suite.attribute("failures"), Some("1"));
}

#[test]
fn the_cases_are_listed_and_nonsense_is_refused() {
    let list = good(&["conform", "--list"]);
    assert!(list.contains("one-step-per-turn (in a run with ten seconds in lockstep)"), "{list}");
    for (arguments, words) in [
        (&["conform", "avoid"][..], "`avoid` is no program; write exec: before"),
        (&["conform", "exec:true", "--robot", "nobody"], "there is no robot `nobody`"),
        (&["conform", "exec:/nowhere/brain"], "there is no program `/nowhere/brain`"),
    ] {
        let (code, _, err) = baudbot(arguments);
        assert!(code == 2 && err.contains(words), "{arguments:?}: {code} {err}");
    }
}
