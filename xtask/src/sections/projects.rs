//! Sections of brains that are projects of their own, as users have them.

use std::path::Path;
use std::process::Command;

use super::parts::{TEN_SECONDS, has_driven, json_word, python, serve};
use super::rust::built;
use crate::shell::{Failure, Shell};

/// The folder for builds of others' projects: they share their dependencies, and nothing with this workspace.
fn target(shell: &Shell) -> std::path::PathBuf {
    shell.place.target.join("projects")
}

/// A command of cargo in a project of a user's. Nobody debugs what it builds, and without what a debugger wants it is there sooner.
fn cargo(shell: &Shell) -> Command {
    let mut cargo = shell.command("cargo");
    cargo.env("CARGO_TARGET_DIR", target(shell)).env("CARGO_PROFILE_DEV_DEBUG", "false");
    cargo
}

/// Projects that `baudbot new brain` makes are built in a place that knows nothing of this source, and drive a robot for ten
/// seconds. They share what they have built with the examples, and are not optimised, to be there sooner.
pub(super) fn new_brains(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let place = std::env::temp_dir().join(format!("baudbot-new-brains-{}", std::process::id()));
    let result = in_place(shell, &program, &place);
    std::fs::remove_dir_all(&place).map_err(Failure::file(&place))?;
    result
}

fn in_place(shell: &Shell, program: &Path, place: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(place).map_err(Failure::file(place))?;
    let (rust, python) = (place.join("weaver"), place.join("timid"));
    for (folder, language) in [(&rust, "rust"), (&python, "python")] {
        let mut new = shell.command(program);
        new.args(["new", "brain"]).arg(folder).args(["--lang", language]);
        shell.run(new)?;
    }
    let mut names = shell.command("grep");
    names.args(["-rlF"]).arg(&shell.place.root).arg(place);
    if shell.status(names)?.success() {
        return Err(Failure::Wrong(
            "the files of new projects that are listed above name the folder of the source".to_owned(),
        ));
    }
    let mut build = cargo(shell);
    build.arg("build").current_dir(&rust);
    shell.run(build)?;
    let interpreter = tested_in_python(shell, program, &python)?;
    let mut weaver = shell.command(target(shell).join("debug/weaver"));
    weaver.arg(rust.join("brain.toml")).args(["--world", "wander"]);
    drives(shell, weaver)?;
    let mut timid = shell.command(interpreter);
    timid.arg(python.join("brain.py"));
    drives(shell, timid)
}

/// The interpreter of a project in Python, whose own test has passed.
fn tested_in_python(shell: &Shell, program: &Path, python: &Path) -> Result<std::path::PathBuf, Failure> {
    let mut venv = shell.command("python3");
    venv.args(["-m", "venv"]).arg(python.join(".venv"));
    shell.run(venv)?;
    let interpreter = python.join(".venv/bin/python");
    let mut pip = shell.command(&interpreter);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-r",
        "requirements.txt",
        "pytest",
    ])
    .current_dir(python);
    shell.run(pip)?;
    let mut test = shell.command(&interpreter);
    test.args(["-m", "pytest", "--quiet"]).current_dir(python).env("BAUDBOT", program);
    shell.run(test)?;
    Ok(interpreter)
}

/// A brain drives the robot of a server for ten seconds.
fn drives(shell: &Shell, mut brain: Command) -> Result<(), Failure> {
    let folder = shell.place.scratch("drives").map_err(Failure::file(&shell.place.target))?;
    let socket = folder.join("socket");
    let server = serve(shell, &shell.place.program(), &socket, &TEN_SECONDS)?;
    brain.arg("--connect").arg(format!("unix:{}", socket.display()));
    let printed = shell.printed(brain, true)?;
    drop(server);
    shell.say(printed.text.trim_end());
    if !printed.status.success() {
        return Err(Failure::Wrong(format!("the brain ended with {}", printed.status)));
    }
    has_driven(&printed.text)
}

/// The brains in examples/, each in a project of its own. They and the one in Python drive the same path, to the last bit. The
/// versions of other crates are those of the workspace.
pub(super) fn examples(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let python = python(shell)?;
    let root = &shell.place.root;
    let lock = root.join("examples/wall-follower/Cargo.lock");
    std::fs::copy(root.join("Cargo.lock"), &lock).map_err(Failure::file(&lock))?;
    let manifest = "examples/wall-follower/Cargo.toml";
    let mut formatting = shell.command("cargo");
    formatting.args(["fmt", "--check", "--manifest-path", manifest]);
    shell.run(formatting)?;
    let mut tests = cargo(shell);
    tests.args(["test", "--quiet", "--manifest-path", manifest]);
    shell.run(tests)?;
    let follower = target(shell).join("debug/wall-follower");
    comes_back(shell, &program, &follower)?;
    let mut generate = shell.command("examples/typescript/generate");
    generate.arg("--check");
    shell.run(generate)?;
    let mut check = shell.command("npm");
    check.args(["run", "--silent", "--prefix", "examples/typescript", "check"]);
    shell.run(check)?;
    let typescript = root.join("examples/typescript");
    let brains = [
        follower.display().to_string(),
        format!("{} client/python/examples/follow.py", python.display()),
        format!("{0}/node_modules/.bin/tsx {0}/follow.ts", typescript.display()),
    ];
    let hashes: Vec<_> =
        brains.iter().map(|brain| path_of(shell, &program, brain)).collect::<Result<_, _>>()?;
    if hashes.iter().any(|hash| *hash != hashes[0]) {
        return Err(Failure::Wrong(format!("the examples do not drive the same path: {hashes:?}")));
    }
    brains.iter().try_for_each(|brain| conforms(shell, &program, brain))
}

