//! Speed and error of the engines, one table.

use robhaz_sim::{EngineKind, Plant, PlantSetup, Truth};
use robhaz_terrain::{Profile, Terrain};
use std::hint::black_box;
use std::time::Duration;

/// CPU time of this thread if the system provides it, otherwise elapsed time.
#[cfg(unix)]
pub fn thread_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).expect("the time of a thread is positive")
}

/// CPU time of this thread if the system provides it, otherwise elapsed time.
#[cfg(not(unix))]
pub fn thread_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// Shortest of at least five times and half a second in all, s: other work on the machine can only
/// add to them.
fn shortest(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = Vec::new();
    while times.len() < 5 || times.iter().sum::<f64>() < 0.5 {
        let start = thread_time();
        work();
        times.push((thread_time() - start).as_secs_f64());
    }
    times.into_iter().fold(f64::INFINITY, f64::min)
}

/// Time of a fixed loop of floating-point work, s: four chains of 10 million multiplications and
/// additions each, with a division after every hundred. It shows how fast the machine is at the
/// moment.
fn loop_time() -> f64 {
    shortest(|| {
        let mut chains = black_box([0.1_f64, 0.2, 0.3, 0.4]);
        for _ in 0..100_000 {
            for _ in 0..100 {
                for x in &mut chains {
                    *x = *x * 0.999_999 + 1e-6;
                }
            }
            for x in &mut chains {
                *x = 1.0 / (1.0 + *x);
            }
        }
        black_box(chains);
    })
}

/// Prints the table: simulated seconds per second of CPU time for complete scenes on one core, with
/// truth at 1 kHz; the error of N relative to `direct` at a tolerance of 1e-8, as the 99th
/// percentile over wheels and records divided by the mean of N; simulated seconds in the time of
/// the loop; the share of time that impulse and work would add.
pub fn table(setup: impl Fn(EngineKind, &Terrain) -> PlantSetup, duration: f64) {
    let unit = loop_time();
    println!("speed: loop of floating-point work {:.1} ms", 1e3 * unit);
    println!(
        "speed: engine  scene   simulated s/s  error of N (99 %)  simulated s per loop  with impulse and work"
    );
    for (name, profile) in [
        ("smooth", Profile::smooth()),
        ("stairs", Profile::Stairs(Default::default())),
    ] {
        let terrain = Terrain::new(profile);
        let mut exact = setup(EngineKind::Direct, &terrain);
        exact.engine.tolerance = 1e-8;
        let exact = truth(&exact, duration);
        for engine in EngineKind::ALL {
            let setup = setup(engine, &terrain);
            let error = error_of_n(&truth(&setup, duration), &exact);
            let seconds = shortest(|| run(&setup, duration));
            let balanced = PlantSetup {
                balance: true,
                ..setup
            };
            let balanced = shortest(|| run(&balanced, duration));
            println!(
                "speed: {:7} {name:7} {:13.0}  {:15.4} %  {:20.1}  {:+20.1} %",
                engine.name(),
                duration / seconds,
                100.0 * error,
                duration / seconds * unit,
                100.0 * (balanced / seconds - 1.0),
            );
        }
    }
}

/// Number of records of a run.
fn records(setup: &PlantSetup, duration: f64) -> usize {
    (duration / setup.period).round() as usize + 1
}

/// A run whose records are dropped, so that no memory is waited for.
fn run(setup: &PlantSetup, duration: f64) {
    let mut plant = Plant::new(setup).expect("the robot stands");
    for _ in 0..records(setup, duration) {
        assert!(black_box(plant.next_truth()).is_ok());
    }
}

/// All records of a run.
fn truth(setup: &PlantSetup, duration: f64) -> Vec<Truth> {
    let mut plant = Plant::new(setup).expect("the robot stands");
    let records = 0..records(setup, duration);
    records
        .map_while(|_| plant.next_truth().ok().copied())
        .collect()
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
