//! Packs what `baudbot new brain` writes into projects: the crates that a brain in Rust needs, the package for Python, and the examples in
//! other languages with the contract. So the program makes projects on machines that have no source of baudbot's.
//!
//! The result is `sources.lz4` in the build's folder: for each file its path in the project, after the name of the language, and
//! its length, each on a line, and then its bytes.

mod lockfile;
mod manifest;

use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The folders of the crates, in the order of what they need.
const CRATES: &[&str] = &[
    "crates/fields",
    "crates/access",
    "crates/geometry",
    "crates/wire",
    "crates/brain",
    "proto",
    "client",
    "brains",
];

/// The folders of `examples/` that are projects of their own.
const EXAMPLES: &[&str] = &["cpp", "go", "java", "node", "ruby", "typescript"];

/// What is in them that was built, or needs this source.
const LEFT_OUT: &[&str] = &["build", "node_modules", "generate", "buf.gen.yaml"];

/// The file of the contract that a brain needs.
const CONTRACT: &str = "proto/baudbot/v1/brain_link.proto";

/// Files that go with the crates as they are.
const BESIDE: &[&str] = &["LICENSE-APACHE", "LICENSE-MIT", "docs/reference/brains.md"];

fn main() -> Result<(), Box<dyn Error>> {
    let cli = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let root = cli.parent().ok_or("the crate is not in a workspace")?;
    let mut archive = Archive::default();
    rust(root, &mut archive)?;
    python(&root.join("client/python"), &mut archive)?;
    let contract = watched(&root.join(CONTRACT))?;
    for language in EXAMPLES {
        example(&root.join("examples").join(language), language, &mut archive)?;
        archive.add(&format!("{language}/{CONTRACT}"), contract.as_bytes());
    }
    let out = PathBuf::from(env::var("OUT_DIR")?).join("sources.lz4");
    let mut packed = lz4::EncoderBuilder::new().level(12).build(fs::File::create(out)?)?;
    packed.write_all(&archive.bytes)?;
    Ok(packed.finish().1?)
}

/// The crates, the workspace that they inherit from, and the versions of other crates with which they are tested.
fn rust(root: &Path, archive: &mut Archive) -> Result<(), Box<dyn Error>> {
    let mut members = Vec::new();
    for folder in CRATES {
        let manifest = manifest::of_library(&watched(&root.join(folder).join("Cargo.toml"))?);
        archive.add(&format!("rust/baudbot/{folder}/Cargo.toml"), manifest.as_bytes());
        members.push(manifest);
        for part in ["src", "repertoires"] {
            let part = root.join(folder).join(part);
            if part.is_dir() {
                archive.add_folder(
                    &part,
                    &part.strip_prefix(root)?.to_string_lossy(),
                    "rust/baudbot",
                    is_source,
                )?;
            }
        }
    }
    let workspace = manifest::of_workspace(&watched(&root.join("Cargo.toml"))?, CRATES, &members);
    archive.add("rust/baudbot/Cargo.toml", workspace.as_bytes());
    let lockfile = lockfile::of_members(&watched(&root.join("Cargo.lock"))?, &members);
    archive.add("rust/Cargo.lock", lockfile.as_bytes());
    for file in BESIDE {
        archive.add(&format!("rust/baudbot/{file}"), watched(&root.join(file))?.as_bytes());
    }
    Ok(())
}

fn python(package: &Path, archive: &mut Archive) -> Result<(), Box<dyn Error>> {
    for file in ["README.md", "pyproject.toml"] {
        archive.add(&format!("python/baudbot-client/{file}"), watched(&package.join(file))?.as_bytes());
    }
    let is_part = |name: &str| {
        let ends = |end: &&str| name.ends_with(end);
        [".py", ".pyi", ".toml", "py.typed"].iter().any(ends)
    };
    archive.add_folder(&package.join("src"), "src", "python/baudbot-client", is_part)
}

/// An example, without what was built in its folder.
fn example(folder: &Path, language: &str, archive: &mut Archive) -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut entries = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let (path, file) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if LEFT_OUT.contains(&file.as_str()) {
            continue;
        }
        if path.is_dir() {
            archive.add_folder(&path, &file, language, |_| true)?;
        } else {
            archive.add(&format!("{language}/{file}"), &fs::read(path)?);
        }
    }
    Ok(())
}

/// Whether a crate needs the file when it is built: modules of tests alone it does not, any other file it may include.
fn is_source(name: &str) -> bool {
    let stem = name.strip_suffix(".rs").unwrap_or_default();
    !(stem == "tests" || stem.starts_with("test_") || stem.ends_with("_tests"))
}

/// The text of a file; the script runs again when that changes.
fn watched(path: &Path) -> Result<String, Box<dyn Error>> {
    println!("cargo::rerun-if-changed={}", path.display());
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()).into())
}

#[derive(Default)]
struct Archive {
    bytes: Vec<u8>,
}

impl Archive {
    fn add(&mut self, path: &str, file: &[u8]) {
        self.bytes.extend(format!("{path}\n{}\n", file.len()).bytes());
        self.bytes.extend(file);
    }

    /// Adds the files of a folder, `name` in the project's folder `within`, whose names are taken.
    fn add_folder(
        &mut self,
        folder: &Path,
        name: &str,
        within: &str,
        takes: impl Fn(&str) -> bool + Copy,
    ) -> Result<(), Box<dyn Error>> {
        println!("cargo::rerun-if-changed={}", folder.display());
        let mut entries = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let (path, file) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let name = format!("{name}/{file}");
            if path.is_dir() {
                self.add_folder(&path, &name, within, takes)?;
            } else if takes(&file) {
                self.add(&format!("{within}/{name}"), &fs::read(path)?);
            }
        }
        Ok(())
    }
}
