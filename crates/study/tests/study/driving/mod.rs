//! What shared traction brings: needed friction, slip and energy on rolling ground; steepest ramp
//! and highest kerb.
//!
//! The study behind `docs/measurements/driving.md`:
//! `cargo test --release -p robhaz-study --test study driving::study -- --ignored --nocapture`; its
//! figure:
//! `ROBHAZ_FIGURE=driving.svg cargo test --release -p robhaz-study --test study driving::figure -- --ignored`.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

mod figure;

use rayon::prelude::*;
use robhaz_run::DrivenPlant;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use std::path::Path;

/// A drive by its name and its keys.
type Drive = (&'static str, &'static [&'static str]);

const PI: Drive = ("`speed`, PI", &[]);
const SOFT: Drive = ("`speed`, soft", &["drive.kp=2", "drive.ki=0"]);
const SHARED: Drive = ("`shared`", &["drive.kind=shared"]);
const DRIVES: [Drive; 3] = [PI, SOFT, SHARED];

/// Sensors with realistic errors, no contact angles (the default estimator of a control).
const COMMON: [&str; 2] = ["engine.kind=direct", "sensors.grade=typical"];

fn load(scene: &str, drive: Drive, more: &[String]) -> Scene {
    let top = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let path = Path::new(top).join(format!("{scene}.toml"));
    let keys = COMMON.iter().chain(drive.1).map(|key| (*key).to_owned());
    let overrides: Vec<String> = keys.chain(more.iter().cloned()).collect();
    Scene::load(&path, &overrides).unwrap_or_else(|e| panic!("{scene}: {e}"))
}

/// A course: a shipped scene with keys.
struct Course {
    name: &'static str,
    scene: &'static str,
    keys: &'static [&'static str],
}

const fn course(name: &'static str, scene: &'static str, keys: &'static [&'static str]) -> Course {
    Course { name, scene, keys }
}

/// Rolling ground, edges, other robots, friction, sensors and speeds.
const COURSES: &[Course] = &[
    course("smooth", "smooth", &[]),
    course("rough", "rough", &[]),
    course("sine", "sine", &[]),
    course("heights", "heights", &[]),
    course("cosbump", "cosbump", &[]),
    course("ramp", "ramp", &[]),
    course("course", "course", &[]),
    course("step", "step", &[]),
    course("ditch", "ditch", &[]),
    course("stairs, robot A", "stairs", &["robot.geometry=A"]),
    course(
        "slope down, 20 deg",
        "ramp",
        &["terrain.angle=-20 deg", "terrain.length=3"],
    ),
    course("smooth, robot B", "smooth", &["robot.geometry=B"]),
    course("smooth, poor sensors", "smooth", &["sensors.grade=poor"]),
    course(
        "smooth, 200 Hz",
        "smooth",
        &["sensors.rate=200", "record.rate=200"],
    ),
    course("smooth, brush", "smooth", &["contact.friction=brush"]),
    course(
        "smooth, mu 0.3",
        "smooth",
        &["contact.mu_s=0.3", "contact.mu_d=0.25"],
    ),
    course(
        "smooth, 0.5 m/s",
        "smooth",
        &["drive.speed=0.5", "record.duration=9"],
    ),
    course(
        "smooth, 0.05 m/s",
        "smooth",
        &["drive.speed=0.05", "record.duration=30"],
    ),
    course(
        "smooth, gear friction",
        "smooth",
        &["drive.gear_friction=0.5"],
    ),
    course(
        "sine, backwards",
        "sine",
        &["drive.speed=-0.2", "terrain.start=-5"],
    ),
];

impl Course {
    fn scene(&self, drive_keys: Drive) -> Scene {
        let keys: Vec<String> = self.keys.iter().map(|key| (*key).to_owned()).collect();
        load(self.scene, drive_keys, &keys)
    }
}

/// What one drive shows.
#[derive(Clone, Copy, Debug, Default)]
struct Trip {
    /// Largest |T|/N of a loaded wheel.
    needed: f64,
    /// The same at the last sample.
    needed_now: f64,
    /// Distance that the rims slipped, sum of the three wheels, m.
    slip: f64,
    /// Work of the motors where they drive; braking gives nothing back, J.
    energy: f64,
    /// Travel of the middle wheel, m.
    travel: f64,
}

