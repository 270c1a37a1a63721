//! Timings. Machines are noisy: believe the ratios within one run.
//!
//! `cargo bench -p robhaz --bench robhaz`

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SavedState, SensorFrame};
use robhaz_model::Robot;
use robhaz_sim::sensors::{Grade, Sensors};
use robhaz_sim::{EngineKind, Plant, PlantSetup, Truth};
use robhaz_terrain::{Profile, Terrain, Vec2};
use std::hint::black_box;
use std::time::Instant;

fn setup(engine: EngineKind, profile: Profile) -> PlantSetup {
    PlantSetup {
        robot: Robot::default_a(),
        terrain: Terrain::new(profile),
        contact: Default::default(),
        friction: Default::default(),
        stretches: Vec::new(),
        drive: Default::default(),
        start: Default::default(),
        engine,
        step: 1.25e-4,
        tolerance: 1e-5,
        period: 1e-3,
    }
}

/// Simulated seconds a second with the error of N beside it: whole scenes, 1 kHz truth included, on one core. Errors are against
/// `direct` at a tolerance of 1e-8, 99th percentile over wheels and records, of the mean N.
fn speed_and_accuracy(_: &mut Criterion) {
    // Criterion's test mode only asks whether it runs.
    let duration = if std::env::args().any(|a| a == "--test") {
        1.0
    } else {
        20.0
    };
    for (name, profile) in [("smooth", Profile::smooth()), ("stairs", Profile::stairs())] {
        let exact = PlantSetup {
            tolerance: 1e-8,
            ..setup(EngineKind::Direct, profile.clone())
        };
        let (exact, _) = timed(&exact, duration);
        for engine in EngineKind::ALL {
            let setup = setup(engine, profile.clone());
            // The best of three: other work on the machine only ever adds.
            let runs = [(); 3].map(|()| timed(&setup, duration));
            let seconds = runs.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
            println!(
                "{name}, {}: {:.0} simulated seconds a second, N errs by {:.4} % (99th percentile)",
                engine.name(),
                duration / seconds,
                100.0 * error_of_n(&runs[0].0, &exact)
            );
        }
    }
}

/// A run, and the time that it took, s.
fn timed(setup: &PlantSetup, duration: f64) -> (Vec<Truth>, f64) {
    let start = Instant::now();
    let mut plant = Plant::new(setup);
    let records = (duration / setup.period).round() as usize;
    let truth = (0..=records)
        .map_while(|_| plant.next_truth().ok())
        .collect();
    (truth, start.elapsed().as_secs_f64())
}

/// 99th percentile of the error of N over wheels and records, of the mean N.
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

/// One simulated second of `smooth` from the third on, 1 kHz truth included; the real-time factor is 1 s over this.
fn plant(c: &mut Criterion) {
    let mut group = c.benchmark_group("plant: 1 s on smooth, 1 kHz truth");
    group.sample_size(10);
    for engine in EngineKind::ALL {
        group.bench_function(engine.name(), |b| {
            b.iter_batched_ref(
                || {
                    let mut plant = Plant::new(&setup(engine, Profile::smooth()));
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

/// One sample of all sensors: nothing but copies, and every error that there is.
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

/// Readings of `smooth` with sensors of the grade `typical`, from 1 s on, when the robot moves: every frame another posture.
fn frames(count: usize) -> Vec<SensorFrame> {
    let mut plant = Plant::new(&setup(EngineKind::Direct, Profile::smooth()));
    let mut sensors = Sensors::new(&Grade::Typical.sensors(), 0);
    let truth = std::iter::from_fn(|| plant.next_truth().ok());
    let frames: Vec<_> = truth
        .map(|truth| {
            let readings = sensors.read(&truth);
            let link = |i: usize| LinkReading {
                inclination: readings.inclination[i],
                rate: readings.rate[i],
            };
            SensorFrame {
                time: readings.time,
                wheel_angle: readings.wheel_angle,
                motor_torque: readings.motor_torque,
                link1: link(0),
                link2: link(1),
                contact_angle: readings.contact_angle,
            }
        })
        .skip(1000)
        .take(count)
        .collect();
    assert_eq!(frames.len(), count);
    frames
}

/// One update of the paper's estimator and of `best`: the mean over 4000 frames in their order. Goals: 0.5 us and 3 us.
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
        "estimator: {} bytes in all, {} of a saved state",
        size_of::<Estimator>(),
        SavedState::BYTES
    );
}

criterion_group!(
    benches,
    speed_and_accuracy,
    plant,
    terrain,
    sensors,
    estimate
);
criterion_main!(benches);
