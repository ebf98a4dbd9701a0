//! Sections of programs on a robot's chip, and of programs of others at serial ports.

use std::path::PathBuf;

use super::parts::{environment, json_word, script};
use super::rust::{built, of_all};
use crate::shell::{Failure, Shell};

/// Programs for real robots, from their registries.
fn python_of_ports(shell: &Shell) -> Result<PathBuf, Failure> {
    environment(
        shell,
        &shell.place.root.join("tests/ports/.venv"),
        &["tests/ports/requirements.txt"],
        &["-r", "tests/ports/requirements.txt"],
    )
}

pub(super) fn ports(shell: &Shell) -> Result<(), Failure> {
    let python = python_of_ports(shell)?;
    let program = built(shell)?;
    shell.run(script(shell, &python, &["tests/ports/try.py", &program.to_string_lossy()]))
}

/// The part of them that needs an idle machine.
pub(super) fn ports_in_time(shell: &Shell) -> Result<(), Failure> {
    let python = python_of_ports(shell)?;
    shell.run(shell.cargo(["build", "--release"]))?;
    let program = shell.place.target.join("release/baudbot");
    let program = program.to_string_lossy();
    shell.run(script(shell, &python, &["tests/ports/idle.py", &program]))?;
    shell.run(script(shell, &python, &["tests/ports/adapter.py", &program]))
}

/// A million random states, over all instructions.
pub(super) fn microcontroller(shell: &Shell) -> Result<(), Failure> {
    let mut command = of_all(shell, ["--quiet", "--test", "outside", "--", "--ignored", "simavr"]);
    command.env("BAUDBOT_AVR_STATES", "13500");
    shell.run(command)
}

/// Programs of others at both ends of a cable, in simulated time.
pub(super) fn simulated_programs(shell: &Shell) -> Result<(), Failure> {
    let python = python_of_ports(shell)?;
    let program = built(shell)?;
    let sketches = sketches(shell)?;
    let words = [program.to_string_lossy(), sketches.to_string_lossy()];
    shell.run(script(shell, &python, &["tests/ports/simulated/try.py", &words[0], &words[1]]))
}

/// The folder of the sketches, which are built once.
fn sketches(shell: &Shell) -> Result<PathBuf, Failure> {
    let sketches = shell.place.target.join("sketches");
    let words = ["tests/firmware/build.py", &sketches.to_string_lossy()];
    shell.run(script(shell, "python3".as_ref(), &words))?;
    Ok(sketches)
}

/// Sketches by Debian's compiler and Arduino's core, firmware of others, projects of `baudbot new firmware`, and programs of
/// others at both ends of the cable.
pub(super) fn firmware(shell: &Shell) -> Result<(), Failure> {
    let python = python_of_ports(shell)?;
    let program = built(shell)?;
    let sketches = sketches(shell)?;
    let mut command = of_all(shell, ["--quiet", "--test", "outside", "--", "--ignored", "sketches"]);
    command.env("BAUDBOT_SKETCHES", &sketches);
    shell.run(command)?;
    new_firmware(shell)?;
    exported_brain(shell)?;
    for seed in ["1", "2"] {
        drives(shell, &["catalogue/scenarios/firmware.toml", "--seconds", "600", "--seed", seed], 30.0)?;
    }
    shell.run(script(
        shell,
        &python,
        &["tests/ports/firmware.py", &program.to_string_lossy(), &sketches.to_string_lossy()],
    ))
}

/// Projects that `baudbot new firmware` makes.
fn new_firmware(shell: &Shell) -> Result<(), Failure> {
    let program = shell.place.program();
    let folder = shell.place.scratch("firmware").map_err(Failure::file(&shell.place.target))?;
    for language in ["arduino", "c"] {
        let project = folder.join(language);
        let mut new = shell.command(&program);
        new.args(["new", "firmware"]).arg(&project).args(["--lang", language]);
        shell.run(new)?;
        let mut make = shell.command("make");
        make.args(["--silent", "-C"]).arg(&project).arg(format!("BAUDBOT={}", program.display()));
        shell.run(make)?;
        drives(shell, &[&project.join("robot.toml").to_string_lossy(), "--seconds", "60"], 5.0)?;
    }
    Ok(())
}

/// A brain that is exported drives in the chip as far as it does at the cable.
fn exported_brain(shell: &Shell) -> Result<(), Failure> {
    const SCENARIO: &str = "catalogue/scenarios/shield.toml";
    let folder = shell.place.scratch("exported").map_err(Failure::file(&shell.place.target))?;
    let (brain, elf) = (folder.join("brain.c"), folder.join("shield.elf"));
    let mut export = shell.command(shell.place.program());
    export.args(["export-brain", "avoid", "--lang", "c", "--scenario", SCENARIO, "--out"]).arg(&brain);
    shell.run(export)?;
    let mut compile = shell.command("avr-gcc");
    compile.args(["-mmcu=atmega328p", "-std=c99", "-Os", "-Wall", "-Wextra", "-Werror", "-I"]).arg(&folder);
    compile.arg("-o").arg(&elf).args(["catalogue/scenarios/firmware/shield.c", "-lm"]);
    shell.run(compile)?;
    // Ten minutes take a minute and a half of a processor in the chip: tried by hand, they were 1 and 3 % apart.
    let minutes = ["--seconds", "120"];
    let firmware = format!("robot={}", elf.display());
    let at_the_cable_m = drives(shell, &[&[SCENARIO, "--brain", "avoid"], &minutes[..]].concat(), 10.0)?;
    let in_the_chip_m = drives(shell, &[&[SCENARIO, "--firmware", &firmware], &minutes[..]].concat(), 10.0)?;
    if (in_the_chip_m / at_the_cable_m - 1.0).abs() > MOST_APART {
        let problem = format!(
            "an exported brain drives {in_the_chip_m} m in the chip, and {at_the_cable_m} m at the cable"
        );
        return Err(Failure::Wrong(problem));
    }
    Ok(())
}

/// Ways of two minutes with other random noise are no farther apart, as a fraction; of two seeds one was, by 0.09.
const MOST_APART: f64 = 0.15;

/// A robot drives farther than so many metres, without a collision and without a warning about its chip, if it has one; the way, in metres.
fn drives(shell: &Shell, arguments: &[&str], least_m: f64) -> Result<f64, Failure> {
    let mut run = shell.command(shell.place.program());
    run.arg("run").args(arguments).arg("--json");
    let json = shell.text(run)?;
    let number = |key| json_word(&json, key).and_then(|word| word.trim().parse::<f64>().ok());
    let (distance_m, collisions) = (number("distance_m"), number("collisions"));
    let is_warned = json.contains("\"warnings\"") && !json.contains("\"warnings\": []");
    let far_m = distance_m.filter(|far_m| *far_m > least_m && collisions == Some(0.0) && !is_warned);
    let Some(far_m) = far_m else {
        return Err(Failure::Wrong(format!(
            "run {}: it should drive more than {least_m} m, without collisions and warnings:\n{json}",
            arguments.join(" ")
        )));
    };
    shell.say(&format!("run {}: driven {far_m} m", arguments.join(" ")));
    Ok(far_m)
}

/// A program on a robot's microcontroller under the real avr-gdb.
pub(super) fn debugging(shell: &Shell) -> Result<(), Failure> {
    let program = built(shell)?;
    shell.run(script(shell, "python3".as_ref(), &["tests/firmware/gdb.py", &program.to_string_lossy()]))
}
