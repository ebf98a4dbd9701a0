//! Release checks that need no other home.

use super::rust::of_all;
use crate::shell::{Failure, Shell};

/// Optimisation could change numbers, and the order of simultaneous events.
pub(super) fn optimised(shell: &Shell) -> Result<(), Failure> {
    let packages = [
        "baudbot-geometry",
        "baudbot-wire",
        "baudbot-avr",
        "baudbot-sim",
        "baudbot-scenario",
        "baudbot-tests",
    ];
    let packages = packages.iter().flat_map(|package| ["-p", package]);
    shell.run(shell.cargo(
        ["test", "--quiet", "--release", "--no-fail-fast", "--lib", "--tests"].into_iter().chain(packages),
    ))
}

pub(super) fn aarch64(shell: &Shell) -> Result<(), Failure> {
    let words = [
        "test",
        "--quiet",
        "--release",
        "--target",
        "aarch64-unknown-linux-gnu",
        "-p",
        "baudbot-tests",
        "-p",
        "baudbot-geometry",
        "-p",
        "baudbot-wire",
        "-p",
        "baudbot-sim",
        "--lib",
        "--test",
        "golden_hashes",
    ];
    let mut command = shell.cargo(words);
    command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc");
    command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", "qemu-aarch64 -L /usr/aarch64-linux-gnu");
    shell.run(command)
}

/// The answers before a kill are held against the state after it.
pub(super) fn kills(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    let mut command =
        of_all(shell, ["--quiet", "--test", "cli", "--", "--ignored", "--nocapture", "many_kills"]);
    command.env("BAUDBOT_KILLS", number(arguments.first(), "50")?);
    shell.run(command)
}

fn number<'a>(argument: Option<&'a String>, usual: &'a str) -> Result<&'a str, Failure> {
    let text = argument.map_or(usual, String::as_str);
    text.parse::<u64>().map(|_| text).map_err(|_| Failure::Wrong(format!("`{text}` is no number")))
}

/// A network that breaks in all ways, of so many seeds, or of one.
pub(super) fn network(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    seeds(shell, arguments, ("network", "NETWORK", "2000"), "in_any_way")
}

/// A network, a disk and a clock that break in all ways, and servers that are killed, of so many seeds, or of one.
pub(super) fn faults(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    seeds(shell, arguments, ("faults", "FAULT", "10000"), "what_operators_were_told")
}

/// The test of the simulated network that has this in its name, with so many seeds, or one.
fn seeds(
    shell: &Shell,
    arguments: &[String],
    (section, variable, usual): (&str, &str, &str),
    test: &str,
) -> Result<(), Failure> {
    let (end, value) = match arguments {
        [] | [_] => ("SEEDS", number(arguments.first(), usual)?),
        [option, seed] if option == "--seed" => ("SEED", number(Some(seed), "0")?),
        [_, ..] => return Err(Failure::Wrong(format!("./test {section} [SEEDS | --seed SEED]"))),
    };
    let mut command = of_all(shell, ["--quiet", "--test", "network", "--", "--nocapture", test]);
    command.env(format!("BAUDBOT_{variable}_{end}"), value);
    shell.run(command)
}

/// Altered bytes for all that reads bytes from outside: so many inputs of each, so long, or as many as are wanted.
pub(super) fn fuzz(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    match arguments {
        [] => script(shell, "xtask/tools/fuzz", &["--executions".to_owned(), "20000".to_owned()]),
        [wanted] if wanted == "wanted" => {
            script(shell, "xtask/tools/fuzz", &["--wanted".to_owned()])?;
            script(shell, "xtask/tools/fuzz", &["--coverage".to_owned(), "60".to_owned()])
        }
        [seconds] => script(shell, "xtask/tools/fuzz", std::slice::from_ref(seconds)),
        [_, ..] => {
            Err(Failure::Wrong("./test fuzz [SECONDS | wanted]; xtask/tools/fuzz has more".to_owned()))
        }
    }
}

/// A server under all kinds of load, for ten minutes or some hours.
pub(super) fn soak(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    let hours = arguments.first().map_or(Ok(1.0 / 6.0), |hours| hours.parse::<f64>());
    let hours = hours
        .map_err(|_| Failure::Wrong(format!("./test soak [HOURS]: {} is no number", arguments.join(" "))))?;
    shell.run(shell.cargo(["build", "--release", "-p", "baudbot"]))?;
    let mut command = shell.cargo(["run", "--release", "-p", "baudbot-tests", "--example", "soak", "--"]);
    command.arg(shell.place.target.join("release/baudbot")).arg((hours * 60.0).to_string());
    shell.run(command)
}

/// A script of the project.
pub(super) fn script(shell: &Shell, file: &str, arguments: &[String]) -> Result<(), Failure> {
    let mut command = shell.command(file);
    // They have their folders below the root's own target.
    command.args(arguments).env_remove("CARGO_TARGET_DIR");
    shell.run(command)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;
    use std::process::Command;

    fn words(text: &str) -> impl Iterator<Item = &str> {
        let is_name = |word: &&str| {
            word.strip_prefix("baudbot-").is_some_and(|rest| {
                !rest.is_empty() && rest.bytes().all(|c| c == b'-' || c.is_ascii_lowercase())
            })
        };
        text.split('"').filter(is_name)
    }

    /// A release check that names a package which is merged into another fails months later.
    #[test]
    fn each_package_that_a_section_names_is_one_of_the_workspace() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let cargo = Command::new("cargo")
            .args(["metadata", "--locked", "--offline", "--no-deps", "--format-version", "1"])
            .current_dir(&root)
            .output()
            .unwrap();
        let metadata = String::from_utf8(cargo.stdout).unwrap();
        let known: BTreeSet<_> = words(&metadata).collect();
        assert!(known.contains("baudbot-sim"), "{known:?}");
        let files = std::fs::read_dir(root.join("xtask/src/sections")).unwrap();
        let texts: Vec<_> =
            files.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
        let named: BTreeSet<_> = texts.iter().flat_map(|text| words(text)).collect();
        assert!(named.contains("baudbot-tests"), "{named:?}");
        let unknown: Vec<_> = named.difference(&known).collect();
        assert!(unknown.is_empty(), "no package of the workspace: {unknown:?}");
    }
}