impl Trip {
    /// Adds a sample of `dt` (s). Wheels with less than a twentieth of the mean load count as
    /// unloaded, as for the estimator.
    fn add(&mut self, truth: &Truth, least_load: f64, dt: f64) {
        self.needed_now = 0.0;
        for wheel in &truth.wheels {
            self.energy += dt * (wheel.torque * wheel.omega).max(0.0);
            if wheel.contacts > 0 {
                self.slip += dt * wheel.slip_speed.abs();
            }
            if wheel.normal_force > least_load {
                let ratio = wheel.traction.abs() / wheel.normal_force;
                self.needed_now = self.needed_now.max(ratio);
            }
        }
        self.needed = self.needed.max(self.needed_now);
        self.travel = truth.wheels[1].position.x;
    }
}

/// Drives a scene until its end, until the middle wheel reaches `goal` (m), or until the robot has
/// not come 5 mm closer to it in 3 s. A robot that overturns has not reached it.
fn drive(scene: &Scene, goal: f64) -> Trip {
    followed(scene, goal, &mut |_| {})
}

/// As [`drive`], with a look at the trip after every sample.
fn followed(scene: &Scene, goal: f64, look: &mut dyn FnMut(&Trip)) -> Trip {
    let dt = 1.0 / scene.sensors.rate;
    let least_load = 0.05 * scene.robot.robot.mean_wheel_load();
    let mut plant = DrivenPlant::new(scene, &scene.plant_setup()).unwrap();
    let (mut trip, mut best, mut since) = (Trip::default(), f64::NEG_INFINITY, 0.0);
    while let Ok(truth) = plant.next_truth() {
        trip.add(&truth, least_load, dt);
        look(&trip);
        if trip.travel > best + 0.005 {
            (best, since) = (trip.travel, truth.time);
        }
        let stuck = goal.is_finite() && truth.time > since.max(scene.drive.start_time) + 3.0;
        if trip.travel >= goal || stuck || truth.time >= scene.record.duration {
            break;
        }
    }
    trip
}

