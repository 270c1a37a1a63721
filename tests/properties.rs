//! Properties of the forces over random robots, grounds and speeds: a run goes on with forces that obey their laws, or it stops
//! and says why. What must not happen is a wrong force without a word.

use crate::support::scene;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use robhaz_model::{Bar, Geometry, MassSet, Pin, Vec2, rotate};
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::stability::longest_step_for_contact;
use robhaz_sim::{Plant, Truth, WheelTruth};
use robhaz_terrain::{
    Bump, CosBump, Course, Ditch, Heights, Interpolation, Profile, Ramp, Rough, RoughClass,
    RoughSettings, Sine, Stairs, Terrain,
};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Level ground on either side of the start, m.
const LEVEL: f64 = 0.55;

/// Robots A and B with every point moved by up to 20 mm, wheels of another size, and masses from half to twice.
fn robots() -> impl Strategy<Value = (Geometry, MassSet)> {
    let moved = proptest::collection::vec(-0.02..0.02_f64, 19);
    let scaled = proptest::collection::vec(0.5..2.0_f64, 10);
    let robot = (any::<bool>(), 0.07..0.13_f64, moved, scaled);
    robot.prop_map(|(a, radius, moved, scaled)| {
        let mut g = if a { Geometry::a() } else { Geometry::b() };
        g.wheel_radius = radius;
        let mut moved = moved.into_iter();
        let mut next = || moved.next().unwrap_or_default();
        for axle in &mut g.axles {
            // All wheels stand on the level ground.
            *axle = Vec2::new(axle.x + next(), radius);
        }
        let pins = [&mut g.pins.p, &mut g.pins.q, &mut g.pins.r, &mut g.pins.s];
        for point in g.link_cg.iter_mut().chain(pins).chain([&mut g.body_cg]) {
            *point += Vec2::new(next(), next());
        }
        let mut m = MassSet::caption();
        let [l1, l2, l3] = &mut m.links;
        let [i1, i2, i3] = &mut m.link_inertias;
        let masses = [&mut m.body, l1, l2, l3, &mut m.wheel];
        let inertias = [&mut m.body_inertia, i1, i2, i3, &mut m.wheel_inertia];
        for (value, by) in masses.into_iter().chain(inertias).zip(scaled) {
            *value *= by;
        }
        (g, m)
    })
}

/// Grounds of every kind, in front of the robot or behind it, within the ranges that a scene allows but no larger than the robot.
fn grounds() -> impl Strategy<Value = Profile> {
    let height = -0.06..0.06_f64;
    let start = LEVEL..1.0_f64;
    let bump =
        (height.clone(), 0.1..0.4_f64, 0.0..2.0_f64).prop_map(|(height, width, more)| Bump {
            height,
            // exp(-12), 0.3 um, is left of it at the start.
            centre: LEVEL + 3.5 * width + more,
            width,
        });
    let steps = proptest::collection::vec((0.01..0.2_f64, -0.02..0.02_f64), 2..12);
    let heights =
        (start.clone(), steps, 0..Interpolation::ALL.len()).prop_map(|(start, steps, way)| {
            let mut at = Vec2::new(start, 0.0);
            let mut points = vec![at, at + Vec2::new(0.05, 0.0)];
            at.x += 0.05;
            for (dx, dy) in steps {
                at += Vec2::new(dx, dy);
                points.push(at);
            }
            Profile::Heights(Heights::new(points, Interpolation::ALL[way]))
        });
    let class_seed = (0..8_usize, 0..1000_u64, start.clone());
    let one = prop_oneof![
        Just(Profile::Flat),
        proptest::collection::vec(bump, 1..5).prop_map(Profile::Bumps),
        (height.clone(), 0.1..0.5_f64, 0.0..1.0_f64).prop_map(|(height, half_width, more)| {
            Profile::CosBump(CosBump {
                height,
                centre: LEVEL + half_width + more,
                half_width,
            })
        }),
        (-0.45..0.45_f64, start.clone(), 0.1..2.0_f64).prop_map(|(angle, start, length)| {
            Profile::Ramp(Ramp {
                angle,
                start,
                length,
            })
        }),
        (height.clone(), 0.1..0.4_f64, 1..4_u32, start.clone()).prop_map(
            |(rise, run, count, start)| {
                Profile::Stairs(Stairs {
                    // 0 is no step.
                    rise: rise + 0.001_f64.copysign(rise),
                    run,
                    count,
                    start,
                })
            }
        ),
        (height, 0.2..1.0_f64, 1..5_u32, start.clone()).prop_map(
            |(amplitude, wavelength, periods, start)| {
                Profile::Sine(Sine {
                    amplitude: 0.4 * amplitude,
                    wavelength,
                    start,
                    periods,
                })
            }
        ),
        (0.01..0.2_f64, 0.02..0.3_f64, start).prop_map(|(depth, width, start)| {
            Profile::Ditch(Ditch {
                depth,
                width,
                start,
            })
        }),
        class_seed.prop_map(|(class, seed, start)| {
            Profile::Rough(Rough::new(RoughSettings {
                class: RoughClass::ALL[class],
                shortest: 0.2,
                longest: 5.0,
                start,
                extent: 3.0,
                fade: 0.5,
                seed,
            }))
        }),
        heights,
    ];
    let behind_it_waves = |one: Profile| {
        let waves = Profile::Sine(Sine {
            amplitude: 0.008,
            wavelength: 0.4,
            start: -LEVEL - 1.2,
            periods: 3,
        });
        match one {
            Profile::Flat => waves,
            one => Profile::Course(Course::new(vec![waves, one])),
        }
    };
    prop_oneof![one.clone(), one.prop_map(behind_it_waves)]
}

