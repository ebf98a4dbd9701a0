//! Suggestions of names that a user may have meant, in words.

use std::fmt;

use baudbot_brains::catalogue::nearest_first;
use baudbot_fields::Cause;

/// There is no thing of this name. The message has those that exist, the nearest first.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct UnknownName {
    kind: &'static str,
    name: String,
    known: Vec<String>,
}

impl UnknownName {
    /// `kind` is what it is a name of, in words.
    pub fn new(kind: &'static str, name: &str, known: &[&str]) -> Self {
        let known = known.iter().copied().map(str::to_owned).collect();
        Self { kind, name: name.to_owned(), known }
    }

    /// The name that is not there.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name that is not there, if that is what is wrong.
    pub fn of(cause: &Cause) -> Option<Self> {
        match cause {
            Cause::UnknownField { name, known } => Some(Self::new("field", name, known)),
            Cause::UnknownElement { name, known } => {
                Some(Self { kind: "element", name: name.as_ref().into(), known: known.to_vec() })
            }
            Cause::Value | Cause::MissingField | Cause::NoTable => None,
        }
    }
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name: String = self.name.chars().take(MAX_CHARACTERS).collect();
        write!(f, "there is no {} `{name}`", self.kind)?;
        let known = nearest_first(&name, self.known.iter().map(String::as_str));
        match known.split_first() {
            None => write!(f, ", and there is none at all"),
            Some((nearest, [])) => write!(f, "; there is only `{nearest}`"),
            Some((nearest, others)) => {
                let more = if others.len() > MAX_NAMES { ", …" } else { "" };
                let others = others[..others.len().min(MAX_NAMES)].join(", ");
                write!(f, "; did you mean `{nearest}`? Others: {others}{more}")
            }
        }
    }
}

/// Most names that are listed besides the nearest.
const MAX_NAMES: usize = 12;

/// Longest name that is listed, in characters.
const MAX_CHARACTERS: usize = 80;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first() {
        let field = |name: &str, known: &[&'static str]| {
            let cause = Cause::UnknownField { name: name.into(), known: known.into() };
            UnknownName::of(&cause).unwrap().to_string()
        };
        let expected = "there is no field `buad`; did you mean `baud`? Others: kind, adapter";
        assert_eq!(field("buad", &["kind", "baud", "adapter"]), expected);
        assert_eq!(field("a", &["b"]), "there is no field `a`; there is only `b`");
        assert_eq!(UnknownName::of(&Cause::MissingField), None);
        let known = ["bob", "alice"].map(str::to_owned).into();
        let element = UnknownName::of(&Cause::UnknownElement { name: "alise".into(), known }).unwrap();
        assert_eq!(element.to_string(), "there is no element `alise`; did you mean `alice`? Others: bob");
    }
}
