//! A picture of a recording in the viewer, as a PNG, without a screen; where a recording ends.

use crate::error::{Cause, Result, ViewerError};
use crate::program::{Started, free_port, start_error};
use crate::writer::TIMELINE;
use re_chunk::Chunk;
use re_log_encoding::Decoder;
use re_log_types::{LogMsg, StoreKind};
use re_protos::common::v1alpha1::{Timeline, TimelineTime};
use re_protos::sdk_comms::v1alpha1::viewer_control_service_client::ViewerControlServiceClient;
use re_protos::sdk_comms::v1alpha1::{
    GetViewerStateRequest, SaveScreenshotRequest, SetTimeCursorRequest,
};
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::{Duration, Instant};
use tempfile::{NamedTempFile, TempPath};
use tokio::runtime::{Builder, Runtime};
use tonic::transport::{Channel, Endpoint};

/// Longest time until a picture shows the data.
const TIMEOUT: Duration = Duration::from_secs(90);
/// Longest time for an answer of the viewer. Software rendering is slow.
const ANSWER_TIME: Duration = Duration::from_secs(30);
/// Time after which the viewer has removed its own messages from its upper right corner.
const MESSAGE_TIME: Duration = Duration::from_secs(7);
/// Time between two pictures.
const PERIOD: Duration = Duration::from_millis(500);
/// The last chunk of a PNG: its type and checksum.
const PNG_END: &[u8] = b"IEND\xaeB`\x82";

/// Starts the installed viewer without a window, shows a recording in it, and saves its picture to
/// `out` (PNG): of a width and height (pixels), at a simulated time (s), or in the middle of the
/// run.
///
/// The picture is saved when the whole recording is loaded and two pictures in a row are equal.
///
/// # Errors
/// - [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`], [`ViewerError::Start`]: no
///   viewer that can draw.
/// - [`ViewerError::Io`]: the recording cannot be read. [`ViewerError::Time`]: it does not contain
///   the time.
/// - [`ViewerError::Picture`]: no picture stays the same within 90 s. [`ViewerError::Control`]: the
///   viewer does not answer.
/// - [`ViewerError::Io`]: the picture, or a file beside it, cannot be written.
/// - [`ViewerError::Stopped`]: `stop` named a cause.
pub fn picture(
    recording: &Path,
    out: &Path,
    size: [u32; 2],
    at: Option<f64>,
    stop: Stop<'_>,
) -> Result {
    let none = || ViewerError::Picture(format!("{} has no data", recording.display()));
    let end = recording_end(recording)?.ok_or_else(none)?;
    let time = at.unwrap_or(0.5 * end);
    // The recording's end is rounded to a nanosecond. NaN is in no range.
    if !(0.0..=end + 1e-9).contains(&time) {
        return Err(ViewerError::Time { at: time, end });
    }
    let draft = beside(out)?;
    let port = free_port()?;
    let size = format!("{}x{}", size[0], size[1]);
    let arguments = ["--headless", "--window-size", &size].map(OsStr::new);
    let arguments = [&arguments[..], &[recording.as_os_str()]].concat();
    let mut viewer = Started::at(port, &arguments)?;
    let deadline = Deadline {
        start: Instant::now(),
        stop,
    };
    let taken = take(port, &draft, [time, end], &deadline);
    // A viewer that cannot draw listens for a moment and exits: its output is the reason.
    let message = viewer.exit_message();
    viewer.end();
    let image = match (taken, message) {
        (stopped @ Err(ViewerError::Stopped(_)), _) => stopped,
        (Err(_), Some(message)) => Err(start_error(message)),
        (taken, _) => taken,
    }?;
    // Not the viewer's file, which it may write once more.
    std::fs::write(out, image).map_err(ViewerError::io("create", out.display()))
}

/// The limit of waiting for the viewer.
struct Deadline<'a> {
    start: Instant,
    stop: Stop<'a>,
}

impl Deadline<'_> {
    fn is_over(&self) -> bool {
        self.start.elapsed() > TIMEOUT
    }

    /// Sleeps, unless the caller stops the work.
    fn pause(&self, time: Duration) -> Result {
        if let Some(cause) = (self.stop)() {
            return Err(ViewerError::Stopped(cause));
        }
        std::thread::sleep(time);
        Ok(())
    }
}

/// The picture (PNG) at a `time` of a recording with an `end` (both s), which the viewer writes to
/// `draft`.
fn take(
    port: u16,
    draft: &Path,
    [time, end]: [f64; 2],
    deadline: &Deadline<'_>,
) -> Result<Vec<u8>> {
    let failed = |why: &str| Err(ViewerError::Picture(format!("{why} after 90 s")));
    let mut control = Control::call(port)?;
    // One nanosecond is the recording's resolution.
    while control.newest()?.is_none_or(|newest| newest < end - 1e-9) {
        if deadline.is_over() {
            return failed("the recording is not loaded");
        }
        deadline.pause(PERIOD)?;
    }
    control.show(time)?;
    while deadline.start.elapsed() < MESSAGE_TIME {
        deadline.pause(PERIOD)?;
    }
    let mut before = None;
    loop {
        let image = take_draft(draft, &mut control, deadline)?;
        if before.as_ref() == Some(&image) {
            return Ok(image);
        }
        if deadline.is_over() {
            return failed("it still changes");
        }
        before = Some(image);
        deadline.pause(PERIOD)?;
    }
}

