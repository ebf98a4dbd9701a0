//! Brains that are programs of their own: `--brain exec:…`. Here the program is `baudbot brain`.

use serde_json::Value;

use crate::cli::{Running, baudbot, good};

/// A brain of the catalogue as a program that reads where it attaches in its environment.
fn program(brain: &str) -> String {
    let baudbot = env!("CARGO_BIN_EXE_baudbot");
    format!(
        "exec:sh -c 'exec {baudbot} brain {brain} --connect $BAUDBOT_CONNECT --world $BAUDBOT_WORLD --robot $BAUDBOT_ROBOT --seed $BAUDBOT_SEED'"
    )
}

fn summary(arguments: &[&str]) -> Value {
    serde_json::from_str(&good(&[arguments, &["--json", "--quiet"]].concat())).unwrap()
}

/// A program that drives for a moment and then hangs, as one with an endless loop does.
#[test]
fn a_program_that_hangs_ends_its_run_if_that_is_asked_for() {
    let hangs =
        program("avoid").replace("exec ", "").replace("SEED'", "SEED & sleep 1; kill -STOP $!; wait'");
    let run =
        ["run", "wander", "--seconds", "1000000", "--log", "off", "--brain", &hangs, "--brain-timeout", "1"];
    let (code, out, err) = baudbot(&run);
    assert_eq!((code, out.as_str()), (1, ""), "{err}");
    assert!(err.contains("no answer of a brain has come within the 1 s of --brain-timeout"), "{err}");
    assert!(err.contains("look for an endless loop"), "{err}");
}

#[test]
fn a_program_drives_as_the_same_brain_in_this_process() {
    let run = |brain: &str| summary(&["run", "wander", "--seconds", "20", "--seed", "5", "--brain", brain]);
    let (own, inside) = (run(&program("avoid")), run("avoid"));
    assert_eq!(own["state_hash"], inside["state_hash"]);
    assert_eq!((own["over"].as_str(), inside["over"].as_str()), (Some("grpc"), Some("direct")));
    assert_eq!(own["robots"][0]["brain"], program("avoid"));
    assert_eq!(own["robots"][0]["collisions"], 0);
}

/// `exec:baudbot brain NAME` is all that a user types: the environment has the rest.
#[test]
fn a_brain_of_the_catalogue_is_a_program_by_its_name_alone() {
    let baudbot = env!("CARGO_BIN_EXE_baudbot");
    let run = |brain: &str| summary(&["run", "wander", "--seconds", "5", "--seed", "5", "--brain", brain]);
    let (own, inside) = (run(&format!("exec:{baudbot} brain avoid")), run("avoid"));
    assert_eq!(own["state_hash"], inside["state_hash"]);
}

#[test]
fn a_drive_of_a_test_is_the_run_of_the_command() {
    let toml = include_str!("../../../catalogue/scenarios/wander.toml");
    for (seed, seconds) in [(1, 20.0), (5, 7.123)] {
        let mut scenario = baudbot_scenario::parse(toml).unwrap();
        scenario.seed = seed;
        let avoid = |body: &_| baudbot_brains::catalogue::brain("avoid", seed, body).ok();
        let drive = baudbot_server::drive_each(&scenario, avoid, seconds).unwrap().remove(0);
        let (seed, seconds) = (seed.to_string(), seconds.to_string());
        let run = summary(&["run", "wander", "--seconds", &seconds, "--seed", &seed, "--brain", "avoid"]);
        assert_eq!(run["state_hash"], format!("{:016x}", drive.state_hash()));
        assert_eq!(run["robots"][0]["distance_m"], drive.distance_m());
        assert!(drive.collisions.is_empty(), "{:?}", drive.collisions);
    }
}

