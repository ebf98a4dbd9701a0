//! Gradings as JUnit XML, which continuous integration shows: an exercise is a suite, a criterion a case.

use std::fmt::{Display, Write};

use crate::grade::exercise::Exercise;
use crate::grade::grading::{Grading, Verdict};

/// One of those whose brains are graded on an exercise.
pub struct Pupil<'a> {
    /// The name of the brain's author.
    pub name: &'a str,
    /// The grading of the brain, or the reason why it could not be graded.
    pub outcome: Result<&'a Grading, &'a dyn Display>,
}

/// The text of a file.
pub fn junit(exercise: &Exercise, grading: &Grading) -> String {
    HEAD.to_owned() + &suite(exercise, &exercise.name, Ok(grading))
}

/// The text of a file in which each of a class is a suite.
pub fn class(exercise: &Exercise, pupils: &[Pupil<'_>]) -> String {
    let suites = pupils
        .iter()
        .map(|pupil| suite(exercise, &format!("{}.{}", exercise.name, pupil.name), pupil.outcome));
    format!("{HEAD}<testsuites>\n{}</testsuites>\n", suites.collect::<String>())
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

fn suite(exercise: &Exercise, name: &str, outcome: Result<&Grading, &dyn Display>) -> String {
    let (name, all) = (escaped(name), exercise.criteria.len());
    let short = |grading: &Grading, place: usize| grading.awarded[place].count() < grading.runs.len();
    let graded = outcome.ok().filter(|grading| grading.verdict != Verdict::NotGraded);
    let (failures, errors) = match graded {
        None => (0, all),
        Some(grading) => ((0..all).filter(|place| short(grading, *place)).count(), 0),
    };
    let mut text =
        format!("<testsuite name=\"{name}\" tests=\"{all}\" failures=\"{failures}\" errors=\"{errors}\">\n");
    let words = match outcome {
        Ok(grading) => escaped(&grading.findings.join("\n")),
        Err(problem) => escaped(&problem.to_string()),
    };
    for (place, criterion) in exercise.criteria.iter().enumerate() {
        let case = format!("classname=\"{name}\" name=\"{}\"", escaped(&criterion.name));
        let _ = match graded {
            None => writeln!(
                text,
                "  <testcase {case}><error message=\"cannot be graded\">{words}</error></testcase>"
            ),
            Some(grading) if short(grading, place) => {
                let values = grading.values(criterion).unwrap_or_default();
                let (count, runs) = (grading.awarded[place].count(), grading.runs.len());
                let message = escaped(&format!("{count} of {runs} seeds{values}"));
                writeln!(
                    text,
                    "  <testcase {case}><failure message=\"{message}\">{words}</failure></testcase>"
                )
            }
            Some(_) => writeln!(text, "  <testcase {case}/>"),
        };
    }
    text + "</testsuite>\n"
}

/// Text of others, escaped for XML: characters that XML has no place for become `?`.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\n' => escaped += "&#10;",
            '\t' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'.. => escaped.push(c),
            _ => escaped.push('?'),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_is_sound_xml() {
        let hostile = "<a b=\"c\">&\u{1b}[31m\n\u{fffe}µ";
        let text = format!("<x y=\"{0}\">{0}</x>", escaped(hostile));
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        assert_eq!(root.text(), Some("<a b=\"c\">&?[31m\n?µ"));
        assert_eq!(root.attribute("y"), root.text());
    }
}
