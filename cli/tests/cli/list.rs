//! The content of an installed program: `list`, `init`, `schema`, `completions`, `man`.

use std::path::PathBuf;

use crate::cli::{baudbot, good};

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("list-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_list_has_all_that_can_be_named() {
    let text = good(&["list"]);
    for name in ["wander", "devices/laser", "firmware", "baud-vs-speed", "tune-sweeper", "avoid", "khepera-1"]
    {
        assert!(
            text.lines().any(|line| line.trim_start().starts_with(&format!("{name} "))),
            "{name}: {text}"
        );
    }
    assert!(text.lines().all(|line| line.chars().count() <= 200), "a line each");
    let tour = text.lines().find(|line| line.starts_with("  tour ")).unwrap();
    assert!(tour.ends_with("(--brain tour)"), "the default brain cannot drive there: {tour}");
    let json: serde_json::Value = serde_json::from_str(&good(&["list", "--json"])).unwrap();
    let scenarios = json["scenarios"].as_array().unwrap();
    let brains = |name: &str| &scenarios.iter().find(|entry| entry["name"] == name).unwrap()["brains"];
    assert_eq!(brains("tour"), &serde_json::json!(["tour"]));
    assert_eq!(brains("devices/heights"), &serde_json::json!(["tall=constant:left=0.2,right=0.2", "none"]));
    for (kind, least) in
        [("scenarios", 40), ("experiments", 10), ("exercises", 10), ("brains", 10), ("presets", 20)]
    {
        let entries = json[kind].as_array().unwrap();
        assert!(entries.len() >= least, "{kind}: {}", entries.len());
        assert!(entries.iter().all(|entry| !entry["summary"].as_str().unwrap().is_empty()), "{kind}");
    }
}

/// A built-in file is the same as the source's, to the bit.
#[test]
fn an_example_is_written_where_one_is_and_runs_as_the_one_that_is_built_in() {
    let folder = folder("init");
    let file = folder.join("mine.toml");
    let file = file.to_str().unwrap();
    let told = good(&["init", "firmware", file]);
    assert!(told.contains(&format!("baudbot run {file}")), "{told}");
    let hash = |scenario: &str| {
        let json = good(&["run", scenario, "--brain", "none", "--seconds", "1", "--json", "--quiet"]);
        serde_json::from_str::<serde_json::Value>(&json).unwrap()["state_hash"].clone()
    };
    assert_eq!(hash(file), hash("firmware"));
    let (code, _, err) = baudbot(&["init", "firmware", file]);
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("is there already; choose another file"), "{err}");
}

#[test]
fn a_name_that_is_nearly_right_is_understood() {
    let (code, _, err) = baudbot(&["run", "devices/lazer"]);
    assert_eq!(code, 2);
    let expected = "devices/lazer: there is no such file, and no scenario of this name is built in; did you mean `devices/laser`?";
    assert!(err.contains(expected), "{err}");
    let (code, _, err) = baudbot(&["init", "baud-vs-sped"]);
    assert_eq!(code, 2);
    assert!(err.contains("`baudbot list` has them all"), "{err}");
    for (arguments, is) in [
        (["run", "avoid"], "`avoid` is a brain: `baudbot run --brain avoid`"),
        (["run", "khepera-1"], "`khepera-1` is a preset: `baudbot preset khepera-1`"),
        (["init", "khepera-1"], "`khepera-1` is a preset: `baudbot preset khepera-1`"),
    ] {
        let (code, _, err) = baudbot(&arguments);
        assert_eq!(code, 2);
        assert!(err.contains(is), "{err}");
    }
}

#[test]
fn shells_and_man_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "elvish"] {
        let script = good(&["completions", shell]);
        assert!(script.contains("serve") && script.contains("tokens"), "{shell}");
    }
    let zsh = good(&["completions", "zsh"]);
    assert!(zsh.contains("_alternative \"names:name:(") && zsh.contains(" wander "), "{zsh}");
    let fish = good(&["completions", "fish"]);
    assert!(fish.contains("using_subcommand preset\" -f -a \""), "{fish}");
    let folder = folder("man");
    good(&["man", folder.to_str().unwrap()]);
    let page = std::fs::read_to_string(folder.join("man1/baudbot-run.1")).unwrap();
    assert!(page.contains(".SH OPTIONS"), "{page}");
    assert!(folder.join("man1/baudbot.1").exists());
}

/// The completion is made by bash itself, in a folder with a file.
#[test]
fn bash_completes_names_of_what_is_built_in() {
    let script = folder("completions").join("baudbot");
    std::fs::write(&script, good(&["completions", "bash"])).unwrap();
    let completed = |words: &str| {
        let mut from_last = words.rsplit(' ');
        let [last, before] = std::array::from_fn(|_| from_last.next().unwrap());
        let ask = format!(
            "source {}; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
             _baudbot baudbot '{last}' '{before}'; echo \"${{COMPREPLY[*]}}\"",
            script.display()
        );
        let told = std::process::Command::new("bash").args(["-c", &ask]).output().unwrap();
        String::from_utf8(told.stdout).unwrap().trim_end().to_owned()
    };
    assert_eq!(completed("baudbot run wand"), "wander");
    assert_eq!(completed("baudbot run --seconds 5 wand"), "wander");
    assert_eq!(completed("baudbot check devices/las"), "devices/laser");
    assert_eq!(completed("baudbot init baud-vs-sp"), "baud-vs-speed");
    assert_eq!(completed("baudbot preset khepera-1-i"), "khepera-1-ir");
    assert_eq!(completed("baudbot run --brain avo"), "avoid");
    assert_eq!(completed("baudbot run my-own.t"), "", "then bash completes files");
}

#[test]
fn editors_get_a_schema() {
    let schema: serde_json::Value = serde_json::from_str(&good(&["schema"])).unwrap();
    assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    assert_eq!(schema["properties"]["step_ms"]["maximum"], 1000);
}

#[test]
fn a_scenario_is_described_for_programs_whether_it_is_sound_or_not() {
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    let sound = json(&good(&["check", "khepera", "--json"]));
    assert_eq!((&sound["sound"], &sound["step_ms"]), (&true.into(), &10.0.into()));
    let robot = &sound["robots"][0];
    assert_eq!((robot["robot"].as_str(), robot["motors"].as_str()), (Some("khepera"), Some("dc")));
    assert_eq!(robot["sensors"].as_array().unwrap().len(), 9);
    assert_eq!(robot["sensors"][0]["period_ms"], 20.0);
    let (code, out, err) = baudbot(&["check", "wander", "--json", "--set", "seed=-1"]);
    let refused = json(&out);
    assert_eq!((code, &refused["sound"]), (2, &false.into()));
    assert_eq!(refused["problem"], "wander: seed: must be a whole number of 0 or more, is -1");
    assert_eq!(err, "error: wander: seed: must be a whole number of 0 or more, is -1\n");
}

#[test]
fn brains_are_listed_for_programs() {
    let brains: serde_json::Value = serde_json::from_str(&good(&["brain", "--list", "--json"])).unwrap();
    let constant = brains.as_array().unwrap().iter().find(|brain| brain["name"] == "constant").unwrap();
    assert_eq!(constant["parameters"][0]["name"], "left");
    assert_eq!(
        (&constant["parameters"][0]["min"], &constant["parameters"][0]["max"]),
        (&(-10.0).into(), &10.0.into())
    );
}