/// A language with an example of its own, as a user makes a project of it: how it is built, tested and started.
struct Language {
    name: &'static str,
    build: &'static str,
    test: &'static str,
    start: &'static str,
}

const LANGUAGES: [Language; 5] = [
    Language { name: "cpp", build: "make -j2", test: "make test", start: "build/follow" },
    Language { name: "go", build: "make", test: "make test", start: "build/follow" },
    Language { name: "java", build: "make", test: "make test", start: "build/follow" },
    Language { name: "ruby", build: "make", test: "make test", start: "ruby follow.rb" },
    Language {
        name: "node",
        build: "npm ci --no-audit --no-fund --loglevel=error",
        test: "npm test",
        start: "node follow.mjs",
    },
];

/// The brains in other languages, each in a project that `baudbot new brain` makes: it is built, its own test drives with a server, it drives
/// the path of the example in Python to the last bit, and it keeps to the contract.
pub(super) fn languages(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    let python = python(shell)?;
    let path = path_of(shell, &program, &format!("{} client/python/examples/follow.py", python.display()))?;
    let place = shell.place.scratch("languages").map_err(Failure::file(&shell.place.target))?;
    for Language { name, build, test, start } in LANGUAGES {
        let folder = place.join(name);
        let mut new = shell.command(&program);
        new.args(["new", "brain"]).arg(&folder).args(["--lang", name]);
        shell.run(new)?;
        for line in [build, test] {
            let mut command = shell.command("sh");
            command.args(["-c", line]).current_dir(&folder).env("BAUDBOT", &program);
            shell.run(command)?;
        }
        let brain = format!("sh -c 'cd {} && exec {start}'", folder.display());
        let own = path_of(shell, &program, &brain)?;
        if own != path {
            return Err(Failure::Wrong(format!(
                "the brain in {name} drives another path, {own}, than the one in Python, {path}"
            )));
        }
        conforms(shell, &program, &brain)?;
    }
    Ok(())
}

/// A brain keeps to the contract.
fn conforms(shell: &Shell, program: &Path, brain: &str) -> Result<(), Failure> {
    let mut conform = shell.command(program);
    conform.args(["conform", &format!("exec:{brain}"), "--patience", "20"]);
    shell.run(conform)
}

/// The state hash of a run, which has no collision.
fn path_of(shell: &Shell, program: &Path, brain: &str) -> Result<String, Failure> {
    let mut run = shell.command(program);
    run.args(["run", "wander", "--seconds", "60", "--json", "--quiet", "--brain", &format!("exec:{brain}")]);
    let json = shell.text(run)?;
    match json_word(&json, "state_hash") {
        Some(hash) if json_word(&json, "collisions") == Some("0") => {
            shell.say(&format!("{hash} {brain}"));
            Ok(hash.to_owned())
        }
        Some(_) | None => {
            Err(Failure::Wrong(format!("{brain} runs into something, or has no hash:\n{json}")))
        }
    }
}

/// A program whose server dies comes back when that is started again, and drives to the end of the run.
fn comes_back(shell: &Shell, program: &Path, brain: &Path) -> Result<(), Failure> {
    let folder = shell.place.scratch("comes-back").map_err(Failure::file(&shell.place.target))?;
    let (socket, said) = (folder.join("socket"), folder.join("said"));
    let server = serve(shell, program, &socket, &["--paused"])?;
    let output = std::fs::File::create(&said).map_err(Failure::file(&said))?;
    let errors = output.try_clone().map_err(Failure::file(&said))?;
    let mut command = shell.command(brain);
    command
        .args(["--world", "wander", "--connect"])
        .arg(format!("unix:{}", socket.display()))
        .stdout(output)
        .stderr(errors);
    let running = shell.start(command)?;
    let says = |words: &str| std::fs::read_to_string(&said).is_ok_and(|text| text.contains(words));
    shell.until("the brain drives", 60, || says("driving robot"))?;
    server.kill();
    shell.until("the brain tries to reconnect", 60, || says("trying to reconnect for 600 s"))?;
    // A server that was killed leaves its socket, which says nothing of the next one.
    std::fs::remove_file(&socket).map_err(Failure::file(&socket))?;
    let _server = serve(shell, program, &socket, &TEN_SECONDS)?;
    let status = running.end(shell, 120)?;
    let text = std::fs::read_to_string(&said).map_err(Failure::file(&said))?;
    shell.say(text.trim_end());
    if !status.success()
        || !text.contains("reconnected with a restarted brain: driving robot of world wander")
    {
        return Err(Failure::Wrong(format!("the brain did not come back ({status})")));
    }
    has_driven(&text)
}
