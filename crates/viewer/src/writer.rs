//! Messages of a recording.
//!
//! The stream types of the SDK number rows by the clock, write in a background thread, and only print errors. Here each
//! message is built and sent directly. Errors return to the caller. The numbers of chunks and rows follow from the
//! scene, so that the same run gives the same messages in the same order. (The index at the end of a file may list
//! recording and layout in either order.)

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
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Name by which the viewer groups recordings and their layouts.
pub(crate) const APPLICATION: &str = "robhaz";
/// Name of the timeline. It is simulated time.
pub(crate) const TIMELINE: &str = "sim_time";

/// Destination of the messages.
pub(crate) trait Target {
    /// Sends one message.
    fn send(&mut self, message: LogMsg) -> Result<(), Cause>;

    /// Closes the destination after the last message.
    fn finish(&mut self) -> Result<(), Cause>;
}

/// An `.rrd` file. A message is in the file when [`Target::send`] returns.
pub(crate) struct RrdFile(Encoder<File>);

impl RrdFile {
    /// Creates an empty file. An older file of that name is replaced immediately.
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

    /// Writes the index at the end of the file.
    fn finish(&mut self) -> Result<(), Cause> {
        Ok(self.0.finish()?)
    }
}

/// A target with a thread of its own: messages are encoded and written while the next are collected.
pub(crate) struct Background {
    /// `None` when the thread has ended.
    messages: Option<SyncSender<LogMsg>>,
    thread: Option<JoinHandle<Result<(), Cause>>>,
}

/// Messages that wait for the thread: those of a few seconds of a run.
const WAITING: usize = 512;

impl Background {
    /// Starts the thread.
    pub(crate) fn start(mut target: impl Target + Send + 'static) -> Result<Self, ViewerError> {
        let (messages, received) = sync_channel::<LogMsg>(WAITING);
        let work = move || {
            for message in received {
                target.send(message)?;
            }
            target.finish()
        };
        let builder = std::thread::Builder::new().name("recording".to_owned());
        let thread = builder.spawn(work).map_err(ViewerError::Thread)?;
        Ok(Self {
            messages: Some(messages),
            thread: Some(thread),
        })
    }
}

impl Target for Background {
    /// Fails with the error of this message or of an earlier one, or leaves its error to the next or the end.
    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        let messages = self.messages.as_ref();
        if messages.is_some_and(|messages| messages.send(message).is_ok()) {
            return Ok(());
        }
        // The thread receives until it fails.
        self.finish()
    }

    fn finish(&mut self) -> Result<(), Cause> {
        self.messages = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(done)) => done,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Err("the recording has ended".into()),
        }
    }
}

impl Drop for Background {
    /// A recording that is given up keeps the messages that it has got.
    fn drop(&mut self) {
        if self.thread.is_some() {
            // A drop cannot report an error.
            let _ = self.finish();
        }
    }
}

/// Builds and sends the messages of one recording and its layout.
pub(crate) struct Writer {
    /// File or address, for errors.
    destination: String,
    target: Box<dyn Target>,
    recording: StoreId,
    layout: StoreId,
    fingerprint: u64,
    /// Number of chunks so far.
    chunks: u64,
}

impl Writer {
    /// Starts a recording. Errors name `destination`; `fingerprint` distinguishes recordings of the same name.
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

    /// Logs data that are valid at all times.
    pub(crate) fn constant(
        &mut self,
        entity: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), ViewerError> {
        let store = self.recording.clone();
        self.row(store, entity.into(), TimePoint::default(), what)
    }

    /// Logs one row at each of `times` (s). Without times it logs nothing.
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

    /// Copies a chunk of another recording to an entity of this one.
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
        // Not static: changes by a user come later on this timeline and take precedence.
        let time = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.row(self.layout.clone(), entity.into(), time, what)
    }

    /// Makes the layout the active one. All its parts must be logged before.
    pub(crate) fn activate_layout(&mut self) -> Result<(), ViewerError> {
        let command = BlueprintActivationCommand {
            blueprint_id: self.layout.clone(),
            make_active: true,
            make_default: true,
        };
        self.send(command.into())
    }

    /// Closes the recording after the last message.
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

    /// The number of the next chunk. Its rows are numbered from it. The SDK puts the time into the upper half; here
    /// that half is a small number, so that rows that a viewer adds count as later.
    fn next_id(&mut self) -> ChunkId {
        self.chunks += 1;
        ChunkId::from_tuid(Tuid::from_nanos_and_inc(
            self.fingerprint >> 8,
            self.chunks << 32,
        ))
    }
}
