//! Measures the structure of the Rust code: its size, its longest functions, and modules that reach each other in a circle.
//!
//! With `--check` it names what the house rules of CONTRIBUTING.md forbid. The exceptions are in [`EXCEPTIONS`], with
//! the reason for each.
//!
//! A module is a file or folder right below a crate's `src`; it reaches another if its path stands in its code, tests
//! left out. Lines of code are those that have more than a comment; the length of a file counts all lines but those of
//! tests. What only tests use (`#[cfg(test)]`, `tests.rs`, `tests/`) is counted apart; generated code is not counted.
//!
//! A comment is a paragraph of `//`, `///` or `//!`, in tests too. It is a clause-comment if its first word is What, How,
//! Where, Which, Who or Why and its first sentence is no question.

mod graph;
mod measure;
mod prose;
mod report;
mod sources;
mod text;

#[cfg(test)]
mod tests;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The exceptions from the house rules, below the root of the repository.
pub(crate) const EXCEPTIONS: &str = "xtask/house.toml";

/// Prints the table of the crates, or with `--check` what is amiss. False means that the check has found something.
pub(crate) fn run(arguments: &[String]) -> Result<bool, Error> {
    let request = Request::parse(arguments)?;
    let root = root()?;
    let files = match &request.commit {
        Some(commit) => sources::at_commit(&root, commit)?,
        None => sources::in_folder(&root)?,
    };
    let crates = measure::crates(&files);
    if !request.check {
        print(&report::table(&crates))?;
        return Ok(true);
    }
    let exceptions = report::Exceptions::read(&root)?;
    let found = report::amiss(&crates, &exceptions);
    if found.is_empty() {
        print(&format!("{}\n", exceptions.nothing_amiss()))?;
    } else {
        print(&format!("{}\n", found.join("\n")))?;
    }
    Ok(found.is_empty())
}

/// The findings of a check of the working tree below `root`, a line for each.
pub(crate) fn findings(root: &Path) -> Result<Vec<String>, Error> {
    let crates = measure::crates(&sources::in_folder(root)?);
    Ok(report::amiss(&crates, &report::Exceptions::read(root)?))
}

/// The line of a check of the working tree below `root` that finds nothing.
pub(crate) fn nothing_amiss(root: &Path) -> Result<String, Error> {
    Ok(report::Exceptions::read(root)?.nothing_amiss())
}

/// A reason why the code could not be measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// An argument that is not known, or lacks what belongs to it.
    #[error("house: {argument}: not understood; the arguments are [--rev COMMIT] [--check]")]
    Argument { argument: String },
    /// The command was given outside the repository.
    #[error("house: neither this folder nor one above it has {EXCEPTIONS}; call it inside the repository")]
    NoRoot,
    /// Git could not be started, or its pipe broke.
    #[error("git {command}: {source}")]
    GitPipe { command: String, source: io::Error },
    /// Git has refused.
    #[error("git {command}: {said}")]
    Git { command: String, said: String },
    /// A file or folder cannot be read.
    #[error("{path}: {source}")]
    Read { path: String, source: io::Error },
    /// A Rust file is not UTF-8.
    #[error("{path}: is not UTF-8, as Rust's sources must be")]
    NotText { path: String },
    /// The file of exceptions says what it may not.
    #[error("{EXCEPTIONS}: {source}")]
    Exceptions { source: toml::de::Error },
    /// The output was closed.
    #[error("house: the output: {source}")]
    Output { source: io::Error },
}

/// The request in the arguments.
struct Request {
    /// The working tree, if there is none.
    commit: Option<String>,
    check: bool,
}

impl Request {
    fn parse(arguments: &[String]) -> Result<Self, Error> {
        let mut request = Self { commit: None, check: false };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            let refused = || Error::Argument { argument: argument.clone() };
            if argument == "--check" {
                request.check = true;
            } else if argument == "--rev" {
                request.commit = Some(rest.next().ok_or_else(refused)?.clone());
            } else {
                request.commit = Some(argument.strip_prefix("--rev=").ok_or_else(refused)?.to_owned());
            }
        }
        Ok(request)
    }
}

/// The root of the repository in which the command was given.
fn root() -> Result<PathBuf, Error> {
    let here = std::env::current_dir().map_err(|source| Error::Read { path: ".".to_owned(), source })?;
    let root = here.ancestors().find(|folder| folder.join(EXCEPTIONS).is_file());
    root.map(Path::to_path_buf).ok_or(Error::NoRoot)
}

/// `print!` panics when the reader has gone, as `head` does.
fn print(text: &str) -> Result<(), Error> {
    io::stdout().lock().write_all(text.as_bytes()).map_err(|source| Error::Output { source })
}
