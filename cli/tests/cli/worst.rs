//! `baudbot worst` and `run --require`: their output, their files and their exit codes.

use std::path::{Path, PathBuf};

use crate::cli::sweep::wait_for_rows;
use crate::cli::{Running, baudbot, good};

const NEAR: &str = r#"
scenario = "wander"
brain = "avoid"
seconds = 10.0
[require]
always = "clearance_m > 0.1"
[[fields]]
field = "robots.robot.link.baud"
label = "baud"
values = [1200]
[[fields]]
field = "robots.robot.start.heading_rad"
label = "heading_rad"
from = -3.0
to = 3.0
"#;

/// An experiment, and the folder for its results.
fn experiment(name: &str, toml: &str) -> (String, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("worst-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("near.toml");
    std::fs::write(&path, toml).unwrap();
    (path.to_str().unwrap().to_owned(), folder.join("out").to_str().unwrap().to_owned())
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_worst_run_is_a_scenario_that_fails_by_the_command_in_its_head() {
    let (file, out) = experiment("head", NEAR);
    let (code, told, err) = baudbot(&["worst", &file, "--out", &out, "--runs", "60"]);
    assert_eq!(code, 1, "{told}{err}");
    assert!(told.starts_with("near: always clearance_m > 0.1 (cma-es)\n"), "{told}");
    assert!(told.contains(" of 60 runs fail\n") && told.contains(" fails "), "{told}");
    for file in ["worst.toml", "worst.mcap", "worst.svg"] {
        assert!(Path::new(&out).join(file).exists() && err.contains(&format!("wrote {out}/{file}")), "{err}");
    }
    let case = std::fs::read_to_string(Path::new(&out).join("worst.toml")).unwrap();
    let command = case.lines().nth(1).unwrap().split_once(": baudbot ").unwrap();
    let state = command.0.strip_prefix("# state ").unwrap();
    let words = shlex::split(command.1).unwrap();
    let words: Vec<_> = words
        .iter()
        .map(|word| if word == "worst.toml" { format!("{out}/{word}") } else { word.clone() })
        .collect();
    let words: Vec<_> = words.iter().map(String::as_str).collect();
    let (code, report, _) = baudbot(&words);
    assert_eq!(code, 1, "{report}");
    assert!(
        report.contains("always clearance_m > 0.1: FAILS for robot by 0.") && report.contains(state),
        "{report}"
    );
    let (code, summary, _) = baudbot(&[&words[..], &["--json"]].concat());
    let required = &json(&summary)["requirements"][0];
    assert_eq!(
        (code, required["holds"].as_bool(), required["robot"].as_str()),
        (1, Some(false), Some("robot"))
    );
    // The recording is of that run.
    let replayed = good(&["replay", &format!("{out}/worst.mcap")]);
    assert!(replayed.contains(state), "{replayed}");
    let again = baudbot(&["worst", &file, "--out", &out, "--runs", "60", "--json", "--quiet"]);
    assert_eq!((again.0, json(&again.1)["case"]["state_hash"].as_str()), (1, Some(state)));
}

#[test]
fn a_search_that_finds_nothing_says_what_that_is_worth() {
    let toml = NEAR.replace("> 0.1\"", "> -1\"") + "[worst]\nmethod = \"random\"\n";
    let (file, out) = experiment("nothing", &toml);
    let (code, told, err) = baudbot(&["worst", &file, "--out", &out, "--runs", "30"]);
    assert_eq!(code, 0, "{told}{err}");
    // 1 − 0.025^(1/30).
    assert!(
        told.contains("not found in 30 runs; with 95 % confidence fewer than 11.57 % of such runs do"),
        "{told}"
    );
}

/// One machine, and eight of which each is killed twice.
#[test]
fn shards_that_are_killed_and_go_on_find_what_one_machine_finds() {
    let toml = NEAR.replace("seconds = 10.0", "seconds = 20.0") + "[worst]\nmethod = \"random\"\n";
    let (file, out) = experiment("killed", &toml);
    let runs = ["--runs", "160"];
    let whole = baudbot(&[&["worst", &file, "--out", &out], &runs[..]].concat());
    assert_eq!(whole.0, 1, "{}", whole.2);
    let folder = Path::new(&out).with_file_name("shards");
    let of = |shard: usize| folder.join(shard.to_string()).display().to_string();
    for shard in 0..8 {
        let (name, out) = (format!("{shard}/8"), of(shard));
        let long = [&["worst", &file, "--shard", &name, "--out", &out, "--jobs", "1"], &runs[..]].concat();
        for rows in [2, 5] {
            let running = Running::start(&long);
            wait_for_rows(&out, rows);
            // SIGKILL.
            drop(running);
        }
        assert_eq!(baudbot(&long).0, 0);
        let lines = std::fs::read_to_string(Path::new(&out).join("rows.jsonl")).unwrap().lines().count();
        assert_eq!(lines, 21, "no run is there twice");
    }
    let (sources, merged) = (folder.display().to_string(), folder.with_file_name("merged"));
    let to = merged.display().to_string();
    let told = baudbot(&[&["worst", &file, "--merge", &sources, "--out", &to], &runs[..]].concat());
    assert_eq!(told.1, whole.1);
    for name in ["summary.txt", "worst.toml", "worst.svg"] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        assert!(read(&merged) == read(Path::new(&out)), "{name} differs");
    }
}

/// By way of a server, to which programs attach, the same runs are seen at each tick.
#[test]
fn programs_are_searched_like_brains_of_the_catalogue() {
    let (file, out) = experiment("direct", NEAR);
    let exec = format!("brain = {{ exec = \"{} brain avoid\" }}", env!("CARGO_BIN_EXE_baudbot"));
    let (program, program_out) = experiment("program", &NEAR.replace("brain = \"avoid\"", &exec));
    let found = [(file, out), (program, program_out)].map(|(file, out)| {
        let (code, told, err) = baudbot(&["worst", &file, "--out", &out, "--runs", "6", "--json"]);
        assert!(code < 2, "{err}");
        let told = json(&told);
        told["worst"]
            .as_array()
            .unwrap()
            .iter()
            .map(|run| (run["run"].clone(), run["robustness"].clone(), run["at_s"].clone()))
            .collect::<Vec<_>>()
    });
    assert_eq!(found[0].len(), 6);
    assert_eq!(found[0], found[1]);
}

/// An experiment whose brain is a script beside it, which ends in a program of the catalogue.
fn with_script(name: &str, toml: &str, script: &str) -> (String, String) {
    let (file, out) = experiment(name, &toml.replace("brain = \"avoid\"", "brain = { exec = \"sh go.sh\" }"));
    let script = format!("{script}\nexec '{}' brain avoid\n", env!("CARGO_BIN_EXE_baudbot"));
    std::fs::write(Path::new(&file).with_file_name("go.sh"), script).unwrap();
    (file, out)
}

/// The experiment's folder is not the one in which the search runs.
#[test]
fn the_case_of_a_program_is_done_again_from_any_folder() {
    let (file, out) = with_script("elsewhere", NEAR, "");
    let (code, told, err) = baudbot(&["worst", &file, "--out", &out, "--runs", "30", "--first"]);
    assert_eq!(code, 1, "{told}{err}");
    assert!(
        Path::new(&out).join("worst.svg").exists() && Path::new(&out).join("worst.mcap").exists(),
        "{err}"
    );
    let case = std::fs::read_to_string(Path::new(&out).join("worst.toml")).unwrap();
    let (state, command) = case.lines().nth(1).unwrap().split_once(": ").unwrap();
    let state = state.strip_prefix("# state ").unwrap();
    let command = command.replace("baudbot run", &format!("'{}' run", env!("CARGO_BIN_EXE_baudbot")));
    let ran = std::process::Command::new("sh").args(["-c", &command]).current_dir("/").output().unwrap();
    let said = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.code() == Some(1) && said.contains(state), "{command}\n{said}");
}

