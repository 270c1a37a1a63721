//! Runs whose outcome can be written down. Static loads on level ground stand in `conservation.rs`; eq. (10) swept and the
//! penetration at rest beside the law.

use crate::support::{keep, scene};
use robhaz_model::PinStop;
use robhaz_scene::EngineKind;
use robhaz_sim::stop::stop_torque;
use robhaz_terrain::{Profile, Ramp};
use robhaz_verify::truth_of;

/// Closed form: rolling down a slope under a drive so soft that the slope rules. Wheels and rotors add to the mass,
/// M = m + 3 (J_wheel + J_rotor)/d^2; gravity pulls with m g sin a, damping and control hold with 3 (B + Kp) v/d^2 and push with
/// 3 Kp omega_set/d, d = r - g. So the rims' speed nears its end with exp(-t/tau), tau = M d^2/(3 (B + Kp)); the way
/// there is followed, not the end alone.
///
/// At the end nothing accelerates: the sum of N is the weight's part across the slope, the sum of T its part along it, and each
/// N is the one that the paper's statics (the estimator's code, with true masses) gives for the given T.
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
        // The arm of the traction.
        let r = robot.geometry.wheel_radius;
        let d = r - law.static_penetration(robot.mean_wheel_load());
        let damping = scene.drive.viscous_damping + scene.drive.kp;
        let spinning = 3.0 * (robot.mass.wheel_inertia + robot.mass.rotor_inertia);
        let tau = (mass * d * d + spinning) / (3.0 * damping);
        let push = 3.0 * scene.drive.kp * scene.drive.speed / r;
        let end = (weight * angle.sin() * d + push) * d / (3.0 * damping);

        let kept = keep(&scene);
        // Of the rims.
        let speed = |i: usize| {
            kept.truth[i]
                .wheels
                .iter()
                .map(|w| w.omega * d)
                .sum::<f64>()
                / 3.0
        };
        // From when the rear wheel has left the level ground and its meeting the corner has died out.
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
            "{}: {:.4} to {end:.4} m/s, off by {worst:.1e}",
            engine.name(),
            speed(on)
        );
        // The creep changes on the way, and with it the speed of the mass against that of the rims.
        assert!(worst < 1e-3, "{worst}");
        // Near rest mu(v) rises with 3 mu_s/(2 v_s), 60 s/m: T/N = -tan a is a creep of 1.5 mm/s.
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
        // The loads, and with them the creeps and the arms (by 0.02 mm, 0.06 mm/s), are not the same on all wheels.
        assert!((rims / end - 1.0).abs() < 1e-4 && ((body - rims) / creep - 1.0).abs() < 0.04);

        let last = kept.truth.last().unwrap();
        let sum = |of: fn(&robhaz_sim::WheelTruth) -> f64| last.wheels.iter().map(of).sum::<f64>();
        let (n, t) = (sum(|w| w.normal_force), sum(|w| w.traction));
        let (across, along) = (weight * angle.cos(), -weight * angle.sin());
        println!(
            "{}: sum of N {n:.4} N for {across:.4}, of T {t:.4} N for {along:.4}",
            engine.name()
        );
        // What is left of the way to the end: exp(-12 s/0.6 s) of the forces.
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
            // The estimator takes r for the arm and T from a filtered speed.
            assert!((wheel.normal_force - found).abs() < 0.03);
        }
    }
}

/// Closed form: the stops' torque is k times the way beyond a limit plus c times the rate, and never pulls; swept, and in runs
/// in which the robot leans on its stops.
#[test]
fn a_stop_holds_with_stiffness_and_damping() {
    let stop = PinStop::standard();
    let expected = |stop: &PinStop, angle: f64, rate: f64| {
        let beyond = (angle - stop.upper).max(0.0) + (angle - stop.lower).min(0.0);
        let torque = -(stop.stiffness * beyond + stop.damping * rate);
        // Towards the free range, or not at all.
        if beyond * torque < 0.0 { torque } else { 0.0 }
    };
    for i in -100..=100 {
        for j in -10..=10 {
            let (angle, rate) = (0.01 * f64::from(i), 0.3 * f64::from(j));
            let found = stop_torque(&stop, angle, rate);
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
            // Of 2000 N m/rad an angle's rounding, 1e-16, leaves 1e-12.
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
