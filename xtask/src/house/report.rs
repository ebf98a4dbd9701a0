//! The table of the crates, and what the house rules forbid.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::measure::{Crate, Fault};
use super::{EXCEPTIONS, Error};

/// What a check says that finds nothing.
pub(super) const NOTHING_AMISS: &str =
    "no circle of modules, nothing too long, no error that is a text, none whose text is read";

/// What a check lets pass.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Exceptions {
    knots: Vec<Circle>,
    long_functions: Vec<Place>,
    long_files: Vec<Place>,
    string_errors: Vec<Place>,
    read_errors: Vec<Place>,
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
    fn places(&self) -> [(&'static str, &[Place]); 4] {
        [
            ("long_functions", &self.long_functions),
            ("long_files", &self.long_files),
            ("string_errors", &self.string_errors),
            ("read_errors", &self.read_errors),
        ]
    }
}

/// What the house rules forbid and no exception lets pass, and exceptions that nothing needs any more.
pub(super) fn amiss(crates: &[Crate], exceptions: &Exceptions) -> Vec<String> {
    let mut wrong = Vec::new();
    for measured in crates {
        wrong.extend(circles_amiss(measured, &exceptions.knots));
        for (table, places) in exceptions.places() {
            wrong.extend(places_amiss(measured, table, places));
        }
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

const COLUMNS: [&str; 8] =
    ["files", "code", "tests", "modules", "in knots", "_ =>", "String errors", "long fns"];
const WIDTHS: [usize; COLUMNS.len()] = [6, 8, 8, 9, 9, 6, 15, 9];
const LISTS: [(&str, &str); 3] = [
    ("functions over 40 lines", "long_functions"),
    ("files over 400 lines", "long_files"),
    ("public functions whose error is a String", "string_errors"),
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
        count("long_functions"),
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

/// How many lines what is too long has, behind a blank.
fn lines(fault: Fault) -> String {
    match fault {
        Fault::LongFunction { lines } | Fault::LongFile { lines } => format!(" {lines}"),
        Fault::StringError | Fault::ReadError => String::new(),
    }
}
