//! The bounds of a number, which are part of its type ([`baudbot_fields::number`]), in words; and numbers that are written in words.

use core::f64::consts::PI;

use alloc::format;
use alloc::string::String;

use serde_json::{Map, Value, json};

/// That the bounds of a number are those of a rule, and not of a type of Rust.
pub(super) const RULE: &str = "x-rule";

/// The whole range of a number: what its rule says, before what the comment says. A comment that starts with `to` is the greatest bound,
/// where that is another field's. The mark of the rule is taken away.
pub(super) fn whole(node: &mut Map<String, Value>, comment: Option<String>) -> Option<String> {
    if node.remove(RULE).is_none() {
        return comment;
    }
    match (comment, node.get("minimum").and_then(Value::as_f64)) {
        (None, _) => words(node),
        (Some(most), Some(least)) if most.starts_with("to ") => {
            Some(format!("{} {most}", in_words(least, true)))
        }
        (Some(more), _) => words(node).map(|rule| format!("{rule}; {more}")),
    }
}

/// What a rule says of a number, in words.
fn words(node: &Map<String, Value>) -> Option<String> {
    let is_whole = node.get("type") == Some(&json!("integer"));
    let bound = |keyword| node.get(keyword).and_then(Value::as_f64).map(|bound| in_words(bound, is_whole));
    Some(match (bound("exclusiveMinimum"), bound("minimum"), bound("maximum")) {
        (Some(_), _, None) => "positive".into(),
        (Some(_), _, Some(most)) => format!("above 0, at most {most}"),
        (None, Some(least), Some(most)) => format!("{least} to {most}"),
        (None, Some(least), None) if least == "0" => "not negative".into(),
        (None, Some(least), None) => format!("at least {least}"),
        (None, None, most) => format!("at most {}", most?),
    })
}

/// A bound as people write it: `10^−6`, `−2π`, `10,000`.
fn in_words(bound: f64, is_whole: bool) -> String {
    if bound < 0.0 {
        return format!("−{}", in_words(-bound, is_whole));
    }
    for (turns, words) in [(PI, "π"), (2.0 * PI, "2π")] {
        if bound == turns {
            return words.into();
        }
    }
    let power = format!("{bound:e}");
    match power.strip_prefix("1e") {
        Some(exponent) if !is_whole && bound >= 1e4 || bound <= 1e-4 => {
            format!("10^{}", exponent.replace('-', "−"))
        }
        _ if bound == f64::from(u32::MAX) => "2^32 − 1".into(),
        _ => grouped(&format!("{bound}")),
    }
}

/// Long whole numbers with commas.
pub(super) fn grouped(digits: &str) -> String {
    if digits.len() < 5 || digits.contains(['.', 'e']) {
        return digits.into();
    }
    let mut groups = String::new();
    for (i, digit) in digits.chars().enumerate() {
        let is_start = i > 0 && (digits.len() - i).is_multiple_of(3);
        groups.extend(is_start.then_some(',').into_iter().chain([digit]));
    }
    groups
}

/// A number as people write it: `16 × 10^6`, `10,000`.
pub(super) fn number(text: &str) -> Option<f64> {
    if let Some((one, other)) = text.split_once(" × ") {
        return Some(number(one)? * number(other)?);
    }
    let plain = text.replace(',', "").replacen("10^", "1e", 1);
    plain.parse().ok().filter(|_| plain.starts_with(|c: char| c.is_ascii_digit()))
}

/// The pattern of a name, of which a range says what it may be.
pub(super) fn pattern(range: &str) -> Option<String> {
    let first = range.split("; ").next()?;
    let length = match first {
        "see [names](#names)" => "64",
        _ => first.strip_prefix("1 to ")?.strip_suffix(" letters, digits, `_` or `-`")?,
    };
    Some(format!("^[A-Za-z0-9_-]{{1,{length}}}$"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_they_are_written() {
        let numbers = ["16 × 10^6", "10,000", "0.125", "10^7"].map(number);
        assert_eq!(numbers, [16e6, 1e4, 0.125, 1e7].map(Some));
        assert_eq!(["`max_m`", "2^63", "half the period", "inf"].map(number), [None; 4]);
    }

    #[test]
    fn bounds_are_told_as_people_write_them() {
        let told = |node: Value| {
            let Value::Object(mut node) = node else { panic!("no object") };
            node.insert(RULE.into(), true.into());
            whole(&mut node, None)
        };
        let number = |bounds: Value| {
            let mut node = json!({ "type": "number" });
            node.as_object_mut().unwrap().extend(bounds.as_object().unwrap().clone());
            told(node).unwrap()
        };
        assert_eq!(number(json!({ "exclusiveMinimum": 0 })), "positive");
        assert_eq!(number(json!({ "exclusiveMinimum": 0, "maximum": 1e9 })), "above 0, at most 10^9");
        assert_eq!(number(json!({ "minimum": 0 })), "not negative");
        assert_eq!(number(json!({ "minimum": 1e-6, "maximum": 1000 })), "10^−6 to 1000");
        assert_eq!(number(json!({ "minimum": -2.0 * PI, "maximum": PI })), "−2π to π");
        assert_eq!(number(json!({ "minimum": 32_000, "maximum": 1e4 })), "32,000 to 10^4");
        let bounded = json!({ "type": "integer", "minimum": 1, "maximum": 1_048_576 });
        assert_eq!(told(bounded).unwrap(), "1 to 1,048,576");
        let least = json!({ "type": "integer", "minimum": 1, RULE: true });
        let with =
            |comment: &str| whole(&mut least.as_object().unwrap().clone(), Some(comment.into())).unwrap();
        assert_eq!(with("only `uart`"), "at least 1; only `uart`");
        assert_eq!(with("to `bits`; with `bits`"), "1 to `bits`; with `bits`");
    }
}
