//! Sections that run Python: the client, the package with worlds, checks by readers of others, the manual.

use super::parts::{environment, path_with, python, script};
use super::rust::{built, of_all};
use crate::shell::{Failure, Shell};

/// The tests of the client beside a real server.
pub(super) fn client(shell: &Shell) -> Result<(), Failure> {
    let wanted = ["client/python/pyproject.toml", "client/python/requirements.txt"];
    let python = environment(
        shell,
        &shell.place.target.join("client-python"),
        &wanted,
        &["-r", "client/python/requirements.txt", "-e", "client/python"],
    )?;
    let program = built(shell)?;
    let mut command =
        script(shell, &python, &["-m", "unittest", "discover", "--start-directory", "client/python/tests"]);
    command.env("BAUDBOT", program);
    shell.run(command)?;
    shell.run(of_all(shell, ["--quiet", "--lib", "--", "--ignored", "a_client_in_python_finds_the_same"]))
}

/// Robustness of requirements, by a library of temporal logic, and response times in budgets, by one of schedules.
pub(super) fn requirements(shell: &Shell) -> Result<(), Failure> {
    let wanted = ["tests/require/requirements.txt", "tests/budget/requirements.txt"];
    let folder = shell.place.target.join("require-python");
    let python = environment(shell, &folder, &wanted, &["-r", wanted[0], "-r", wanted[1]])?;
    // As `built` has it, so that nothing is built twice.
    let words =
        ["build", "--quiet", "--workspace", "--all-features", "--bin", "baudbot", "--example", "soak"];
    shell.run(shell.cargo(words.into_iter().chain(["--example", "robustness"])))?;
    let program = shell.place.program();
    let example = program.with_file_name("examples/robustness");
    shell.run(script(shell, &python, &["tests/require/referee.py", &example.to_string_lossy()]))?;
    shell.run(script(shell, &python, &["tests/budget/referee.py", &program.to_string_lossy()]))
}

/// The client's stubs, types and examples.
pub(super) fn brains(shell: &Shell) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    let mut generate = shell.command("client/python/generate");
    generate.arg("--check");
    shell.run(generate)?;
    shell.run(script(shell, &python, &["crates/wire/frames.py"]))?;
    let mut types = script(shell, &python, &["-m", "mypy"]);
    types.current_dir(shell.place.root.join("client/python"));
    shell.run(types)?;
    // The wall follower is drawn as in docs/reference/brains.md.
    let mut diagram = shell.command(&program);
    let brain = "exec:python client/python/examples/follow.py";
    diagram.args([
        "diagram",
        "wander",
        "--brain",
        brain,
        "--set",
        "robots.robot.link.baud=38400",
        "--cycle",
        "5",
        "--svg",
        "-",
    ]);
    diagram.env("PATH", path_with(&shell.place.root.join(".venv/bin")));
    let drawn = shell.text(diagram)?;
    let picture = shell.place.root.join("docs/pictures/follow-cycle.svg");
    if drawn != std::fs::read_to_string(&picture).map_err(Failure::file(&picture))? {
        return Err(Failure::Wrong(
            "the wall follower in Python is not drawn as in docs/pictures/follow-cycle.svg".to_owned(),
        ));
    }
    // That the package and a bare stream end with the same bits; how long they take is for a quiet machine.
    let mut turn = script(shell, &python, &["crates/bench/python/turn.py", "--pairs", "1", "--seconds", "2"]);
    turn.env("BAUDBOT", program);
    shell.run(turn)
}

/// The package with worlds in it, with the native part and the program that the tests were built with. `wheel` builds it as
/// people install it.
pub(super) fn worlds(shell: &Shell) -> Result<(), Failure> {
    let python = worlds_installed(shell)?;
    let folder = shell.place.target.join("python");
    let bin = folder.join("bin");
    // Not from the root: the folder client/python has a part of the package only.
    let outside = |words: &[&str]| {
        let mut command = script(shell, &python, words);
        command.current_dir("/");
        command
    };
    let package = shell.text(outside(&["-c", "import baudbot; print(baudbot.__path__[0], end='')"]))?;
    let (cache, configuration) = (folder.join("mypy"), shell.place.root.join("python/pyproject.toml"));
    let (cache, configuration) = (cache.to_string_lossy(), configuration.to_string_lossy());
    shell.run(outside(&[
        "-m",
        "mypy",
        "--cache-dir",
        &cache,
        "--config-file",
        &configuration,
        "-p",
        "baudbot",
    ]))?;
    let native = format!("{package}/_native.abi3.so");
    shell.run(script(
        shell,
        &python,
        &["-m", "abi3audit", "--strict", "--assume-minimum-abi3", "3.10", &native],
    ))?;
    let mut tests = script(shell, &python, &["-m", "unittest"]);
    tests.current_dir(shell.place.root.join("python/tests")).env("PATH", path_with(&bin));
    shell.run(tests)?;
    let mut notebooks = script(shell, &python, &["python/tests/run_notebooks.py"]);
    notebooks.env("PATH", path_with(&bin));
    shell.run(notebooks)?;
    // That it runs; how fast is for a quiet machine.
    shell.run(script(shell, &python, &["crates/bench/python/vector.py", "--seconds", "0.2"]))
}

