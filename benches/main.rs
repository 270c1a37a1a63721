//! Benchmarks. Timings on a loaded machine vary: compare ratios within one run.
//!
//! `cargo bench --workspace --bench robhaz`

#![allow(clippy::expect_used, reason = "a bench may stop at an error")]

mod speed;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use robhaz_estimator::{Estimator, EstimatorSettings, SensorFrame};
use robhaz_model::Robot;
use robhaz_scene::Scene;
use robhaz_sim::sensors::{Grade, Sensors};
use robhaz_sim::{EngineKind, Plant, PlantSetup, Truth};
use robhaz_terrain::{Heights, Interpolation, Profile, Terrain, Vec2};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// The default robot, drive and laws on a terrain.
fn setup(engine: EngineKind, terrain: &Terrain) -> PlantSetup {
    let mut setup = Scene::default().plant_setup();
    (setup.terrain, setup.engine.kind) = (terrain.clone(), engine);
    setup
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

/// Speed and error of both engines. In criterion's test mode a short run suffices.
fn speed_and_accuracy(_: &mut Criterion) {
    let testing = std::env::args().any(|a| a == "--test");
    speed::table(setup, if testing { 1.0 } else { 20.0 });
}

/// The third simulated second of `smooth`, with truth at 1 kHz. The real-time factor is 1 s divided
/// by the time.
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
        (
            "rough",
            Profile::Rough(robhaz_terrain::Rough::new(Default::default())),
            5.0,
        ),
        (
            "stairs: tread and riser",
            Profile::Stairs(Default::default()),
            0.601,
        ),
    ] {
        let [y, slope, _] = profile.eval(x);
        let terrain = Terrain::new(profile);
        let up = Vec2::new(-slope, 1.0).normalize();
        let centre = Vec2::new(x, y) + up * 0.0995;
        let mut found = Vec::new();
        group.bench_function(name, |b| {
            b.iter(|| terrain.contacts(black_box(centre), 0.1, &mut found));
        });
    }
}

/// The same 4 m of ground through 100 knots and through 1 000 000: the time of a step must not
/// depend on their number.
///
/// The two are measured alternately, and the shortest times are compared: other work on the machine
/// can only add to them.
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

/// One sample of all sensors: ideal ones, which copy the truth, and poor ones, which have every
/// error.
fn sensors(c: &mut Criterion) {
    let mut group = c.benchmark_group("sensors: one sample of all");
    for grade in [Grade::Ideal, Grade::Poor] {
        let mut sensors = Sensors::new(&grade.sensors(), 0, &Robot::default_a());
        let mut truth = Truth::default();
        group.bench_function(grade.name(), |b| {
            b.iter(|| {
                truth.time += 1e-3;
                black_box(sensors.read(black_box(&truth)))
            });
        });
    }
}

/// Sensor frames of `smooth` with the grade `typical` from 1 s, when the robot moves and its
/// posture changes.
fn frames(count: usize) -> Vec<SensorFrame> {
    let setup = setup(EngineKind::Direct, &Terrain::new(Profile::smooth()));
    let mut plant = Plant::new(&setup).expect("the robot stands");
    let mut sensors = Sensors::new(&Grade::Typical.sensors(), 0, &setup.robot);
    let truth = std::iter::from_fn(|| plant.next_truth().ok().copied());
    let frames: Vec<_> = truth
        .map(|truth| sensors.read(&truth))
        .skip(1000)
        .take(count)
        .collect();
    assert_eq!(frames.len(), count);
    frames
}

/// Updates of the paper's estimator and of `kalman` with 4000 consecutive frames. Goals: 0.5 us and 3
/// us per update.
fn estimate(c: &mut Criterion) {
    let frames = frames(4000);
    let mut group = c.benchmark_group("estimator: 4000 updates");
    for (name, settings) in [
        ("paper-wheels", EstimatorSettings::paper_wheels()),
        ("kalman", EstimatorSettings::kalman()),
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
    println!("estimator: {} bytes in memory", size_of::<Estimator>());
}

/// Cost of the viewer to the simulating thread in the third and fourth second of `smooth`: the
/// simulation alone; with a recording. The times exclude layout and start.
fn viewing(c: &mut Criterion) {
    use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
    use robhaz_viewer::RecordingSink;
    use speed::thread_time;

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
