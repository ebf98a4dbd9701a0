//! Gradings as JUnit XML, which continuous integration shows: an exercise is a suite, a criterion a case.

use std::fmt::Write;

use crate::exercise::Exercise;
use crate::grading::{Grading, Verdict};

/// The text of a file.
pub fn junit(exercise: &Exercise, grading: &Grading) -> String {
    let cases = exercise.criteria.iter().zip(&grading.awarded);
    let is_short = |count: usize| count < grading.runs.len();
    let (failures, errors) = match grading.verdict {
        Verdict::NotGraded => (0, exercise.criteria.len()),
        Verdict::Passed | Verdict::Failed => {
            (grading.awarded.iter().filter(|awarded| is_short(awarded.count())).count(), 0)
        }
    };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\">\n",
        escaped(&exercise.name),
        exercise.criteria.len()
    );
    let words = escaped(&grading.findings.join("\n"));
    for (criterion, awarded) in cases {
        let case = format!("classname=\"{}\" name=\"{}\"", escaped(&exercise.name), escaped(&criterion.name));
        let values = grading.values(criterion).unwrap_or_default();
        let message = format!("{} of {} seeds{values}", awarded.count(), grading.runs.len());
        let message = escaped(&message);
        let _ = match (grading.verdict, is_short(awarded.count())) {
            (Verdict::NotGraded, _) => writeln!(
                text,
                "  <testcase {case}><error message=\"cannot be graded\">{words}</error></testcase>"
            ),
            (_, false) => writeln!(text, "  <testcase {case}/>"),
            (_, true) => writeln!(
                text,
                "  <testcase {case}><failure message=\"{message}\">{words}</failure></testcase>"
            ),
        };
    }
    text + "</testsuite>\n"
}

/// Text of others, as XML can have it: characters that XML has no place for become `?`.
fn escaped(text: &str) -> String {
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
