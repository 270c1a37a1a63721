//! Random scenes at the limits of what a robot does: saturated motors, impacts, kerbs higher than a
//! wheel, wheels in the air, friction from ice to twice that of rubber, bodies of 1.5 to 20 kg.
//!
//! Each run goes to its end or stops with a physical reason, on both engines. The engines agree:
//! impulse of the ground and place of the body, as `robhaz verify` asks on edges. Where rapier's
//! step is too long for that, a finer one agrees.

use crate::draws::{grounds, robots};
use crate::support::scene;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rayon::prelude::*;
use robhaz_run::verify::{Run, agreement, impulse_difference};
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::drive::Drive;
use robhaz_sim::friction::FrictionLaw;
use robhaz_sim::{NoTruth, PlantError, StartKind};
use std::collections::BTreeMap;
use std::sync::Mutex;

/// Duration of a run, s.
const SECONDS: f64 = 8.0;
/// Bounds of `robhaz verify`: impulse of the ground on a wheel, of itself; distance of the bodies,
/// m.
const IMPULSE: f64 = 1e-2;
const APART: f64 = 1e-3;
/// Both engines stop within this time, s, where they stop: a robot that turns over takes some
/// tenths of a second.
const SAME_STOP: f64 = 0.05;
/// Finer runs: rapier's step and direct's tolerance times these.
const FINER: [(f64, f64); 2] = [(0.25, 0.1), (0.0625, 0.01)];

/// Uniform in the logarithm.
fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// Drives that saturate, soft and PI, most of them forward, where most obstacles are; up to 3 m/s.
fn drives() -> impl Strategy<Value = Drive> {
    let speed = (log(0.1, 3.0), 0..8_u32).prop_map(|(v, way)| if way == 0 { -v } else { v });
    let gains = (
        log(0.5, 200.0),
        prop_oneof![Just(0.0), log(1.0, 2000.0)],
        log(0.02, 1.0),
    );
    let losses = (0.0..1.0_f64, prop_oneof![Just(0.0), 0.05..1.0_f64]);
    (speed, gains, log(1.0, 30.0), losses, 0.0..0.5_f64).prop_map(
        |(speed, (kp, ki, tracking_time), torque_limit, (b, f), ramp_time)| Drive {
            speed,
            kp,
            ki,
            torque_limit,
            tracking_time,
            viscous_damping: b,
            gear_friction: f,
            start_time: 0.2,
            ramp_time,
            scalings: Vec::new(),
        },
    )
}

/// From ice to twice what rubber holds.
fn frictions() -> impl Strategy<Value = FrictionLaw> {
    (log(0.1, 2.0), 0.5..1.0_f64, log(0.005, 0.05)).prop_map(|(mu_s, ratio, v_s)| FrictionLaw {
        mu_s,
        mu_d: ratio * mu_s,
        v_s,
        v_d: 5.0 * v_s,
        ..FrictionLaw::default()
    })
}

