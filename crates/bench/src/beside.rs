//! A workload of another program, or of another build of this one, by turns with ours: the only ratio that means something.

use std::process::{Command, ExitStatus, Stdio};

use regex::Regex;
use serde::Serialize;

use crate::instructions::tail;
use crate::measure::median;

/// A command of another program, and what reads its figure from what it writes.
#[derive(Clone, Debug)]
pub struct Other {
    command: String,
    pattern: Option<Regex>,
}

/// The reason why there is no figure of the other program.
#[derive(Debug, thiserror::Error)]
pub enum OtherError {
    /// The pattern is none.
    #[error("--pattern: {0}")]
    Pattern(#[from] regex::Error),
    /// The pattern has no place for the figure.
    #[error("--pattern `{0}` has no group: put the figure into parentheses, such as `([0-9.]+) steps/s`")]
    NoGroup(String),
    /// The shell could not be started.
    #[error("cannot start `sh -c`: {0}")]
    Start(std::io::Error),
    /// The command failed.
    #[error("`{command}` ended with {status}:\n{said}")]
    Failed {
        /// The command.
        command: String,
        /// The exit status.
        status: ExitStatus,
        /// The end of its output.
        said: String,
    },
    /// The command's output has no figure.
    #[error("`{command}` wrote no figure of {workload} {mending}; its output ends with:\n{said}")]
    NoFigure {
        /// The command.
        command: String,
        /// The workload whose figure is missing.
        workload: String,
        /// The remedy.
        mending: &'static str,
        /// The end of its output.
        said: String,
    },
}

impl Other {
    /// A command for the shell. `pattern` is a regular expression whose first group is the figure; without one, the output
    /// is read as that of `baudbot-bench`, JSON or table.
    ///
    /// # Errors
    /// If the pattern is none, or has no group.
    pub fn new(command: &str, pattern: Option<&str>) -> Result<Self, OtherError> {
        let pattern = pattern.map(Regex::new).transpose()?;
        if let Some(pattern) = pattern.as_ref().filter(|pattern| pattern.captures_len() < 2) {
            return Err(OtherError::NoGroup(pattern.as_str().to_owned()));
        }
        Ok(Self { command: command.to_owned(), pattern })
    }

    /// Runs it once; its figure of this workload.
    ///
    /// # Errors
    /// If it fails or writes no figure.
    pub fn run(&self, workload: &str) -> Result<f64, OtherError> {
        let run = Command::new("sh").args(["-c", &self.command]).stdin(Stdio::null()).output();
        let run = run.map_err(OtherError::Start)?;
        let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        let said = || tail(&format!("{out}\n{err}"), TAIL);
        if !run.status.success() {
            return Err(OtherError::Failed {
                command: self.command.clone(),
                status: run.status,
                said: said(),
            });
        }
        self.figure(&out, workload).ok_or_else(|| OtherError::NoFigure {
            command: self.command.clone(),
            workload: workload.to_owned(),
            mending: match &self.pattern {
                Some(_) => "that --pattern finds",
                None => "as baudbot-bench does; --pattern says what another program's looks like",
            },
            said: said(),
        })
    }

    /// The figure of a workload in an output.
    fn figure(&self, text: &str, workload: &str) -> Option<f64> {
        let figure = match &self.pattern {
            Some(pattern) => number(pattern.captures_iter(text).last()?.get(1)?.as_str())?,
            None => of_json(text, workload).or_else(|| of_table(text, workload))?,
        };
        (figure.is_finite() && figure > 0.0).then_some(figure)
    }
}

/// The median in what `baudbot-bench --json -` writes.
fn of_json(text: &str, workload: &str) -> Option<f64> {
    let all: serde_json::Value = serde_json::from_str(text).ok()?;
    let own = all["workloads"].as_array()?.iter().find(|own| own["workload"] == workload)?;
    own["median"].as_f64()
}

/// The median in the table that `baudbot-bench` writes.
fn of_table(text: &str, workload: &str) -> Option<f64> {
    let row = text.lines().map(str::split_whitespace).find_map(|mut words| {
        (words.next() == Some(workload)).then_some(words).and_then(|mut words| words.next())
    });
    number(row?)
}

/// The number, with or without commas between thousands.
fn number(text: &str) -> Option<f64> {
    text.trim().replace(',', "").parse().ok()
}

/// Ratios of pairs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pairs {
    /// The workload.
    pub workload: String,
    /// Unit of the figures.
    pub unit: String,
    /// Figures of ours and of the other program, in the order in which they were measured.
    pub figures: Vec<[f64; 2]>,
}

