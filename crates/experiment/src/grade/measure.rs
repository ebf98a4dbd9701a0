//! Measures: the numbers of a run that criteria and advice are about.

use baudbot_run::UnknownName;

use crate::figures::{Figure, INFOS};
use crate::success::Quantity;

/// A number of a run. A measure that does not apply to a run is missing, and keeps no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A figure of merit of experiments.
    Figure(Figure),
    /// One that only exercises have, by its place in [`MEASURES`].
    Own(Own),
}

/// A measure of the robot that the exercise is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "`MEASURES` says what each is")]
pub enum Own {
    TurnedRad,
    FarthestM,
    EndErrorM,
    EndErrorRad,
    StandingShare,
    StandingEndS,
    BackwardsShare,
    SaturatedShare,
    SignalBias,
    FirstCollisionS,
    InGoalsS,
    Commands,
    BytesDown,
    BytesUp,
    QueueMaxBytes,
    Beliefs,
    BeliefErrorMeanM,
    BeliefErrorMaxM,
    BeliefErrorEndM,
    QuadraticCost,
}

/// The description of a measure.
#[derive(Clone, Copy, Debug)]
pub struct MeasureInfo {
    /// The measure.
    pub own: Own,
    /// The name of the measure in files.
    pub name: &'static str,
    /// The meaning of the measure.
    pub meaning: &'static str,
}

/// All measures that only exercises have.
pub const MEASURES: [MeasureInfo; 20] = [
    info(Own::TurnedRad, "turned_rad", "sum of the robot's turns, positive to the left"),
    info(Own::FarthestM, "farthest_m", "largest distance from the start"),
    info(Own::EndErrorM, "end_error_m", "distance from `target` at the end"),
    info(
        Own::EndErrorRad,
        "end_error_rad",
        "angle between the headings of the robot and of `target` at the end",
    ),
    info(Own::StandingShare, "standing_share", "fraction of the time in which the robot stood still"),
    info(Own::StandingEndS, "standing_end_s", "time for which the robot had stood still when the run ended"),
    info(Own::BackwardsShare, "backwards_share", "fraction of the distance that was driven backwards"),
    info(
        Own::SaturatedShare,
        "saturated_share",
        "fraction of the time in which a motor signal was at its limit",
    ),
    info(Own::SignalBias, "signal_bias", "mean of the right motor's signal less the left one's, halved"),
    info(Own::FirstCollisionS, "first_collision_s", "time of the robot's first collision"),
    info(Own::InGoalsS, "in_goals_s", "time that the robot spent in zones with `goal`"),
    info(Own::Commands, "commands", "commands that the microcontroller obeyed"),
    info(Own::BytesDown, "bytes_down", "bytes that went from the brain to the robot"),
    info(Own::BytesUp, "bytes_up", "bytes that went from the robot to the brain"),
    info(
        Own::QueueMaxBytes,
        "queue_max_bytes",
        "most bytes that waited for the cable to the robot, or were on it",
    ),
    info(Own::Beliefs, "beliefs", "poses that the brain published as its belief"),
    info(Own::BeliefErrorMeanM, "belief_error_mean_m", "mean distance of these poses from the truth"),
    info(Own::BeliefErrorMaxM, "belief_error_max_m", "largest distance of such a pose from the truth"),
    info(Own::BeliefErrorEndM, "belief_error_end_m", "distance of the last such pose from the truth"),
    info(
        Own::QuadraticCost,
        "quadratic_cost",
        "integral over the run of the importance of each of `deficits` times its square",
    ),
];

const fn info(own: Own, name: &'static str, meaning: &'static str) -> MeasureInfo {
    MeasureInfo { own, name, meaning }
}

impl Measure {
    /// All measures: figures first.
    pub fn all() -> impl Iterator<Item = Self> {
        let figures = INFOS.iter().map(|info| Self::Figure(info.figure));
        figures.chain(MEASURES.iter().map(|info| Self::Own(info.own)))
    }
}

impl Measure {
    /// Whether it is a part of a whole, which people read as a percentage.
    pub(crate) fn is_share(self) -> bool {
        match self {
            Self::Figure(figure) => figure.info().is_share,
            Self::Own(own) => MEASURES[own as usize].name.ends_with("_share"),
        }
    }
}

impl Quantity for Measure {
    fn named(name: &str) -> Result<Self, UnknownName> {
        let names: Vec<_> = Self::all().map(Self::name).collect();
        let found = Self::all().find(|measure| measure.name() == name);
        found.ok_or_else(|| UnknownName::new("measure", name, &names))
    }

    fn name(self) -> &'static str {
        match self {
            Self::Figure(figure) => figure.info().name,
            Self::Own(own) => MEASURES[own as usize].name,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measure_stands_in_its_place_and_in_the_book() {
        let book = include_str!("../../../../docs/how-to/grading.md");
        for (i, info) in MEASURES.iter().enumerate() {
            assert_eq!(info.own as usize, i, "{}", info.name);
            assert_eq!(Measure::named(info.name), Ok(Measure::Own(info.own)));
            assert!(book.contains(&format!("\n| `{}` | ", info.name)), "{}", info.name);
        }
        assert_eq!(Measure::all().count(), INFOS.len() + MEASURES.len());
    }

    #[test]
    fn a_wrong_name_is_told_with_the_nearest() {
        let error = Measure::named("turnd_rad").unwrap_err().to_string();
        assert!(error.starts_with("there is no measure `turnd_rad`; did you mean `turned_rad`?"), "{error}");
        assert_eq!(Measure::named("collisions"), Ok(Measure::Figure(Figure::Collisions)));
    }
}
