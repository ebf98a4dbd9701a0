//! From the words of a range to the keywords of a schema.
//!
//! A range has clauses between `;` and `,`. Those that are understood become keywords, the others are for people:
//!
//! | clause | of | keywords |
//! |---|---|---|
//! | `0 to 10^6`, `at least 1`, `at most 1`, `above 0`, `positive`, `not negative`, `8, 10 or 11` | a number | its bounds |
//! | `3 to 4096 points` | a list | how many there are |
//! | `each 0 to 1` | a list | bounds of all numbers in it |
//! | `shares 0 to 1` | a list of `[current, share]` | bounds of these |
//! | `see [names](#names)`, `1 to 40 letters, digits, …` | a string | a pattern |

use core::f64::consts::PI;

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use serde_json::{Map, Value, json};

use super::text::Text;

/// What lists have a number of.
const COUNTED: [&str; 8] = ["point", "points", "distances", "angles", "bytes", "robots", "faults", "outages"];

/// Puts into the schema of a value what its range says.
pub(super) fn apply(node: &mut Map<String, Value>, text: &Text) {
    let Some(range) = &text.range else { return };
    for part in range.split("; ") {
        if let Some(numbers) = choice(part).filter(|_| is_number(node)) {
            node.insert("enum".into(), numbers.into());
            continue;
        }
        if let Some(length) = length_of_name(part).filter(|_| node.get("type") == Some(&json!("string"))) {
            node.insert("pattern".into(), format!("^[A-Za-z0-9_-]{{1,{length}}}$").into());
            continue;
        }
        part.split(", ").for_each(|clause| apply_clause(node, clause, text.form.as_deref()));
    }
}

fn apply_clause(node: &mut Map<String, Value>, clause: &str, form: Option<&str>) {
    if is_number(node) {
        bounds(clause).into_iter().for_each(|(keyword, bound)| set(node, keyword, bound));
        return;
    }
    let Some((first, rest)) = clause.split_once(' ') else { return };
    if let Some((span, noun)) = clause.rsplit_once(' ')
        && COUNTED.contains(&noun)
    {
        number_of_items(node, span);
    } else if first == "each" {
        each_number(node, &bounds(rest));
    } else if let Some(place) = place(form, first) {
        of_place(node, place, &bounds(rest));
    }
}

