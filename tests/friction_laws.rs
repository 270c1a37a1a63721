//! The friction laws, rolling resistance and wheels that are driven apart, in whole runs.
//! `friction/tests.rs` of the simulator sweeps the laws themselves.

use crate::support::{scene, truth_of};
use robhaz_run::verify::{Run, agreement, energy, momentum_error, verify};
use robhaz_scene::{EngineKind, Scene};
use robhaz_score::ProgressMeter;
use robhaz_sim::friction::{FrictionKind, FrictionLaw};
use robhaz_sim::{Plant, Truth, WheelTruth};

/// The laws in the engines that take them.
const LAWS: [(&str, &[&str]); 9] = [
    ("direct", &["contact.friction=adams"]),
    (
        "direct",
        &["contact.friction=brush", "contact.slip_stiffness=5"],
    ),
    ("direct", &["contact.friction=brush"]),
    (
        "direct",
        &["contact.friction=brush", "contact.slip_stiffness=50"],
    ),
    ("direct", &["contact.friction=rigid"]),
    (
        "direct",
        &["contact.friction=rigid", "contact.v_s=0.2 mm/s"],
    ),
    ("rapier", &["contact.friction=adams"]),
    (
        "rapier",
        &["contact.friction=brush", "contact.slip_stiffness=5"],
    ),
    // The stiffest that rapier takes at its default step: it cuts every step.
    (
        "rapier",
        &["contact.friction=brush", "contact.slip_stiffness=17"],
    ),
];

/// No law is left out.
#[test]
fn every_law_is_listed() {
    for kind in FrictionKind::ALL {
        let name = format!("contact.friction={}", kind.name());
        assert!(LAWS.iter().any(|(_, law)| law[0] == name), "{name}");
    }
}

fn with(name: &str, engine: &str, law: &[&str], more: &[&str]) -> Scene {
    let engine = format!("engine.kind={engine}");
    let mut sets = vec![engine.as_str()];
    sets.extend(law);
    sets.extend(more);
    scene(name, &sets)
}

/// Slip speed (m/s) of a gripping contact with the ratio `T/N` at the speed `u` of a rim that is
/// faster than the wheel's centre: the laws solved for the slip. In ADAMS's form
/// `mu_s (3 x - x^3)/2 = T/N` has the root `x = 2 sin(asin(T/(mu_s N))/3)`; the brush model's is
/// `a = 1 - cbrt(1 - T/(mu_s N))`.
fn slip_speed(law: &FrictionLaw, ratio: f64, u: f64) -> f64 {
    let share = ratio / law.mu_s;
    match law.kind {
        FrictionKind::Adams | FrictionKind::Rigid => 2.0 * (share.asin() / 3.0).sin() * law.v_s,
        FrictionKind::Brush => {
            let kappa = 3.0 * law.mu_s / law.slip_stiffness * (1.0 - (1.0 - share).cbrt());
            kappa * u
        }
    }
}

/// Closed form: the robot climbs a slope of 10 deg under the low-gain drive. At constant speed a
/// wheel's traction follows from its torque, `d T = tau - B omega - f_r r N`, with the arm d = r -
/// g and the set speed in tau; the tractions carry the weight along the slope, and the slip speed
/// of each wheel is that of its law at T/N.
#[test]
fn a_climbing_wheel_slips_as_its_law_says() {
    let angle = 10.0_f64.to_radians();
    let points = [[-5.0, -5.0 * angle.tan()], [5.0, 5.0 * angle.tan()]];
    let points = format!("terrain.points={points:?}");
    for (engine, law) in LAWS {
        for rolling in [
            "contact.rolling_resistance=0",
            "contact.rolling_resistance=0.03",
        ] {
            let more = [
                "terrain.kind=heights",
                "terrain.interpolation=corners",
                points.as_str(),
                "drive.kp=2",
                "drive.ki=0",
                "record.duration=4",
                rolling,
            ];
            let scene = with("flat", engine, law, &more);
            let truth = truth_of(&scene).unwrap();
            let last = truth.last().unwrap();
            let (drive, r) = (&scene.drive, scene.robot.robot.geometry.wheel_radius);
            let (mut worst_t, mut worst_slip, mut sum) = (0.0_f64, 0.0_f64, 0.0);
            for w in &last.wheels {
                let d = r - w.penetration;
                let torque =
                    drive.kp * (drive.speed / r - w.omega) - drive.viscous_damping * w.omega;
                let rolling = scene.friction.rolling * r * w.normal_force;
                worst_t = worst_t.max((w.traction - (torque - rolling) / d).abs());
                let expected =
                    slip_speed(&scene.friction, w.traction / w.normal_force, w.omega * d);
                worst_slip = worst_slip.max((w.slip_speed / expected - 1.0).abs());
                sum += w.traction;
            }
            let weight = 14.0 * robhaz_model::GRAVITY * angle.sin();
            println!(
                "{engine} {law:?} {rolling}: T off by {worst_t:.1e} N, slip {:.4e} m/s off by {worst_slip:.1e} of itself, \
                 sum of T off by {:.1e} N",
                last.wheels[0].slip_speed,
                sum - weight
            );
            assert!(worst_t < 1e-4, "{engine} {law:?}: {worst_t}");
            assert!(worst_slip < 1e-6, "{engine} {law:?}: {worst_slip}");
            assert!(
                (sum - weight).abs() < 1e-3,
                "{engine} {law:?}: {sum} {weight}"
            );
        }
    }
}