/// The largest value between `low` and `high` at which the robot reaches the goal, to `width`;
/// `low` if it never does.
fn largest(low: f64, high: f64, width: f64, reaches: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (low, high);
    while high - low > width {
        let middle = 0.5 * (low + high);
        if reaches(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// mu_s, and mu_d at the ratio of the default law.
fn ground(mu: f64) -> [String; 2] {
    [
        format!("contact.mu_s={mu}"),
        format!("contact.mu_d={}", 0.875 * mu),
    ]
}

/// Climbs a long ramp of an angle (deg): the goal is 0.7 m beyond its foot, with all wheels on the
/// incline.
fn climbs_ramp(drive_keys: Drive, mu: f64, degrees: f64) -> bool {
    let keys = [
        format!("terrain.angle={degrees} deg"),
        "terrain.length=3".to_owned(),
        "record.duration=30".to_owned(),
    ];
    let keys: Vec<String> = keys.into_iter().chain(ground(mu)).collect();
    drive(&load("ramp", drive_keys, &keys), 1.4).travel >= 1.4
}

/// Steepest ramp that is climbed, deg.
fn steepest_ramp(drive_keys: Drive, mu: f64) -> f64 {
    largest(0.0, 44.0, 0.25, |a| climbs_ramp(drive_keys, mu, a.max(0.1)))
}

/// Climbs a kerb (mm) with all wheels.
fn climbs_kerb(drive_keys: Drive, mu: f64, millimetres: f64) -> bool {
    let keys = [
        format!("terrain.kerb={millimetres} mm"),
        "record.duration=30".to_owned(),
    ];
    let keys: Vec<String> = keys.into_iter().chain(ground(mu)).collect();
    drive(&load("step", drive_keys, &keys), 1.2).travel >= 1.2
}

/// Acceptance: on the main scene, with typical sensors and without contact angles, shared traction
/// needs at most half of the friction of the PI drive and slips at most half as far.
#[test]
fn shared_traction_halves_needed_friction_and_slip() {
    let [pi, shared] = [PI, SHARED].map(|drive_keys| {
        let trip = drive(&load("smooth", drive_keys, &[]), f64::INFINITY);
        println!("{}: {trip:?}", drive_keys.0);
        trip
    });
    assert!(shared.needed <= 0.5 * pi.needed, "{shared:?} {pi:?}");
    assert!(shared.slip <= 0.5 * pi.slip, "{shared:?} {pi:?}");
    // It still drives: 20 s at 0.2 m/s from 1.1 s on are 3.78 m along the ground.
    assert!(shared.travel > 3.4, "{shared:?}");
}

/// Acceptance: shared traction climbs every ramp up to a share of the friction angle, not only some
/// of them.
#[test]
fn shared_traction_climbs_up_to_the_friction_angle() {
    let shares: Vec<f64> = match std::env::var("ROBHAZ_SHARES") {
        Ok(text) => text.split(',').map(|t| t.parse().unwrap()).collect(),
        Err(_) => vec![0.6, 0.8, 0.9, 0.95],
    };
    let cases: Vec<(f64, f64)> = [0.3, 0.5, 0.8]
        .into_iter()
        .flat_map(|mu: f64| {
            shares
                .iter()
                .map(move |share| (mu, share * mu.atan().to_degrees()))
        })
        .collect();
    let failed: Vec<&(f64, f64)> = cases
        .par_iter()
        .filter(|(mu, degrees)| !climbs_ramp(SHARED, *mu, *degrees))
        .collect();
    assert!(failed.is_empty(), "mu, degrees: {failed:?}");
}

/// Determinism and equivalence: two runs of the loop have the same bits.
#[test]
fn a_closed_loop_repeats_to_the_bit() {
    for engine in ["engine.kind=direct", "engine.kind=rapier"] {
        let keys = [engine.to_owned(), "record.duration=4".to_owned()];
        let scene = load("smooth", SHARED, &keys);
        let run = || {
            let mut plant = DrivenPlant::new(&scene, &scene.plant_setup()).unwrap();
            let truth: Vec<Truth> = (0..4000).map_while(|_| plant.next_truth().ok()).collect();
            truth
        };
        let (first, second) = (run(), run());
        assert_eq!(first.len(), 4000);
        assert!(first == second, "{engine}");
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_rolling() {
    println!("| ground | drive | largest T/N | slip, m | motor energy, J | travel, m |");
    println!("|---|---|---|---|---|---|");
    let cases: Vec<(&Course, Drive)> = COURSES
        .iter()
        .flat_map(|course| DRIVES.map(|drive_keys| (course, drive_keys)))
        .collect();
    let rows: Vec<Trip> = cases
        .par_iter()
        .map(|(course, drive_keys)| drive(&course.scene(*drive_keys), f64::INFINITY))
        .collect();
    for ((course, drive_keys), trip) in cases.iter().zip(rows) {
        println!(
            "| {} | {} | {:.2} | {:.3} | {:.1} | {:.2} |",
            course.name, drive_keys.0, trip.needed, trip.slip, trip.energy, trip.travel
        );
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_climbing() {
    println!("| mu | drive | steepest ramp, deg | highest kerb, mm |");
    println!("|---|---|---|---|");
    let cases: Vec<(f64, Drive)> = [0.3, 0.5, 0.8]
        .into_iter()
        .flat_map(|mu| DRIVES.map(|drive_keys| (mu, drive_keys)))
        .collect();
    let rows: Vec<(f64, f64)> = cases
        .par_iter()
        .map(|(mu, drive_keys)| {
            let ramp = largest(0.0, 44.0, 0.25, |a| {
                climbs_ramp(*drive_keys, *mu, a.max(0.1))
            });
            let kerb = largest(0.0, 160.0, 2.0, |h| {
                climbs_kerb(*drive_keys, *mu, h.max(1.0))
            });
            (ramp, kerb)
        })
        .collect();
    for ((mu, drive_keys), (ramp, kerb)) in cases.iter().zip(rows) {
        println!("| {mu} | {} | {ramp:.1} | {kerb:.0} |", drive_keys.0);
    }
}
