//! Lists the scenarios, experiments and exercises of this repository, so that an installed program has them all.
//!
//! Experiments that start a program are left out, as it would have to be installed, too; they work from a copy of the repository. The page,
//! which is built for wasm32 and has neither experiments nor exercises, has none of their texts.
//!
//! The result is `embedded.rs` in the build's folder: four lists of names and contents. A scenario is called by its path below
//! `catalogue/scenarios/` without `.toml`, an experiment by its path below `catalogue/experiments/`, an exercise by its name in `catalogue/exercises/`, a program of a microcontroller by its path below `catalogue/scenarios/`.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let root = root.ancestors().nth(2).ok_or("the crate is not in a workspace")?.join("catalogue");
    let (mut scenarios, mut experiments, mut programs) = (Vec::new(), Vec::new(), Vec::new());
    let (exercises, mut exercise_files) = (root.join("exercises"), Vec::new());
    collect(&root.join("scenarios"), "toml", &mut scenarios)?;
    collect(&root.join("experiments"), "toml", &mut experiments)?;
    // An installed program has none of this repository's programs beside it.
    let mut own = Vec::new();
    for path in experiments {
        if !starts_program(&fs::read_to_string(&path)?) {
            own.push(path);
        }
    }
    collect(&exercises, "toml", &mut exercise_files)?;
    // Folders below have brains.
    exercise_files.retain(|path| path.parent() == Some(&exercises));
    collect(&root.join("scenarios"), "hex", &mut programs)?;
    if env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|arch| arch == "wasm32") {
        (own, exercise_files) = (Vec::new(), Vec::new());
    }
    let mut code = String::new();
    list(&mut code, "SCENARIOS", "str", &root.join("scenarios"), &scenarios, ".toml")?;
    list(&mut code, "EXPERIMENTS", "str", &root.join("experiments"), &own, ".toml")?;
    list(&mut code, "EXERCISES", "str", &exercises, &exercise_files, ".toml")?;
    list(&mut code, "PROGRAMS", "[u8]", &root.join("scenarios"), &programs, "")?;
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("embedded.rs"), code)?;
    Ok(())
}

/// Whether the brain of an experiment is a program of its own.
fn starts_program(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("exec = ") || (!line.starts_with('#') && line.contains("exec:")))
}

/// The files below a folder whose names have this extension, in the order of their paths.
fn collect(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={}", folder.display());
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, extension, found)?;
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found.sort();
    Ok(())
}

fn list(
    code: &mut String,
    name: &str,
    kind: &str,
    folder: &Path,
    paths: &[PathBuf],
    without: &str,
) -> Result<(), Box<dyn Error>> {
    let include = if kind == "str" { "include_str" } else { "include_bytes" };
    writeln!(code, "pub(crate) const {name}: &[(&str, &{kind})] = &[")?;
    for path in paths {
        let called = path.strip_prefix(folder)?.to_str().ok_or("a path is no text")?;
        let called = called.strip_suffix(without).unwrap_or(called);
        writeln!(code, "    ({called:?}, {include}!({path:?})),")?;
    }
    writeln!(code, "];")?;
    Ok(())
}
