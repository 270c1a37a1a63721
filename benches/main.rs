//! Benchmarks. Timings on a loaded machine vary: compare ratios within one run.
//!
//! `cargo bench -p robhaz --bench robhaz`

#![allow(clippy::expect_used, reason = "a bench may stop at an error")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use robhaz_estimator::{Estimator, EstimatorSettings, SavedState, SensorFrame};
use robhaz_model::Robot;
use robhaz_scene::Scene;
use robhaz_sim::sensors::{Grade, Sensors};
use robhaz_sim::{EngineKind, Plant, PlantSetup, Truth};
use robhaz_terrain::{Heights, Interpolation, Profile, Terrain, Vec2};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// The default robot, drive and laws on a terrain.
fn setup(engine: EngineKind, terrain: &Terrain) -> PlantSetup {
    PlantSetup {
        terrain: terrain.clone(),
        engine,
        ..Scene::default().plant_setup()
    }
}

/// A plant after two simulated seconds, when the robot moves.
fn rolling(setup: &PlantSetup) -> Plant {
    let mut plant = Plant::new(setup).expect("the robot stands");
    one_second(&mut plant);
    one_second(&mut plant);
    plant
}

/// Runs one simulated second at 1 kHz.
fn one_second(plant: &mut Plant) {
    for _ in 0..1000 {
        assert!(black_box(plant.next_truth()).is_ok());
    }
}

/// Speed and error of both engines: simulated seconds per second for complete scenes on one core, with truth at 1 kHz,
/// and the error of N relative to `direct` at a tolerance of 1e-8, as the 99th percentile over wheels and records
/// divided by the mean of N.
fn speed_and_accuracy(_: &mut Criterion) {
    // In criterion's test mode a short run suffices.
    let duration = if std::env::args().any(|a| a == "--test") {
        1.0
    } else {
        20.0
    };
    for (name, profile) in [("smooth", Profile::smooth()), ("stairs", Profile::stairs())] {
        let terrain = Terrain::new(profile);
        let exact = PlantSetup {
            tolerance: 1e-8,
            ..setup(EngineKind::Direct, &terrain)
        };
        let (exact, _) = timed(&exact, duration);
        for engine in EngineKind::ALL {
            let setup = setup(engine, &terrain);
            // The shortest of three times: other work on the machine can only add to them.
            let runs = [(); 3].map(|()| timed(&setup, duration));
            let best = |runs: &[(Vec<Truth>, f64); 3]| {
                runs.iter().map(|r| r.1).fold(f64::INFINITY, f64::min)
            };
            let seconds = best(&runs);
            let balanced = PlantSetup {
                balance: true,
                ..setup
            };
            let balanced = best(&[(); 3].map(|()| timed(&balanced, duration)));
            println!(
                "{name}, {}: {:.0} simulated seconds per second, error of N {:.4} % (99th percentile); {:.3} of the time with impulse and work",
                engine.name(),
                duration / seconds,
                100.0 * error_of_n(&runs[0].0, &exact),
                balanced / seconds,
            );
        }
    }
}

/// A run, and its duration in real time, s.
fn timed(setup: &PlantSetup, duration: f64) -> (Vec<Truth>, f64) {
    let start = Instant::now();
    let mut plant = Plant::new(setup).expect("the robot stands");
    let records = (duration / setup.period).round() as usize;
    let truth = (0..=records)
        .map_while(|_| plant.next_truth().ok())
        .collect();
    (truth, start.elapsed().as_secs_f64())
}

