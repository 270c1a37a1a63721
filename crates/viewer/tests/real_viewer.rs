//! The installed viewer shows the data at the right places. Without a viewer that can draw, the
//! tests are skipped.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

mod common;

use robhaz_estimator::SensorFrame;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_viewer::{RecordingSink, ViewerError, picture};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

const WIDTH: usize = 1000;
const HEIGHT: usize = 700;

/// Colours of the front, middle and rear wheel, and below that of the estimator `paper-body`.
const WHEELS: [[u8; 3]; 3] = [[0x00, 0x72, 0xB2], [0xD5, 0x5E, 0x00], [0x00, 0x9E, 0x73]];
const PAPER_BODY: [u8; 3] = [0xCC, 0x79, 0xA7];

/// The pixels of a picture (red, green, blue), row by row from the top.
fn pixels(path: &Path) -> Vec<[u8; 3]> {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path).expect("a picture")));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    assert_eq!((info.width, info.height), (WIDTH as u32, HEIGHT as u32));
    let bytes = bytes[..info.buffer_size()].chunks_exact(info.color_type.samples());
    bytes.map(|p| [p[0], p[1], p[2]]).collect()
}

/// Number and mean position of the pixels close to a colour, in a part of the picture. Positions
/// are shares of its size.
fn found(pixels: &[[u8; 3]], colour: [u8; 3], x: [f64; 2], y: [f64; 2]) -> (usize, [f64; 2]) {
    let (mut count, mut sum) = (0, [0.0; 2]);
    for (i, pixel) in pixels.iter().enumerate() {
        let at = [
            (i % WIDTH) as f64 / WIDTH as f64,
            (i / WIDTH) as f64 / HEIGHT as f64,
        ];
        let inside = (x[0]..x[1]).contains(&at[0]) && (y[0]..y[1]).contains(&at[1]);
        if inside && pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 12) {
            count += 1;
            sum = [sum[0] + at[0], sum[1] + at[1]];
        }
    }
    (count, sum.map(|s| s / f64::from(count.max(1) as u32)))
}

/// The pixels of a picture of a short run at 3 s. `None` if no viewer can draw.
fn taken() -> Option<Vec<[u8; 3]>> {
    taken_of(|path| {
        let mut sink = RecordingSink::save(path).expect("a file");
        robhaz_run::run(&common::smooth(6.0), &mut [&mut sink]).expect("a run");
    })
}

/// The same of the recording that `record` writes, of at least 3 s.
fn taken_of(record: impl FnOnce(&Path)) -> Option<Vec<[u8; 3]>> {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, shot) = (
        folder.path().join("run.rrd"),
        folder.path().join("shot.png"),
    );
    record(&recording);
    let size = [WIDTH as u32, HEIGHT as u32];
    match picture(&recording, &shot, size, Some(3.0), &|| None) {
        Ok(()) => Some(pixels(&shot)),
        Err(
            error @ (ViewerError::NotInstalled
            | ViewerError::OtherVersion { .. }
            | ViewerError::Start { .. }),
        ) => {
            eprintln!("SKIPPED, no viewer can draw here: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Passes a run on as recorded readings without truth and contact angles.
struct OfLog(RecordingSink);

impl Sink for OfLog {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        self.0.begin(&RunDescription {
            has_truth: false,
            world: None,
            both: None,
            ..run.clone()
        })
    }
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let sensors = SensorFrame {
            contact_angle: [None; 3],
            ..*frame.sensors
        };
        self.0.frame(&Frame {
            clearances: None,
            truth: None,
            sensors: &sensors,
            ..*frame
        })
    }
    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.0.end(end)
    }
}

/// A recording of recorded readings has no robot, and one of `paper-body` alone no colour of a
/// wheel in view. Its picture shows the line of this estimator in the plots of N on the right.
#[test]
fn a_picture_of_a_log_shows_its_estimates() {
    let pixels = taken_of(|path| {
        let mut sink = OfLog(RecordingSink::save(path).expect("a file"));
        let mut scene = common::smooth(4.0);
        scene.estimators.truncate(1);
        robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    });
    let Some(pixels) = pixels else {
        return;
    };
    let (count, _) = found(&pixels, PAPER_BODY, [0.5, 1.0], [0.16, 0.76]);
    assert!(count > 300, "the estimator covers {count} pixels");
}

/// The picture has the robot on the left, with the wheels from rear to front. On the right it has
/// the plots of the wheels, from front to rear, with the estimators' lines.
#[test]
fn the_viewer_shows_the_data_in_its_places() {
    let Some(pixels) = taken() else {
        return;
    };
    // The view that moves with the body is in the left half, from 27 % to 75 % of the height.
    let [front, middle, rear] = WHEELS.map(|c| found(&pixels, c, [0.0, 0.5], [0.27, 0.75]));
    for (name, (count, _)) in [("front", front), ("middle", middle), ("rear", rear)] {
        assert!(count > 300, "the {name} wheel covers {count} pixels");
    }
    let [x_rear, x_middle, x_front] = [rear.1[0], middle.1[0], front.1[0]];
    assert!(
        x_rear + 0.05 < x_middle && x_middle + 0.05 < x_front,
        "{x_rear} {x_middle} {x_front}"
    );

    // The three plots of N are in the right half, below the key.
    let [front, middle, rear] = WHEELS.map(|c| found(&pixels, c, [0.5, 1.0], [0.16, 0.76]));
    for (name, (count, _)) in [("front", front), ("middle", middle), ("rear", rear)] {
        assert!(
            count > 300,
            "the line of the {name} wheel covers {count} pixels"
        );
    }
    let [y_front, y_middle, y_rear] = [front.1[1], middle.1[1], rear.1[1]];
    assert!(
        y_front + 0.1 < y_middle && y_middle + 0.1 < y_rear,
        "{y_front} {y_middle} {y_rear}"
    );
    let (estimated, _) = found(&pixels, PAPER_BODY, [0.5, 1.0], [0.16, 0.76]);
    assert!(
        estimated > 100,
        "the estimated lines cover {estimated} pixels"
    );
}

/// A picture of an empty recording is an error, and leaves no file.
#[test]
fn a_picture_of_nothing_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("run.rrd");
    drop(RecordingSink::save(&recording).expect("a file"));
    let shot = folder.path().join("shot.png");
    picture(&recording, &shot, [1400, 900], None, &|| None).expect_err("there is no data");
    assert!(!shot.exists());
}
