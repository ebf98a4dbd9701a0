//! The texts on its licence in a crate's package.

use std::path::{Path, PathBuf};

use super::crates::Crate;
use crate::shell::Failure;

/// The beginnings of the names of files that a notice is made of, in lower case.
const NAMES: [&str; 6] = ["license", "licence", "copying", "copyright", "notice", "unlicense"];
/// The licence whose text is shortest is enough where there is a choice.
const SHORTEST: &str = "mit";

/// The text that has to go with a crate: the files of its package; of one that forgot them, its licence's text with its authors.
pub(super) fn of(root: &Path, one: &Crate) -> Result<String, Failure> {
    let files = files(one)?;
    if files.is_empty() {
        return instead(root, one);
    }
    let texts = files.iter().map(|path| {
        let bytes = std::fs::read(path).map_err(Failure::file(path))?;
        Ok(String::from_utf8_lossy(&bytes).replace('\r', "").trim_end().to_owned())
    });
    Ok(texts.collect::<Result<Vec<_>, Failure>>()?.join("\n\n"))
}

fn files(one: &Crate) -> Result<Vec<PathBuf>, Failure> {
    let folder = one.folder();
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Failure::file(folder))? {
        let path = entry.map_err(Failure::file(folder))?.path();
        if path.is_file() && NAMES.iter().any(|begin| name(&path).starts_with(begin)) {
            files.push(path);
        }
    }
    files.sort();
    let is_alternative = |path: &Path| {
        ["license", "licence", "copying", "unlicense"].iter().any(|begin| name(path).starts_with(begin))
    };
    if is_choice(one) && files.iter().any(|path| name(path).contains(SHORTEST)) {
        files.retain(|path| !is_alternative(path) || name(path).contains(SHORTEST));
    }
    Ok(files)
}

/// Whether the MIT licence alone is enough.
fn is_choice(one: &Crate) -> bool {
    alternatives(one).any(|licence| licence == "MIT")
}

/// The licences of which any is enough; `/` is an old spelling of `OR`.
fn alternatives(one: &Crate) -> impl Iterator<Item = &str> {
    let expression = one.license.as_deref().unwrap_or_default();
    let is_simple = !expression.contains(" AND ") && !expression.contains('(');
    expression.split(" OR ").flat_map(|part| part.split('/')).map(str::trim).filter(move |_| is_simple)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Of a crate whose package has no such file.
fn instead(root: &Path, one: &Crate) -> Result<String, Failure> {
    let known = [("MIT", "LICENSE-MIT"), ("Apache-2.0", "LICENSE-APACHE")];
    let found = known.iter().find(|(licence, _)| alternatives(one).any(|one| one == *licence));
    let Some((licence, file)) = found else {
        return Err(Failure::Wrong(format!(
            "{one}: its package has no file with its licence; add the text of this licence to {}",
            file!()
        )));
    };
    let path = root.join(file);
    let text = std::fs::read_to_string(&path).map_err(Failure::file(&path))?;
    // Ours begins with our own name.
    let text: Vec<_> = text.lines().filter(|line| !line.starts_with("Copyright (c)")).collect();
    let authors =
        if one.authors.is_empty() { format!("the authors of {}", one.name) } else { one.authors.join(", ") };
    Ok(format!("Copyright (c) {authors}\n\n{licence}:\n\n{}", text.join("\n").trim()))
}
