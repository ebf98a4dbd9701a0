//! Tables in Parquet, without compression: a reader needs no more than the format itself.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnDescriptor, Type, TypePtr};

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
    /// The values of a column of [`Kind::Whole`].
    Whole(Vec<i64>),
    /// The values of a column of [`Kind::Number`].
    Number(Vec<Option<f64>>),
    /// The values of a column of [`Kind::Text`].
    Text(Vec<Option<String>>),
    /// The values of a column of [`Kind::Truth`].
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

/// A table that such a writer has made, group of rows by group of rows.
pub struct Reader {
    file: SerializedFileReader<File>,
    columns: Vec<(String, Kind)>,
    /// The next group.
    group: usize,
}

impl Reader {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read, or is no such table.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = SerializedFileReader::new(File::open(path)?).map_err(failed)?;
        let kind = |column: &Arc<ColumnDescriptor>| match column.physical_type() {
            Physical::INT64 => Ok((column.name().to_owned(), Kind::Whole)),
            Physical::DOUBLE => Ok((column.name().to_owned(), Kind::Number)),
            Physical::BYTE_ARRAY => Ok((column.name().to_owned(), Kind::Text)),
            Physical::BOOLEAN => Ok((column.name().to_owned(), Kind::Truth)),
            other
            @ (Physical::INT32 | Physical::INT96 | Physical::FLOAT | Physical::FIXED_LEN_BYTE_ARRAY) => {
                Err(io::Error::other(format!("has a column of another kind: {other}")))
            }
        };
        let columns = file.metadata().file_metadata().schema_descr().columns();
        let columns = columns.iter().map(kind).collect::<io::Result<_>>()?;
        Ok(Self { file, columns, group: 0 })
    }

    /// The columns.
    pub fn columns(&self) -> &[(String, Kind)] {
        &self.columns
    }

    fn read(&self) -> Result<Vec<Column>> {
        let group = self.file.get_row_group(self.group)?;
        let rows = group.metadata().num_rows() as usize;
        (0..self.columns.len()).map(|i| read_column(group.get_column_reader(i)?, rows)).collect()
    }
}

impl Iterator for Reader {
    type Item = io::Result<Vec<Column>>;

    fn next(&mut self) -> Option<Self::Item> {
        (self.group < self.file.num_row_groups()).then(|| {
            let columns = self.read().map_err(failed);
            self.group += 1;
            columns
        })
    }
}

fn read_column(reader: ColumnReader, rows: usize) -> Result<Column> {
    Ok(match reader {
        ColumnReader::Int64ColumnReader(reader) => {
            Column::Whole(sparse(reader, rows)?.into_iter().flatten().collect())
        }
        ColumnReader::DoubleColumnReader(reader) => Column::Number(sparse(reader, rows)?),
        ColumnReader::BoolColumnReader(reader) => Column::Truth(sparse(reader, rows)?),
        ColumnReader::ByteArrayColumnReader(reader) => {
            let texts = sparse(reader, rows)?.into_iter();
            let texts = texts.map(|text| text.map(|text| text.as_utf8().map(str::to_owned)).transpose());
            Column::Text(texts.collect::<Result<_>>()?)
        }
        ColumnReader::Int32ColumnReader(_)
        | ColumnReader::Int96ColumnReader(_)
        | ColumnReader::FloatColumnReader(_)
        | ColumnReader::FixedLenByteArrayColumnReader(_) => {
            return Err(ParquetError::General("has a column of another kind".to_owned()));
        }
    })
}

/// The values of a column, with `None` where there is none: the other way of [`dense`].
fn sparse<T: DataType>(mut reader: ColumnReaderImpl<T>, rows: usize) -> Result<Vec<Option<T::T>>> {
    let (mut values, mut levels, mut read) = (Vec::new(), Vec::new(), 0);
    while read < rows {
        let (more, ..) = reader.read_records(rows - read, Some(&mut levels), None, &mut values)?;
        if more == 0 {
            return Err(ParquetError::EOF("a column is too short".to_owned()));
        }
        read += more;
    }
    if levels.is_empty() {
        return Ok(values.into_iter().map(Some).collect());
    }
    let mut values = values.into_iter();
    Ok(levels.into_iter().map(|level| if level > 0 { values.next() } else { None }).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        let kinds = [Kind::Whole, Kind::Number, Kind::Text, Kind::Truth];
        let names: Vec<_> = ["a", "b", "c", "d"].map(str::to_owned).into_iter().zip(kinds).collect();
        let group = |first: i64| {
            vec![
                Column::Whole((first..first + 3).collect()),
                Column::Number(vec![Some(0.1), None, Some(f64::INFINITY)]),
                Column::Text(vec![None, Some("é".to_owned()), Some(String::new())]),
                Column::Truth(vec![Some(true), Some(false), None]),
            ]
        };
        let mut writer = Writer::new(File::create(&path).unwrap(), "test", &names).unwrap();
        writer.rows(group(0)).unwrap();
        writer.rows(group(3)).unwrap();
        writer.finish().unwrap();
        let reader = Reader::open(&path).unwrap();
        assert_eq!(reader.columns(), names);
        assert_eq!(reader.collect::<io::Result<Vec<_>>>().unwrap(), [group(0), group(3)]);
        std::fs::write(&path, "no table").unwrap();
        assert!(Reader::open(&path).is_err());
    }
}
