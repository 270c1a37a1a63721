//! Runs the paper's scene (course `smooth`, ideal sensors, three estimators) and records it.
//!
//! ```text
//! cargo run --release -p robhaz-record --example record_run -- runs/example 20
//! ```
//!
//! Leaves tables, figures and summary in the folder, prints the comparison and how long each sink took.

use robhaz_estimator::EstimatorSettings;
use robhaz_model::Robot;
use robhaz_record::{FigureSink, SummarySink, TableFormat, TableSink, comparison_table};
use robhaz_run::{Frame, RunEnd, Sink, SinkError};
use robhaz_scene::{
    EngineChoice, EstimatorChoice, Grade, RecordChoice, RobotChoice, Scene, SensorChoice,
    TerrainChoice,
};
use robhaz_sim::contact::ContactLaw;
use robhaz_sim::drive::Drive;
use robhaz_sim::friction::FrictionLaw;
use robhaz_terrain::Profile;
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
    let scene = scene(duration);

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

fn scene(duration: f64) -> Scene {
    let estimator = |name: &str, settings| EstimatorChoice {
        name: name.to_owned(),
        settings,
    };
    Scene {
        name: "smooth".to_owned(),
        seed: 1,
        robot: RobotChoice {
            geometry_name: "A".to_owned(),
            mass_name: "caption".to_owned(),
            robot: Robot::default_a(),
        },
        terrain: TerrainChoice {
            kind: "smooth",
            profile: Profile::smooth(),
            stretches: Vec::new(),
        },
        contact: ContactLaw::default(),
        friction: FrictionLaw::default(),
        drive: Drive::default(),
        sensors: SensorChoice {
            grade: Grade::Ideal,
            rate: 1000.0,
        },
        estimators: vec![
            estimator("paper-body", EstimatorSettings::paper_body()),
            estimator("paper-wheels", EstimatorSettings::paper_wheels()),
            estimator("true-mass", EstimatorSettings::true_mass()),
        ],
        engine: EngineChoice::default(),
        record: RecordChoice {
            duration,
            rate: 1000.0,
            compare_from: 2.0,
        },
    }
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
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.time(|sink| sink.begin(scene))
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.time(|sink| sink.frame(frame))
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.time(|sink| sink.end(end))
    }
}
