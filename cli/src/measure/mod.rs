//! `baudbot measure`: what is measured at a real robot on the desk, as tables that `baudbot fit` reads.
//!
//! [`echo`] times bytes on a serial port, [`curve`] collects a sensor's readings at distances, [`step`] measures wheels
//! that are commanded to turn. [`port`] is the serial port, [`table`] a table that can be continued, [`typed`] asks a
//! person, [`numbers`] finds numbers in replies.

mod curve;
mod echo;
mod numbers;
mod port;
mod step;
mod table;
mod typed;

use std::io::{self, IsTerminal};
use std::process::ExitCode;

use baudbot_plot::quantity::handy;

use crate::args::MeasureCommand;
use crate::text::pairs;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

pub(crate) fn measure(command: &MeasureCommand) -> anyhow::Result<ExitCode> {
    match command {
        MeasureCommand::Echo(args) => echo::echo(args),
        MeasureCommand::Curve(args) => curve::curve(args),
        MeasureCommand::Step(args) => step::step(args),
    }
}

/// A bar for so many things, if stderr is a terminal.
fn progress(number: u32, what: &str, quiet: bool) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(number.into()), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {what}, {{eta}} to go"));
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The beginning of a table: lines `# name: value`, and the names of its columns.
fn header(notes: &[(&str, String)], columns: &str) -> String {
    let notes: String = notes.iter().map(|(name, value)| format!("# {name}: {value}\n")).collect();
    notes + columns + "\n"
}

/// Numbers in a few words: how many, mean, standard deviation, and some of their percentiles.
fn summary(what: &str, numbers: &[f64], unit: &str) -> String {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(least), Some(most)) = (sorted.first(), sorted.last()) else { return format!("{what}  none\n") };
    let count = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / count;
    let squares = sorted.iter().map(|number| (number - mean) * (number - mean)).sum::<f64>();
    let sd = (squares / (count - 1.0).max(1.0)).sqrt();
    let percentile = |share: f64| sorted[((share * count).ceil() as usize).clamp(1, sorted.len()) - 1];
    let with_unit = |number: f64| format!("{} {unit}", handy(number));
    pairs(
        "",
        &[
            (what, sorted.len().to_string()),
            ("mean", with_unit(mean)),
            ("sd", with_unit(sd)),
            ("min", with_unit(*least)),
            ("p50", with_unit(percentile(0.5))),
            ("p99", with_unit(percentile(0.99))),
            ("max", with_unit(*most)),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_has_percentiles_by_rank() {
        let numbers: Vec<_> = (1..=200).rev().map(f64::from).collect();
        let words = summary("echoes", &numbers, "ms");
        for line in ["echoes  200", "mean    100.5 ms", "sd      57.879 ms", "min     1 ms", "p50     100 ms"]
        {
            assert!(words.contains(line), "{line}: {words}");
        }
        assert!(words.contains("p99     198 ms\nmax     200 ms\n"), "{words}");
        assert!(summary("echoes", &[2.0], "ms").contains("sd      0 ms"));
        assert_eq!(summary("echoes", &[], "ms"), "echoes  none\n");
    }

    #[test]
    fn a_header_is_notes_and_columns() {
        let text =
            header(&[("experiment", "echo".to_owned()), ("baud", "9600".to_owned())], "sent_us,received_us");
        assert_eq!(text, "# experiment: echo\n# baud: 9600\nsent_us,received_us\n");
    }
}
