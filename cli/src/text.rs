//! Text in columns, and quantities for people.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;

/// Rows of cells as lines, each column as wide as its widest cell: the first to the left, the others to the
/// right.
pub(crate) fn table<const N: usize>(indent: &str, rows: &[[String; N]]) -> String {
    let width = |i: usize| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let mut line = indent.to_owned();
        for (i, cell) in row.iter().enumerate() {
            match i {
                0 => line += &format!("{cell:<w$}", w = widths[0]),
                _ => line += &format!("  {cell:>w$}", w = widths[i]),
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
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

/// Nanoseconds in the unit in which they are a handy number.
pub(crate) fn duration(ns: f64) -> String {
    match ns.abs() {
        size if size < 1e3 => format!("{ns:.0} ns"),
        size if size < 1e6 => format!("{} µs", handy(ns / 1e3)),
        size if size < 1e9 => format!("{} ms", handy(ns / 1e6)),
        _ => format!("{} s", handy(ns / 1e9)),
    }
}

/// At most three decimals, and no zeros at their end.
pub(crate) fn handy(number: f64) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// So many of something.
pub(crate) fn count(number: usize, one: &str) -> String {
    format!("{number} {one}{}", if number == 1 { "" } else { "s" })
}

/// Writes to stdout; a reader that is gone is an error, no panic.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to stdout")
}

/// Writes to a file, or to stdout for `-`.
pub(crate) fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    if path == Path::new("-") {
        return print(text);
    }
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// What stands where there is no number.
pub(crate) const NOTHING: &str = "—";

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
    fn quantities() {
        assert_eq!(duration(999.0), "999 ns");
        assert_eq!(duration(20e6), "20 ms");
        assert_eq!(duration(19_791_667.0), "19.792 ms");
        assert_eq!(duration(-1_500.0), "-1.5 µs");
        assert_eq!(percent(0.98958), "99.0 %");
        assert_eq!(percent(f64::NAN), NOTHING);
        assert_eq!(count(1, "turn") + &count(0, "turn"), "1 turn0 turns");
    }
}
