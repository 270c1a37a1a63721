//! The same scene gives the same bits on any number of threads, and every shipped scene gives the
//! numbers recorded in `golden.txt` beside this file.
//!
//! Bits are compared within one binary only: another compiler, mathematical library or processor
//! may round differently. The golden hashes must not depend on that, so they are hashes of rounded
//! values at a few instants. A difference of 1e-9 N changes about one in 1e6 of the rounded values.
//!
//! Renewal: `ROBHAZ_RENEW_GOLDEN=1 cargo test --release -p robhaz --test robhaz golden` rewrites
//! the file. Do so only if a change was meant to alter numbers (a law, a default, a solver, a step,
//! a shipped scene) and the tests of references, conservation and convergence pass. State the
//! reason in the commit.
//!
//! `stairs direct` was renewed when mass matrix, four-bar and terrain got cheaper formulas with the
//! same values but for rounding: at a corner the last digits decide where a step of the solver
//! ends, within its tolerance.

use crate::support::{root, truth_of};
use fnv::FnvHasher;
use rayon::prelude::*;
use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::Truth;
use std::collections::HashSet;
use std::fmt::Write;
use std::hash::Hasher as _;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Indices of the records that enter a scene's golden hash. At the last one the front wheel has
/// reached the first obstacle.
fn instants(scene: &str) -> [usize; 4] {
    match scene {
        // The bump begins 0.55 m ahead of the front wheel, which reaches it at 4.0 s.
        "cosbump" => [500, 1500, 4500, 5500],
        _ => [500, 1500, 2500, 3500],
    }
}

/// FNV-1a of a text.
fn fnv(text: &str) -> u64 {
    let mut hash = FnvHasher::default();
    hash.write(text.as_bytes());
    hash.finish()
}

/// Every shipped scene with every engine, with a short duration.
fn scenes() -> Vec<Scene> {
    let folder = std::fs::read_dir(root().join("scenes")).unwrap();
    let mut paths: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let both = |path: &PathBuf| {
        EngineKind::ALL.map(|kind| {
            let mut scene = Scene::load(path, &[]).unwrap();
            scene.engine.kind = kind;
            #[expect(clippy::cast_precision_loss, reason = "a count of records")]
            let last = instants(&scene.name)[3] as f64;
            scene.record.duration = last / scene.record.rate;
            scene
        })
    };
    paths.iter().flat_map(both).collect()
}

/// Hash of every hundredth record and the last one as text in which different floats differ, also zeros
/// of both signs. A record follows from the one before: a difference stays.
fn bits(truth: &[Truth]) -> u64 {
    let every: Vec<&Truth> = truth.iter().step_by(100).chain(truth.last()).collect();
    fnv(&format!("{every:?}"))
}

/// The scenes by one thread: bits, and rounded values.
fn alone() -> &'static [(u64, String)] {
    static ALONE: OnceLock<Vec<(u64, String)>> = OnceLock::new();
    let of = |scene: &Scene, truth: &[Truth]| (bits(truth), rounded(scene, truth));
    ALONE.get_or_init(|| run_all(&scenes(), 1, of))
}

/// Runs all scenes on a number of threads and applies `of` to each truth. The results are in the
/// order of the scenes.
fn run_all<T: Send>(
    scenes: &[Scene],
    threads: usize,
    of: impl Fn(&Scene, &[Truth]) -> T + Sync,
) -> Vec<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let run = |scene: &Scene| of(scene, &truth_of(scene).unwrap());
    pool.build()
        .unwrap()
        .install(|| scenes.par_iter().map(run).collect())
}

/// Determinism: one thread and several, more than most machines have cores, give the same bits.
#[test]
fn threads_change_no_bit() {
    let scenes = scenes();
    let together = run_all(&scenes, 8, |_, truth| bits(truth));
    assert_eq!(alone().len(), scenes.len());
    for (scene, ((a, _), b)) in scenes.iter().zip(alone().iter().zip(together)) {
        assert_eq!(*a, b, "{}, {}", scene.name, scene.engine.kind.name());
    }
}

/// Values of a few records, rounded: forces to 1 mN, angles to 10 urad, positions to 10 um.
fn rounded(scene: &Scene, truth: &[Truth]) -> String {
    let mut text = String::new();
    let mut put = |value: f64, unit: f64| {
        // As an integer, -0 equals 0.
        let _ = write!(text, "{} ", (value / unit).round() as i64);
    };
    for i in instants(&scene.name) {
        let t = &truth[i];
        for bar in std::iter::once(&t.body).chain(&t.links) {
            put(bar.position.x, 1e-5);
            put(bar.position.y, 1e-5);
            put(bar.angle, 1e-5);
        }
        for w in &t.wheels {
            put(w.normal_force, 1e-3);
            put(w.traction, 1e-3);
            put(f64::from(w.contacts), 1.0);
        }
        for pin in &t.pins {
            put(pin.force.x, 1e-3);
            put(pin.force.y, 1e-3);
        }
    }
    text
}

/// Golden: the shipped scenes give the recorded numbers, and no two scenes have the same hash with
/// one engine.
#[test]
fn golden_hashes() {
    let path = root().join("tests/golden.txt");
    let scenes = scenes();
    let mut found = String::from(
        "# FNV-1a of rounded values of each shipped scene: see determinism.rs for what is hashed and when this file may be renewed.\n",
    );
    for (scene, (_, text)) in scenes.iter().zip(alone()) {
        let _ = writeln!(
            found,
            "{} {} {:016x}",
            scene.name,
            scene.engine.kind.name(),
            fnv(text)
        );
    }
    // Engine and hash. Of one scene both engines may have the same rounded numbers, as on `flat`.
    let hashes: HashSet<_> = found
        .lines()
        .skip(1)
        .map(|line| line.split_once(' ').map(|(_, rest)| rest))
        .collect();
    assert_eq!(
        hashes.len(),
        scenes.len(),
        "two scenes have the same numbers: one of them ends before its first obstacle\n{found}"
    );
    if std::env::var_os("ROBHAZ_RENEW_GOLDEN").is_some() {
        std::fs::write(&path, &found).unwrap();
        return;
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    let changed: Vec<&str> = found
        .lines()
        .filter(|line| !expected.lines().any(|e| e == *line))
        .collect();
    let gone = expected.lines().count() != found.lines().count();
    assert!(
        changed.is_empty() && !gone,
        "the numbers of these runs are not those of tests/golden.txt:\n{}\n\
         If they were meant to change (a law, a default, a solver, a step, a shipped scene) and the tests of references, conservation \
         and convergence pass, renew the file and say why in the commit:\n\
         ROBHAZ_RENEW_GOLDEN=1 cargo test --release -p robhaz --test robhaz golden\n\
         If no number was meant to change, the change has an error. On another kind of machine one line can \
         differ if a value lies on the border of its rounding.",
        if changed.is_empty() {
            "a scene is missing"
        } else {
            ""
        }
        .to_owned()
            + &changed.join("\n"),
    );
}
