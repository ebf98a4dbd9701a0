//! Files that earlier versions have written: each is read, and has its content still.
//!
//! `tests/data/released/VERSION` has one of each kind, and `expected.json` has their content. README.md there describes
//! how a release adds to it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use baudbot_access::TokenFile;
use baudbot_recording::RecordedRun;
use baudbot_sim::World;
use serde_json::{Value, json};

use crate::state::operator::stepped;
use crate::state::server::Server;
use crate::state::{WANDER, place, text};

fn released() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/released")
}

/// The folders of the versions.
fn versions() -> Vec<PathBuf> {
    let folders = fs::read_dir(released()).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<_> = folders.filter(|path| path.is_dir()).collect();
    folders.sort();
    assert!(!folders.is_empty());
    folders
}

fn expected(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("expected.json")).unwrap()).unwrap()
}

/// Runs the program in a folder; returns its exit code and its output.
fn baudbot(folder: &Path, args: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_baudbot")).current_dir(folder).args(args).output().unwrap();
    let said = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), said(output.stdout), said(output.stderr))
}

fn hash(world: &World) -> String {
    format!("{:016x}", world.hash())
}

#[test]
fn recordings_and_saved_states_of_earlier_versions_are_read() {
    for folder in versions() {
        let expected = expected(&folder);
        let recorded = RecordedRun::open(&folder.join("recording.mcap")).unwrap();
        assert!(recorded.is_whole() && recorded.scratch().is_none());
        let found = json!({
            "inputs": recorded.inputs(), "last_tick": recorded.last_tick(),
            "state_hash": format!("{:016x}", recorded.last_hash()),
        });
        assert_eq!(found, expected["recording"], "{}", folder.display());
        let (code, out, err) = baudbot(&folder, &["replay", "recording.mcap"]);
        assert_eq!(code, Some(0), "{out}{err}");
        let saved = RecordedRun::open(&folder.join("saved.mcap")).unwrap().first_state().unwrap();
        assert_eq!(json!({ "tick": saved.tick(), "state_hash": hash(&saved) }), expected["saved"]);
    }
}

#[test]
fn state_of_earlier_versions_goes_on() {
    for folder in versions() {
        let version = folder.file_name().unwrap().to_str().unwrap().to_owned();
        let copy = place(&format!("released-{version}"));
        let copied =
            Command::new("cp").args(["-r", text(&folder.join("state")), text(&copy)]).status().unwrap();
        assert!(copied.success());
        let server = Server::start(&copy, &format!("released-{version}"), &[]);
        let mut operator = server.operator();
        let expected = expected(&folder);
        let told = |status: &baudbot_proto::v1::WorldStatus| json!({ "tick": status.tick, "state_hash": format!("{:016x}", status.state_hash) });
        assert_eq!(told(&operator.status("kept").unwrap()), expected["state"], "{}", server.log());
        assert_eq!(told(&operator.restore("kept", 1).unwrap()), expected["snapshot"]);
    }
}

#[test]
fn tokens_policies_and_journals_of_sweeps_of_earlier_versions_are_read() {
    for folder in versions() {
        let expected = expected(&folder);
        let grants = TokenFile::at("tokens.toml")
            .parse(&fs::read_to_string(folder.join("tokens.toml")).unwrap())
            .unwrap();
        let names: Vec<_> = grants.iter().map(|grant| grant.name.to_string()).collect();
        assert_eq!(json!(names), expected["tokens"]);
        let drive = ["run", "wander", "--brain", "policy.toml", "--ticks", "50", "--json", "--quiet"];
        let (code, out, err) = baudbot(&folder, &drive);
        assert_eq!(code, Some(0), "{err}");
        let summary: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(summary["state_hash"], expected["policy"]["state_hash"]);
        // Runs of other versions are not mixed with those of this one.
        let copy = place("released-sweep");
        let copied =
            Command::new("cp").args(["-r", text(&folder.join("sweep")), text(&copy)]).status().unwrap();
        assert!(copied.success());
        let (code, _, err) = baudbot(&copy, &["sweep", "small.toml", "--out", "out"]);
        let other = "belongs to another experiment, scenario or version";
        assert!(code == Some(0) || err.contains(other), "{err}");
        assert!(!err.contains("damage"), "{err}");
    }
}

