//! The table of the crates, and what the house rules forbid.

use std::cmp::Ordering;
use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::measure::{Crate, Fault};
use super::prose::Prose;
use super::{EXCEPTIONS, Error};

/// The most clause-comments among a thousand comments.
const CLAUSES_IN_1000: usize = 20;

/// The exceptions of a check.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Exceptions {
    knots: Vec<Circle>,
    long_functions: Vec<Place>,
    long_files: Vec<Place>,
    string_errors: Vec<Place>,
    read_errors: Vec<Place>,
    participles: Vec<Place>,
    at_most: AtMost,
}

/// Numbers that the tree may not exceed while it is on its way to the rule; each may only shrink. The default is the rule.
#[derive(Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct AtMost {
    clause_comments_in_1000: usize,
    participles: usize,
}

impl Default for AtMost {
    fn default() -> Self {
        Self { clause_comments_in_1000: CLAUSES_IN_1000, participles: 0 }
    }
}

/// Modules of a crate that may reach each other.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Circle {
    #[serde(rename = "crate")]
    name: String,
    modules: Vec<String>,
    #[expect(dead_code, reason = "it is for people; but an exception without one is refused")]
    reason: String,
}

/// A file, or behind a colon a function in it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    place: String,
    #[expect(dead_code, reason = "it is for people; but an exception without one is refused")]
    reason: String,
}

impl Exceptions {
    /// The exceptions of the repository at `root`.
    pub(super) fn read(root: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(root.join(EXCEPTIONS));
        let text = text.map_err(|source| Error::Read { path: EXCEPTIONS.to_owned(), source })?;
        toml::from_str(&text).map_err(|source| Error::Exceptions { source })
    }

    /// Those for places, by the name of their table.
    fn places(&self) -> [(&'static str, &[Place]); 5] {
        [
            ("long_functions", &self.long_functions),
            ("long_files", &self.long_files),
            ("string_errors", &self.string_errors),
            ("read_errors", &self.read_errors),
            ("participles", &self.participles),
        ]
    }

    /// The line of a check that finds nothing.
    pub(super) fn nothing_amiss(&self) -> String {
        let AtMost { participles, .. } = self.at_most;
        format!(
            "no circle of modules, nothing too long, no error that is a String or whose text is read; types that are a participle: \
             {participles}, as {EXCEPTIONS} lets pass for now"
        )
    }

    /// The findings in a table that may be there.
    fn at_most(&self, table: &str) -> usize {
        match table {
            "participles" => self.at_most.participles,
            _ => 0,
        }
    }
}

/// The findings that no exception lets pass, and exceptions that nothing needs any more.
pub(super) fn amiss(crates: &[Crate], exceptions: &Exceptions) -> Vec<String> {
    let mut wrong = Vec::new();
    for measured in crates {
        wrong.extend(circles_amiss(measured, &exceptions.knots));
    }
    for (table, places) in exceptions.places() {
        let found: Vec<_> =
            crates.iter().flat_map(|measured| places_amiss(measured, table, places)).collect();
        let most = exceptions.at_most(table);
        match found.len().cmp(&most) {
            Ordering::Greater => wrong.extend(found),
            Ordering::Less => wrong.push(format!(
                "{EXCEPTIONS}: [at_most] {table}: is {most}, and there are {}; write that",
                found.len()
            )),
            Ordering::Equal => {}
        }
    }
    let (clauses, most) = (prose(crates).clauses_in_1000(), exceptions.at_most.clause_comments_in_1000);
    if clauses > most {
        wrong.push(format!(
            "{clauses} of 1,000 comments begin with What, How, Where, Which, Who or Why as a clause, more than {most}; \
             write sentences with a noun as their subject"
        ));
    }
    let circles =
        exceptions.knots.iter().filter(|circle| !crates.iter().any(|measured| circle.is_needed(measured)));
    wrong.extend(circles.map(|circle| not_needed("knots", &circle.name)));
    for (table, places) in exceptions.places() {
        let places =
            places.iter().filter(|place| !crates.iter().any(|measured| place.is_needed(measured, table)));
        wrong.extend(places.map(|place| not_needed(table, &place.place)));
    }
    wrong
}

impl Circle {
    fn lets_pass(&self, measured: &Crate, circle: &[String]) -> bool {
        self.name == measured.name && circle.iter().all(|module| self.modules.contains(module))
    }

    fn is_needed(&self, measured: &Crate) -> bool {
        measured.circles.iter().any(|circle| self.lets_pass(measured, circle))
    }
}

impl Place {
    fn lets_pass(&self, measured: &Crate, place: &str) -> bool {
        self.place == format!("{}/src/{place}", measured.name)
    }

