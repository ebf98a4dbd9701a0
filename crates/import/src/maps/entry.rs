//! An entry of `arena.maps`, as it stands in the file and checked.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use super::select::Selector;
use super::shape::MAX_POSITION;
use crate::error::ImportError;

/// A map: where it comes from and how it becomes shapes.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) height_m: Option<f64>,
    pub(crate) source: Source,
}

#[derive(Debug)]
pub(crate) enum Source {
    Ros { file: String, unknown: Unknown },
    Svg { file: String, plan: Plan },
}

/// The use of a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) scale: Scale,
    pub(crate) choice: Choice,
    pub(crate) marks: Vec<Wanted>,
}

/// A place that is asked for, by the id of its shape or group.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub(crate) id: String,
    pub(crate) purpose: Purpose,
}

/// The purpose of a place.
#[derive(Clone, Debug)]
pub(crate) enum Purpose {
    /// This robot starts there.
    Start(String),
    /// The run ends there.
    Goal,
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start(robot) => write!(f, "`starts.{robot}`"),
            Self::Goal => f.write_str("`goal`"),
        }
    }
}

/// The choice of the shapes of a drawing that are walls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    /// The shapes that one of these selectors chooses; all if there are none.
    pub(crate) only: Vec<Selector>,
    /// But not those that one of these chooses.
    pub(crate) without: Vec<Selector>,
}

/// The treatment of cells that the map marks as unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Unknown {
    #[default]
    Free,
    Occupied,
}

/// The placement of a drawing in the arena.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) m_per_unit: f64,
    /// The place of the drawing's lower left corner, in metres.
    pub(crate) origin: [f64; 2],
    /// The greatest distance, in metres, of a chord from its curve.
    pub(crate) tolerance: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Raw {
    name: String,
    height_m: Option<f64>,
    ros: Option<String>,
    unknown: Option<Unknown>,
    svg: Option<String>,
    m_per_unit: Option<f64>,
    origin_m: Option<[f64; 2]>,
    tolerance_m: Option<f64>,
    only: Option<Vec<String>>,
    without: Option<Vec<String>>,
    starts: Option<BTreeMap<String, String>>,
    goal: Option<String>,
}

