//! `baudbot export`: what is made of recordings.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use baudbot_recording::{Digests, RecordingFile, Writer, header, saved};
use baudbot_scenario::Override;
use baudbot_sim::World;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use roxmltree::Document;
use serde_json::Value;

use crate::cli::{baudbot, good, place};

const WANDER: &str = include_str!("../../../catalogue/scenarios/wander.toml");

/// Three robots in a row that drive into each other and the wall.
const THREE: &str = r#"
    name = "three"
    collision = "stop-robot"
    end.after_s = 4.0

    [[arena.polygons]]
    name = "border"
    solid = false
    points_m = [[-2, -1], [2, -1], [2, 1], [-2, 1]]

    [[robots]]
    name = "a"
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.02, wheel_radius_m = 0.05, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }
    sensors.heading = { kind = "compass" }

    [[robots]]
    name = "b"
    start = { x_m = 0.5, y_m = 0.05 }
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.02, wheel_radius_m = 0.05, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78, color = [200, 30, 30] }

    [[robots]]
    name = "c"
    start = { x_m = -0.5, heading_rad = 3.0 }
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.02, wheel_radius_m = 0.05, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }
"#;

/// Records a run with these options.
fn record(scenario: &str, options: &[&str], name: &str) -> String {
    let path = place(name).to_str().unwrap().to_owned();
    good(&[&["run", scenario, "--quiet", "--record", &path, "--record-hz", "0"], options].concat());
    path
}

/// Records [`THREE`] with these brains.
fn three(brains: &[&str], name: &str) -> String {
    let toml = place(&format!("{name}.toml"));
    fs::write(&toml, THREE).unwrap();
    let brains: Vec<_> = brains.iter().flat_map(|brain| ["--brain", brain]).collect();
    record(toml.to_str().unwrap(), &brains, name)
}

/// Two seconds of `wander`, and where they are.
fn two_seconds(name: &str) -> String {
    record("wander", &["--set", "end.after_s=2.0"], name)
}

fn refusal(code: i32, args: &[&str]) -> String {
    let (found, out, err) = baudbot(args);
    assert_eq!((found, out.as_str()), (code, ""), "{err}");
    err.strip_prefix("error: ").unwrap_or_else(|| panic!("no error: {err}")).trim_end().to_owned()
}

#[test]
fn the_table_and_the_trace_are_those_of_the_run() {
    let [csv, trace, run_csv, run_trace] =
        ["same-tape.csv", "same-tape.trace", "same-run.csv", "same-run.trace"].map(place);
    let paths = [&csv, &trace, &run_csv, &run_trace].map(|path| path.to_str().unwrap());
    let recorded =
        record("wander", &["--seconds", "2", "--csv", paths[2], "--timeline", paths[3]], "same.mcap");
    good(&["export", &recorded, "--csv", paths[0], "--timeline", paths[1]]);
    assert_eq!(fs::read_to_string(&csv).unwrap(), fs::read_to_string(&run_csv).unwrap());
    let [made, ran] = [&trace, &run_trace].map(|path| fs::read(path).unwrap());
    assert!(!ran.is_empty() && made == ran, "{} and {} bytes", made.len(), ran.len());
}

#[test]
fn a_part_of_the_run_has_the_rows_of_that_part() {
    let recorded = two_seconds("part.mcap");
    let whole = good(&["export", &recorded, "--csv", "-"]);
    let rows: Vec<_> = whole.lines().collect();
    assert_eq!(rows.len(), 1 + 201);
    let part = good(&["export", &recorded, "--csv", "-", "--from-s", "1.5", "--to-s", "1.7"]);
    assert_eq!(part.lines().collect::<Vec<_>>(), [&rows[..1], &rows[151..=171]].concat());
    let thin = good(&["export", &recorded, "--csv", "-", "--every", "50"]);
    assert_eq!(thin.lines().collect::<Vec<_>>(), [0, 1, 51, 101, 151, 201].map(|row| rows[row]));
    assert_eq!(good(&["export", &recorded, "--csv", "-", "--hz", "2"]), thin);
}

