//! Bytes on a command line: text with escapes.

/// A text with `\n`, `\r`, `\t`, `\\` and `\xNN` as the bytes that they stand for.
///
/// # Errors
/// Names the escape that stands for nothing.
pub(crate) fn unescaped(text: &str) -> Result<Vec<u8>, EscapeError> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('\\') {
        bytes.extend(&rest.as_bytes()[..start]);
        rest = &rest[start + 1..];
        let unknown = || EscapeError(rest.chars().take(3).collect());
        let (byte, length) = match rest.as_bytes().first() {
            Some(b'n') => (b'\n', 1),
            Some(b'r') => (b'\r', 1),
            Some(b't') => (b'\t', 1),
            Some(b'\\') => (b'\\', 1),
            Some(b'x') => {
                let digits =
                    rest.get(1..3).filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
                (digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()).ok_or_else(unknown)?, 3)
            }
            _ => return Err(unknown()),
        };
        bytes.push(byte);
        rest = &rest[length..];
    }
    bytes.extend(rest.as_bytes());
    Ok(bytes)
}

/// An escape that stands for no byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EscapeError(String);

impl std::fmt::Display for EscapeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`\\{}` is not an escape; there are \\n, \\r, \\t, \\\\ and \\xNN", self.0)
    }
}

impl std::error::Error for EscapeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_the_bytes_that_they_stand_for() {
        assert_eq!(unescaped("D,5,-5\\n").unwrap(), b"D,5,-5\n");
        assert_eq!(unescaped("\\x00\\xFF\\\\a\\r\\t").unwrap(), [0, 255, b'\\', b'a', b'\r', b'\t']);
        assert_eq!(unescaped("").unwrap(), b"");
        for (text, found) in [("a\\q", "q"), ("\\x4", "x4"), ("\\x+1", "x+1"), ("\\", ""), ("\\é", "é")] {
            assert_eq!(unescaped(text), Err(EscapeError(found.to_owned())), "{text}");
        }
    }
}
