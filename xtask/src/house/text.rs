//! Rust code as a text: without comments and strings, without what only tests use, by words and by brackets.

/// The code with its comments gone and its strings empty; lines stay where they are.
pub(super) fn bare(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut kept = String::with_capacity(text.len());
    let mut at = 0;
    while at < bytes.len() {
        let (end, instead) = token(text, at);
        match instead {
            None => kept.push_str(&text[at..end]),
            Some(instead) => {
                kept.push_str(instead);
                kept.extend(text[at..end].chars().filter(|&character| character == '\n'));
            }
        }
        at = end;
    }
    kept
}

/// A comment of one line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comment<'a> {
    line: usize,
    /// Whether it stands on its line without code.
    is_alone: bool,
    /// `///`, `//!` or `//`.
    marker: &'a str,
    /// The words behind the marker.
    pub(super) text: &'a str,
}

impl Comment<'_> {
    /// Whether it goes on right below another, as a further line of the same kind.
    pub(super) fn continues(self, above: Self) -> bool {
        self.is_alone && above.is_alone && self.line == above.line + 1 && self.marker == above.marker
    }
}

/// The comments that a line's end closes, in turn.
pub(super) fn comments(text: &str) -> Vec<Comment<'_>> {
    let (mut found, mut at, mut line) = (Vec::new(), 0, 0);
    while at < text.len() {
        let (end, _) = token(text, at);
        let token = &text[at..end];
        if token.starts_with("//") {
            let marker = ["///", "//!"].into_iter().find(|marker| token.starts_with(marker)).unwrap_or("//");
            let before = text[..at].rsplit('\n').next().unwrap_or_default();
            let is_alone = before.trim().is_empty();
            found.push(Comment { line, is_alone, marker, text: &token[marker.len()..] });
        }
        line += token.matches('\n').count();
        at = end;
    }
    found
}

/// The number of lines that have more than blanks.
pub(super) fn code_lines(code: &str) -> usize {
    code.lines().filter(|line| !line.trim().is_empty()).count()
}

/// The code without what only tests use, and that.
pub(super) fn apart(code: &str) -> (String, String) {
    let (mut kept, mut tests, mut at) = (String::new(), String::new(), 0);
    let mut searched = 0;
    while let Some(found) = code[searched..].find("#[") {
        let start = searched + found;
        if !is_for_tests(inside(code, start + 1)) {
            searched = start + 2;
            continue;
        }
        let end = item_end(code, attributes_end(code, start));
        kept.push_str(&code[at..start]);
        tests.push_str(&code[start..end]);
        tests.push('\n');
        (at, searched) = (end, end);
    }
    kept.push_str(&code[at..]);
    (kept, tests)
}

/// A word of the code: a name, a keyword or a number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) text: &'a str,
}

/// The words of bare code in turn.
pub(super) fn words(code: &str) -> impl Iterator<Item = Word<'_>> {
    let bytes = code.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + bytes[at..].iter().position(|&byte| is_of_word(byte))?;
        at = word_end(bytes, start);
        Some(Word { start, end: at, text: &code[start..at] })
    })
}

/// The bytes from a place on that no bracket of these pairs encloses, with their places. A bracket that closes what was
/// opened before that place is among them.
pub(super) fn outside(code: &str, at: usize, pairs: &str) -> impl Iterator<Item = (usize, u8)> {
    let mut depth = 0_usize;
    let mut previous = b' ';
    code.bytes().enumerate().skip(at).filter(move |&(_, byte)| {
        let is_arrow = byte == b'>' && matches!(previous, b'-' | b'=');
        previous = byte;
        match pairs.bytes().position(|bracket| bracket == byte) {
            Some(opens) if opens.is_multiple_of(2) => {
                depth += 1;
                false
            }
            Some(_) if depth > 0 && !is_arrow => {
                depth -= 1;
                false
            }
            Some(_) | None => depth == 0,
        }
    })
}

/// Parts between commas that no bracket encloses, without blanks around them; none is empty.
pub(super) fn parts(list: &str) -> Vec<&str> {
    let commas = outside(list, 0, "()[]{}<>").filter(|&(_, byte)| byte == b',').map(|(at, _)| at);
    let mut start = 0;
    let mut found = Vec::new();
    for end in commas.chain([list.len()]) {
        found.push(list[start..end].trim());
        start = end + 1;
    }
    found.retain(|part| !part.is_empty());
    found
}

/// Behind the bracket that closes the one at this place.
pub(super) fn group_end(code: &str, at: usize) -> usize {
    let pair = match code.as_bytes()[at] {
        b'(' => "()",
        b'[' => "[]",
        b'<' => "<>",
        _ => "{}",
    };
    let closing = outside(code, at + 1, pair).find(|&(_, byte)| byte == pair.as_bytes()[1]);
    closing.map_or(code.len(), |(at, _)| at + 1)
}

/// The text between the bracket at this place and the one that closes it.
pub(super) fn inside(code: &str, at: usize) -> &str {
    let group = &code[at + 1..group_end(code, at)];
    group.strip_suffix([')', ']', '>', '}']).unwrap_or(group)
}

