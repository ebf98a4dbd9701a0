//! The fault of a value, in words of TOML and not of Rust: serde says `expected u64`, a file has whole numbers.

use alloc::borrow::{Cow, ToOwned};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use serde::de::{Expected, Unexpected};

use crate::nearest::{edits, nearest};

/// A value of another type, or one that its type does not have.
pub(crate) fn wrong(found: &Unexpected<'_>, expected: &dyn Expected) -> String {
    format!("must be {}, is {}", wanted(&expected.to_string()), given(found))
}

/// A list that is too long or too short.
pub(crate) fn wrong_length(found: usize, expected: usize) -> String {
    format!("must have {expected} elements, has {found}")
}

/// A name that is none of those that there are.
pub(crate) fn unknown(name: &str, known: &[&str]) -> String {
    let names: Vec<_> = known.iter().map(|name| format!("`{name}`")).collect();
    let meant = meant(name, known);
    match names.as_slice() {
        [] => format!("there is no `{name}` here"),
        [one] => format!("must be {one}, is `{name}`"),
        [one, other] => format!("must be {one} or {other}, is `{name}`"),
        _ => format!("must be one of {}, is `{name}`{meant}", names.join(", ")),
    }
}

/// A suggestion for a name that is none of the known ones.
pub(crate) fn meant(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter(), |known| known).as_slice() {
        [one] if known.len() > 2 && is_near(name, one) => format!("; did you mean `{one}`?"),
        _ => String::new(),
    }
}

/// Whether a name may be another one, misspelt. There are so many fields that some share half the letters of any name.
fn is_near(name: &str, other: &str) -> bool {
    let letters: Vec<char> = name.chars().collect();
    other.contains(name) || edits(&letters, other) <= letters.len().div_ceil(3)
}

/// The name of a type in a file.
fn wanted(expected: &str) -> Cow<'_, str> {
    let text = match expected {
        "f64" | "f32" => "a number",
        "u64" | "usize" => "a whole number of 0 or more",
        "u32" => "a whole number from 0 to 4294967295",
        "u16" => "a whole number from 0 to 65535",
        "u8" => "a whole number from 0 to 255",
        "i64" | "i32" | "i16" | "i8" | "isize" => "a whole number",
        "a boolean" => "true or false",
        "string only" => "a string",
        "a sequence" => "a list",
        "a map" => "a table",
        _ if expected.starts_with("struct ") => "a table",
        _ => {
            return expected
                .strip_prefix("an array of length ")
                .map_or(Cow::Borrowed(expected), |length| Cow::Owned(format!("a list of {length}")));
        }
    };
    Cow::Borrowed(text)
}

/// A value as it stands in a file, if it is short.
fn given(found: &Unexpected<'_>) -> String {
    match found {
        Unexpected::Bool(value) => value.to_string(),
        Unexpected::Unsigned(value) => value.to_string(),
        Unexpected::Signed(value) => value.to_string(),
        Unexpected::Float(value) => format!("{value:?}"),
        Unexpected::Str(text) => format!("{text:?}"),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "a table".to_owned(),
        // The last one alone can come from a reader of TOML.
        Unexpected::Char(_)
        | Unexpected::Bytes(_)
        | Unexpected::Unit
        | Unexpected::Option
        | Unexpected::NewtypeStruct
        | Unexpected::Enum
        | Unexpected::UnitVariant
        | Unexpected::NewtypeVariant
        | Unexpected::TupleVariant
        | Unexpected::StructVariant
        | Unexpected::Other(_) => found.to_string(),
    }
}
