use super::*;
use crate::drive::FRICTION_SPEED;

/// Speeds of rim and wheel centre, m/s: a grid over both signs that contains zero and the
/// surroundings of every breakpoint of `law`.
fn slips(law: &FrictionLaw) -> Vec<Slip> {
    let mut speeds = vec![0.0, Slip::SLOWEST, 1e-6, 0.05, 0.2, 0.7, 3.0];
    // 401 slip speeds beside each of them, from micrometres a second to beyond v_d.
    let mut slip_speeds: Vec<f64> = (0..=400)
        .map(|i| 1e-6 * (f64::from(i) * 0.035).exp())
        .collect();
    for breakpoint in [law.v_s, law.v_d] {
        slip_speeds.extend([1.0 - 1e-9, 1.0, 1.0 + 1e-9].map(|near| near * breakpoint));
    }
    slip_speeds.push(0.0);
    speeds.extend([-0.01, -0.05, -0.2, -3.0]);
    let mut slips = Vec::new();
    for centre in speeds {
        for v in &slip_speeds {
            for sign in [-1.0, 1.0] {
                slips.push(Slip {
                    rim: centre + sign * v,
                    centre,
                });
            }
        }
        // A brush contact slides from kappa = 3 mu/C on.
        for a in [0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5] {
            let kappa: f64 = a * 3.0 * law.mu_s / law.slip_stiffness;
            slips.push(Slip {
                rim: centre * (1.0 - kappa),
                centre,
            });
        }
    }
    slips
}

/// mu of a sliding contact, as a polynomial about the middle of the fall.
fn sliding(law: &FrictionLaw, v: f64) -> f64 {
    let y = (2.0 * v.abs() - law.v_s - law.v_d) / (law.v_d - law.v_s);
    let y = y.clamp(-1.0, 1.0);
    0.5 * (law.mu_s + law.mu_d) - 0.25 * (law.mu_s - law.mu_d) * (3.0 * y - y.powi(3))
}

/// T/N of ADAMS's form: for |v| <= v_s the odd cubic through (v_s, mu_s) with slope zero there.
fn adams(law: &FrictionLaw, slip: &Slip) -> f64 {
    let v = slip.rim - slip.centre;
    let x = v / law.v_s;
    if x.abs() < 1.0 {
        law.mu_s * 0.5 * (3.0 * x - x.powi(3))
    } else {
        v.signum() * sliding(law, v)
    }
}

/// T/N of the brush model: the cube of the share of the contact that grips is missing.
fn brush(law: &FrictionLaw, slip: &Slip) -> f64 {
    let v = slip.rim - slip.centre;
    let fastest = [slip.rim.abs(), slip.centre.abs(), 0.01]
        .into_iter()
        .fold(0.0, f64::max);
    let mu = sliding(law, v);
    let grips = (1.0 - law.slip_stiffness * (v / fastest).abs() / (3.0 * mu)).max(0.0);
    v.signum() * mu * (1.0 - grips.powi(3))
}

fn laws() -> Vec<FrictionLaw> {
    let mut laws: Vec<FrictionLaw> = FrictionKind::ALL.map(FrictionLaw::of).to_vec();
    for slip_stiffness in [5.0, 50.0] {
        laws.push(FrictionLaw {
            slip_stiffness,
            mu_s: 0.5,
            mu_d: 0.5,
            ..FrictionLaw::of(FrictionKind::Brush)
        });
    }
    laws.push(FrictionLaw {
        v_s: 0.2e-3,
        mu_d: 0.3,
        ..FrictionLaw::of(FrictionKind::Rigid)
    });
    laws
}

/// Closed form: every law over slip speeds of both signs, across its breakpoints, at standstill of
/// the wheel, of the rim and of both, and in reverse, against formulas of another form. 1e-10 is
/// far above rounding: with v_s = 0.2 mm/s an error of 1e-16 m/s in the slip speed changes T/N by
/// 1e-12.
#[test]
fn laws_equal_their_closed_forms() {
    for law in laws() {
        let slips = slips(&law);
        assert!(slips.len() > 8000);
        for slip in &slips {
            let expected = match law.kind {
                FrictionKind::Adams | FrictionKind::Rigid => adams(&law, slip),
                FrictionKind::Brush => brush(&law, slip),
            };
            let found = law.coefficient(slip);
            assert!(
                (found - expected).abs() < 1e-10,
                "{law:?} {slip:?}: {found} {expected}"
            );
            // The factor allows rounding.
            assert!(found.abs() <= law.mu_s * (1.0 + 1e-15));
            assert!(found * slip.speed() >= 0.0, "friction dissipates");
        }
    }
}

