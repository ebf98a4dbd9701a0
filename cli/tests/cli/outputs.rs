//! Outputs do not overwrite inputs, and files that are begun by `init`.

use std::fs;
use std::net::TcpStream;
use std::path::Path;
use std::process::Stdio;

use tempfile::TempDir;

use crate::cli::{Running, command, said};

const LASER: &str = include_str!("../../../catalogue/scenarios/devices/laser.toml");

/// A folder with a file of each kind that commands read.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    put("w.toml", include_bytes!("../../../catalogue/scenarios/wander.toml"));
    put("my.toml", include_bytes!("../../../catalogue/exercises/stop.toml"));
    put("brain.toml", include_bytes!("../../../brains/repertoires/wedge.toml"));
    put("firmware.toml", include_bytes!("../../../catalogue/scenarios/firmware.toml"));
    put("X.hex", include_bytes!("../../../catalogue/scenarios/firmware/wander.hex"));
    fs::create_dir(folder.path().join("firmware")).unwrap();
    put("firmware/wander.hex", include_bytes!("../../../catalogue/scenarios/firmware/wander.hex"));
    folder
}

/// Runs it in this folder to its end.
fn within(folder: &Path, line: &str) -> (i32, String, String) {
    said(command(&line.split(' ').collect::<Vec<_>>()).current_dir(folder).output().unwrap())
}

/// A command that is refused, because this output would go over this input, which stays as it was.
fn is_spared(line: &str, option: &str, (word, file): (&str, &str)) {
    let folder = folder();
    let before = fs::read(folder.path().join(file)).unwrap();
    let (code, out, err) = within(folder.path(), line);
    let expected =
        format!("error: {option} {file} would overwrite the {word} {file}; write to another file\n");
    assert_eq!((code, out.as_str(), err), (2, "", expected), "{line}");
    assert_eq!(fs::read(folder.path().join(file)).unwrap(), before, "{line}");
}

#[test]
fn no_output_goes_over_the_scenario() {
    for (command, option) in [
        ("check w.toml", "--svg"),
        ("check w.toml --json", "--svg"),
        ("run w.toml --seconds 1", "--csv"),
        ("run w.toml --seconds 1", "--timeline"),
        ("run w.toml --seconds 1", "--record"),
        ("plan w.toml --to 1,1", "--svg"),
        ("export-brain avoid --lang c --scenario w.toml", "--out"),
        ("budget w.toml", "--svg"),
        ("diagram w.toml", "--svg"),
        ("diagram w.toml", "--csv"),
    ] {
        is_spared(&format!("{command} {option} w.toml"), option, ("scenario", "w.toml"));
    }
}

#[test]
fn no_output_goes_over_an_exercise_a_brain_or_a_program() {
    is_spared("grade my.toml --brain avoid --junit my.toml", "--junit", ("exercise", "my.toml"));
    is_spared("grade stop --brain brain.toml --junit brain.toml", "--junit", ("brain", "brain.toml"));
    is_spared("run w.toml --brain robot=brain.toml:a.b=1 --csv brain.toml", "--csv", ("brain", "brain.toml"));
    is_spared("export-brain brain.toml --lang c --out brain.toml", "--out", ("brain", "brain.toml"));
    is_spared("plan w.toml --field brain.toml --svg brain.toml", "--svg", ("brain", "brain.toml"));
    let program = ("firmware", "firmware/wander.hex");
    is_spared("run firmware.toml --serial robot=firmware/wander.hex", "--serial", program);
    is_spared("run firmware --firmware robot=X.hex --vcd robot=X.hex", "--vcd", ("firmware", "X.hex"));
}

/// Else it would serve.
#[test]
fn no_audit_log_goes_over_a_scenario() {
    let folder = folder();
    let path = folder.path().join("w.toml");
    let file = path.to_str().unwrap();
    let before = fs::read(&path).unwrap();
    let addresses = ["--listen", "127.0.0.1:0", "--viewer", "off"];
    let (code, _, err) = Running::start(&[&["serve", file, "--audit", file], &addresses[..]].concat()).end();
    assert_eq!(code, 2, "{err}");
    assert!(err.contains(&format!("--audit {file} would overwrite the scenario {file}")), "{err}");
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[test]
fn other_files_are_written_over_and_built_in_names_are_no_files() {
    let folder = folder();
    fs::write(folder.path().join("wander"), "old").unwrap();
    for line in ["run w.toml --ticks 2 --quiet --csv my.toml", "run wander --ticks 2 --quiet --csv wander"] {
        assert_eq!(within(folder.path(), line), (0, String::new(), String::new()), "{line}");
    }
    assert!(fs::read_to_string(folder.path().join("my.toml")).unwrap().starts_with("t_s,"));
    assert!(fs::read_to_string(folder.path().join("wander")).unwrap().starts_with("t_s,"));
}

/// A scenario that comes through a pipe is read once, and nothing can go over it.
#[test]
fn a_scenario_from_a_pipe_is_still_run() {
    let folder = folder();
    let mut command = command(&["run", "/dev/stdin", "--ticks", "2", "--quiet", "--csv", "a.csv"]);
    let mut child = command.current_dir(folder.path()).stdin(Stdio::piped()).spawn().unwrap();
    let text = fs::read(folder.path().join("w.toml")).unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), &text).unwrap();
    let (code, _, err) = said(child.wait_with_output().unwrap());
    assert_eq!(code, 0, "{err}");
    assert!(fs::read_to_string(folder.path().join("a.csv")).unwrap().starts_with("t_s,"));
}