/// Sets bounds of the numbers in this place of each pair in a list.
fn of_place(node: &mut Map<String, Value>, place: usize, of_each: &[(&'static str, f64)]) {
    let Some(items) = node.get_mut("items").and_then(|pairs| pairs.get_mut("items")) else { return };
    if items.is_object() {
        *items = [items.clone(), items.clone()].into_iter().collect();
    }
    if let Some(Value::Object(number)) = items.get_mut(place) {
        of_each.iter().for_each(|(keyword, bound)| set(number, keyword, *bound));
    }
}

fn is_number(node: &Map<String, Value>) -> bool {
    matches!(node.get("type").and_then(Value::as_str), Some("number" | "integer"))
}

fn number_of_items(node: &mut Map<String, Value>, span: &str) {
    let of_span = bounds(span);
    for (keyword, bound) in &of_span {
        let items = if *keyword == "minimum" { "minItems" } else { "maxItems" };
        set(node, items, *bound);
    }
    if let Some(exactly) = number(span).filter(|_| of_span.is_empty()) {
        set(node, "minItems", exactly);
        set(node, "maxItems", exactly);
    }
}

/// Sets bounds of all numbers in lists.
fn each_number(node: &mut Map<String, Value>, of_each: &[(&'static str, f64)]) {
    if is_number(node) {
        of_each.iter().for_each(|(keyword, bound)| set(node, keyword, *bound));
    }
    match node.get_mut("items") {
        Some(Value::Object(items)) => each_number(items, of_each),
        Some(Value::Array(items)) => {
            items.iter_mut().filter_map(Value::as_object_mut).for_each(|item| each_number(item, of_each));
        }
        _ => {}
    }
}

/// Where this is in a list of `[current, share]`; `shares` are in place 1.
fn place(form: Option<&str>, name: &str) -> Option<usize> {
    let (_, names) = form?.split_once('[')?;
    let mut names = names.split_once(']')?.0.split(", ");
    names.position(|other| name == other || name.strip_suffix('s') == Some(other))
}

/// A bound as a whole number, if it is one.
fn set(node: &mut Map<String, Value>, keyword: &str, bound: f64) {
    let is_whole = bound == bound as i64 as f64;
    node.insert(keyword.into(), if is_whole { json!(bound as i64) } else { json!(bound) });
}

/// The bounds that a clause gives a number; none if it does not.
fn bounds(clause: &str) -> Vec<(&'static str, f64)> {
    let one =
        |keyword, words: &str| clause.strip_prefix(words).and_then(number).map(|bound| (keyword, bound));
    match clause {
        "positive" => return alloc::vec![("exclusiveMinimum", 0.0)],
        "not negative" => return alloc::vec![("minimum", 0.0)],
        _ => {}
    }
    if let Some((least, most)) = clause.split_once(" to ") {
        // What depends on another field is in backticks, and is no bound here; nor is what only one kind has.
        if least.starts_with('`') && !least.ends_with('`') {
            return Vec::new();
        }
        let least = number(least).map(|least| ("minimum", least));
        return least.into_iter().chain(number(most).map(|most| ("maximum", most))).collect();
    }
    let ways = [one("exclusiveMinimum", "above "), one("minimum", "at least "), one("maximum", "at most ")];
    ways.into_iter().flatten().collect()
}

/// The numbers of `8, 10 or 11`.
fn choice(part: &str) -> Option<Vec<Value>> {
    let (before, last) = part.rsplit_once(" or ")?;
    let numbers = before.split(", ").chain([last]).map(|one| one.parse::<i64>().ok().map(Value::from));
    numbers.collect()
}

/// How long a name may be.
fn length_of_name(part: &str) -> Option<u32> {
    if part == "see [names](#names)" {
        return Some(64);
    }
    part.strip_prefix("1 to ")?.strip_suffix(" letters, digits, `_` or `-`")?.parse().ok()
}

/// A number as people write it: `10^−6`, `−2π`, `16 × 10^6`, `2^32 − 1`, `10,000`.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.replace('−', "-").replace(',', "");
    if let Some((one, other)) = text.split_once(" - ") {
        return Some(number(one)? - number(other)?);
    }
    if let Some((one, other)) = text.split_once(" × ") {
        return Some(number(one)? * number(other)?);
    }
    if let Some(positive) = text.strip_prefix('-') {
        return number(positive).map(|number| -number);
    }
    if let Some(exponent) = text.strip_prefix("10^") {
        return format!("1e{exponent}").parse().ok();
    }
    if let Some(exponent) = text.strip_prefix("2^") {
        return exponent
            .parse()
            .ok()
            .filter(|exponent| *exponent < 53)
            .map(|exponent: u32| (1_u64 << exponent) as f64);
    }
    match &*text {
        "π" => Some(PI),
        "2π" => Some(2.0 * PI),
        "π/2" => Some(0.5 * PI),
        _ if text.starts_with(|c: char| c.is_ascii_digit()) => text.to_owned().parse().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schema(node: Value, form: &str, range: &str) -> Value {
        let Value::Object(mut node) = node else { panic!("no object") };
        let text = Text { form: Some(form.to_owned()), range: Some(range.to_owned()), ..Text::default() };
        apply(&mut node, &text);
        Value::Object(node)
    }

    #[test]
    fn numbers_are_read_as_they_are_written() {
        let numbers = ["10^−6", "−2π", "16 × 10^6", "2^32 − 1", "10,000", "0.125", "π/2", "-3"].map(number);
        let expected = [1e-6, -2.0 * PI, 16e6, 4_294_967_295.0, 1e4, 0.125, 0.5 * PI, -3.0];
        assert_eq!(numbers, expected.map(Some));
        assert_eq!(["`max_m`", "2^63", "0.9 periods", "one period"].map(number), [None; 4]);
    }

    #[test]
    fn bounds_of_a_number() {
        let of = |range| schema(json!({ "type": "number" }), "", range);
        let both = json!({ "type": "number", "minimum": 0, "maximum": 0.5 });
        assert_eq!(of("0 to 0.5; only `uart`"), both);
        assert_eq!(
            of("above 0, at most 1"),
            json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1 })
        );
        assert_eq!(of("positive; required with `bits`"), json!({ "type": "number", "exclusiveMinimum": 0 }));
        assert_eq!(of("0 to `max_m`"), json!({ "type": "number", "minimum": 0 }));
        assert_eq!(of("8, 10 or 11; only `uart`"), json!({ "type": "number", "enum": [8, 10, 11] }));
        assert_eq!(of("`max_m` to 9"), json!({ "type": "number", "maximum": 9 }));
        assert_eq!(of("`ftdi` 1 to 255"), json!({ "type": "number" }));
    }

    #[test]
    fn bounds_in_a_list() {
        let number = json!({ "type": "number" });
        let pairs = json!({ "type": "array", "items": { "type": "array", "items": [number, number] } });
        let found = schema(
            pairs,
            "list of `[current, share]`",
            "2 to 9 points; currents 0 to 5, increasing; shares not negative",
        );
        let current = json!({ "type": "number", "minimum": 0, "maximum": 5 });
        let share = json!({ "type": "number", "minimum": 0 });
        let items = json!({ "type": "array", "items": [current, share] });
        assert_eq!(found, json!({ "type": "array", "minItems": 2, "maxItems": 9, "items": items }));
        let pairs = json!({ "type": "array", "items": { "type": "array", "items": number } });
        let found = schema(pairs, "list of `[current, share]`", "currents 0 to 5; shares not negative");
        assert_eq!(found, json!({ "type": "array", "items": items }));
        let list = json!({ "type": "array", "items": number });
        let each = json!({ "type": "number", "minimum": 0, "maximum": 255 });
        let expected = json!({ "type": "array", "minItems": 3, "maxItems": 3, "items": each });
        assert_eq!(schema(list, "", "3 bytes, each 0 to 255"), expected);
    }
}