#[test]
fn parquet_has_the_numbers_of_the_table() {
    let recorded = three(&["a=constant:left=0.3,right=0.3", "none"], "parquet.mcap");
    let path = place("three.parquet");
    good(&["export", &recorded, "--parquet", path.to_str().unwrap(), "--every", "2"]);
    let table = good(&["export", &recorded, "--csv", "-", "--every", "2"]);
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let mut header = lines.next().unwrap();
    header[0] = "time_s";
    let compass = header.iter().position(|name| *name == "heading").unwrap();
    header[compass] = "heading.rad";
    let file = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
    let mut rows = 0;
    for (row, line) in file.get_row_iter(None).unwrap().zip(lines) {
        let row = row.unwrap();
        let names: Vec<_> = row.get_column_iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, header);
        for ((name, field), cell) in row.get_column_iter().zip(line) {
            let is_same = match field {
                Field::Double(value) => cell.parse() == Ok(*value),
                Field::Str(text) => cell == text,
                Field::Bool(truth) => cell == if *truth { "1" } else { "0" },
                Field::Null => cell.is_empty(),
                other => panic!("{name}: {other:?}"),
            };
            assert!(is_same, "{name}: {field:?} is not {cell}");
        }
        rows += 1;
    }
    assert_eq!(rows, 3 * 201);
}

#[test]
fn events_are_rows() {
    let recorded = three(&["a=constant:left=0.6,right=0.6", "none"], "events.mcap");
    let table = good(&["export", &recorded, "--events", "-"]);
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().iter().collect::<Vec<_>>().join(",");
    assert_eq!(header, "start_ns,end_ns,robot,kind,part,bytes,text");
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    let of = |kind: &str| rows.iter().filter(|row| &row[3] == kind).collect::<Vec<_>>();
    let collision = of("collision")[0];
    assert_eq!((&collision[2], &collision[6]), ("a", "`a` ran into `b`"));
    let at_ns: u64 = collision[0].parse().unwrap();
    assert!(at_ns > 0 && at_ns < 4_000_000_000 && at_ns.is_multiple_of(10_000_000), "{at_ns}");
    assert_eq!((&of("brain")[0][2], &of("brain")[0][6]), ("a", "`constant:left=0.6,right=0.6` drives `a`"));
    assert_eq!(of("ending").len(), 1);
    let acquire = of("acquire")[0];
    assert_eq!((&acquire[2], &acquire[4], &acquire[5], &acquire[6]), ("a", "heading", "", "read heading"));
    let think: Vec<_> = of("think").into_iter().filter(|row| &row[2] == "a").collect();
    assert_eq!(think.len(), 400, "one a tick");
    let late = good(&["export", &recorded, "--events", "-", "--from-s", "3"]);
    let ends = late.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse::<u64>().unwrap());
    assert!(ends.min().unwrap() >= 3_000_000_000, "{late}");
}

#[test]
fn the_picture_has_a_way_for_each_robot() {
    let brains = ["a=constant:left=0.6,right=0.6", "c=constant:left=0.5,right=0.3", "none"];
    let recorded = three(&brains, "ways.mcap");
    let picture = good(&["export", &recorded, "--svg", "-"]);
    let document = Document::parse(&picture).unwrap();
    let ways: Vec<_> =
        document.descendants().filter(|node| node.attribute("class") == Some("trail")).collect();
    assert_eq!(ways.len(), 3);
    let title = |i: usize| ways[i].first_element_child().unwrap().text().unwrap();
    assert!(title(0).starts_with("the path of a: ") && title(0).ends_with("1 collision"), "{}", title(0));
    assert_eq!(title(1).split(':').next(), Some("the path of b"));
    assert_eq!(ways[1].attribute("stroke"), Some("#aa1919"), "its own colour");
    let text = document.descendants().filter_map(|node| node.text()).collect::<Vec<_>>().join("\n");
    for part in ["The paths of 3 robots from 0 to 4 s", "a began here", "c ended here", "a ran into b at "] {
        assert!(text.contains(part), "{part}");
    }
    // A curve needs its points, a line only its ends.
    let points =
        |i: usize| ways[i].descendants().find_map(|node| node.attribute("d")).unwrap().matches('L').count();
    assert!(points(0) <= 2 && points(2) > 5, "{} and {} points", points(0), points(2));
}

