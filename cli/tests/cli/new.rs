//! `baudbot new`; `./test new-brains` builds what it makes.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cli::{baudbot, good};

fn folder(name: &str) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    path.to_str().unwrap().to_owned()
}

/// The packages that Cargo resolves for a project, without a network, and the lockfile.
fn resolved(project: &Path) -> (String, String) {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["tree", "--offline", "--prefix", "none", "--format", "{p}"]).current_dir(project);
    let output = cargo.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lockfile = std::fs::read_to_string(project.join("Cargo.lock")).unwrap();
    (String::from_utf8(output.stdout).unwrap(), lockfile)
}

/// Texts of all files below a folder.
fn texts(folder: &Path) -> Vec<String> {
    let below = |path: PathBuf| if path.is_dir() { texts(&path) } else { vec![read(&path)] };
    std::fs::read_dir(folder).unwrap().flat_map(|entry| below(entry.unwrap().path())).collect()
}

fn read(path: &Path) -> String {
    String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned()
}

#[test]
fn a_project_in_rust_has_the_crates_with_it_and_their_versions() {
    // Away from the source, as Cargo looks for a workspace in the folders above.
    let place = tempfile::tempdir().unwrap();
    let project = place.path().join("weaver");
    let said = good(&["new", "brain", project.to_str().unwrap()]);
    assert!(said.starts_with(&format!("{} is ready.", project.display())), "{said}");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for text in texts(&project) {
        assert!(!text.contains(source.to_str().unwrap()), "{text}");
    }
    for file in ["Cargo.toml", "README.md", "baudbot/README.md"] {
        let text = read(&project.join(file));
        assert!(!text.contains('{') || file == "Cargo.toml" && !text.contains("{baudbot}"), "{file}: {text}");
    }
    assert!(read(&project.join("Cargo.toml")).contains("name = \"weaver\""));
    assert!(read(&project.join("src/main.rs")).contains("impl MotorBehavior for Weave"));
    assert!(read(&project.join("README.md")).contains("The folder `baudbot/`"));
    let (packages, lockfile) = resolved(&project);
    let tested = include_str!("../../../Cargo.lock");
    let is_there = |line: &&str| line.starts_with("checksum = ") && !tested.contains(*line);
    assert_eq!(lockfile.lines().find(is_there), None, "a version that is not tested");
    for package in ["baudbot-brains", "baudbot-client", "tonic", "clap"] {
        assert!(packages.contains(&format!("\n{package} v")), "{package} in {packages}");
    }
    let (code, _, err) = baudbot(&["new", "brain", project.to_str().unwrap()]);
    let taken = format!("error: {}: already exists and is not empty\n", project.display());
    assert_eq!((code, err), (2, taken));
}

#[test]
fn a_project_in_rust_may_be_built_with_a_clone() {
    let folder = folder("cloner");
    let clone = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_str().unwrap();
    good(&["new", "brain", &folder, "--baudbot", clone]);
    let project = Path::new(&folder);
    assert!(read(&project.join("Cargo.toml")).contains(&format!("path = \"{clone}/brains\"")));
    assert!(read(&project.join("README.md")).contains(&format!("`{clone}/docs/reference/brains.md`")));
    assert!(!project.join("baudbot").exists() && !project.join("Cargo.lock").exists());
}

#[test]
fn a_project_in_python_has_the_package_with_it() {
    let folder = folder("timid");
    good(&["new", "brain", &folder, "--lang", "python"]);
    let read = |name: &str| std::fs::read_to_string(Path::new(&folder).join(name)).unwrap();
    assert!(read("brain.py").contains("class Avoid(baudbot.Brain):"));
    assert_eq!(read("requirements.txt"), "./baudbot-client\n");
    assert!(read("baudbot-client/pyproject.toml").contains("name = \"baudbot-client\""));
    assert!(read("baudbot-client/src/baudbot/v1/brain_link_pb2.py").contains("DESCRIPTOR"));
    assert!(read("baudbot-client/src/baudbot/scenarios/wander.toml").contains("name = \"wander\""));
}

#[test]
fn what_cannot_be_made_is_refused() {
    let (code, _, err) = baudbot(&["new", "brain", "My Brain"]);
    assert!(
        code == 2 && err.contains("a lowercase letter, then lowercase letters, digits, - and _"),
        "{err}"
    );
    let (code, _, err) = baudbot(&["new", "brain", &folder("deps")]);
    assert!(code == 2 && err.contains("no package may be called `deps`"), "{err}");
    let (code, _, err) = baudbot(&["new", "brain", &folder("lost"), "--baudbot", "/nowhere"]);
    assert!(code == 2 && err.contains("--baudbot /nowhere: baudbot's source is not there"), "{err}");
}

/// What is built in a clone's folder is not in the project, and the contract is.
#[test]
fn a_project_in_another_language_has_the_contract_with_it() {
    for (language, brain) in [
        ("cpp", "follow.hpp"),
        ("go", "follow.go"),
        ("java", "Follow.java"),
        ("node", "follow.mjs"),
        ("ruby", "follow.rb"),
        ("typescript", "gen/baudbot/v1/brain_link_pb.ts"),
    ] {
        let folder = folder(&format!("follow-{language}"));
        good(&["new", "brain", &folder, "--lang", language]);
        for file in ["README.md", "proto/baudbot/v1/brain_link.proto", brain] {
            assert!(Path::new(&folder).join(file).is_file(), "{language}: {file}");
        }
        for left_out in ["build", "node_modules", "generate"] {
            assert!(!Path::new(&folder).join(left_out).exists(), "{language}: {left_out}");
        }
    }
}
