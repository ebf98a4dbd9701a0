//! Text in columns, and the only way to terminals.
//!
//! Scenarios, recordings and brains of others have names and words in them that a terminal may obey. All that goes to stdout
//! and stderr as text goes through here, where such characters are shown instead.

use std::fmt;
use std::fs::{self, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use anyhow::Context;
use baudbot_fields::printable::{Printable, PrintableLines, is_printable};
use baudbot_plot::quantity::NOTHING;
use baudbot_plot::text::columns;
use serde::Serialize;

use crate::error;

/// Rows of cells as lines, each column as wide as its widest cell: the first to the left, the others to the
/// right.
pub(crate) fn table<const N: usize>(indent: &str, rows: &[[String; N]]) -> String {
    columns(indent, rows, |i| i == 0)
}

/// Names and values as lines, the values below one another.
pub(crate) fn pairs(indent: &str, pairs: &[(&str, String)]) -> String {
    let width = pairs.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    pairs.iter().map(|(name, value)| format!("{indent}{name:<width$}  {value}\n")).collect()
}

/// A fraction as a percentage.
pub(crate) fn percent(fraction: f64) -> String {
    if fraction.is_finite() { format!("{:.1} %", fraction * 100.0) } else { NOTHING.to_owned() }
}

/// A text of others on one line: line breaks are spaces, and what else a terminal would obey is shown.
pub(crate) fn one_line(text: &str) -> String {
    Printable(text.split_whitespace().collect::<Vec<_>>().join(" ")).to_string()
}

/// Writes text for people to stdout; a reader that is gone is an error, no panic.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    write_out(&PrintableLines(text).to_string())
}

/// Writes a value as JSON to stdout. Its strings keep all their characters, and no terminal obeys them.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let json = serde_json::to_string_pretty(value).context("cannot write JSON")?;
    write_out(&(escaped_json(&json) + "\n"))
}

/// Prints it as JSON on a line of its own.
pub(crate) fn print_json_line(value: &impl Serialize) -> anyhow::Result<()> {
    let json = serde_json::to_string(value).context("cannot write JSON")?;
    write_out(&(escaped_json(&json) + "\n"))
}

/// Moves the cursor and the like: escape sequences of our own, and text that is printable.
pub(crate) fn control(sequences: &str) -> anyhow::Result<()> {
    write_out(sequences)
}

fn write_out(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|error| error::from_output(error, "stdout"))
}

/// JSON in which only printable characters stand for themselves: all others are in strings, or between lines.
pub(crate) fn escaped_json(json: &str) -> String {
    let mut escaped = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '\n' => escaped.push(c),
            c if is_printable(c) => escaped.push(c),
            // None of them is beyond the first 2¹⁶.
            c => escaped += &format!("\\u{:04x}", u32::from(c)),
        }
    }
    escaped
}

/// Writes a line to stderr, as `eprintln!` does: see [`tell`].
macro_rules! tell {
    ($($text:tt)*) => { $crate::text::write_err(format_args!($($text)*)) };
}
pub(crate) use tell;

/// Writes a line, or several, for people to stderr. Errors are ignored, as there is no place left to report them.
pub(crate) fn write_err(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "{}", PrintableLines(text));
}

/// Writes the beginning of a line that a person ends, to stderr.
pub(crate) fn prompt(text: &str) {
    let mut err = io::stderr().lock();
    let _ = write!(err, "{}", Printable(text)).and_then(|()| err.flush());
}

/// Writes what a program reads to a file, or to stdout for `-`.
pub(crate) fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    if path == Path::new("-") {
        // Pictures and tables are for other programs, and escape what is in them.
        return write_out(text);
    }
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Writes a file in one step: whoever finds it finds all of it, and a full disk or a power cut leaves the old one.
pub(crate) fn replace(path: &Path, text: &str) -> anyhow::Result<()> {
    let write = || {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        // The permissions are those of any other new file, less the user's mask.
        let mut builder = tempfile::Builder::new();
        builder.permissions(Permissions::from_mode(0o666));
        let mut file = builder.tempfile_in(folder.unwrap_or_else(|| Path::new(".")))?;
        file.write_all(text.as_bytes())?;
        file.persist(path).map(drop).map_err(|error| error.error)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned);
        let text = table("> ", &[row(["µ", "1", ""]), row(["left", "100", ""])]);
        assert_eq!(text, "> µ       1\n> left  100\n");
        assert_eq!(pairs("", &[("a", "1".into()), ("bcd", "2".into())]), "a    1\nbcd  2\n");
    }

    #[test]
    fn json_keeps_its_strings_and_shows_nothing_that_a_terminal_obeys() {
        let hostile = "\u{1b}[31m\u{9b}2J\u{202e}\u{7f}µ\n\"";
        let json = escaped_json(&serde_json::to_string_pretty(&[hostile]).unwrap());
        assert!(json.chars().all(|c| is_printable(c) || c == '\n'), "{json:?}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&json).unwrap(), [hostile]);
        assert!(json.contains('µ'), "{json}");
    }

    #[test]
    fn a_text_of_others_is_one_line() {
        assert_eq!(one_line(" a\n  b\tc\u{1b}[0m "), r"a b c\u{1b}[0m");
    }

    #[test]
    fn a_percentage_has_a_decimal_if_it_is_a_number() {
        assert_eq!(percent(0.98958), "99.0 %");
        assert_eq!(percent(f64::NAN), NOTHING);
    }
}
