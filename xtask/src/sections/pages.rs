//! Sections of the pages, and of what Node checks.

use std::path::PathBuf;
use std::process::Command;

use super::parts::{json_word, python, script};
use super::rust::built;
use crate::shell::{Failure, Shell};

fn buf(shell: &Shell, words: &[&str]) -> Result<(), Failure> {
    let mut command = shell.command("xtask/tools/node_modules/.bin/buf");
    command.args(words);
    shell.run(command)?;
    shell.say(&format!("buf {}: nothing to say", words[0]));
    Ok(())
}

/// The contract only grows: programs that were built with the last one go on. A release renews the file (docs/architecture/releases.md).
pub(super) fn contract(shell: &Shell) -> Result<(), Failure> {
    buf(shell, &["lint", "proto"])?;
    buf(shell, &["breaking", "proto", "--against", "proto/released.binpb"])
}

pub(super) fn editors(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    shell.run(script(shell, "python3".as_ref(), &["xtask/tools/check_schema.py", &program.to_string_lossy()]))
}

fn npm(shell: &Shell, name: &str, words: &[&str]) -> Command {
    let mut command = shell.command("npm");
    command.args(["run", "--silent", "--prefix", "viewer", name]);
    if !words.is_empty() {
        command.arg("--").args(words);
    }
    command
}

/// The page is rebuilt, and must equal the committed one, which the program contains.
pub(super) fn viewer(shell: &Shell) -> Result<(), Failure> {
    let new = shell.place.scratch("viewer").map_err(Failure::file(&shell.place.target))?;
    shell.run(npm(
        shell,
        "build",
        &["--outDir", &new.to_string_lossy(), "--emptyOutDir", "--logLevel", "warn"],
    ))?;
    let mut diff = shell.command("diff");
    diff.args(["-r", "viewer/dist"]).arg(&new);
    if !shell.status(diff)?.success() {
        return Err(Failure::Wrong(
            "viewer/dist is not what viewer/src makes: run npm run --prefix viewer build, and commit it"
                .to_owned(),
        ));
    }
    shell.run(npm(shell, "check", &[]))?;
    shell.run(npm(shell, "test", &[]))
}

pub(super) fn viewer_in_a_browser(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let chromium = found(shell, "chromium")?;
    let mut browser = npm(shell, "test:browser", &[]);
    browser.env("CHROMIUM", &chromium);
    shell.run(browser)?;
    let mut server = npm(shell, "test:server", &[]);
    server.env("CHROMIUM", chromium).env("BAUDBOT", program);
    shell.run(server)
}

fn found(shell: &Shell, program: &str) -> Result<String, Failure> {
    let mut command = shell.command("sh");
    command.args(["-c", &format!("command -v {program}")]);
    Ok(shell.text(command)?.trim().to_owned())
}

/// The page in a browser beside the program.
pub(super) fn page(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let page = build_page(shell)?;
    let python = python(shell)?;
    let mut follow = shell.command(&program);
    let brain = format!("exec:{} client/python/examples/follow.py", python.display());
    follow.args(["run", "wander", "--seconds", "60", "--json", "--quiet", "--brain", &brain]);
    let printed = shell.text(follow)?;
    let hash = json_word(&printed, "state_hash")
        .ok_or_else(|| Failure::Wrong(format!("a run has no state hash:\n{printed}")))?;
    let mut test = npm(shell, "test:page", &[]);
    test.env("CHROMIUM", found(shell, "chromium")?)
        .env("BAUDBOT", program)
        .env("PAGE", page)
        .env("FOLLOW_HASH", hash);
    shell.run(test)
}

fn build_page(shell: &Shell) -> Result<PathBuf, Failure> {
    let page = shell.place.target.join("page");
    let mut command = shell.command("viewer/build-page");
    command.arg(&page);
    shell.run(command)?;
    Ok(page)
}

/// Both pages, the one without a server and that of a server, in another browser.
pub(super) fn firefox(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let page = build_page(shell)?;
    let mut command = npm(shell, "test:firefox", &[]);
    command.env("FIREFOX", found(shell, "firefox-esr")?).env("BAUDBOT", program).env("PAGE", page);
    shell.run(command)
}
