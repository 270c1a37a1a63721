//! A picture of a recording in the viewer, as a PNG, without a screen.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, hues};
use crate::control::Control;
use crate::error::Cause;
use crate::print::PrintCopy;
use crate::program::{Started, free_port, start_error};
use crate::reading::recording_content;
use crate::theme::Theme;
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time until a picture shows the data.
const TIMEOUT: Duration = Duration::from_secs(90);
/// Time after which the viewer has removed its own messages from its upper right corner.
const MESSAGE_TIME: Duration = Duration::from_secs(7);
/// Time between two pictures.
const PERIOD: Duration = Duration::from_millis(500);
/// Least share of a picture that a colour of the data covers. A rim alone covers 0.001, on a path
/// of 5 m 0.0004.
const LEAST_SHARE: f64 = 1e-4;

/// Height of the bar at the top of the viewer's window, pixels. It cannot be hidden.
const TITLE_BAR: u32 = 28;
/// Width of the window's rounded corners, pixels.
const CORNER: usize = 10;

/// Size, time and theme of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Simulated time to show, s. `None`: the middle of the run.
    pub at: Option<f64>,
    /// Dark as in the viewer, or light for print.
    pub theme: Theme,
}

impl Default for PictureOptions {
    /// 1400 by 900 pixels, the middle of the run.
    fn default() -> Self {
        Self {
            size: [1400, 900],
            at: None,
            theme: Theme::Dark,
        }
    }
}

/// Starts the installed viewer without a window, shows a recording in it, and saves its picture to `out` (PNG). The
/// picture has the views alone, without the panels around them.
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
    let content = if has_wheels {
        Content::Wheels
    } else {
        Content::Lines
    };
    let time = options.at.unwrap_or(0.5 * end);
    // The recording's end is rounded to a nanosecond. NaN is in no range.
    if !(0.0..=end + 1e-9).contains(&time) {
        return Err(ViewerError::Time { at: time, end });
    }
    let copy = PrintCopy::of(recording, out, end)?;
    let port = free_port()?;
    let size = format!("{}x{}", options.size[0], options.size[1] + TITLE_BAR);
    let mut viewer = Started::at(
        port,
        &[
            OsStr::new("--headless"),
            OsStr::new("--window-size"),
            OsStr::new(&size),
            copy.0.as_os_str(),
        ],
    )?;
    let deadline = Deadline {
        start: Instant::now(),
        stop,
    };
    let taken = take(port, out, [time, end], content, options.theme, &deadline);
    // A viewer that cannot draw listens for a moment and exits: its output is the reason.
    let message = viewer.exit_message();
    viewer.end();
    match (taken, message) {
        (Err(ViewerError::Stopped { cause }), _) => Err(ViewerError::Stopped { cause }),
        (Err(_), Some(message)) => Err(start_error(&message)),
        (taken, _) => taken,
    }
}

/// What a picture must show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// The robot, with all three wheels.
    Wheels,
    /// Lines over time alone.
    Lines,
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
    content: Content,
    theme: Theme,
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
    let draft = Draft::beside(out)?;
    let mut before = None;
    loop {
        let image = draft.take(&mut control, deadline)?;
        let missing = image.missing(content);
        if missing.is_none() && before.as_ref() == Some(&image) {
            let written = image.views().write(&draft.0, theme);
            written.map_err(ViewerError::write(&draft.0.display().to_string()))?;
            return std::fs::rename(&draft.0, out).map_err(|source| ViewerError::Create {
                path: out.to_owned(),
                source,
            });
        }
        if deadline.is_over() {
            let reason = missing.unwrap_or_else(|| "it still changes after 90 s".to_owned());
            return Err(ViewerError::Picture { reason });
        }
        before = Some(image);
        deadline.pause(PERIOD)?;
    }
}

/// A file for pictures that may be incomplete. It is removed when the draft is dropped.
struct Draft(PathBuf);

impl Draft {
    /// A draft beside the picture. Its path is absolute, because the viewer may have another working directory.
    fn beside(out: &Path) -> Result<Self, ViewerError> {
        let path = std::path::absolute(out).map_err(|source| ViewerError::Create {
            path: out.to_owned(),
            source,
        })?;
        Ok(Self(path.with_extension("partial.png")))
    }

