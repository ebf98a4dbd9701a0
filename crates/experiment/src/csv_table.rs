//! The rows as a table in CSV.

use std::io::Write;

use crate::error::Error;
use crate::experiment::Experiment;
use crate::outputs::Content;
use crate::run_record::Row;

/// Writes the rows, which come in the order of their runs: the same rows give the same bytes.
pub(crate) fn write(
    out: impl Write,
    experiment: &Experiment,
    rows: impl Iterator<Item = Result<Row, Error>>,
) -> Result<(), Content> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(experiment.columns()).map_err(failed)?;
    for row in rows {
        table.write_record(record(experiment, &row?)).map_err(failed)?;
    }
    Ok(table.flush()?)
}

fn record(experiment: &Experiment, row: &Row) -> Vec<String> {
    let task = experiment.task(row.run);
    let mut record = vec![row.run.to_string(), task.cell.number.to_string(), task.seed.to_string()];
    record.extend(task.cell.levels.into_iter().map(|level| level.name));
    let ran = row.outcome.as_ref().ok();
    record.push(row.outcome.as_ref().err().map(ToString::to_string).unwrap_or_default());
    record.push(ran.map(|ran| ran.ending.clone()).unwrap_or_default());
    record.extend(
        experiment
            .succeeded(row)
            .map(|success| if ran.is_some() { u8::from(success).to_string() } else { String::new() }),
    );
    if !experiment.requirements.is_empty() {
        let fall = ran.and_then(|ran| ran.fall);
        record.push(fall.map(|fall| fall.robustness.to_string()).unwrap_or_default());
        record.push(fall.map(|fall| fall.at_s().to_string()).unwrap_or_default());
        record.push(
            fall.map(|fall| experiment.requirements[fall.requirement as usize].to_string())
                .unwrap_or_default(),
        );
    }
    let figures = ran.map(|ran| ran.figures.0).unwrap_or_default();
    record.extend(figures.iter().map(|value| value.map(|value| value.to_string()).unwrap_or_default()));
    record.push(ran.map(|ran| format!("{:016x}", ran.hash)).unwrap_or_default());
    record
}

fn failed(error: csv::Error) -> Content {
    Content::Io(error.into())
}
