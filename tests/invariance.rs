//! Invariances: the forces are the same for a mirrored robot on mirrored ground, for the same
//! ground at another place, and for the same ground through more points.
//!
//! Each test prints the differences of N and T over all records. On rolling ground only rounding
//! differs. At an impact N rises within microseconds, so a difference in the solver's steps around
//! it changes the recorded values.

use crate::support::{scene, truth_of};
use robhaz_model::{Carrier, Geometry, Outline, PinStop, Pins, Vec2};
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::Truth;
use robhaz_terrain::{
    Bump, Course, Ditch, Heights, Interpolation, Profile, Ramp, Sine, Stairs, Terrain,
};

/// Duration, s: until the middle wheel, too, reaches the end of the level ground.
const DURATION: f64 = 4.5;

/// The main scene on another profile, with a tight tolerance.
fn on(profile: Profile, engine: EngineKind) -> Scene {
    let mut scene = scene("smooth", &[]);
    assert_eq!(profile.check(), Ok(()));
    scene.terrain.profile = profile;
    scene.engine.kind = engine;
    // Rounding can change the choice of a step; the smaller the tolerance, the smaller the effect.
    scene.engine.tolerance = 1e-7;
    scene.record.duration = DURATION;
    scene
}

/// Difference of two runs over all wheels and records.
struct Difference {
    /// Greatest difference of N and T, N.
    greatest: f64,
    /// RMS difference of N and T, N.
    rms: f64,
    /// Greatest distance of the bodies, m.
    apart: f64,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            greatest,
            rms,
            apart,
        } = self;
        write!(
            f,
            "forces {rms:.1e} N RMS, {greatest:.1e} N at most, bodies {apart:.1e} m"
        )
    }
}

fn difference(a: &[Truth], b: &[Truth]) -> Difference {
    assert_eq!(a.len(), b.len());
    let mut found = Difference {
        greatest: 0.0,
        rms: 0.0,
        apart: 0.0,
    };
    let mut count = 0.0;
    for (a, b) in a.iter().zip(b) {
        found.apart = found.apart.max((a.body.position - b.body.position).norm());
        for (a, b) in a.wheels.iter().zip(&b.wheels) {
            for off in [a.normal_force - b.normal_force, a.traction - b.traction] {
                found.greatest = found.greatest.max(off.abs());
                found.rms += off * off;
                count += 1.0;
            }
        }
    }
    found.rms = f64::sqrt(found.rms / count);
    found
}

/// Range of N over a run, N: the ground must change the forces.
fn range(truth: &[Truth]) -> f64 {
    let all = || truth.iter().flat_map(|t| t.wheels).map(|w| w.normal_force);
    all().fold(0.0, f64::max) - all().fold(f64::INFINITY, f64::min)
}

fn mirrored_point(v: Vec2) -> Vec2 {
    Vec2::new(-v.x, v.y)
}

/// The robot mirrored at x = 0: wheel 3 becomes wheel 1.
fn mirrored_geometry(g: &Geometry) -> Geometry {
    let [a, b, c] = g.axles.map(mirrored_point);
    let [d, e, f]: [Carrier; 3] = g.carriers;
    Geometry {
        suspension: g.suspension,
        wheel_radius: g.wheel_radius,
        axles: [c, b, a],
        carriers: [f, e, d],
        pins: Pins {
            p: mirrored_point(g.pins.p),
            q: mirrored_point(g.pins.q),
            r: mirrored_point(g.pins.r),
            s: mirrored_point(g.pins.s),
        },
        body_cg: mirrored_point(g.body_cg),
        link_cg: g.link_cg.map(mirrored_point),
        stop: PinStop {
            lower: -g.stop.upper,
            upper: -g.stop.lower,
            ..g.stop
        },
        outline: Outline {
            body_lower: Vec2::new(-g.outline.body_upper.x, g.outline.body_lower.y),
            body_upper: Vec2::new(-g.outline.body_lower.x, g.outline.body_upper.y),
            ..g.outline
        },
    }
}

