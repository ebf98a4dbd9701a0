//! Unmodified programs in simulated time: `baudbot program`, and `program:` as a brain. `tests/ports/simulated` has those of others.

use std::fs;

use serde_json::Value;

use crate::cli::{baudbot, good};

/// A robot that answers lines, at 9600 baud with two stop bits.
const SCENARIO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/ports/khepera.toml");
/// Asks for the sensors, and prints the answer.
const ASKS: &str = "stty -F /dev/ttyUSB0 9600 raw -echo cstopb; exec 3<>/dev/ttyUSB0; \
                    for i in 1 2 3; do printf 'N\\r' >&3; read -r line <&3; echo $line; done";

fn program(options: &[&str], script: &str) -> (i32, String, String) {
    baudbot(&[&["program", SCENARIO, "--seconds", "2"], options, &["--", "sh", "-c", script]].concat())
}

fn summary(options: &[&str], script: &str) -> (Value, String) {
    let (code, out, err) = program(&[options, &["--json", "--show-output"]].concat(), script);
    assert_eq!(code, 0, "{err}");
    (serde_json::from_str(&out).unwrap(), err)
}

#[test]
fn a_shell_asks_a_robot_and_the_same_run_comes_again_as_a_brain_and_as_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let (run, said) = summary(&["--record", file.to_str().unwrap()], ASKS);
    let lines: Vec<_> = said.lines().filter(|line| line.starts_with("n,")).collect();
    assert_eq!(lines.len(), 3, "{said}");
    assert_eq!(run["ending"], "its program has ended");
    // Three times two characters there and about twenty back, at 11 bits each, and the firmware's time.
    let ended_s = run["programs"][0]["ended_s"].as_f64().unwrap();
    assert!((0.07..0.12).contains(&ended_s), "{ended_s}");
    assert_eq!(run["programs"][0]["charged_calls"], 0);
    let (again, _) = summary(&[], ASKS);
    assert_eq!(run["state_hash"], again["state_hash"]);
    let script = folder.path().join("asks.sh");
    fs::write(&script, ASKS).unwrap();
    let brain = format!("program:/dev/ttyUSB0=robot sh {}", script.display());
    let as_brain = good(&["run", SCENARIO, "--seconds", "2", "--json", "--quiet", "--brain", &brain]);
    let as_brain: Value = serde_json::from_str(&as_brain).unwrap();
    assert_eq!(run["state_hash"], as_brain["state_hash"]);
    let replayed: Value = serde_json::from_str(&good(&["replay", file.to_str().unwrap(), "--json"])).unwrap();
    assert!(replayed.to_string().contains(run["state_hash"].as_str().unwrap()), "{replayed}");
}

#[test]
fn a_price_is_told_and_takes_simulated_time() {
    let looks = "i=0; while [ $i -lt 20 ]; do date +%N > /dev/null; i=$((i+1)); done";
    let (run, _) = summary(&["--cpu-price", "1ms"], looks);
    assert_eq!(run["programs"][0]["price_ns"], 1_000_000);
    let (calls, charged_s) = (&run["programs"][0]["charged_calls"], &run["programs"][0]["charged_s"]);
    let (calls, charged_s) = (calls.as_u64().unwrap(), charged_s.as_f64().unwrap());
    assert!(calls >= 20 && (charged_s - calls as f64 * 1e-3).abs() < 1e-9, "{calls} {charged_s}");
    let (free, _) = summary(&[], looks);
    assert_eq!(free["programs"][0]["charged_calls"], 0);
}

#[test]
fn what_cannot_be_is_said_with_the_reason() {
    for (options, script, code, words) in [
        (&[][..], "echo broken >&2; exit 3", 1, "it ended with code 3 at 0 s; it printed\n  broken"),
        (
            &["--port", "/dev/ttyS9=front"],
            "true",
            2,
            "no cable `front` for /dev/ttyS9; its cables are: robot",
        ),
        (&["--port", "front"], "true", 2, "write a path below /dev and a cable, as in /dev/ttyUSB0=robot"),
        (&["--cpu-price", "5"], "true", 2, "`price=5`: a price is a number with its unit"),
        (
            &["--pace", "real-time"],
            "true",
            2,
            "what needs a server is not: other programs (exec:), viewers, real time",
        ),
        (&["--robot", "nobody"], "true", 2, "there is no robot `nobody`; there are: khepera"),
        (&["--over", "grpc"], "true", 2, "what needs a server is not"),
    ] {
        let (ended, out, err) = program(options, script);
        assert!(ended == code && err.contains(words), "{options:?}: {ended} {out}{err}");
    }
    let (code, _, err) = baudbot(&["budget", SCENARIO, "--brain", "program:true"]);
    assert!(code == 2 && err.contains("so it has no budget; a run measures it"), "{err}");
    let mixed = ["run", "office", "--brain", "a=program:true", "--brain", "exec:true"];
    let (code, _, err) = baudbot(&mixed);
    assert!(code == 2, "{err}");
}

#[test]
fn a_program_that_waits_for_ever_is_told_at_the_end_of_the_run() {
    let (run, _) = summary(&[], "read -r line < /dev/ttyUSB0");
    let waits = run["programs"][0]["waits"].to_string();
    assert!(waits.contains("sh waits in read for what another task or a port does"), "{waits}");
    assert_eq!(run["programs"][0]["ended_s"], Value::Null);
}

/// A brain that is a program is one in experiments and exercises, too.
#[test]
fn an_experiment_varies_the_robot_of_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let (script, experiment) = (folder.path().join("drives.sh"), folder.path().join("rates.toml"));
    fs::write(&script, "stty -F /dev/ttyUSB0 $1 raw -echo cstopb; printf 'D,5,5\\r' > /dev/ttyUSB0; sleep 1")
        .unwrap();
    let text = format!(
        "scenario = {SCENARIO:?}\nbrain = \"program:sh {} {{baud}}\"\nseeds = 2\nseconds = 3\n\
         [[fields]]\nfield = \"robots.khepera.link.baud\"\nvalues = [1200, 9600]\n",
        script.display()
    );
    fs::write(&experiment, text).unwrap();
    let out = folder.path().join("out");
    good(&["sweep", experiment.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()]);
    let tables = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    let runs = tables
        .map(|path| fs::read_to_string(path).unwrap_or_default())
        .find(|text| text.contains("seed"))
        .unwrap();
    assert!(!runs.contains("error:"), "{runs}");
}

/// A program that knows one rate only: the search finds it.
#[test]
fn a_search_finds_the_limit_of_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let (script, experiment) = (folder.path().join("drives.sh"), folder.path().join("rates.toml"));
    let text = "stty -F /dev/ttyUSB0 9600 raw -echo cstopb; printf 'D,5,5\\r' > /dev/ttyUSB0; sleep 1";
    fs::write(&script, text).unwrap();
    let text = format!(
        "scenario = {SCENARIO:?}\nbrain = \"program:sh {}\"\nseeds = 2\nseconds = 3\n\
         [[fields]]\nfield = \"robots.khepera.link.baud\"\nvalues = [1200, 2400, 4800, 9600]\n\
         [success]\ndistance_m_at_least = 0.02\n",
        script.display()
    );
    fs::write(&experiment, text).unwrap();
    let said = good(&["sweep", experiment.to_str().unwrap(), "--find", "robots.khepera.link.baud"]);
    assert!(said.contains(": 9600 (2 of 2 seeds"), "{said}");
}
