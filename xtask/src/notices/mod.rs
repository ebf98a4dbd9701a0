//! Notices of the work of others in what is given away: each crate in the program, the Python package and the page, with the
//! files on licences and notices that its package has; what `viewer/LICENSES.md` says of the pages' scripts; and what the
//! toolchain adds. Which licences there may be says `deny.toml`, by `./test supply-chain`.
//!
//! They are collected at each build of something that is given away, from what Cargo says is built in, so that none is missing
//! or out of date.

mod crates;
mod texts;

use std::collections::BTreeMap;
use std::path::Path;

use self::crates::Crate;
use crate::shell::{Failure, Shell};

/// The packages that are given away; what they depend on is in them.
const GIVEN_AWAY: [&str; 3] = ["baudbot", "baudbot-python", "baudbot-page"];
/// The targets of released programs.
const TARGETS: [&str; 5] = [
    "x86_64-unknown-linux-gnu",
    "x86_64-unknown-linux-musl",
    "aarch64-unknown-linux-gnu",
    "aarch64-unknown-linux-musl",
    "wasm32-wasip1",
];
/// The notices of parts of programs that are no crates.
const TOOLCHAIN: &str = "deploy/release/toolchain-notices.txt";
/// The notices of the pages' packages from npm.
const SCRIPTS: &str = "viewer/LICENSES.md";
const RULE: &str =
    "================================================================================================";

/// The file of notices.
const FILE: &str = "THIRD-PARTY-NOTICES.txt";

/// `./test notices [FOLDER]`: writes the notices of all that is given away.
///
/// # Errors
///
/// A crate has neither a file with its licence nor a licence whose text is here.
pub(crate) fn write(shell: &Shell, arguments: &[String]) -> Result<(), Failure> {
    let folder = match arguments {
        [] => shell.place.target.join("notices"),
        [folder] => shell.place.root.join(folder),
        [_, ..] => return Err(Failure::Wrong("./test notices [FOLDER]".to_owned())),
    };
    std::fs::create_dir_all(&folder).map_err(Failure::file(&folder))?;
    let crates = crates::built_into(shell, &GIVEN_AWAY, &TARGETS)?;
    let path = folder.join(FILE);
    std::fs::write(&path, of(&shell.place.root, &crates)?).map_err(Failure::file(&path))?;
    shell.say(&format!("{}: notices of {} crates", path.display(), crates.len()));
    Ok(())
}

