//! The crates of others that are built into packages, as Cargo tells them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::shell::{Failure, Shell};

/// A crate of somebody else.
#[derive(Clone, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd)]
pub(super) struct Crate {
    pub(super) name: String,
    pub(super) version: String,
    /// An SPDX expression.
    pub(super) license: Option<String>,
    pub(super) authors: Vec<String>,
    manifest_path: PathBuf,
    id: String,
    /// None if it is of this repository.
    source: Option<String>,
}

impl Crate {
    /// Its package, unpacked.
    pub(super) fn folder(&self) -> &Path {
        self.manifest_path.parent().unwrap_or(&self.manifest_path)
    }
}

impl fmt::Display for Crate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let licence = self.license.as_deref().unwrap_or("see below");
        write!(f, "{} {} ({licence})", self.name, self.version)
    }
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Crate>,
    resolve: Resolve,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

#[derive(Deserialize)]
struct Kind {
    /// None if it is normal; else it is for builds or for tests.
    kind: Option<String>,
}

/// The crates of others that packages of this repository depend on with all features, each once.
pub(super) fn built_into(shell: &Shell, packages: &[&str], targets: &[&str]) -> Result<Vec<Crate>, Failure> {
    let mut command = shell.cargo(["metadata", "--format-version", "1", "--all-features"]);
    command.args(targets.iter().flat_map(|target| ["--filter-platform", target]));
    let Metadata { packages: all, resolve } = serde_json::from_str(&shell.text(command)?)
        .map_err(|error| Failure::Wrong(format!("cargo metadata tells what is not understood: {error}")))?;
    let dependencies: BTreeMap<_, _> = resolve.nodes.iter().map(|node| (&node.id, &node.deps)).collect();
    let is_root = |one: &&Crate| one.source.is_none() && packages.contains(&one.name.as_str());
    let mut waiting: Vec<_> = all.iter().filter(is_root).map(|one| &one.id).collect();
    let mut reached = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if reached.insert(id) {
            let normal = dependencies.get(id).into_iter().copied().flatten();
            let normal =
                normal.filter(|dependency| dependency.dep_kinds.iter().any(|kind| kind.kind.is_none()));
            waiting.extend(normal.map(|dependency| &dependency.pkg));
        }
    }
    let mut crates: Vec<_> =
        all.iter().filter(|one| one.source.is_some() && reached.contains(&one.id)).cloned().collect();
    crates.sort();
    Ok(crates)
}
