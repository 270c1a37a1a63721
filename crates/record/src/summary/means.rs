//! Means of the forces of one estimator of a recorded log, and flags of its records.

use robhaz_estimator::{Estimate, Flags};
use robhaz_score::{estimated_needed_friction, has_forces};
use serde::{Deserialize, Serialize};

/// Means of one estimator's forces, of records that count: without those that are out of range,
/// whose forces no weight and no impact explains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanForces {
    /// Mean N of each wheel, N.
    pub normal_force: [f64; 3],
    /// Mean T of each wheel, N.
    pub traction: [f64; 3],
    /// RMS of the stated standard deviation of N of each wheel, N. `None` if the estimator states
    /// none.
    pub normal_force_sigma: Option<[f64; 3]>,
    /// The same of T of each wheel, N.
    pub traction_sigma: Option<[f64; 3]>,
    /// Mean needed friction T/N of each wheel, -; `None` for a wheel without load.
    pub needed_friction: [Option<f64>; 3],
    /// Largest size of the needed friction of each wheel, -.
    pub largest_needed_friction: [Option<f64>; 3],
    /// RMS of the parity residual over its expected standard deviation: 1 if the noise budget is
    /// right. `None` if the estimator expects none.
    pub parity: Option<f64>,
    /// Records with an estimate: those of which the numbers below are a part.
    pub records: u64,
    /// How many of them have a flag.
    #[serde(flatten)]
    pub flags: FlagCounts,
}

/// Numbers of records with a flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlagCounts {
    /// Records with a wheel without load.
    pub unloaded: u64,
    /// Records with the linkage at an end stop.
    pub at_stop: u64,
    /// Records with a reading that is missing, or jumps.
    pub reading_missing: u64,
    /// Records with a reading that has been missing for long, or with a new start of the filters.
    pub reading_stale: u64,
    /// Records with a reading beyond what the robot can do.
    pub reading_absurd: u64,
    /// Records with a parity residual beyond five standard deviations, or a force beyond five times
    /// the weight. They are not in the means.
    pub out_of_range: u64,
}

impl MeanForces {
    /// Share of the records with an estimate.
    pub(crate) fn share(&self, count: u64) -> f64 {
        // Counts of records.
        count as f64 / self.records.max(1) as f64
    }
}

/// Sums over the records of one estimator that count.
#[derive(Clone, Debug, Default)]
pub(super) struct ForceSums {
    /// Records with an estimate.
    pub samples: u64,
    /// Records without one.
    pub missing: u64,
    /// Records whose forces are in the means.
    averaged: u64,
    normal_force: [f64; 3],
    traction: [f64; 3],
    /// Of N, and of T.
    variance: [[f64; 3]; 2],
    variances: u64,
    /// Needed friction of each wheel: sum, largest size, number of records.
    needed: [(f64, f64, u64); 3],
    parity: f64,
    parities: u64,
    flags: FlagCounts,
}

impl ForceSums {
    /// Adds a record.
    pub fn add(&mut self, estimate: Option<&Estimate>) {
        let Some(estimate) = estimate.filter(|e| has_forces(e)) else {
            self.missing += 1;
            return;
        };
        self.samples += 1;
        let has = |flag| estimate.flags.contains(flag);
        let is_unloaded = Flags::WHEEL_UNLOADED.into_iter().any(has);
        self.flags.unloaded += u64::from(is_unloaded);
        self.flags.at_stop += u64::from(has(Flags::AT_STOP));
        self.flags.reading_missing += u64::from(has(Flags::SENSOR_MISSING));
        self.flags.reading_stale += u64::from(has(Flags::SENSOR_STALE));
        self.flags.reading_absurd += u64::from(has(Flags::SENSOR_ABSURD));
        self.flags.out_of_range += u64::from(has(Flags::OUT_OF_RANGE));
        if let Some(parity) = estimate.parity.filter(|p| p.sigma > 0.0) {
            self.parities += 1;
            self.parity += (parity.value / parity.sigma).powi(2);
        }
        if has(Flags::OUT_OF_RANGE) {
            return;
        }
        self.averaged += 1;
        for i in 0..3 {
            self.normal_force[i] += estimate.normal_force[i];
            self.traction[i] += estimate.traction[i];
            if let Some((needed, _)) = estimated_needed_friction(estimate, i) {
                let (sum, largest, count) = &mut self.needed[i];
                *sum += needed;
                *largest = largest.max(needed.abs());
                *count += 1;
            }
        }
        if let Some(covariance) = estimate.kalman.as_ref().map(|k| &k.covariance) {
            self.variances += 1;
            for i in 0..3 {
                self.variance[0][i] += covariance[2 * i + 1][2 * i + 1];
                self.variance[1][i] += covariance[2 * i][2 * i];
            }
        }
    }

    /// The means; `None` without records that count.
    pub fn means(&self) -> Option<MeanForces> {
        // Counts of records.
        let mean = |sum: f64, of: u64| sum / of as f64;
        if self.averaged == 0 {
            return None;
        }
        let sigma = |sums: &[f64; 3]| sums.map(|sum| mean(sum.max(0.0), self.variances).sqrt());
        let stated = (self.variances > 0).then(|| self.variance.each_ref().map(sigma));
        let needed = self.needed.map(|needed| Some(needed).filter(|n| n.2 > 0));
        Some(MeanForces {
            normal_force: self.normal_force.map(|sum| mean(sum, self.averaged)),
            traction: self.traction.map(|sum| mean(sum, self.averaged)),
            normal_force_sigma: stated.map(|[normal, _]| normal),
            traction_sigma: stated.map(|[_, traction]| traction),
            needed_friction: needed.map(|n| n.map(|(sum, _, count)| mean(sum, count))),
            largest_needed_friction: needed.map(|n| n.map(|(_, largest, _)| largest)),
            parity: (self.parities > 0).then(|| mean(self.parity, self.parities).sqrt()),
            records: self.samples,
            flags: self.flags,
        })
    }
}
