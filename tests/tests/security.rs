//! `SECURITY.md` names a test for each threat: they are there.

use std::path::{Path, PathBuf};

/// All sources of tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !["target", "node_modules", ".git", ".venv"].contains(&name.as_str()) {
            sources(&path, found);
        } else if name.ends_with(".rs") {
            found.push(path);
        }
    }
}

#[test]
fn each_threat_has_a_test() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let text = std::fs::read_to_string(root.join("SECURITY.md")).unwrap();
    let mut paths = Vec::new();
    sources(root, &mut paths);
    let code: String = paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let sections = std::fs::read_to_string(root.join("xtask/src/sections/mod.rs")).unwrap();
    let (_, table) = text.split_once("## Threats").unwrap();
    let mut tests = 0;
    for row in table.lines().filter(|line| line.starts_with('|')).skip(2) {
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap();
        let named: Vec<_> = cell.split('`').skip(1).step_by(2).collect();
        assert!(!named.is_empty(), "no test is named: {row}");
        for name in named {
            let is_there = match name {
                command if command.starts_with("./test ") => {
                    let section = command.split(' ').nth(1).unwrap();
                    sections.contains(&format!("Section {{ name: \"{section}\""))
                }
                file if file.contains('/') => root.join(file).exists(),
                test => code.contains(&format!("fn {test}(")),
            };
            assert!(is_there, "there is no test `{name}`");
            tests += 1;
        }
    }
    assert!(tests > 20, "{tests}");
}
