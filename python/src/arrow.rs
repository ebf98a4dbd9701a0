//! Tables as Arrow's C stream, which other packages take over as they are.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, StringArray,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use baudbot_experiment::columnar::{Column, Kind, Reader};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::errors::{apart, failed};

/// The values of a column, by what they all can be.
#[derive(FromPyObject)]
pub(crate) enum Values {
    Truth(Vec<Option<bool>>),
    Whole(Vec<i64>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
}

/// A stream of the table in a file of a sweep's.
#[pyfunction]
pub(crate) fn stream_of_file(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyCapsule>> {
    let reader = apart(py, || Reader::open(&path))?;
    let reader = reader.map_err(|error| failed(py, &format!("{}: {error}", path.display())))?;
    let schema = schema(reader.columns());
    let own = Arc::clone(&schema);
    let groups = reader.map(move |columns| batch(&own, columns.map_err(ArrowError::from)?));
    stream(py, schema, groups)
}

/// A stream of a table that is given column by column.
#[pyfunction]
pub(crate) fn stream_of_columns(
    py: Python<'_>,
    names: Vec<String>,
    columns: Vec<Values>,
) -> PyResult<Bound<'_, PyCapsule>> {
    let columns: Vec<_> = columns.into_iter().map(Column::from).collect();
    let kinds = columns.iter().map(|column| match column {
        Column::Whole(_) => Kind::Whole,
        Column::Number(_) => Kind::Number,
        Column::Text(_) => Kind::Text,
        Column::Truth(_) => Kind::Truth,
    });
    let schema = schema(&names.into_iter().zip(kinds).collect::<Vec<_>>());
    let batch = batch(&schema, columns).map_err(|error| failed(py, &error.to_string()))?;
    stream(py, schema, [Ok(batch)])
}

impl From<Values> for Column {
    fn from(values: Values) -> Self {
        match values {
            Values::Truth(values) => Self::Truth(values),
            Values::Whole(values) => Self::Whole(values),
            Values::Number(values) => Self::Number(values),
            Values::Text(values) => Self::Text(values),
        }
    }
}

fn stream<I>(py: Python<'_>, schema: SchemaRef, batches: I) -> PyResult<Bound<'_, PyCapsule>>
where
    I: IntoIterator<Item = Result<RecordBatch, ArrowError>>,
    I::IntoIter: Send + 'static,
{
    let batches = RecordBatchIterator::new(batches.into_iter(), schema);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), c"arrow_array_stream")
}

fn schema(columns: &[(String, Kind)]) -> SchemaRef {
    let field = |(name, kind): &(String, Kind)| match kind {
        Kind::Whole => Field::new(name, DataType::Int64, false),
        Kind::Number => Field::new(name, DataType::Float64, true),
        Kind::Text => Field::new(name, DataType::Utf8, true),
        Kind::Truth => Field::new(name, DataType::Boolean, true),
    };
    Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()))
}

fn batch(schema: &SchemaRef, columns: Vec<Column>) -> Result<RecordBatch, ArrowError> {
    let array = |column| -> ArrayRef {
        match column {
            Column::Whole(values) => Arc::new(Int64Array::from(values)),
            Column::Number(values) => Arc::new(Float64Array::from(values)),
            Column::Text(values) => Arc::new(StringArray::from(values)),
            Column::Truth(values) => Arc::new(BooleanArray::from(values)),
        }
    };
    RecordBatch::try_new(Arc::clone(schema), columns.into_iter().map(array).collect())
}
