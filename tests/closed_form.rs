//! Runs and laws with a known closed form. `conservation.rs` tests static loads on level ground;
//! `contact.rs` of the simulator tests eq. (10) and the static penetration.

use crate::support::{keep, scene, truth_of};
use robhaz_model::PinStop;
use robhaz_scene::EngineKind;
use robhaz_terrain::{Profile, Ramp};

/// Closed form: the robot rolls down a slope of angle a with a drive so soft that gravity
/// dominates. Let d = r - g be the arm of the traction. Wheels and rotors add to the mass,
/// `M = m + 3 (J_wheel + J_rotor)/d^2`. The driving forces are `m g sin a` of gravity and
/// `3 Kp omega_set/d` of the drive, the braking force is `3 (B + Kp) v/d^2` of damping and control.
/// So the rims' speed v approaches its final value with `exp(-t/tau)`, `tau = M d^2/(3 (B + Kp))`.
/// The test compares v over the whole run.
///
/// At the end the acceleration is zero: the sum of N is the component of the weight normal to the
/// slope, the sum of T the one along it, and each N is that of the paper's statics (the estimator
/// `true-mass`) for the given T.
#[test]
fn rolling_down_a_slope() {
    let angle = 5.0_f64.to_radians();
    for engine in EngineKind::ALL {
        let mut scene = scene("smooth", &[]);
        scene.engine.kind = engine;
        scene.terrain.profile = Profile::Ramp(Ramp {
            angle: -angle,
            start: 0.35,
            length: 10.0,
        });
        (scene.drive.kp, scene.drive.ki, scene.drive.speed) = (0.1, 0.0, 0.3);
        scene.record.duration = 12.0;
        let robot = &scene.robot.robot;
        let (mass, weight) = (robot.mass.total(), robot.mass.total() * 9.81);
        let law = &scene.contact;
        // The arm of the traction is d.
        let r = robot.geometry.wheel_radius;
        let d = r - law.static_penetration(robot.mean_wheel_load());
        let damping = scene.drive.viscous_damping + scene.drive.kp;
        let spinning = 3.0 * (robot.mass.wheel_inertia + robot.mass.rotor_inertia);
        let tau = (mass * d * d + spinning) / (3.0 * damping);
        let push = 3.0 * scene.drive.kp * scene.drive.speed / r;
        let end = (weight * angle.sin() * d + push) * d / (3.0 * damping);

        let kept = keep(&scene);
        // Mean speed of the rims, m/s.
        let speed = |i: usize| {
            kept.truth[i]
                .wheels
                .iter()
                .map(|w| w.omega * d)
                .sum::<f64>()
                / 3.0
        };
        // All wheels have been on the slope for 0.1 s: the impact of the rear wheel at the corner
        // has decayed.
        let all_on =
            |w: &robhaz_sim::WheelTruth| w.contacts == 1 && (w.contact_angle + angle).abs() < 1e-6;
        let on = kept
            .truth
            .iter()
            .position(|t| t.wheels.iter().all(all_on))
            .unwrap()
            + 100;
        assert!(end - speed(on) > 0.02, "{} of {end}", speed(on));
        let mut worst = 0.0_f64;
        for i in (on..kept.truth.len()).step_by(10) {
            let t = kept.truth[i].time - kept.truth[on].time;
            let expected = end - (end - speed(on)) * (-t / tau).exp();
            worst = worst.max((speed(i) / expected - 1.0).abs());
        }
        println!(
            "{}: {:.4} to {end:.4} m/s, relative error {worst:.1e}",
            engine.name(),
            speed(on)
        );
        // The creep, the difference between the speed of the rims and that of the robot, changes
        // during the run.
        assert!(worst < 1e-3, "{worst}");
        // At v = 0 the slope of mu(v) is 3 mu_s/(2 v_s) = 60 s/m: T/N = -tan a gives a creep of 1.5
        // mm/s.
        let friction = &scene.friction;
        let creep = angle.tan() * 2.0 * friction.v_s / (3.0 * friction.mu_s);
        let rims = speed(kept.truth.len() - 1);
        let body = kept.truth.last().unwrap().body.velocity.norm();
        println!(
            "{}: rims {:.2e} off, creep {:.6} m/s for {creep:.6}",
            engine.name(),
            rims / end - 1.0,
            body - rims
        );
        // The wheels' loads differ, and with them the arms (by 0.02 mm) and the creeps (by 0.06
        // mm/s).
        assert!((rims / end - 1.0).abs() < 1e-4 && ((body - rims) / creep - 1.0).abs() < 0.04);

        let last = kept.truth.last().unwrap();
        let sum = |of: fn(&robhaz_sim::WheelTruth) -> f64| last.wheels.iter().map(of).sum::<f64>();
        let (n, t) = (sum(|w| w.normal_force), sum(|w| w.traction));
        let (across, along) = (weight * angle.cos(), -weight * angle.sin());
        println!(
            "{}: sum of N {n:.4} N for {across:.4}, of T {t:.4} N for {along:.4}",
            engine.name()
        );
        // The transient has decayed to exp(-12 s/0.6 s).
        assert!((n - across).abs() < 1e-3 && (t - along).abs() < 1e-3);
        let true_mass = scene.estimators.iter().position(|e| e.name == "true-mass");
        let estimate = kept.estimates[true_mass.unwrap()]
            .last()
            .unwrap()
            .as_ref()
            .unwrap();
        for (wheel, found) in last.wheels.iter().zip(estimate.normal_force) {
            println!(
                "{}: N {:.4} N, statics {found:.4} N",
                engine.name(),
                wheel.normal_force
            );
            // The estimator uses the arm r, and T from a filtered speed.
            assert!((wheel.normal_force - found).abs() < 0.03);
        }
    }
}

