//! Messages of a recording.
//!
//! The stream types of the SDK number rows by the clock, write in a background thread, and only
//! print errors. Here each message is built and sent directly. Errors return to the caller. The
//! numbers of chunks and rows follow from the scene, so that the same run gives the same messages
//! in the same order. (The index at the end of a file may list recording and layout in either
//! order.)

use crate::ViewerError;
use crate::connection::Connection;
use crate::error::Cause;
use re_build_info::CrateVersion;
use re_chunk::{Chunk, ChunkId, ChunkResult, RowId, TimeColumn};
use re_log_encoding::{Encoder, EncodingOptions};
use re_log_types::external::re_tuid::Tuid;
use re_log_types::{
    ApplicationId, BlueprintActivationCommand, EntityPath, LogMsg, SetStoreInfo, StoreId,
    StoreInfo, StoreKind, StoreSource, TimePoint, Timeline,
};
use re_sdk_types::archetypes::RecordingInfo;
use re_sdk_types::{AsComponents, SerializationResult, SerializedComponentColumn};
use std::fs::File;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Name of the timeline. It is simulated time.
pub(crate) const TIMELINE: &str = "sim_time";

/// Time after which a viewer that reads nothing is given up.
const PATIENCE: Duration = Duration::from_secs(3);

/// Destination of the messages.
pub(crate) enum Target {
    /// An `.rrd` file. A message is in it when [`Target::send`] returns.
    File(Box<Encoder<File>>),
    /// A viewer that listens at an address. Sending blocks while it does not read.
    Viewer(Connection),
}

impl Target {
    /// A new file. An older file of that name is replaced immediately.
    pub(crate) fn create(path: &Path) -> Result<Self, ViewerError> {
        let file = File::create(path).map_err(ViewerError::io("create", path.display()))?;
        let encoder = Encoder::new_eager(
            CrateVersion::LOCAL,
            EncodingOptions::PROTOBUF_COMPRESSED,
            file,
        );
        let encoder = encoder.map_err(ViewerError::io("write", path.display()))?;
        Ok(Self::File(Box::new(encoder)))
    }

    /// The viewer that listens at `HOST:PORT` or `rerun+http://HOST:PORT/proxy`, and its address
    /// without what surrounds it.
    pub(crate) fn connect(address: &str) -> Result<(Self, String), ViewerError> {
        let plain = address.strip_prefix("rerun+http://");
        let plain = plain.map_or(address, |p| p.strip_suffix("/proxy").unwrap_or(p));
        let bad = |_| ViewerError::Address(address.to_owned());
        let mut found = plain.to_socket_addrs().map_err(bad)?;
        // The client waits for a viewer without limit: test first whether one listens.
        let second = Duration::from_secs(1);
        let answers = |a: &SocketAddr| TcpStream::connect_timeout(a, second).is_ok();
        let Some(listening) = found.find(answers) else {
            return Err(ViewerError::NoViewerListens(plain.to_owned()));
        };
        let viewer = Self::Viewer(Connection::open(listening)?);
        Ok((viewer, plain.to_owned()))
    }

    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        match self {
            Self::File(encoder) => {
                encoder.append(&message)?;
            }
            Self::Viewer(viewer) => viewer.send(&message)?,
        }
        Ok(())
    }

    /// Closes it after the last message. A file gets its index.
    fn finish(&mut self) -> Result<(), Cause> {
        match self {
            Self::File(encoder) => Ok(encoder.finish()?),
            Self::Viewer(viewer) => viewer.finish(),
        }
    }
}

/// The way for batches of messages, and the thread that takes them.
type Work = (Sender<Vec<LogMsg>>, JoinHandle<Result<(), Cause>>);

/// A target with a thread of its own: messages are encoded and written while the next are
/// collected. The run does not wait for it. What waits is at most the recording, whose size does
/// not grow with the length of the run.
struct Background {
    /// `None` when there are no more messages.
    work: Option<Work>,
    /// A message for each batch that the target has taken.
    taken: Receiver<()>,
    /// A target that takes nothing for this time is given up; `None` of a file.
    patience: Option<Duration>,
}

impl Background {
    fn start(mut target: Target) -> Result<Self, ViewerError> {
        let patience = matches!(target, Target::Viewer(_)).then_some(PATIENCE);
        let (batches, received) = channel::<Vec<LogMsg>>();
        let (done, taken) = channel();
        let work = move || {
            for messages in received {
                for message in messages {
                    target.send(message)?;
                }
                // No thread waits for it once the recording has been given up.
                let _ = done.send(());
            }
            target.finish()
        };
        let builder = std::thread::Builder::new().name("recording".to_owned());
        let thread = builder.spawn(work).map_err(ViewerError::Thread)?;
        Ok(Self {
            work: Some((batches, thread)),
            taken,
            patience,
        })
    }

