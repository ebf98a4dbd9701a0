//! The way from a value of TOML to a type. The reader of the crate `toml` gives its errors as text only; this one keeps
//! the cause.

use serde::de::DeserializeOwned;
use toml::Value;

use crate::misread::Misread;
use crate::tree::Tree;

/// Reads a value of TOML.
///
/// # Errors
/// Names the field that is missing, unknown, or of the wrong type.
pub fn read<T: DeserializeOwned>(value: impl Into<Value>) -> Result<T, Misread> {
    T::deserialize(Tree(value.into())).map_err(|problem| *problem.0)
}

#[cfg(test)]
mod tests {
    use alloc::collections::BTreeMap;
    use alloc::string::{String, ToString};
    use alloc::vec;
    use alloc::vec::Vec;

    use serde::Deserialize;
    use toml::Table;

    use super::*;
    use crate::{Cause, words};

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Sheet {
        range_m: f64,
        #[serde(default)]
        mark: Option<Mark>,
        #[serde(default)]
        places: Vec<[f64; 2]>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Mark {
        LightGrey,
        Rgb([u8; 3]),
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Drawer {
        #[serde(default)]
        sheets: BTreeMap<String, Sheet>,
        #[serde(default)]
        kind: Option<Kind>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Kind {
        Plain,
        Depth(f64),
        Pair(u8, u8),
        Shade { depth: f64 },
    }

    fn misread(toml: &str) -> Misread {
        read::<Sheet>(toml.parse::<Table>().unwrap()).unwrap_err()
    }

    #[test]
    fn what_fits_is_read() {
        let read = |toml: &str| read::<Sheet>(toml.parse::<Table>().unwrap()).unwrap();
        let sheet = read("range_m = 2\nmark = { rgb = [1, 2, 3] }\nplaces = [[0.5, 1]]");
        assert_eq!(sheet, Sheet { range_m: 2.0, mark: Some(Mark::Rgb([1, 2, 3])), places: vec![[0.5, 1.0]] });
        assert_eq!(read("range_m = 2.0\nmark = \"light-grey\"").mark, Some(Mark::LightGrey));
        let read = |toml: &str| super::read::<Drawer>(toml.parse::<Table>().unwrap()).unwrap();
        assert_eq!(read("sheets.a.range_m = 1.0").sheets["a"].range_m, 1.0);
        let kinds = [
            ("\"plain\"", Kind::Plain),
            ("{ depth = 1 }", Kind::Depth(1.0)),
            ("{ pair = [1, 2] }", Kind::Pair(1, 2)),
            ("{ shade = { depth = 0.5 } }", Kind::Shade { depth: 0.5 }),
        ];
        for (toml, kind) in kinds {
            assert_eq!(read(&alloc::format!("kind = {toml}")).kind, Some(kind));
        }
    }

    #[test]
    fn fields_that_are_not_there_have_their_cause() {
        let error = misread("range_m = 1.0\nrnge_m = 2.0");
        let known = ["range_m", "mark", "places"].into();
        assert_eq!(error.cause, Cause::UnknownField { name: "rnge_m".into(), known });
        let expected =
            "unknown field `rnge_m`, expected one of `range_m`, `mark`, `places`; did you mean `range_m`?";
        assert_eq!((error.path.as_str(), error.problem.as_str()), ("rnge_m", expected));
        let error = misread("places = []");
        assert_eq!((error.path.as_str(), error.problem.as_str()), ("", "missing field `range_m`"));
        assert_eq!(error.cause, Cause::MissingField);
    }

    /// Paths are those that the crate `toml` has for the same values; words are those of a file.
    #[test]
    fn what_does_not_fit_is_told_in_words_of_toml() {
        let wrong = [
            ("range_m = \"far\"", "must be a number, is \"far\""),
            ("range_m = 1.0\nplaces = [[1.0, 2.0], [3.0]]", "must have 2 elements, has 1"),
            ("range_m = 1.0\nplaces = [[1.0, 2.0, 3.0]]", "must have 2 elements, has 3"),
            ("range_m = 1.0\nplaces = 7", "must be a list, is 7"),
            ("range_m = 1.0\nmark = \"dark\"", "must be `light-grey` or `rgb`, is `dark`"),
            ("range_m = 1.0\nmark = {}", "must be a table with 1 field, has 0"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 3], grey = 1 }", "must be a table with 1 field, has 2"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 300] }", "must be a whole number from 0 to 255, is 300"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 3.5] }", "must be a whole number from 0 to 255, is 3.5"),
            ("range_m = 1.0\nmark = 5", "must be a string, is 5"),
            ("range_m = 1.0\nmark = [true]", "must be a string, is a list"),
            ("range_m = 1979-05-27", "must be a number, is \"1979-05-27\""),
            ("range_m = { x = 1 }", "must be a number, is a table"),
            ("mark = \"light-grey\"", "missing field `range_m`"),
            ("other = 1", "unknown field `other`, expected one of `range_m`, `mark`, `places`"),
        ];
        for (toml, words) in wrong {
            let ours = misread(toml);
            assert_eq!(ours.problem, words, "{toml}");
            let theirs: Result<Sheet, _> = serde_path_to_error::deserialize(toml.parse::<Table>().unwrap());
            let path = if ours.path.is_empty() { "." } else { &ours.path };
            assert_eq!(path, theirs.unwrap_err().path().to_string(), "{toml}");
        }
    }

