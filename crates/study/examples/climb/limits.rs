//! Least friction and highest riser of a geometry.

use crate::Outcome;
use crate::design::{load_spread, reach, robot};
use crate::trial::{Control, Trial};
use robhaz_model::Geometry;
use robhaz_scene::Scene;

/// Tread of `stairs`, m.
pub const TREAD: f64 = 0.30;
/// Riser of `stairs`, m.
pub const RISER: f64 = 0.08;
/// Default friction coefficient, -.
pub const MU: f64 = 0.8;
/// Largest friction coefficient that is tried, and the width of the search, -.
const LARGEST_MU: f64 = 1.2;
const MU_WIDTH: f64 = 0.02;
/// Width of the search for the riser, m.
const RISE_WIDTH: f64 = 0.005;

/// A geometry by its built-in name or its file.
pub fn load(name: &str) -> Outcome<Geometry> {
    let file = std::env::current_dir()?.join(name);
    let name = if name.ends_with(".toml") {
        file.display().to_string()
    } else {
        name.to_owned()
    };
    let key = format!("robot.geometry={name:?}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/stairs.toml");
    let scene = Scene::load(std::path::Path::new(path), &[key])?;
    Ok(scene.robot.robot.geometry)
}

/// Least mu at which the robot climbs every step down from the largest one in steps of the width: a robot that climbs at a lower
/// one by chance is not counted. `None` if it does not climb at the largest.
pub fn least_mu(geometry: &Geometry, control: Control, rise: f64, run: f64) -> Option<f64> {
    let trial = |mu| Trial {
        control,
        mu,
        rise,
        run,
    };
    let steps = (LARGEST_MU / MU_WIDTH).round() as u32 - 1;
    let mus = (0..steps).map(|k| LARGEST_MU - MU_WIDTH * f64::from(k));
    mus.take_while(|mu| trial(*mu).passes(geometry)).last()
}

/// Highest riser that is climbed with all lower ones, m, in steps of the width; 0 if none is.
pub fn highest_riser(geometry: &Geometry, control: Control, mu: f64, run: f64) -> f64 {
    let trial = |rise| Trial {
        control,
        mu,
        rise,
        run,
    };
    let rises = (1..=40).map(|k| RISE_WIDTH * f64::from(k));
    let climbed = rises.take_while(|rise| trial(*rise).passes(geometry));
    climbed.last().unwrap_or(0.0)
}

/// Prints what geometries reach.
pub fn table(names: &[&str]) -> Outcome<()> {
    for name in names {
        let geometry = load(name)?;
        let robot = robot(geometry.clone());
        let loads = robot
            .static_loads()
            .ok_or("the static loads are not determined")?;
        println!(
            "{name}: static loads {loads:.2?} N, spread {:.3}, reach {:.3} m",
            load_spread(&robot).unwrap_or(f64::NAN),
            reach(&geometry)
        );
        println!(
            "| control | least mu at 80 mm | highest riser at mu 0.8, mm | least margin to the stops, deg | least clearance, mm |"
        );
        println!("|---|---|---|---|---|");
        for control in Control::ALL {
            let drove = Trial {
                control,
                mu: MU,
                rise: RISER,
                run: TREAD,
            }
            .drive(&geometry)?;
            let least = least_mu(&geometry, control, RISER, TREAD);
            println!(
                "| {} | {} | {:.0} | {:.1} | {:.0} ({:?}) |",
                control.name(),
                least.map_or("-".to_owned(), |mu| format!("{mu:.2}")),
                1e3 * highest_riser(&geometry, control, MU, TREAD),
                drove.stop_margin.to_degrees(),
                1e3 * drove.clearance,
                drove.end
            );
        }
    }
    Ok(())
}
