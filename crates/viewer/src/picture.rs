//! A recording as the viewer shows it, in a PNG, without a screen.

use crate::colours::{Colour, WHEELS};
use crate::control::Control;
use crate::error::Cause;
use crate::program::{Started, free_port, start_error};
use crate::{ViewerError, recording_end};
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long the viewer may take until its picture shows the data.
const PATIENCE: Duration = Duration::from_secs(90);
/// How long the viewer's own messages lie over its upper right corner.
const MESSAGES: Duration = Duration::from_secs(7);
/// Between two pictures.
const PAUSE: Duration = Duration::from_millis(500);
/// Each wheel's colour covers at least this share of a picture that shows the data: a rim alone is a thousandth.
const LEAST_SHARE: f64 = 5e-4;

/// What to take a picture of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width and height of the viewer and of the picture, in pixels.
    pub size: [u32; 2],
    /// Simulated time to show, s; by default the middle of the run.
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

/// Lets the installed viewer, without a window, show a recording, and saves its picture to `out`.
///
/// The picture is taken when the whole recording is loaded and two pictures in a row are the same, and only kept when the
/// colours of all three wheels are in it.
///
/// # Errors
/// [`ViewerError`]: no viewer, the recording cannot be read, it does not hold the time, no picture shows the data, or `stop`
/// names a cause.
pub fn picture(
    recording: &Path,
    out: &Path,
    options: PictureOptions,
    stop: Stop<'_>,
) -> Result<(), ViewerError> {
    let end = recording_end(recording)?.ok_or_else(|| ViewerError::Picture {
        reason: format!("{} has no data", recording.display()),
    })?;
    let time = options.at.unwrap_or(0.5 * end);
    // The recording's end is rounded to a nanosecond. Not a number is not in the run either.
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
    let patience = Patience {
        start: Instant::now(),
        stop,
    };
    let taken = take(port, out, [time, end], &patience);
    // Without a renderer it listens for a moment and ends.
    let words = viewer.last_words();
    viewer.end();
    match (taken, words) {
        (Err(ViewerError::Stopped { cause }), _) => Err(ViewerError::Stopped { cause }),
        (Err(_), Some(words)) => Err(start_error(&words)),
        (taken, _) => taken,
    }
}

/// How long to wait for the viewer.
struct Patience<'a> {
    start: Instant,
    stop: Stop<'a>,
}

impl Patience<'_> {
    fn is_over(&self) -> bool {
        self.start.elapsed() > PATIENCE
    }

    /// Sleeps, unless the caller has had enough.
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

/// A picture at a time of a recording that ends at another, s.
fn take(
    port: u16,
    out: &Path,
    [time, end]: [f64; 2],
    patience: &Patience<'_>,
) -> Result<(), ViewerError> {
    let mut control = Control::call(port)?;
    // To a nanosecond: the recording's own resolution.
    while control.newest()?.is_none_or(|newest| newest < end - 1e-9) {
        if patience.is_over() {
            return Err(ViewerError::Picture {
                reason: "the recording is not loaded after 90 s".to_owned(),
            });
        }
        patience.pause(PAUSE)?;
    }
    control.show(time)?;
    while patience.start.elapsed() < MESSAGES {
        patience.pause(PAUSE)?;
    }
    let draft = Draft::beside(out)?;
    let mut before = None;
    loop {
        let image = draft.take(&mut control, patience)?;
        let missing = image.missing();
        if missing.is_none() && before.as_ref() == Some(&image) {
            return std::fs::rename(&draft.0, out).map_err(|source| ViewerError::Create {
                path: out.to_owned(),
                source,
            });
        }
        if patience.is_over() {
            let reason = missing.unwrap_or_else(|| "it does not come to rest".to_owned());
            return Err(ViewerError::Picture { reason });
        }
        before = Some(image);
        patience.pause(PAUSE)?;
    }
}

/// A picture that may not be good enough yet; gone when it was not.
struct Draft(PathBuf);

impl Draft {
    /// At an absolute path beside the picture: the viewer has a working directory of its own.
    fn beside(out: &Path) -> Result<Self, ViewerError> {
        let path = std::path::absolute(out).map_err(|source| ViewerError::Create {
            path: out.to_owned(),
            source,
        })?;
        Ok(Self(path.with_extension("partial.png")))
    }

    /// A picture taken now. The viewer answers before the file is written: it is read until it is whole.
    fn take(&self, control: &mut Control, patience: &Patience<'_>) -> Result<Image, ViewerError> {
        let _ = std::fs::remove_file(&self.0);
        control.save_picture(&self.0)?;
        loop {
            match Image::decode(&self.0) {
                Ok(image) => return Ok(image),
                Err(cause) if patience.is_over() => {
                    return Err(ViewerError::read(&self.0)(cause));
                }
                Err(_) => patience.pause(PAUSE / 10)?,
            }
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Pixels of a picture.
#[derive(PartialEq)]
struct Image {
    /// Red, green, blue of each pixel.
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

    /// What a picture that shows the data would have, and this has not.
    fn missing(&self) -> Option<String> {
        #[expect(clippy::cast_precision_loss, reason = "a few million pixels")]
        let share = |colour: Colour| {
            let near = self.pixels.iter().filter(|p| is_near(p, colour)).count();
            near as f64 / self.pixels.len().max(1) as f64
        };
        let wheels = ["front", "middle", "rear"].into_iter().zip(WHEELS);
        let absent = wheels.filter(|(_, colour)| share(*colour) < LEAST_SHARE);
        let names: Vec<&str> = absent.map(|(name, _)| name).collect();
        (!names.is_empty())
            .then(|| format!("the colour of the {} wheel is missing", names.join(", ")))
    }
}

/// Within what smoothing of edges leaves of a colour.
fn is_near(pixel: &[u8; 3], Colour(colour): Colour) -> bool {
    pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 12)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of the welcome page, or of an empty layout, is not taken for one of a run.
    #[test]
    fn a_picture_without_the_wheels_is_not_enough() {
        let mut image = Image {
            pixels: vec![[13, 16, 17]; 10_000],
        };
        let missing = image.missing().expect("nothing is shown");
        assert!(missing.contains("front, middle, rear"), "{missing}");
        for (i, Colour(colour)) in WHEELS.into_iter().enumerate() {
            image.pixels[20 * i..20 * i + 20].fill(colour);
        }
        assert_eq!(image.missing(), None);
        image.pixels[..20].fill([0; 3]);
        let missing = image.missing().expect("the front wheel has gone");
        assert!(missing.contains("the front wheel"), "{missing}");
    }
}