    /// Fails with the error of this batch or of an earlier one, or leaves its error to the next or
    /// the end.
    fn send(&mut self, batch: Vec<LogMsg>) -> Result<(), Cause> {
        match &self.work {
            Some((batches, _)) if batches.send(batch).is_ok() => Ok(()),
            // The thread receives until it fails.
            _ => self.finish(),
        }
    }

    /// Waits until the target has taken everything. A viewer that reads nothing is abandoned with
    /// its thread, which cannot be interrupted.
    fn finish(&mut self) -> Result<(), Cause> {
        let Some((batches, thread)) = self.work.take() else {
            return Err("the recording has ended".into());
        };
        drop(batches);
        if let Some(patience) = self.patience {
            let mut taken = std::iter::repeat_with(|| self.taken.recv_timeout(patience));
            if taken.find_map(Result::err) == Some(RecvTimeoutError::Timeout) {
                return Err("it takes no more data".into());
            }
        }
        let done = thread.join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for Background {
    /// A recording that is given up keeps the messages that it has got.
    fn drop(&mut self) {
        // A drop cannot report an error.
        let _ = self.finish();
    }
}

/// Builds and sends the messages of one recording and its layout.
pub(crate) struct Writer {
    /// File or address, for errors.
    destination: String,
    /// Messages that are not sent yet.
    messages: Vec<LogMsg>,
    background: Background,
    recording: StoreId,
    layout: StoreId,
    fingerprint: u64,
    /// Number of chunks so far.
    chunks: u64,
}

impl Writer {
    /// Starts a recording. Errors name `destination`; `fingerprint` distinguishes recordings of the
    /// same name.
    pub(crate) fn start(
        destination: &str,
        target: Target,
        name: &str,
        fingerprint: u64,
    ) -> Result<Self, ViewerError> {
        let id = format!("{name}-{fingerprint:016x}");
        // The viewer has one layout for each application: a run is one, so that each has its own.
        let application = ApplicationId::try_from(format!("robhaz-{fingerprint:016x}"));
        let application = application.map_err(ViewerError::io("write", destination))?;
        let mut writer = Self {
            destination: destination.to_owned(),
            messages: Vec::new(),
            background: Background::start(target)?,
            recording: StoreId::new(StoreKind::Recording, application.clone(), id.clone()),
            layout: StoreId::new(StoreKind::Blueprint, application, id),
            fingerprint,
            chunks: 0,
        };
        for store in [writer.recording.clone(), writer.layout.clone()] {
            let row_id = *writer.next_id();
            let info = StoreInfo::new(store, StoreSource::Other("robhaz".to_owned()));
            writer.messages.push(SetStoreInfo { row_id, info }.into());
        }
        let info = RecordingInfo::update_fields().with_name(name);
        writer.constant(EntityPath::properties(), &info)?;
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
    ) -> Result<(), ViewerError> {
        // Not static: changes by a user come later on this timeline and take precedence.
        let time = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.row(self.layout.clone(), entity.into(), time, what)
    }

    /// Makes the layout the active one. All its parts must be logged before.
    pub(crate) fn activate_layout(&mut self) {
        let command = BlueprintActivationCommand {
            blueprint_id: self.layout.clone(),
            make_active: true,
            make_default: true,
        };
        self.messages.push(command.into());
    }

    /// Sends the messages so far. It does not wait for the target.
    pub(crate) fn send(&mut self) -> Result<(), ViewerError> {
        let messages = std::mem::take(&mut self.messages);
        let sent = self.background.send(messages);
        sent.map_err(ViewerError::io("write", &self.destination))
    }

    /// Sends the rest, and closes the recording.
    pub(crate) fn finish(&mut self) -> Result<(), ViewerError> {
        self.send()?;
        let finished = self.background.finish();
        finished.map_err(ViewerError::io("write", &self.destination))
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
            .build();
        self.send_chunk(store, chunk)
    }

    fn send_chunk(&mut self, store: StoreId, chunk: ChunkResult<Chunk>) -> Result<(), ViewerError> {
        let message = chunk.and_then(|chunk| chunk.to_arrow_msg());
        let message = message.map_err(ViewerError::io("write", &self.destination))?;
        self.messages.push(LogMsg::ArrowMsg(store, message));
        Ok(())
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
