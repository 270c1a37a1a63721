//! What a run of both sides leaves beside the summaries of its sides.

use super::parts::TorqueScaleSummary;
use robhaz_estimator::TorqueScale;
use robhaz_estimator::whole::WholeEstimate;
use robhaz_run::{BothDescription, BothFrame};
use robhaz_score::{BothErrors, BothStatistics, Sum};
use serde::{Deserialize, Serialize};

/// The rover as a whole, over the records that count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BothSummary {
    /// Name of the estimator.
    pub estimator: String,
    /// Errors of N along the ground's normal; `None` without truth.
    pub normal_force: Option<BothErrors>,
    /// Errors of N in the wheels' planes, which is what is estimated; `None` where it is not known.
    pub in_plane_normal_force: Option<BothErrors>,
    /// Mean force of the ground across the body, N, to the left.
    pub mean_lateral_force: f64,
    /// Largest size of the mean axial force of a wheel over its N, -.
    pub largest_axial_share: f64,
    /// Least load of the wheels off a line about which the rover would tip, over their load on level
    /// ground, -.
    pub least_tip_margin: f64,
    /// Its time, s.
    pub least_tip_margin_s: f64,
    /// That line: `left`, `right`, `front`, `rear`.
    pub tip_line: String,
    /// Records.
    pub samples: u64,
    /// Records in which wheels are dragged across.
    pub dragged: u64,
    /// Mean misfit of the nine equations over the records in which none are, -: 3 if what is stated
    /// holds; `None` without such records.
    pub misfit: Option<f64>,
    /// Why readings contradict each other, a cause each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contradictions: Vec<String>,
    /// What the readings do not confirm, though the forces depend on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unconfirmed: Vec<String>,
    /// The torques against the weight at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_scale: Option<TorqueScaleSummary>,
}

/// Sums over the records of a run of both sides that count.
#[derive(Debug, Default)]
pub(super) struct BothSums {
    normal_force: BothStatistics,
    in_plane: BothStatistics,
    load: Sum,
    loads: u64,
    lateral_force: Sum,
    largest_axial_share: f64,
    /// Margin, time (s) and line.
    least: Option<(f64, f64, &'static str)>,
    samples: u64,
    dragged: u64,
    misfit: Sum,
    /// How far the wheels have turned, rad, and the last sum of their angles.
    rolled: f64,
    turned: Option<f64>,
    scale: Option<TorqueScale>,
}

impl BothSums {
    /// Takes the scale of a record, also of one that does not count.
    pub fn add_scale(&mut self, record: &BothFrame<'_>) {
        self.scale = record.estimate.map(|e| e.torque_scale).or(self.scale);
    }

    /// Adds a record that counts.
    pub fn add(&mut self, time: f64, record: &BothFrame<'_>) {
        let Some(estimate) = record.estimate else {
            return;
        };
        self.samples += 1;
        self.dragged += u64::from(estimate.dragged);
        let turned = record.sides.readings.wheel_angle.iter().copied();
        let turned = turned.sum::<Option<f64>>();
        let step = turned.and_then(|now| Some((now - self.turned.replace(now)?).abs() / 6.0));
        if !estimate.dragged {
            self.misfit.add(estimate.misfit);
            self.rolled += step.unwrap_or(0.0);
        }
        self.lateral_force.add(estimate.lateral_force);
        let share = estimate.axial_share.abs();
        self.largest_axial_share = self.largest_axial_share.max(share);
        let margin = estimate.tip_margin;
        if self.least.is_none_or(|(least, ..)| margin < least) {
            self.least = Some((margin, time, estimate.tip_line.name()));
        }
        let Some(truth) = &record.sides.truth else {
            return;
        };
        let errors =
            |truth: &[f64; 6]| core::array::from_fn(|i| estimate.normal_force[i] - truth[i]);
        let covariance = &estimate.covariance;
        self.normal_force
            .add(errors(&truth.normal_force), covariance);
        if let Some(in_plane) = &truth.in_plane {
            self.in_plane
                .add(errors(in_plane), &estimate.in_plane_covariance());
        }
        truth.normal_force.iter().for_each(|n| self.load.add(*n));
        self.loads += 6;
    }