/// The address in a program's environment is good for driving, and gives no truth.
#[test]
fn a_program_cannot_observe_by_the_address_that_it_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let said = folder.path().join("said");
    let baudbot = env!("CARGO_BIN_EXE_baudbot");
    let watches =
        format!("{baudbot} watch --connect $BAUDBOT_CONNECT >{0} 2>&1; echo $? >>{0};", said.display());
    let curious = program("avoid").replacen("-c '", &format!("-c '{watches} "), 1);
    summary(&["run", "wander", "--seconds", "5", "--brain", &curious]);
    let said = std::fs::read_to_string(said).unwrap();
    assert!(said.ends_with("1\n") && !said.contains("pose"), "{said}");
    assert!(said.contains("the server does not offer this call"), "{said}");
}

#[test]
fn bad_programs_are_told_in_a_sentence() {
    for (brain, words) in [
        ("exec:/nowhere/follow", "there is no program `/nowhere/follow`"),
        ("exec:", "`exec:` names no program"),
        ("exec:sh -c 'echo no luck; exit 3'", "exited with code 3 before it attached; it printed\n  no luck"),
        ("nobody=exec:true", "there is no robot `nobody`"),
    ] {
        let (code, out, err) = baudbot(&["run", "wander", "--seconds", "1", "--brain", brain]);
        assert!(code != 0 && out.is_empty(), "{brain}: {code} {out}");
        assert!(err.contains(words), "{brain}: {err}");
    }
    let dies = program("avoid").replace("exec ", "").replace("'exec:", "'");
    let dies = dies.replacen("-c '", "-c '(sleep 0.5; kill -9 $$) & ", 1);
    let (code, _, err) = baudbot(&["run", "wander", "--seconds", "1000000", "--brain", &dies]);
    assert!(code == 1 && err.contains("was ended by signal 9 before the run was over"), "{err}");
}

#[test]
fn a_diagram_of_a_program_is_that_of_the_same_brain_in_this_process() {
    let diagram =
        |brain: &str, place: &[&str]| good(&[&["diagram", "wander", "--brain", brain], place].concat());
    for place in [&["--cycle", "5"][..], &["--at", "1.5"], &[]] {
        let (own, inside) = (diagram(&program("avoid"), place), diagram("avoid", place));
        assert_eq!(own, inside, "{place:?}");
        assert!(own.lines().count() > 5, "{own}");
    }
    let picture = diagram(&program("avoid"), &["--cycle", "5", "--svg", "-"]);
    assert!(picture.starts_with("<svg") && picture.contains("exec:sh"), "{picture}");
}

#[test]
fn thinking_is_measured_shown_recorded_and_put_into_the_budget() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let run = |name: &str, more: &[&str]| {
        summary(&[&["run", "wander", "--seconds", "2", "--record", &path(name)], more].concat())
    };
    let own = run("own.mcap", &["--brain", &program("avoid")]);
    let thinking = &own["robots"][0]["thinking_processor"];
    let turns = thinking["turns"].as_u64().unwrap();
    assert!((90..=200).contains(&turns), "{own}");
    let ms = |name: &str| thinking[name].as_f64().unwrap();
    assert!(0.0 < ms("min_ms") && ms("min_ms") <= ms("p50_ms") && ms("p50_ms") <= ms("max_ms"), "{own}");
    assert!(own["robots"][0].get("thinking_wall").is_none(), "{own}");
    let timed = run("timed.mcap", &["--pace", "real-time"]);
    assert!(timed["robots"][0]["thinking_wall"]["turns"].as_u64().unwrap() > 0, "{timed}");
    let inside = run("inside.mcap", &[]);
    assert!(inside["robots"][0].get("thinking_processor").is_none(), "{inside}");

    let budget = |name: &str| good(&["budget", "wander", "--measured", &path(name), "--json"]);
    let budget: Value = serde_json::from_str(&budget("own.mcap")).unwrap();
    let rows = budget["robots"][0]["cycle"]["rows"].as_array().unwrap();
    let row = rows.iter().find(|row| row["part"] == "thinking").unwrap();
    for (of, in_summary) in [("best_ns", "min_ms"), ("typical_ns", "p50_ms"), ("worst_ns", "max_ms")] {
        assert!((row[of].as_f64().unwrap() / 1e6 - ms(in_summary)).abs() < 1e-6, "{of}: {row} {thinking}");
    }
    let told = good(&["budget", "wander", "--measured", &path("timed.mcap")]);
    assert!(told.contains("  thinking time measured by the wall clock in "), "{told}");
    let (code, _, err) = baudbot(&["budget", "wander", "--measured", &path("inside.mcap")]);
    assert!(code == 2 && err.contains("no thinking time was measured in that run"), "{err}");
    let (code, _, err) = baudbot(&["budget", "wander", "--measured", &path("none.mcap")]);
    assert!(code == 2 && err.contains("none.mcap: cannot be read"), "{code} {err}");
}

