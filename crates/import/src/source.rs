//! The source of a scenario's text: a file, or the program itself.

use std::borrow::Cow;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

use crate::embedded;
use crate::error::ImportError;
use crate::kind::Kind;
use crate::note::Note;
use crate::{MAX_TEXT, inline_embedded, inline_with_notes, opened};

/// The text of a scenario, not yet parsed, with all that it refers to by file in it.
#[derive(Clone, Debug)]
pub struct Source {
    /// The name that was given: a path, or that of an embedded scenario.
    pub label: String,
    /// TOML.
    pub text: String,
    /// The notes on the files that are in it.
    pub notes: Vec<Note>,
}

/// The reason why there is no such text, on one line that begins with its name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SourceError(String);

impl Source {
    /// Finds an embedded scenario of this name, or reads a file, and what that refers to by file.
    ///
    /// # Errors
    /// If there is neither, if it is no text or too long, or if something that it refers to cannot be read.
    pub fn find(name: &str) -> Result<Self, SourceError> {
        let mut notes = Vec::new();
        let text = match embedded::scenario(name) {
            Some(text) => whole(name, inline_embedded(text))?,
            None => inlined(name, &read(name, Kind::Scenario)?, &mut notes)?,
        };
        Ok(Self { label: name.to_owned(), text, notes })
    }

    /// A text that a program has made. Files that it refers to are found from the present folder.
    ///
    /// # Errors
    /// If something that it refers to cannot be read.
    pub fn written(text: String) -> Result<Self, SourceError> {
        let (label, mut notes) = ("scenario".to_owned(), Vec::new());
        Ok(Self { text: inlined(&label, &text, &mut notes)?, label, notes })
    }

    /// The same as [`find`](Self::find), of a file that another file refers to, which is in `folder`.
    ///
    /// # Errors
    /// As [`find`](Self::find).
    pub fn beside(folder: &Path, name: &str) -> Result<Self, SourceError> {
        if embedded::scenario(name).is_some() {
            return Self::find(name);
        }
        Self::find(&folder.join(name).display().to_string())
    }
}

/// Reads a file of this kind as it stands, without what it refers to.
///
/// # Errors
/// If it cannot be read, is no text or is too long.
pub fn read(path: &str, wanted: Kind) -> Result<String, SourceError> {
    let unreadable = |error: io::Error| SourceError(unreadable(path, wanted, &error));
    let one = wanted.one();
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(SourceError(format!("{path}: is a directory, not {one} file")));
    }
    let mut file = opened::any(Path::new(path)).map_err(unreadable)?;
    // However long a recording is, that is not what is wrong with it.
    let mut bytes = Vec::new();
    file.by_ref().take(RECORDING.len() as u64).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes == RECORDING {
        return Err(SourceError(format!(
            "{path}: is a recording, not {one}; `baudbot replay {path}` repeats its run, and `baudbot export {path}` describes it, draws it and \
             writes its tables"
        )));
    }
    if metadata.len() > MAX_TEXT as u64 {
        let problem = format!("{path}: has {} bytes, {one} has at most {MAX_TEXT}", metadata.len());
        return Err(SourceError(problem));
    }
    // A device or a pipe has no length, and may have no end.
    file.take(MAX_TEXT as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() > MAX_TEXT {
        let problem = format!("{path}: has more than {MAX_TEXT} bytes, the most that {one} may have");
        return Err(SourceError(problem));
    }
    String::from_utf8(bytes).map_err(|_| unreadable(io::ErrorKind::InvalidData.into()))
}

/// The error for a text that is not valid as this kind, if it is of another.
pub fn mistaken(name: &str, text: &str, wanted: Kind) -> Option<SourceError> {
    let found = Kind::of_text(text).filter(|found| *found != wanted)?;
    let (is, not, command) = (found.one(), wanted.one(), found.command(name, text));
    Some(SourceError(format!("{name}: is {is}, not {not}; run it with `{command}`")))
}

/// The error for a path without a recording, if a file of another kind is there, or it is a name that is built in.
pub fn no_recording(path: &Path) -> Option<SourceError> {
    let name = path.display().to_string();
    if !path.exists() {
        let built_in = other_built_in(&name, Kind::Recording)?;
        return Some(SourceError(format!("{name}: there is no such file; {built_in}")));
    }
    let text = read(&name, Kind::Recording).ok()?;
    mistaken(&name, &text, Kind::Recording)
}

/// The first bytes of a file in MCAP.
const RECORDING: &[u8] = b"\x89MCAP0\r\n";

/// Puts the maps and tables that a scenario refers to into their places.
fn inlined(path: &str, text: &str, notes: &mut Vec<Note>) -> Result<String, SourceError> {
    let folder = Path::new(path).parent().unwrap_or_else(|| Path::new(""));
    whole(path, inline_with_notes(text, folder, notes))
}

fn whole(path: &str, text: Result<Cow<'_, str>, ImportError>) -> Result<String, SourceError> {
    text.map(Cow::into_owned).map_err(|error| SourceError(format!("{path}: {error}")))
}

fn unreadable(path: &str, wanted: Kind, error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        let noun = wanted.noun();
        let hint = other_built_in(path, wanted).or_else(|| meant(path, wanted));
        let hint = hint.map_or_else(String::new, |hint| format!("; {hint}"));
        let list = if wanted == Kind::Exercise { "; `baudbot grade --list` has them all" } else { "" };
        format!("{path}: there is no such file, and no {noun} of this name is built in{hint}{list}")
    } else if error.kind() == io::ErrorKind::InvalidData {
        format!("{path}: is not text in UTF-8")
    } else {
        format!("{path}: {error}")
    }
}

/// The error that a name is one of another built-in file, and the command for that.
fn other_built_in(name: &str, wanted: Kind) -> Option<String> {
    let (kind, text) = Kind::built_in(name).filter(|(kind, _)| *kind != wanted)?;
    Some(format!("`{name}` is {}: `{}`", kind.one(), kind.command(name, text)))
}

/// The names that may be meant.
fn meant(wrong: &str, wanted: Kind) -> Option<String> {
    let meant: Vec<_> = wanted.nearest(wrong).iter().map(|name| format!("`{name}`")).collect();
    (!meant.is_empty()).then(|| format!("did you mean {}?", meant.join(", ")))
}
