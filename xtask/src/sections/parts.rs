//! The shared parts of several sections: environments of Python, servers.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::shell::{Failure, Running, Shell};

/// An environment of Python below the root with these packages, made or renewed if a file that names them has changed; its
/// interpreter.
///
/// # Errors
///
/// [`Failure::Missing`] if the packages cannot be had.
pub(super) fn environment(
    shell: &Shell,
    folder: &Path,
    wanted: &[&str],
    install: &[&str],
) -> Result<PathBuf, Failure> {
    let root = &shell.place.root;
    let python = folder.join("bin/python");
    let mut texts = String::new();
    for name in wanted {
        let path = root.join(name);
        texts += &std::fs::read_to_string(&path).map_err(Failure::file(&path))?;
    }
    texts += &install.join(" ");
    let note = folder.join("installed");
    if python.is_file() && std::fs::read_to_string(&note).is_ok_and(|text| text == texts) {
        return Ok(python);
    }
    let mut make = shell.command("python3");
    make.args(["-m", "venv"]).arg(folder);
    shell.run(make)?;
    let mut pip = shell.command(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "2"])
        .args(install);
    let printed = shell.printed(pip, true)?;
    shell.say(printed.text.trim_end());
    if !printed.status.success() {
        let signs =
            ["NewConnectionError", "Failed to establish", "name resolution", "ConnectTimeout", "ProxyError"];
        if signs.iter().any(|sign| printed.text.contains(sign)) {
            return Err(Failure::Missing("its packages cannot be had: there is no network".to_owned()));
        }
        return Err(Failure::Ended { program: "pip install".to_owned(), status: printed.status });
    }
    std::fs::write(&note, texts).map_err(Failure::file(&note))?;
    Ok(python)
}

/// The interpreter with `baudbot-client` as people install it, and with what the checks need.
pub(super) fn python(shell: &Shell) -> Result<PathBuf, Failure> {
    let wanted =
        ["client/python/pyproject.toml", "client/python/requirements.txt", "xtask/tools/requirements.txt"];
    let install =
        ["-r", "client/python/requirements.txt", "-r", "xtask/tools/requirements.txt", "-e", "client/python"];
    environment(shell, &shell.place.root.join(".venv"), &wanted, &install)
}

/// A command of an interpreter that leaves no compiled files behind.
pub(super) fn script(shell: &Shell, python: &Path, words: &[&str]) -> Command {
    let mut command = shell.command(python);
    command.arg("-B").args(words);
    command
}

/// `PATH` with a folder before all others.
pub(super) fn path_with(folder: &Path) -> std::ffi::OsString {
    let mut path = folder.as_os_str().to_owned();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    path
}

/// A server of the world `wander` at a Unix socket.
///
/// # Errors
///
/// It does not come up.
pub(super) fn serve(
    shell: &Shell,
    program: &Path,
    socket: &Path,
    options: &[&str],
) -> Result<Running, Failure> {
    let mut command = shell.command(program);
    command.args(["serve", "wander"]).args(options).arg("--listen").arg(format!("unix:{}", socket.display()));
    command.stdout(std::process::Stdio::null());
    let server = shell.start(command)?;
    shell.until("the server's socket", 30, || socket.exists())?;
    Ok(server)
}

/// The options of a server whose world ends after ten seconds.
pub(super) const TEN_SECONDS: [&str; 4] = ["--pace", "lockstep", "--set", "end.after_s=10.0"];

/// Whether a program says that it has driven.
///
/// # Errors
///
/// It does not say so.
pub(super) fn has_driven(said: &str) -> Result<(), Failure> {
    let turns = said
        .split("over after ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .and_then(|word| word.parse::<u64>().ok());
    match turns {
        Some(1..) => Ok(()),
        Some(0) | None => Err(Failure::Wrong(format!("the brain has not driven; it printed\n{said}"))),
    }
}

/// The text behind a key of the program's JSON, up to a comma or a quotation mark.
pub(super) fn json_word<'a>(json: &'a str, key: &str) -> Option<&'a str> {
    let rest = json.split(&format!("\"{key}\": ")).nth(1)?;
    rest.trim_start_matches('"').split([',', '"', '\n']).next()
}
