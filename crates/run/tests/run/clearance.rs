//! Equivalence: what is skipped because it cannot matter changes nothing. On every shipped scene
//! the clearances of a run are those of a full search of the ground at every record.

use robhaz_run::{DrivenPlant, TruthClearance};
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::Truth;
use robhaz_sim::clearance::{BarPlace, ClearanceMeter, Clearances};
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Rounding of distances on grounds of some ten metres, m.
const ROUNDING: f64 = 1e-12;
/// Records between two full searches: they take longer than all the rest.
const EVERY: usize = 5;

/// Half the width of links that touch some of the shipped grounds, m: on none does the robot as it
/// is.
const THICK: f64 = 0.06;

fn places(truth: &Truth) -> [BarPlace; 4] {
    let [link1, link2, link3] = truth.links;
    [truth.body, link1, link2, link3].map(|bar| BarPlace {
        centre: bar.position,
        angle: bar.angle,
    })
}

/// All shipped scenes with the robot as it is and with thick links, by `direct`, whose speed lets
/// them go to their end.
fn scenes() -> Outcome<Vec<Scene>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            paths.push(path);
        }
    }
    paths.sort();
    let mut scenes = Vec::new();
    for path in paths {
        let mut scene = Scene::load(&path, &[])?;
        scene.engine.kind = EngineKind::Direct;
        scenes.push(scene.clone());
        scene.robot.robot.geometry.outline.half_width = THICK;
        scenes.push(scene);
    }
    Ok(scenes)
}

/// The truth of a scene up to its end, or to that of the simulation.
fn truths(scene: &Scene) -> Outcome<Vec<Truth>> {
    let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
    let mut truths = Vec::new();
    while let Ok(truth) = plant.next_truth() {
        if truth.time > scene.record.duration {
            break;
        }
        truths.push(truth);
    }
    Ok(truths)
}

#[test]
fn clearances_are_those_of_a_full_search() -> Outcome<()> {
    let mut touches = 0;
    for scene in scenes()? {
        let terrain = scene.terrain.build(&scene.robot.robot);
        let mut full = ClearanceMeter::new(&scene.robot.robot.geometry, terrain);
        let mut meter = TruthClearance::of(&scene);
        for (k, truth) in truths(&scene)?.iter().enumerate() {
            let found = meter.at(truth);
            assert!(found.least.1.is_finite());
            if k % EVERY == 0 {
                let each = full.measure_each(&places(truth));
                let expected = Clearances::of(each);
                let of_bar = each[found.least.0 as usize];
                assert!(
                    (found.least.1 - expected.least.1).abs() < ROUNDING,
                    "{found:?} {each:?}"
                );
                assert!(
                    (of_bar - expected.least.1).abs() < ROUNDING,
                    "{found:?} {each:?}"
                );
                assert_eq!(found.touching, expected.touching, "{each:?}");
            }
            touches += usize::from(found.touches());
        }
    }
    // The robot as it is clears all grounds: the thick one makes the other case.
    assert!(touches > 100, "{touches}");
    Ok(())
}
