//! The sink that keeps the tables in memory.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::felt_ground::FeltGrounds;
use crate::ground_table::ground_batches;
use crate::table::metadata;
use crate::terrain_table::terrain_batch;
use arrow_array::RecordBatch;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::slice;

/// Keeps the tables of a run as Arrow batches: those that [`crate::TableSink`] writes, with the same names, columns and metadata.
#[derive(Default)]
pub struct MemorySink {
    builders: Vec<BatchBuilder>,
    grounds: Option<(RunDescription, FeltGrounds)>,
    tables: Vec<(String, RecordBatch)>,
}

impl MemorySink {
    /// A sink for one run.
    pub fn new() -> Self {
        Self::default()
    }

    /// Name and content of each table, in the order in which a folder has them: `truth`, `sensors`, `estimate-NAME`, then
    /// `terrain` and `ground-NAME`. Empty before the end of the run.
    pub fn into_tables(self) -> Vec<(String, RecordBatch)> {
        self.tables
    }
}

impl Sink for MemorySink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let metadata = metadata(run);
        let tables = Table::all(run).into_iter();
        self.builders = tables.map(|t| BatchBuilder::new(t, &metadata)).collect();
        self.grounds = Some((run.clone(), FeltGrounds::new(run)));
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.frames(slice::from_ref(frame))
    }

    fn frames(&mut self, frames: &[Frame<'_>]) -> Result<(), SinkError> {
        if let Some((_, grounds)) = &mut self.grounds {
            frames.iter().for_each(|frame| grounds.add(frame));
        }
        for builder in &mut self.builders {
            builder.push_all(frames);
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        for mut builder in self.builders.drain(..) {
            let batch = builder.take()?;
            self.tables.push((builder.name().to_owned(), batch));
        }
        if let Some((run, mut grounds)) = self.grounds.take() {
            grounds.finish(end);
            let metadata = metadata(&run);
            self.tables.extend(terrain_batch(&run, &metadata)?);
            self.tables
                .extend(ground_batches(&run, &grounds, &metadata)?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scene;
    use crate::{TableFormat, TableSink};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_run::RunError;
    use std::fs::File;

    /// Equivalence: the tables in memory are those of the folder, to the bit, with the same columns, units and descriptions.
    #[test]
    fn memory_holds_what_a_folder_holds() -> Result<(), RunError> {
        let mut scene = scene();
        scene.record.duration = 3.0;
        let folder = tempfile::tempdir().expect("a folder");
        let mut files = TableSink::new(folder.path(), TableFormat::Parquet);
        let mut memory = MemorySink::new();
        robhaz_run::run(&scene, &mut [&mut files, &mut memory])?;
        let tables = memory.into_tables();
        let count = std::fs::read_dir(folder.path()).expect("files").count();
        assert_eq!(tables.len(), count);
        for (name, batch) in tables {
            let file = File::open(folder.path().join(format!("{name}.parquet"))).expect("a table");
            let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("a footer");
            assert_eq!(reader.schema().fields(), batch.schema().fields(), "{name}");
            let reader = reader.with_batch_size(batch.num_rows().max(1));
            let rows = reader.build().expect("a reader");
            let mut rows = rows.map(|batch| batch.expect("rows"));
            let read = rows.next().expect("a batch");
            assert_eq!(read.columns(), batch.columns(), "{name}");
            assert!(rows.next().is_none());
        }
        Ok(())
    }
}
