//! The Rust files of the working tree or of a commit.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::Error;

/// Texts by path from the root, with `/` between folders.
pub(super) type Sources = BTreeMap<String, String>;

/// Folders of other people's code and of what a build makes; Git ignores them, but a source archive has no Git.
const NOT_OURS: [&str; 4] = ["target", "node_modules", ".git", ".venv"];

/// The files as they lie in the folder: those that Git has or would take, or all if it is no checkout.
pub(super) fn in_folder(root: &Path) -> Result<Sources, Error> {
    let mut found = Sources::new();
    if !root.join(".git").exists() {
        walk(root, "", &mut found)?;
        return Ok(found);
    }
    let listed = git(root, &["ls-files", "-z", "-co", "--exclude-standard", "--", "*.rs"])?;
    for path in listed.split('\0').filter(|path| !path.is_empty()) {
        // Git still lists what was just deleted.
        if root.join(path).exists() {
            found.insert(path.to_owned(), read(root, path)?);
        }
    }
    Ok(found)
}

/// The files as a commit has them.
pub(super) fn at_commit(root: &Path, commit: &str) -> Result<Sources, Error> {
    let listed = git(root, &["ls-tree", "-r", "-z", commit])?;
    let mut blobs = Blobs::open(root)?;
    let mut found = Sources::new();
    for entry in listed.split('\0') {
        // "100644 blob 257cc5642cb1a054f08cc83f2d943e56fd3ebe99\tsrc/lib.rs"; links have another mode.
        let Some((object, path)) = entry.split_once('\t') else { continue };
        if object.starts_with("100") && path.ends_with(".rs") {
            let name = object.rsplit(' ').next().unwrap_or_default();
            let text = String::from_utf8(blobs.read(name)?);
            let text = text.map_err(|_| Error::NotText { path: path.to_owned() })?;
            found.insert(path.to_owned(), text);
        }
    }
    Ok(found)
}

/// Adds the Rust files below a folder, whose path from the root is empty or ends in `/`.
fn walk(root: &Path, folder: &str, found: &mut Sources) -> Result<(), Error> {
    let failed = |source| Error::Read { path: root.join(folder).display().to_string(), source };
    for entry in fs::read_dir(root.join(folder)).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let kind = entry.file_type().map_err(failed)?;
        let name = entry.file_name();
        // None of our files has such a name, so it is not ours.
        let Some(name) = name.to_str() else { continue };
        if kind.is_dir() && !NOT_OURS.contains(&name) {
            walk(root, &format!("{folder}{name}/"), found)?;
        } else if kind.is_file() && name.ends_with(".rs") {
            let path = format!("{folder}{name}");
            let text = read(root, &path)?;
            found.insert(path, text);
        }
    }
    Ok(())
}

fn read(root: &Path, path: &str) -> Result<String, Error> {
    let bytes = fs::read(root.join(path)).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    String::from_utf8(bytes).map_err(|_| Error::NotText { path: path.to_owned() })
}

fn git(root: &Path, arguments: &[&str]) -> Result<String, Error> {
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output();
    let command = arguments.join(" ");
    let output = output.map_err(|source| Error::GitPipe { command: command.clone(), source })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(Error::Git { command, said });
    }
    String::from_utf8(output.stdout).map_err(|_| Error::NotText { path: format!("git {command}") })
}

/// A Git that gives one object after the other; to start one for each would take seconds.
struct Blobs {
    git: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Blobs {
    fn open(root: &Path) -> Result<Self, Error> {
        let mut command = Command::new("git");
        command.arg("-C").arg(root).args(["cat-file", "--batch"]);
        let mut git = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(broken)?;
        let answers = git.stdout.take().ok_or_else(|| broken(io::ErrorKind::BrokenPipe.into()))?;
        Ok(Self { git, answers: BufReader::new(answers) })
    }

    /// Asks and reads in turns, so that neither pipe can fill up while the other end waits.
    fn read(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        let questions = self.git.stdin.as_mut().ok_or_else(|| broken(io::ErrorKind::BrokenPipe.into()))?;
        writeln!(questions, "{name}").map_err(broken)?;
        let mut head = String::new();
        self.answers.read_line(&mut head).map_err(broken)?;
        // "257cc5642cb1a054f08cc83f2d943e56fd3ebe99 blob 4", then the bytes and a line's end.
        let length = head.trim().rsplit(' ').next().and_then(|length| length.parse::<usize>().ok());
        let said = || Error::Git { command: BATCH.to_owned(), said: head.trim().to_owned() };
        let mut bytes = vec![0; length.ok_or_else(said)? + 1];
        self.answers.read_exact(&mut bytes).map_err(broken)?;
        bytes.pop();
        Ok(bytes)
    }
}

impl Drop for Blobs {
    /// Without its questions Git ends by itself; it is waited for, so that no zombie stays.
    fn drop(&mut self) {
        drop(self.git.stdin.take());
        let _ = self.git.wait();
    }
}

const BATCH: &str = "cat-file --batch";

fn broken(source: io::Error) -> Error {
    Error::GitPipe { command: BATCH.to_owned(), source }
}
