//! Criteria of success: limits of figures, or of other quantities of a run, all of which it must keep.

use std::fmt;

use baudbot_run::UnknownName;
use toml::Table;

use crate::error::Error;
use crate::factor::number;
use crate::figures::{Figure, Figures};

/// Conditions on figures, of which there is at least one.
pub type Success = Conditions<Figure>;

/// A number of a run.
pub trait Quantity: Copy {
    /// The quantity of this name.
    ///
    /// # Errors
    /// An error with those that exist, the nearest first.
    fn named(name: &str) -> Result<Self, UnknownName>;

    /// The name of the quantity in files.
    fn name(self) -> &'static str;
}

impl Quantity for Figure {
    fn named(name: &str) -> Result<Self, UnknownName> {
        Self::named(name)
    }

    fn name(self) -> &'static str {
        self.info().name
    }
}

/// Conditions, of which there is at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions<Q> {
    conditions: Vec<Condition<Q>>,
}

/// A limit of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition<Q> {
    /// The quantity with the limit.
    pub quantity: Q,
    /// The limit, in the quantity's unit.
    pub limit: f64,
    /// The limit is a lower one.
    pub at_least: bool,
}

impl<Q: Quantity> Condition<Q> {
    /// Whether a value keeps the limit. What was not counted keeps none.
    pub fn holds(&self, value: Option<f64>) -> bool {
        value.is_some_and(|value| if self.at_least { value >= self.limit } else { value <= self.limit })
    }
}

impl<Q: Quantity> Conditions<Q> {
    /// The conditions of a table, which is at this place in its file: `FIGURE_at_most`, `FIGURE_at_least` and
    /// `goal_reached`.
    ///
    /// # Errors
    /// If it has none, or something else in it.
    pub fn new(place: &str, table: &Table) -> Result<Self, Error> {
        let mut conditions = Vec::new();
        for (key, value) in table {
            let at = format!("{place}.{key}");
            if key == "goal_reached" {
                if value.as_bool() != Some(true) {
                    return Err(Error::field(at, "can only be true; leave it out otherwise"));
                }
                let quantity =
                    Q::named(Figure::GoalTimeS.name()).map_err(|error| Error::field(&at, error))?;
                conditions.push(Condition { quantity, limit: 0.0, at_least: true });
                continue;
            }
            let ends = [("_at_most", false), ("_at_least", true)];
            let split = ends.into_iter().find_map(|(end, at_least)| Some((key.strip_suffix(end)?, at_least)));
            let Some((name, at_least)) = split else {
                let problem = "is not a condition; write FIGURE_at_most, FIGURE_at_least or goal_reached, such as \
                               collisions_at_most = 0";
                return Err(Error::field(at, problem));
            };
            let quantity = Q::named(name).map_err(|problem| Error::field(&at, problem))?;
            let Some(limit) = number(value) else {
                return Err(Error::field(at, format!("must be a number, is {value}")));
            };
            conditions.push(Condition { quantity, limit, at_least });
        }
        if conditions.is_empty() {
            return Err(Error::field(place, "is empty; give a condition such as collisions_at_most = 0"));
        }
        Ok(Self { conditions })
    }

    /// Whether all hold of these values. A quantity that was not counted keeps no limit.
    pub fn hold(&self, value: impl Fn(Q) -> Option<f64>) -> bool {
        self.conditions.iter().all(|condition| condition.holds(value(condition.quantity)))
    }

    /// Each of them.
    pub fn iter(&self) -> impl Iterator<Item = &Condition<Q>> {
        self.conditions.iter()
    }
}

impl Success {
    /// Whether a run succeeded.
    pub fn of(&self, figures: &Figures) -> bool {
        self.hold(|figure| figures.get(figure))
    }

    /// The figures that it uses.
    pub fn figures(&self) -> impl Iterator<Item = Figure> {
        self.iter().map(|condition| condition.quantity)
    }
}

impl<Q: Quantity> fmt::Display for Condition<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, limit) = (self.quantity.name(), self.limit);
        match self.at_least {
            true if limit == 0.0 && name == Figure::GoalTimeS.name() => f.write_str("the goal reached"),
            false if limit == 0.0 && name == Figure::Collisions.name() => f.write_str("no collision"),
            true => write!(f, "{name} at least {limit}"),
            false => write!(f, "{name} at most {limit}"),
        }
    }
}

impl<Q: Quantity> fmt::Display for Conditions<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, condition) in self.conditions.iter().enumerate() {
            write!(f, "{}{condition}", if i > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn success(toml: &str) -> Result<Success, String> {
        Success::new("success", &toml.parse().unwrap()).map_err(|error| error.to_string())
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
