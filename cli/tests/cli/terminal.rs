//! The text of others is shown on a terminal, and never obeyed by it.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::cli::{baudbot, good, place};

const WANDER: &str = include_str!("../../../catalogue/scenarios/wander.toml");

/// Sequences that clear a screen, name a window, turn writing around and go back in a line, as TOML writes them.
const HOSTILE: &str = r"\u001b[2J\u001b]0;owned\u0007\u009b31m\u202egnp\u2066\r\b";

/// Whether a terminal only shows it.
fn is_shown(text: &str) -> bool {
    text.chars().all(|c| c == '\n' || baudbot_fields::printable::is_printable(c))
}

fn scenario(name: &str, toml: &str) -> String {
    let path = place(name);
    std::fs::write(&path, toml).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_description_is_shown_on_one_line_and_escaped() {
    let (head, rest) = WANDER.split_once("description = ").unwrap();
    let (_, rest) = rest.split_once('\n').unwrap();
    let toml = format!("{head}description = \"two\\nlines{HOSTILE}\"\n{rest}");
    let path = scenario("described.toml", &toml);
    let told = good(&["check", &path]);
    assert!(is_shown(&told), "{told:?}");
    assert!(
        told.contains(r"  description  two lines\u{1b}[2J\u{1b}]0;owned\u{7}\u{9b}31m\u{202e}gnp"),
        "{told}"
    );
    for command in [&["run", &path, "--seconds", "0.1"][..], &["budget", &path], &["diagram", &path]] {
        let (code, out, err) = baudbot(command);
        assert_eq!(code, 0, "{err}");
        assert!(is_shown(&out) && is_shown(&err), "{out:?} {err:?}");
    }
    let picture = good(&["check", &path, "--svg", "-"]);
    assert!(is_shown(&picture) && roxmltree::Document::parse(&picture).is_ok(), "{picture:?}");
}

#[test]
fn what_an_error_quotes_of_a_file_is_shown() {
    let raw = HOSTILE.replace(r"\u001b", "\u{1b}").replace(r"\u202e", "\u{202e}");
    for (i, toml) in [
        format!("name = \"{HOSTILE}\""),
        format!("\"{HOSTILE}\" = 1"),
        format!("[[robots]]\nname = \"{HOSTILE}\""),
        format!("[[robots]]\nname = \"r\"\npreset = \"{HOSTILE}\""),
        format!("[[robots]]\nname = \"r\"\nlink.kind = \"{HOSTILE}\""),
        format!("[[arena.maps]]\nname = \"m\"\nros = \"{HOSTILE}\""),
        // No TOML: the error shows the line.
        format!("step_ms = {raw}"),
    ]
    .iter()
    .enumerate()
    {
        let path = scenario(&format!("hostile-{i}.toml"), toml);
        for command in ["check", "run", "budget"] {
            let (code, _, err) = baudbot(&[command, &path]);
            assert_eq!(code, 2, "{err}");
            assert!(is_shown(&err) && err.starts_with("error: "), "{toml}: {err:?}");
        }
    }
    // An experiment, and the name of a file.
    let experiment = scenario(
        "hostile.toml",
        &format!(
            "scenario = \"wander\"\nbrain = \"{HOSTILE}\"\nseconds = 1.0\n[[fields]]\nfield = \"{HOSTILE}\"\nvalues = [1]"
        ),
    );
    for command in [&["sweep", &experiment][..], &["check", "\u{1b}[31m\u{202e}.toml"]] {
        let (code, _, err) = baudbot(command);
        assert_eq!(code, 2, "{err}");
        assert!(is_shown(&err), "{err:?}");
    }
}

#[test]
fn a_brain_with_a_name_that_a_terminal_obeys_does_not_attach() {
    let (_server, tcp, _) = crate::cli::processes::serve("hostile.sock", &["wander"]);
    let brain = "[motor.stroll]\nkind = \"wander\"\nutility = { bias = 0.3 }\n";
    let path = scenario("b\u{1b}[2J\u{202e}.toml", brain);
    let (code, _, err) = baudbot(&["brain", &path, "--connect", &tcp]);
    assert_eq!(code, 1, "{err}");
    assert!(
        err.contains("hello.brain: must be on one line and without control characters, is `")
            && err.contains(r"b\u{1b}[2J\u{202e}.toml"),
        "{err:?}"
    );
    assert!(is_shown(&err), "{err:?}");
}

/// All that there is to print, without what needs a server or a robot.
const PRINTING: [&[&str]; 17] = [
    &["run", "--ticks", "2"],
    &["brain", "--list"],
    &["budget", "wander"],
    &["check", "wander", "--json"],
    &["check", "wander", "--svg", "-"],
    &["completions", "bash"],
    &["diagram", "wander"],
    &["grade"],
    &["help"],
    &["help", "run"],
    &["init", "wander", "-"],
    &["list", "--json"],
    &["plan", "wander", "--to", "1,1"],
    &["preset", "khepera-1"],
    &["run", "--ticks", "2", "--quiet", "--csv", "-"],
    &["schema"],
    &["--version"],
];

/// The help of each command, as `man` lists them.
fn helps() -> Vec<Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    good(&["man", folder.path().to_str().unwrap()]);
    let pages = std::fs::read_dir(folder.path().join("man1")).unwrap();
    let helps = pages.map(|page| {
        let name = page.unwrap().file_name().into_string().unwrap();
        let words = name.trim_end_matches(".1").split('-').skip(1).filter(|word| *word != "help");
        words.map(str::to_owned).chain(["--help".to_owned()]).collect()
    });
    helps.collect()
}

#[test]
fn nothing_that_is_printed_is_lost_without_a_word() {
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    // The reading end of the pipe is gone.
    let closed = || {
        let (_, writer) = std::io::pipe().unwrap();
        writer
    };
    let helps = helps();
    assert!(helps.len() > 30, "{helps:?}");
    let printing = PRINTING.iter().map(|words| words.iter().map(|&word| word.to_owned()).collect());
    for words in printing.chain(helps) {
        let words: Vec<_> = words;
        let to = |stdout: Stdio| {
            let ended = Command::new(env!("CARGO_BIN_EXE_baudbot"))
                .args(&words)
                .stdin(Stdio::null())
                .stdout(stdout)
                .output()
                .unwrap();
            (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
        };
        let (code, err) = to(full().into());
        let complaint =
            err.strip_prefix("error: cannot write ").unwrap_or_else(|| panic!("{words:?}: {err}"));
        assert!(code == Some(1) && complaint.contains("No space left on device"), "{words:?}: {err}");
        assert_eq!(to(closed().into()), (Some(141), String::new()), "{words:?}");
    }
}

#[test]
fn a_reader_who_has_read_enough_is_no_error() {
    let recording = place("long.mcap");
    let recording = recording.to_str().unwrap();
    good(&["run", "wander", "--seconds", "60", "--quiet", "--record", recording]);
    // Each of these writes more than a pipe holds.
    for command in [
        &["schema"][..],
        &["run", "wander", "--seconds", "600", "--quiet", "--csv", "-"],
        &["export", recording, "--csv", "-"],
    ] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_baudbot"))
            .args(command)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(program.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let ended = program.wait_with_output().unwrap();
        assert!(!line.is_empty(), "{command:?}");
        assert_eq!(String::from_utf8(ended.stderr).unwrap(), "", "{command:?}");
        assert_eq!(ended.status.code(), Some(141), "{command:?}: as if SIGPIPE had ended it");
    }
}
