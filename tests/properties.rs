//! Properties of the forces over random robots, grounds and speeds: every record obeys the laws, or
//! the run stops with a reason. A wrong force without an error must not occur.

use crate::draws::{grounds, robots};
use crate::support::scene;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use robhaz_model::{Bar, Geometry, MassSet, Pin, Vec2, rotate};
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::{Plant, Truth, WheelTruth};
use robhaz_terrain::{Profile, Terrain};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Speeds forward and backward, m/s, never at rest.
fn speeds() -> impl Strategy<Value = f64> {
    (0.05..0.5_f64, any::<bool>()).prop_map(|(v, back)| if back { -v } else { v })
}

/// Checks the properties of one record. The error names the one that is violated.
fn check_record(scene: &Scene, terrain: &Terrain, truth: &Truth) -> Result<(), String> {
    let geometry = &scene.robot.robot.geometry;
    for (i, w) in truth.wheels.iter().enumerate() {
        let wheel = i + 1;
        // Independent of the plant: at its nearest point, the ground must be below the wheel's
        // centre.
        if terrain
            .nearest(w.position)
            .is_none_or(|c| c.distance <= 0.0)
        {
            return Err(format!("wheel {wheel} is below the ground"));
        }
        if w.normal_force < 0.0 || (w.contacts == 0 && w.normal_force > 0.0) {
            return Err(format!("N of wheel {wheel} is {}", w.normal_force));
        }
        // With two contacts, N is the vector sum but T the scalar sum: the bound holds for one
        // contact only.
        let most = scene.friction.mu_s * w.normal_force * (1.0 + 1e-12);
        if w.contacts == 1 && w.traction.abs() > most {
            return Err(format!(
                "T of wheel {wheel} is {}, N {}",
                w.traction, w.normal_force
            ));
        }
    }
    // Both bars of a pin give it the same position, and each axle has the position that its link
    // gives it.
    let image = |bar: Bar, nominal: Vec2| {
        let b = truth.bar(bar);
        b.position + rotate(nominal - geometry.cg(bar), b.angle)
    };
    let pins = Pin::ALL.map(|pin| {
        let ((a, b), at) = (pin.bars(), geometry.pins.get(pin));
        (image(a, at) - image(b, at)).norm()
    });
    let axles = [0, 1, 2].map(|i| {
        let link = geometry.carriers[i].bar();
        (image(link, geometry.axles[i]) - truth.wheels[i].position).norm()
    });
    let open = pins.into_iter().chain(axles).fold(0.0, f64::max);
    let allowed = match scene.engine.kind {
        EngineKind::Direct => 1e-9,
        EngineKind::Rapier => Plant::MAX_LOOP_ERROR,
    };
    if open > allowed {
        return Err(format!("a pin or axle is open by {open} m"));
    }
    Ok(())
}

/// Counts over random runs.
#[derive(Debug, Default)]
struct Outcome {
    /// Runs that reached their end.
    ended: u32,
    /// Runs that stopped, by reason.
    stopped: BTreeMap<String, u32>,
    /// Records with a wheel in the air.
    in_the_air: u32,
    /// Records with a wheel that has two contacts.
    two_contacts: u32,
    /// Records with a wheel that slides faster than v_d.
    sliding: u32,
}

impl Outcome {
    fn count(&mut self, scene: &Scene, truth: &Truth) {
        let any = |what: fn(&WheelTruth, f64) -> bool| {
            u32::from(truth.wheels.iter().any(|w| what(w, scene.friction.v_d)))
        };
        self.in_the_air += any(|w, _| w.contacts == 0);
        self.two_contacts += any(|w, _| w.contacts > 1);
        self.sliding += any(|w, v_d| w.contacts > 0 && w.slip_speed.abs() > v_d);
    }
}

/// Makes `cases` random runs of some seconds and checks every record.
fn runs(cases: u32, seconds: f64, engine: EngineKind) -> Outcome {
    let config = ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20),
        failure_persistence: None,
        // Shrinking a failed run would take minutes.
        max_shrink_iters: 0,
        ..ProptestConfig::default()
    };
    let outcome = RefCell::new(Outcome::default());
    let one = |((geometry, mass), profile, speed): ((Geometry, MassSet), Profile, f64)| {
        let mut scene = scene("smooth", &[]);
        scene.robot.robot.geometry = geometry;
        scene.robot.robot.mass = mass;
        scene.drive.speed = speed;
        scene.drive.start_time = 0.2;
        scene.drive.ramp_time = 0.3;
        scene.engine.kind = engine;
        let robot = &scene.robot.robot;
        prop_assume!(robot.geometry.check().is_ok() && robot.mass.check().is_ok());
        // Wide bumps can overlap the waves behind the robot.
        prop_assume!(profile.check().is_ok());
        scene.terrain.profile = profile;
        let setup = scene.plant_setup();
        let mut plant = Plant::new(&setup);
        let records = (seconds / setup.period) as u32;
        for record in 0..records {
            let next = plant.as_mut().map_err(|why| *why);
            match next.and_then(Plant::next_truth) {
                Ok(truth) => {
                    let checked = check_record(&scene, &setup.terrain, truth);
                    // Of every tenth record only: to write one takes as long as to simulate it.
                    if record % 10 == 0 {
                        let written = format!("{truth:?}");
                        prop_assert!(!written.contains("NaN") && !written.contains("inf"));
                    }
                    let context = || format!("t = {}: {:?}", truth.time, scene.terrain.profile);
                    outcome.borrow_mut().count(&scene, truth);
                    prop_assert!(checked.is_ok(), "{:?}, {}", checked, context());
                }
                Err(why) => {
                    let kind = format!("{why:?}");
                    let kind = kind.split([' ', '{']).next().unwrap_or_default().to_owned();
                    *outcome.borrow_mut().stopped.entry(kind).or_insert(0) += 1;
                    return Ok(());
                }
            }
        }
        outcome.borrow_mut().ended += 1;
        Ok(())
    };
    let result = TestRunner::new(config).run(&(robots(0.5..2.0), grounds(1.0), speeds()), one);
    assert!(result.is_ok(), "{}", result.unwrap_err());
    outcome.into_inner()
}

/// Property: of 40 random runs of the direct engine each obeys the laws to its end, or stops with a
/// reason, which few do. None stops for lack of a step.
#[test]
fn random_runs_by_direct() {
    let found = runs(40, 5.0, EngineKind::Direct);
    println!("direct, 40 runs of 5 s: {found:?}");
    assert!(found.ended >= 36, "{found:?}");
    assert!(!found.stopped.contains_key("NoStep"), "{found:?}");
    assert!(found.in_the_air > 20 && found.two_contacts > 100 && found.sliding > 100);
}

/// The same with rapier, which takes longer.
#[test]
fn random_runs_by_rapier() {
    let found = runs(8, 2.0, EngineKind::Rapier);
    println!("rapier, 8 runs of 2 s: {found:?}");
    assert!(found.ended >= 7, "{found:?}");
    // In 2 s few wheels leave the ground.
    assert!(found.two_contacts > 0 && found.sliding > 0);
}
