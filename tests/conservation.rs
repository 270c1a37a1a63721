//! What must hold of the simulated forces whatever the reference says: closed forms, momentum, determinism.

use crate::support::{keep, scene};
use robhaz_sim::Truth;

const ENGINES: [&str; 2] = ["engine.kind=rapier", "engine.kind=direct"];

/// Closed form: static loads on level ground (the four-bar's statics by hand), and the penetration of eq. (10) under them.
///
/// Settled at 0.75 s: the slow mode of the contact (0.118 s) has left exp(-6) of a start that was 2 N off at most.
#[test]
fn static_loads_and_penetrations_on_level_ground() {
    for (geometry, expected) in [("A", [43.58, 48.05, 45.71]), ("B", [46.21, 45.65, 45.48])] {
        for engine in ENGINES {
            let overrides = [
                engine,
                &format!("robot.geometry={geometry}"),
                "record.duration=0.75",
                "record.compare_from=0.5",
            ];
            let kept = keep(&scene("flat", &overrides));
            for (wheel, expected) in kept.truth[750].wheels.iter().zip(expected) {
                let n = wheel.normal_force;
                assert!((n - expected).abs() < 0.015, "{geometry}, {engine}: {n}");
                let law = robhaz_sim::contact::ContactLaw::default();
                // 0.1 um is 0.02 N.
                let penetration = law.static_penetration(n);
                assert!((wheel.penetration - penetration).abs() < 1e-7);
            }
        }
    }
}

/// Conservation: what the ground gives is what gravity takes and what the robot gains, over the whole course and any part
/// of it. The impulse of the ground's force at 1 kHz (trapezoidal rule) against weight times time and momentum.
#[test]
fn momentum_balances() {
    for engine in ENGINES {
        let scene = scene("smooth", &[engine]);
        let kept = keep(&scene);
        let mass = &scene.robot.robot.mass;
        let masses = [mass.body, mass.links[0], mass.links[1], mass.links[2]];
        let momentum = |t: &Truth, kept: &[Truth], k: usize| {
            let bars = [&t.body, &t.links[0], &t.links[1], &t.links[2]];
            let mut p = [0.0; 2];
            for (m, bar) in masses.iter().zip(bars) {
                p[0] += m * bar.velocity.x;
                p[1] += m * bar.velocity.y;
            }
            // Wheels by central differences of their positions: 1e-5 m/s at these accelerations.
            for i in 0..3 {
                let step = kept[k + 1].wheels[i].position - kept[k - 1].wheels[i].position;
                p[0] += mass.wheel * step.x / 2e-3;
                p[1] += mass.wheel * step.y / 2e-3;
            }
            p
        };
        let ground = |t: &Truth| {
            let mut f = [0.0, -mass.total() * robhaz_model::GRAVITY];
            for w in &t.wheels {
                let (sin, cos) = w.contact_angle.sin_cos();
                f[0] += w.traction * cos - w.normal_force * sin;
                f[1] += w.traction * sin + w.normal_force * cos;
            }
            f
        };
        for (from, to) in [(500, 5000), (5000, 12_000), (1000, 19_000)] {
            let truth = &kept.truth;
            let before = momentum(&truth[from], truth, from);
            let after = momentum(&truth[to], truth, to);
            let mut impulse = [0.0; 2];
            for k in from..to {
                let (a, b) = (ground(&truth[k]), ground(&truth[k + 1]));
                for axis in 0..2 {
                    impulse[axis] += 0.5e-3 * (a[axis] + b[axis]);
                }
            }
            for axis in 0..2 {
                let error = impulse[axis] - (after[axis] - before[axis]);
                println!("{engine}, {from} to {to} ms, axis {axis}: {error:.1e} N s");
                // Weight times time is up to 2472 N s; 2e-3 N s is a millionth of it.
                assert!(
                    error.abs() < 2e-3,
                    "{engine}: {error} N s along axis {axis}"
                );
            }
        }
    }
}

