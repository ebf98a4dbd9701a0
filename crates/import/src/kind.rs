//! The kinds of files that commands take. Each is recognised by the fields that only it has.

use toml_edit::DocumentMut;

use crate::embedded;

/// A kind of file, or of what is built in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A world before its first tick.
    Scenario,
    /// A scenario that is run many times.
    Experiment,
    /// A task for a brain, with criteria.
    Exercise,
    /// A run, as an MCAP file.
    Recording,
}

impl Kind {
    /// The kind of a text: the only one of which it has own fields. It may still be wrong in other ways.
    pub fn of_text(text: &str) -> Option<Self> {
        let document = text.parse::<DocumentMut>().ok()?;
        let has = |field: &&str| document.contains_key(field);
        let mut kinds = TEXTS.iter().filter(|(_, own)| own.iter().any(&has));
        let (kind, _) = kinds.next().filter(|_| kinds.next().is_none())?;
        // A scenario refers to no other.
        (*kind != Self::Scenario || !has(&"scenario")).then_some(*kind)
    }

    /// The kind of what is built in under this name, and its text. A scenario comes first.
    pub fn built_in(name: &str) -> Option<(Self, &'static str)> {
        let scenario = embedded::scenario(name).map(|text| (Self::Scenario, text));
        let experiment = || embedded::experiment(name).map(|text| (Self::Experiment, text));
        let exercise = || embedded::exercise(name).map(|text| (Self::Exercise, text));
        scenario.or_else(experiment).or_else(exercise)
    }

    /// The name of the kind.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Experiment => "experiment",
            Self::Exercise => "exercise",
            Self::Recording => "recording",
        }
    }

    /// The name of the kind with its article.
    pub(crate) fn one(self) -> String {
        let article = if self.noun().starts_with('e') { "an" } else { "a" };
        format!("{article} {}", self.noun())
    }

    /// The command that is for a file of this kind, or for what is built in.
    pub(crate) fn command(self, name: &str, text: &str) -> String {
        match self {
            Self::Scenario => format!("baudbot run {name}"),
            Self::Experiment if has_table(text, "tune") => format!("baudbot tune {name}"),
            Self::Experiment if has_table(text, "require") || has_table(text, "worst") => {
                format!("baudbot worst {name}")
            }
            Self::Experiment => format!("baudbot sweep {name}"),
            Self::Exercise => format!("baudbot grade {name} --brain BRAIN"),
            Self::Recording => format!("baudbot replay {name}"),
        }
    }

    /// The built-in names of this kind that may be meant by a wrong one.
    pub(crate) fn nearest(self, wrong: &str) -> Vec<&'static str> {
        match self {
            Self::Scenario => embedded::nearest(wrong),
            Self::Experiment => embedded::nearest_experiments(wrong),
            Self::Exercise => embedded::nearest_exercises(wrong),
            Self::Recording => Vec::new(),
        }
    }
}

/// Whether the text of a file has this table.
fn has_table(text: &str, table: &str) -> bool {
    text.parse::<DocumentMut>().is_ok_and(|document| document.contains_key(table))
}

/// The fields that no other kind has.
const TEXTS: [(Kind, &[&str]); 3] = [
    (Kind::Scenario, &["arena", "collision", "end", "metrics", "noise", "robots", "step_ms", "substeps"]),
    (
        Kind::Experiment,
        &[
            "brain", "charts", "design", "fields", "find", "nearness", "require", "samples", "success",
            "tune", "worst",
        ],
    ),
    (
        Kind::Exercise,
        &["advice", "criteria", "limits", "pass", "robot", "section", "set", "target", "task", "title"],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_built_in_is_recognised_by_its_fields() {
        let kinds: [(Kind, Vec<_>); 3] = [
            (Kind::Scenario, embedded::scenarios().collect()),
            (Kind::Experiment, embedded::experiments().collect()),
            (Kind::Exercise, embedded::exercises().collect()),
        ];
        for (kind, all) in kinds {
            for (name, text) in all {
                assert_eq!(Kind::of_text(text), Some(kind), "{name}");
            }
        }
    }

    #[test]
    fn a_text_of_no_kind_or_of_two_is_not_recognised() {
        for text in
            ["", "name = \"wander\"", "robots = []\nfields = []", "scenario = \"a\"\nrobots = []", "["]
        {
            assert_eq!(Kind::of_text(text), None, "{text}");
        }
    }
}