/// The error of a bag of this scenario, which is not begun.
fn no_bag(toml: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), toml).unwrap();
    let (code, _, err) =
        within(folder.path(), "run s.toml --brain none --seconds 0.2 --quiet --record r.mcap");
    assert_eq!(code, 0, "{err}");
    let (code, out, err) = within(folder.path(), "export r.mcap --rosbag2 bag --csv a.csv");
    assert_eq!((code, out.as_str()), (2, ""), "{err}");
    assert!(!folder.path().join("bag").exists() && !folder.path().join("a.csv").exists());
    err
}

#[test]
fn robots_and_lasers_do_not_become_one_in_a_bag() {
    let (arena, robot) = LASER.split_at(LASER.find("[[robots]]").unwrap());
    let named = |name: &str| robot.replace("name = \"robot\"", &format!("name = \"{name}\""));
    let two =
        [arena, &named("1-a"), "\n", &named("1_a").replace("start = {", "start = { x_m = 1.5,")].concat();
    assert_eq!(no_bag(&two), "error: robots `1-a` and `1_a` would both be `_1_a` in a bag; rename one\n");
    let from = LASER.find("[robots.sensors.urg]").unwrap();
    let until = LASER.find("[robots.motors]").unwrap();
    let laser = |name: &str| LASER[from..until].replace("urg", name);
    let two = [&LASER[..from], &laser("front-l"), &laser("front_l"), &LASER[until..]].concat();
    let expected =
        "error: sensors `front-l` and `front_l` of `robot` would both be `front_l` in a bag; rename one\n";
    assert_eq!(no_bag(&two), expected);
}

#[test]
fn an_example_goes_to_stdout_alone_if_it_needs_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let wander = include_str!("../../../catalogue/scenarios/wander.toml");
    assert_eq!(within(folder.path(), "init wander -"), (0, wander.to_owned(), String::new()));
    let (code, out, err) = within(folder.path(), "init firmware -");
    assert_eq!((code, out.as_str()), (2, ""), "{err}");
    assert!(err.starts_with("error: firmware: refers to firmware/wander.hex, which is written"), "{err}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_command_for_an_example_can_be_copied_into_a_shell() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, err) =
        said(command(&["init", "wander", "a b.toml"]).current_dir(folder.path()).output().unwrap());
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.ends_with("try it with: baudbot run 'a b.toml'\n"), "{out}");
}

#[test]
fn an_exercise_and_a_link_that_leads_nowhere_are_told_as_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let (code, _, err) = within(folder.path(), "init stop");
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("is an exercise") && err.contains("baudbot grade stop --toml > stop.toml"), "{err}");
    std::os::unix::fs::symlink("nowhere", folder.path().join("dang")).unwrap();
    let (code, _, err) = within(folder.path(), "init wander dang");
    let expected = "error: dang: is a link that leads nowhere; remove it, or choose another file\n";
    assert_eq!((code, err.as_str()), (2, expected));
}

/// A test starts a server at a free port, and reads where it is once the file is there.
#[test]
fn a_server_that_is_ready_says_where_it_is() {
    let folder = folder();
    let (file, again) = (folder.path().join("address"), folder.path().join("again"));
    fs::write(&file, "an older server").unwrap();
    let arguments = |file: &Path| {
        let words =
            ["serve", "wander", "--listen", "127.0.0.1:0", "--viewer", "off", "--json", "--port-file"];
        words.into_iter().map(str::to_owned).chain([file.display().to_string()]).collect::<Vec<_>>()
    };
    let start = |file| {
        let words = arguments(file);
        Running::start(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let mut server = start(&file);
    let line = server.lines_until("{").pop().unwrap();
    let ready: serde_json::Value = serde_json::from_str(&line).unwrap();
    let address = fs::read_to_string(&file).unwrap();
    assert_eq!(ready["connect"].as_str(), Some(address.trim_end()));
    assert_eq!(ready["worlds"][0], serde_json::json!({ "world": "wander", "robots": ["robot"] }));
    assert!(TcpStream::connect(address.trim_end()).is_ok());
    server.signal("-TERM");
    let (code, out, err) = server.end();
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    let missing = again.join("nowhere");
    let (code, _, err) = start(&missing).end();
    assert!(code != 0 && err.contains("--port-file"), "{err}");
}
