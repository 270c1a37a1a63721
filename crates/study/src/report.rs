//! The result of a study, as a table and as JSON.

use crate::error::{Result, StudyError};
use crate::statistics::{Consistency, CovarianceVerdict, LEAST_RUNS, Mean};
use crate::study::Study;
use robhaz_record::{Dataset, Grid};
use robhaz_scene::Scene;
use serde::Serialize;

/// Width of the table, columns of text.
const WIDTH: u16 = 110;

/// A column of the table: header, and cell of an estimator.
type Column = (&'static str, fn(&Line) -> String);

const COLUMNS: [Column; 10] = [
    ("estimator", |l| l.name.clone()),
    ("error of N\n% ± s.e.", |l| {
        l.nrmse.map_or_else(|| "-".to_owned(), percent)
    }),
    ("error/\nbound", |l| number(l.error_over_floor, 2)),
    ("T\nN", |l| mean(l.traction_rmse_n, 1.0, 2)),
    ("stated\n%", |l| {
        mean(l.stated, 100.0, l.stated.as_ref().map_or(0, digits))
    }),
    ("error/\nstated", |l| mean(l.error_over_stated, 1.0, 2)),
    ("within\n2 sigma %", |l| {
        mean(l.consistency.map(|c| c.coverage), 100.0, 1)
    }),
    ("NEES\n(3)", |l| mean(l.consistency.map(|c| c.nees), 1.0, 2)),
    ("NIS\n(1)", |l| {
        mean(l.consistency.and_then(|c| c.nis), 1.0, 2)
    }),
    ("stated\nsigma is", |l| {
        l.verdict.map_or("-", CovarianceVerdict::name).to_owned()
    }),
];

fn mean(mean: Option<Mean>, factor: f64, digits: usize) -> String {
    number(mean.map(|m| factor * m.mean), digits)
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

/// The result of a study: means over all its complete runs. Errors of N and standard deviations are
/// fractions of the mean true N. What is not the same in all runs is `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene, or of the study file.
    pub scene: String,
    /// Whether the runs differ in their seeds alone.
    #[serde(skip)]
    only_seeds: bool,
    /// Number of runs.
    pub runs: u64,
    /// How many of them failed, and have no scores.
    pub failed: u64,
    /// Engine that computed the truth.
    pub engine: Option<String>,
    /// Grade of the sensors.
    pub sensors: Option<String>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// Errors count from this time on, s.
    pub compare_from_s: Option<f64>,
    /// Number of samples of a run that count.
    pub samples: Option<u64>,
    /// How many of these have a wheel with two contacts.
    pub two_contacts: Option<u64>,
    /// Number of samples of a run left out because no single contact is equivalent to the contacts
    /// of a wheel.
    pub left_out: Option<u64>,
    /// Cramer-Rao bound of one sample: [`robhaz_score::Bound::nrmse`], the mean over the runs.
    /// `None` where torques and contact angles are exact.
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
    /// Number of samples without an estimate, of all runs together.
    pub missing: u64,
    /// Number of samples that count, of all runs together.
    #[serde(skip)]
    counted: u64,
}

/// The rows of one estimator.
struct Rows<'a> {
    data: &'a Dataset,
    label: &'a str,
}

impl Rows<'_> {
    /// The values of a column, in the order of the runs.
    fn of(&self, column: &str) -> Vec<f64> {
        self.data.of_estimator(self.label, column)
    }

    fn mean(&self, column: &str) -> Option<Mean> {
        Mean::of(&self.of(column))
    }

    /// Samples that count, by run.
    fn counted(&self) -> Vec<f64> {
        let (samples, missing) = (self.of("samples"), self.of("missing"));
        samples.iter().zip(missing).map(|(s, m)| s + m).collect()
    }
}

/// The value that all have; `None` where they differ.
fn common<T: PartialEq>(mut values: impl Iterator<Item = T>) -> Option<T> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// The value of a count that is the same in all runs; of estimators that miss samples the largest
/// one.
fn count(estimators: &[Rows<'_>], of: impl Fn(&Rows<'_>) -> Vec<f64>) -> Option<u64> {
    let counts = estimators.iter().map(|rows| common(of(rows).into_iter()));
    let largest = counts.collect::<Option<Vec<f64>>>()?.into_iter();
    // Counts, written as numbers.
    largest.reduce(f64::max).map(|count| count as u64)
}

