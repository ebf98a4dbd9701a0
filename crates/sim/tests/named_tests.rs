//! Tests that the page of tests of noise, `docs/explanation/equations.md` and `docs/explanation/determinism.md` name are there under
//! these names.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const PAGES: [(&str, &str); 3] = [
    ("crates/sim/tests/devices/README.md", include_str!("devices/README.md")),
    ("docs/explanation/equations.md", include_str!("../../../docs/explanation/equations.md")),
    ("docs/explanation/determinism.md", include_str!("../../../docs/explanation/determinism.md")),
];

#[test]
fn each_test_that_a_page_names_is_there() {
    let mut functions = BTreeSet::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for around in [root.join("crates"), root] {
        for package in fs::read_dir(around).unwrap().map(|entry| entry.unwrap().path()) {
            if package.join("Cargo.toml").exists() {
                ["src", "tests", "examples"]
                    .iter()
                    .for_each(|sources| collect(&package.join(sources), &mut functions));
            }
        }
    }
    assert!(functions.len() > 1000, "found only {} functions", functions.len());
    for (page, text) in PAGES {
        let names: Vec<_> = text.split('`').skip(1).step_by(2).filter(|word| is_sentence(word)).collect();
        assert!(names.len() > 10, "{page} names only {names:?}");
        for name in names {
            assert!(functions.contains(name), "{page} names `{name}`, which is not there");
        }
    }
}

/// Whether it is as the names of tests are: four words or more.
fn is_sentence(word: &str) -> bool {
    word.matches('_').count() >= 3 && word.bytes().all(|b| matches!(b, b'a'..=b'z' | b'0'..=b'9' | b'_'))
}

/// The names of all functions in a folder's files, and in the folders in it.
fn collect(folder: &Path, functions: &mut BTreeSet<String>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            collect(&path, functions);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let name = |line: &str| Some(line.split_once("fn ")?.1.split_once('(')?.0.to_owned());
            functions.extend(text.lines().filter_map(name));
        }
    }
}