/// A random scene: the same for the same number.
fn random_scene(number: u64) -> Scene {
    let mut seed = [0; 32];
    seed[..8].copy_from_slice(&number.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let switches = any::<(bool, bool)>();
    let all = (
        robots(0.3..4.0),
        grounds(4.0),
        drives(),
        frictions(),
        switches,
    );
    let all = all.prop_filter("a robot on a ground", |((g, m), profile, ..)| {
        g.check().is_ok() && m.check().is_ok() && profile.check().is_ok()
    });
    let ((geometry, mass), profile, drive, friction, (raw, constant)) =
        all.new_tree(&mut runner).unwrap().current();
    let mut scene = scene("flat", &[]);
    scene.robot.robot.geometry = geometry;
    scene.robot.robot.mass = mass;
    scene.terrain.profile = profile;
    scene.record.duration = SECONDS;
    (scene.drive, scene.friction) = (drive, friction);
    if raw {
        scene.engine.start = StartKind::Raw;
    }
    if constant {
        scene.contact.damping_ramp = 0.0;
    }
    scene
}

/// Name of what ended a run.
fn end(run: &Run) -> String {
    let name = match &run.stopped {
        None => "ended".to_owned(),
        Some(PlantError::NoTruth { why, .. }) => format!("{why:?}"),
        Some(why) => format!("{why:?}"),
    };
    name.split([' ', '{']).next().unwrap().to_owned()
}

/// Whether the robot, not the integration, ended a run.
fn is_physical(run: &Run) -> bool {
    matches!(
        run.stopped,
        None | Some(PlantError::NoTruth {
            why: NoTruth::Overturned { .. }
                | NoTruth::OffTheGround { .. }
                | NoTruth::WheelBelowGround { .. }
                | NoTruth::LoopRange,
            ..
        })
    )
}

/// One scene on both engines.
struct Pair {
    runs: [Run; 2],
    /// Up to the end of the shorter run: difference of the wheels' impulses, of themselves;
    /// distance of the bodies, m.
    impulse: f64,
    apart: f64,
}

impl Pair {
    fn new(scene: &Scene, (step, tolerance): (f64, f64)) -> Self {
        let runs = EngineKind::ALL.map(|kind| {
            let mut scene = scene.clone();
            scene.engine.kind = kind;
            scene.engine.step *= step;
            scene.engine.tolerance *= tolerance;
            Run::of(&scene).unwrap()
        });
        let [rapier, direct] = &runs;
        let common = rapier.truth.len().min(direct.truth.len());
        let apart = agreement(&rapier.truth[..common], &direct.truth[..common]).apart;
        let last = common - 1;
        let impulse = impulse_difference(&rapier.balance[last], &direct.balance[last]);
        Self {
            impulse,
            apart,
            runs,
        }
    }

    /// Why the engines disagree.
    fn disagreement(&self) -> Option<String> {
        let [rapier, direct] = &self.runs;
        let time = |run: &Run| run.truth.last().map_or(0.0, |t| t.time);
        let agrees = end(rapier) == end(direct)
            && (time(rapier) - time(direct)).abs() < SAME_STOP
            && self.impulse < IMPULSE
            && self.apart < APART;
        (!agrees).then(|| {
            format!(
                "rapier {} at {:.3} s, direct {} at {:.3} s, impulse {:.1e}, {:.1e} m apart",
                end(rapier),
                time(rapier),
                end(direct),
                time(direct),
                self.impulse,
                self.apart
            )
        })
    }
}

/// What came of random scenes.
#[derive(Debug, Default)]
struct Found {
    /// Runs by engine and end.
    ends: BTreeMap<String, u32>,
    /// Scenes on which the engines agree at their usual steps, and at each of the finer ones.
    agree: [u32; 1 + FINER.len()],
    /// Scenes on which they do not, and why; runs that stopped for no physical reason.
    differ: Vec<String>,
    unphysical: Vec<String>,
    /// Greatest differences where they agree at their usual steps.
    impulse: f64,
    apart: f64,
    /// Runs with a saturated motor in some record, with a wheel in the air.
    saturated: u32,
    in_the_air: u32,
}

impl Found {
    fn look(&mut self, number: u64, scene: &Scene, pair: &Pair) {
        for (kind, run) in EngineKind::ALL.iter().zip(&pair.runs) {
            let name = format!("{} {}", kind.name(), end(run));
            *self.ends.entry(name).or_insert(0) += 1;
            if !is_physical(run) {
                let message = format!("{number}, {}: {:?}", kind.name(), run.stopped);
                self.unphysical.push(message);
            }
            let wheels = || run.truth.iter().flat_map(|t| t.wheels);
            let limit = scene.drive.torque_limit;
            self.saturated += u32::from(wheels().any(|w| w.torque.abs() >= limit));
            self.in_the_air += u32::from(wheels().any(|w| w.contacts == 0));
        }
    }
}

/// Runs scenes on both engines. Where the engines disagree, finer steps and tolerances are tried.
fn study(numbers: &[u64]) -> Found {
    let found = Mutex::new(Found::default());
    numbers.par_iter().for_each(|&number| {
        let scene = random_scene(number);
        let pair = Pair::new(&scene, (1.0, 1.0));
        let mut why = pair.disagreement();
        let mut level = 0;
        let mut reasons = vec![format!("scene {number}")];
        while let (Some(reason), Some(finer)) = (&why, FINER.get(level)) {
            reasons.push(reason.clone());
            why = Pair::new(&scene, *finer).disagreement();
            level += 1;
        }
        let mut found = found.lock().unwrap();
        found.look(number, &scene, &pair);
        match why {
            None => found.agree[level] += 1,
            Some(reason) => {
                reasons.push(reason);
                found.differ.push(reasons.join("; "));
            }
        }
        if level == 0 {
            found.impulse = found.impulse.max(pair.impulse);
            found.apart = found.apart.max(pair.apart);
        }
    });
    found.into_inner().unwrap()
}

/// Property: a small part of the study below.
#[test]
fn random_scenes_end_for_physical_reasons_and_engines_agree() {
    let mut numbers: Vec<u64> = (0..8).collect();
    // 435 has a corner of 1 deg: with two contacts there the law of contact made energy.
    numbers.extend([59, 130, 162, 435, 717]);
    let found = study(&numbers);
    println!("{found:#?}");
    assert!(found.unphysical.is_empty(), "{:?}", found.unphysical);
    assert!(found.differ.is_empty(), "{:?}", found.differ);
    assert!(found.saturated >= 6 && found.in_the_air >= 6);
}

/// The whole study, a minute and a half:
/// `cargo test --release -p robhaz --test robhaz study_of_500 -- --ignored --nocapture`.
/// docs/validation.md states what was found.
#[test]
#[ignore = "a minute and a half"]
fn study_of_500_random_scenes() {
    let found = study(&(0..500).collect::<Vec<_>>());
    println!("{found:#?}");
    assert!(found.unphysical.is_empty(), "{:?}", found.unphysical);
    // One scene in a hundred: a place can depend on an impact so strongly that a sixteenth of the
    // step is not fine enough.
    assert!(found.differ.len() <= 5, "{:?}", found.differ);
}

/// A motor in saturation never stops `direct`: shipped scenes with low torque limits, heavy bodies,
/// high speeds, much friction. The engines agree.
#[test]
fn saturated_motors_do_not_stop_direct() {
    let mut cases = Vec::new();
    for name in ["smooth", "step", "stairs", "ditch", "ramp", "heights"] {
        for limit in [4, 5, 6, 8] {
            cases.push((name, format!("drive.torque_limit={limit}")));
        }
    }
    for (name, change) in [
        ("smooth", "drive.speed=3"),
        ("step", "drive.speed=3"),
        ("smooth", "robot.mass.body=20"),
        ("stairs", "robot.mass.body=20"),
        ("step", "terrain.kerb=0.3"),
        ("stairs", "contact.mu_s=2"),
    ] {
        cases.push((name, change.to_owned()));
    }
    for (name, change) in &cases {
        let keys = [change.as_str(), "engine.kind=direct", "robot.geometry=A"];
        let mut scene = scene(name, &keys);
        let run = Run::of(&scene).unwrap();
        assert!(is_physical(&run), "{name}, {change}: {:?}", run.stopped);
        // Three of those that found no step while the anti-windup was discontinuous; the rest is
        // the study's.
        let compared = [
            ("smooth", "drive.torque_limit=5"),
            ("step", "drive.torque_limit=4"),
            ("stairs", "contact.mu_s=2"),
        ];
        if compared.contains(&(*name, change.as_str())) {
            scene.record.duration = 12.0;
            let why = Pair::new(&scene, (1.0, 1.0)).disagreement();
            assert_eq!(why, None, "{name}, {change}");
        }
    }
}

/// Equivalence: the engines agree at gains just within the limits of `rapier`. Convergence: at the
/// greatest gains `direct` agrees with itself at a tolerance a hundred times smaller.
#[test]
fn high_gains_do_not_chatter() {
    for gains in ["drive.kp=450", "drive.ki=16000"] {
        let [rapier, direct] = EngineKind::ALL.map(|kind| {
            let engine = format!("engine.kind={}", kind.name());
            let scene = scene("smooth", &[gains, &engine, "record.duration=6"]);
            Run::of(&scene).unwrap().truth
        });
        let found = agreement(&rapier, &direct);
        println!("{gains}: {found:?}");
        // The bound of `robhaz verify` on rolling ground; 1.4e-5 was found, 8e-3 at kp = 800.
        assert!(found.normal_force < 1e-3, "{gains}: {found:?}");
    }
    let most = "drive={kp=1e6,ki=1e6}";
    let [usual, exact] = ["engine.tolerance=1e-5", "engine.tolerance=1e-7"].map(|tolerance| {
        let overrides = [most, tolerance, "engine.kind=direct", "record.duration=6"];
        let run = Run::of(&scene("smooth", &overrides)).unwrap();
        assert_eq!(run.stopped, None);
        run.truth
    });
    let (mut torque, mut count) = (0.0, 0.0);
    for (a, b) in usual.iter().zip(&exact).skip(1500) {
        for (a, b) in a.wheels.iter().zip(&b.wheels) {
            torque += (a.torque - b.torque).powi(2);
            count += 1.0;
        }
    }
    let torque = f64::sqrt(torque / count);
    let found = agreement(&usual, &exact);
    println!("greatest gains: {found:?}, torque {torque:.1e} N m RMS");
    // 2e-6 of the mean N and 1e-6 N m were found.
    assert!(
        found.normal_force < 1e-4 && torque < 1e-3,
        "{found:?} {torque}"
    );
}