impl Report {
    /// The report on the dataset of a study.
    ///
    /// # Errors
    /// [`StudyError::Failed`] where a run of a scene failed, or has no sample that counts.
    pub fn of(study: &Study, data: &Dataset) -> Result<Self> {
        let failures = data.failures();
        let only_seeds = study.driven().is_some();
        let labels = data.estimators().into_iter();
        let estimators: Vec<Rows<'_>> = labels.map(|label| Rows { data, label }).collect();
        let name = &study.choice.name;
        let failed = |reason: String| StudyError::Failed {
            scene: name.clone(),
            reason,
        };
        if let (true, Some((reason, ..))) = (only_seeds, failures.first()) {
            return Err(failed((*reason).to_owned()));
        }
        let scenes = &study.scenes;
        let compare_from_s = common(scenes.iter().map(|scene| scene.record.compare_from));
        let samples = count(&estimators, |rows| rows.counted());
        let left_out = count(&estimators, |rows| rows.of("no_equivalent"));
        if let (true, Some(0), Some(compared), Some(from)) =
            (only_seeds, samples, left_out, compare_from_s)
        {
            return Err(failed(format!(
                "no sample counts: in each of the {compared} samples from {from} s on the contacts of a wheel have no equivalent \
                 single contact"
            )));
        }
        let bounds: Vec<f64> = data.numbers("bound").into_iter().flatten().collect();
        // Equal bounds keep their bits.
        let floor = common(bounds.iter().copied());
        let floor = floor.or_else(|| Mean::of(&bounds).map(|bound| bound.mean));
        Ok(Self {
            scene: name.clone(),
            only_seeds,
            runs: data.runs,
            failed: failures.iter().map(|(_, count, _)| count).sum(),
            engine: common(scenes.iter().map(|s| s.engine.kind.name())).map(str::to_owned),
            sensors: common(scenes.iter().map(|s| s.sensors.grade.name())).map(str::to_owned),
            seeds: seeds(data, scenes),
            compare_from_s,
            samples,
            two_contacts: count(&estimators, |rows| rows.of("two_contacts")),
            left_out,
            floor,
            estimators: estimators.iter().map(|e| Line::new(e, floor)).collect(),
        })
    }

    /// The table, and below it what was run.
    pub fn text(&self) -> String {
        let mut table = Grid::new(&[0, 9], &COLUMNS.map(|(header, _)| header));
        for line in &self.estimators {
            table.row(COLUMNS.iter().map(|(_, cell)| cell(line)));
        }
        let each = self.each(true);
        let bound = match self.floor {
            Some(floor) => format!(
                "Cramer-Rao bound of one sample, for the errors of torques and contact angles: {:.2} %.",
                100.0 * floor
            ),
            None => "Cramer-Rao bound of one sample: none, torques and contact angles are exact."
                .to_owned(),
        };
        let mut lines = vec![
            format!(
                "Errors of the normal forces N in % of their mean, of the tractions T in N; means over the {each}"
            ),
            table.text(Some(WIDTH)),
            bound,
            self.what_was_run(),
        ];
        lines.extend(self.without_two_contacts());
        let mut verdicts = self.estimators.iter().map(|line| line.verdict);
        if verdicts.any(|verdict| verdict == Some(CovarianceVerdict::NotJudged)) {
            lines.push(format!(
                "Not judged: a verdict needs at least {LEAST_RUNS} {each}, and random errors that differ between them."
            ));
        }
        lines.extend(self.estimators.iter().filter_map(Line::wrong_parity));
        for line in self.estimators.iter().filter(|l| l.missing > 0) {
            let (name, missing, counted) = (&line.name, line.missing, line.counted);
            lines.push(format!(
                "{name}: no estimate in {missing} of {counted} samples of all {each}; these do not count."
            ));
        }
        lines.join("\n")
    }