/// Closed form: the torque of the end stops is k times the angle beyond a limit plus c times the
/// rate, and never acts away from the free range. Tested over a grid of angles and rates, and in
/// runs in which the robot rests on its stops.
#[test]
fn a_stop_holds_with_stiffness_and_damping() {
    let stop = PinStop::standard();
    let expected = |stop: &PinStop, angle: f64, rate: f64| {
        let beyond = (angle - stop.upper).max(0.0) + (angle - stop.lower).min(0.0);
        let torque = -(stop.stiffness * beyond + stop.damping * rate);
        // The torque acts towards the free range or is zero.
        if beyond * torque < 0.0 { torque } else { 0.0 }
    };
    for i in -100..=100 {
        for j in -10..=10 {
            let (angle, rate) = (0.01 * f64::from(i), 0.3 * f64::from(j));
            let found = stop.torque(angle, rate);
            assert!((found - expected(&stop, angle, rate)).abs() < 1e-10);
        }
    }
    for engine in EngineKind::ALL {
        let mut scene = scene("smooth", &["record.duration=8"]);
        scene.engine.kind = engine;
        let narrow = PinStop {
            lower: (-4.0_f64).to_radians(),
            upper: 4.0_f64.to_radians(),
            ..stop
        };
        scene.robot.robot.geometry.stop = narrow;
        let truth = truth_of(&scene).unwrap();
        let mut greatest = 0.0_f64;
        for t in &truth {
            let angle = t.links[0].angle - t.links[1].angle;
            let rate = t.links[0].rate - t.links[1].rate;
            // Rounding of an angle, 1e-16 rad, times 2000 N m/rad is 2e-13 N m.
            assert!((t.stop_torque - expected(&narrow, angle, rate)).abs() < 1e-9);
            greatest = greatest.max(t.stop_torque.abs());
        }
        println!(
            "{}: the stops hold with up to {greatest:.2} N m",
            engine.name()
        );
        assert!(greatest > 1.0);
    }
}
