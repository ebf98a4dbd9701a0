//! Tables in Parquet, without compression: a reader needs no more than the format itself.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

/// The values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers, one in each row.
    Whole,
    /// Numbers, where there are any.
    Number,
    /// Texts, where there are any.
    Text,
    /// True or false, where it is known.
    Truth,
}

/// A column's values; `None` where there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Of [`Kind::Whole`].
    Whole(Vec<i64>),
    /// Of [`Kind::Number`].
    Number(Vec<Option<f64>>),
    /// Of [`Kind::Text`].
    Text(Vec<Option<String>>),
    /// Of [`Kind::Truth`].
    Truth(Vec<Option<bool>>),
}

/// Writes a table, some rows at a time.
pub struct Writer<W: Write + Send> {
    file: SerializedFileWriter<W>,
}

impl<W: Write + Send> Writer<W> {
    /// Begins a table with columns of these names.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(out: W, table: &str, columns: &[(String, Kind)]) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED).build();
        let schema = schema(table, columns).map_err(failed)?;
        let file = SerializedFileWriter::new(out, schema, Arc::new(properties)).map_err(failed)?;
        Ok(Self { file })
    }

    /// Rows, as all columns in their order, each as long as the others.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn rows(&mut self, columns: Vec<Column>) -> io::Result<()> {
        self.group(columns).map_err(failed)
    }

    /// Ends the table; without its end it cannot be read.
    ///
    /// # Errors
    /// If that cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.finish().map_err(failed)?;
        self.file.inner_mut().flush()
    }

    fn group(&mut self, columns: Vec<Column>) -> Result<()> {
        let mut group = self.file.next_row_group()?;
        for column in columns {
            if let Some(mut writer) = group.next_column()? {
                write_column(&mut writer, column)?;
                writer.close()?;
            }
        }
        group.close()?;
        Ok(())
    }
}

fn schema(table: &str, columns: &[(String, Kind)]) -> Result<TypePtr> {
    let column = |(name, kind): &(String, Kind)| {
        let (physical, logical, repetition) = match kind {
            Kind::Whole => (Physical::INT64, None, Repetition::REQUIRED),
            Kind::Number => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL),
            Kind::Truth => (Physical::BOOLEAN, None, Repetition::OPTIONAL),
        };
        let column = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        column.with_repetition(repetition).build().map(Arc::new)
    };
    let columns = columns.iter().map(column).collect::<Result<_>>()?;
    Ok(Arc::new(Type::group_type_builder(table).with_fields(columns).build()?))
}

fn write_column(writer: &mut SerializedColumnWriter<'_>, column: Column) -> Result<()> {
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

fn failed(error: ParquetError) -> io::Error {
    io::Error::other(error)
}
