//! The estimator of a whole rover on drives of a rover in MuJoCo, readings with the errors of
//! typical sensors:
//!
//! `python examples/mujoco/simulate_rover.py --seed 1 2 3 --out FOLDER`, then
//! `WHOLE_ROVER_LOGS=FOLDER cargo test --release -p robhaz-estimator --test whole_rover drives --
//! --ignored --nocapture`

use crate::rover::{open_source_rover, triple_bogie};
use robhaz_estimator::whole::{WholeEstimate, WholeEstimator, WholeFrame};
use robhaz_estimator::{EstimatorSettings, Health, NoiseBudget};
use robhaz_model::{Units, Vec2, WholeRover};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A table of numbers by column.
struct Table {
    names: BTreeMap<String, usize>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a table");
        let mut lines = text.lines();
        let header = lines
            .next()
            .expect("a header")
            .split(',')
            .map(str::to_owned);
        Self {
            names: header.enumerate().map(|(k, name)| (name, k)).collect(),
            rows: lines
                .map(|line| {
                    line.split(',')
                        .map(|x| x.parse().expect("a number"))
                        .collect()
                })
                .collect(),
        }
    }

    fn get(&self, row: usize, name: &str) -> Option<f64> {
        Some(self.rows[row][*self.names.get(name)?])
    }

    fn wheels(&self, row: usize, quantity: &str) -> [Option<f64>; 6] {
        core::array::from_fn(|i| {
            let side = if i < 3 { "left" } else { "right" };
            self.get(row, &format!("{side}_wheel{}_{quantity}", i % 3 + 1))
        })
    }

    fn frame(&self, row: usize) -> WholeFrame {
        let one = |name: &str| self.get(row, name);
        WholeFrame {
            time: one("time").expect("a time"),
            wheel_angle: self.wheels(row, "angle"),
            motor_torque: self.wheels(row, "motor_torque"),
            steering: self.wheels(row, "steering"),
            pins: [one("left_pin_angle"), one("right_pin_angle")],
            coupling: one("differential_angle").or(one("rear_bogie_angle")),
            inclination: one("body_inclination"),
            roll: one("body_roll"),
            rates: [
                one("body_roll_rate"),
                one("body_rate"),
                one("body_yaw_rate"),
            ],
        }
    }
}

/// The rover of a case of `simulate_rover.py`.
fn rover_of(case: &str) -> WholeRover {
    if case.starts_with("triple") {
        WholeRover {
            pivot: Vec2::new(-0.25, 0.12),
            ..triple_bogie(0.12)
        }
    } else {
        open_source_rover()
    }
}

fn estimator(rover: &WholeRover) -> WholeEstimator {
    let noise = 0.1_f64.to_radians();
    let torque = Units::of(&rover.side).torque();
    let typical = NoiseBudget::typical();
    let budget = NoiseBudget {
        torque_noise: typical.torque_noise * torque,
        torque_offset: typical.torque_offset * torque,
        gear_friction: typical.gear_friction * torque,
        ..typical
    };
    let settings = EstimatorSettings {
        viscous_damping: 0.044,
        budget,
        ..EstimatorSettings::kalman_without_angles()
    };
    WholeEstimator::new(rover, settings, [noise, 0.1_f64.to_radians()]).expect("a rover")
}

/// Errors over a drive.
#[derive(Default)]
struct Errors {
    samples: f64,
    in_plane: f64,
    normal: f64,
    stated: f64,
    within: f64,
    normal_within: f64,
    traction: f64,
    angle: f64,
    load: f64,
    nees: f64,
    misfit: f64,
    alarms: usize,
}

impl Errors {
    fn add(&mut self, found: &WholeEstimate, truth: &Table, row: usize) {
        self.samples += 1.0;
        let known = |quantity| {
            truth
                .wheels(row, quantity)
                .map(|value| value.expect("truth"))
        };
        let (in_plane, normal) = (known("in_plane_normal_force"), known("normal_force"));
        let (traction, angle) = (known("traction"), known("contact_angle"));
        for i in 0..6 {
            let n = found.normal_force[i];
            let sigma = found.sigma_normal(i).expect("a wheel");
            let (error, of_normal) = (n - in_plane[i], n - normal[i]);
            self.in_plane += error * error / 6.0;
            self.normal += of_normal * of_normal / 6.0;
            self.stated += sigma * sigma / 6.0;
            self.nees += error * error / (sigma * sigma) / 6.0;
            self.within += f64::from(u8::from(error.abs() <= 2.0 * sigma)) / 6.0;
            self.normal_within += f64::from(u8::from(of_normal.abs() <= 2.0 * sigma)) / 6.0;
            self.traction += (found.traction[i] - traction[i]).powi(2) / 6.0;
            let of_angle = found.sides[i / 3].contact_angle[i % 3] - found.attitude[0] - angle[i];
            self.angle += of_angle * of_angle / 6.0;
            self.load += normal[i] / 6.0;
        }
        self.misfit += found.misfit;
        let healthy = |health: Health| health.faulty.is_empty();
        let alarm = found
            .sides
            .iter()
            .any(|side| side.kalman.is_some_and(|k| !healthy(k.health)));
        self.alarms += usize::from(alarm);
    }

    fn line(&self) -> String {
        let load = self.load / self.samples;
        let percent = |square: f64| 100.0 * (square / self.samples).sqrt() / load;
        format!(
            "{:5.2} {:5.2} {:5.2} | {:5.1} {:5.1} | T {:4.2} N, angle {:4.2} deg, NEES {:.2}, misfit {:.2}, alarms {:.3}",
            percent(self.in_plane),
            percent(self.normal),
            percent(self.stated),
            100.0 * self.within / self.samples,
            100.0 * self.normal_within / self.samples,
            (self.traction / self.samples).sqrt(),
            (self.angle / self.samples).sqrt().to_degrees(),
            self.nees / self.samples,
            self.misfit / self.samples,
            self.alarms as f64 / self.samples,
        )
    }
}

/// From 2 s on, where the rover starts.
fn errors(log: &Table, truth: &Table, rover: &WholeRover) -> Errors {
    let mut estimator = estimator(rover);
    let mut errors = Errors::default();
    for row in 0..log.rows.len() {
        let frame = log.frame(row);
        let found = estimator.update(&frame);
        if frame.time >= 2.5 {
            errors.add(&found.expect("an estimate"), truth, row);
        }
    }
    errors
}

/// Prints, for each log of the folder: error of N in the wheel's plane, of N along the ground's
/// normal, stated deviation (% of the mean load); share within two stated deviations of both.
#[test]
#[ignore = "needs logs of another simulator"]
fn study() {
    let folder = PathBuf::from(std::env::var("WHOLE_ROVER_LOGS").expect("WHOLE_ROVER_LOGS"));
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    for path in paths {
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if let Some((case, seed)) = name.split_once("-log-") {
            let truth = Table::read(&folder.join(format!("{case}.csv")));
            let found = errors(&Table::read(&path), &truth, &rover_of(case));
            println!("{case:16} {seed} {}", found.line());
        }
    }
}