/// The same scene gives the same bits, run after run.
#[test]
fn runs_repeat_to_the_bit() {
    for engine in ENGINES {
        for name in ["smooth", "stairs"] {
            let scene = scene(name, &[engine, "record.duration=5"]);
            let [a, b] = [keep(&scene), keep(&scene)];
            assert!(a.truth == b.truth, "{name}, {engine}");
            assert!(a.estimates == b.estimates, "{name}, {engine}");
        }
    }
}

/// Bounds of the laws: N never pulls, T never exceeds mu_s N, no number is lost, on smooth ground and on stairs.
#[test]
fn forces_stay_within_their_laws() {
    for engine in ENGINES {
        for name in ["smooth", "stairs"] {
            let scene = scene(name, &[engine]);
            for t in &keep(&scene).truth {
                for w in &t.wheels {
                    assert!(w.normal_force >= 0.0);
                    // Of two contacts N is the sum of vectors, T the plain sum: the bound holds for one.
                    if w.contacts == 1 {
                        assert!(w.traction.abs() <= scene.friction.mu_s * w.normal_force + 1e-12);
                    }
                    assert!(w.penetration.is_finite() && w.contact_angle.is_finite());
                }
            }
        }
    }
}

/// Conservation: the motors' work is what gear damping, friction and the contacts take, and what the robot gains.
///
/// All from the records: kinetic and potential energy of bars, wheels and rotors at both ends, work by the trapezoidal rule
/// at 1 kHz. The wheels' penetration works against N, the slip against T.
#[test]
fn energy_balances() {
    for (engine, bound) in [
        // Rapier's step of 0.1 ms is of first order in time.
        ("engine.kind=rapier", 1e-4),
        // What is left is the trapezoidal rule: 1 ms against a slow pole of the contact of 118 ms.
        ("engine.kind=direct", 1e-6),
    ] {
        let scene = scene("smooth", &[engine, "engine.tolerance=1e-6"]);
        let truth = keep(&scene).truth;
        let robot = &scene.robot.robot;
        let energy = |t: &Truth| {
            let m = &robot.mass;
            let mut e = 0.0;
            let bars = [
                (m.body, m.body_inertia, &t.body),
                (m.links[0], m.link_inertias[0], &t.links[0]),
                (m.links[1], m.link_inertias[1], &t.links[1]),
                (m.links[2], m.link_inertias[2], &t.links[2]),
            ];
            for (mass, inertia, bar) in bars {
                e += 0.5 * mass * bar.velocity.norm_squared() + 0.5 * inertia * bar.rate.powi(2);
                e += mass * robhaz_model::GRAVITY * bar.position.y;
            }
            for (i, w) in t.wheels.iter().enumerate() {
                let link = t.bar(robot.geometry.carriers[i].bar());
                let arm = w.position - link.position;
                let velocity = link.velocity + robhaz_model::Vec2::new(-arm.y, arm.x) * link.rate;
                e += 0.5 * m.wheel * velocity.norm_squared();
                e += m.wheel * robhaz_model::GRAVITY * w.position.y;
                // The disc turns absolutely, the rotor relative to the link.
                e += 0.5 * m.wheel_inertia * (w.omega - link.rate).powi(2);
                e += 0.5 * m.rotor_inertia * w.omega.powi(2);
            }
            e
        };
        let (mut motors, mut losses) = (0.0, 0.0);
        let (from, to) = (500, 19_500);
        for k in from..to {
            for (a, b) in truth[k].wheels.iter().zip(&truth[k + 1].wheels) {
                let mean = |f: &dyn Fn(&robhaz_sim::WheelTruth) -> f64| 0.5e-3 * (f(a) + f(b));
                motors += mean(&|w| w.torque * w.omega);
                losses += mean(&|w| scene.drive.viscous_damping * w.omega.powi(2));
                losses += mean(&|w| w.traction * w.slip_speed);
                losses += 0.5 * (a.normal_force + b.normal_force) * (b.penetration - a.penetration);
            }
        }
        let gain = energy(&truth[to]) - energy(&truth[from]);
        let relative = (motors - losses - gain) / motors;
        println!(
            "{engine}: motors {motors:.4} J, losses {losses:.4} J, gain {gain:.4} J, left {relative:.1e}"
        );
        assert!(motors > 10.0);
        assert!(relative.abs() < bound, "{engine}: {relative}");
    }
}