/// Closed form: at constant speed on level ground the tractions add up to zero and the motors give
/// `B omega + f_r r N + d T` at each wheel, together 3 B omega + f_r r W.
#[test]
fn rolling_resistance_costs_its_torque() {
    for engine in EngineKind::ALL {
        let sets = ["contact.rolling_resistance=0.03", "record.duration=6"];
        let scene = with("flat", engine.name(), &[], &sets);
        let truth = truth_of(&scene).unwrap();
        let last = truth.last().unwrap();
        let r = scene.robot.robot.geometry.wheel_radius;
        let expected = |w: &WheelTruth| {
            let damping = scene.drive.viscous_damping * w.omega;
            damping + 0.03 * r * w.normal_force + (r - w.penetration) * w.traction
        };
        let sum = |value: &dyn Fn(&WheelTruth) -> f64| last.wheels.iter().map(value).sum::<f64>();
        let worst = last
            .wheels
            .iter()
            .map(|w| (w.torque - expected(w)).abs())
            .fold(0.0, f64::max);
        let traction = sum(&|w| w.traction);
        let (torque, all) = (
            sum(&|w| w.torque),
            3.0 * 0.15 * 2.0 + 0.03 * 0.1 * 14.0 * 9.81,
        );
        println!(
            "{}: torque off by {worst:.1e} N m, in all {torque:.6} for {all:.6}, sum of T {traction:.1e} N",
            engine.name()
        );
        assert!(worst < 1e-5 && traction.abs() < 1e-3);
        // The arms differ by 0.02 mm, and with them the moments of tractions that cancel.
        assert!((torque - all).abs() < 1e-3, "{torque} {all}");
    }
}

/// Conservation: with rolling resistance energy and momentum balance, and without its loss they do
/// not: 0.02 of the weight over the way is 7 J.
#[test]
fn the_balance_contains_rolling_resistance() {
    let runs = EngineKind::ALL.map(|engine| {
        let sets = ["contact.rolling_resistance=0.02", "record.duration=8"];
        let scene = with("smooth", engine.name(), &[], &sets);
        let robot = &scene.robot.robot;
        let mut run = Run::of(&scene).unwrap();
        let found = energy(robot, &run.truth, &run.balance);
        let momentum = momentum_error(robot, &run.truth, &run.balance);
        println!(
            "{}: {found:.4?}, left {:.1e}, momentum {momentum:.1e}",
            engine.name(),
            found.relative_error
        );
        assert!(found.relative_error < 1e-4 && momentum < 1e-6);
        let lost: f64 = run
            .truth
            .windows(2)
            .map(|pair| {
                let power = |t: &Truth| {
                    t.wheels
                        .iter()
                        .map(|w| 0.02 * 0.1 * w.normal_force * w.omega.abs())
                        .sum::<f64>()
                };
                0.5e-3 * (power(&pair[0]) + power(&pair[1]))
            })
            .sum();
        assert!(lost > 3.0, "{lost}");
        run.balance.last_mut().unwrap().ground_work += lost;
        assert!(energy(robot, &run.truth, &run.balance).relative_error > 0.1);
        run.truth
    });
    let apart = agreement(&runs[0], &runs[1]);
    assert!(apart.normal_force < 1e-3 && apart.apart < 1e-3, "{apart:?}");
}