    /// As above, in what is deeper.
    #[test]
    fn what_does_not_fit_in_a_variant_or_an_entry_has_its_path() {
        let wrong = [
            ("kind = \"depth\"", "kind.depth", "must be newtype variant, is unit variant"),
            ("kind = \"pair\"", "kind.pair", "must be tuple variant, is unit variant"),
            ("kind = \"shade\"", "kind.shade", "must be a table, is unit variant"),
            ("kind = { plain = 1 }", "kind.plain", "must be unit, is 1"),
            ("kind = { depth = \"far\" }", "kind.depth", "must be a number, is \"far\""),
            ("kind = { pair = [1] }", "kind.pair", "must have 2 elements, has 1"),
            (
                "kind = { pair = [1, \"b\"] }",
                "kind.pair[1]",
                "must be a whole number from 0 to 255, is \"b\"",
            ),
            ("kind = { shade = 1 }", "kind.shade", "must be a table, is 1"),
            ("kind = { shade = {} }", "kind.shade", "missing field `depth`"),
            ("kind = { shade = { depth = [1] } }", "kind.shade.depth", "must be a number, is a list"),
            ("kind = { dark = 1 }", "kind", "must be one of `plain`, `depth`, `pair`, `shade`, is `dark`"),
            (
                "sheets = { a = { range_m = 1.0 }, b = { range_m = 1.0, places = [[1, true]] } }",
                "sheets.b.places[0][1]",
                "must be a number, is true",
            ),
            (
                "sheets = { \"a.b\" = { range_m = 1.0, x = 2.0 } }",
                "sheets.a.b.x",
                "unknown field `x`, expected one of `range_m`, `mark`, `places`",
            ),
            ("sheets = [1]", "sheets", "must be a table, is a list"),
        ];
        for (toml, path, words) in wrong {
            let ours = read::<Drawer>(toml.parse::<Table>().unwrap()).unwrap_err();
            assert_eq!((ours.path.as_str(), ours.problem.as_str()), (path, words), "{toml}");
            let theirs: Result<Drawer, _> = serde_path_to_error::deserialize(toml.parse::<Table>().unwrap());
            assert_eq!(path, theirs.unwrap_err().path().to_string(), "{toml}");
        }
    }

    /// Serde takes one as the fields in the order in which the program has them.
    #[test]
    fn a_list_is_no_table() {
        let error = read::<Drawer>("sheets.a = [1.0]".parse::<Table>().unwrap()).unwrap_err();
        assert_eq!((error.path.as_str(), error.problem.as_str()), ("sheets.a", "must be a table, is a list"));
    }

    #[test]
    fn the_name_that_was_meant_is_suggested() {
        assert_eq!(
            words::unknown("uat", &["ideal", "onboard", "uart"]),
            "must be one of `ideal`, `onboard`, `uart`, is `uat`; did you mean `uart`?"
        );
        assert_eq!(words::unknown("x", &["dc"]), "must be `dc`, is `x`");
    }
}
