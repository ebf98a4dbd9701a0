//! Sections that need Rust only.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::shell::{Failure, Shell};
use crate::{house, map, records, sections};

/// The tests that take long, and those that take so long that not each change waits for them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SlowTests {
    tests: BTreeMap<String, String>,
    longest: BTreeMap<String, String>,
}

pub(super) fn formatting(shell: &Shell) -> Result<(), Failure> {
    let mut command = shell.command("cargo");
    command.args(["fmt", "--all", "--check"]);
    shell.run(command)
}

/// Circles of modules, what is too long, errors that are texts; the ladder's tables; ways from a brain to the world.
pub(super) fn structure(shell: &Shell) -> Result<(), Failure> {
    let root = &shell.place.root;
    let mut findings = house::findings(root)?;
    findings.extend(map::finding(shell)?);
    findings.extend(sections::faults(&records::times(root)?, &records::greens(root)?));
    for package in ["baudbot-brain", "baudbot-client", "baudbot-brains"] {
        let mut command =
            shell.cargo(["tree", "-p", package, "--all-features", "-e", "normal", "--prefix", "none"]);
        command.env("CARGO_TERM_COLOR", "never");
        let tree = shell.text(command)?;
        // A brain knows only its readings: Cargo must not give it a way to the world.
        if tree.lines().any(|line| line.starts_with("baudbot-sim ") || line.starts_with("baudbot-server ")) {
            findings.push(format!("{package} depends on the world; cargo tree -p {package} --all-features -e normal shows the way"));
        }
    }
    if findings.is_empty() {
        shell.say(&format!("{}; no way from a brain to the world", house::nothing_amiss(root)?));
        return Ok(());
    }
    Err(Failure::Wrong(findings.join("\n")))
}

/// Tests of all packages. The features and packages are the same in all commands, so that nothing is built twice.
pub(super) fn of_all<'a>(shell: &Shell, words: impl IntoIterator<Item = &'a str>) -> Command {
    shell.cargo(["test", "--workspace", "--all-features", "--no-fail-fast"].into_iter().chain(words))
}

/// Tests that wait for something run beside others.
fn side_by_side(command: &mut Command) {
    let threads = 2 * std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
    command.env("RUST_TEST_THREADS", threads.to_string());
}

impl SlowTests {
    fn of(shell: &Shell) -> Result<Self, Failure> {
        let path = shell.place.root.join("xtask/slow-tests.toml");
        let text = std::fs::read_to_string(&path).map_err(Failure::file(&path))?;
        Ok(toml::from_str(&text).map_err(|error| records::Error::Text { path, error })?)
    }
}

pub(super) fn tests(shell: &Shell) -> Result<(), Failure> {
    let slow = SlowTests::of(shell)?;
    shell.run(of_all(shell, ["--no-run"]))?;
    let mut command = of_all(shell, ["--quiet", "--lib", "--bins", "--tests", "--examples", "--", "--exact"]);
    command.args(slow.tests.keys().chain(slow.longest.keys()).flat_map(|name| ["--skip", name]));
    side_by_side(&mut command);
    shell.run(command)
}

/// The slow ones alone, and the examples in documentation.
pub(super) fn slow_tests(shell: &Shell) -> Result<(), Failure> {
    each_passes(shell, &SlowTests::of(shell)?.tests)?;
    shell.run(of_all(shell, ["--quiet", "--doc"]))
}

pub(super) fn longest_tests(shell: &Shell) -> Result<(), Failure> {
    each_passes(shell, &SlowTests::of(shell)?.longest)
}

/// Runs tests by their names.
fn each_passes(shell: &Shell, tests: &BTreeMap<String, String>) -> Result<(), Failure> {
    let mut command = of_all(shell, ["--lib", "--bins", "--tests", "--examples", "--", "--exact"]);
    command.args(tests.keys());
    shell.run(command)?;
    let log = shell.log_text()?;
    // A name that no test has any more would go unnoticed.
    let has_run = |name: &&String| {
        log.lines().any(|line| line.starts_with(&format!("test {name} ...")) && line.ends_with("ok"))
    };
    if let Some(name) = tests.keys().find(|name| !has_run(name)) {
        return Err(Failure::Wrong(format!(
            "xtask/slow-tests.toml: no test has the name `{name}`; mend or remove the line"
        )));
    }
    Ok(())
}

pub(super) fn fuzz_briefly(shell: &Shell) -> Result<(), Failure> {
    let mut command = of_all(shell, ["--quiet", "--example", "fuzz"]);
    command.env("BAUDBOT_FUZZ_SECONDS", "1");
    shell.run(command)
}