/// 99th percentile of the error of N over wheels and records, divided by the mean of N.
fn error_of_n(truth: &[Truth], exact: &[Truth]) -> f64 {
    assert_eq!(truth.len(), exact.len());
    let forces = |t: &Truth| t.wheels.map(|w| w.normal_force);
    let pairs = truth
        .iter()
        .flat_map(forces)
        .zip(exact.iter().flat_map(forces));
    let mut errors: Vec<f64> = pairs.map(|(n, exact)| (n - exact).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let mean = exact.iter().flat_map(forces).sum::<f64>() / errors.len() as f64;
    errors[errors.len() * 99 / 100] / mean
}

/// The third simulated second of `smooth`, with truth at 1 kHz. The real-time factor is 1 s divided by the time.
fn plant(c: &mut Criterion) {
    let terrain = Terrain::new(Profile::smooth());
    let mut group = c.benchmark_group("plant: 1 s on smooth, 1 kHz truth");
    group.sample_size(10);
    for engine in EngineKind::ALL {
        group.bench_function(engine.name(), |b| {
            b.iter_batched_ref(
                || rolling(&setup(engine, &terrain)),
                one_second,
                BatchSize::PerIteration,
            );
        });
    }
}

/// Contacts of one wheel, at places with one contact and with two.
fn terrain(c: &mut Criterion) {
    let mut group = c.benchmark_group("terrain: contacts of one wheel");
    for (name, profile, x) in [
        ("flat", Profile::Flat, 1.1),
        ("smooth", Profile::smooth(), 1.1),
        ("rough", Profile::rough(0), 5.0),
        ("stairs: tread and riser", Profile::stairs(), 0.601),
    ] {
        let terrain = Terrain::new(profile);
        let [y, slope, _] = terrain.profile().eval(x);
        let up = Vec2::new(-slope, 1.0).normalize();
        let centre = Vec2::new(x, y) + up * 0.0995;
        let mut found = Vec::new();
        group.bench_function(name, |b| {
            b.iter(|| terrain.contacts(black_box(centre), 0.1, &mut found));
        });
    }
}

/// The same 4 m of ground through 100 knots and through 1 000 000: the time of a step must not depend on their number.
///
/// The two are measured alternately, and the shortest times are compared: other work on the machine can only add to
/// them.
fn knots(_: &mut Criterion) {
    // Follows criterion's filter and test mode, because criterion does not measure this.
    let given = |wanted: fn(&str) -> bool| std::env::args().skip(1).any(|a| wanted(&a));
    let testing = given(|a| a == "--test");
    if given(|a| !a.starts_with('-') && a != "knots") {
        return;
    }
    let spline = |points| Profile::Heights(Heights::new(points, Interpolation::Spline));
    let sampled = |of: &Profile, count: u32| -> Vec<Vec2> {
        let x = |i: u32| 0.5 + 4.0 * f64::from(i) / f64::from(count - 1);
        (0..count)
            .map(|i| Vec2::new(x(i), of.eval(x(i))[0]))
            .collect()
    };
    let few = spline(sampled(&Profile::smooth(), 100));
    let many = spline(sampled(&few, 1_000_000));
    let terrains = [Terrain::new(few), Terrain::new(many)];
    let turns = if testing { 1 } else { 15 };
    for engine in EngineKind::ALL {
        let mut least = [Duration::MAX; 2];
        for _ in 0..turns {
            for (terrain, least) in terrains.iter().zip(&mut least) {
                let mut plant = rolling(&setup(engine, terrain));
                let start = Instant::now();
                one_second(&mut plant);
                *least = start.elapsed().min(*least);
            }
        }
        println!(
            "knots: plant, 1 s on heights, {}: {:.2?} with 100, {:.2?} with 1 000 000; ratio {:.3}",
            engine.name(),
            least[0],
            least[1],
            least[1].as_secs_f64() / least[0].as_secs_f64()
        );
    }
}

/// One sample of all sensors: ideal ones, which copy the truth, and poor ones, which have every error.
fn sensors(c: &mut Criterion) {
    let mut group = c.benchmark_group("sensors: one sample of all");
    for grade in [Grade::Ideal, Grade::Poor] {
        let mut sensors = Sensors::new(&grade.sensors(), 0);
        let mut truth = Truth::default();
        group.bench_function(grade.name(), |b| {
            b.iter(|| {
                truth.time += 1e-3;
                black_box(sensors.read(black_box(&truth)))
            });
        });
    }
}

/// Sensor frames of `smooth` with the grade `typical` from 1 s, when the robot moves and its posture changes.
fn frames(count: usize) -> Vec<SensorFrame> {
    let setup = setup(EngineKind::Direct, &Terrain::new(Profile::smooth()));
    let mut plant = Plant::new(&setup).expect("the robot stands");
    let mut sensors = Sensors::new(&Grade::Typical.sensors(), 0);
    let truth = std::iter::from_fn(|| plant.next_truth().ok());
    let frames: Vec<_> = truth
        .map(|truth| robhaz_run::sensor_frame(&sensors.read(&truth)))
        .skip(1000)
        .take(count)
        .collect();
    assert_eq!(frames.len(), count);
    frames
}

/// Updates of the paper's estimator and of `best` with 4000 consecutive frames. Goals: 0.5 us and 3 us per update.
fn estimate(c: &mut Criterion) {
    let frames = frames(4000);
    let mut group = c.benchmark_group("estimator: 4000 updates");
    for (name, settings) in [
        ("paper-wheels", EstimatorSettings::paper_wheels()),
        ("best", EstimatorSettings::best()),
    ] {
        let new = Estimator::new(&Robot::default_a(), settings);
        group.throughput(Throughput::Elements(frames.len() as u64));
        group.bench_function(name, |b| {
            b.iter_batched_ref(
                || new.clone(),
                |estimator| {
                    for frame in &frames {
                        let _ = black_box(estimator.update(black_box(frame)));
                    }
                },
                BatchSize::SmallInput,
            );
        });
    }
    println!(
        "estimator: {} bytes in memory, {} bytes of saved state",
        size_of::<Estimator>(),
        SavedState::BYTES
    );
}

/// Cost of the viewer to the simulating thread in the third and fourth second of `smooth`: the simulation alone; with a
/// live viewer (here a server that keeps the data); with a recording. The times exclude layout and start.
#[cfg(feature = "viewer")]
fn viewing(c: &mut Criterion) {
    use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
    use robhaz_viewer::{LiveSink, RecordingSink};

    /// CPU time of this thread if the system provides it, otherwise elapsed time.
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
        fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
            self.inner.as_mut().map_or(Ok(()), |s| s.begin(run))
        }

        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            self.inner.as_mut().map_or(Ok(()), |s| s.frame(frame))?;
            // A recording is written every two seconds: here and at the end.
            if frame.time >= 2.0 {
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

/// Without the feature `viewer` there is no such benchmark.
#[cfg(not(feature = "viewer"))]
fn viewing(_: &mut Criterion) {}

criterion_group!(
    benches,
    speed_and_accuracy,
    plant,
    terrain,
    knots,
    sensors,
    estimate,
    viewing
);
criterion_main!(benches);