#[test]
fn a_diagram_tells_of_a_program_that_fails() {
    let (code, out, err) = baudbot(&["diagram", "wander", "--brain", "exec:sh -c 'echo no luck; exit 3'"]);
    assert!(code == 1 && out.is_empty(), "{code} {out}");
    assert!(err.contains("exited with code 3 before it attached") && err.contains("no luck"), "{err}");
}

#[test]
fn ctrl_c_before_a_program_holds_its_robot_runs_nothing() {
    let socket = format!("unix:{}", tempfile::tempdir().unwrap().keep().join("socket").display());
    for brain in [&["--brain", "exec:sleep 63"][..], &["--external", "1"]] {
        let args = [&["run", "wander", "--seconds", "9", "--json", "--listen", &socket], brain].concat();
        let mut run = Running::start(&args);
        // Signals are awaited before it listens.
        assert_eq!(run.first_complaint(), format!("listening on {socket}\n"));
        run.signal("-INT");
        let (code, out, _) = run.end();
        let summary: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(
            (code, summary["interrupted"].as_bool(), summary["ticks"].as_u64()),
            (130, Some(true), Some(0))
        );
    }
}

#[test]
fn parameters_are_set_of_all_brains_that_have_them() {
    let shows = "exec:sh -c 'echo $BAUDBOT_PARAMETERS; exit 3'";
    let (_, _, err) =
        baudbot(&["run", "wander", "--brain", shows, "--parameter", "speed=0.5", "--parameter", "name=a b"]);
    assert!(err.contains("{\"name\":\"a b\",\"speed\":0.5}"), "{err}");
    let run = |brain: &[&str]| summary(&[&["run", "wander", "--seconds", "2", "--brain"], brain].concat());
    let set = run(&["constant:left=0.1,right=0.1", "--parameter", "left=0.3"]);
    assert_eq!(set["state_hash"], run(&["constant:left=0.3,right=0.1"])["state_hash"]);
    for (argument, words) in [("left", "write NAME=VALUE"), ("lefd=1", "lefd")] {
        let (code, _, err) = baudbot(&["run", "wander", "--brain", "constant", "--parameter", argument]);
        assert!(
            code == 2 && err.contains(&format!("--parameter {argument}: ")) && err.contains(words),
            "{err}"
        );
    }
    let (code, _, err) = baudbot(&["run", "wander", "--brain", "follow.py"]);
    assert!(
        code == 2 && err.contains("a program of your own is named as in 'exec:python3 follow.py'"),
        "{err}"
    );
}

#[test]
fn what_a_program_prints_is_shown_if_it_is_wanted() {
    let loud = program("avoid").replacen("-c '", "-c 'echo good morning; ", 1);
    let run =
        |more: &[&str]| baudbot(&[&["run", "wander", "--seconds", "1", "--brain", &loud], more].concat());
    let (code, _, err) = run(&["--show-output", "--quiet"]);
    assert!(code == 0 && err.contains("good morning\n"), "{err}");
    let (code, _, err) = run(&["--quiet"]);
    assert!(code == 0 && !err.contains("good morning"), "{err}");
    let (code, _, err) = baudbot(&["run", "wander", "--show-output"]);
    assert!(code == 2 && err.contains("--show-output: no brain is a program"), "{err}");
}