    /// What means are over.
    fn each(&self, several: bool) -> &'static str {
        match (self.only_seeds, several) {
            (true, true) => "seeds",
            (true, false) => "seed",
            (false, true) => "runs",
            (false, false) => "run",
        }
    }

    /// Errors of N over the samples without two contacts. Impacts on corners make most of the error
    /// of the others.
    fn without_two_contacts(&self) -> Option<String> {
        let of = |line: &Line| {
            let error = percent(line.nrmse_at_one_contact?);
            Some(format!("{} {error}", line.name))
        };
        let errors: Vec<String> = self.estimators.iter().filter_map(of).collect();
        let is_of_interest = self.two_contacts != Some(0) && !errors.is_empty();
        let errors = errors.join(", ");
        is_of_interest
            .then(|| format!("Error of N in % over the samples without two contacts: {errors}."))
    }

    fn what_was_run(&self) -> String {
        let seeds = match self.seeds.as_slice() {
            [] => "seeds vary".to_owned(),
            [one] => format!("seed {one}"),
            [first, .., last] => format!("{} seeds, {first} to {last}", self.seeds.len()),
        };
        let runs = match (self.only_seeds, self.failed) {
            (true, _) => String::new(),
            (false, 0) => format!("{} runs, none failed; ", self.runs),
            (false, failed) => format!("{} runs, {failed} of them failed; ", self.runs),
        };
        let common = |value: &Option<String>| value.clone().unwrap_or("several".to_owned());
        let (engine, sensors) = (common(&self.engine), common(&self.sensors));
        let from = self.compare_from_s.map(|from| format!(" from {from} s on"));
        let from = from.unwrap_or_default();
        let samples = match self.samples {
            Some(samples) => format!("{samples} samples a {}{from}", self.each(false)),
            None => format!("samples{from}"),
        };
        let two_contacts = match self.two_contacts {
            Some(0) => String::new(),
            Some(n) => format!("{n} of them with two contacts of a wheel, "),
            None => "some of them with two contacts of a wheel, ".to_owned(),
        };
        let why = " because the contacts of a wheel have no equivalent single contact";
        let (left_out, why) = match self.left_out {
            Some(0) => ("none".to_owned(), ""),
            Some(n) => (n.to_string(), why),
            None => ("some".to_owned(), why),
        };
        format!(
            "{}: {runs}{seeds}; engine {engine}, sensors {sensors}; {samples}, {two_contacts}{left_out} left out{why}.",
            self.scene
        )
    }
}

impl Line {
    fn new(rows: &Rows<'_>, floor: Option<f64>) -> Self {
        let nrmse = rows.mean("nrmse");
        let consistency = rows.mean("nees").zip(rows.mean("coverage"));
        let consistency = consistency.map(|(nees, coverage)| Consistency {
            nees,
            nis: rows.mean("nis"),
            coverage,
        });
        Self {
            name: rows.label.to_owned(),
            nrmse,
            nrmse_at_one_contact: rows.mean("nrmse_at_one_contact"),
            traction_rmse_n: rows.mean("traction_rmse"),
            stated: rows.mean("stated"),
            error_over_stated: rows.mean("error_over_stated"),
            error_over_floor: nrmse.zip(floor).map(|(error, floor)| error.mean / floor),
            consistency,
            verdict: consistency.map(|c| c.verdict()),
            parity_verdict: consistency.and_then(|c| c.parity_verdict()),
            missing: rows.of("missing").iter().sum::<f64>() as u64,
            counted: rows.counted().iter().sum::<f64>() as u64,
        }
    }

    /// What is wrong with the expected variance of the parity residual.
    fn wrong_parity(&self) -> Option<String> {
        use CovarianceVerdict::{Cautious, Overconfident};
        let nis = self.consistency?.nis?.mean;
        let verdict = self.parity_verdict;
        let verdict = verdict.filter(|v| matches!(v, Cautious | Overconfident))?;
        let (name, words) = (&self.name, verdict.name());
        Some(format!(
            "{name}: the expected variance of the parity residual is {words} (NIS {nis:.2})."
        ))
    }
}

/// The seeds of all runs, each once, from the least on.
fn seeds(data: &Dataset, scenes: &[Scene]) -> Vec<u64> {
    let varied = data.numbers("seed").into_iter().flatten();
    let mut varied: Vec<u64> = varied.map(|s| s as u64).collect();
    varied.sort_unstable();
    varied.dedup();
    if varied.is_empty() {
        varied.extend(common(scenes.iter().map(|scene| scene.seed)));
    }
    varied
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
