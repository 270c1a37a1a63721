//! Messages of a recording, chunk by chunk, without the clock.
//!
//! The stream types of the SDK number rows by the clock, write in the background and only print what fails there. Here the
//! messages are built and handed on directly: errors come back to the caller, and the numbers of chunks and rows follow from
//! the scene, so that the same run gives the same messages in the same order. (The index that closes a file lists recording
//! and layout in either order.)

use crate::ViewerError;
use crate::error::Cause;
use rerun::external::re_log_encoding::{Encoder, EncodingOptions};
use rerun::external::re_log_types::external::re_tuid::Tuid;
use rerun::external::re_log_types::{
    BlueprintActivationCommand, SetStoreInfo, StoreInfo, StoreSource,
};
use rerun::log::{Chunk, ChunkId, LogMsg, RowId, TimeColumn};
use rerun::{
    AsComponents, EntityPath, SerializationResult, SerializedComponentColumn, StoreId, StoreKind,
    TimePoint, Timeline,
};
use std::fs::File;
use std::path::Path;

/// Name under which the viewer keeps layouts and recordings together.
pub(crate) const APPLICATION: &str = "robhaz";
/// Name of the timeline: simulated time.
pub(crate) const TIMELINE: &str = "sim_time";

/// Where messages go.
pub(crate) trait Target {
    /// Hands on one message.
    fn send(&mut self, message: LogMsg) -> Result<(), Cause>;

    /// No message follows.
    fn finish(&mut self) -> Result<(), Cause>;
}

/// An `.rrd` file. Every message is in the file when the call returns.
pub(crate) struct RrdFile(Encoder<File>);

impl RrdFile {
    /// A new file; an older one of that name is replaced at once.
    pub(crate) fn create(path: &Path) -> Result<File, ViewerError> {
        File::create(path).map_err(|source| ViewerError::Create {
            path: path.to_owned(),
            source,
        })
    }

    /// Writes the header into an empty file.
    pub(crate) fn begin(file: File) -> Result<Self, Cause> {
        let version = rerun::build_info().version;
        let encoder = Encoder::new_eager(version, EncodingOptions::PROTOBUF_COMPRESSED, file)?;
        Ok(Self(encoder))
    }
}

impl Target for RrdFile {
    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        self.0.append(&message)?;
        Ok(())
    }

    /// Writes the index that closes the file.
    fn finish(&mut self) -> Result<(), Cause> {
        Ok(self.0.finish()?)
    }
}

/// Builds the messages of one recording and its layout.
pub(crate) struct Writer {
    destination: String,
    target: Box<dyn Target>,
    recording: StoreId,
    layout: StoreId,
    fingerprint: u64,
    chunks: u64,
}

impl Writer {
    /// Starts a recording. `destination` is named in errors; `fingerprint` tells recordings of the same name apart.
    pub(crate) fn start(
        destination: &str,
        target: Box<dyn Target>,
        name: &str,
        fingerprint: u64,
    ) -> Result<Self, ViewerError> {
        let id = format!("{name}-{fingerprint:016x}");
        let mut writer = Self {
            destination: destination.to_owned(),
            target,
            recording: StoreId::new(StoreKind::Recording, APPLICATION, id.clone()),
            layout: StoreId::new(StoreKind::Blueprint, APPLICATION, id),
            fingerprint,
            chunks: 0,
        };
        for store in [writer.recording.clone(), writer.layout.clone()] {
            let row_id = *writer.next_id();
            let info = StoreInfo::new(store, StoreSource::Other(APPLICATION.to_owned()));
            writer.send(SetStoreInfo { row_id, info }.into())?;
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
        let columns = columns.map_err(ViewerError::write(&self.destination))?;
        let time = TimeColumn::new_duration_secs(TIMELINE, times.iter().copied());
        let chunk = Chunk::from_auto_row_ids(
            self.next_id(),
            entity.into(),
            std::iter::once((*time.timeline().name(), time)).collect(),
            columns.map(|c| (c.descriptor, c.list_array)).collect(),
        )
        .map_err(ViewerError::write(&self.destination))?;
        self.send_chunk(self.recording.clone(), &chunk)
    }

    /// Logs a chunk of another recording under an entity of this one.
    pub(crate) fn copy(
        &mut self,
        chunk: &Chunk,
        entity: impl Into<EntityPath>,
    ) -> Result<(), ViewerError> {
        let id = self.next_id();
        let chunk = chunk
            .clone_as(id, RowId::from_tuid((*id).next()))
            .clone_with_new_entity_path(entity.into());
        self.send_chunk(self.recording.clone(), &chunk)
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
        self.send(command.into())
    }

    /// No message follows.
    pub(crate) fn finish(&mut self) -> Result<(), ViewerError> {
        self.target
            .finish()
            .map_err(ViewerError::write(&self.destination))
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
            .map_err(ViewerError::write(&self.destination))?;
        self.send_chunk(store, &chunk)
    }

    fn send_chunk(&mut self, store: StoreId, chunk: &Chunk) -> Result<(), ViewerError> {
        let message = chunk
            .to_arrow_msg()
            .map_err(ViewerError::write(&self.destination))?;
        self.send(LogMsg::ArrowMsg(store, message))
    }

    fn send(&mut self, message: LogMsg) -> Result<(), ViewerError> {
        self.target
            .send(message)
            .map_err(ViewerError::write(&self.destination))
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