/// Closed form: on level ground with mu = 0.5 the front wheel is driven 1.5 times as fast as the
/// others for ten seconds. It slides with T = mu_d N all that time, the others carry the opposite
/// traction, and the robot keeps its speed. The run counts as travelling, and no wheel as spinning:
/// the slip is asked for. Afterwards all wheels grip.
#[test]
fn a_wheel_driven_apart_slides() {
    let apart = "drive.scaling=[{wheels=[1],from=6,to=16,factor=1.5}]";
    // The next test has the other laws, for a shorter time.
    for (engine, law) in LAWS.into_iter().filter(|(_, law)| law.len() == 1) {
        let more = [
            "contact.mu_s=0.5",
            "contact.mu_d=0.5",
            apart,
            "record.duration=18",
        ];
        let scene = with("flat", engine, law, &more);
        let run = Run::of(&scene).unwrap();
        assert_eq!(run.stopped, None);
        let mut meter = ProgressMeter::new(&scene.drive, 0.1);
        let mut most = 0.0_f64;
        for t in &run.truth {
            meter.add(t);
            if (7.0..=16.0).contains(&t.time) {
                let front = &t.wheels[0];
                most = most.max((front.traction / front.normal_force - 0.5).abs());
                assert!(
                    front.slip_speed > 0.09,
                    "{engine} {law:?}: {}",
                    front.slip_speed
                );
            }
        }
        let last = run.truth.last().unwrap();
        let left = energy(&scene.robot.robot, &run.truth, &run.balance).relative_error;
        let found = meter.progress();
        println!("{engine} {law:?}: T/N off by {most:.1e}, energy {left:.1e}, {found:?}");
        // Rounding: the law is constant there.
        assert!(most < 1e-12, "{engine} {law:?}: {most}");
        assert!(left < 1e-4, "{engine} {law:?}: {left}");
        assert_eq!(
            (found.stuck_since, found.spinning),
            (None, [0.0; 3]),
            "{engine} {law:?}"
        );
        // The front wheel pulls with 0.5 N against the others, which creep by 3 mm/s with `adams`;
        // the arm r - g instead of r costs 0.6 %.
        let share = found.distance / found.asked;
        assert!((share - 1.0).abs() < 0.02, "{engine} {law:?}: {share}");
        for w in &last.wheels {
            assert!(w.slip_speed.abs() < w.slip_limit, "{engine} {law:?}: {w:?}");
        }
    }
}

/// Equivalence: with mu that falls from 0.6 to 0.5 the sliding wheel of the law `brush` has the
/// traction of `adams`, since both take mu from the slip speed, and the engines agree.
#[test]
fn sliding_wheels_have_the_same_traction_under_every_law() {
    let more = [
        "contact.mu_s=0.6",
        "contact.mu_d=0.5",
        "contact.v_d=5 cm/s",
        "drive.scaling=[{wheels=[1],from=3,to=5,factor=1.5}]",
        "record.duration=5",
    ];
    for (engine, law) in LAWS {
        let truth = truth_of(&with("flat", engine, law, &more)).unwrap();
        for t in truth.iter().filter(|t| t.time > 4.0) {
            let front = &t.wheels[0];
            let ratio = front.traction / front.normal_force;
            assert!((ratio - 0.5).abs() < 1e-12, "{engine} {law:?}: {ratio}");
        }
    }
}