    /// Takes a picture. The viewer answers before the file is complete, so that reading is repeated until it succeeds.
    fn take(&self, control: &mut Control, deadline: &Deadline<'_>) -> Result<Image, ViewerError> {
        let _ = std::fs::remove_file(&self.0);
        control.save_picture(&self.0)?;
        loop {
            match Image::decode(&self.0) {
                Ok(image) => return Ok(image),
                Err(cause) if deadline.is_over() => {
                    return Err(ViewerError::read(&self.0)(cause));
                }
                Err(_) => deadline.pause(PERIOD / 10)?,
            }
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The pixels of a picture.
#[derive(PartialEq)]
struct Image {
    /// Width and height, pixels.
    size: [u32; 2],
    /// Red, green and blue of each pixel, row by row from the top.
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
        Ok(Self {
            size: [info.width, info.height],
            pixels,
        })
    }

    /// The picture without the title bar, lower by the bar's height. It leaves out empty rows at the top, and rows at
    /// the bottom if those are too few.
    fn views(&self) -> Self {
        let width = self.size[0] as usize;
        let bar = TITLE_BAR as usize;
        let empty = |row: &&[[u8; 3]]| {
            let inner = row.get(CORNER..width.saturating_sub(CORNER));
            inner.is_some_and(|inner| inner.windows(2).all(|pair| pair[0] == pair[1]))
        };
        let rows: Vec<&[[u8; 3]]> = self.pixels.chunks_exact(width.max(1)).collect();
        let top = rows.iter().take(bar).take_while(|row| empty(row)).count();
        let height = rows.len().saturating_sub(bar);
        let kept: Vec<[u8; 3]> = rows
            .iter()
            .skip(top)
            .take(height)
            .copied()
            .flatten()
            .copied()
            .collect();
        Self {
            size: [self.size[0], u32::try_from(height).unwrap_or(u32::MAX)],
            pixels: kept,
        }
    }

    /// Writes the picture in a theme.
    fn write(&self, path: &Path, theme: Theme) -> Result<(), Cause> {
        let file = BufWriter::new(File::create(path)?);
        let mut encoder = png::Encoder::new(file, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        let bytes: Vec<u8> = self.pixels.iter().flat_map(|p| theme.pixel(*p)).collect();
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(())
    }

    /// Names what is missing. `None` for a picture that shows the data.
    fn missing(&self, content: Content) -> Option<String> {
        #[expect(clippy::cast_precision_loss, reason = "a few million pixels")]
        let share = |colour: Colour| {
            let near = self.pixels.iter().filter(|p| is_near(p, colour)).count();
            near as f64 / self.pixels.len().max(1) as f64
        };
        if content == Content::Lines {
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
            size: [100, 100],
            pixels: vec![[13, 16, 17]; 10_000],
        };
        let missing = image.missing(Content::Wheels).expect("nothing is shown");
        assert!(missing.contains("front, middle, rear"), "{missing}");
        for (i, Colour(colour)) in WHEELS.into_iter().enumerate() {
            image.pixels[20 * i..20 * i + 20].fill(colour);
        }
        assert_eq!(image.missing(Content::Wheels), None);
        image.pixels[..20].fill([0; 3]);
        let missing = image.missing(Content::Wheels);
        let missing = missing.expect("the front wheel is not there");
        assert!(missing.contains("the front wheel"), "{missing}");
    }

    /// A recording without a robot needs no wheels in its picture: the line of one estimator is
    /// enough, and an empty layout is not.
    #[test]
    fn a_picture_of_lines_needs_one_of_them() {
        let mut image = Image {
            size: [100, 100],
            pixels: vec![[13, 16, 17]; 10_000],
        };
        assert!(image.missing(Content::Lines).is_some());
        image.pixels[..20].fill(crate::colours::by_index(0).0);
        assert_eq!(image.missing(Content::Lines), None);
        assert!(image.missing(Content::Wheels).is_some());
    }

    /// Closed form: an empty bar of 28 rows is left out; a first row with a pattern is not.
    #[test]
    fn the_title_bar_is_left_out() {
        let width = 40;
        let row = |grey: u8| vec![[grey; 3]; width];
        let mut pixels: Vec<[u8; 3]> = (0..28).flat_map(|_| row(13)).collect();
        pixels.extend((0..20_u8).flat_map(|k| [vec![[k; 3]; 20], row(99)[20..].to_vec()].concat()));
        let image = Image {
            size: [40, 48],
            pixels,
        };
        let views = image.views();
        assert_eq!(views.size, [40, 20]);
        assert_eq!(views.pixels[0], [0; 3]);
        assert_eq!(views.pixels.len(), 800);
        // A picture whose first row is not empty keeps it.
        let full = Image {
            size: [40, 48],
            pixels: (0..48_u8)
                .flat_map(|k| [vec![[k; 3]; 20], row(99)[20..].to_vec()].concat())
                .collect(),
        };
        assert_eq!(full.views().pixels[0], [0; 3]);
        assert_eq!(full.views().size, [40, 20]);
    }
}