/// Writes the files of this version: see README.md beside them.
#[test]
#[ignore = "for a release: writes tests/data/released/VERSION"]
fn write_the_files_of_this_version() {
    let version = env!("CARGO_PKG_VERSION").rsplit_once('.').unwrap().0;
    let folder = released().join(version);
    fs::create_dir(&folder).unwrap();
    let good = |args: &[&str]| {
        let (code, out, err) = baudbot(&folder, args);
        assert_eq!(code, Some(0), "{err}");
        out
    };
    let drive = "constant:left=0.2,right=0.1";
    let run = ["run", "wander", "--brain", drive, "--ticks", "60", "--quiet", "--record", "recording.mcap"];
    good(&[&run[..], &["--record-hz", "0"]].concat());
    good(&["token", "new", "--name", "alice", "--drive", "wander/alice", "--file", "tokens.toml"]);
    good(&["token", "new", "--name", "viewer", "--observe", "--file", "tokens.toml"]);
    fs::write(folder.join("policy.toml"), POLICY).unwrap();
    fs::create_dir(folder.join("sweep")).unwrap();
    fs::write(folder.join("sweep/small.toml"), SWEEP).unwrap();
    good(&["sweep", "sweep/small.toml", "--out", "sweep/out"]);
    for other in ["rows.csv", "rows.parquet", "summary.txt"] {
        let _ = fs::remove_file(folder.join("sweep/out").join(other));
    }
    let policy = good(&["run", "wander", "--brain", "policy.toml", "--ticks", "50", "--json", "--quiet"]);
    let policy: Value = serde_json::from_str(&policy).unwrap();

    let state = place("written");
    let server = Server::start(&state, "written", &[]);
    let mut operator = server.operator();
    operator.create("kept", WANDER, (stepped(), false), &["seed=4"]).unwrap();
    operator.delete("wander").unwrap();
    operator.start("kept").unwrap();
    let snapshot = operator.step("kept", 10).unwrap();
    operator.snapshot("kept").unwrap();
    operator.put("kept", (0.2, 0.1, 1.0)).unwrap();
    let kept = operator.step("kept", 15).unwrap();
    fs::write(folder.join("saved.mcap"), operator.save("kept").unwrap()).unwrap();
    server.kill();
    fs::remove_dir(state.join("recordings")).unwrap();
    assert!(
        Command::new("cp")
            .args(["-r", text(&state), text(&folder.join("state"))])
            .status()
            .unwrap()
            .success()
    );

    let recorded = RecordedRun::open(&folder.join("recording.mcap")).unwrap();
    let told = |tick: u64, hash: u64| json!({ "tick": tick, "state_hash": format!("{hash:016x}") });
    let expected = json!({
        "recording": {
            "inputs": recorded.inputs(), "last_tick": recorded.last_tick(),
            "state_hash": format!("{:016x}", recorded.last_hash()),
        },
        "saved": told(kept.tick, kept.state_hash),
        "state": told(kept.tick, kept.state_hash),
        "snapshot": told(snapshot.tick, snapshot.state_hash),
        "tokens": ["alice", "viewer"],
        "policy": { "state_hash": policy["state_hash"] },
    });
    let expected = serde_json::to_string_pretty(&expected).unwrap() + "\n";
    fs::write(folder.join("expected.json"), expected).unwrap();
}

const POLICY: &str = "description = \"drives in a circle\"\n\n[policy]\nversion = 1\n\
    layers = [[[0.0, 0.0, 0.0, 0.0, 0.0, 0.2], [0.0, 0.0, 0.0, 0.0, 0.0, 0.1]]]\n";

const SWEEP: &str = "name = \"small\"\nscenario = \"wander\"\nseconds = 0.2\nseeds = 1\n\
    brain = \"constant:left=0.1,right=0.1\"\n\n[[fields]]\nfield = \"robots.robot.link.baud\"\nlabel = \"baud\"\n\
    unit = \"bit/s\"\nvalues = [9600, 38400]\n";
