//! Criteria of success: limits of figures, all of which a run must keep.

use std::fmt;

use toml::Table;

use crate::error::Error;
use crate::factor::number;
use crate::figures::{Figure, Figures};

/// Conditions, of which there is at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Success {
    conditions: Vec<Condition>,
}

#[derive(Clone, Debug, PartialEq)]
struct Condition {
    figure: Figure,
    limit: f64,
    at_least: bool,
}

impl Success {
    pub(crate) fn new(table: &Table) -> Result<Self, Error> {
        let mut conditions = Vec::new();
        for (key, value) in table {
            let at = format!("success.{key}");
            if key == "goal_reached" {
                if value.as_bool() != Some(true) {
                    return Err(Error::field(at, "can only be true; leave it out otherwise"));
                }
                conditions.push(Condition { figure: Figure::GoalTimeS, limit: 0.0, at_least: true });
                continue;
            }
            let ends = [("_at_most", false), ("_at_least", true)];
            let split = ends.into_iter().find_map(|(end, at_least)| Some((key.strip_suffix(end)?, at_least)));
            let Some((name, at_least)) = split else {
                let problem = "is not a condition; write FIGURE_at_most, FIGURE_at_least or goal_reached, such as \
                               collisions_at_most = 0";
                return Err(Error::field(at, problem));
            };
            let figure = Figure::named(name).map_err(|problem| Error::field(&at, problem))?;
            let Some(limit) = number(value) else {
                return Err(Error::field(at, format!("must be a number, is {value}")));
            };
            conditions.push(Condition { figure, limit, at_least });
        }
        if conditions.is_empty() {
            return Err(Error::field("success", "is empty; give a condition such as collisions_at_most = 0"));
        }
        Ok(Self { conditions })
    }

    /// Whether a run succeeded. A figure that was not counted keeps no limit.
    pub fn of(&self, figures: &Figures) -> bool {
        self.conditions.iter().all(|condition| {
            figures.get(condition.figure).is_some_and(|value| match condition.at_least {
                true => value >= condition.limit,
                false => value <= condition.limit,
            })
        })
    }

    /// The figures that it uses.
    pub fn figures(&self) -> impl Iterator<Item = Figure> {
        self.conditions.iter().map(|condition| condition.figure)
    }
}

impl fmt::Display for Success {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Condition { figure, limit, at_least }) in self.conditions.iter().enumerate() {
            let and = if i > 0 { ", " } else { "" };
            match (figure, at_least) {
                (Figure::GoalTimeS, true) if *limit == 0.0 => write!(f, "{and}the goal reached")?,
                (Figure::Collisions, false) if *limit == 0.0 => write!(f, "{and}no collision")?,
                (figure, true) => write!(f, "{and}{} at least {limit}", figure.info().name)?,
                (figure, false) => write!(f, "{and}{} at most {limit}", figure.info().name)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn success(toml: &str) -> Result<Success, String> {
        Success::new(&toml.parse().unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn all_limits_must_be_kept_and_what_was_not_counted_keeps_none() {
        let mut figures = Figures::default();
        figures.set(Figure::Collisions, Some(0.0));
        figures.set(Figure::DistanceM, Some(3.0));
        for (toml, expected) in [
            ("collisions_at_most = 0", true),
            ("collisions_at_most = 0\ndistance_m_at_least = 3.0", true),
            ("collisions_at_most = 0\ndistance_m_at_least = 3.1", false),
            ("covered_at_least = 0.0", false),
            ("goal_reached = true", false),
        ] {
            assert_eq!(success(toml).unwrap().of(&figures), expected, "{toml}");
        }
        assert_eq!(success("collisions_at_most = 0").unwrap().to_string(), "no collision");
    }

    #[test]
    fn what_is_no_condition_is_refused_with_what_was_meant() {
        assert!(success("colisions_at_most = 0").unwrap_err().contains("did you mean `collisions`?"));
        assert!(success("collisions = 0").unwrap_err().contains("collisions_at_most = 0"));
        assert!(success("collisions_at_most = true").unwrap_err().contains("must be a number, is true"));
        assert!(success("").unwrap_err().starts_with("success: is empty"));
    }
}