/// The packages that build ours and that its checks need; it brings its own dependencies itself.
const WORLDS: [&str; 5] =
    ["-r", "python/requirements.txt", "maturin>=1.16,<2", "hatchling>=1.27", "wheel>=0.45"];

/// Its interpreter, in an environment of its own.
fn worlds_installed(shell: &Shell) -> Result<std::path::PathBuf, Failure> {
    built(shell)?;
    let words = ["build", "--quiet", "--workspace", "--all-features", "--lib", "--example", "soak"];
    shell.run(shell.cargo(words))?;
    let wanted = ["python/requirements.txt", "python/pyproject.toml", "client/python/pyproject.toml"];
    let python = environment(shell, &shell.place.target.join("python"), &wanted, &WORLDS)?;
    // The versions stay the same, so that pip must be told when something in them has changed.
    let again = ["--force-reinstall", "--no-deps", "./client/python", "./python"];
    for words in [&["./client/python", "./python[all]"][..], &again] {
        let mut pip = shell.command(&python);
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-build-isolation"])
            .args(words);
        pip.env("BAUDBOT_BUILT", shell.place.target.join("debug"))
            .env("PATH", path_with(&shell.place.target.join("python/bin")));
        shell.run(pip)?;
    }
    Ok(python)
}

/// The wheels of a release; and the package as README has people install it from a clone.
pub(super) fn wheel(shell: &Shell) -> Result<(), Failure> {
    super::release::script(shell, "python/build-wheel", &[])?;
    noticed(shell)?;
    let folder = shell.place.scratch("wheel").map_err(Failure::file(&shell.place.target))?;
    let python = environment(shell, &folder, &["python/pyproject.toml"], &["./python[all]"])?;
    let mut import = shell.command(python);
    import
        .args(["-c", "import baudbot, gymnasium; gymnasium.make('baudbot/Wander-v0').reset(seed=1)"])
        .current_dir("/");
    shell.run(import)?;
    let mut program = shell.command(folder.join("bin/baudbot"));
    program.arg("--version");
    shell.run(program)
}

/// The notices of others' work are in the wheel, as they are collected now.
fn noticed(shell: &Shell) -> Result<(), Failure> {
    let words = "import glob, sys, zipfile\n\
        wheel = zipfile.ZipFile(glob.glob('target/wheels/baudbot-*.whl')[0])\n\
        names = [name for name in wheel.namelist() if name.endswith('/share/doc/baudbot/THIRD-PARTY-NOTICES.txt')]\n\
        now = open('target/notices/THIRD-PARTY-NOTICES.txt', 'rb').read()\n\
        sys.exit(None if [wheel.read(name) for name in names] == [now] else f'the wheel has other notices: {names}')";
    let mut command = shell.command("python3");
    command.args(["-c", words]);
    shell.run(command)
}

/// Sweeps on a cluster. Ray is large, and a cluster takes a while to come up.
pub(super) fn cluster(shell: &Shell) -> Result<(), Failure> {
    let python = worlds_installed(shell)?;
    shell.run(script(
        shell,
        &python,
        &["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "ray==2.60.0"],
    ))?;
    let mut types = script(shell, &python, &["-m", "mypy", "--cache-dir"]);
    types.arg(shell.place.target.join("python/mypy")).args([
        "--config-file",
        "python/pyproject.toml",
        "-m",
        "baudbot.ray",
    ]);
    shell.run(types)?;
    let mut nodes = script(shell, &python, &["python/tests/cluster/nodes.py"]);
    nodes.env("PATH", path_with(&shell.place.target.join("python/bin")));
    shell.run(nodes)
}

/// Policies that learn to wander at fast and slow cables.
pub(super) fn learn(shell: &Shell) -> Result<(), Failure> {
    let python = worlds_installed(shell)?;
    let mut command = script(shell, &python, &["python/examples/ages.py", "--out"]);
    command.arg(shell.place.target.join("learn"));
    command.env("PATH", path_with(&shell.place.target.join("python/bin"))).env("OMP_NUM_THREADS", "1");
    shell.run(command)
}

/// The solution of each exercise passes, each typical mistake gets its word; and the script of the templates for continuous
/// integration works.
pub(super) fn exercises(shell: &Shell) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    let program = program.to_string_lossy();
    shell.run(script(shell, &python, &["catalogue/exercises/check.py", &program]))?;
    let folder = shell.place.scratch("grade").map_err(Failure::file(&shell.place.target))?;
    let root = &shell.place.root;
    let copies = [("examples/ci/grade.sh", "grade.sh"), ("catalogue/exercises/mistakes/stop.py", "stop.py")];
    for (from, to) in copies {
        std::fs::copy(root.join(from), folder.join(to)).map_err(Failure::file(&root.join(from)))?;
    }
    let mut command = shell.command("sh");
    command.arg("grade.sh").current_dir(&folder);
    command
        .env("BAUDBOT", &*program)
        .env("EXERCISE", "stop")
        .env("BRAIN", format!("exec:{} stop.py", python.display()));
    let status = shell.status(command)?;
    if status.code() != Some(3) {
        return Err(Failure::Wrong(format!("grade.sh ended with {status}, not with 3")));
    }
    contains(&folder.join("result.xml"), "<failure")?;
    contains(&folder.join("result.json"), "\"verdict\": \"failed\"")?;
    contains(&root.join("examples/ci/github.yml"), "sh grade.sh")?;
    contains(&root.join("examples/ci/gitlab.yml"), "sh grade.sh")
}

