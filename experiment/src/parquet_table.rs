//! The rows as a table in Parquet, without compression: whoever reads it needs no more than the format itself.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::figures::{Figures, INFOS};
use crate::outputs::Content;
use crate::row::Row;

/// Writes the rows, which come in the order of their runs.
pub(crate) fn write(
    out: impl Write + Send,
    experiment: &Experiment,
    rows: impl Iterator<Item = Result<Row, Error>>,
) -> Result<(), Content> {
    let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED).build();
    let mut file = SerializedFileWriter::new(out, schema(experiment).map_err(failed)?, Arc::new(properties));
    let file = file.as_mut().map_err(|error| failed(ParquetError::General(error.to_string())))?;
    let mut group = Vec::new();
    for row in rows {
        group.push(row?);
        if group.len() == GROUP {
            write_group(file, experiment, &group).map_err(failed)?;
            group.clear();
        }
    }
    if !group.is_empty() {
        write_group(file, experiment, &group).map_err(failed)?;
    }
    file.finish().map_err(failed)?;
    Ok(())
}

/// A column's values; `None` where there is none.
enum Column {
    Whole(Vec<i64>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
    Truth(Vec<Option<bool>>),
}

fn schema(experiment: &Experiment) -> Result<TypePtr, ParquetError> {
    let columns = experiment.columns().into_iter().zip(columns(experiment, &[]));
    let column = |(name, column): (String, Column)| {
        let (physical, logical, repetition) = match column {
            Column::Whole(_) => (Physical::INT64, None, Repetition::REQUIRED),
            Column::Number(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Column::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL),
            Column::Truth(_) => (Physical::BOOLEAN, None, Repetition::OPTIONAL),
        };
        let column = Type::primitive_type_builder(&name, physical).with_logical_type(logical);
        column.with_repetition(repetition).build().map(Arc::new)
    };
    let columns = columns.map(column).collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("sweep").with_fields(columns).build()?))
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
    all.push(Column::Text(rows.iter().map(|row| row.outcome.as_ref().err().cloned()).collect()));
    all.push(Column::Text(ran().map(|ran| ran.map(|ran| ran.ending.clone())).collect()));
    if experiment.success.is_some() {
        let success = |row: &Row| experiment.succeeded(row).filter(|_| row.outcome.is_ok());
        all.push(Column::Truth(rows.iter().map(success).collect()));
    }
    for info in &INFOS {
        let value = |figures: &Figures| figures.get(info.figure);
        all.push(Column::Number(ran().map(|ran| ran.and_then(|ran| value(&ran.figures))).collect()));
    }
    all.push(Column::Text(ran().map(|ran| ran.map(|ran| format!("{:016x}", ran.hash))).collect()));
    all
}

fn write_group<W: Write + Send>(
    file: &mut SerializedFileWriter<W>,
    experiment: &Experiment,
    rows: &[Row],
) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for column in columns(experiment, rows) {
        if let Some(mut writer) = group.next_column()? {
            write_column(&mut writer, column)?;
            writer.close()?;
        }
    }
    group.close()?;
    Ok(())
}

fn write_column(writer: &mut SerializedColumnWriter<'_>, column: Column) -> Result<(), ParquetError> {
    match column {
        Column::Whole(values) => {
            writer.typed::<Int64Type>().write_batch(&values, None, None)?;
        }
        Column::Number(values) => {
            let (values, levels) = dense(values, |value| value);
            writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        }
        Column::Text(values) => {
            let (values, levels) = dense(values, |text| ByteArray::from(text.into_bytes()));
            writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
        }
        Column::Truth(values) => {
            let (values, levels) = dense(values, |value| value);
            writer.typed::<BoolType>().write_batch(&values, Some(&levels), None)?;
        }
    }
    Ok(())
}

/// The values that there are, and for each row whether there is one.
fn dense<T, V>(values: Vec<Option<T>>, value: impl Fn(T) -> V) -> (Vec<V>, Vec<i16>) {
    let levels = values.iter().map(|value| i16::from(value.is_some())).collect();
    (values.into_iter().flatten().map(value).collect(), levels)
}

fn failed(error: ParquetError) -> Content {
    Content::Io(std::io::Error::other(error))
}

/// Rows that are written at a time.
const GROUP: usize = 100_000;