#[test]
fn what_a_program_printed_unseen_and_a_brain_that_commands_nothing_are_hinted_at() {
    let loud = program("avoid").replacen("-c '", "-c 'echo good; echo morning; ", 1);
    let run = |brain: &str, more: &[&str]| {
        good(&[&["run", "wander", "--seconds", "2", "--brain", brain], more].concat())
    };
    let text = run(&loud, &[]);
    assert!(text.contains("the brain's program printed 2 lines: --show-output shows them"), "{text}");
    let (code, text, err) = baudbot(&["run", "wander", "--seconds", "2", "--brain", &loud, "--show-output"]);
    assert!(code == 0 && err.contains("morning") && !text.contains("hint"), "{text}{err}");
    let text = run("avoid", &[]);
    assert!(!text.contains("hint"), "{text}");
    // The brain waits for its odometer.
    let late = [
        "run",
        "arsim",
        "--brain",
        "navigate",
        "--seconds",
        "2",
        "--set",
        "robots.robot.sensors.odometer.phase_ms=5000",
    ];
    let text = good(&late);
    assert!(text.contains("the brain sent nothing in 200 turns: does its step return a command?"), "{text}");
}

#[test]
fn a_program_that_drives_another_robot_is_told() {
    let scenario = std::env::temp_dir().join(format!("baudbot-two-{}.toml", std::process::id()));
    let robots = ["alice", "bob"].map(|name| {
        let x = if name == "alice" { 0.0 } else { 1.0 };
        format!("[[robots]]\nname = \"{name}\"\npreset = \"khepera-1\"\nstart.x_m = {x:?}\n")
    });
    std::fs::write(&scenario, robots.concat()).unwrap();
    let other = program("wander").replace("$BAUDBOT_ROBOT", "bob");
    let (code, _, err) = baudbot(&[
        "run",
        scenario.to_str().unwrap(),
        "--brain",
        "bob=none",
        "--brain",
        &format!("alice={other}"),
        "--seconds",
        "1",
    ]);
    assert!(code == 1 && err.contains("was started for alice (BAUDBOT_ROBOT), but bob is attached"), "{err}");
    std::fs::remove_file(scenario).unwrap();
}

#[test]
fn a_sweep_runs_a_program_with_its_parameters_from_the_experiments_folder() {
    let folder = tempfile::tempdir().unwrap();
    let baudbot_program = env!("CARGO_BIN_EXE_baudbot");
    let script = format!(
        "speed=${{BAUDBOT_PARAMETERS#*:}}\nexec {baudbot_program} brain constant:left=${{speed%\\}}}},right=0.2 \
         --connect $BAUDBOT_CONNECT --world $BAUDBOT_WORLD --robot $BAUDBOT_ROBOT\n"
    );
    std::fs::write(folder.path().join("drive.sh"), script).unwrap();
    let experiment = folder.path().join("drive.toml");
    let toml = "scenario = \"khepera\"\nseconds = 2.0\nseeds = 2\n[brain]\nexec = \"sh drive.sh\"\n\
                [[fields]]\nfield = \"brain.left\"\nvalues = [0.1, 0.2]\n";
    std::fs::write(&experiment, toml).unwrap();
    let out = folder.path().join("out");
    let (experiment, out) = (experiment.to_str().unwrap(), out.to_str().unwrap());
    good(&["sweep", experiment, "--out", out, "--quiet"]);
    let table = std::fs::read_to_string(format!("{out}/rows.csv")).unwrap();
    let hashes = |table: &str| -> Vec<String> {
        table.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().to_owned()).collect()
    };
    assert_eq!(hashes(&table).len(), 4, "{table}");
    // The same as with that brain of the catalogue.
    let same = toml
        .replace("[brain]\nexec = \"sh drive.sh\"\n", "")
        .replace("scenario", "brain = \"constant:right=0.2\"\nscenario");
    std::fs::write(experiment, same).unwrap();
    let inside = format!("{out}-inside");
    good(&["sweep", experiment, "--out", &inside, "--quiet"]);
    let inside = std::fs::read_to_string(format!("{inside}/rows.csv")).unwrap();
    assert_eq!(hashes(&table), hashes(&inside), "{table}\n{inside}");
}