/// The truth mirrored at x = 0.
fn mirrored_truth(truth: &[Truth]) -> Vec<Truth> {
    let mirrored = |t: &Truth| {
        let mut image = *t;
        for bar in std::iter::once(&mut image.body).chain(&mut image.links) {
            bar.position.x *= -1.0;
            bar.velocity.x *= -1.0;
            bar.angle *= -1.0;
            bar.rate *= -1.0;
        }
        image.wheels.reverse();
        for w in &mut image.wheels {
            w.position.x *= -1.0;
            for value in [
                &mut w.angle,
                &mut w.omega,
                &mut w.torque,
                &mut w.traction,
                &mut w.contact_angle,
                &mut w.slip_speed,
            ] {
                *value *= -1.0;
            }
        }
        for pin in &mut image.pins {
            pin.position.x *= -1.0;
            pin.force.x *= -1.0;
        }
        image.stop_torque *= -1.0;
        image
    };
    truth.iter().map(mirrored).collect()
}

/// Profiles and their mirror images.
fn mirrored_profiles() -> [(&'static str, Profile, Profile); 4] {
    let bumps = |sign: f64| {
        let Profile::Bumps(bumps) = Profile::smooth() else {
            return Profile::Flat;
        };
        let mirrored = |b: Bump| Bump {
            centre: sign * b.centre,
            ..b
        };
        Profile::Bumps(bumps.into_iter().map(mirrored).collect())
    };
    let waves = |start| {
        Profile::Sine(Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start,
            periods: 2,
        })
    };
    // A step far behind the robot raises the ground to the height from which the mirrored ramp
    // descends to the start.
    let up = |rise| {
        Profile::Stairs(Stairs {
            rise,
            run: 0.3,
            count: 1,
            start: -50.0,
        })
    };
    let angle = 15.0_f64.to_radians();
    let (long, high) = (0.8 * angle.cos(), 0.8 * angle.sin());
    let down = Profile::Ramp(Ramp {
        angle: -angle,
        start: -0.7 - long,
        length: 0.8,
    });
    let ditch = |start| {
        Profile::Ditch(Ditch {
            depth: 0.05,
            width: 0.12,
            start,
        })
    };
    [
        ("smooth", bumps(1.0), bumps(-1.0)),
        ("sine", waves(0.7), waves(-1.7)),
        (
            "ramp",
            Profile::Ramp(Default::default()),
            Profile::Course(Course::new(vec![up(high), down])),
        ),
        ("ditch", ditch(0.7), ditch(-0.82)),
    ]
}

/// Symmetry: a mirrored robot that drives backwards over the mirrored ground has the mirrored
/// forces.
#[test]
fn forward_and_backward_are_symmetric() {
    for engine in EngineKind::ALL {
        for (name, ground, mirrored) in mirrored_profiles() {
            let scene = on(ground, engine);
            let mut other = on(mirrored, engine);
            other.drive.speed = -scene.drive.speed;
            other.robot.robot.geometry = mirrored_geometry(&scene.robot.robot.geometry);
            assert_eq!(other.robot.robot.geometry.check(), Ok(()));
            let truth = truth_of(&scene).unwrap();
            let image = mirrored_truth(&truth_of(&other).unwrap());
            let found = difference(&truth, &image);
            println!("mirror, {}, {name}: {found}", engine.name());
            assert!(range(&truth) > 10.0);
            let has_corners = Terrain::new(scene.terrain.profile).has_corners();
            let allowed = match (engine, has_corners) {
                (EngineKind::Direct, _) => ROUNDING,
                (EngineKind::Rapier, false) => RAPIER_MIRRORED,
                (EngineKind::Rapier, true) => RAPIER_MIRRORED_AT_CORNERS,
            };
            assert_allowed(&found, allowed);
        }
    }
}

/// Allowed difference: RMS of the forces, N, and distance of the bodies, m.
type Allowed = (f64, f64);

/// Rounding, and for direct its effect on the steps: ten times the measured differences.
const ROUNDING: Allowed = (1e-4, 1e-8);
/// Rapier solves its joints one after the other. Mirroring reverses their order, which changes the
/// error of its iterations.
const RAPIER_MIRRORED: Allowed = (2e-4, 2e-7);
/// The same at impacts of kilonewtons: ten times the measured differences.
const RAPIER_MIRRORED_AT_CORNERS: Allowed = (0.2, 5e-6);

fn assert_allowed(found: &Difference, allowed: Allowed) {
    assert!(found.rms < allowed.0 && found.apart < allowed.1, "{found}");
}

