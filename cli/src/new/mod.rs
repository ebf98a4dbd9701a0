//! `baudbot new`: small projects. A brain attaches to a robot and drives it; a firmware is a program for a robot's microcontroller.

mod firmware;
mod sources;

use std::ffi::OsStr;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::args::{Language, NewBrainArgs};
use crate::error::Refused;
use crate::text;
use anyhow::Context;
pub(crate) use firmware::firmware;

/// A file of a project: its path, its text, and whether it is a program.
type File = (String, Vec<u8>, bool);

pub(crate) fn brain(args: &NewBrainArgs) -> anyhow::Result<()> {
    let folder = &args.folder;
    check_free(folder)?;
    let name = package_name(folder)?;
    let (files, first) = match args.lang {
        Language::Rust => {
            (rust(&name, args.baudbot.as_deref())?, "cargo run --release -- brain.toml --world wander")
        }
        Language::Python => {
            (python(&name)?, ".venv/bin/python brain.py   (README.md lists what to install first)")
        }
        Language::Cpp => {
            (carried("cpp")?.collect(), "make && build/follow   (README.md lists what to install first)")
        }
        Language::Go => {
            (carried("go")?.collect(), "make && build/follow   (README.md lists what to install first)")
        }
        Language::Java => {
            (carried("java")?.collect(), "make && build/follow   (README.md lists what to install first)")
        }
        Language::Ruby => {
            (carried("ruby")?.collect(), "make && ruby follow.rb   (README.md lists what to install first)")
        }
        Language::Node => (carried("node")?.collect(), "npm ci && node follow.mjs"),
        Language::TypeScript => (carried("typescript")?.collect(), "npm ci && npx tsx follow.ts"),
    };
    write_all(folder, files)?;
    text::print(&format!(
        "{} is ready. In one terminal:\n  baudbot serve wander\nIn another, in that folder:\n  {first}\n",
        folder.display()
    ))
}

/// Refuses a folder in which there is something.
fn check_free(folder: &Path) -> anyhow::Result<()> {
    let is_taken = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(_) => folder.exists(),
    };
    if is_taken {
        return Err(Refused::error(format!("{}: already exists and is not empty", folder.display())));
    }
    Ok(())
}

fn write_all(folder: &Path, files: Vec<File>) -> anyhow::Result<()> {
    files.into_iter().try_for_each(|(path, text, is_program)| write(&folder.join(path), &text, is_program))
}

/// The folder's name as that of a package: small letters, digits and hyphens.
fn package_name(folder: &Path) -> anyhow::Result<String> {
    // `.` has a name, too.
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let name = whole.file_name().and_then(OsStr::to_str).unwrap_or_default();
    let is_good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    if RESERVED.contains(&name) {
        let folder = folder.display();
        return Err(Refused::error(format!(
            "{folder}: no package may be called `{name}`; choose another name"
        )));
    }
    if name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_good) {
        return Ok(name.to_owned());
    }
    Err(Refused::error(format!(
        "{}: the folder's name is also the package's: a lowercase letter, then lowercase letters, digits, - and _",
        folder.display()
    )))
}

/// The crates are in no registry, so that the project has them with it, unless there is a clone to build from.
fn rust(name: &str, clone: Option<&Path>) -> anyhow::Result<Vec<File>> {
    let version = env!("CARGO_PKG_VERSION");
    let (baudbot, note) = match clone {
        Some(clone) => (source(clone)?, String::new()),
        None => ("baudbot".to_owned(), include_str!("../../templates/rust/carried.md").to_owned()),
    };
    let fill = |template: &str| {
        let filled = template.replace("{carried}", &note).replace("{name}", name);
        filled.replace("{baudbot}", &baudbot).replace("{version}", version).into_bytes()
    };
    let mut files: Vec<File> = vec![
        ("Cargo.toml".into(), fill(include_str!("../../templates/rust/Cargo.toml")), false),
        ("README.md".into(), fill(include_str!("../../templates/rust/README.md")), false),
        ("brain.toml".into(), fill(include_str!("../../templates/rust/brain.toml")), false),
        ("src/main.rs".into(), include_bytes!("../../templates/rust/main.rs").to_vec(), false),
        (".gitignore".into(), b"/target\n".to_vec(), false),
    ];
    if clone.is_none() {
        let readme = fill(include_str!("../../templates/rust/baudbot.md"));
        files.push(("baudbot/README.md".into(), readme, false));
        files.extend(carried("rust")?);
    }
    Ok(files)
}

/// The folder of a clone, for manifests.
fn source(clone: &Path) -> anyhow::Result<String> {
    if !clone.join("brains/Cargo.toml").is_file() {
        return Err(Refused::error(format!(
            "--baudbot {}: baudbot's source is not there; name the folder of a clone",
            clone.display()
        )));
    }
    let source = clone.canonicalize().with_context(|| clone.display().to_string())?;
    Ok(source.display().to_string())
}

/// The package for brains is in no registry, so the project contains it.
fn python(name: &str) -> anyhow::Result<Vec<File>> {
    let readme = include_str!("../../templates/python/README.md").replace("{name}", name);
    let example = include_str!("../../../client/python/examples/avoid.py");
    let mut files: Vec<File> = vec![
        ("README.md".into(), readme.into_bytes(), false),
        ("brain.py".into(), example.into(), true),
        ("test_brain.py".into(), include_bytes!("../../templates/python/test_brain.py").to_vec(), false),
        (
            "requirements.txt".into(),
            include_bytes!("../../templates/python/requirements.txt").to_vec(),
            false,
        ),
        (".gitignore".into(), b"/.venv\n__pycache__/\n".to_vec(), false),
    ];
    files.extend(carried("python")?);
    Ok(files)
}

/// The files that the program carries for projects in a language.
fn carried(language: &str) -> anyhow::Result<impl Iterator<Item = File>> {
    Ok(sources::of(language)?.into_iter().map(|(path, text)| (path, text, false)))
}

fn write(path: &Path, text: &[u8], is_program: bool) -> anyhow::Result<()> {
    let written = || -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(path, text)?;
        let mode = if is_program { 0o755 } else { 0o644 };
        fs::set_permissions(path, fs::Permissions::from_mode(mode))
    };
    written().with_context(|| format!("cannot write {}", path.display()))
}

/// Folders of cargo's own, and words of Rust: no program can be called so.
const RESERVED: &[&str] = &[
    "abstract",
    "as",
    "async",
    "await",
    "become",
    "box",
    "break",
    "build",
    "const",
    "continue",
    "crate",
    "deps",
    "do",
    "dyn",
    "else",
    "enum",
    "examples",
    "extern",
    "false",
    "final",
    "fn",
    "for",
    "if",
    "impl",
    "in",
    "incremental",
    "let",
    "loop",
    "macro",
    "match",
    "mod",
    "move",
    "mut",
    "override",
    "pub",
    "ref",
    "return",
    "self",
    "static",
    "struct",
    "super",
    "test",
    "trait",
];