    fn is_needed(&self, measured: &Crate, table: &str) -> bool {
        let mut findings = measured.findings.iter().filter(|finding| finding.fault.table() == table);
        findings.any(|finding| self.lets_pass(measured, &finding.place))
    }
}

fn circles_amiss(measured: &Crate, exceptions: &[Circle]) -> impl Iterator<Item = String> {
    let passes = |circle: &[String]| exceptions.iter().any(|exception| exception.lets_pass(measured, circle));
    let wrong = measured.circles.iter().filter(move |circle| !passes(circle));
    wrong.map(|circle| {
        format!(
            "{}: these modules reach each other in a circle: {}; move what they share into one below them",
            measured.name,
            circle.join(" ")
        )
    })
}

fn places_amiss(measured: &Crate, table: &str, exceptions: &[Place]) -> impl Iterator<Item = String> {
    let passes = |place: &str| exceptions.iter().any(|exception| exception.lets_pass(measured, place));
    let wrong = measured.findings.iter().filter(move |finding| finding.fault.table() == table);
    wrong
        .filter(move |finding| !passes(&finding.place))
        .map(|finding| format!("{}/src/{}: {}", measured.name, finding.place, finding.fault))
}

fn not_needed(table: &str, exception: &str) -> String {
    format!("{EXCEPTIONS}: [[{table}]] {exception}: nothing needs this exception any more; remove it")
}

/// The sizes of the crates, then the circles and the places that break rules.
pub(super) fn table(crates: &[Crate]) -> String {
    let mut text = row("crate", &COLUMNS);
    let mut total = [0; COLUMNS.len()];
    for measured in crates {
        let numbers = numbers(measured);
        for (sum, number) in total.iter_mut().zip(numbers) {
            *sum += number;
        }
        text += &row(&measured.name, &numbers);
    }
    text += &row("all", &total);
    let prose = prose(crates);
    text += &format!(
        "\nclause-comments: {} of 1,000 comments, {CLAUSES_IN_1000} may be\n",
        prose.clauses_in_1000()
    );
    text += "\nknots:\n";
    for measured in crates {
        for circle in &measured.circles {
            text += &format!("  {}: {}\n", measured.name, circle.join(" "));
        }
    }
    for (title, table) in LISTS {
        text += &format!("\n{title}:\n");
        text.extend(crates.iter().flat_map(|measured| places(measured, table)));
    }
    text
}

/// The comments of all crates.
fn prose(crates: &[Crate]) -> Prose {
    crates.iter().fold(Prose::default(), |sum, measured| sum.plus(measured.prose))
}

const COLUMNS: [&str; 11] = [
    "files",
    "code",
    "tests",
    "modules",
    "in knots",
    "_ =>",
    "String errors",
    "participles",
    "long fns",
    "comments",
    "clauses",
];
const WIDTHS: [usize; COLUMNS.len()] = [6, 8, 8, 9, 9, 6, 15, 13, 9, 10, 9];
const LISTS: [(&str, &str); 5] = [
    ("functions over 40 lines", "long_functions"),
    ("files over 400 lines", "long_files"),
    ("errors that are a String", "string_errors"),
    ("errors whose text is read", "read_errors"),
    ("types that are mere participles", "participles"),
];

fn numbers(measured: &Crate) -> [usize; COLUMNS.len()] {
    let count = |table| measured.findings.iter().filter(|finding| finding.fault.table() == table).count();
    [
        measured.files,
        measured.code,
        measured.tests,
        measured.modules,
        measured.circles.iter().map(Vec::len).sum(),
        measured.wildcards,
        count("string_errors"),
        count("participles"),
        count("long_functions"),
        measured.prose.comments,
        measured.prose.clauses,
    ]
}

fn row(name: &str, cells: &[impl ToString]) -> String {
    let cells = cells.iter().zip(WIDTHS).map(|(cell, width)| format!("{:>width$}", cell.to_string()));
    format!("{name:38}{}\n", cells.collect::<String>())
}

/// A line for each finding of a kind.
fn places(measured: &Crate, table: &str) -> impl Iterator<Item = String> {
    let findings = measured.findings.iter().filter(move |finding| finding.fault.table() == table);
    findings.map(|finding| format!("  {}: {}{}\n", measured.name, finding.place, lines(finding.fault)))
}

/// The number of lines of a place that is too long, behind a blank.
fn lines(fault: Fault) -> String {
    match fault {
        Fault::LongFunction { lines } | Fault::LongFile { lines } => format!(" {lines}"),
        Fault::StringError | Fault::ReadError | Fault::ParticipleType => String::new(),
    }
}