fn shifted(profile: &Profile, by: f64) -> Profile {
    match profile {
        Profile::Bumps(bumps) => {
            let moved = |b: &Bump| Bump {
                centre: b.centre + by,
                ..*b
            };
            Profile::Bumps(bumps.iter().map(moved).collect())
        }
        Profile::Ditch(ditch) => Profile::Ditch(Ditch {
            start: ditch.start + by,
            ..*ditch
        }),
        Profile::Ramp(ramp) => Profile::Ramp(Ramp {
            start: ramp.start + by,
            ..*ramp
        }),
        Profile::Heights(heights) => {
            let moved = |p: &Vec2| p + Vec2::new(by, 0.0);
            let points = heights.points().iter().map(moved).collect();
            // The one such ground that is shifted here.
            Profile::Heights(Heights::new(points, Interpolation::Corners))
        }
        other => panic!("{other:?}"),
    }
}

/// Invariance: the same ground and start at another x. The start follows from the nominal
/// positions, so these are shifted.
#[test]
fn a_shift_in_x_changes_nothing() {
    let grounds = [
        ("smooth", Profile::smooth()),
        ("ramp", Profile::Ramp(Default::default())),
        ("ditch", Profile::Ditch(Ditch::default())),
        ("heights", track(Interpolation::Corners, 1)),
    ];
    for engine in EngineKind::ALL {
        for (name, ground) in &grounds {
            // Not a multiple of the cells' or edges' width, so that the ground is divided at other
            // places.
            let by = 98.765_432_1;
            let scene = on(ground.clone(), engine);
            let mut other = on(shifted(ground, by), engine);
            let g = &mut other.robot.robot.geometry;
            let pins = [&mut g.pins.p, &mut g.pins.q, &mut g.pins.r, &mut g.pins.s];
            let points = g.axles.iter_mut().chain(&mut g.link_cg).chain(pins);
            points.chain([&mut g.body_cg]).for_each(|p| p.x += by);
            let truth = truth_of(&scene).unwrap();
            let mut there = truth_of(&other).unwrap();
            there.iter_mut().for_each(|t| t.body.position.x -= by);
            let found = difference(&truth, &there);
            println!("shift, {}, {name}: {found}", engine.name());
            assert!(range(&truth) > 5.0);
            assert_allowed(&found, ROUNDING);
        }
    }
}

/// A track through points, with each interval divided into `parts` by points on its curve.
fn track(interpolation: Interpolation, parts: u32) -> Profile {
    let points = [
        (0.5, 0.0),
        (0.7, 0.0),
        (0.9, 0.02),
        (1.05, 0.015),
        (1.3, 0.04),
        (1.6, 0.01),
        (1.8, 0.01),
    ];
    let given: Vec<Vec2> = points.iter().map(|(x, y)| Vec2::new(*x, *y)).collect();
    let coarse = Heights::new(given.clone(), interpolation);
    if parts == 1 {
        return Profile::Heights(coarse);
    }
    let curve = Profile::Heights(coarse);
    let mut points = vec![given[0]];
    for pair in given.windows(2) {
        for i in 1..=parts {
            let x = pair[0].x + (pair[1].x - pair[0].x) * f64::from(i) / f64::from(parts);
            points.push(Vec2::new(x, curve.eval(x)[0]));
        }
    }
    Profile::Heights(Heights::new(points, interpolation))
}

/// Invariance: more points on the same curve give the same ground. This does not hold for a
/// monotone curve, whose slopes come from the points.
#[test]
fn more_points_on_the_ground_change_nothing() {
    for engine in EngineKind::ALL {
        for interpolation in [Interpolation::Spline, Interpolation::Corners] {
            let coarse = on(track(interpolation, 1), engine);
            let truth = truth_of(&coarse).unwrap();
            assert!(range(&truth) > 5.0);
            for parts in [3, 1000] {
                let fine = on(track(interpolation, parts), engine);
                let found = difference(&truth, &truth_of(&fine).unwrap());
                println!(
                    "knots, {}, {interpolation:?} in {parts}: {found}",
                    engine.name()
                );
                assert_allowed(&found, ROUNDING);
            }
        }
    }
}
