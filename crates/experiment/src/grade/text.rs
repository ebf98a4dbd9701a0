//! Gradings and exercises as text for people.

use std::fmt::Write;

use crate::success::Quantity;

use crate::grade::advice::shown;
use crate::grade::exercise::{Criterion, Exercise};
use crate::grade::grading::{Grading, Verdict};
use crate::grade::points::Awarded;

impl Exercise {
    /// The title of the exercise, with the section of the notes.
    pub fn headline(&self) -> String {
        let section =
            if self.section.is_empty() { String::new() } else { format!(" (section {})", self.section) };
        format!("{}: {}{section}", self.name, self.title)
    }

    /// The task, and what earns points.
    pub fn described(&self) -> String {
        let mut text = format!(
            "{}\n\n{}\n\nscenario  {}\nseeds     {}\n\n",
            self.headline(),
            self.task,
            self.scenario,
            self.seeds.count()
        );
        for criterion in &self.criteria {
            let _ =
                writeln!(text, "{:>6}  {} ({})", points(criterion.points), criterion.name, criterion.needs);
        }
        let _ = writeln!(
            text,
            "\npassed with {} of {} points",
            shown(self.pass * self.points()),
            points(self.points())
        );
        text
    }
}

impl Grading {
    /// The result in words.
    pub fn text(&self, exercise: &Exercise) -> String {
        let mut text = format!("{}\n\n", exercise.headline());
        if self.verdict != Verdict::NotGraded {
            for (criterion, awarded) in exercise.criteria.iter().zip(&self.awarded) {
                let _ = writeln!(text, "  {}", self.line(criterion, awarded));
            }
            text.push('\n');
        }
        let (earned, of) = (points(self.points), points(exercise.points()));
        text += &match self.verdict {
            Verdict::Passed => format!("passed: {earned} of {of} points\n"),
            Verdict::Failed => {
                format!(
                    "not passed: {earned} of {of} points, {} are needed\n",
                    shown(exercise.pass * exercise.points())
                )
            }
            Verdict::NotGraded => "cannot be graded: the brain drove in no run\n".to_owned(),
        };
        for finding in &self.findings {
            let _ = writeln!(text, "- {}", finding.replace('\n', "\n  "));
        }
        text
    }

    /// Points, the criterion, and what kept runs from it.
    fn line(&self, criterion: &Criterion, awarded: &Awarded) -> String {
        let (earned, of) = (points(awarded.points), points(criterion.points));
        let name = &criterion.name;
        match awarded.count() {
            count if count == self.runs.len() => format!("{earned:>5} of {of}  {name}"),
            count => {
                let was = self.values(criterion).unwrap_or_default();
                format!("{earned:>5} of {of}  {name}: in {count} of {} seeds{was}", self.runs.len())
            }
        }
    }

    /// The values of what was not kept: `; collisions: 1 to 3, needed: no collision`.
    pub(crate) fn values(&self, criterion: &Criterion) -> Option<String> {
        let mut text = String::new();
        for condition in criterion.needs.iter() {
            let values = self.runs.iter().filter_map(|run| run.measures());
            let values: Vec<_> = values.map(|measures| measures.get(condition.quantity)).collect();
            if values.iter().all(|value| condition.holds(*value)) {
                continue;
            }
            let name = condition.quantity.name();
            let known: Vec<f64> = values.iter().filter_map(|value| *value).collect();
            let least = known.iter().copied().reduce(f64::min).map(shown);
            let most = known.iter().copied().reduce(f64::max).map(shown);
            let was = match (least, most) {
                (Some(least), Some(most)) if least == most => least,
                (Some(least), Some(most)) => format!("{least} to {most}"),
                (None, _) | (_, None) => "missing".to_owned(),
            };
            let missing = if known.len() < values.len() && !known.is_empty() { " or missing" } else { "" };
            let _ = write!(text, "; {name}: {was}{missing}, needed: {condition}");
        }
        (!text.is_empty()).then_some(text)
    }
}

/// Points: two digits behind the point, if there are any.
fn points(points: f64) -> String {
    let text = format!("{points:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