/// Speeds forward and backward, m/s, never at rest.
fn speeds() -> impl Strategy<Value = f64> {
    (0.05..0.5_f64, any::<bool>()).prop_map(|(v, back)| if back { -v } else { v })
}

/// What must hold of every record, whatever the robot and ground; else what does not.
fn holds(scene: &Scene, terrain: &Terrain, truth: &Truth) -> Result<(), String> {
    let geometry = &scene.robot.robot.geometry;
    let written = format!("{truth:?}");
    if written.contains("NaN") || written.contains("inf") {
        return Err("a value is no number".to_owned());
    }
    for (i, w) in truth.wheels.iter().enumerate() {
        let wheel = i + 1;
        // Not the plant's own word: where the ground is nearest, the centre is on its outer side.
        if terrain
            .nearest(w.position)
            .is_none_or(|c| c.distance <= 0.0)
        {
            return Err(format!("wheel {wheel} is below the ground"));
        }
        if w.normal_force < 0.0 || (w.contacts == 0 && w.normal_force > 0.0) {
            return Err(format!("N of wheel {wheel} is {}", w.normal_force));
        }
        // Of two contacts N is the sum of vectors, T the plain sum: the bound holds for one.
        let most = scene.friction.mu_s * w.normal_force * (1.0 + 1e-12);
        if w.contacts == 1 && w.traction.abs() > most {
            return Err(format!(
                "T of wheel {wheel} is {}, N {}",
                w.traction, w.normal_force
            ));
        }
    }
    // Both bars of a pin have it at the same place, and each axle is where its link has it.
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

/// What came of random runs.
#[derive(Debug, Default)]
struct Outcome {
    /// Runs that went to their end.
    ended: u32,
    /// Runs that stopped, by reason.
    stopped: BTreeMap<String, u32>,
    /// Records with a wheel in the air, with a wheel on two places, with a wheel that slides at more than v_d.
    in_the_air: u32,
    on_two_places: u32,
    sliding: u32,
}

impl Outcome {
    fn look(&mut self, scene: &Scene, truth: &Truth) {
        let any = |what: fn(&WheelTruth, f64) -> bool| {
            u32::from(truth.wheels.iter().any(|w| what(w, scene.friction.v_d)))
        };
        self.in_the_air += any(|w, _| w.contacts == 0);
        self.on_two_places += any(|w, _| w.contacts > 1);
        self.sliding += any(|w, v_d| w.contacts > 0 && w.slip_speed.abs() > v_d);
    }
}

/// Makes random runs.
fn runs(cases: u32, seconds: f64, engine: EngineKind) -> Outcome {
    let config = ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20),
        failure_persistence: None,
        // A run that fails is shown as it is: to shrink it takes minutes.
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
        // The engine cuts its steps for stiff friction by itself.
        let longest = longest_step_for_contact(&scene.contact, robot);
        scene.engine.step = scene.engine.step.min(0.6 * longest);
        prop_assume!(robot.geometry.check().is_ok() && robot.mass.check().is_ok());
        // Wide bumps reach back to the waves behind.
        prop_assume!(profile.check().is_ok());
        scene.terrain.profile = profile;
        let setup = scene.plant_setup();
        let mut plant = Plant::new(&setup);
        let records = (seconds / setup.period) as u32;
        for _ in 0..records {
            let next = plant.as_mut().map_err(|why| *why);
            match next.and_then(Plant::next_truth) {
                Ok(truth) => {
                    let held = holds(&scene, &setup.terrain, &truth);
                    let context = || format!("t = {}: {:?}", truth.time, scene.terrain.profile);
                    outcome.borrow_mut().look(&scene, &truth);
                    prop_assert!(held.is_ok(), "{:?}, {}", held, context());
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
    let result = TestRunner::new(config).run(&(robots(), grounds(), speeds()), one);
    assert!(result.is_ok(), "{}", result.unwrap_err());
    outcome.into_inner()
}

/// Property: of 150 random runs of the direct engine each obeys the laws to its end, or stops with a reason, which few do.
#[test]
fn random_runs_by_direct() {
    let found = runs(150, 5.0, EngineKind::Direct);
    println!("direct, 150 runs of 5 s: {found:?}");
    assert!(found.ended >= 135, "{found:?}");
    assert!(found.in_the_air > 100 && found.on_two_places > 100 && found.sliding > 100);
}

/// The same by rapier, which takes longer.
#[test]
fn random_runs_by_rapier() {
    let found = runs(40, 2.0, EngineKind::Rapier);
    println!("rapier, 40 runs of 2 s: {found:?}");
    assert!(found.ended >= 36, "{found:?}");
    // In 2 s few get so far as to fly.
    assert!(found.on_two_places > 0 && found.sliding > 0);
}