/// A temporary file beside a picture, of an absolute path: the viewer may have another working
/// directory.
fn beside(picture: &Path) -> Result<TempPath> {
    let path = std::path::absolute(picture);
    let file = path.and_then(|path| {
        let folder = path.parent().unwrap_or(Path::new("/"));
        let mut name = tempfile::Builder::new();
        name.suffix(".png").tempfile_in(folder)
    });
    file.map(NamedTempFile::into_temp_path)
        .map_err(ViewerError::io("create", picture.display()))
}

/// Takes a picture. The viewer answers before the file is complete, so that reading is repeated
/// until it succeeds.
fn take_draft(draft: &Path, control: &mut Control, deadline: &Deadline<'_>) -> Result<Vec<u8>> {
    let _ = std::fs::remove_file(draft);
    control.save_picture(draft)?;
    loop {
        match std::fs::read(draft) {
            Ok(image) if image.ends_with(PNG_END) => return Ok(image),
            Err(cause) if deadline.is_over() => {
                let failed = ViewerError::io("read the picture", draft.display());
                return Err(failed(cause));
            }
            _ => deadline.pause(PERIOD / 10)?,
        }
    }
}

/// A connection to a viewer.
struct Control {
    runtime: Runtime,
    client: ViewerControlServiceClient<Channel>,
}

impl Control {
    /// Connects to the viewer that listens at a port of this machine.
    fn call(port: u16) -> Result<Self> {
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(ViewerError::Thread)?;
        let channel = answer(&runtime, "a connection", async {
            let endpoint = Endpoint::from_shared(format!("http://127.0.0.1:{port}"))?;
            endpoint.timeout(ANSWER_TIME).connect().await
        })?;
        let client = ViewerControlServiceClient::new(channel);
        Ok(Self { runtime, client })
    }

    /// Newest simulated time of any recording in the viewer, s. `None`: the viewer has no recording
    /// yet.
    fn newest(&mut self) -> Result<Option<f64>> {
        let request = self.client.get_viewer_state(GetViewerStateRequest {});
        let state = answer(&self.runtime, "its state", request)?.into_inner();
        let timelines = state.recordings.iter().flat_map(|r| &r.timelines);
        let ours = timelines.filter(|t| t.timeline.as_ref().is_some_and(|t| t.name == TIMELINE));
        let newest = ours.filter_map(|t| Some(t.time_range.as_ref()?.end)).max();
        // Exact up to a hundred days.
        Ok(newest.map(|ns| ns as f64 * 1e-9))
    }

    /// Moves the cursor to a simulated time (s) and pauses there.
    fn show(&mut self, time: f64) -> Result {
        // Times of a run.
        let time = (time * 1e9).round() as i64;
        let name = TIMELINE.to_owned();
        let request = SetTimeCursorRequest {
            store_id: None,
            timeline: Some(Timeline { name }),
            time: Some(TimelineTime { time }),
            play: false,
        };
        let request = self.client.set_time_cursor(request);
        answer(&self.runtime, "another time", request).map(|_| ())
    }

    /// Lets the viewer save a picture of its window (PNG). It answers before the file is complete.
    fn save_picture(&mut self, path: &Path) -> Result {
        let request = SaveScreenshotRequest {
            view_id: None,
            file_path: path.display().to_string(),
        };
        let request = self.client.save_screenshot(request);
        answer(&self.runtime, "a picture", request).map(|_| ())
    }
}

/// Waits for the answer of a viewer; [`ViewerError::Control`] without one.
fn answer<T, E: Into<Cause>>(
    runtime: &Runtime,
    request: &'static str,
    answer: impl Future<Output = Result<T, E>>,
) -> Result<T> {
    let answer = runtime.block_on(answer);
    answer.map_err(|cause| ViewerError::Control {
        request,
        source: cause.into(),
    })
}

/// Time of the newest row of a recording, s. `None`: it has no rows. A file that ends within a
/// message, as that of a killed run, is read up to that message.
///
/// # Errors
/// [`ViewerError::Io`]
pub fn recording_end(path: &Path) -> Result<Option<f64>> {
    let end = newest(path).map_err(ViewerError::io("read the recording", path.display()))?;
    // Exact up to a hundred days.
    Ok(end.map(|ns| ns as f64 * 1e-9))
}

/// Time of the newest row, ns.
fn newest(path: &Path) -> Result<Option<i64>, Cause> {
    let mut end: Option<i64> = None;
    for message in Decoder::<LogMsg>::decode_eager(BufReader::new(File::open(path)?))? {
        if let LogMsg::ArrowMsg(store, message) = message?
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message)?;
            let newest = chunk.timelines().values().flat_map(|t| t.times_raw()).max();
            end = end.max(newest.copied());
        }
    }
    Ok(end)
}
