//! A table as Parquet: units and descriptions in the field metadata, readable at any time while it grows.
//!
//! A Parquet file ends in a footer that says where everything is; without it nothing can be read. So a footer is written
//! after every row group, and the next row group overwrites it: a run that is killed leaves a whole file that lacks its
//! last rows only.

use crate::columns::{Column, Kind, Table, Value};
use crate::error::{RecordError, io_error};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::{ARROW_SCHEMA_META_KEY, ArrowWriter, encode_arrow_schema};
use parquet::basic::Compression;
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{FileMetaData, KeyValue, ParquetMetaData, ParquetMetaDataWriter};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use robhaz_run::Frame;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows handed to the encoder at once.
const BATCH_ROWS: usize = 1024;
/// Rows in a row group: 16 s at 1 kHz, well below a second of computing.
const GROUP_ROWS: usize = 16 * BATCH_ROWS;

/// Values of one column that wait to be encoded.
enum Buffer {
    Float(Vec<f64>),
    Optional(Vec<Option<f64>>),
    Count(Vec<u32>),
}

impl Buffer {
    fn new(column: &Column) -> Self {
        match column.kind() {
            Kind::Float => Self::Float(Vec::with_capacity(BATCH_ROWS)),
            Kind::Optional => Self::Optional(Vec::with_capacity(BATCH_ROWS)),
            Kind::Count => Self::Count(Vec::with_capacity(BATCH_ROWS)),
        }
    }

    fn push(&mut self, value: Value) {
        match (self, value) {
            (Self::Float(buffer), Value::Float(value)) => buffer.push(value),
            (Self::Optional(buffer), Value::Optional(value)) => buffer.push(value),
            (Self::Count(buffer), Value::Count(value)) => buffer.push(value),
            // A column is of one kind for good; were it not, the lengths would differ and the batch be refused.
            _ => {}
        }
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Self::Float(buffer) => Arc::new(Float64Array::from(std::mem::take(buffer))),
            Self::Optional(buffer) => Arc::new(buffer.drain(..).collect::<Float64Array>()),
            Self::Count(buffer) => Arc::new(UInt32Array::from(std::mem::take(buffer))),
        }
    }
}

/// A table being written.
pub struct ParquetTable {
    columns: Vec<Column>,
    buffers: Vec<Buffer>,
    buffered: usize,
    schema: SchemaRef,
    metadata: Vec<KeyValue>,
    writer: ArrowWriter<File>,
    path: PathBuf,
}

impl ParquetTable {
    /// Creates the file. `metadata` are keys and values that go with the file as a whole.
    pub fn create(
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.parquet", table.name));
        let file = File::create(&path).map_err(io_error("create", &path))?;
        let schema = Arc::new(Schema::new(
            table.columns.iter().map(field).collect::<Vec<_>>(),
        ));
        let metadata: Vec<KeyValue> = metadata
            .iter()
            .map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()))
            .collect();
        let writer = ArrowWriter::try_new(
            file,
            Arc::clone(&schema),
            Some(properties(metadata.clone())),
        )
        .map_err(parquet_error(&path))?;
        Ok(Self {
            buffers: table.columns.iter().map(Buffer::new).collect(),
            columns: table.columns,
            buffered: 0,
            schema,
            metadata,
            writer,
            path,
        })
    }

    /// Adds one row.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        for (buffer, column) in self.buffers.iter_mut().zip(&self.columns) {
            buffer.push(column.value(frame));
        }
        self.buffered += 1;
        if self.buffered == BATCH_ROWS {
            self.encode().map_err(parquet_error(&self.path))?;
        }
        if self.writer.in_progress_rows() >= GROUP_ROWS {
            self.write_group().map_err(parquet_error(&self.path))?;
        }
        Ok(())
    }

    /// Writes what is left and the footer.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.finish().map_err(parquet_error(&self.path))
    }

    fn encode(&mut self) -> ParquetResult<()> {
        if self.buffered == 0 {
            return Ok(());
        }
        self.buffered = 0;
        let arrays = self.buffers.iter_mut().map(Buffer::take).collect();
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays)?;
        self.writer.write(&batch)
    }

    /// A row group, and a footer after it that the next row group overwrites.
    fn write_group(&mut self) -> ParquetResult<()> {
        self.writer.flush()?;
        self.writer.sync()?;
        let footer = self.footer()?;
        let mut file = self.writer.inner();
        let end = file.stream_position()?;
        file.write_all(&footer)?;
        file.seek(SeekFrom::Start(end))?;
        Ok(())
    }

    fn footer(&self) -> ParquetResult<Vec<u8>> {
        let groups = self.writer.flushed_row_groups().to_vec();
        let Some(first) = groups.first() else {
            return Ok(Vec::new());
        };
        let mut metadata = self.metadata.clone();
        metadata.push(KeyValue::new(
            ARROW_SCHEMA_META_KEY.to_owned(),
            encode_arrow_schema(&self.schema),
        ));
        let file = FileMetaData::new(
            1,
            groups.iter().map(|g| g.num_rows()).sum(),
            None,
            Some(metadata),
            first.schema_descr_ptr(),
            None,
        );
        let mut bytes = Vec::new();
        ParquetMetaDataWriter::new(&mut bytes, &ParquetMetaData::new(file, groups)).finish()?;
        Ok(bytes)
    }

    fn finish(&mut self) -> ParquetResult<()> {
        self.encode()?;
        self.writer.finish()?;
        self.writer.sync()?;
        // Nothing of an earlier footer may stay behind the last one.
        let mut file = self.writer.inner();
        let end = file.stream_position()?;
        file.set_len(end)?;
        Ok(())
    }
}

fn field(column: &Column) -> Field {
    let (kind, nullable) = match column.kind() {
        // Only what can be missing is nullable; to mark what is there costs time.
        Kind::Float => (DataType::Float64, false),
        Kind::Optional => (DataType::Float64, true),
        Kind::Count => (DataType::UInt32, false),
    };
    Field::new(&column.name, kind, nullable).with_metadata(HashMap::from([
        ("unit".to_owned(), column.unit.to_owned()),
        ("description".to_owned(), column.description.clone()),
    ]))
}

fn properties(metadata: Vec<KeyValue>) -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        // Measures hardly ever repeat: a dictionary of them only costs.
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        // Row groups end where `push` says, so that a footer follows each.
        .set_max_row_group_row_count(None)
        .set_key_value_metadata(Some(metadata))
        .build()
}

fn parquet_error(path: &Path) -> impl FnOnce(parquet::errors::ParquetError) -> RecordError + use<> {
    let path = path.to_path_buf();
    move |source| RecordError::Parquet { path, source }
}
