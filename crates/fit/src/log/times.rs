//! The instants of a log: that they increase, and where they leap.

use super::error::{LogError, Problem, Warning};
use super::names::Quantity;
use super::{GAP, Log};

/// Most gaps that are listed one by one.
const LISTED_GAPS: usize = 5;

/// Leaves out copies of rows, puts rows of one instant together whose cells complement each other, as those of merged tables, and
/// finds gaps.
///
/// # Errors
/// If the clock goes back, or a time is there twice with different numbers.
pub(super) fn settle(mut log: Log) -> Result<Log, LogError> {
    let quantity =
        [Quantity::Time, Quantity::Sent].into_iter().find(|quantity| log.column(*quantity).is_some());
    let Some(quantity) = quantity else {
        log.segments = std::iter::once(0..log.len()).collect();
        return Ok(log);
    };
    let copies = copies(&mut log, quantity)?;
    if let Some(&(first, _)) = copies.iter().find(|(_, is_copy)| *is_copy) {
        let rows = copies.iter().filter(|(_, is_copy)| *is_copy).count();
        log.warnings.push(Warning::Copies { rows, line: log.lines[first] });
    }
    leave_out(&mut log, &copies.into_iter().map(|(row, _)| row).collect::<Vec<_>>());
    let times = log.column(quantity).map(|column| column.values.clone()).unwrap_or_default();
    split_at_gaps(&mut log, &times);
    Ok(log)
}

/// The rows that are not needed: copies of the ones before them, and those whose cells the row behind them has got.
fn copies(log: &mut Log, quantity: Quantity) -> Result<Vec<(usize, bool)>, LogError> {
    let Some(column) = log.column(quantity).cloned() else { return Ok(Vec::new()) };
    let (file, lines) = (log.file.clone(), log.lines.clone());
    let error = |row: usize, problem: Problem| LogError {
        file: file.clone(),
        line: Some(lines[row]),
        column: Some((column.place, column.header.clone())),
        problem: problem.into(),
    };
    let mut copies = Vec::new();
    for (row, time) in column.values.iter().enumerate() {
        if time.is_nan() {
            return Err(error(row, Problem::NoTime));
        }
        let Some(before) = row.checked_sub(1) else { continue };
        let (last, line) = (column.values[before], lines[before]);
        if *time < last {
            return Err(error(row, Problem::ClockBack { before: line, back_s: last - time }));
        }
        if *time > last
            || log.labels.as_ref().is_some_and(|labels| labels.of_rows[row] != labels.of_rows[before])
        {
            continue;
        }
        let pairs = || log.columns.iter().map(|column| (column.values[row], column.values[before]));
        if pairs().all(|(a, b)| same(a, b)) {
            copies.push((row, true));
        } else if pairs().all(|(a, b)| same(a, b) || a.is_nan() || b.is_nan()) {
            copies.push((before, false));
            complete(log, row, before);
        } else {
            return Err(error(row, Problem::RepeatedTime { before: line }));
        }
    }
    copies.sort_unstable();
    copies.dedup_by_key(|(row, _)| *row);
    Ok(copies)
}

/// Fills the empty cells of a row from another one.
fn complete(log: &mut Log, row: usize, other: usize) {
    for column in &mut log.columns {
        if column.values[row].is_nan() {
            column.values[row] = column.values[other];
        }
    }
}

fn same(a: f64, b: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

fn leave_out(log: &mut Log, rows: &[usize]) {
    fn without<T: Copy>(values: &mut Vec<T>, rows: &[usize]) {
        let (mut row, mut next) = (0, 0);
        values.retain(|_| {
            let leaves = rows.get(next) == Some(&row);
            next += usize::from(leaves);
            row += 1;
            !leaves
        });
    }
    without(&mut log.lines, rows);
    if let Some(labels) = &mut log.labels {
        without(&mut labels.of_rows, rows);
    }
    for column in &mut log.columns {
        without(&mut column.values, rows);
    }
}

fn split_at_gaps(log: &mut Log, times: &[f64]) {
    let mut periods: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    periods.sort_by(f64::total_cmp);
    let median_s = periods.get(periods.len() / 2).copied().unwrap_or_default();
    let mut start = 0;
    let mut gaps = 0;
    for row in 1..times.len() {
        let gap_s = times[row] - times[row - 1];
        if gap_s > GAP * median_s && median_s > 0.0 {
            log.segments.push(start..row);
            start = row;
            gaps += 1;
            if gaps <= LISTED_GAPS {
                log.warnings.push(Warning::Gap { line: log.lines[row], gap_s, median_s });
            }
        }
    }
    log.segments.push(start..times.len());
    if gaps > LISTED_GAPS {
        log.warnings.push(Warning::MoreGaps { more: gaps - LISTED_GAPS });
    }
}
