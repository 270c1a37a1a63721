//! Runs the paper's scene (course `smooth`, ideal sensors, three estimators) and records it.
//!
//! ```text
//! cargo run --release -p robhaz-record --example record_run -- runs/example 20
//! ```
//!
//! Leaves tables, figures and summary in the folder, prints the comparison and how long each sink took.

use robhaz_record::{FigureSink, SummarySink, TableFormat, TableSink, comparison_table};
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(
        arguments
            .next()
            .unwrap_or_else(|| "runs/example".to_owned()),
    );
    let duration: f64 = arguments.next().map_or(Ok(20.0), |s| s.parse())?;
    let mut scene = Scene {
        name: "smooth".to_owned(),
        ..Scene::default()
    };
    scene.record.duration = duration;

    let mut parquet = Timed::new(TableSink::new(&folder, TableFormat::Parquet));
    let mut csv = Timed::new(TableSink::new(&folder.join("csv"), TableFormat::Csv));
    let mut figures = Timed::new(FigureSink::new(&folder.join("figures")));
    let mut summary = Timed::new(SummarySink::new());
    robhaz_run::run(
        &scene,
        &mut [&mut parquet, &mut csv, &mut figures, &mut summary],
    )?;

    let result = summary.sink.summary()?;
    result.write(&folder)?;
    println!("{}", comparison_table(&[(&scene.name, &result)]));
    for (name, spent) in [
        ("Parquet", parquet.spent),
        ("CSV", csv.spent),
        ("figures", figures.spent),
        ("summary", summary.spent),
    ] {
        println!("{name}: {:.3} s", spent.as_secs_f64());
    }
    Ok(())
}

/// A sink that keeps the time spent in it.
struct Timed<S> {
    sink: S,
    spent: Duration,
}

impl<S: Sink> Timed<S> {
    fn new(sink: S) -> Self {
        Self {
            sink,
            spent: Duration::ZERO,
        }
    }

    fn time(
        &mut self,
        work: impl FnOnce(&mut S) -> Result<(), SinkError>,
    ) -> Result<(), SinkError> {
        let start = Instant::now();
        let result = work(&mut self.sink);
        self.spent += start.elapsed();
        result
    }
}

impl<S: Sink> Sink for Timed<S> {
    fn clearance_need(&self) -> ClearanceNeed {
        self.sink.clearance_need()
    }

    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        self.time(|sink| sink.begin(run))
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.time(|sink| sink.frame(frame))
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.time(|sink| sink.end(end))
    }
}
