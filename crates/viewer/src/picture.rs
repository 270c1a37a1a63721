//! A picture of a recording in the viewer, as a PNG, without a screen.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, hues};
use crate::control::Control;
use crate::error::Cause;
use crate::program::{Started, free_port, start_error};
use crate::reading::recording_content;
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::{Duration, Instant};
use tempfile::{NamedTempFile, TempPath};

/// Longest time until a picture shows the data.
const TIMEOUT: Duration = Duration::from_secs(90);
/// Time after which the viewer has removed its own messages from its upper right corner.
const MESSAGE_TIME: Duration = Duration::from_secs(7);
/// Time between two pictures.
const PERIOD: Duration = Duration::from_millis(500);
/// Least share of a picture that a colour of the data covers. A rim alone covers 0.001, on a path
/// of 5 m 0.0004.
const LEAST_SHARE: f64 = 1e-4;

/// Size and time of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Simulated time to show, s. `None`: the middle of the run.
    pub at: Option<f64>,
}

impl Default for PictureOptions {
    /// 1400 by 900 pixels, the middle of the run.
    fn default() -> Self {
        Self {
            size: [1400, 900],
            at: None,
        }
    }
}

/// Starts the installed viewer without a window, shows a recording in it, and saves its picture to `out` (PNG).
///
/// The picture is saved when the whole recording is loaded, two pictures in a row are equal, and
/// the data are in them: the colours of all three wheels, or, where the recording has no robot,
/// that of some line.
///
/// # Errors
/// - [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`], [`ViewerError::Start`]: no viewer that can draw.
/// - [`ViewerError::Read`]: the recording cannot be read. [`ViewerError::Time`]: it does not contain the time.
/// - [`ViewerError::Picture`]: no picture shows the data within 90 s. [`ViewerError::Control`]: the viewer does not
///   answer.
/// - [`ViewerError::Create`], [`ViewerError::Write`]: the picture, or a file beside it, cannot be written.
/// - [`ViewerError::Stopped`]: `stop` named a cause.
pub fn picture(
    recording: &Path,
    out: &Path,
    options: PictureOptions,
    stop: Stop<'_>,
) -> Result<(), ViewerError> {
    let (end, has_wheels) = recording_content(recording)?;
    let end = end.ok_or_else(|| ViewerError::Picture {
        reason: format!("{} has no data", recording.display()),
    })?;
    let time = options.at.unwrap_or(0.5 * end);
    // The recording's end is rounded to a nanosecond. NaN is in no range.
    if !(0.0..=end + 1e-9).contains(&time) {
        return Err(ViewerError::Time { at: time, end });
    }
    let port = free_port()?;
    let size = format!("{}x{}", options.size[0], options.size[1]);
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
    let taken = take(port, out, [time, end], has_wheels, &deadline);
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

/// Saves a picture at a `time` of a recording with an `end` (both s). It must show all three wheels, or lines alone.
fn take(
    port: u16,
    out: &Path,
    [time, end]: [f64; 2],
    has_wheels: bool,
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
        let missing = image.missing(has_wheels);
        if missing.is_none() && before.as_ref() == Some(&image) {
            return draft
                .persist(out)
                .map_err(|error| ViewerError::create(out)(error.error));
        }
        if deadline.is_over() {
            let reason = missing.unwrap_or_else(|| "it still changes after 90 s".to_owned());
            return Err(ViewerError::Picture { reason });
        }
        before = Some(image);
        deadline.pause(PERIOD)?;
    }
}

/// A temporary file beside a picture, of an absolute path: the viewer may have another working directory.
fn beside(picture: &Path) -> Result<TempPath, ViewerError> {
    let path = std::path::absolute(picture);
    let file = path.and_then(|path| {
        let folder = path.parent().unwrap_or(Path::new("/"));
        let mut name = tempfile::Builder::new();
        name.suffix(".png").tempfile_in(folder)
    });
    file.map(NamedTempFile::into_temp_path)
        .map_err(ViewerError::create(picture))
}

/// Takes a picture. The viewer answers before the file is complete, so that reading is repeated until it succeeds.
fn take_draft(
    draft: &Path,
    control: &mut Control,
    deadline: &Deadline<'_>,
) -> Result<Image, ViewerError> {
    let _ = std::fs::remove_file(draft);
    control.save_picture(draft)?;
    loop {
        match Image::decode(draft) {
            Ok(image) => return Ok(image),
            Err(cause) if deadline.is_over() => return Err(ViewerError::read(draft)(cause)),
            Err(_) => deadline.pause(PERIOD / 10)?,
        }
    }
}

/// Red, green and blue of each pixel of a picture.
#[derive(PartialEq)]
struct Image {
    pixels: Vec<[u8; 3]>,
}

impl Image {
    fn decode(path: &Path) -> Result<Self, Cause> {
        let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let size = reader
            .output_buffer_size()
            .ok_or("the picture is too large")?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes)?;
        bytes.truncate(info.buffer_size());
        let pixels = bytes.chunks_exact(info.color_type.samples());
        let pixels = pixels.filter_map(|p| p.get(..3)?.try_into().ok()).collect();
        Ok(Self { pixels })
    }

    /// Names what is missing. `None` for a picture that shows the data.
    fn missing(&self, has_wheels: bool) -> Option<String> {
        #[expect(clippy::cast_precision_loss, reason = "a few million pixels")]
        let share = |colour: Colour| {
            let near = self.pixels.iter().filter(|p| is_near(p, colour)).count();
            near as f64 / self.pixels.len().max(1) as f64
        };
        if !has_wheels {
            let is_empty = hues().all(|colour| share(colour) < LEAST_SHARE);
            return is_empty.then(|| "no line has a colour of the data".to_owned());
        }
        let wheels = ["front", "middle", "rear"].into_iter().zip(WHEELS);
        let absent = wheels.filter(|(_, colour)| share(*colour) < LEAST_SHARE);
        let names: Vec<&str> = absent.map(|(name, _)| name).collect();
        (!names.is_empty())
            .then(|| format!("the colour of the {} wheel is missing", names.join(", ")))
    }
}

/// The pixel has a colour, except for the smoothing of edges.
fn is_near(pixel: &[u8; 3], Colour(colour): Colour) -> bool {
    pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 12)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of the welcome page or of an empty layout does not show the data; nor does one without the front
    /// wheel.
    #[test]
    fn a_picture_without_the_wheels_is_not_enough() {
        let mut image = Image {
            pixels: vec![[13, 16, 17]; 10_000],
        };
        let missing = image.missing(true).expect("nothing is shown");
        assert!(missing.contains("front, middle, rear"), "{missing}");
        for (i, Colour(colour)) in WHEELS.into_iter().enumerate() {
            image.pixels[20 * i..20 * i + 20].fill(colour);
        }
        assert_eq!(image.missing(true), None);
        image.pixels[..20].fill([0; 3]);
        let missing = image.missing(true);
        let missing = missing.expect("the front wheel is not there");
        assert!(missing.contains("the front wheel"), "{missing}");
    }

    /// A recording without a robot needs no wheels in its picture: the line of one estimator is
    /// enough, and an empty layout is not.
    #[test]
    fn a_picture_of_lines_needs_one_of_them() {
        let mut image = Image {
            pixels: vec![[13, 16, 17]; 10_000],
        };
        assert!(image.missing(false).is_some());
        image.pixels[..20].fill(crate::colours::by_index(0).0);
        assert_eq!(image.missing(false), None);
        assert!(image.missing(true).is_some());
    }
}