/// The notices of these crates, of the pages' scripts and of the toolchain. Crates whose texts are alike share them.
fn of(root: &Path, crates: &[Crate]) -> Result<String, Failure> {
    let mut by_texts = BTreeMap::<String, Vec<&Crate>>::new();
    for one in crates {
        by_texts.entry(texts::of(root, one)?).or_default().push(one);
    }
    let mut groups: Vec<_> = by_texts.into_iter().collect();
    groups.sort_by(|(_, one), (_, other)| one[0].cmp(other[0]));
    let mut notices =
        "The work of others that is in baudbot's programs, packages and pages, with its licences.\n"
            .to_owned();
    for (text, crates) in groups {
        let names: String = crates.iter().map(|one| format!("{one}\n")).collect();
        notices += &format!("\n{RULE}\n{names}\n{text}\n");
    }
    for name in [TOOLCHAIN, SCRIPTS] {
        let path = root.join(name);
        let text = std::fs::read_to_string(&path).map_err(Failure::file(&path))?;
        notices += &format!("\n{RULE}\n{}\n", text.trim_end());
    }
    Ok(notices)
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::place::Place;

    fn shell() -> Shell {
        let mut place = Place::new();
        place.target = std::env::temp_dir().join(format!("xtask-notices-{}", std::process::id()));
        Shell::new(place, Arc::new(AtomicBool::new(false))).unwrap()
    }

    /// By `cargo tree`, which the notices are not made from: with normal dependencies only, and all features.
    #[test]
    fn each_crate_that_is_built_in_is_named_in_the_notices() {
        let shell = shell();
        let target = ["x86_64-unknown-linux-gnu"];
        let notices =
            of(&shell.place.root, &crates::built_into(&shell, &GIVEN_AWAY, &target).unwrap()).unwrap();
        let words =
            ["tree", "--all-features", "--edges", "normal", "--prefix", "none", "--target", target[0]];
        let mut tree = shell.cargo(words);
        tree.args(["--format", "{p}|{l}"]).args(GIVEN_AWAY.iter().flat_map(|name| ["-p", name]));
        let tree = shell.text(tree).unwrap();
        let crates: BTreeSet<_> = tree
            .lines()
            .filter_map(|line| line.split_once('|'))
            // A crate with a path is of this repository.
            .filter(|(name, _)| !name.contains(" (/"))
            .map(|(name, licence)| {
                let name = name.trim_end_matches(" (proc-macro)").replacen(" v", " ", 1);
                format!("{name} ({})", licence.trim_end_matches(" (*)"))
            })
            .collect();
        let named: BTreeSet<_> = notices.lines().collect();
        let missing: Vec<_> = crates.iter().filter(|one| !named.contains(one.as_str())).collect();
        assert!(missing.is_empty(), "{missing:?}");
        assert!(crates.len() > 200, "{}", crates.len());
        // A text for each that asks for one: of BSD, of ISC, and a notice under Apache's licence.
        for words in
            ["Redistributions in binary form must", "Permission to use, copy, modify, and", "MIT License"]
        {
            assert!(notices.contains(words), "{words}");
        }
        std::fs::remove_dir_all(&shell.place.target).unwrap();
    }

    fn scripts(folder: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                scripts(&path, found);
            } else if path.extension().is_some_and(|end| end == "ts" || end == "css") {
                found.push(std::fs::read_to_string(&path).unwrap());
            }
        }
    }

    /// The packages of npm that scripts import, by their names.
    fn imported(scripts: &[String]) -> BTreeSet<String> {
        let mut packages = BTreeSet::new();
        for begin in ["from \"", "import \"", "import(\"", "@import \""] {
            for rest in scripts.iter().flat_map(|text| text.split(begin).skip(1)) {
                let path = rest.split('"').next().unwrap_or_default();
                let is_name = path.starts_with(|c: char| c.is_ascii_lowercase() || c == '@');
                let depth = if path.starts_with('@') { 2 } else { 1 };
                if is_name {
                    packages.insert(path.split('/').take(depth).collect::<Vec<_>>().join("/"));
                }
            }
        }
        packages
    }

    /// The bundles are `viewer/dist`, and the page that needs no installation, with all that they depend on.
    #[test]
    fn each_package_that_the_pages_import_is_among_their_licences_in_its_version() {
        #[derive(serde::Deserialize)]
        struct Lock {
            packages: BTreeMap<String, Package>,
        }
        #[derive(serde::Deserialize)]
        struct Package {
            #[serde(default)]
            version: String,
            #[serde(default)]
            dependencies: BTreeMap<String, String>,
        }
        let root = Place::new().root;
        let mut texts = Vec::new();
        scripts(&root.join("viewer/src"), &mut texts);
        let lock = std::fs::read_to_string(root.join("viewer/package-lock.json")).unwrap();
        let lock: Lock = serde_json::from_str(&lock).unwrap();
        let licences = std::fs::read_to_string(root.join(SCRIPTS)).unwrap();
        let (mut waiting, mut bundled) = (Vec::from_iter(imported(&texts)), BTreeSet::new());
        while let Some(name) = waiting.pop() {
            let package = &lock.packages.get(&format!("node_modules/{name}")).expect(&name);
            if bundled.insert(format!("## {name} {}", package.version)) {
                waiting.extend(package.dependencies.keys().cloned());
            }
        }
        let there: BTreeSet<_> = licences.lines().collect();
        let missing: Vec<_> = bundled.iter().filter(|line| !there.contains(line.as_str())).collect();
        assert!(missing.is_empty(), "{SCRIPTS} lacks {missing:?}");
        let only =
            "import { a } from \"@b/c/d\";\nimport \"e/f.css\";\nimport { g } from \"./g\";\nimport(\"h\")";
        assert_eq!(Vec::from_iter(imported(&[only.to_owned()])), ["@b/c", "e", "h"]);
        assert!(bundled.len() >= 5, "{bundled:?}");
    }
}