/// The program of the tests' profile, with all features, which other sections use. It is what the tests were built with: an
/// example among the targets makes Cargo choose the features as it does for tests.
pub(super) fn built(shell: &Shell) -> Result<PathBuf, Failure> {
    shell.run(shell.cargo([
        "build",
        "--quiet",
        "--workspace",
        "--all-features",
        "--bin",
        "baudbot",
        "--example",
        "soak",
    ]))?;
    Ok(shell.place.program())
}

pub(super) fn main_job(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    runs_as_in_readme(shell, shell.command(program))
}

fn runs_as_in_readme(shell: &Shell, command: Command) -> Result<(), Failure> {
    let printed = shell.text(command)?;
    let readme = shell.place.root.join("README.md");
    let readme = std::fs::read_to_string(&readme).map_err(Failure::file(&readme))?;
    let hash_of =
        |text: &str| text.lines().find_map(|line| line.strip_prefix("state hash  ").map(str::to_owned));
    let (promised, hash) = (hash_of(&readme), hash_of(&printed));
    if hash.is_none() || hash != promised {
        return Err(Failure::Wrong(format!(
            "README's first run has the state hash {hash:?}, and README promises {promised:?}:\n{printed}"
        )));
    }
    shell.say(&format!("README's first run has the state hash {}", hash.unwrap_or_default()));
    Ok(())
}

pub(super) fn lints(shell: &Shell) -> Result<(), Failure> {
    shell.run(shell.cargo([
        "clippy",
        "--quiet",
        "--workspace",
        "--all-targets",
        "--all-features",
        "--",
        "-D",
        "warnings",
    ]))
}

