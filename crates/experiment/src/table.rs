//! The summary as a table for people.

use std::fmt::Write;

use baudbot_plot::quantity::NOTHING;
use baudbot_plot::text::columns;

use crate::experiment::Experiment;
use crate::figures::{Figure, INFOS};
use crate::paired::Comparison;
use crate::statistics::Sample;
use crate::summary::{CellSummary, Summary};

/// The table, of at most so many combinations.
pub fn text(experiment: &Experiment, summary: &Summary, most: usize) -> String {
    let figures = shown(experiment);
    let mut head: Vec<String> = experiment.fields.iter().map(|field| field.label.clone()).collect();
    head.push("runs".to_owned());
    head.extend(experiment.has_success().then(|| "success".to_owned()));
    head.extend(figures.iter().map(|figure| figure.info().name.to_owned()));
    let cells = summary.cells.iter().take(most);
    let rows: Vec<_> = std::iter::once(head).chain(cells.map(|cell| row(cell, &figures))).collect();
    let mut text = columns("", &rows, |i| i < experiment.fields.len());
    let others = summary.left_out + summary.cells.len().saturating_sub(most) as u64;
    if others > 0 {
        let _ = writeln!(text, "… and {others} more");
    }
    if let Some(success) = experiment.success_text() {
        let _ = writeln!(text, "success: {success}");
    }
    let _ = writeln!(
        text,
        "means over seeds ± half of the 95 % interval (Student), fractions with theirs (Wilson)"
    );
    text + &compared(experiment, summary, most, &figures) + &failures(summary)
}

/// The cells beside the first one.
fn compared(experiment: &Experiment, summary: &Summary, most: usize, figures: &[Figure]) -> String {
    let cells = summary.cells.iter().take(most);
    let cells: Vec<_> = cells.filter_map(|cell| Some((cell, cell.beside_first.as_ref()?))).collect();
    if cells.is_empty() {
        return String::new();
    }
    let mut head: Vec<String> = experiment.fields.iter().map(|field| field.label.clone()).collect();
    head.push("pairs".to_owned());
    if experiment.has_success() {
        head.extend(["success", "p", "seeds for 80 %"].map(str::to_owned));
    }
    head.extend(figures.iter().map(|figure| figure.info().name.to_owned()));
    let row = |(cell, comparison): &(&CellSummary, &Comparison)| {
        let mut row = cell.levels.clone();
        row.push(comparison.pairs.to_string());
        if experiment.has_success() {
            let success = comparison.success();
            row.push(
                success.map_or_else(|| NOTHING.to_owned(), |(share, _)| format!("{:+.0} %", share * 100.0)),
            );
            row.push(success.map_or_else(|| NOTHING.to_owned(), |(_, p)| format!("{p:.3}")));
            row.push(comparison.seeds_needed().map_or_else(|| NOTHING.to_owned(), |seeds| seeds.to_string()));
        }
        row.extend(figures.iter().map(|&figure| mean(&comparison.figures[figure as usize])));
        row
    };
    let rows: Vec<_> = std::iter::once(head).chain(cells.iter().map(row)).collect();
    let first: Vec<_> =
        summary.cells.iter().take(1).flat_map(|cell| cell.levels.iter().map(String::as_str)).collect();
    let title = format!(
        "beside {}, seed by seed: differences ± half of their 95 % interval (Student), p by McNemar's exact test\n",
        first.join(", ")
    );
    title + &columns("", &rows, |i| i < experiment.fields.len())
}

/// The figures that the experiment is about, and a few that are always worth a look.
fn shown(experiment: &Experiment) -> Vec<Figure> {
    let success = experiment.success.iter().flat_map(|success| success.figures());
    let charts = experiment.charts.iter().filter_map(|chart| chart.figure);
    let usual = [Figure::Collisions, Figure::DistanceM, Figure::StalenessMeanMs];
    let chosen: Vec<_> = success.chain(charts).chain(usual).collect();
    INFOS.iter().map(|info| info.figure).filter(|figure| chosen.contains(figure)).collect()
}

fn row(cell: &CellSummary, figures: &[Figure]) -> Vec<String> {
    let mut row = cell.levels.clone();
    row.push(match cell.failed {
        0 => cell.runs.to_string(),
        failed => format!("{} ({failed} failed)", cell.runs),
    });
    if cell.succeeded.is_some() {
        row.push(cell.success().map_or_else(
            || NOTHING.to_owned(),
            |(share, low, high)| format!("{:.0} % ({:.0}–{:.0})", share * 100.0, low * 100.0, high * 100.0),
        ));
    }
    row.extend(figures.iter().map(|&figure| mean(&cell.figures[figure as usize])));
    row
}

fn mean(sample: &Sample) -> String {
    let Some(mean) = sample.mean() else { return NOTHING.to_owned() };
    match sample.half_width() {
        Some(half) => {
            let decimals = decimals(if half > 0.0 { half } else { mean.abs() });
            format!("{mean:.decimals$} ± {half:.decimals$}")
        }
        None => format!("{mean:.0$}", decimals(mean.abs())),
    }
}

/// The number of decimals that shows two digits; none for a whole number.
fn decimals(number: f64) -> usize {
    if number.fract() == 0.0 { 0 } else { (1.0 - number.log10().floor()).clamp(0.0, 6.0) as usize }
}

fn failures(summary: &Summary) -> String {
    if summary.failed == 0 {
        return String::new();
    }
    let mut text = format!("{} of {} runs failed:\n", summary.failed, summary.runs);
    let mut told: Vec<&str> = Vec::new();
    for (run, problem) in &summary.failures {
        // Seeds of a combination fail alike.
        if told.contains(&problem.as_str()) {
            continue;
        }
        told.push(problem);
        let _ = writeln!(text, "  run {run}: {}", problem.replace('\n', " "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_has_as_many_decimals_as_its_interval_deserves() {
        let of = |values: &[f64]| {
            let mut sample = Sample::default();
            values.iter().for_each(|&value| sample.add(value));
            mean(&sample)
        };
        assert_eq!(of(&[]), "—");
        assert_eq!(of(&[12.345_678]), "12");
        assert_eq!(of(&[0.012_345]), "0.012");
        assert_eq!(of(&[0.0, 0.0]), "0 ± 0");
        assert_eq!(of(&[10.0, 11.0, 12.0]), "11.0 ± 2.5");
        assert_eq!(of(&[1000.0, 2000.0]), "1500 ± 6353");
    }
}
