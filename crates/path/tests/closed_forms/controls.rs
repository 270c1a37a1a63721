//! What a robot needs whose control shares its traction, or holds the speeds of its wheels.

use super::*;

/// Closed form: on a uniform slope both controls need its tangent at every wheel: equal T/N is the
/// tangent, and all wheels creep alike. 1e-8: the accuracy of the curve of the centres.
#[test]
fn controls_need_the_tangent_of_a_slope() {
    for drive in [DriveKind::Shared, DriveKind::Speed] {
        let report = judged(&ramp(15.0), &[], driven(drive, 0.8));
        for place in on_slope(&report) {
            let needed = place.needed_mu.unwrap();
            let expected = 15.0_f64.to_radians().tan();
            assert!((needed - expected).abs() < 1e-8, "{drive:?}: {needed}");
        }
    }
}

/// Property: a control needs at least the friction of the best tractions, at each place. 1e-7:
/// tolerance of the linear programs.
#[test]
fn controls_need_no_less_than_the_best() {
    for text in [ramp(15.0), kerb(0.05), String::new()] {
        let best = judged(&text, &[], Options::default());
        for drive in [DriveKind::Shared, DriveKind::Speed] {
            let found = judged(&text, &[], driven(drive, 0.8));
            assert_eq!(best.places.len(), found.places.len());
            for (a, b) in best.places.iter().zip(&found.places) {
                if let (Some(least), Some(needed)) = (a.needed_mu, b.needed_mu) {
                    assert!(needed > least - 1e-7, "{drive:?}: {needed} {least}");
                }
            }
        }
    }
}

/// Property: under the speed control no traction is above what friction gives, and where the margin
/// is below 0 all wheels slide with the friction that would do.
#[test]
fn no_wheel_pulls_more_than_its_friction() {
    for text in [ramp(15.0), kerb(0.05)] {
        let report = judged(&text, &[], driven(DriveKind::Speed, 0.4));
        let mut places = 0;
        for place in report.places.iter().filter(|p| p.contacts == [1; 3]) {
            let (Some(margin), Some(n), Some(t)) =
                (place.margin, place.normal_force, place.traction)
            else {
                continue;
            };
            for i in 0..3 {
                let most = n[i] * (0.4 - margin.min(0.0)) + 1e-9;
                assert!(t[i].abs() <= most, "{place:?}");
            }
            places += 1;
        }
        assert!(places > 100, "{places}");
    }
}

/// Equivalence: a robot of 1 mm/s has no momentum (5e-8 m of height) and its wheels slide with the
/// static coefficient. It passes with the largest T/N that equal ratios need at rest. 2e-3: the
/// places are up to 5 mm apart, and mu_n changes by 0.1 a centimetre at a kerb; the margin is found
/// to 1e-4.
#[test]
fn without_momentum_equal_ratios_decide() {
    for text in [ramp(15.0), kerb(0.03), kerb(0.05)] {
        let report = judged(
            &text,
            &["drive.speed=0.001"],
            driven(DriveKind::Shared, 0.8),
        );
        let needed = report.needed_mu.unwrap();
        let found = 0.8 - report.margin.unwrap();
        assert!((found - needed).abs() < 2e-3, "{text}: {found} {needed}");
    }
}

/// Sensitivity: momentum helps over a kerb, by more than the accuracy of the margin.
#[test]
fn momentum_helps_over_a_kerb() {
    let margin = |speed: &str| {
        let set = format!("drive.speed={speed}");
        let report = judged(&kerb(0.04), &[&set], driven(DriveKind::Shared, 0.8));
        report.margin.unwrap()
    };
    let (slow, fast) = (margin("0.001"), margin("0.2"));
    assert!(fast > slow + 0.01, "{slow} {fast}");
}

/// Equivalence: at the same Froude number v^2/(g r) the same margin is left on Mars as on Earth.
/// 1e-4 as the margin is found.
#[test]
fn the_margin_is_the_same_on_mars() {
    let earth = judged(&kerb(0.04), &[], driven(DriveKind::Speed, 0.8));
    let speed = format!("drive.speed={}", 0.2 * (3.71 / GRAVITY).sqrt());
    let torque = format!("drive.torque_limit={}", 10.0 * 3.71 / GRAVITY);
    let slip = [0.02, 0.1].map(|v| v * (3.71 / GRAVITY).sqrt());
    let [v_s, v_d] = [
        format!("contact.v_s={}", slip[0]),
        format!("contact.v_d={}", slip[1]),
    ];
    let set = ["robot.gravity=mars", &speed, &torque, &v_s, &v_d];
    let mars = judged(&kerb(0.04), &set, driven(DriveKind::Speed, 0.8));
    let (a, b) = (earth.margin.unwrap(), mars.margin.unwrap());
    assert!((a - b).abs() < 1e-4, "{a} {b}");
    let weight = mars.places[0].normal_force.unwrap().iter().sum::<f64>();
    assert!((weight - 14.0 * 3.71).abs() < 1e-6, "{weight}");
}

/// Consistency: with the friction lowered by a little less than the margin a driven robot passes,
/// with a little more it is stuck for want of friction.
#[test]
fn a_driven_robot_is_stuck_beyond_its_margin() {
    for drive in [DriveKind::Shared, DriveKind::Speed] {
        for text in [ramp(20.0), kerb(0.05)] {
            let margin = judged(&text, &[], driven(drive, 0.8)).margin.unwrap();
            let go = |mu: f64| judged(&text, &[], driven(drive, mu));
            assert!(go(0.8 - margin + 1e-3).go, "{drive:?} {text}");
            let stuck = go(0.8 - margin - 1e-3);
            let reason = stuck.first_failure.map(|f| f.reason);
            assert_eq!(reason, Some(Reason::Friction), "{drive:?} {text}");
            assert!(stuck.margin.unwrap() < 0.0 && stuck.probability < 0.5);
        }
    }
}

/// A torque limit below what the slope needs stops a driven robot, whatever the friction.
#[test]
fn a_driven_robot_is_stuck_at_its_torque_limit() {
    let third = Robot::default_a().mass.total() * GRAVITY * 20.0_f64.to_radians().sin() / 3.0 * 0.1;
    let set = format!("drive.torque_limit={}", 0.95 * third);
    let report = judged(&ramp(20.0), &[&set], driven(DriveKind::Shared, 2.0));
    let failure = report.first_failure.unwrap();
    assert_eq!(failure.reason, Reason::Torque);
    assert!(report.probability == 0.0 && report.margin.is_none());
}