/// All text of a picture.
fn words(picture: &str) -> String {
    let document = Document::parse(picture).unwrap();
    document.descendants().filter_map(|node| node.text()).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_picture_tells_what_ran_and_repeats_no_description_that_was_made_false() {
    let whole = "ARSim's arena, five IR sensors, a brain across 9600 baud 8N1";
    let seconds = ["--seconds", "0.5", "--seed", "7", "--brain", "avoid:forward=0.3"];
    let recorded = record("wander", &seconds, "as-described.mcap");
    let picture = words(&good(&["export", &recorded, "--svg", "-"]));
    assert!(picture.contains(whole), "{picture}");
    assert!(
        picture.contains("wander") && picture.contains("avoid:forward=0.3 · 9600 baud · seed 7"),
        "{picture}"
    );
    let slow = [&seconds[..], &["--set", "robots.robot.link.baud=2400", "--no-noise"]].concat();
    let recorded = record("wander", &slow, "slower.mcap");
    let picture = words(&good(&["export", &recorded, "--svg", "-"]));
    assert!(!picture.contains("9600"), "{picture}");
    assert!(picture.contains("changed: robots.robot.link.baud=2400, noise=false"), "{picture}");
    assert!(picture.contains("avoid:forward=0.3 · 2400 baud · seed 7"), "{picture}");
    let set = ["--set", "robots.robot.link.baud=2400"];
    let picture = words(&good(&[&["check", "wander", "--svg", "-"], &set[..]].concat()));
    assert!(
        !picture.contains("9600") && picture.contains("changed: robots.robot.link.baud=2400"),
        "{picture}"
    );
    let diagram = ["diagram", "wander", "--svg", "-", "--brain", "wander", "--seed", "3"];
    let picture = words(&good(&[&diagram, &set[..]].concat()));
    assert!(picture.contains("wander · 2400 baud · seed 3"), "{picture}");
    assert!(picture.contains("changed: robots.robot.link.baud=2400"), "{picture}");
}

#[test]
fn a_recording_is_summed_up() {
    let recorded = two_seconds("summary.mcap");
    let text = good(&["export", &recorded]);
    for part in [
        "wander, scenario wander, seed 1\n",
        "200 of 10 ms, from 0 to 2 s\n",
        "robot\n",
        // The brain may be gone before the file is closed or not, by the wall clock.
        " brain, 1 ending\n",
        &format!("by baudbot {}\n", env!("CARGO_PKG_VERSION")),
    ] {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
    let summary: Value = serde_json::from_str(&good(&["export", &recorded, "--json"])).unwrap();
    let run = good(&["run", "wander", "--set", "end.after_s=2.0", "--json", "--quiet"]);
    let run: Value = serde_json::from_str(&run).unwrap();
    assert_eq!(summary["last_state_hash"], run["state_hash"]);
    assert_eq!((&summary["simulated_s"], &summary["cut_off"]), (&Value::from(2.0), &Value::Null));
    assert_eq!(summary["bytes"], fs::metadata(&recorded).unwrap().len());
}

#[test]
fn what_is_left_of_a_recording_is_exported_with_a_note() {
    let recorded = two_seconds("cut.mcap");
    let whole = fs::read(&recorded).unwrap();
    fs::write(&recorded, &whole[..whole.len() - 100]).unwrap();
    let (code, table, note) = baudbot(&["export", &recorded, "--csv", "-"]);
    assert_eq!(code, 0);
    assert!(note.starts_with(&format!("note: {recorded}: the file is cut off")), "{note}");
    assert!(table.lines().count() > 1, "{table}");
    assert!(good(&["export", &recorded]).contains("cut off"));
}

/// A recording whose fingerprints are of another run.
fn that_differs(path: &Path) {
    let world = |seed: &str| {
        let changes = ["end.after_s=1.0", seed].map(|text| Override::parse(text).unwrap());
        World::new(baudbot_scenario::parse_with(WANDER, &changes).unwrap().into())
    };
    let (recorded, mut other) = (world("seed=1"), world("seed=2"));
    let head = header("wander", recorded.scenario(), None);
    let mut writer = Writer::new(RecordingFile::create(path).unwrap(), &head).unwrap();
    writer.state(&saved::state(&recorded)).unwrap();
    let mut digests = Digests::default();
    for _ in 0..50 {
        other.begin();
        digests.note(&other);
        other.finish(&[]);
    }
    writer.mark(&digests.last_mark(&other)).unwrap();
    writer.finish().unwrap();
}

#[test]
fn a_run_that_comes_out_otherwise_is_exported_with_a_warning() {
    let path = place("differs.mcap");
    that_differs(&path);
    let (code, table, warning) = baudbot(&["export", path.to_str().unwrap(), "--csv", "-"]);
    assert_eq!((code, table.lines().count()), (0, 1 + 51));
    assert!(warning.starts_with("warning: the replay differs from the recorded run, from tick 0 (0 s): "));
}

#[test]
fn outputs_are_kept_apart() {
    let recorded = two_seconds("apart.mcap");
    let out = place("apart.out");
    let out = out.to_str().unwrap();
    let same = refusal(2, &["export", &recorded, "--csv", out, "--svg", out]);
    assert_eq!(
        same,
        format!("--csv {out} and --svg {out} are the same file; write each to a file of its own")
    );
    let both = refusal(2, &["export", &recorded, "--events", "-", "--svg", "-"]);
    assert_eq!(both, "--events - and --svg - both write to stdout; write one of them to a file");
    let before = fs::read(&recorded).unwrap();
    let over = refusal(2, &["export", &recorded, "--parquet", &recorded]);
    assert!(over.starts_with(&format!("--parquet {recorded} would overwrite the recording")), "{over}");
    assert_eq!(fs::read(&recorded).unwrap(), before);
    let nowhere = place("nowhere").join("a.parquet");
    let nowhere = nowhere.to_str().unwrap();
    let error = refusal(1, &["export", &recorded, "--parquet", nowhere]);
    assert!(error.starts_with(&format!("cannot write {nowhere}: ")), "{error}");
    let full = refusal(1, &["export", &recorded, "--parquet", "/dev/full", "--quiet"]);
    assert!(full.starts_with("cannot write /dev/full: "), "{full}");
    assert!(refusal(2, &["export", &recorded, "--from-s", "9", "--csv", "-"]).contains("is from 0 s to 2 s"));
}

#[test]
fn what_is_no_recording_is_told() {
    let toml = place("none.mcap");
    fs::write(&toml, WANDER).unwrap();
    let toml = toml.to_str().unwrap();
    let error = refusal(2, &["export", toml, "--csv", "-"]);
    assert_eq!(error, format!("{toml}: is a scenario, not a recording; run it with `baudbot run {toml}`"));
    fs::write(toml, "none").unwrap();
    let error = refusal(2, &["export", toml, "--csv", "-"]);
    assert!(error.starts_with(&format!("{toml}: is not an MCAP file: ")), "{error}");
    let error = refusal(2, &["export", "/nowhere.mcap"]);
    assert_eq!(error, "/nowhere.mcap: cannot be read: No such file or directory (os error 2)");
}

/// A program in place of a browser: it writes its process down, does this in Bash with the page's address in `url`, and
/// stays.
fn browser(name: &str, bash: &str) -> (PathBuf, PathBuf) {
    let (program, told) = (place(name), place(&format!("{name}.told")));
    let text = format!(
        "#!/usr/bin/env bash\nurl=${{!#}}\nprintf '%s\n' $$ \"$@\" > '{}'\n{ASKS}{bash}\n",
        told.display()
    );
    crate::cli::write_program(&program, &text);
    (program, told)
}

/// A browser in Bash: `ask METHOD PATH BODY` prints the server's answer.
const ASKS: &str = r#"
server=${url#http://} server=${server%%/*}
ask() {
  exec 3<>"/dev/tcp/${server%:*}/${server##*:}"
  printf '%s %s HTTP/1.1\r\nHost: %s\r\nContent-Length: %d\r\nConnection: close\r\n\r\n%s' "$1" "$2" "$server" "${#3}" "$3" >&3
  cat <&3
}
"#;

fn film(recorded: &str, browser: &Path, args: &[&str]) -> (i32, String, String) {
    let mut command = crate::cli::command(&[&["export", recorded, "--quiet"], args].concat());
    crate::cli::said(command.env("BAUDBOT_BROWSER", browser).output().unwrap())
}

#[test]
fn a_film_is_what_the_page_hands_in() {
    let recorded = two_seconds("film.mcap");
    let bash = "ask GET / '' | grep -aqi '<html' || exit 4\nask POST /film \"GIF89a$url\"\nexec sleep 600";
    let (program, told) = browser("browser-good", bash);
    let out = place("film.gif");
    let options = ["--from-s", "0.5", "--speed", "2", "--fps", "20", "--width-px", "640", "--theme", "dark"];
    let args = [&["--gif", out.to_str().unwrap()], &options[..]].concat();
    assert_eq!(film(&recorded, &program, &args), (0, String::new(), String::new()));
    let made = fs::read_to_string(&out).unwrap();
    let asked = "/?film=gif&world=wander&from_s=0.5&to_s=2&speed=2&fps=20&width=640&theme=dark&post=/film";
    assert!(made.starts_with("GIF89ahttp://127.0.0.1:") && made.ends_with(asked), "{made}");
    let told = fs::read_to_string(told).unwrap();
    let (process, options) = told.split_once('\n').unwrap();
    assert!(!Path::new("/proc").join(process).join("exe").exists(), "the browser is gone");
    let profile = options.lines().find_map(|option| option.strip_prefix("--user-data-dir=")).unwrap();
    assert!(profile.contains("baudbot-film-") && !Path::new(profile).exists(), "{profile}");
    let is_root = Command::new("id").arg("-u").output().unwrap().stdout == b"0\n";
    assert_eq!(options.lines().any(|option| option == "--no-sandbox"), is_root);
}

#[test]
fn a_film_that_cannot_be_is_an_error_that_says_why() {
    let recorded = two_seconds("no-film.mcap");
    let out = place("no-film.webm");
    let out = out.to_str().unwrap();
    let failed = |bash: &str| {
        let (program, _) = browser("browser-bad", bash);
        let (code, _, err) = film(&recorded, &program, &["--webm", out]);
        assert_eq!(code, 1, "{err}");
        err
    };
    let refused = failed("ask POST '/film?failed=1' 'no encoder for VP9'\nexec sleep 600");
    assert_eq!(refused, "error: the page made no film: no encoder for VP9\n");
    let other = failed("ask POST /film GIF89a\nexec sleep 600");
    assert!(other.contains("the page did not make a valid webm (6 bytes)"), "{other}");
    let ended = failed("echo 'no display' >&2\nexit 3");
    assert_eq!(
        ended,
        "error: the browser ended without a film: exit status: 3 (its last message: no display)\n"
    );
    let (code, _, err) = film(&recorded, Path::new("/nowhere/chromium"), &["--webm", out]);
    assert_eq!(code, 2);
    assert!(err.contains("BAUDBOT_BROWSER: there is no program `/nowhere/chromium`"), "{err}");
    let mut without = crate::cli::command(&["export", &recorded, "--webm", out]);
    let (code, _, err) =
        crate::cli::said(without.env("PATH", "/nowhere").env_remove("BAUDBOT_BROWSER").output().unwrap());
    assert!(code == 2 && err.contains("apt install chromium"), "{err}");
    let many = refusal(2, &["export", &recorded, "--gif", out, "--speed", "0.0001"]);
    assert!(many.contains("would have 500001 pictures"), "{many}");
}

#[test]
fn ctrl_c_ends_the_browser() {
    let recorded = two_seconds("interrupted.mcap");
    let (program, told) = browser("browser-slow", "exec sleep 600");
    let out = place("interrupted.gif");
    let mut command = crate::cli::command(&["export", &recorded, "--quiet", "--gif", out.to_str().unwrap()]);
    let run = crate::cli::Running(command.env("BAUDBOT_BROWSER", &program).spawn().unwrap());
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(20);
    while !fs::read_to_string(&told).is_ok_and(|told| told.contains('\n')) {
        assert!(std::time::Instant::now() < deadline, "no browser was started");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    run.signal("-INT");
    assert_eq!(run.end().0, 130);
    let told = fs::read_to_string(told).unwrap();
    let process = told.lines().next().unwrap();
    assert!(!Path::new("/proc").join(process).join("exe").exists(), "the browser is gone");
}