fn contains(path: &std::path::Path, words: &str) -> Result<(), Failure> {
    let text = std::fs::read_to_string(path).map_err(Failure::file(path))?;
    if text.contains(words) {
        Ok(())
    } else {
        Err(Failure::Wrong(format!("{} does not have `{words}`", path.display())))
    }
}

/// Traces of a test and of runs, read with the schema of those who read such traces.
pub(super) fn traces(shell: &Shell) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    let folder = shell.place.scratch("traces").map_err(Failure::file(&shell.place.target))?;
    let trace = folder.join("run.pftrace");
    let made_up = shell.place.target.join("tmp/made-up.pftrace");
    shell.run(of_all(shell, ["--quiet", "--test", "made_up"]))?;
    shell.run(script(shell, &python, &["xtask/tools/check_trace.py", &made_up.to_string_lossy()]))?;
    for arguments in [
        &["khepera", "--brain", "none"][..],
        &["catalogue/scenarios/devices/laser.toml", "--brain", "none"],
        &[],
    ] {
        let mut run = shell.command(&program);
        run.arg("run").args(arguments).args(["--seconds", "5", "--quiet", "--timeline"]).arg(&trace);
        shell.run(run)?;
        shell.run(script(shell, &python, &["xtask/tools/check_trace.py", &trace.to_string_lossy()]))?;
    }
    Ok(())
}

/// Recordings of runs, read with the readers and the schemas of others.
pub(super) fn recordings(shell: &Shell) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    let folder = shell.place.scratch("recordings").map_err(Failure::file(&shell.place.target))?;
    let runs: [(&str, &[&str], &[&str]); 2] = [
        ("run.mcap", &[], &[]),
        ("laser.mcap", &["catalogue/scenarios/devices/laser.toml", "--brain", "wander"], &["urg"]),
    ];
    for (name, arguments, sensors) in runs {
        let file = folder.join(name);
        let mut run = shell.command(&program);
        run.arg("run").args(arguments).args(["--seconds", "5", "--quiet", "--record"]).arg(&file);
        shell.run(run)?;
        let mut check = script(shell, &python, &["xtask/tools/check_recording.py", &file.to_string_lossy()]);
        check.args(sensors);
        shell.run(check)?;
    }
    shell.run(script(shell, &python, &["xtask/tools/check_rosbag.py", &program.to_string_lossy()]))
}

/// A sweep in shards, as a cluster does it: the manifest by Kubernetes' own schemas, and its commands on this machine.
pub(super) fn shards(shell: &Shell) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    shell.run(script(shell, &python, &["xtask/tools/check_kubernetes.py", &program.to_string_lossy()]))
}

/// The manual is a site without broken links.
pub(super) fn manual(shell: &Shell) -> Result<(), Failure> {
    shell.run(shell.command("xtask/tools/docs"))
}

/// Tutorials and how-tos do what they say, and the pages that are made of the program's help, of the contract and of marks in the
/// code are up to date.
/// The reader of some has the package with worlds in it.
pub(super) fn manual_commands(shell: &Shell) -> Result<(), Failure> {
    let tools = ["-m", "unittest", "discover", "--start-directory", "xtask/tools"];
    shell.run(script(shell, "python3".as_ref(), &tools))?;
    with_program(shell, "python3".as_ref(), &["xtask/tools/reference.py", "--check"])?;
    let python = worlds_installed(shell)?;
    with_program(shell, &python, &["xtask/tools/doc_commands.py"])
}

/// The gallery's pictures are what its commands make.
pub(super) fn gallery(shell: &Shell) -> Result<(), Failure> {
    with_program(shell, "python3".as_ref(), &["xtask/tools/gallery.py", "--check"])
}

fn with_program(shell: &Shell, python: &std::path::Path, words: &[&str]) -> Result<(), Failure> {
    let program = built(shell)?;
    let mut command = script(shell, python, words);
    command.env("BAUDBOT", program);
    shell.run(command)
}