/// Closed form: with all set speeds reversed the robot comes back, and with one wheel locked it
/// goes on and drags this wheel. Neither counts as stuck; a robot that is held while it is asked to
/// come back does.
#[test]
fn reversed_and_locked_wheels_are_no_trouble() {
    for engine in EngineKind::ALL {
        let reverse = "drive.scaling=[{wheels=[1,2,3],from=6,to=12,factor=-1}]";
        let scene = with("flat", engine.name(), &[], &[reverse, "record.duration=14"]);
        let truth = truth_of(&scene).unwrap();
        let mut meter = ProgressMeter::new(&scene.drive, 0.1);
        truth.iter().for_each(|t| meter.add(t));
        let found = meter.progress();
        // Forward for half of the start's ramp and 4.6 s, back for 5.4 s, forward for 1.4 s. The
        // changes cancel.
        let expected = 0.2 * (0.3 + 4.6 - 5.4 + 1.4);
        println!("{}: {found:?}", engine.name());
        assert!((found.asked - expected).abs() < 1e-4, "{found:?}");
        // The arm is r - g instead of r: 0.6 % of the difference, and the body moves on its links.
        assert!((found.distance - found.asked).abs() < 4e-3, "{found:?}");
        assert_eq!((found.stuck_since, found.spinning), (None, [0.0; 3]));

        let locked = "drive.scaling=[{wheels=[3],from=3,to=9,factor=0}]";
        let scene = with("flat", engine.name(), &[], &[locked, "record.duration=8"]);
        let truth = truth_of(&scene).unwrap();
        let last = truth.last().unwrap();
        let rear = &last.wheels[2];
        assert!(rear.omega.abs() < 1e-3, "{}", rear.omega);
        // mu_d = 0.7 from a slip speed of 0.1 m/s on.
        assert!((rear.traction / rear.normal_force + 0.7).abs() < 1e-12);
        let mut meter = ProgressMeter::new(&scene.drive, 0.1);
        truth.iter().for_each(|t| meter.add(t));
        let found = meter.progress();
        assert_eq!((found.stuck_since, found.spinning), (None, [0.0; 3]));
    }
}

/// Truth of a scene and the mean step of its engine, s.
fn truth_and_step(scene: &Scene) -> (Vec<Truth>, f64) {
    let mut plant = Plant::new(&scene.plant_setup()).unwrap();
    let records = 0..scene.record.count();
    let truth = records.map(|_| *plant.next_truth().unwrap()).collect();
    (truth, plant.mean_step())
}

/// Accuracy: stiff laws cost direct neither accuracy nor many steps, on the smooth course under the
/// PI drive. The reference has a thousandth of the tolerance.
#[test]
fn stiff_laws_are_exact_in_direct() {
    for (engine, law) in LAWS.into_iter().filter(|(engine, _)| *engine == "direct") {
        let run = |tolerance: &str| {
            let more = [tolerance, "record.duration=8"];
            truth_and_step(&with("smooth", engine, law, &more))
        };
        let (truth, step) = run("engine.tolerance=1e-5");
        let (exact, _) = run("engine.tolerance=1e-8");
        let rms = |force: fn(&WheelTruth) -> f64| {
            let pairs = truth.iter().zip(&exact);
            let errors = pairs.flat_map(|(a, b)| {
                [0, 1, 2].map(|i| (force(&a.wheels[i]) - force(&b.wheels[i])).powi(2))
            });
            (errors.sum::<f64>() / (3.0 * truth.len() as f64)).sqrt()
        };
        let (n, t) = (rms(|w| w.normal_force), rms(|w| w.traction));
        println!(
            "{law:?}: mean step {:.2} ms, error of N {n:.1e}, of T {t:.1e} N RMS",
            1e3 * step
        );
        // Five times the largest measured errors, 0.2 and 0.6 mN; half the shortest mean step, 29
        // ms.
        assert!(n < 1e-3 && t < 3e-3, "{law:?}: {n} {t}");
        assert!(step > 15e-3, "{law:?}: {step}");
    }
}

/// Acceptance: `robhaz verify` passes scenes of every law with rolling resistance and a wheel
/// driven apart. A law that is too stiff for rapier is judged by direct alone.
#[test]
fn every_law_verifies() {
    let more = [
        "contact.rolling_resistance=0.02",
        "drive.scaling=[{wheels=[1],from=2,to=4,factor=1.5}]",
        "record.duration=6",
    ];
    for (law, stiff) in [
        (
            ["contact.friction=brush", "contact.slip_stiffness=5"],
            false,
        ),
        (
            ["contact.friction=brush", "contact.slip_stiffness=50"],
            true,
        ),
        (["contact.friction=rigid", "contact.v_s=0.2 mm/s"], true),
    ] {
        let verdicts = verify(&with("smooth", "direct", &law, &more), &mut |_| (), &|| {
            None
        })
        .unwrap();
        for verdict in &verdicts {
            println!("{law:?}: {verdict:?}");
            let expected = if stiff && verdict.check == "rapier: all checks" {
                None
            } else {
                Some(true)
            };
            assert_eq!(verdict.passed, expected, "{law:?}: {verdict:?}");
        }
        assert_eq!(verdicts.len(), if stiff { 10 } else { 19 });
    }
}
