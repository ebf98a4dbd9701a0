//! Gradings and exercises as JSON, for programs. `docs/how-to/grading.md` describes the fields.

use serde_json::{Map, Value, json};

use crate::grade::exercise::Exercise;
use crate::grade::grading::Grading;
use crate::grade::measure::Measure;
use crate::grade::run::Run;
use crate::success::Quantity;

/// The fields at the top of a grading.
pub const JSON_FIELDS: [&str; 10] = [
    "exercise",
    "title",
    "section",
    "verdict",
    "points",
    "points_needed",
    "points_of",
    "findings",
    "criteria",
    "runs",
];

impl Exercise {
    /// The exercise without its scenario.
    pub fn json(&self) -> Value {
        let criterion = |criterion: &crate::grade::exercise::Criterion| json!({ "name": criterion.name, "points_of": criterion.points, "needs": criterion.needs.to_string() });
        json!({
            "exercise": self.name,
            "title": self.title,
            "section": self.section,
            "task": self.task,
            "scenario": self.scenario,
            "points_needed": self.pass * self.points(),
            "points_of": self.points(),
            "criteria": self.criteria.iter().map(criterion).collect::<Vec<_>>(),
        })
    }
}

impl Grading {
    /// The result as JSON.
    pub fn json(&self, exercise: &Exercise) -> Value {
        let criteria = exercise.criteria.iter().zip(&self.awarded).map(|(criterion, awarded)| {
            json!({
                "name": criterion.name,
                "points": awarded.points,
                "points_of": criterion.points,
                "needs": criterion.needs.to_string(),
                "runs_fulfilled": awarded.count(),
            })
        });
        json!({
            "exercise": exercise.name,
            "title": exercise.title,
            "section": exercise.section,
            "verdict": self.verdict.name(),
            "points": self.points,
            "points_needed": exercise.pass * exercise.points(),
            "points_of": exercise.points(),
            "findings": self.findings,
            "criteria": criteria.collect::<Vec<_>>(),
            "runs": (0..).zip(&self.runs).map(|(place, run)| self.run_json(place, run)).collect::<Vec<_>>(),
        })
    }

    fn run_json(&self, place: usize, run: &Run) -> Value {
        let hits =
            run.hits.iter().map(|hit| json!({ "at_s": hit.at_s, "robot": hit.robot, "with": hit.with }));
        let mut json = json!({
            "seed": run.seed,
            "time_s": run.time_s,
            "fulfilled": self.awarded.iter().map(|awarded| awarded.fulfilled[place]).collect::<Vec<_>>(),
            "collisions": hits.collect::<Vec<_>>(),
        });
        match &run.outcome {
            Err(problem) => json["problem"] = problem.to_string().into(),
            Ok(ended) => {
                json["ending"] = ended.ending.clone().into();
                json["state_hash"] = format!("{:016x}", ended.hash).into();
                let value =
                    |measure: Measure| (measure.name().to_owned(), ended.measures.get(measure).into());
                json["measures"] = Value::Object(Measure::all().map(value).collect::<Map<_, _>>());
            }
        }
        json
    }
}
