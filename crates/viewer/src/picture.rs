//! A picture of a recording in the viewer, as a PNG, without a screen.

use crate::ViewerError;
use crate::control::Control;
use crate::program::{Started, free_port, start_error};
use crate::reading::recording_end;
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::path::Path;
use std::time::{Duration, Instant};
use tempfile::{NamedTempFile, TempPath};

/// Longest time until a picture shows the data.
const TIMEOUT: Duration = Duration::from_secs(90);
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
) -> Result<(), ViewerError> {
    let end = recording_end(recording)?.ok_or_else(|| ViewerError::Picture {
        reason: format!("{} has no data", recording.display()),
    })?;
    let time = at.unwrap_or(0.5 * end);
    // The recording's end is rounded to a nanosecond. NaN is in no range.
    if !(0.0..=end + 1e-9).contains(&time) {
        return Err(ViewerError::Time { at: time, end });
    }
    let port = free_port()?;
    let size = format!("{}x{}", size[0], size[1]);
    let mut viewer = Started::at(
        port,
        &[
            OsStr::new("--headless"),
            OsStr::new("--window-size"),
            OsStr::new(&size),
            recording.as_os_str(),
        ],
    )?;
    let deadline = Deadline {
        start: Instant::now(),
        stop,
    };
    let taken = take(port, out, [time, end], &deadline);
    // A viewer that cannot draw listens for a moment and exits: its output is the reason.
    let message = viewer.exit_message();
    viewer.end();
    match (taken, message) {
        (Err(ViewerError::Stopped { cause }), _) => Err(ViewerError::Stopped { cause }),
        (Err(_), Some(message)) => Err(start_error(&message)),
        (taken, _) => taken,
    }
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
    fn pause(&self, time: Duration) -> Result<(), ViewerError> {
        match (self.stop)() {
            Some(cause) => Err(ViewerError::Stopped { cause }),
            None => {
                std::thread::sleep(time);
                Ok(())
            }
        }
    }
}

/// Saves a picture at a `time` of a recording with an `end` (both s).
fn take(
    port: u16,
    out: &Path,
    [time, end]: [f64; 2],
    deadline: &Deadline<'_>,
) -> Result<(), ViewerError> {
    let mut control = Control::call(port)?;
    // One nanosecond is the recording's resolution.
    while control.newest()?.is_none_or(|newest| newest < end - 1e-9) {
        if deadline.is_over() {
            return Err(ViewerError::Picture {
                reason: "the recording is not loaded after 90 s".to_owned(),
            });
        }
        deadline.pause(PERIOD)?;
    }
    control.show(time)?;
    while deadline.start.elapsed() < MESSAGE_TIME {
        deadline.pause(PERIOD)?;
    }
    let draft = beside(out)?;
    let mut before = None;
    loop {
        let image = take_draft(&draft, &mut control, deadline)?;
        if before.as_ref() == Some(&image) {
            return draft
                .persist(out)
                .map_err(|error| ViewerError::io("create", out.display())(error.error));
        }
        if deadline.is_over() {
            return Err(ViewerError::Picture {
                reason: "it still changes after 90 s".to_owned(),
            });
        }
        before = Some(image);
        deadline.pause(PERIOD)?;
    }
}

/// A temporary file beside a picture, of an absolute path: the viewer may have another working
/// directory.
fn beside(picture: &Path) -> Result<TempPath, ViewerError> {
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
fn take_draft(
    draft: &Path,
    control: &mut Control,
    deadline: &Deadline<'_>,
) -> Result<Vec<u8>, ViewerError> {
    let _ = std::fs::remove_file(draft);
    control.save_picture(draft)?;
    loop {
        match std::fs::read(draft) {
            Ok(image) if image.ends_with(PNG_END) => return Ok(image),
            Err(cause) if deadline.is_over() => {
                return Err(ViewerError::io("read the recording", draft.display())(
                    cause,
                ));
            }
            _ => deadline.pause(PERIOD / 10)?,
        }
    }
}
