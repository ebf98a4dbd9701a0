//! Names that somebody may have meant, in words.

use baudbot_brains::catalogue::nearest_first;

/// That there is no such thing, and what there is, the nearest first.
pub(crate) fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    let name: String = name.chars().take(MAX_CHARACTERS).collect();
    let known = nearest_first(&name, known.iter().copied());
    match known.split_first() {
        None => format!("there is no {what} `{name}`, and there is none at all"),
        Some((nearest, [])) => format!("there is no {what} `{name}`; there is only `{nearest}`"),
        Some((nearest, others)) => {
            let more = if others.len() > MAX_NAMES { ", …" } else { "" };
            let others = others[..others.len().min(MAX_NAMES)].join(", ");
            format!("there is no {what} `{name}`; did you mean `{nearest}`? Others: {others}{more}")
        }
    }
}

/// A name that something has not, and the names that it has, of a message of serde's or of a scenario's.
pub(crate) struct Unknown {
    pub(crate) name: String,
    pub(crate) known: Vec<String>,
}

impl Unknown {
    /// Of ``unknown field `a`, expected one of `b`, `c` `` and the like.
    pub(crate) fn field(message: &str) -> Option<Self> {
        let (_, rest) = message.split_once("unknown field `")?;
        let (name, rest) = rest.split_once('`')?;
        // Of text that is cut at its ticks every second piece stood between two of them.
        let known = rest.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        Some(Self { name: name.to_owned(), known })
    }

    /// Of `PATH.NAME: there is no such element; there are: a, b`.
    pub(crate) fn element(message: &str) -> Option<Self> {
        let (path, known) = message.split_once(": there is no such element; there are: ")?;
        let name = path.rsplit('.').next()?.to_owned();
        Some(Self { name, known: known.split(", ").map(str::to_owned).collect() })
    }

    pub(crate) fn words(&self, what: &str) -> String {
        unknown(what, &self.name, &self.known.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

/// A message of serde's, the names that are known in it the nearest first.
pub(crate) fn reworded(message: &str) -> String {
    Unknown::field(message).map_or_else(|| message.to_owned(), |unknown| unknown.words("field"))
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
            Unknown::element("robots.alise: there is no such element; there are: bob, alice").unwrap();
        assert_eq!(element.words("robot"), "there is no robot `alise`; did you mean `alice`? Others: bob");
    }
}
