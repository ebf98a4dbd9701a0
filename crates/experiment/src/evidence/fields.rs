//! Single numbers of presets, compared with measurements or data sheets.

use baudbot_scenario::presets::{Fact, preset};
use serde::Deserialize;

use crate::evidence::comparison::Reliability;

/// A number of a preset, and what is known of the real one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// The preset.
    pub preset: String,
    /// The path in its file, such as `robot.body.wheel_radius_m`.
    pub path: String,
    /// The known facts, in words.
    pub measured: String,
    /// The least and the largest value that agree with it, in the field's unit.
    pub range: [f64; 2],
    /// The source.
    pub source: String,
    /// The reliability of the measurement.
    pub reliability: Reliability,
    /// The reason why the preset differs.
    pub disagrees: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    fields: Vec<Field>,
}

/// All of them, in the order of the page.
pub fn fields() -> Vec<Field> {
    let file: File = toml::from_str(include_str!("../../fields.toml"))
        .unwrap_or_else(|error| panic!("fields.toml, which is a part of the program: {error}"));
    file.fields
}

impl Field {
    /// The preset's number; `None` if the preset has no such number.
    pub fn value(&self) -> Option<f64> {
        let facts = preset(&self.preset)?.facts();
        let inside = |fact: &Fact| {
            let rest = self.path.strip_prefix(&fact.path)?;
            let keys = rest.split('.').filter(|key| !key.is_empty());
            keys.into_iter().try_fold(fact.value.clone(), |value, key| value.get(key).cloned())
        };
        let value = facts.iter().find_map(inside)?;
        value.as_float().or_else(|| value.as_integer().map(|value| value as f64))
    }

    /// Whether the preset's number is what was measured.
    pub fn agrees(&self) -> bool {
        let [least, most] = self.range;
        self.value().is_some_and(|value| value >= least && value <= most)
    }
}

#[cfg(test)]
mod tests {
    use super::{fields, preset};

    #[test]
    fn every_field_is_a_number_of_a_preset_and_agrees_unless_it_says_why_not() {
        for field in fields() {
            let name = format!("{}: {}", field.preset, field.path);
            assert!(preset(&field.preset).is_some(), "there is no preset {}", field.preset);
            assert_eq!(field.agrees(), field.disagrees.is_none(), "{name} is {:?}", field.value());
        }
    }
}
