//! Messages of a recording.
//!
//! The stream types of the SDK number rows by the clock, and only print errors. Here each message is
//! built and sent directly. Errors return to the caller. The numbers of chunks and rows follow from
//! the scene, so that the same run gives the same messages in the same order. (The index at the end
//! of a file may list recording and layout in either order.)

use crate::error::{Result, ViewerError};
use crate::target::Target;
use re_chunk::{Chunk, ChunkId, ChunkResult, RowId, TimeColumn};
use re_log_types::external::re_tuid::Tuid;
use re_log_types::{
    ApplicationId, BlueprintActivationCommand, EntityPath, LogMsg, SetStoreInfo, StoreId,
    StoreInfo, StoreKind, StoreSource, TimeInt, TimePoint, Timeline,
};
use re_sdk_types::archetypes::{RecordingInfo, TextDocument};
use re_sdk_types::components::MediaType;
use re_sdk_types::{AsComponents, SerializationResult, SerializedComponentColumn};
use robhaz_run::RunDescription;
use std::time::SystemTime;

/// Name of the timeline. It is simulated time.
pub(crate) const TIMELINE: &str = "sim_time";

/// Builds and sends the messages of one recording and its layout.
pub(crate) struct Writer {
    /// File or address, for errors.
    destination: String,
    target: Target,
    recording: StoreId,
    layout: StoreId,
    fingerprint: u64,
    /// Number of chunks so far.
    chunks: u64,
}

impl Writer {
    /// Starts the recording of a run. Errors name `destination`.
    pub(crate) fn start(destination: &str, target: Target, run: &RunDescription) -> Result<Self> {
        let name = &run.name;
        // A viewer would mix two runs with the same identifier.
        let fingerprint = run.fingerprint ^ if target.is_live() { now() } else { 0 };
        let id = format!("{name}-{fingerprint:016x}");
        // The viewer has one layout for each application: a run is one, so that each has its own.
        let application = ApplicationId::try_from(format!("robhaz-{fingerprint:016x}"));
        let application = application.map_err(ViewerError::io("write", destination))?;
        let mut writer = Self {
            destination: destination.to_owned(),
            target,
            recording: StoreId::new(StoreKind::Recording, application.clone(), id.clone()),
            layout: StoreId::new(StoreKind::Blueprint, application, id),
            fingerprint,
            chunks: 0,
        };
        for store in [writer.recording.clone(), writer.layout.clone()] {
            let row_id = *writer.next_id();
            let info = StoreInfo::new(store, StoreSource::Other("robhaz".to_owned()));
            writer.send(SetStoreInfo { row_id, info }.into())?;
        }
        let info = RecordingInfo::update_fields().with_name(name.as_str());
        writer.constant(EntityPath::properties(), &info)?;
        Ok(writer)
    }

    /// Whether it goes to a viewer.
    pub(crate) fn is_live(&self) -> bool {
        self.target.is_live()
    }

    /// Logs the page that explains the recording, Markdown.
    pub(crate) fn about(&mut self, page: String) -> Result {
        let page = TextDocument::new(page).with_media_type(MediaType::markdown());
        self.constant("about", &page)
    }

    /// Logs data that are valid at all times.
    pub(crate) fn constant(
        &mut self,
        entity: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result {
        let store = self.recording.clone();
        self.row(store, entity.into(), TimePoint::default(), what)
    }

    /// Logs data that are valid from a time (s) on.
    pub(crate) fn at(
        &mut self,
        entity: impl Into<EntityPath>,
        time: f64,
        what: &dyn AsComponents,
    ) -> Result {
        let time = TimeInt::from_secs(time);
        let time = TimePoint::default().with(Timeline::new_duration(TIMELINE), time);
        self.row(self.recording.clone(), entity.into(), time, what)
    }

    /// Logs one row at each of `times` (s). Without times it logs nothing.
    pub(crate) fn columns(
        &mut self,
        entity: impl Into<EntityPath>,
        times: &[f64],
        columns: SerializationResult<impl Iterator<Item = SerializedComponentColumn>>,
    ) -> Result {
        if times.is_empty() {
            return Ok(());
        }
        let columns = columns.map_err(ViewerError::io("write", &self.destination))?;
        let time = TimeColumn::new_duration_secs(TIMELINE, times.iter().copied());
        let chunk = Chunk::from_auto_row_ids(
            self.next_id(),
            entity.into(),
            std::iter::once((*time.timeline().name(), time)).collect(),
            columns.map(|c| (c.descriptor, c.list_array)).collect(),
        );
        self.send_chunk(self.recording.clone(), chunk)
    }

    /// Logs a part of the layout.
    pub(crate) fn layout(
        &mut self,
        entity: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result {
        // Not static: changes by a user come later on this timeline and take precedence.
        let time = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.row(self.layout.clone(), entity.into(), time, what)
    }

    /// Makes the layout the active one. All its parts must be logged before.
    pub(crate) fn activate_layout(&mut self) -> Result {
        let command = BlueprintActivationCommand {
            blueprint_id: self.layout.clone(),
            make_active: true,
            make_default: true,
        };
        self.send(command.into())
    }

    /// Closes the recording: waits until all of it is written, or read by the viewer.
    pub(crate) fn finish(&mut self) -> Result {
        let finished = self.target.finish();
        finished.map_err(ViewerError::io("write", &self.destination))
    }

    /// Does not wait for the target. Fails with the error of this message or of an earlier one.
    fn send(&mut self, message: LogMsg) -> Result {
        let sent = self.target.send(message);
        sent.map_err(ViewerError::io("write", &self.destination))
    }

    fn row(
        &mut self,
        store: StoreId,
        entity: EntityPath,
        time: TimePoint,
        what: &dyn AsComponents,
    ) -> Result {
        let id = self.next_id();
        let row = RowId::from_tuid((*id).next());
        let chunk = Chunk::builder_with_id(id, entity)
            .with_archetype(row, time, what)
            .build();
        self.send_chunk(store, chunk)
    }

    fn send_chunk(&mut self, store: StoreId, chunk: ChunkResult<Chunk>) -> Result {
        let message = chunk.and_then(|chunk| chunk.to_arrow_msg());
        let message = message.map_err(ViewerError::io("write", &self.destination))?;
        self.send(LogMsg::ArrowMsg(store, message))
    }

    /// The number of the next chunk. Its rows are numbered from it. The SDK puts the time into the
    /// upper half; here that half is a small number, so that rows that a viewer adds count as
    /// later.
    fn next_id(&mut self) -> ChunkId {
        self.chunks += 1;
        let id = Tuid::from_nanos_and_inc(self.fingerprint >> 8, self.chunks << 32);
        ChunkId::from_tuid(id)
    }
}

/// Wall-clock time, ns. It distinguishes two runs of the same scene in one viewer.
fn now() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    // The lower digits distinguish two runs.
    since.map_or(0, |time| time.as_nanos() as u64)
}
