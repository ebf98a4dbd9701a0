//! The sources of a preset's values: the comments behind them.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use toml::{Table, Value};

use super::Preset;

/// A value of a preset and where it is from.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// The path of the fact, such as `robot.body.mass_kg`.
    pub path: String,
    /// The value.
    pub value: Value,
    /// The kind of the source; none for words that choose a part.
    pub standing: Option<Standing>,
    /// The source.
    pub source: &'static str,
}

/// The certainty of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// The value is from the maker's data sheet or manual.
    Datasheet,
    /// The value was measured and published by a third party.
    Measured,
    /// The value is from the lecture notes (Wahde 2016).
    Notes,
    /// A constant of another public simulator or driver.
    Driver,
    /// The value is from a data sheet, from memory, to be checked.
    Recalled,
    /// Follows from other values.
    Calculated,
    /// The value is a guess; replace it if you have a better one.
    Guess,
}

impl Standing {
    /// All of them, the surest first.
    pub const ALL: [Self; 7] = [
        Self::Datasheet,
        Self::Measured,
        Self::Notes,
        Self::Driver,
        Self::Recalled,
        Self::Calculated,
        Self::Guess,
    ];

    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Datasheet => "datasheet",
            Self::Measured => "measured",
            Self::Notes => "notes",
            Self::Driver => "driver",
            Self::Recalled => "recalled",
            Self::Calculated => "calculated",
            Self::Guess => "guess",
        }
    }
}

impl Preset {
    /// The preset's values in the order of the file.
    pub fn facts(&self) -> Vec<Fact> {
        let mut table = String::new();
        let mut facts = Vec::new();
        // The first two lines are its kind and its description.
        for line in self.text.lines().skip(2) {
            if let Some(header) = line.strip_prefix('[') {
                table = header.split(']').next().unwrap_or(header).into();
            } else if let Some(fact) = fact(&table, line) {
                facts.push(fact);
            }
        }
        facts
    }
}

/// The value of a line, if it has one: `key = value # standing: source`.
fn fact(table: &str, line: &'static str) -> Option<Fact> {
    let (assignment, comment) = line.split_once(" # ").unwrap_or((line, ""));
    let (key, value) = assignment.parse::<Table>().ok()?.into_iter().next()?;
    let (standing, source) = comment.split_once(": ").unwrap_or((comment, ""));
    let standing = Standing::ALL.into_iter().find(|known| known.word() == standing);
    let source = if standing.is_some() { source.trim() } else { "" };
    Some(Fact { path: format!("{table}.{key}"), value, standing, source })
}

#[cfg(test)]
mod tests {
    use alloc::string::ToString;

    use toml::{Table, Value};

    use super::{Standing, fact};
    use crate::presets::{PresetKind, preset, presets};

    #[test]
    fn a_line_is_a_value_with_its_standing_and_source() {
        let fact = fact("robot.body", "radius_m = 0.0275 # datasheet: K-Team, Khepera (55 mm)").unwrap();
        assert_eq!((fact.path.as_str(), fact.value), ("robot.body.radius_m", Value::Float(0.0275)));
        assert_eq!((fact.standing, fact.source), (Some(Standing::Datasheet), "K-Team, Khepera (55 mm)"));
    }

    /// Only words that choose a part need none.
    #[test]
    fn every_value_of_every_preset_says_where_it_is_from() {
        for preset in presets() {
            for fact in preset.facts() {
                let is_word = fact.path.ends_with(".kind") || fact.path.ends_with(".preset");
                let sound = is_word || (fact.standing.is_some() && !fact.source.is_empty());
                assert!(sound, "{}: {} has no `# STANDING: source`", preset.name, fact.path);
            }
        }
    }

    #[test]
    fn facts_are_all_of_a_preset_and_nothing_else() {
        for preset in presets() {
            let mut rebuilt = Table::new();
            for fact in preset.facts() {
                let mut parts = fact.path.split('.').peekable();
                let mut here = &mut rebuilt;
                while let Some(part) = parts.next() {
                    if parts.peek().is_none() {
                        here.insert(part.into(), fact.value.clone());
                        break;
                    }
                    let table = here.entry(part).or_insert_with(|| Value::Table(Table::new()));
                    here = table.as_table_mut().unwrap();
                }
            }
            let mut table: Table = preset.text.parse().unwrap();
            let word =
                |table: &mut Table, key: &str| table.remove(key).unwrap().as_str().unwrap().to_string();
            assert_eq!(word(&mut table, "kind"), preset.kind.word());
            assert_eq!(word(&mut table, "description"), preset.description);
            assert_eq!(table.keys().collect::<alloc::vec::Vec<_>>(), [preset.kind.word()], "{}", preset.name);
            assert_eq!(rebuilt, table, "{}", preset.name);
        }
    }

    #[test]
    fn presets_come_kind_by_kind_and_have_names_of_their_own() {
        assert!(presets().is_sorted_by_key(|preset| preset.kind));
        for kind in PresetKind::ALL {
            assert!(presets().any(|preset| preset.kind == kind), "{}", kind.word());
        }
        for found in presets() {
            assert!(core::ptr::eq(preset(found.name).unwrap(), found), "{}", found.name);
        }
    }
}
