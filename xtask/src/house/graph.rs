//! The references between modules of a crate, and the circles that they make.

use std::collections::{BTreeMap, BTreeSet};

use super::text::{inside, parts, words};

/// The modules by name, each with those that it reaches.
pub(super) type Graph = BTreeMap<String, BTreeSet<String>>;

/// The module that a file belongs to, by its path below `src`.
pub(super) fn module_of(path: &str) -> &str {
    path.split('/').next().unwrap_or(path).trim_end_matches(".rs")
}

/// The names of a file's crate in it: modules, and items of its root.
pub(super) fn named(path: &str, code: &str) -> BTreeSet<String> {
    // `super` of a module right below the crate is the crate itself.
    let depth = path.split('/').count() - usize::from(path.ends_with("/mod.rs"));
    let mut found = BTreeSet::new();
    let mut behind_super = 0;
    for word in words(code) {
        if word.text == "crate" {
            if let Some(path) = below(&code[word.end..]) {
                follow(path, 0, &mut found);
            }
        } else if word.text == "super" {
            // The first of several is followed through the others.
            if &code[behind_super..word.start] != "::" {
                follow(&code[word.start..], depth, &mut found);
            }
            behind_super = word.end;
        }
    }
    found
}

/// Groups of modules that all reach each other, the largest first.
pub(super) fn circles(graph: &Graph) -> Vec<Vec<String>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        graph.keys().map(|module| (module.as_str(), reached(graph, module))).collect();
    let circle_of = |module: &str| -> Vec<String> {
        let others = reached[module].iter().filter(|other| reached[**other].contains(module));
        others.map(|other| (*other).to_owned()).collect()
    };
    let circles: BTreeSet<Vec<String>> = graph.keys().map(|module| circle_of(module)).collect();
    let mut circles: Vec<_> = circles.into_iter().filter(|circle| circle.len() > 1).collect();
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

/// The path behind `::`, if that comes next.
fn below(code: &str) -> Option<&str> {
    code.trim_start().strip_prefix("::")
}

/// Adds what a path names that has to go up so many times to be at the crate. `super::{a, b::{c, d}}` names `a` and `b`.
fn follow(path: &str, ups: usize, found: &mut BTreeSet<String>) {
    let path = path.trim_start();
    if path.starts_with('{') {
        for part in parts(inside(path, 0)) {
            follow(part, ups, found);
        }
        return;
    }
    let Some(word) = words(path).next().filter(|word| word.start == 0) else { return };
    if ups == 0 {
        found.insert(word.text.to_owned());
    } else if word.text == "super"
        && let Some(path) = below(&path[word.end..])
    {
        follow(path, ups - 1, found);
    }
}

/// The modules that one reaches, also through others; itself only if it is in a circle.
fn reached<'a>(graph: &'a Graph, module: &str) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open = vec![module];
    while let Some(module) = open.pop() {
        for other in &graph[module] {
            if found.insert(other.as_str()) {
                open.push(other);
            }
        }
    }
    found
}
