//! The truth of a step for a trainer, and its reward.

use baudbot_sim::Scenario;
use serde::{Deserialize, Serialize};

use crate::learn::error::LearnError;

/// The events of a step: the truth, for rewards, never for brains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Simulated time, in seconds.
    pub seconds: f64,
    /// Distance that the agent's robot drove, forwards and backwards added, in metres.
    pub distance_m: f64,
    /// Times that it ran into something.
    pub collisions: f64,
    /// The distance by which it came nearer to the scenario's goal, in metres; 0 if there is none.
    pub progress_m: f64,
    /// Share of the free floor that was covered, by any robot; 0 if the scenario does not count it.
    pub covered: f64,
    /// Share of the free floor that was sensed; 0 if the scenario does not count it.
    pub sensed: f64,
    /// Zones that robots have been in for the first time.
    pub zones: f64,
    /// 1 if the run ended as the scenario wishes: a goal was reached, or enough was covered or sensed.
    pub success: f64,
}

impl Tally {
    /// The names of the numbers.
    pub const NAMES: [&'static str; 8] =
        ["seconds", "distance_m", "collisions", "progress_m", "covered", "sensed", "zones", "success"];

    /// The numbers of the tally, in the order of [`NAMES`](Self::NAMES).
    pub fn numbers(&self) -> [f64; 8] {
        let Self { seconds, distance_m, collisions, progress_m, covered, sensed, zones, success } = *self;
        [seconds, distance_m, collisions, progress_m, covered, sensed, zones, success]
    }
}

/// A reward: what each part of a [`Tally`] is worth, summed up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reward([f64; 8]);

impl Reward {
    /// Weights by the names of a tally's numbers; those that are not named are worth nothing.
    ///
    /// # Errors
    /// If a name is unknown, or a weight is not finite.
    pub fn new<'a>(weights: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Self, LearnError> {
        let mut all = [0.0; 8];
        for (name, weight) in weights {
            let path = || format!("reward.{name}");
            let Some(place) = Tally::NAMES.iter().position(|known| *known == name) else {
                return Err(LearnError::value(
                    path(),
                    format!("there is no such part; there are: {}", Tally::NAMES.join(", ")),
                ));
            };
            if !weight.is_finite() {
                return Err(LearnError::value(path(), format!("{weight} is not a finite number")));
            }
            all[place] = weight;
        }
        Ok(Self(all))
    }

    /// The weight of each number of a tally, by its name.
    pub fn weights(&self) -> impl Iterator<Item = (&'static str, f64)> {
        Tally::NAMES.into_iter().zip(self.0)
    }

    /// Checks that this scenario counts what is worth something.
    ///
    /// # Errors
    /// If it has no goal, no zones or no grid of the floor, and that is weighed.
    pub fn check(&self, scenario: &Scenario) -> Result<(), LearnError> {
        let missing = [
            (scenario.end.goal.is_none(), "progress_m", "the scenario has no `end.goal` to come nearer to"),
            (scenario.rules.floor.is_none(), "covered", "the scenario counts no floor; set metrics.cell_m"),
            (
                !scenario.rules.count_sensed(),
                "sensed",
                "the scenario does not count what is sensed; see metrics in docs/reference/scenario.md",
            ),
            (scenario.surroundings.zones.is_empty(), "zones", "the scenario has no zones"),
        ];
        for (is_missing, name, problem) in missing {
            let weight =
                Tally::NAMES.iter().position(|known| *known == name).map_or(0.0, |place| self.0[place]);
            if is_missing && weight != 0.0 {
                return Err(LearnError::value(format!("reward.{name}"), problem));
            }
        }
        Ok(())
    }

    /// The reward of a step.
    pub fn of(&self, tally: &Tally) -> f64 {
        self.0.iter().zip(tally.numbers()).map(|(weight, number)| weight * number).sum()
    }
}
