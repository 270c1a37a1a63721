//! The result of a study, as a table and as JSON.

use crate::consistency::{Consistency, CovarianceVerdict};
use crate::seeds::SeedScores;
use crate::statistics::{LEAST_RUNS, Mean};
use crate::truth_run::TruthRun;
use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Row, Table};
use robhaz_scene::Scene;
use serde::Serialize;

/// Width of the table, columns of text.
const WIDTH: u16 = 110;

/// The result of a study. Errors of N and standard deviations are fractions of the mean true N.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Engine that computed the truth.
    pub engine: String,
    /// Grade of the sensors.
    pub sensors: String,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// Errors count from this time on, s.
    pub compare_from_s: f64,
    /// Number of samples of one seed that count.
    pub samples: usize,
    /// How many of these have a wheel with two contacts.
    pub two_contacts: usize,
    /// Number of samples of one seed left out because no single contact is equivalent to the contacts of a wheel.
    pub left_out: usize,
    /// Cramer-Rao bound of one sample: [`crate::floor`]. `None` where torques and contact angles are exact.
    pub floor: Option<f64>,
    /// One line per estimator.
    pub estimators: Vec<Line>,
}

/// The result of one estimator. `None` where it gave no estimate or states no covariance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// RMS error of N.
    pub nrmse: Option<Mean>,
    /// RMS error of N over the samples at which no wheel has two contacts.
    pub nrmse_at_one_contact: Option<Mean>,
    /// RMS error of T, N.
    pub traction_rmse_n: Option<Mean>,
    /// Stated standard deviation of N: [`robhaz_score::Statistics::stated`].
    pub stated: Option<Mean>,
    /// RMS of the errors of N, each over its stated standard deviation.
    pub error_over_stated: Option<Mean>,
    /// RMS error of N over the Cramer-Rao bound of one sample.
    pub error_over_floor: Option<f64>,
    /// NEES, NIS and coverage.
    pub consistency: Option<Consistency>,
    /// Verdict by the NEES.
    pub verdict: Option<CovarianceVerdict>,
    /// Verdict by the NIS.
    pub parity_verdict: Option<CovarianceVerdict>,
    /// Number of samples without an estimate, of all seeds together.
    pub missing: u64,
}

impl Report {
    /// The report on a scene whose truth was observed with `seeds`.
    pub fn new(
        scene: &Scene,
        run: &TruthRun,
        seeds: &[u64],
        floor: Option<f64>,
        scores: &[SeedScores],
    ) -> Self {
        Self {
            scene: scene.name.clone(),
            engine: scene.engine.kind.name().to_owned(),
            sensors: scene.sensors.grade.name().to_owned(),
            seeds: seeds.to_vec(),
            compare_from_s: scene.record.compare_from,
            samples: run.counted(),
            two_contacts: run.two_contacts(),
            left_out: run.left_out(),
            floor,
            estimators: scores.iter().map(|s| Line::new(s, floor)).collect(),
        }
    }

    /// The table, and below it what was run.
    pub fn text(&self) -> String {
        let mut table = Table::new();
        table
            .load_preset(UTF8_FULL_CONDENSED)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(WIDTH)
            .set_header(header());
        for line in &self.estimators {
            table.add_row(line.row());
        }
        let mut text = String::from(
            "Errors of the normal forces N in % of their mean, of the tractions T in N; means over the seeds\n",
        );
        text.push_str(&table.trim_fmt());
        text.push('\n');
        text.push_str(&match self.floor {
            Some(floor) => format!(
                "Cramer-Rao bound of one sample, for the errors of torques and contact angles: {:.2} %.\n",
                100.0 * floor
            ),
            None => "Cramer-Rao bound of one sample: none, torques and contact angles are exact.\n"
                .to_owned(),
        });
        text.push_str(&self.what_was_run());
        text.push_str(&self.without_two_contacts());
        if self
            .estimators
            .iter()
            .any(|l| l.verdict == Some(CovarianceVerdict::NotJudged))
        {
            text.push_str(&format!(
                "\nNot judged: a verdict needs at least {LEAST_RUNS} seeds, and random errors that differ between them."
            ));
        }
        for line in &self.estimators {
            let nis = line.consistency.and_then(|c| c.nis);
            let (Some(verdict), Some(nis)) = (line.parity_verdict, nis) else {
                continue;
            };
            if matches!(
                verdict,
                CovarianceVerdict::Cautious | CovarianceVerdict::Overconfident
            ) {
                text.push_str(&format!(
                    "\n{}: the expected variance of the parity residual is {} (NIS {:.2}).",
                    line.name,
                    verdict.words(),
                    nis.mean,
                ));
            }
        }
        for line in self.estimators.iter().filter(|l| l.missing > 0) {
            text.push_str(&format!(
                "\n{}: no estimate in {} of {} samples of all seeds; these do not count.",
                line.name,
                line.missing,
                self.samples * self.seeds.len()
            ));
        }
        text
    }

