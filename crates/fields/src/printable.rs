//! Texts of others as people may see them. A terminal obeys some characters in place of showing them: control characters,
//! with which escape sequences begin, and those that turn the direction of writing around.

use core::fmt::{self, Display, Write};

/// Whether a terminal only shows this character.
pub fn is_printable(c: char) -> bool {
    let turns =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let breaks = matches!(c, '\u{2028}' | '\u{2029}');
    !(c.is_control() || turns || breaks)
}

/// A text on one line: what a terminal would obey is shown as in a string of Rust, `\n` or `\u{1b}`.
#[derive(Clone, Copy, Debug)]
pub struct Printable<T>(pub T);

/// The same of a text of several lines, which stay, as do its tabs.
#[derive(Clone, Copy, Debug)]
pub struct PrintableLines<T>(pub T);

impl<T: Display> Display for Printable<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaped { out: f, keeps: "" }, "{}", self.0)
    }
}

impl<T: Display> Display for PrintableLines<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaped { out: f, keeps: "\n\t" }, "{}", self.0)
    }
}

struct Escaped<'a, 'b> {
    out: &'a mut fmt::Formatter<'b>,
    keeps: &'static str,
}

impl Write for Escaped<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let obeyed = |c: char| !is_printable(c) && !self.keeps.contains(c);
        let mut rest = text;
        while let Some((at, c)) = rest.char_indices().find(|(_, c)| obeyed(*c)) {
            write!(self.out, "{}{}", &rest[..at], c.escape_default())?;
            rest = &rest[at + c.len_utf8()..];
        }
        self.out.write_str(rest)
    }
}

#[cfg(test)]
mod tests {
    use alloc::format;
    use alloc::string::ToString;

    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown() {
        let text = "\u{1b}[31mred\u{9b}2J\u{7}\r\n\tµ — 移动 \u{202e}txt.exe\u{2069}\u{7f}";
        let expected = r"\u{1b}[31mred\u{9b}2J\u{7}\r\n\tµ — 移动 \u{202e}txt.exe\u{2069}\u{7f}";
        assert_eq!(Printable(text).to_string(), expected);
        assert_eq!(PrintableLines("a\n\tb\r\n\u{1b}c").to_string(), "a\n\tb\\r\n\\u{1b}c");
    }

    #[test]
    fn nothing_that_is_obeyed_is_left_of_any_character() {
        for c in '\0'..=char::MAX {
            let (line, lines) = (format!("{}", Printable(c)), format!("{}", PrintableLines(c)));
            assert!(line.chars().all(is_printable), "{c:?}");
            assert!(lines.chars().all(|c| is_printable(c) || c == '\n' || c == '\t'), "{c:?}");
            assert!(is_printable(c) == (line == c.to_string()), "{c:?}");
        }
    }
}
