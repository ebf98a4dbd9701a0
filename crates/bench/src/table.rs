//! The measurements as a table for people.

use baudbot_bench::catalogue::Workload;
use baudbot_bench::outcome::Outcome;

use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;

/// The workloads and what they are.
pub(super) fn list(workloads: &[&Workload]) -> String {
    let width = workloads.iter().map(|workload| workload.name.len()).max().unwrap_or(0);
    workloads.iter().map(|workload| format!("{:<width$}  {}\n", workload.name, workload.summary)).collect()
}

/// A row a workload, then the measurement by turns with it, then the other notes.
pub(super) fn text(measured: &[(&Workload, Outcome)]) -> String {
    let head = ["workload", "median", "min", "max", "unit", "peak memory", "per 10^6 rounds"];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(measured.iter().map(|(_, outcome)| row(outcome)));
    let mut text = table("", &rows);
    let others: Vec<_> = measured.iter().filter_map(|(_, outcome)| beside(outcome)).collect();
    if !others.is_empty() {
        text += "\nby turns with it in the same run\n";
        text += &table("  ", &others);
    }
    let hashes: Vec<_> = measured.iter().filter_map(|(_, outcome)| hash(outcome)).collect();
    if !hashes.is_empty() {
        text += "\nfingerprints, the same on every machine\n";
        text += &table("  ", &hashes);
    }
    for (_, outcome) in measured {
        for note in &outcome.notes {
            text += &format!("\n{}: {note}", outcome.workload);
        }
    }
    text.trim_end().to_owned() + "\n"
}

/// Rows as lines, the first column to the left and the others to the right.
fn table<const N: usize>(indent: &str, rows: &[[String; N]]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).add_rows(rows);
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        column.set_cell_alignment(if i == 0 { CellAlignment::Left } else { CellAlignment::Right });
    }
    table.lines().map(|line| format!("{}\n", format!("{indent}{line}").trim_end())).collect()
}

fn row(outcome: &Outcome) -> [String; 7] {
    let [least, greatest] = outcome.spread();
    let memory = outcome.peak_memory_bytes.map(|bytes| format!("{:.1} MB", bytes as f64 / 1e6));
    [
        outcome.workload.clone(),
        figure(outcome.median()),
        figure(least),
        figure(greatest),
        outcome.unit.clone(),
        memory.unwrap_or_else(|| NOTHING.to_owned()),
        figure(outcome.median_per_million_rounds()),
    ]
}

fn beside(outcome: &Outcome) -> Option<[String; 4]> {
    let beside = outcome.beside.as_ref()?;
    let ratio = format!("{} ×", figure(beside.median_ratio(outcome)));
    Some([outcome.workload.clone(), beside.what.clone(), figure(beside.median()), ratio])
}

fn hash(outcome: &Outcome) -> Option<[String; 3]> {
    let ticks = outcome.hash_ticks?;
    Some([outcome.workload.clone(), outcome.hash.clone()?, format!("after {ticks} ticks")])
}

/// The text in place of a missing number.
const NOTHING: &str = "—";

/// A number that is not below 0 with four digits that count, thousands apart.
pub(super) fn figure(number: f64) -> String {
    if !number.is_finite() {
        return NOTHING.to_owned();
    }
    if number == 0.0 {
        return "0".to_owned();
    }
    let place = number.abs().log10().floor() as i32;
    if place >= 3 {
        let unit = 10_f64.powi(place - 3);
        return HumanCount(((number / unit).round() * unit) as u64).to_string();
    }
    format!("{number:.*}", (3 - place).clamp(0, 9) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_the_digits_that_count() {
        let found = [0.0, 0.004_521_7, 12.346, 739.96, 1439.9, 143_987.2, 38_512_345.0, f64::NAN].map(figure);
        assert_eq!(found, ["0", "0.004522", "12.35", "740.0", "1,440", "144,000", "38,510,000", "—"]);
    }
}
