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
        start: Default::default(),
        engine,
        step: 1.25e-4,
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

criterion_group!(benches, plant, terrain, estimate);
criterion_main!(benches);
