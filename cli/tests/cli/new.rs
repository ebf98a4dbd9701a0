//! `baudbot new`; `./test` builds what it makes.

use std::path::Path;

use crate::{baudbot, good};

fn folder(name: &str) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_project_in_rust_names_the_crates_of_this_one() {
    let folder = folder("weaver");
    let said = good(&["new", "brain", &folder]);
    assert!(said.starts_with(&format!("{folder} is ready.")), "{said}");
    let read = |name: &str| std::fs::read_to_string(Path::new(&folder).join(name)).unwrap();
    assert!(read("Cargo.toml").contains("name = \"weaver\""));
    assert!(read("src/main.rs").contains("impl MotorBehavior for Weave"));
    for name in ["Cargo.toml", "README.md"] {
        assert!(!read(name).contains("{baudbot}") && !read(name).contains("{name}"), "{name}");
    }
    let (code, _, err) = baudbot(&["new", "brain", &folder]);
    assert_eq!((code, err), (2, format!("error: {folder}: already exists and is not empty\n")));
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