    /// Errors of N over the samples without two contacts. Impacts on corners make most of the error of the others.
    fn without_two_contacts(&self) -> String {
        let of = |line: &Line| {
            Some(format!(
                "{} {}",
                line.name,
                percent(line.nrmse_at_one_contact?)
            ))
        };
        let errors: Vec<String> = self.estimators.iter().filter_map(of).collect();
        if self.two_contacts == 0 || errors.is_empty() {
            return String::new();
        }
        let errors = errors.join(", ");
        format!("\nError of N in % over the samples without two contacts: {errors}.")
    }

    fn what_was_run(&self) -> String {
        let seeds = match self.seeds.as_slice() {
            [] => "no seed".to_owned(),
            [one] => format!("seed {one}"),
            [first, .., last] => format!("{} seeds, {first} to {last}", self.seeds.len()),
        };
        let left_out = match self.left_out {
            0 => "none left out".to_owned(),
            n => format!(
                "{n} left out because the contacts of a wheel have no equivalent single contact"
            ),
        };
        let two_contacts = match self.two_contacts {
            0 => String::new(),
            n => format!("{n} of them with two contacts of a wheel, "),
        };
        format!(
            "{}: {seeds}; engine {}, sensors {}; {} samples a seed from {} s on, {two_contacts}{left_out}.",
            self.scene, self.engine, self.sensors, self.samples, self.compare_from_s
        )
    }
}

impl Line {
    fn new(scores: &SeedScores, floor: Option<f64>) -> Self {
        let nrmse = scores.nrmse();
        let consistency = scores.consistency();
        Self {
            name: scores.name.clone(),
            nrmse,
            nrmse_at_one_contact: scores.at_one_contact().nrmse(),
            traction_rmse_n: scores.traction_rmse(),
            stated: scores.stated(),
            error_over_stated: scores.normalised(),
            error_over_floor: nrmse.zip(floor).map(|(error, floor)| error.mean / floor),
            consistency,
            verdict: consistency.map(|c| c.verdict()),
            parity_verdict: consistency.and_then(|c| c.parity_verdict()),
            missing: scores.missing(),
        }
    }

    fn row(&self) -> Row {
        let mut row = Row::from(vec![Cell::new(&self.name)]);
        let c = self.consistency;
        let number = |value: Option<f64>, digits: usize| match value {
            Some(value) => format!("{value:.digits$}"),
            None => "-".to_owned(),
        };
        let cells = [
            self.nrmse.map_or_else(|| "-".to_owned(), percent),
            number(self.error_over_floor, 2),
            number(self.traction_rmse_n.map(|m| m.mean), 2),
            self.stated.map_or_else(
                || "-".to_owned(),
                |m| format!("{:.*}", digits(&m), 100.0 * m.mean),
            ),
            number(self.error_over_stated.map(|m| m.mean), 2),
            number(c.map(|c| 100.0 * c.coverage.mean), 1),
            number(c.map(|c| c.nees.mean), 2),
            number(c.and_then(|c| c.nis).map(|m| m.mean), 2),
        ];
        for cell in cells {
            row.add_cell(right(cell));
        }
        row.add_cell(Cell::new(
            self.verdict.map_or("-", CovarianceVerdict::words),
        ));
        row
    }
}

/// A fraction in %, with its standard error where there is one.
fn percent(share: Mean) -> String {
    let digits = digits(&share);
    let mean = format!("{:.digits$}", 100.0 * share.mean);
    match share.standard_error {
        Some(error) => format!("{mean} ±{:.digits$}", 100.0 * error),
        None => mean,
    }
}

/// Decimals of a fraction in %, for three significant digits.
fn digits(share: &Mean) -> usize {
    match 100.0 * share.mean {
        x if x < 1.0 => 3,
        x if x < 10.0 => 2,
        _ => 1,
    }
}

fn header() -> Row {
    let mut row = Row::from(vec![Cell::new("estimator")]);
    let names = [
        "error of N\n% ± s.e.",
        "error/\nbound",
        "T\nN",
        "stated\n%",
        "error/\nstated",
        "within\n2 sigma %",
        "NEES\n(3)",
        "NIS\n(1)",
    ];
    for name in names {
        row.add_cell(right(name));
    }
    row.add_cell(Cell::new("stated\nsigma is"));
    row
}

fn right(text: impl ToString) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}