impl Raw {
    /// Checks the entry that stands at `path`.
    pub(crate) fn check(mut self, path: &str) -> Result<Entry, ImportError> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !(1..=40).contains(&self.name.len()) || !self.name.chars().all(fits) {
            let problem = format!("must be 1 to 40 letters, digits, `_` or `-`, is {:?}", self.name);
            return Err(ImportError::field(format!("{path}.name"), problem));
        }
        if let Some(height_m) = self.height_m.filter(|height_m| !height_m.is_finite()) {
            return Err(ImportError::field(
                format!("{path}.height_m"),
                format!("must be finite, is {height_m}"),
            ));
        }
        let source = match (self.ros.take(), self.svg.take()) {
            (Some(file), None) => self.ros(file, path)?,
            (None, Some(file)) => self.svg(file, path)?,
            (Some(_), Some(_)) => {
                return Err(ImportError::field(path, "has both `ros` and `svg`: take one of them out"));
            }
            (None, None) => {
                let problem = "needs a file: `ros = \"map.yaml\"` or `svg = \"plan.svg\"`";
                return Err(ImportError::field(path, problem));
            }
        };
        Ok(Entry { name: self.name, height_m: self.height_m, source })
    }

    fn ros(&self, file: String, path: &str) -> Result<Source, ImportError> {
        let of_svg = [
            ("m_per_unit", self.m_per_unit.is_some()),
            ("origin_m", self.origin_m.is_some()),
            ("tolerance_m", self.tolerance_m.is_some()),
            ("only", self.only.is_some()),
            ("without", self.without.is_some()),
            ("starts", self.starts.is_some()),
            ("goal", self.goal.is_some()),
        ];
        if let Some((field, _)) = of_svg.iter().find(|(_, is_there)| *is_there) {
            let problem = "is for maps with `svg` only: take it out, the YAML sets the place of the map";
            return Err(ImportError::field(format!("{path}.{field}"), problem));
        }
        Ok(Source::Ros { file, unknown: self.unknown.unwrap_or_default() })
    }

    fn svg(&self, file: String, path: &str) -> Result<Source, ImportError> {
        if self.unknown.is_some() {
            let problem = "is for maps with `ros` only: take it out";
            return Err(ImportError::field(format!("{path}.unknown"), problem));
        }
        let plan = Plan { scale: self.scale(path)?, choice: self.choice(path)?, marks: self.marks() };
        Ok(Source::Svg { file, plan })
    }

    /// The placement of the drawing in the arena, with defaults for missing fields.
    fn scale(&self, path: &str) -> Result<Scale, ImportError> {
        let wrong = |field: &str, problem: String| ImportError::field(format!("{path}.{field}"), problem);
        let Some(m_per_unit) = self.m_per_unit else {
            return Err(wrong(
                "m_per_unit",
                "is missing: the metres that a unit of the drawing stands for".into(),
            ));
        };
        let origin = self.origin_m.unwrap_or_default();
        let tolerance = self.tolerance_m.unwrap_or(TOLERANCE);
        if !(m_per_unit > 0.0 && m_per_unit <= MAX_POSITION) {
            return Err(wrong(
                "m_per_unit",
                format!("must be above 0, at most {MAX_POSITION}, is {m_per_unit}"),
            ));
        }
        if !origin.iter().all(|x| x.abs() <= MAX_POSITION) {
            return Err(wrong("origin_m", format!("must be within ±{MAX_POSITION}, is {origin:?}")));
        }
        if !(MIN_TOLERANCE..=MAX_POSITION).contains(&tolerance) {
            let problem = format!("must be from {MIN_TOLERANCE} to {MAX_POSITION}, is {tolerance}");
            return Err(wrong("tolerance_m", problem));
        }
        Ok(Scale { m_per_unit, origin, tolerance })
    }

    /// The choice of the shapes of the drawing that are walls.
    fn choice(&self, path: &str) -> Result<Choice, ImportError> {
        let selectors = |field: &str, texts: &Option<Vec<String>>| {
            let texts = texts.iter().flatten().enumerate();
            let parse = |(i, text): (usize, &String)| {
                text.parse::<Selector>()
                    .map_err(|problem| ImportError::field(format!("{path}.{field}[{i}]"), problem))
            };
            texts.map(parse).collect::<Result<Vec<Selector>, _>>()
        };
        Ok(Choice { only: selectors("only", &self.only)?, without: selectors("without", &self.without)? })
    }

    /// The places that are asked for: where robots start, then the goal.
    fn marks(&self) -> Vec<Wanted> {
        let starts = self.starts.iter().flatten();
        let starts =
            starts.map(|(robot, id)| Wanted { id: id.clone(), purpose: Purpose::Start(robot.clone()) });
        let goal = self.goal.iter().map(|id| Wanted { id: id.clone(), purpose: Purpose::Goal });
        starts.chain(goal).collect()
    }
}

/// In metres: finer than robots can feel.
const TOLERANCE: f64 = 0.005;

/// In metres. Corners are rounded to that, and a curve has no end of them if nothing is too fine.
const MIN_TOLERANCE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// The words in backticks of the error for a field or a variant that there is not.
    fn known(toml: &str) -> BTreeSet<String> {
        let error = toml::from_str::<Raw>(toml).unwrap_err().to_string();
        let (_, known) = error.split_once("expected ").unwrap_or_else(|| panic!("{error}"));
        known.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    }

    /// The crate `scenario` describes maps without reading them.
    #[test]
    fn the_schema_of_scenarios_has_the_fields_of_a_map() {
        let schema = baudbot_scenario::schema();
        let map = schema.pointer("/properties/arena/properties/maps/items/allOf/0").expect("its maps");
        let fields = map["properties"].as_object().expect("their fields");
        assert_eq!(known("nothing = 1"), fields.keys().cloned().collect());
        let unknown = fields["unknown"]["enum"].as_array().expect("its words").iter();
        let unknown = unknown.filter_map(|word| word.as_str()).map(str::to_owned).collect();
        assert_eq!(known("name = \"a\"\nunknown = \"nothing\""), unknown);
    }
}
