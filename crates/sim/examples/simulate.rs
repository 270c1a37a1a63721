//! Simulates a course for some seconds and prints the mean of N, for counting the instructions of
//! an engine:
//!
//! `valgrind --tool=callgrind target/release/examples/simulate smooth direct 10 1e-3`
//!
//! Arguments: course (`smooth`, `stairs`, `cosbump`, `flat`), engine (`direct`, `rapier`), duration
//! (s), time between two records (s).

use robhaz_model::Robot;
use robhaz_sim::{EngineChoice, EngineKind, Plant, PlantSetup};
use robhaz_terrain::{Profile, Terrain};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [course, engine, duration, period] = &arguments[..] else {
        return Err("four arguments: course, engine, duration in s, period in s".into());
    };
    let profile = match course.as_str() {
        "smooth" => Profile::smooth(),
        "stairs" => Profile::Stairs(Default::default()),
        "cosbump" => Profile::CosBump(Default::default()),
        "flat" => Profile::Flat,
        other => {
            return Err(format!("course {other} is not smooth, stairs, cosbump or flat").into());
        }
    };
    let mut kinds = EngineKind::ALL.into_iter();
    let engine = kinds.find(|kind| kind.name() == engine);
    let setup = PlantSetup {
        robot: Robot::default_a(),
        terrain: Terrain::new(profile),
        contact: Default::default(),
        friction: Default::default(),
        stretches: Vec::new(),
        drive: Default::default(),
        engine: EngineChoice {
            kind: engine.ok_or("the engine is not direct or rapier")?,
            ..Default::default()
        },
        period: period.parse()?,
        balance: false,
    };
    let mut plant = Plant::new(&setup)?;
    let records = (duration.parse::<f64>()? / setup.period).round() as u64;
    let mut sum = 0.0;
    for _ in 0..records {
        let wheels = plant.next_truth()?.wheels;
        sum += wheels.map(|wheel| wheel.normal_force).iter().sum::<f64>();
    }
    println!(
        "{records} records, mean N {:.6} N, mean step {:.3} ms",
        sum / 3.0 / records as f64,
        1e3 * plant.mean_step()
    );
    Ok(())
}
