//! Manifests of crates that are built and not tested.

/// The manifest of a crate without its tests, benchmarks and examples, and what those need.
pub(crate) fn of_library(manifest: &str) -> String {
    tables(manifest, |table| !["[dev-dependencies]", "[[test]]", "[[bench]]", "[[example]]"].contains(&table))
}

/// The workspace's manifest with these members alone, and with what they inherit.
pub(crate) fn of_workspace(manifest: &str, folders: &[&str], members: &[String]) -> String {
    let used: Vec<_> = members.iter().flat_map(|member| dependencies(member)).collect();
    let shared = tables(manifest, |table| table.starts_with("[workspace."));
    let versions = tables(&shared, |table| table == "[workspace.dependencies]");
    let is_unused = |line: &str| key(line).is_some_and(|key| versions.contains(line) && !used.contains(&key));
    let inherited: Vec<_> = shared.lines().filter(|line| !is_unused(line)).collect();
    let members: Vec<_> = folders.iter().map(|folder| format!("\"{folder}\"")).collect();
    format!(
        "[workspace]\nresolver = \"3\"\nmembers = [{}]\n\n{}\n",
        members.join(", "),
        inherited.join("\n").trim()
    )
}

/// The names of the crates that a manifest's `[dependencies]` names.
pub(crate) fn dependencies(manifest: &str) -> Vec<String> {
    tables(manifest, |table| table == "[dependencies]").lines().filter_map(key).collect()
}

/// The first part of a line's key.
fn key(line: &str) -> Option<String> {
    let (name, _) = line.split_once('=')?;
    let name = name.split('.').next().unwrap_or_default().trim();
    (!name.is_empty() && !name.starts_with(['#', '['])).then(|| name.to_owned())
}

/// The tables of a file that are kept by their headers, each with the comment before it.
fn tables(toml: &str, keeps: impl Fn(&str) -> bool) -> String {
    let (mut kept, mut is_kept, mut before) = (String::new(), false, String::new());
    for line in toml.lines() {
        if line.is_empty() || line.starts_with('#') {
            before += &format!("{line}\n");
            continue;
        }
        if line.starts_with('[') {
            is_kept = keeps(line);
        }
        if is_kept {
            kept += &format!("{before}{line}\n");
        }
        before.clear();
    }
    kept
}
