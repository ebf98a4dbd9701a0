//! Goals of a tuning: the quality of a candidate.

use std::fmt;

use toml::Table;

use crate::error::Error;
use crate::factor::number;
use crate::figures::{Figure, Figures};

/// A sum of figures with weights, which is to be made large.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    weights: Vec<(Figure, f64)>,
}

impl Goal {
    pub(crate) fn new(table: &Table) -> Result<Self, Error> {
        let mut weights = Vec::new();
        for (name, weight) in table {
            let at = format!("tune.maximize.{name}");
            let figure = Figure::named(name).map_err(|problem| Error::field(&at, problem))?;
            let Some(weight) = number(weight) else {
                return Err(Error::field(at, format!("must be a number, its weight, is {weight}")));
            };
            weights.push((figure, weight));
        }
        if weights.iter().all(|(_, weight)| *weight == 0.0) {
            let problem =
                "has no figure with a weight; give some, such as { covered = 1.0, collisions = -0.1 }";
            return Err(Error::field("tune.maximize", problem));
        }
        Ok(Self { weights })
    }

    /// Whether some runs lack a figure that others have.
    pub(crate) fn may_be_missed(&self) -> bool {
        self.weights.iter().any(|(figure, _)| *figure == Figure::GoalTimeS)
    }

    /// The figures that it uses.
    pub(crate) fn figures(&self) -> impl Iterator<Item = Figure> {
        self.weights.iter().map(|(figure, _)| *figure)
    }

    /// The score of a run; of one that lacks a figure, the figure that it lacks.
    pub fn score(&self, figures: &Figures) -> Result<f64, Figure> {
        let part =
            |&(figure, weight): &(Figure, f64)| figures.get(figure).map(|value| weight * value).ok_or(figure);
        self.weights.iter().map(part).sum()
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A wanted figure comes before others.
        let mut weights = self.weights.clone();
        weights.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        for (i, (figure, weight)) in weights.iter().enumerate() {
            let sign = match (i, *weight < 0.0) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            let name = figure.info().name;
            match weight.abs() {
                1.0 => write!(f, "{sign}{name}")?,
                weight => write!(f, "{sign}{weight} {name}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(toml: &str) -> Result<Goal, String> {
        Goal::new(&toml.parse().unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_score_is_a_sum_with_weights_and_lacks_nothing() {
        let goal = goal("covered = 1\ncollisions = -0.1").unwrap();
        let mut figures = Figures::default();
        figures.set(Figure::Covered, Some(0.8));
        assert_eq!(goal.score(&figures), Err(Figure::Collisions));
        figures.set(Figure::Collisions, Some(3.0));
        assert!((goal.score(&figures).unwrap() - 0.5).abs() < 1e-12);
        assert!(
            ["covered - 0.1 collisions", "-0.1 collisions + covered"].contains(&goal.to_string().as_str())
        );
    }

    #[test]
    fn what_is_no_goal_is_refused() {
        assert!(goal("covred = 1").unwrap_err().contains("did you mean `covered`?"));
        assert!(
            goal("covered = \"much\"").unwrap_err().starts_with("tune.maximize.covered: must be a number")
        );
        assert!(goal("covered = 0").unwrap_err().starts_with("tune.maximize: has no figure"));
        assert!(goal("").unwrap_err().starts_with("tune.maximize: has no figure"));
    }
}
