//! The rows as a table in Parquet.

use std::io::Write;

use crate::columnar::{Column, Kind, Writer};
use crate::error::Error;
use crate::experiment::Experiment;
use crate::figures::{Figures, INFOS};
use crate::outputs::Content;
use crate::requirement::Fall;
use crate::run_record::Row;

/// Writes the rows, which come in the order of their runs.
pub(crate) fn write(
    out: impl Write + Send,
    experiment: &Experiment,
    rows: impl Iterator<Item = Result<Row, Error>>,
) -> Result<(), Content> {
    let kinds = columns(experiment, &[]).into_iter().map(|column| match column {
        Column::Whole(_) => Kind::Whole,
        Column::Number(_) => Kind::Number,
        Column::Text(_) => Kind::Text,
        Column::Truth(_) => Kind::Truth,
    });
    let names: Vec<_> = experiment.columns().into_iter().zip(kinds).collect();
    let mut file = Writer::new(out, "sweep", &names).map_err(Content::Io)?;
    let mut group = Vec::new();
    for row in rows {
        group.push(row?);
        if group.len() == GROUP {
            file.rows(columns(experiment, &group)).map_err(Content::Io)?;
            group.clear();
        }
    }
    if !group.is_empty() {
        file.rows(columns(experiment, &group)).map_err(Content::Io)?;
    }
    file.finish().map_err(Content::Io)
}

/// All columns of some rows, in the order of [`Experiment::columns`].
fn columns(experiment: &Experiment, rows: &[Row]) -> Vec<Column> {
    let tasks: Vec<_> = rows.iter().map(|row| experiment.task(row.run)).collect();
    let whole = |value: u64| i64::try_from(value).unwrap_or(i64::MAX);
    let mut all = vec![
        Column::Whole(rows.iter().map(|row| whole(row.run)).collect()),
        Column::Whole(tasks.iter().map(|task| whole(task.cell.number)).collect()),
        Column::Whole(tasks.iter().map(|task| whole(task.seed)).collect()),
    ];
    for (i, field) in experiment.fields.iter().enumerate() {
        let levels = tasks.iter().map(|task| &task.cell.levels[i]);
        all.push(match field.is_numeric() {
            true => Column::Number(levels.map(|level| level.number).collect()),
            false => Column::Text(levels.map(|level| Some(level.name.clone())).collect()),
        });
    }
    let ran = || rows.iter().map(|row| row.outcome.as_ref().ok());
    all.push(Column::Text(
        rows.iter().map(|row| row.outcome.as_ref().err().map(ToString::to_string)).collect(),
    ));
    all.push(Column::Text(ran().map(|ran| ran.map(|ran| ran.ending.clone())).collect()));
    if experiment.has_success() {
        let success = |row: &Row| experiment.succeeded(row).filter(|_| row.outcome.is_ok());
        all.push(Column::Truth(rows.iter().map(success).collect()));
    }
    if !experiment.requirements.is_empty() {
        let falls = || ran().map(|ran| ran.and_then(|ran| ran.fall));
        let named = |fall: Fall| experiment.requirements[fall.requirement as usize].to_string();
        all.push(Column::Number(falls().map(|fall| fall.map(|fall| fall.robustness)).collect()));
        all.push(Column::Number(falls().map(|fall| fall.map(|fall| fall.at_s())).collect()));
        all.push(Column::Text(falls().map(|fall| fall.map(named)).collect()));
    }
    for info in &INFOS {
        let value = |figures: &Figures| figures.get(info.figure);
        all.push(Column::Number(ran().map(|ran| ran.and_then(|ran| value(&ran.figures))).collect()));
    }
    all.push(Column::Text(ran().map(|ran| ran.map(|ran| format!("{:016x}", ran.hash))).collect()));
    all
}

/// Rows that are written at a time.
const GROUP: usize = 100_000;
