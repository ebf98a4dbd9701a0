//! The records of runs: the durations of sections and the last green release checks (committed), and the sections
//! that have passed on this state of the tree (in the target folder).

use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::place::Place;

/// A reason why records cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The file system says no.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: std::io::Error,
    },
    /// The file is no such record.
    #[error("{}: {error}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// The place and the fault.
        error: toml::de::Error,
    },
    /// A question to git has no answer.
    #[error("git {question}: {answer}")]
    Git {
        /// Its words.
        question: String,
        /// The answer of git.
        answer: String,
    },
}

/// The duration of a section.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Duration {
    /// By the wall clock, in whole seconds.
    pub(crate) wall_s: u64,
    /// Of all processors, in whole seconds.
    pub(crate) processor_s: u64,
    /// The commit at which it was measured.
    pub(crate) commit: String,
    /// The machine on which it was measured.
    pub(crate) machine: String,
}

/// When a release check was last green.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Green {
    /// The commit that it checked.
    pub(crate) commit: String,
    /// The day, in UTC.
    pub(crate) date: String,
    /// The hash of its log in git (`git hash-object`).
    pub(crate) log: String,
    /// By the wall clock, in whole seconds.
    pub(crate) wall_s: u64,
}

/// A committed table: a line for each section.
pub(crate) type Table<T> = BTreeMap<String, T>;

const TIMES: &str = "xtask/times.toml";
const TIMES_HEAD: &str = "# How long sections take, each run alone on a machine that does nothing else. Written by `./test … --write-times`.\n";
const GREEN: &str = "xtask/release-checks.toml";
const GREEN_HEAD: &str =
    "# When each release check was last green. Written by the checks themselves (`./test release-checks`).\n";

/// The expected durations.
///
/// # Errors
///
/// The file cannot be read.
pub(crate) fn times(root: &Path) -> Result<Table<Duration>, Error> {
    read(&root.join(TIMES))
}

/// Replaces some of the expected durations.
///
/// # Errors
///
/// The file cannot be read or written.
pub(crate) fn write_times(root: &Path, fresh: Table<Duration>) -> Result<(), Error> {
    let mut all = times(root)?;
    all.extend(fresh);
    write(&root.join(TIMES), TIMES_HEAD, &all)
}

/// When release checks were last green.
///
/// # Errors
///
/// The file cannot be read.
pub(crate) fn greens(root: &Path) -> Result<Table<Green>, Error> {
    read(&root.join(GREEN))
}

/// Notes that a release check is green.
///
/// # Errors
///
/// The file cannot be read or written.
pub(crate) fn write_green(root: &Path, section: &str, green: Green) -> Result<(), Error> {
    let mut all = greens(root)?;
    all.insert(section.to_owned(), green);
    write(&root.join(GREEN), GREEN_HEAD, &all)
}

fn read<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<Table<T>, Error> {
    match std::fs::read_to_string(path) {
        Ok(text) => toml::from_str(&text).map_err(|error| Error::Text { path: path.to_owned(), error }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Table::new()),
        Err(error) => Err(Error::File { path: path.to_owned(), error }),
    }
}

/// Writes a table with a line for each entry, so that a change of one is a change of one line.
fn write<T: Serialize>(path: &Path, head: &str, table: &Table<T>) -> Result<(), Error> {
    let mut text = head.to_owned();
    for (name, entry) in table {
        // A record has numbers and words only.
        let line = toml::Value::try_from(entry).map(|value| value.to_string()).unwrap_or_default();
        text += &format!("{name} = {line}\n");
    }
    std::fs::write(path, text).map_err(|error| Error::File { path: path.to_owned(), error })
}

/// The processor seconds of all programs that have ended, as Linux counts them.
pub(crate) fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in parentheses, may have blanks. Linux counts hundredths of a second, on every processor.
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(13).take(2).filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// The processor, and how many there are.
pub(crate) fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{processors} of {}", model.map_or("an unknown processor", |(_, name)| name))
}

/// The commit that is checked out.
///
/// # Errors
///
/// This is no clone.
pub(crate) fn commit(root: &Path) -> Result<String, Error> {
    git(root, &["rev-parse", "--short=12", "HEAD"])
}

/// The number of commits since one; `None` if it is not known here.
pub(crate) fn commits_since(root: &Path, commit: &str) -> Option<u64> {
    git(root, &["rev-list", "--count", &format!("{commit}..HEAD")]).ok()?.parse().ok()
}

/// The number of commits that lead to this one; 0 if that is not known.
pub(crate) fn commits(root: &Path) -> u64 {
    git(root, &["rev-list", "--count", "HEAD"]).ok().and_then(|count| count.parse().ok()).unwrap_or(0)
}