impl Pairs {
    /// Ours divided by the other's, a pair each.
    fn ratios(&self) -> impl Iterator<Item = f64> {
        self.figures.iter().map(|[own, other]| own / other)
    }

    /// The median of the ratios.
    pub fn median(&self) -> f64 {
        median(self.ratios())
    }

    /// The least and the greatest of the ratios.
    pub fn spread(&self) -> [f64; 2] {
        [self.ratios().fold(f64::INFINITY, f64::min), self.ratios().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The medians of the figures, ours and the other's.
    pub fn medians(&self) -> [f64; 2] {
        [0, 1].map(|i| median(self.figures.iter().map(|pair| pair[i])))
    }
}

/// Lines of an output that an error shows.
const TAIL: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(pattern: Option<&str>, text: &str) -> Option<f64> {
        Other::new("true", pattern).unwrap().figure(text, "W3/100")
    }

    #[test]
    fn our_own_json_and_table_are_read_without_a_pattern() {
        let json = r#"{ "workloads": [{ "workload": "W3/10", "median": 1.5 }, { "workload": "W3/100", "median": 2.5 }] }"#;
        assert_eq!(figure(None, json), Some(2.5));
        let table = "workload   median   min\nW3/1000  396,000  390,400\nW3/100   887,500  861,400\n";
        assert_eq!(figure(None, table), Some(887_500.0));
        assert_eq!(figure(None, "W3/100 is fast"), None);
        assert_eq!(figure(None, "W3/100"), None);
    }

    #[test]
    fn a_pattern_takes_its_first_group_where_it_is_found_last() {
        let pattern = Some(r"([0-9.]+) steps/s");
        assert_eq!(figure(pattern, "warm-up: 10.5 steps/s\n142.25 steps/s\n"), Some(142.25));
        assert_eq!(figure(pattern, "nothing"), None);
        assert_eq!(figure(Some("(-?[0-9]+)"), "-3"), None, "no figure is negative");
    }

    #[test]
    fn what_is_wrong_is_told_with_the_end_of_the_output() {
        let error = |command: &str, pattern: Option<&str>| {
            Other::new(command, pattern).and_then(|other| other.run("W2")).unwrap_err().to_string()
        };
        let no_group =
            "--pattern `[0-9]+` has no group: put the figure into parentheses, such as `([0-9.]+) steps/s`";
        assert_eq!(error("true", Some("[0-9]+")), no_group);
        assert!(error("true", Some("(")).starts_with("--pattern: regex parse error"));
        assert_eq!(error("echo no; exit 3", None), "`echo no; exit 3` ended with exit status: 3:\nno");
        let none = error("seq 20", Some("(x)"));
        assert!(
            none.starts_with(
                "`seq 20` wrote no figure of W2 that --pattern finds; its output ends with:\n13\n"
            )
        );
        assert!(error("echo", None).contains("--pattern says what another program's looks like"));
    }

    #[test]
    fn pairs_have_the_median_of_their_ratios() {
        let figures = vec![[2.0, 1.0], [9.0, 3.0], [8.0, 2.0]];
        let pairs = Pairs { workload: "W2".to_owned(), unit: "rays/s".to_owned(), figures };
        assert_eq!((pairs.median(), pairs.spread(), pairs.medians()), (3.0, [2.0, 4.0], [8.0, 2.0]));
    }
}
