//! Files that are written during a run, on the world's thread, and how that goes as seen from outside.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use anyhow::Context;
use baudbot_import::embedded;
use baudbot_import::kind::Kind;
use baudbot_import::source;
use baudbot_run::assignment;
use tokio::sync::oneshot;
use tokio::task::JoinSet;

use crate::args::ChangeArgs;
use crate::error::{self, Refused};

/// The progress of the files that are being written.
#[derive(Default)]
pub(crate) struct Files(JoinSet<anyhow::Result<()>>);

impl Files {
    /// Watches a file with this name. Its writer sends an error as soon as one occurs, or else the end.
    pub(crate) fn watch(&mut self, name: String, outcome: oneshot::Receiver<io::Result<()>>) {
        self.0.spawn(async move {
            match outcome.await {
                Ok(result) => result.map_err(|error| error::from_output(error, &name)),
                // The writer is gone without a word: it panicked, and that is reported elsewhere.
                Err(_) => Ok(()),
            }
        });
    }

    /// Waits for one of them to fail; forever if none does.
    pub(crate) async fn failure(&mut self) -> anyhow::Error {
        while let Some(done) = self.0.join_next().await {
            if let Ok(Err(error)) = done {
                return error;
            }
        }
        std::future::pending().await
    }

    /// Waits for their ends, or the first failure that was not reported before.
    pub(crate) async fn finish(mut self) -> anyhow::Result<()> {
        while let Some(done) = self.0.join_next().await {
            done.context("a file's watch panicked")??;
        }
        Ok(())
    }
}

/// Opens a file, or stdout for `-`. What is in the file stays there until the first rows are written; a file that is new, and was
/// neither written nor flushed, goes again.
pub(crate) fn open(path: &Path) -> io::Result<Box<dyn Write + Send>> {
    if path == Path::new(STDOUT) {
        // Not the standard library's stdout: what that holds back is written at the program's exit, which
        // must not wait for a reader.
        return Ok(Box::new(File::from(io::stdout().as_fd().try_clone_to_owned()?)));
    }
    let (file, state) = match File::create_new(path) {
        Ok(file) => (file, State::New(path.to_owned())),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            // A file that is not regular, such as a FIFO, has nothing to be replaced.
            let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
            let state = if file.metadata()?.is_file() { State::Old } else { State::Written };
            (file, state)
        }
        Err(error) => return Err(error),
    };
    Ok(Box::new(Replaced { file, state }))
}

/// Refuses outputs that would be written into each other. Each comes with its option.
pub(crate) fn check_apart<'a>(outputs: impl Iterator<Item = (&'static str, &'a Path)>) -> anyhow::Result<()> {
    let mut before: Vec<(&str, &Path)> = Vec::new();
    for (option, path) in outputs {
        if let Some((other, same)) = before.iter().find(|(_, other)| is_same_file(other, path)) {
            let (same, path) = (same.display(), path.display());
            return Err(Refused::error(format!(
                "{other} {same} and {option} {path} are the same file; write each to a file of its own"
            )));
        }
        before.push((option, path));
    }
    Ok(())
}

