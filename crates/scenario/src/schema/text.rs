//! What the documentation of a field says besides its meaning. It stands at the end of a doc comment, in this order:
//!
//! - ``Type: list of `[x, y]`.``, where JSON's words for types say too little;
//! - ``Default: half the period.``, where the default is not that of the code; also ``this or `other` ``, which says that one of them must be
//!   given, ``required with `other` ``, and ``required for `kind` ``;
//! - ``Range: only `uart`.``, where the type does not say it: what a number's rule says stands before it ([`super::range`]).

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// The documentation of a field.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Text {
    /// Its meaning.
    pub(super) meaning: String,
    /// Its type.
    pub(super) form: Option<String>,
    /// Its default, or when it is required.
    pub(super) default: Option<String>,
    /// Its range, and what it depends on.
    pub(super) range: Option<String>,
}

impl Text {
    /// The parts of a doc comment.
    pub(super) fn of(comment: &str) -> Self {
        let mut text =
            Self { meaning: comment.split_whitespace().collect::<Vec<_>>().join(" "), ..Self::default() };
        text.range = text.take(" Range: ");
        text.default = text.take(" Default: ");
        text.form = text.take(" Type: ");
        text
    }

    /// Takes what stands behind the last such mark.
    fn take(&mut self, mark: &str) -> Option<String> {
        let (before, behind) = self.meaning.rsplit_once(mark)?;
        let (before, behind) = (before.to_owned(), behind.strip_suffix('.').unwrap_or(behind).to_owned());
        self.meaning = before;
        Some(behind)
    }

    /// All of it, for people.
    pub(super) fn whole(&self) -> String {
        let mut whole = self.meaning.clone();
        for (mark, part) in [("Type", &self.form), ("Default", &self.default), ("Range", &self.range)] {
            if let Some(part) = part {
                whole += &format!(" {mark}: {part}.");
            }
        }
        whole
    }

    /// The names that stand in it behind these words: ``this or `a` ``, ``required for `a` and `b` ``.
    pub(super) fn named(text: Option<&String>, words: &str) -> Vec<String> {
        let Some((_, behind)) = text.and_then(|text| text.split_once(words)) else { return Vec::new() };
        let mut names = Vec::new();
        let mut rest = behind;
        while let Some((name, behind)) = rest.strip_prefix('`').and_then(|rest| rest.split_once('`')) {
            names.push(name.to_owned());
            let joint = [", ", " and ", " or "].into_iter().find_map(|joint| behind.strip_prefix(joint));
            rest = joint.unwrap_or("");
        }
        names
    }
}

/// Text of Markdown without the places that its links lead to.
pub(super) fn without_links(markdown: &str) -> String {
    let mut plain = String::new();
    let mut rest = markdown;
    while let Some((before, behind)) = rest.split_once("](") {
        let (text, start) = before.rsplit_once('[').map_or(("", before), |(start, text)| (text, start));
        plain += start;
        plain += text;
        rest = behind.split_once(')').map_or("", |(_, rest)| rest);
    }
    plain + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_has_parts() {
        let text =
            Text::of("How long\nit is lit. Type: list of `[x, y]`. Default: half. Range: 0 to 1; only `a`.");
        let part = |text: &str| Some(text.to_owned());
        let meaning = "How long it is lit.".to_owned();
        let (form, default, range) = (part("list of `[x, y]`"), part("half"), part("0 to 1; only `a`"));
        assert_eq!(text, Text { meaning, form, default, range });
        assert_eq!(Text::of("A name.").whole(), "A name.");
        let comment = "Seed. Default: 1. Range: 0 to 9.";
        assert_eq!(Text::of(comment).whole(), comment);
    }

    #[test]
    fn names_are_found() {
        let named = |text: &str, words| Text::named(Some(&text.to_owned()), words);
        assert_eq!(named("this or `a`", "this or "), ["a"]);
        assert_eq!(named("required for `a`, `b` and `c`; `d`", "required for "), ["a", "b", "c"]);
        assert_eq!(named("none", "this or "), [""; 0]);
    }

    #[test]
    fn links_leave_their_text() {
        let plain = without_links("see [names](#names), [`a`](b.md#c) and `[x, y]`");
        assert_eq!(plain, "see names, `a` and `[x, y]`");
    }
}
