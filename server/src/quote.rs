//! Quotations in error texts. A status travels in a header of HTTP/2, which has little room.

use baudbot_fields::printable::Printable;

/// Longest quotation, in characters.
const MAX_QUOTED: usize = 1000;

/// Most names in a list.
const MAX_NAMES: usize = 20;

/// The text of a caller, on one line, with escapes for all that a terminal would obey; cut if it is long.
pub(crate) fn brief(text: &str) -> String {
    let (from, is_cut) = beginning(text);
    cut(&format!("{}{}", Printable(from), if is_cut { "…" } else { "" }))
}

/// A text of ours, whose quotations are [`brief`] or escaped already; cut if it is long.
pub(crate) fn cut(text: &str) -> String {
    let (from, is_cut) = beginning(text);
    format!("{from}{}", if is_cut { "…" } else { "" })
}

/// The part of a text that is quoted, and whether there is more.
fn beginning(text: &str) -> (&str, bool) {
    // The sign that it was cut is one more.
    match text.char_indices().nth(MAX_QUOTED) {
        Some((end, '…')) if end + '…'.len_utf8() == text.len() => (text, false),
        Some((end, _)) => (&text[..end], true),
        None => (text, false),
    }
}

/// A list of names, cut if it is long.
pub(crate) fn list<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let more = names.len().saturating_sub(MAX_NAMES);
    let shown: Vec<String> = names.take(MAX_NAMES).map(brief).collect();
    match (shown.is_empty(), more) {
        (true, _) => "none".to_owned(),
        (false, 0) => shown.join(", "),
        (false, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_and_lists_are_cut() {
        assert_eq!(brief("abc"), "abc");
        assert_eq!(brief("a\u{1b}[31m\u{7}\u{202e}\nb"), r"a\u{1b}[31m\u{7}\u{202e}\nb");
        assert_eq!(cut("a\n  b"), "a\n  b");
        assert_eq!(brief(&"ä".repeat(2000)).chars().count(), MAX_QUOTED + 1);
        assert_eq!(list([].into_iter()), "none");
        assert_eq!(list(["a", "b"].into_iter()), "a, b");
        let many: Vec<String> = (0..3000).map(|i| format!("r{i}")).collect();
        assert!(list(many.iter().map(String::as_str)).ends_with("r19 and 2980 more"));
    }
}