/// Files that a command reads, each with a word for what it is.
#[derive(Default)]
pub(crate) struct Inputs(Vec<(&'static str, PathBuf)>);

impl Inputs {
    /// A scenario by its name, which may be built in, and the programs in place of its own.
    pub(crate) fn of(scenario: &str, changes: &ChangeArgs) -> Self {
        Self::default().scenario(scenario).firmware(&changes.firmware)
    }

    pub(crate) fn scenario(self, name: &str) -> Self {
        if embedded::scenario(name).is_some() { self } else { self.file(SCENARIO, name) }
    }

    /// The files of `--firmware` arguments.
    pub(crate) fn firmware(self, arguments: &[String]) -> Self {
        let files = arguments.iter().filter_map(|argument| argument.split_once('='));
        files.fold(self, |all, (_, file)| all.file(FIRMWARE, file))
    }

    /// The description files of `--brain` arguments.
    pub(crate) fn brains(self, arguments: &[String]) -> Self {
        let names =
            arguments.iter().map(|brain| assignment::split(brain).1.split(':').next().unwrap_or_default());
        names.filter(|name| name.ends_with(".toml")).fold(self, |all, name| all.file("brain", name))
    }

    pub(crate) fn file(mut self, word: &'static str, path: impl Into<PathBuf>) -> Self {
        self.0.push((word, path.into()));
        self
    }

    /// Refuses outputs that would be written over one of them, or over what it refers to. Each output comes with its option.
    pub(crate) fn check<'a>(
        self,
        outputs: impl Iterator<Item = (&'static str, &'a Path)>,
    ) -> anyhow::Result<()> {
        let mut outputs = outputs.filter(|(_, path)| *path != Path::new(STDOUT)).peekable();
        if outputs.peek().is_none() {
            return Ok(());
        }
        let inputs = self.with_references();
        for (option, path) in outputs {
            if let Some((word, input)) = inputs.iter().find(|(_, input)| is_same_file(input, path)) {
                let (path, input) = (path.display(), input.display());
                return Err(Refused::error(format!(
                    "{option} {path} would overwrite the {word} {input}; write to another file"
                )));
            }
        }
        Ok(())
    }

    /// The outputs that can be overwritten: a pipe cannot, and must not be read twice.
    fn with_references(self) -> Vec<(&'static str, PathBuf)> {
        let mut all = self.0;
        all.retain(|(_, path)| path.is_file());
        let mut seen = 0;
        // An exercise leads to its scenario, and a scenario to no other.
        while let Some((word, path)) = all.get(seen) {
            let more = references(word, path);
            all.extend(more);
            seen += 1;
        }
        all
    }
}

/// The files that a scenario or an exercise refers to; none if it cannot be read, which is reported elsewhere.
fn references(word: &str, path: &Path) -> Vec<(&'static str, PathBuf)> {
    let kind = match word {
        SCENARIO => Kind::Scenario,
        EXERCISE => Kind::Exercise,
        _ => return Vec::new(),
    };
    let Some(Ok(text)) = path.to_str().map(|path| source::read(path, kind)) else { return Vec::new() };
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    let mut found = Vec::new();
    for line in text.lines().filter(|line| !line.trim_start().starts_with('#')) {
        let parts: Vec<_> = line.split(['"', '\'']).collect();
        for pair in parts.windows(2) {
            let referred = referred(pair[0]).filter(|referred| (word, *referred) != (SCENARIO, SCENARIO));
            let is_built_in = referred == Some(SCENARIO) && embedded::scenario(pair[1]).is_some();
            let file = referred.filter(|_| !is_built_in).map(|word| (word, folder.join(pair[1])));
            found.extend(file.filter(|(_, path)| path.is_file()));
        }
    }
    found
}

/// The kind of file that a string in TOML refers to, by the key before it.
fn referred(before: &str) -> Option<&'static str> {
    let key = before.trim_end().strip_suffix('=')?.trim_end();
    let key = key.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next()?;
    REFERENCES.iter().find(|(known, _)| *known == key).map(|(_, word)| *word)
}

/// Whether both paths lead to one file, which need not be there yet.
pub(crate) fn is_same_file(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| {
        path.canonicalize().or_else(|_| {
            let path = std::path::absolute(path)?;
            let folder = path.parent().and_then(|folder| folder.canonicalize().ok());
            Ok::<_, io::Error>(match folder.zip(path.file_name()) {
                Some((folder, name)) => folder.join(name),
                None => path,
            })
        })
    };
    one == other || real(one).ok().zip(real(other).ok()).is_some_and(|(one, other)| one == other)
}

/// A file that keeps what is in it until something new is written.
struct Replaced {
    file: File,
    state: State,
}

/// The content of a file that is written.
enum State {
    /// Nothing, and it is here for this only.
    New(PathBuf),
    /// The content from before.
    Old,
    /// The new content.
    Written,
}

impl Write for Replaced {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match std::mem::replace(&mut self.state, State::Written) {
            State::Old => self.file.set_len(0)?,
            State::New(_) | State::Written => {}
        }
        self.file.write(bytes)
    }

    /// A flush is the end of an output, also of an empty one.
    fn flush(&mut self) -> io::Result<()> {
        if matches!(self.state, State::New(_)) {
            self.state = State::Written;
        }
        self.file.flush()
    }
}

impl Drop for Replaced {
    fn drop(&mut self) {
        match &self.state {
            State::New(path) => drop(std::fs::remove_file(path)),
            State::Old | State::Written => {}
        }
    }
}

/// The file name that means stdout.
pub(crate) const STDOUT: &str = "-";

/// Words for inputs that refer to others.
pub(crate) const SCENARIO: &str = "scenario";
pub(crate) const EXERCISE: &str = "exercise";
const FIRMWARE: &str = "firmware";

/// The fields that name files, and words for these.
const REFERENCES: [(&str, &str); 5] =
    [("program", FIRMWARE), ("lookup", "table"), ("ros", "map"), ("svg", "map"), ("scenario", SCENARIO)];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_new_and_not_written_goes_again_and_an_old_one_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.gif");
        drop(open(&path).unwrap());
        assert!(!path.exists());
        open(&path).unwrap().flush().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"", "there was nothing to say");
        open(&path).unwrap().write_all(b"a long film").unwrap();
        drop(open(&path).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"a long film");
        open(&path).unwrap().write_all(b"short").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"short");
    }
}
