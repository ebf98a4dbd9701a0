//! Names that somebody may have meant, in words.

use std::fmt;

use baudbot_brains::catalogue::nearest_first;

/// There is no thing of this name. The message says which there are, the nearest first.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct UnknownName {
    kind: &'static str,
    pub(crate) name: String,
    known: Vec<String>,
}

impl UnknownName {
    /// `kind` is what it is a name of, in words.
    pub(crate) fn new(kind: &'static str, name: &str, known: &[&str]) -> Self {
        let known = known.iter().copied().map(str::to_owned).collect();
        Self { kind, name: name.to_owned(), known }
    }

    /// Of a message of serde's: ``unknown field `a`, expected one of `b`, `c` `` and the like.
    pub(crate) fn field(message: &str) -> Option<Self> {
        let (_, rest) = message.split_once("unknown field `")?;
        let (name, rest) = rest.split_once('`')?;
        // Of text that is cut at its ticks every second piece stood between two of them.
        let known: Vec<_> = rest.split('`').skip(1).step_by(2).collect();
        Some(Self::new("field", name, &known))
    }

    /// Of a scenario's message: `PATH.NAME: there is no such element; there are: a, b`.
    pub(crate) fn element(message: &str) -> Option<Self> {
        let (path, known) = message.split_once(": there is no such element; there are: ")?;
        let known: Vec<_> = known.split(", ").collect();
        Some(Self::new("element", path.rsplit('.').next()?, &known))
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

/// A message of serde's, the names that are known in it the nearest first.
pub(crate) fn reworded(message: &str) -> String {
    UnknownName::field(message).map_or_else(|| message.to_owned(), |unknown| unknown.to_string())
}

/// Most names that are told besides the nearest.
const MAX_NAMES: usize = 12;

/// Longest name that is told, in characters.
const MAX_CHARACTERS: usize = 80;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first() {
        let message = "unknown field `buad`, expected one of `kind`, `baud`, `adapter`";
        assert_eq!(reworded(message), "there is no field `buad`; did you mean `baud`? Others: kind, adapter");
        assert_eq!(reworded("unknown field `a`, expected `b`"), "there is no field `a`; there is only `b`");
        assert_eq!(reworded("missing field `a`"), "missing field `a`");
        let element =
            UnknownName::element("robots.alise: there is no such element; there are: bob, alice").unwrap();
        assert_eq!(element.to_string(), "there is no element `alise`; did you mean `alice`? Others: bob");
    }
}
