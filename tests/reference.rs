//! The simulation held against runs of an independent solver (another formulation, another language: see
//! `reference/README.md`).

use crate::support::{Reference, keep, scene};
use robhaz_sim::Truth;

/// Records of the reference up to this time are left out for pin forces, s: in the first 0.1 ms after the raw start the
/// wheels' fast pole (0.075 ms) makes the pins' forces change by newtons, and ours are means over one step.
const AFTER_FIRST_STEP: f64 = 0.02;

struct Bounds {
    force: f64,
    pin_force: f64,
}

/// Holds N, T, pin forces, poses and the rest of one run against its reference.
fn hold(case: &str, truth: &[Truth], bounds: &Bounds) {
    let reference = Reference::read(case);
    let check = |name: &str, from: f64, bound: f64, value: &dyn Fn(&Truth) -> f64| {
        let (rms, greatest) = reference.difference(name, from, truth, value);
        println!("{case} {name:8} RMS {rms:.2e}  greatest {greatest:.2e}");
        assert!(
            rms <= bound,
            "{case}: {name} differs by {rms} RMS, allowed {bound}"
        );
    };
    for i in 0..3 {
        let name = |symbol: &str| format!("{symbol}{}", i + 1);
        check(&name("N"), 0.0, bounds.force, &|t| t.wheels[i].normal_force);
        check(&name("T"), 0.0, bounds.force, &|t| t.wheels[i].traction);
        // The torque that makes as much traction on a wheel of 0.1 m.
        check(&name("tau"), 0.0, 0.1 * bounds.force, &|t| {
            t.wheels[i].torque
        });
        // A contact angle off by 1e-4 rad turns 46 N by 5 mN.
        check(&name("gamma"), 0.0, 1e-4, &|t| t.wheels[i].contact_angle);
        // 1 um of penetration is 0.17 N.
        check(&name("pen_mm"), 0.0, 1e-3, &|t| {
            1e3 * t.wheels[i].penetration
        });
        check(&name("vslip"), 0.0, 1e-5, &|t| t.wheels[i].slip_speed);
        // The symplectic Euler step is half a step ahead: 1e-4 rad at 2 rad/s.
        check(&name("phi"), 0.0, 2e-4, &|t| t.wheels[i].angle);
    }
    // Poses: 0.1 mm and 1e-4 rad.
    check("body_x", 0.0, 1e-4, &|t| t.body.position.x);
    check("body_z", 0.0, 1e-4, &|t| t.body.position.y);
    check("thb", 0.0, 1e-4, &|t| t.body.angle);
    for i in 0..3 {
        check(&format!("th{}", i + 1), 0.0, 1e-4, &|t| t.links[i].angle);
    }
    check("xQ", 0.0, 1e-4, &|t| t.pins[1].position.x);
    check("zQ", 0.0, 1e-4, &|t| t.pins[1].position.y);
    for (i, pin) in ["P", "Q", "R", "S"].iter().enumerate() {
        check(
            &format!("{pin}x"),
            AFTER_FIRST_STEP,
            bounds.pin_force,
            &|t| t.pins[i].force.x,
        );
        check(
            &format!("{pin}z"),
            AFTER_FIRST_STEP,
            bounds.pin_force,
            &|t| t.pins[i].force.y,
        );
    }
}

/// Settling and starting on level ground. Bounds: ten times what a step of 0.1 ms leaves (0.3 mN RMS).
#[test]
fn flat_start() {
    let kept = keep(&scene(
        "flat",
        &["contact.damping_ramp=0", "record.duration=4"],
    ));
    hold(
        "c6_flat_start",
        &kept.truth,
        &Bounds {
            force: 0.005,
            pin_force: 0.02,
        },
    );
}

/// The paper's main scene with eq. (10) as printed. Bounds: ten times what a step of 0.1 ms leaves (1.4 mN RMS).
#[test]
fn smooth_without_the_ramp_of_c() {
    let kept = keep(&scene("smooth", &["contact.damping_ramp=0"]));
    hold(
        "c1_smooth_stiff",
        &kept.truth,
        &Bounds {
            force: 0.015,
            pin_force: 0.02,
        },
    );
    // The loop stays closed to a micrometre.
    let open = kept.truth.iter().map(|t| t.loop_error).fold(0.0, f64::max);
    assert!(open < 1e-6, "{open}");
}
