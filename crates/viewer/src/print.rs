//! A copy of a recording with a layout for pictures: no panels around the views, and the whole run in each plot.
//!
//! The lanes of states have no setting for their range of time.

use crate::ViewerError;
use crate::writer::{RrdFile, Target};
use rerun::datatypes::{TimeInt, TimeRange, TimeRangeBoundary};
use rerun::external::re_log_encoding::Decoder;
use rerun::external::re_log_types::external::re_tuid::Tuid;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    PanelBlueprint, TimeAxis, TimePanelBlueprint,
};
use rerun::external::re_sdk_types::blueprint::components::{LinkAxis, PanelState};
use rerun::log::{Chunk, ChunkId, LogMsg, RowId};
use rerun::{AsComponents, EntityPath, StoreId, StoreKind, TimePoint, Timeline};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use tempfile::{NamedTempFile, TempPath};

/// Panels around the views.
const PANELS: [&str; 3] = ["top_panel", "blueprint_panel", "selection_panel"];
/// Share of a run by which a time axis is longer than the run. The label at the end needs that room.
const MARGIN: f64 = 0.05;
/// Name of the layout in errors.
const LAYOUT: &str = "the layout of a picture";
/// Name of a plot's time axis in the layout.
const TIME_AXIS: &str = "TimeAxis";

/// A temporary file beside a picture, of an absolute path: the viewer may have another working directory.
pub(crate) fn beside(picture: &Path, extension: &str) -> Result<TempPath, ViewerError> {
    let path = std::path::absolute(picture);
    let file = path.and_then(|path| {
        let folder = path.parent().unwrap_or(Path::new("/"));
        tempfile::Builder::new()
            .suffix(extension)
            .tempfile_in(folder)
    });
    file.map(NamedTempFile::into_temp_path)
        .map_err(|source| ViewerError::Create {
            path: picture.to_owned(),
            source,
        })
}

/// Copies a recording with an `end` (s) to the file `to`.
///
/// # Errors
/// [`ViewerError::Create`], [`ViewerError::Write`], [`ViewerError::Read`]
pub(crate) fn print_copy(recording: &Path, to: &Path, end: f64) -> Result<(), ViewerError> {
    let destination = to.display().to_string();
    let mut out = RrdFile::begin(RrdFile::create(to)?).map_err(ViewerError::write(&destination))?;
    let mut send = |message| out.send(message).map_err(ViewerError::write(&destination));

    let file = File::open(recording).map_err(ViewerError::read(recording))?;
    let messages = Decoder::decode_eager(BufReader::new(file));
    let mut rows = Rows::default();
    for message in messages.map_err(ViewerError::read(recording))? {
        let message: LogMsg = message.map_err(ViewerError::read(recording))?;
        match &message {
            LogMsg::ArrowMsg(store, arrow) if store.kind() == StoreKind::Blueprint => {
                let chunk = Chunk::from_arrow_msg(arrow).map_err(ViewerError::read(recording))?;
                let entity = chunk.entity_path().clone();
                let store = store.clone();
                send(message)?;
                if entity.to_string().ends_with(TIME_AXIS) {
                    send(rows.next(store, entity, &whole_time(end))?)?;
                }
            }
            LogMsg::BlueprintActivationCommand(command) => {
                let hidden = PanelBlueprint::new().with_state(PanelState::Hidden);
                for panel in PANELS {
                    let store = command.blueprint_id.clone();
                    send(rows.next(store, EntityPath::from(panel), &hidden)?)?;
                }
                let time = TimePanelBlueprint::new().with_state(PanelState::Hidden);
                let store = command.blueprint_id.clone();
                send(rows.next(store, EntityPath::from("time_panel"), &time)?)?;
                send(message)?;
            }
            _ => send(message)?,
        }
    }
    out.finish().map_err(ViewerError::write(&destination))
}

/// A time axis of a whole run with an `end` (s).
fn whole_time(end: f64) -> TimeAxis {
    #[expect(clippy::cast_possible_truncation, reason = "times of a run")]
    let at = |time: f64| TimeRangeBoundary::Absolute(TimeInt((time * 1e9).round() as i64));
    TimeAxis::new()
        .with_link(LinkAxis::Independent)
        .with_view_range(TimeRange {
            start: at(-0.2 * MARGIN * end),
            end: at((1.0 + MARGIN) * end),
        })
}

/// Numbers rows of a layout so that they count as later than those of [`crate::writer::Writer`].
#[derive(Default)]
struct Rows(u64);

impl Rows {
    /// The next row, as a message.
    fn next(
        &mut self,
        store: StoreId,
        entity: EntityPath,
        what: &dyn AsComponents,
    ) -> Result<LogMsg, ViewerError> {
        self.0 += 1;
        let id = ChunkId::from_tuid(Tuid::from_nanos_and_inc(u64::MAX >> 2, self.0 << 32));
        let time = TimePoint::default().with(Timeline::new_sequence("blueprint"), 1);
        let chunk = Chunk::builder_with_id(id, entity)
            .with_archetype(RowId::from_tuid((*id).next()), time, what)
            .build()
            .map_err(ViewerError::write(LAYOUT))?;
        let message = chunk.to_arrow_msg().map_err(ViewerError::write(LAYOUT))?;
        Ok(LogMsg::ArrowMsg(store, message))
    }
}
