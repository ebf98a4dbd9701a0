//! Puts what a scenario refers to by file into its text, so that a simulator which reads no files gets one
//! text that is complete.
//!
//! Three things can be referred to:
//!
//! - `[[arena.maps]]`: a map of a ROS map server, or a plan in SVG. It becomes `[[arena.polygons]]` tables. That needs the
//!   feature `maps`, and is refused without it.
//! - `[robots.sensors.NAME] lookup = "samples.csv"`: a table of measurements. It becomes a table in the text.
//! - `[robots.microcontroller] program = "wander.hex"`: a program, as Intel HEX or ELF. It becomes a table with Intel HEX.
//!
//! A file is checked as far as it must be to become shapes and numbers. The scenario's parser then finds out whether
//! these make sense, as if they had been written by hand.
//!
//! Equal files give equal text on every machine as far as maps and measurements go. Curves and turned parts
//! of an SVG are computed in single precision by another crate, and are rounded to a micrometre.

pub mod embedded;
mod error;
mod file;
pub mod kind;
mod lookup;
#[cfg_attr(not(feature = "maps"), path = "no_maps.rs")]
mod maps;
mod note;
#[cfg_attr(not(unix), path = "opened_elsewhere.rs")]
pub mod opened;
mod program;
pub mod source;
mod tables;

use std::borrow::Cow;
use std::path::Path;

use toml_edit::DocumentMut;

pub use error::ImportError;
pub use note::{Note, Weight};
use program::Files;
pub use program::program;

/// Gives back a scenario that refers to no file.
///
/// `text` is a scenario in TOML, and `base` the folder that file names in it are relative to. A text that refers to no
/// file comes back as it is, and so does one that is no TOML: the parser of scenarios has the place and the reason. In
/// any other the tables stay in their order.
pub fn inline<'a>(text: &'a str, base: &Path) -> Result<Cow<'a, str>, ImportError> {
    inline_with_notes(text, base, &mut Vec::new())
}

/// The same, with the notes on the files.
///
/// # Errors
/// As [`inline`].
pub fn inline_with_notes<'a>(
    text: &'a str,
    base: &Path,
    notes: &mut Vec<Note>,
) -> Result<Cow<'a, str>, ImportError> {
    inline_from(text, Files::In(base), notes)
}

/// The same of a scenario that is in this program. It refers to no maps and tables.
pub(crate) fn inline_embedded(text: &str) -> Result<Cow<'_, str>, ImportError> {
    inline_from(text, Files::Embedded, &mut Vec::new())
}

fn inline_from<'a>(
    text: &'a str,
    files: Files<'_>,
    notes: &mut Vec<Note>,
) -> Result<Cow<'a, str>, ImportError> {
    if text.len() > MAX_TEXT {
        return Ok(Cow::Borrowed(text)); // the parser refuses it
    }
    if !may_refer(text) {
        return Ok(Cow::Borrowed(text));
    }
    let Ok(mut document) = text.parse::<DocumentMut>() else { return Ok(Cow::Borrowed(text)) };
    let base = match files {
        Files::In(base) => base,
        Files::Embedded => Path::new(""),
    };
    let has_maps = maps::inline(&mut document, base, notes)?;
    let has_lookups = lookup::inline(&mut document, base)?;
    let has_programs = program::inline(&mut document, files)?;
    if !has_maps && !has_lookups && !has_programs {
        return Ok(Cow::Borrowed(text));
    }
    let complete = document.to_string();
    if complete.len() > MAX_TEXT {
        let problem = format!(
            "with all files in it the text has {} bytes, the limit is {MAX_TEXT}: use a coarser map, a \
             larger tolerance_m or fewer samples",
            complete.len()
        );
        return Err(ImportError::field("scenario", problem));
    }
    Ok(Cow::Owned(complete))
}

/// Whether a text has a word that fields with names of files are called by, or may have one in disguise. A long text
/// that has none is not parsed here, which takes several times its memory.
fn may_refer(text: &str) -> bool {
    ["maps", "lookup", "program", "\\"].iter().any(|word| text.contains(word))
}

/// Bytes of the longest text that the parser of scenarios takes.
const MAX_TEXT: usize = 16 << 20;