pub(super) fn documentation(shell: &Shell) -> Result<(), Failure> {
    let mut command = shell.cargo(["doc", "--workspace", "--no-deps", "--all-features"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    shell.run(command)
}

/// The crates that know no operating system.
const PURE: [&str; 8] = [
    "baudbot-fields",
    "baudbot-geometry",
    "baudbot-wire",
    "baudbot-avr",
    "baudbot-board",
    "baudbot-brain",
    "baudbot-sim",
    "baudbot-scenario",
];

fn check_for<'a>(
    shell: &Shell,
    target: &'a str,
    packages: &[&'a str],
    options: &[&'a str],
) -> Result<(), Failure> {
    let packages = packages.iter().flat_map(|package| ["-p", package]);
    let words = ["check", "--quiet", "--lib", "--target", target]
        .into_iter()
        .chain(packages)
        .chain(options.iter().copied());
    shell.run(shell.cargo(words))
}

/// The page's section builds the rest for browsers.
pub(super) fn bare_metal(shell: &Shell) -> Result<(), Failure> {
    check_for(shell, "thumbv7em-none-eabihf", &PURE, &[])?;
    check_for(shell, "wasm32-unknown-unknown", &[&PURE[1..], &["baudbot-brains"]].concat(), &[])?;
    // Recordings are read and written in browsers without their compressor in C.
    check_for(shell, "wasm32-unknown-unknown", &["baudbot-recording"], &["--no-default-features"])
}

/// As a newcomer builds it: the program alone, without what the tests switch on in its dependencies. What such a program
/// cannot do it says.
pub(super) fn program(shell: &Shell) -> Result<(), Failure> {
    shell.run(shell.cargo(["build", "--release"]))?;
    let program = shell.place.target.join("release/baudbot");
    runs_as_in_readme(shell, shell.command(&program))?;
    let scratch = shell.place.scratch("program").map_err(Failure::file(&shell.place.target))?;
    let map = scratch.join("map.toml");
    std::fs::write(&map, "[[arena.maps]]\nname = \"m\"\nros = \"m.yaml\"\n").map_err(Failure::file(&map))?;
    let (map, certificates) =
        (map.to_string_lossy().into_owned(), scratch.join("ca").to_string_lossy().into_owned());
    let without: [(&[&str], &str); 5] = [
        (&["watch", "--foxglove"], "built without it; cargo build --release --features foxglove"),
        (
            &["tune", "catalogue/experiments/tune-sweeper.toml"],
            "built without optimizers; cargo build --release --features tune",
        ),
        (
            &["cert", "ca", &certificates],
            "built without certificates; cargo build --release --features certificates",
        ),
        (&["check", &map], "built without maps and plans; cargo build --release --features maps"),
        (&["run", "--seconds", "0.1", "--quiet"], "built without the feature otel: nothing is exported"),
    ];
    for (arguments, words) in without {
        let mut command = shell.command(&program);
        command.args(arguments).env("OTEL_EXPORTER_OTLP_ENDPOINT", "http://127.0.0.1:1");
        let printed = shell.printed(command, true)?;
        if printed.status.success() != (arguments[0] == "run") || !printed.text.contains(words) {
            return Err(Failure::Wrong(format!(
                "baudbot {} does not say `{words}`:\n{}",
                arguments.join(" "),
                printed.text
            )));
        }
    }
    shell.say("what it was built without it says");
    Ok(())
}

/// No workload needs more instructions than it is known to, by more than 2 %.
pub(super) fn instructions(shell: &Shell) -> Result<(), Failure> {
    shell.run(shell.cargo(["build", "--release", "-p", "baudbot-bench"]))?;
    let mut command = shell.command(shell.place.target.join("release/baudbot-bench"));
    command.args(["--instructions", "--check", "crates/bench/instructions.toml"]);
    shell.run(command)
}

pub(super) fn supply_chain(shell: &Shell) -> Result<(), Failure> {
    cargo_deny(shell, &["check", "bans", "licenses", "sources"])
}

/// Runs cargo-deny, which is built once for all checkouts of this machine. No registry but crates.io has this version.
pub(super) fn cargo_deny(shell: &Shell, arguments: &[&str]) -> Result<(), Failure> {
    const VERSION: &str = "0.20.2";
    let home = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
    let cache = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache")));
    let folder = cache.map_or_else(|| shell.place.target.join("tools"), |cache| cache.join("baudbot"));
    let folder = folder.join(format!("cargo-deny-{VERSION}"));
    let program = folder.join("bin/cargo-deny");
    if !program.is_file() {
        shell.say(&format!(
            "building cargo-deny {VERSION} in {}, once: about three minutes",
            folder.display()
        ));
        let built = shell.place.scratch("cargo-deny").map_err(Failure::file(&shell.place.target))?;
        let mut command = shell.cargo(["install", "--quiet", "--debug", "cargo-deny", "--version", VERSION]);
        command.arg("--root").arg(&folder).arg("--target-dir").arg(&built);
        shell.run(command)?;
        std::fs::remove_dir_all(&built).map_err(Failure::file(&built))?;
    }
    let mut command = shell.command(program);
    command.args(["--all-features", "--locked"]).args(arguments);
    shell.run(command)
}

/// Formatting, lints and tests of some crates, with the features that these ask for.
pub(super) fn quick(shell: &Shell, folders: &[String]) -> Result<(), Failure> {
    if folders.is_empty() {
        return Err(Failure::Wrong(
            "which crates? ./test quick takes their folders, such as sim or wire; ./test alone tests all"
                .to_owned(),
        ));
    }
    let mut packages = Vec::new();
    for folder in folders {
        let Some((manifest, text)) = manifest_of(&shell.place.root, folder) else {
            return Err(Failure::Wrong(format!(
                "there is no crate in {folder}: ./test quick takes crates by their folders, such as sim or wire"
            )));
        };
        let manifest: toml::Table =
            toml::from_str(&text).map_err(|error| records::Error::Text { path: manifest, error })?;
        let name =
            manifest.get("package").and_then(|package| package.get("name")).and_then(toml::Value::as_str);
        packages.extend(["-p", name.unwrap_or_default()].map(str::to_owned));
    }
    let mut formatting = shell.command("cargo");
    formatting.arg("fmt").args(&packages).arg("--check");
    shell.run(formatting)?;
    let packages = || packages.iter().map(String::as_str);
    shell
        .run(shell.cargo(
            ["clippy", "--all-targets"].into_iter().chain(packages()).chain(["--", "-D", "warnings"]),
        ))?;
    shell.run(shell.cargo(["test", "--quiet"].into_iter().chain(packages())))
}

/// The manifest of the crate in a folder, with its text. The crates in `crates/` and `viewer/` need no more than their own name.
fn manifest_of(root: &Path, folder: &str) -> Option<(PathBuf, String)> {
    ["", "crates", "viewer"].into_iter().find_map(|around| {
        let path = root.join(around).join(folder).join("Cargo.toml");
        let text = std::fs::read_to_string(&path).ok()?;
        Some((path, text))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_crate_goes_by_the_name_of_its_folder() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let is_crate = |folder: &Path| folder.join("Cargo.toml").is_file();
        let mut found = 0;
        for around in ["", "crates", "viewer"].map(|around| root.join(around)) {
            let folders = std::fs::read_dir(around).unwrap().map(|entry| entry.unwrap().path());
            for folder in folders.filter(|folder| is_crate(folder)) {
                let name = folder.file_name().unwrap().to_str().unwrap();
                let (manifest, _) = manifest_of(&root, name).unwrap_or_else(|| panic!("{name}"));
                assert_eq!(manifest, folder.join("Cargo.toml"), "two crates are in folders of this name");
                found += 1;
            }
        }
        assert!(found > 20, "{found}");
        assert_eq!(manifest_of(&root, "docs"), None);
    }
}