/// Whether this is a clone with all of its past.
pub(crate) fn has_its_past(root: &Path) -> bool {
    git(root, &["rev-parse", "--is-shallow-repository"]).is_ok_and(|answer| answer == "false")
}

/// The hash of a file's content in git.
///
/// # Errors
///
/// There is no git, or no such file.
pub(crate) fn content_hash(root: &Path, file: &Path) -> Result<String, Error> {
    git(root, &["hash-object", &file.to_string_lossy()])
}

/// A name for this state of the tree, with changes that are not committed.
///
/// # Errors
///
/// This is no clone.
pub(crate) fn state_of_tree(root: &Path) -> Result<String, Error> {
    let commit = commit(root)?;
    // The tables that runs write themselves change nothing that is tested.
    let tables = ["--", ".", ":!xtask/times.toml", ":!xtask/release-checks.toml"];
    let changes = git(root, &[&["diff", "--no-ext-diff", "HEAD", "--binary"], &tables[..]].concat())?;
    let files = git(root, &[&["ls-files", "--others", "--exclude-standard"], &tables[..]].concat())?;
    if changes.is_empty() && files.is_empty() {
        return Ok(commit);
    }
    let mut hasher = DefaultHasher::new();
    changes.hash(&mut hasher);
    for file in files.lines() {
        (file, std::fs::read(root.join(file)).ok()).hash(&mut hasher);
    }
    Ok(format!("{commit}+{:016x}", hasher.finish()))
}

/// Today, in UTC.
pub(crate) fn today() -> String {
    let printed = Command::new("date").args(["-u", "+%F"]).output();
    printed.map_or_else(
        |_| "an unknown day".to_owned(),
        |printed| String::from_utf8_lossy(&printed.stdout).trim().to_owned(),
    )
}

fn git(root: &Path, words: &[&str]) -> Result<String, Error> {
    let asked = Command::new("git").arg("-C").arg(root).args(words).output();
    let no_answer = |answer: String| Error::Git { question: words.join(" "), answer };
    let printed = asked.map_err(|error| no_answer(error.to_string()))?;
    if printed.status.success() {
        Ok(String::from_utf8_lossy(&printed.stdout).trim_end().to_owned())
    } else {
        Err(no_answer(String::from_utf8_lossy(&printed.stderr).trim().to_owned()))
    }
}

/// The sections that have passed, by keys of the tree's state and the section.
pub(crate) struct Passed {
    path: PathBuf,
}

impl Passed {
    /// That of a target folder.
    pub(crate) fn of(place: &Place) -> Self {
        Self { path: place.target.join("test/passed") }
    }

    /// Whether a section has.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.text().lines().any(|line| line == key)
    }

    /// Notes that a section has.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub(crate) fn add(&self, key: &str) -> Result<(), Error> {
        append(&self.path, &format!("{key}\n"))
    }

    /// Forgets that a section has.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub(crate) fn remove(&self, key: &str) -> Result<(), Error> {
        let kept: String =
            self.text().lines().filter(|line| *line != key).map(|line| format!("{line}\n")).collect();
        std::fs::write(&self.path, kept).map_err(|error| Error::File { path: self.path.clone(), error })
    }

    /// A file that is not there has no line.
    fn text(&self) -> String {
        std::fs::read_to_string(&self.path).unwrap_or_default()
    }
}

/// The results of sections that were repeated, by states of the tree: lines of a state, a section, `passed` or `failed`, and
/// seconds.
pub(crate) struct Repeats {
    path: PathBuf,
}

impl Repeats {
    /// Those of a target folder.
    pub(crate) fn of(place: &Place) -> Self {
        Self { path: place.target.join("test/repeats") }
    }

    /// Adds a result.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub(crate) fn add(&self, state: &str, section: &str, passed: bool, seconds: u64) -> Result<(), Error> {
        let how = if passed { "passed" } else { "failed" };
        append(&self.path, &format!("{state} {section} {how} {seconds}\n"))
    }

    /// The number of times that a section has passed and failed on a state of the tree.
    pub(crate) fn counts(&self, state: &str, section: &str) -> (usize, usize) {
        let text = std::fs::read_to_string(&self.path).unwrap_or_default();
        let count = |how: &str| {
            text.lines().filter(|line| line.starts_with(&format!("{state} {section} {how} "))).count()
        };
        (count("passed"), count("failed"))
    }
}

fn append(path: &Path, line: &str) -> Result<(), Error> {
    use std::io::Write as _;
    let written = std::fs::File::options()
        .create(true)
        .append(true)
        .open(path)
        .and_then(|mut file| file.write_all(line.as_bytes()));
    written.map_err(|error| Error::File { path: path.to_owned(), error })
}