/// The end of the token that begins here, and its replacement if it is a comment or has text in it.
fn token(text: &str, at: usize) -> (usize, Option<&'static str>) {
    let bytes = text.as_bytes();
    let rest = &text[at..];
    if rest.starts_with("//") {
        return (rest.find('\n').map_or(text.len(), |length| at + length), Some(""));
    }
    if rest.starts_with("/*") {
        // Two words with a comment between them stay two words.
        return (block_comment_end(bytes, at), Some(" "));
    }
    match bytes[at] {
        b'"' => (string_end(bytes, at + 1), Some("\"\"")),
        b'\'' => char_end(text, at).map_or((at + 1, None), |end| (end, Some("''"))),
        byte if is_of_word(byte) => {
            let end = word_end(bytes, at);
            let is_raw = matches!(&text[at..end], "r" | "br" | "cr");
            let string = if is_raw { raw_string_end(text, end) } else { None };
            string.map_or((end, None), |end| (end, Some("\"\"")))
        }
        _ => (at + 1, None),
    }
}

/// Comments may stand in each other.
fn block_comment_end(bytes: &[u8], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0_usize);
    while at < bytes.len() {
        if bytes[at..].starts_with(b"/*") {
            depth += 1;
            at += 2;
        } else if bytes[at..].starts_with(b"*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    bytes.len()
}

/// The end of the string whose quote is right before this place.
fn string_end(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// The end of the raw string whose hashes and quote begin here, right behind its `r`; `r#type` is a name.
fn raw_string_end(text: &str, at: usize) -> Option<usize> {
    let opening = &text[at..];
    let behind = opening.trim_start_matches('#');
    let hashes = &opening[..opening.len() - behind.len()];
    let content = behind.strip_prefix('"')?;
    let start = text.len() - content.len();
    let length = content.find(&format!("\"{hashes}"));
    Some(length.map_or(text.len(), |length| start + length + 1 + hashes.len()))
}

/// The end of the character whose quote is at this place, unless it is a lifetime.
fn char_end(text: &str, quote: usize) -> Option<usize> {
    let start = quote + 1;
    let first = text[start..].chars().next()?;
    if first == '\\' {
        let escaped = text[start + 1..].chars().next()?;
        let behind = start + 1 + escaped.len_utf8();
        return text[behind..].find('\'').map(|length| behind + length + 1);
    }
    let behind = start + first.len_utf8();
    let is_char = !matches!(first, '\'' | '\n') && text[behind..].starts_with('\'');
    is_char.then_some(behind + 1)
}

/// Letters beyond ASCII are in no bare code but in names.
fn is_of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || !byte.is_ascii()
}

fn word_end(bytes: &[u8], start: usize) -> usize {
    bytes[start..].iter().position(|&byte| !is_of_word(byte)).map_or(bytes.len(), |length| start + length)
}

/// Whether an attribute leaves its item to tests: `cfg(test)` or `cfg(all(test, …))`, but not `cfg(any(test, …))`.
fn is_for_tests(attribute: &str) -> bool {
    let attribute: String = attribute.split_whitespace().collect();
    let all = attribute.strip_prefix("cfg(all(").and_then(|rest| rest.strip_suffix("))"));
    attribute == "cfg(test)" || all.is_some_and(|all| parts(all).contains(&"test"))
}

/// The end of the attributes the first of which begins here.
fn attributes_end(code: &str, mut at: usize) -> usize {
    while code[at..].starts_with("#[") {
        let end = group_end(code, at + 1);
        at = end + code[end..].len() - code[end..].trim_start().len();
    }
    at
}

/// The token that ends an item.
enum Ending {
    /// With a semicolon; braces may come before it.
    Semicolon,
    /// With the braces of its body, or a semicolon instead.
    Body,
    /// As a field, a variant, an arm or a statement: with a comma, a semicolon, braces, or where they all end.
    Comma,
}

/// The end of the item that begins here.
fn item_end(code: &str, at: usize) -> usize {
    let found = match ending(&code[at..]) {
        Ending::Semicolon => outside(code, at, "()[]{}").find(|&(_, byte)| byte == b';'),
        Ending::Body => outside(code, at, "()[]").find(|&(_, byte)| matches!(byte, b';' | b'{')),
        Ending::Comma => outside(code, at, "()[]<>")
            .chain(outside(code, at, "()[]"))
            .find(|(_, byte)| b",;{}])".contains(byte)),
    };
    match found {
        None => code.len(),
        Some((stop, b'{')) => {
            let end = group_end(code, stop);
            // The comma behind a variant's or an arm's braces.
            end + usize::from(code[end..].starts_with(','))
        }
        // The line on which they all end is not the item's.
        Some((stop, b'}' | b']' | b')')) => at + code[at..stop].trim_end().len(),
        Some((stop, _)) => stop + 1,
    }
}

fn ending(item: &str) -> Ending {
    let mut words = words(item)
        .map(|word| word.text)
        .skip_while(|word| matches!(*word, "pub" | "crate" | "super" | "in"));
    match (words.next().unwrap_or_default(), words.next().unwrap_or_default()) {
        ("const", "fn" | "async" | "unsafe" | "extern") => Ending::Body,
        ("const" | "let" | "static" | "type" | "use", _) => Ending::Semicolon,
        ("async" | "enum" | "extern" | "fn" | "impl" | "mod" | "struct" | "trait" | "unsafe", _) => {
            Ending::Body
        }
        _ => Ending::Comma,
    }
}
