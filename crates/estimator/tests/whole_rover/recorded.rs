//! Recorded drives as tables, and the errors of their estimates.

use crate::rover::{open_source_rover, triple_bogie};
use robhaz_estimator::whole::{Joints, WholeEstimate, WholeEstimator, WholeFrame};
use robhaz_estimator::{EstimatorSettings, Health, NoiseBudget};
use robhaz_model::{Vec2, WholeRover};
use std::collections::BTreeMap;
use std::path::Path;

/// A table of numbers by column.
pub struct Table {
    pub names: BTreeMap<String, usize>,
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn read(path: &Path) -> Self {
        Self::of(&std::fs::read_to_string(path).expect("a table"))
    }

    pub fn of(text: &str) -> Self {
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

    pub fn get(&self, row: usize, name: &str) -> Option<f64> {
        Some(self.rows[row][*self.names.get(name)?])
    }

    pub fn wheels(&self, row: usize, quantity: &str) -> [Option<f64>; 6] {
        core::array::from_fn(|i| {
            let side = if i < 3 { "left" } else { "right" };
            self.get(row, &format!("{side}_wheel{}_{quantity}", i % 3 + 1))
        })
    }

    pub fn frame(&self, row: usize) -> WholeFrame {
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
pub fn rover_of(case: &str) -> WholeRover {
    if case.starts_with("triple") {
        WholeRover {
            pivot: Vec2::new(-0.25, 0.12),
            ..triple_bogie(0.12)
        }
    } else {
        open_source_rover()
    }
}

pub fn estimator(rover: &WholeRover) -> WholeEstimator {
    estimator_with(rover, NoiseBudget::typical_for(&rover.side))
}

pub fn estimator_with(rover: &WholeRover, budget: NoiseBudget) -> WholeEstimator {
    let noise = 0.1_f64.to_radians();
    let settings = EstimatorSettings {
        viscous_damping: 0.044,
        budget,
        ..EstimatorSettings::kalman_without_angles()
    };
    WholeEstimator::new(rover, settings, [noise, 0.1_f64.to_radians()]).expect("a rover")
}

/// Errors over a drive.
#[derive(Default)]
pub struct Errors {
    pub samples: f64,
    pub in_plane: f64,
    pub normal: f64,
    pub stated: f64,
    pub within: f64,
    pub normal_within: f64,
    pub normal_stated: f64,
    pub traction: f64,
    pub angle: f64,
    pub load: f64,
    pub nees: f64,
    pub misfit: f64,
    pub alarms: usize,
    pub dragged: usize,
}

impl Errors {
    pub fn add(
        &mut self,
        found: &WholeEstimate,
        steering: [Option<f64>; 6],
        truth: &Table,
        row: usize,
    ) {
        self.samples += 1.0;
        let joints = Joints {
            steering: steering.map(|angle| angle.unwrap_or(0.0)),
            ..Joints::default()
        };
        let planes = joints.inclinations(found.attitude);
        let known = |quantity| {
            truth
                .wheels(row, quantity)
                .map(|value| value.expect("truth"))
        };
        let (in_plane, normal) = (known("in_plane_normal_force"), known("normal_force"));
        let (traction, angle) = (known("traction"), known("contact_angle"));
        let covariance = found.in_plane_covariance();
        for i in 0..6 {
            let n = found.normal_force[i];
            let sigma = covariance[i][i].sqrt();
            let sigma_normal = found.sigma_normal(i).expect("a wheel");
            let (error, of_normal) = (n - in_plane[i], n - normal[i]);
            self.in_plane += error * error / 6.0;
            self.normal += of_normal * of_normal / 6.0;
            self.stated += sigma * sigma / 6.0;
            self.nees += error * error / (sigma * sigma) / 6.0;
            self.within += f64::from(u8::from(error.abs() <= 2.0 * sigma)) / 6.0;
            self.normal_within += f64::from(u8::from(of_normal.abs() <= 2.0 * sigma_normal)) / 6.0;
            self.normal_stated += sigma_normal * sigma_normal / 6.0;
            self.traction += (found.traction[i] - traction[i]).powi(2) / 6.0;
            let of_angle = found.sides[i / 3].contact_angle[i % 3] - planes[i] - angle[i];
            self.angle += of_angle * of_angle / 6.0;
            self.load += normal[i] / 6.0;
        }
        self.misfit += found.misfit;
        self.dragged += usize::from(found.dragged);
        let healthy = |health: Health| health.faulty.is_empty();
        let alarm = found
            .sides
            .iter()
            .any(|side| side.kalman.is_some_and(|k| !healthy(k.health)));
        self.alarms += usize::from(alarm);
    }

    pub fn line(&self) -> String {
        let load = self.load / self.samples;
        let percent = |square: f64| 100.0 * (square / self.samples).sqrt() / load;
        format!(
            "{:5.2} {:5.2} stated {:5.2} {:5.2} | {:5.1} {:5.1} | T {:4.2} N, angle {:4.2} deg, NEES {:.2}, misfit {:.2}, alarms {:.3}, dragged {:.2}",
            percent(self.in_plane),
            percent(self.normal),
            percent(self.stated),
            percent(self.normal_stated),
            100.0 * self.within / self.samples,
            100.0 * self.normal_within / self.samples,
            (self.traction / self.samples).sqrt(),
            (self.angle / self.samples).sqrt().to_degrees(),
            self.nees / self.samples,
            self.misfit / self.samples,
            self.alarms as f64 / self.samples,
            self.dragged as f64 / self.samples,
        )
    }
}

/// Adds those from 2.5 s on: the rover starts before.
pub fn add_errors(errors: &mut Errors, log: &Table, truth: &Table, mut estimator: WholeEstimator) {
    for row in 0..log.rows.len() {
        let frame = log.frame(row);
        let found = estimator.update(&frame);
        if frame.time >= 2.5 {
            let found = found.expect("an estimate");
            errors.add(&found, frame.steering, truth, row);
        }
    }
}
