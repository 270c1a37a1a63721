//! Timings. Machines are noisy: believe the ratios within one run.
//!
//! `cargo bench -p robhaz --bench robhaz`

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::Robot;
use robhaz_sim::{EngineKind, Plant, PlantSetup};
use robhaz_terrain::{Profile, Terrain, Vec2};
use std::hint::black_box;

fn setup(engine: EngineKind) -> PlantSetup {
    PlantSetup {
        robot: Robot::default_a(),
        terrain: Terrain::new(Profile::smooth()),
        contact: Default::default(),
        friction: Default::default(),
        stretches: Vec::new(),
        drive: Default::default(),
        engine,
        step: 1e-4,
        tolerance: 1e-4,
        period: 1e-3,
    }
}

/// One simulated second of `smooth` from the third on, 1 kHz truth included; the real-time factor is 1 s over this.
fn plant(c: &mut Criterion) {
    let mut group = c.benchmark_group("plant: 1 s on smooth, 1 kHz truth");
    group.sample_size(10);
    for engine in EngineKind::ALL {
        group.bench_function(engine.name(), |b| {
            b.iter_batched_ref(
                || {
                    let mut plant = Plant::new(&setup(engine));
                    for _ in 0..2000 {
                        assert!(plant.next_truth().is_ok());
                    }
                    plant
                },
                |plant| {
                    for _ in 0..1000 {
                        assert!(black_box(plant.next_truth()).is_ok());
                    }
                },
                BatchSize::PerIteration,
            );
        });
    }
}

/// Nearest contact of one wheel on the smooth profile.
fn terrain(c: &mut Criterion) {
    let terrain = Terrain::new(Profile::smooth());
    let [y, slope, _] = terrain.profile().eval(1.1);
    let up = Vec2::new(-slope, 1.0).normalize();
    let centre = Vec2::new(1.1, y) + up * 0.0995;
    let mut found = Vec::new();
    c.bench_function("terrain: contacts of one wheel on smooth", |b| {
        b.iter(|| terrain.contacts(black_box(centre), 0.1, &mut found));
    });
}

/// One update of the paper's estimator.
fn estimate(c: &mut Criterion) {
    let mut frame = SensorFrame {
        time: 0.0,
        wheel_angle: [0.0; 3],
        motor_torque: [0.5, -0.2, 0.3],
        link1: LinkReading {
            inclination: 0.1,
            rate: 0.0,
        },
        link2: LinkReading {
            inclination: -0.05,
            rate: 0.0,
        },
        contact_angle: [0.2, 0.0, -0.1],
    };
    let mut estimator = Estimator::new(&Robot::default_a(), EstimatorSettings::paper_wheels());
    c.bench_function("estimator: one update of paper-wheels", |b| {
        b.iter_batched(
            || {
                frame.time += 1e-3;
                frame
            },
            |frame| black_box(estimator.update(&frame)),
            BatchSize::SmallInput,
        );
    });
}

/// What the viewer costs the thread that simulates, in the third and fourth second of `smooth`: the simulation alone; handed to a
/// live viewer (here a server that keeps it); written to a file. Layout and start are not in it.
#[cfg(feature = "viewer")]
fn viewing(c: &mut Criterion) {
    use robhaz_run::{Frame, RunEnd, Sink, SinkError};
    use robhaz_scene::Scene;
    use robhaz_viewer::{LiveSink, RecordingSink};
    use std::time::{Duration, Instant};

    /// A clock of this thread's own work, where the system has one: other threads and programs do not count.
    fn thread_time() -> Duration {
        static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
        let known = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let nanoseconds = known.and_then(|text| text.split(' ').next()?.parse().ok());
        nanoseconds.map_or_else(|| START.elapsed(), Duration::from_nanos)
    }

    /// Times the third and fourth second of a run through another sink, if any.
    struct Timed<'a> {
        inner: Option<&'a mut dyn Sink>,
        start: Option<Duration>,
        taken: Duration,
    }

    impl Sink for Timed<'_> {
        fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
            self.inner.as_mut().map_or(Ok(()), |s| s.begin(scene))
        }

        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            self.inner.as_mut().map_or(Ok(()), |s| s.frame(frame))?;
            // A file is written every two seconds: here, and at the end.
            if frame.truth.time >= 2.0 {
                self.start.get_or_insert_with(thread_time);
            }
            Ok(())
        }

        fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
            if let Some(start) = self.start {
                self.taken = thread_time() - start;
            }
            self.inner.as_mut().map_or(Ok(()), |s| s.end(end))
        }
    }

    fn two_seconds(scene: &Scene, inner: Option<&mut dyn Sink>) -> Duration {
        let mut timed = Timed {
            inner,
            start: None,
            taken: Duration::ZERO,
        };
        let end = robhaz_run::run(scene, &mut [&mut timed]);
        assert!(end.is_ok(), "{end:?}");
        timed.taken
    }

    let folder = std::env::temp_dir().join(format!("robhaz-bench-{}", std::process::id()));
    assert!(std::fs::create_dir_all(&folder).is_ok());
    let path = folder.join("run.rrd");
    for engine in EngineKind::ALL {
        let mut scene = Scene::default();
        scene.record.duration = 4.0;
        scene.engine.kind = engine;
        let name = format!("viewing: 2 s on smooth, {}", engine.name());
        let mut group = c.benchmark_group(name);
        group.sample_size(10);
        group.bench_function("simulation alone", |b| {
            b.iter_custom(|n| (0..n).map(|_| two_seconds(&scene, None)).sum());
        });
        group.bench_function("live", |b| {
            let mut port = 40_000;
            b.iter_custom(|n| {
                let live = |_| loop {
                    port += 1;
                    if let Ok(mut sink) = LiveSink::serve(port) {
                        break two_seconds(&scene, Some(&mut sink));
                    }
                };
                (0..n).map(live).sum()
            });
        });
        group.bench_function("saved", |b| {
            b.iter_custom(|n| {
                let saved = |_| match RecordingSink::save(&path) {
                    Ok(mut sink) => two_seconds(&scene, Some(&mut sink)),
                    Err(error) => panic!("{error}"),
                };
                (0..n).map(saved).sum()
            });
        });
    }
    let _ = std::fs::remove_dir_all(&folder);
}

/// Without the viewer there is nothing to be measured.
#[cfg(not(feature = "viewer"))]
fn viewing(_: &mut Criterion) {}

criterion_group!(benches, plant, terrain, estimate, viewing);
criterion_main!(benches);