/// Property: every law is odd, no slope is steeper than [`FrictionLaw::steepest_slope`], and the
/// slope at zero slip of a resting wheel reaches it.
#[test]
fn no_slope_is_steeper_than_the_one_at_zero_slip() {
    for law in laws() {
        for slip in slips(&law) {
            let (u, w) = (slip.rim, slip.centre);
            let reverse = Slip {
                rim: -u,
                centre: -w,
            };
            let found = law.coefficient(&slip);
            assert!((law.coefficient(&reverse) + found).abs() < 1e-15);
            let faster = Slip {
                rim: u + 1e-7,
                centre: w,
            };
            let slope = (law.coefficient(&faster) - found) / 1e-7;
            // Rounding of a speed of 3 m/s, 4e-16 m/s, over the difference of 1e-7 m/s.
            let steepest = law.steepest_slope() * (1.0 + 1e-8);
            assert!(slope <= steepest, "{law:?} {slip:?}: {slope} {steepest}");
        }
        let creep = Slip {
            rim: 1e-8,
            centre: 0.0,
        };
        let slope = law.coefficient(&creep) / 1e-8;
        // The brush model's next term is a = 1e-8 C/(0.01 * 3 mu).
        assert!((slope / law.steepest_slope() - 1.0).abs() < 1e-4, "{law:?}");
    }
}

/// Definition: a contact slides where T/N no longer rises with the slip speed, and grips before.
/// The speed of the centre is 0.2 m/s.
#[test]
fn a_contact_slides_beyond_its_limit() {
    for law in laws() {
        let at = |v: f64| Slip {
            rim: 0.2 + v,
            centre: 0.2,
        };
        for i in 1..2000 {
            // Beside round numbers, so that no slip speed is the limit itself.
            let slip = at(1e-4 * f64::from(i) + 0.37e-4);
            let ratio = law.coefficient(&slip) / law.sliding_coefficient(slip.speed());
            let at_limit = ratio > 1.0 - 1e-12;
            let slides = slip.speed().abs() > law.slip_limit(&slip);
            assert_eq!(slides, at_limit, "{law:?} {slip:?} {ratio}");
        }
    }
}

/// Ground without friction transmits no traction, at any slip, also at none.
#[test]
fn without_friction_there_is_no_traction() {
    for kind in FrictionKind::ALL {
        let ice = FrictionLaw {
            mu_s: 0.0,
            mu_d: 0.0,
            ..FrictionLaw::of(kind)
        };
        for slip in slips(&ice) {
            assert!(ice.coefficient(&slip) == 0.0, "{kind:?} {slip:?}");
        }
    }
}

/// Closed form: the defaults of ADAMS's form at its breakpoints, and the slope at v = 0, 3 mu_s/(2
/// v_s) = 60 s/m.
#[test]
fn the_default_law_passes_through_its_parameters() {
    let law = FrictionLaw::default();
    let at = |v: f64| {
        law.coefficient(&Slip {
            rim: v,
            centre: 0.0,
        })
    };
    for (v, mu) in [
        (0.0, 0.0),
        (0.02, 0.8),
        (0.06, 0.75),
        (0.10, 0.7),
        (2.0, 0.7),
    ] {
        assert!((at(v) - mu).abs() < 1e-15, "mu({v})");
        assert!((at(-v) + mu).abs() < 1e-15, "mu(-{v})");
    }
    assert!((at(1e-8) / 1e-8 - 60.0).abs() < 1e-6);
    assert!((law.steepest_slope() - 60.0).abs() < 1e-12);
}

/// Closed form: `f_r r N` beyond the smoothing (tanh(10) = 1 - 4e-9), zero at standstill, odd,
/// with the slope `f_r r N/FRICTION_SPEED` there.
#[test]
fn the_moment_opposes_the_rolling() {
    let law = FrictionLaw {
        rolling: 0.03,
        ..FrictionLaw::default()
    };
    let moment = |spin| law.rolling_moment(46.0, 0.1, spin);
    for spin in [0.1, 2.0, 50.0] {
        assert!((moment(spin) - 0.138).abs() < 1e-9, "{spin}");
        assert!((moment(-spin) + moment(spin)).abs() < 1e-15);
    }
    assert!(moment(0.0) == 0.0);
    assert!((moment(1e-6) / 1e-6 - 0.138 / FRICTION_SPEED).abs() < 1e-6);
    assert!(FrictionLaw::default().rolling_moment(46.0, 0.1, 2.0) == 0.0);
}