    /// The summary of a run whose sides have the mass `described` each, kg; `None` without records.
    pub fn summary(&self, run: &BothDescription, described: f64) -> Option<BothSummary> {
        let largest = WholeEstimate::largest_misfit(self.rolled);
        let misfit = self.misfit.mean(self.samples - self.dragged);
        let beyond = misfit.filter(|misfit| *misfit > largest).map(|misfit| {
            format!("the nine equations of the rover have a misfit of {misfit:.1} on average, where 3 is expected and correct readings have {largest:.1} once in 10 000 drives")
        });
        let contradictions = run.contradiction.clone().into_iter().chain(beyond);
        let (least_tip_margin, least_tip_margin_s, line) = self.least?;
        let load = self.load.mean(self.loads).unwrap_or(1.0);
        Some(BothSummary {
            estimator: run.label.clone(),
            normal_force: self.normal_force.errors(load),
            in_plane_normal_force: self.in_plane.errors(load),
            mean_lateral_force: self.lateral_force.mean(self.samples)?,
            largest_axial_share: self.largest_axial_share,
            least_tip_margin,
            least_tip_margin_s,
            tip_line: line.to_owned(),
            samples: self.samples,
            dragged: self.dragged,
            misfit,
            contradictions: contradictions.collect(),
            unconfirmed: run.unconfirmed.clone(),
            torque_scale: self
                .scale
                .map(|scale| TorqueScaleSummary::of(&scale, described)),
        })
    }
}

impl BothSummary {
    /// What the user must know before the forces, a line each.
    pub(crate) fn warnings(&self) -> Vec<String> {
        /// Share of the records that is no turn.
        const FEW: f64 = 0.01;
        // Counts of records.
        let share = self.dragged as f64 / self.samples.max(1) as f64;
        let mut warnings = Vec::new();
        if !self.contradictions.is_empty() {
            let list = self.contradictions.join("; ");
            warnings.push(format!(
                "READINGS CONTRADICT EACH OTHER: {list}. `robhaz check` looks for the cause."
            ));
        }
        if share > FEW {
            warnings.push(format!(
                "WHEELS ARE DRAGGED ACROSS in {:.1} % of the records, as in a skid turn: there forces are outside of the model, and their stated deviations large.",
                100.0 * share
            ));
        }
        warnings
    }

    /// The rover as a whole, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let errors = |what: &str, errors: &BothErrors| {
            format!(
                "  all six wheels, N {what}: NRMSE {:.2} %, {:.1} % within two stated deviations (stated {:.2} %).",
                100.0 * errors.nrmse,
                100.0 * errors.coverage,
                100.0 * errors.stated
            )
        };
        let in_plane = self.in_plane_normal_force.as_ref();
        let in_plane = in_plane.map(|e| errors("in the wheels' planes", e));
        let normal = self.normal_force.as_ref();
        let normal = normal.map(|e| errors("along the ground's normal", e));
        let rover = format!(
            "  the rover: force of the ground across {:.1} N on average (positive to the left); axial force of a wheel up to {:.2} of its N; tip-over margin {:.2} at least, at {:.2} s about the {} wheels (1 on level ground, 0 tips).",
            self.mean_lateral_force,
            self.largest_axial_share,
            self.least_tip_margin,
            self.least_tip_margin_s,
            self.tip_line
        );
        let scale = self.torque_scale.as_ref();
        let scale = scale.map(|scale| format!("  {}: {}.", self.estimator, scale.words));
        // Half of all logs leave something open, so that it is no alarm.
        let open = !self.unconfirmed.is_empty();
        let open = open.then(|| {
            let list = self.unconfirmed.join("; ");
            format!("  not confirmed by this log: {list}.")
        });
        let lines = in_plane.into_iter().chain(normal).chain([rover]);
        lines.chain(scale).chain(open).collect()
    }
}
