//! An `.rrd` file written chunk by chunk, without threads and without the clock.
//!
//! The stream types of the SDK number rows by the clock, write in the background and only print what fails there. Here the
//! encoder is called directly: errors come back to the caller, every chunk is in the file when the call returns, and the
//! numbers of chunks and rows follow from the scene, so that the same run gives the same messages in the same order. (The index
//! that closes the file lists recording and layout in either order.)

use crate::ViewerError;
use re_sdk::external::re_log_encoding::{Encoder, EncodingOptions};
use re_sdk::external::re_log_types::external::re_tuid::Tuid;
use re_sdk::external::re_log_types::{
    BlueprintActivationCommand, SetStoreInfo, StoreInfo, StoreSource,
};
use re_sdk::log::{Chunk, ChunkId, LogMsg, RowId, TimeColumn};
use re_sdk::{
    AsComponents, EntityPath, SerializationResult, SerializedComponentColumn, StoreId, StoreKind,
    TimePoint, Timeline,
};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Name under which the viewer keeps layouts and recordings together.
pub(crate) const APPLICATION: &str = "robhaz";
/// Name of the timeline: simulated time.
pub(crate) const TIMELINE: &str = "sim_time";

/// An open recording and its layout.
pub(crate) struct RrdWriter {
    path: PathBuf,
    encoder: Encoder<File>,
    recording: StoreId,
    layout: StoreId,
    fingerprint: u64,
    chunks: u64,
}

impl RrdWriter {
    /// Starts a recording in an empty file. `fingerprint` tells recordings of the same name apart.
    pub(crate) fn start(
        path: &Path,
        file: File,
        name: &str,
        fingerprint: u64,
    ) -> Result<Self, ViewerError> {
        let id = format!("{name}-{fingerprint:016x}");
        let encoder = Encoder::new_eager(
            re_sdk::build_info().version,
            EncodingOptions::PROTOBUF_COMPRESSED,
            file,
        )
        .map_err(ViewerError::write(path))?;
        let mut writer = Self {
            path: path.to_owned(),
            encoder,
            recording: StoreId::new(StoreKind::Recording, APPLICATION, id.clone()),
            layout: StoreId::new(StoreKind::Blueprint, APPLICATION, id),
            fingerprint,
            chunks: 0,
        };
        for store in [writer.recording.clone(), writer.layout.clone()] {
            let row_id = *writer.next_id();
            let info = StoreInfo::new(store, StoreSource::Other(APPLICATION.to_owned()));
            writer.append(&SetStoreInfo { row_id, info }.into())?;
        }
        Ok(writer)
    }

    /// Logs what holds at all times.
    pub(crate) fn constant(
        &mut self,
        entity: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), ViewerError> {
        let store = self.recording.clone();
        self.row(store, entity.into(), TimePoint::default(), what)
    }

    /// Logs a column of rows, one at each of `times` (s).
    pub(crate) fn columns(
        &mut self,
        entity: impl Into<EntityPath>,
        times: &[f64],
        columns: SerializationResult<impl Iterator<Item = SerializedComponentColumn>>,
    ) -> Result<(), ViewerError> {
        if times.is_empty() {
            return Ok(());
        }
        let columns = columns.map_err(ViewerError::write(&self.path))?;
        let time = TimeColumn::new_duration_secs(TIMELINE, times.iter().copied());
        let chunk = Chunk::from_auto_row_ids(
            self.next_id(),
            entity.into(),
            std::iter::once((*time.timeline().name(), time)).collect(),
            columns.map(|c| (c.descriptor, c.list_array)).collect(),
        )
        .map_err(ViewerError::write(&self.path))?;
        self.send(self.recording.clone(), &chunk)
    }

    /// Logs a part of the layout.
    pub(crate) fn layout(
        &mut self,
        entity: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), ViewerError> {
        // Not static: what a user changes in the viewer comes later on this timeline and wins.
        let time = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.row(self.layout.clone(), entity.into(), time, what)
    }

    /// Tells the viewer that the layout is complete and to be used.
    pub(crate) fn activate_layout(&mut self) -> Result<(), ViewerError> {
        let command = BlueprintActivationCommand {
            blueprint_id: self.layout.clone(),
            make_active: true,
            make_default: true,
        };
        self.append(&command.into())
    }

    /// Writes the index that closes the file.
    pub(crate) fn finish(&mut self) -> Result<(), ViewerError> {
        self.encoder
            .finish()
            .map_err(ViewerError::write(&self.path))
    }

    fn row(
        &mut self,
        store: StoreId,
        entity: EntityPath,
        time: TimePoint,
        what: &dyn AsComponents,
    ) -> Result<(), ViewerError> {
        let id = self.next_id();
        let row = RowId::from_tuid((*id).next());
        let chunk = Chunk::builder_with_id(id, entity)
            .with_archetype(row, time, what)
            .build()
            .map_err(ViewerError::write(&self.path))?;
        self.send(store, &chunk)
    }

    fn send(&mut self, store: StoreId, chunk: &Chunk) -> Result<(), ViewerError> {
        let message = chunk
            .to_arrow_msg()
            .map_err(ViewerError::write(&self.path))?;
        self.append(&LogMsg::ArrowMsg(store, message))
    }

    fn append(&mut self, message: &LogMsg) -> Result<(), ViewerError> {
        self.encoder
            .append(message)
            .map(|_| ())
            .map_err(ViewerError::write(&self.path))
    }

    /// Rows of a chunk are numbered on from the chunk's number. The upper half stands where the SDK puts the time; it stays
    /// small, so that what a viewer adds later counts as later.
    fn next_id(&mut self) -> ChunkId {
        self.chunks += 1;
        ChunkId::from_tuid(Tuid::from_nanos_and_inc(
            self.fingerprint >> 8,
            self.chunks << 32,
        ))
    }
}