#[test]
fn a_program_that_ends_too_soon_is_no_success() {
    let script =
        "n=$(cat count 2>/dev/null || echo 0); echo $((n + 1)) > count; [ $((n % 3)) = 2 ] && exit 3";
    let (file, out) = with_script("crash", &NEAR.replace("> 0.1\"", "> -1\""), script);
    let search = ["worst", &file, "--out", &out, "--jobs", "1"];
    let (code, told, err) = baudbot(&[&search[..], &["--runs", "9"]].concat());
    assert_eq!(code, 1, "{told}{err}");
    assert!(told.contains(" runs could not be done; the first: run "), "{told}");
    assert!(
        told.contains("it is done again by baudbot run wander --brain 'exec:sh go.sh' --set '"),
        "{told}"
    );
    assert!(told.contains("--set 'seed="), "{told}");
    let (code, told, _) =
        baudbot(&[&search[..], &["--runs", "500", "--first", "--fresh", "--json"]].concat());
    let told = json(&told);
    assert!(code == 1 && told["failed"].as_u64() > Some(0) && told["runs"].as_u64() < Some(500), "{told}");
}

/// A run of half a million ticks, in whose midst the program is halted.
#[test]
fn a_program_that_does_not_answer_fails_its_run_and_holds_up_nothing() {
    let script =
        format!("'{}' brain avoid & sleep 2; kill -STOP $!; wait; exit", env!("CARGO_BIN_EXE_baudbot"));
    let long = NEAR
        .replace("seconds = 10.0", "seconds = 5000.0")
        .replace("[1200]", "[9600]")
        .replace("> 0.1\"", "> -1\"");
    let (file, out) = with_script("silent", &long, &script);
    let limits = ["--runs", "2", "--jobs", "2", "--brain-timeout", "1"];
    let (code, told, err) = baudbot(&[&["worst", &file, "--out", &out][..], &limits].concat());
    assert_eq!(code, 2, "{told}{err}");
    assert!(
        err.contains("none of 2 runs could be done: run 0: at t = ")
            && err.contains("no answer of a brain has come within the 1 s of --brain-timeout"),
        "{err}"
    );
}

#[test]
fn what_cannot_be_required_is_refused() {
    let run = |rule: &str| baudbot(&["run", "wander", "--seconds", "1", "--quiet", "--require", rule]);
    let (code, _, err) = run("always clearence_m > 0");
    assert!(code == 2 && err.contains("did you mean `clearance_m`?"), "{code} {err}");
    let (code, _, err) = run("always age_ms(ir_rear) < 3");
    assert!(code == 2 && err.contains("--require: there is no sensor `ir_rear`"), "{code} {err}");
    assert_eq!(run("always clearance_m > 0").0, 0);
    assert_eq!(run("eventually distance_m > 100").0, 1);
    let (file, _) = experiment("remote", NEAR);
    let (code, _, err) = baudbot(&["sweep", &file, "--connect", "localhost:1"]);
    assert!(code == 2, "{err}");
}
