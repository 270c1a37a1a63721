//! The table that is printed at the end of a run, and that compares runs; and the comparison for
//! other programs and for documents, a row for each run and estimator.

use crate::grid::Grid;
use crate::log_lines::{MEANS, log_lines, means};
use crate::scores::ScoreColumn;
use crate::summary::{
    BothSummary, BrokenOff, ClearanceSummary, EstimatorSummary, Faulty, FrictionSummary, Summary,
};
use indexmap::IndexMap;
use robhaz_score::{Agreement, Progress};
use serde_json::Value;

/// Width of the table, columns of text.
const WIDTH: u16 = 100;

/// Time for which a wheel may spin before the report mentions it, s: at a kerb's edge or a trench's
/// it spins for less.
const LONG_SPIN: f64 = 2.0;

/// Errors of the normal forces, estimators by wheels, of one run or several. Each run has a label.
///
/// Errors are in N, and also in % of the mean true normal force of the three wheels. Recorded logs
/// without truth have a table of their own, with means.
pub fn comparison_table(runs: &[(&str, &Summary)]) -> String {
    let several = runs.len() > 1;
    let without_truth = |summary: &Summary| summary.log.is_some() && !is_compared(summary);
    let (of_logs, compared): (Vec<_>, Vec<_>) = runs.iter().partition(|run| without_truth(run.1));
    let mut tables = Vec::new();
    if !compared.is_empty() {
        tables.push(errors_table(&compared, several));
    }
    if !of_logs.is_empty() {
        tables.push(format!("{MEANS}\n{}", means(&of_logs, several).text(None)));
    }
    let floods = runs
        .iter()
        .flat_map(|(label, summary)| flood(label, summary));
    let of_both = runs.iter().flat_map(|(label, summary)| {
        let warnings = summary.both.iter().flat_map(BothSummary::warnings);
        warnings.map(move |warning| format!("{label}: {warning}"))
    });
    let warnings = floods.chain(of_both);
    let mut text = warnings.chain(tables).collect::<Vec<_>>().join("\n");
    for (label, summary) in runs {
        text.push('\n');
        text.push_str(&remarks(label, summary).join("\n"));
    }
    text
}

/// What happened in a run, in sentences: its speed, its end, what the errors leave out, faults.
pub(crate) fn remarks(label: &str, summary: &Summary) -> Vec<String> {
    let mut lines = vec![speed(label, summary)];
    if let Some(BrokenOff { reason, time_s }) = &summary.broken_off {
        lines.push(format!(
            "  {label} broke off at {time_s:.3} s: {reason}. The errors are of what was recorded."
        ));
    }
    lines.extend(summary.both.iter().flat_map(BothSummary::lines));
    lines.extend(two_contacts(summary));
    let trouble = summary.progress.as_ref().and_then(trouble);
    let touch = summary.clearance.as_ref().and_then(touch);
    let found = trouble.into_iter().chain(touch);
    lines.extend(found.map(|what| format!("{label}: {what}")));
    for (name, estimator) in &summary.estimators {
        let missing = estimator.missing;
        if missing > 0 {
            let all = missing + estimator.samples;
            lines.push(format!(
                "  {name}: no estimate in {missing} of {all} records; these do not count."
            ));
        }
        lines.extend(faulty_channels(name, estimator));
        let scale = estimator.torque_scale.as_ref();
        lines.extend(scale.map(|scale| format!("  {name}: {}.", scale.words)));
    }
    lines.extend(log_lines(summary));
    lines
}

/// The estimators of a log of which many records are out of range.
fn flood(label: &str, summary: &Summary) -> Vec<String> {
    let of = |(name, e): (&String, &EstimatorSummary)| {
        let all = f64::from(u8::from(e.samples > 0));
        let means = e.means.as_ref();
        let share = means.map_or(all, |m| m.share(m.flags.out_of_range));
        let excuse = e.excuse_of_forces.map(|excuse| excuse.in_words());
        let words = excuse.map_or("WRONG FORCES", |_| "forces that may be wrong");
        let check = || ". `robhaz check` looks for the cause".to_owned();
        let why = excuse.map_or_else(check, |why| format!(": {why}"));
        (summary.log.is_some() && share > Agreement::FEW_OUT_OF_RANGE).then(|| {
            format!(
                "{label}, {name}: {words} in {:.1} % of the records: parity beyond five deviations, or a force \
                 beyond five weights. The means are of the others{why}.",
                100.0 * share
            )
        })
    };
    summary.estimators.iter().filter_map(of).collect()
}

/// Whether there are errors of an estimator.
fn is_compared(summary: &Summary) -> bool {
    let mut estimators = summary.estimators.values();
    estimators.any(|e| e.normal_force.is_some())
}

fn errors_table(runs: &[(&str, &Summary)], several: bool) -> String {
    let names = [
        "wheel 1\nfront\nN     %",
        "wheel 2\nmiddle\nN     %",
        "wheel 3\nrear\nN     %",
        "all wheels\n(NRMSE)\nN     %",
        "largest\nerror\nN",
        "traction,\nall wheels\nN",
    ];
    let cells = |estimator: &EstimatorSummary| {
        let Some((normal, traction)) = estimator.normal_force.zip(estimator.traction) else {
            return vec![vec!["-".to_owned(); names.len()]];
        };
        // All shares refer to the same load, so that wheels can be compared in % as well.
        let share = normal.nrmse.map(|n| n / normal.rmse_all);
        let wheels = normal.rmse.map(|r| force(r, share.map(|s| s * r)));
        let all = force(normal.rmse_all, normal.nrmse);
        let others = [normal.max_abs, traction.rmse_all].map(|newtons| force(newtons, None));
        vec![wheels.into_iter().chain([all]).chain(others).collect()]
    };
    let width = if several { WIDTH + 40 } else { WIDTH };
    format!(
        "RMSE of the normal force in N and in % of its mean over the wheels; last column: traction in N\n{}",
        Grid::of_estimators(runs, several, &names, cells).text(Some(width))
    )
}

/// Newtons and, under the header's `%`, the share.
fn force(newtons: f64, share: Option<f64>) -> String {
    match share {
        Some(share) if share.is_finite() => format!("{newtons:.2} {:>5.1}", 100.0 * share),
        _ => format!("{newtons:.2}"),
    }
}

fn speed(label: &str, summary: &Summary) -> String {
    let (seconds, wall, factor) = (summary.duration_s, summary.wall_s, summary.real_time_factor);
    let friction = summary.friction.as_ref();
    let friction = friction.and_then(FrictionSummary::in_words);
    let friction = friction.map_or(String::new(), |words| format!(", {words}"));
    match (&summary.engine, summary.step_s) {
        (Some(engine), Some(step)) => format!(
            "{label}: {} s simulated in {wall:.2} s, {factor:.1} times real time (engine {engine}, step {:.3} ms\
             {friction}). Errors count from {} s on.",
            // A run that broke off ends between two steps.
            (1e3 * seconds).round() / 1e3,
            1e3 * step,
            summary.compare_from_s,
        ),
        _ => format!(
            "{label}: {seconds:.3} s of recorded readings in {wall:.2} s, {factor:.1} times real time. {} count from {} s on.",
            if is_compared(summary) {
                "Errors"
            } else if summary.estimators.values().all(|e| e.means.is_none()) {
                "No estimator has an estimate, so there are neither means nor errors; they"
            } else {
                "Without truth there are no errors; means"
            },
            summary.compare_from_s,
        ),
    }
}

/// Channels whose readings contradicted others.
fn faulty_channels(name: &str, estimator: &EstimatorSummary) -> Option<String> {
    let channel = |(name, Faulty { first_s, records }): (&String, &Faulty)| {
        format!("{name} from {first_s:.1} s on ({records} records)")
    };
    let channels: Vec<String> = estimator.faulty_channels.iter().map(channel).collect();
    let list = channels.join(", ");
    (!channels.is_empty()).then(|| match estimator.excuse {
        None => format!(
            "  {name}: READINGS CONTRADICT EACH OTHER: {list}. `robhaz check` looks for the cause."
        ),
        Some(excuse) => format!(
            "  {name}: readings may contradict each other: {list}; {}.",
            excuse.in_words()
        ),
    })
}

/// How many records have a wheel with two contacts, and how many are left out, the same for all
/// estimators of a run.
fn two_contacts(summary: &Summary) -> Vec<String> {
    let Some(first) = summary.estimators.values().next() else {
        return Vec::new();
    };
    let mut lines = Vec::new();
    let (two, samples, left_out) = (first.two_contacts, first.samples, first.no_equivalent);
    if two > 0 {
        lines.push(format!(
            "  {two} of {samples} records have a wheel with two contacts: compared with the equivalent single contact."
        ));
        // Impacts on corners make most of the error of these records.
        let without = |(name, e): (_, &EstimatorSummary)| {
            let nrmse = e.normal_force_at_one_contact?.nrmse?;
            Some(format!("{name} {:.1}", 100.0 * nrmse))
        };
        let errors: Vec<String> = summary.estimators.iter().filter_map(without).collect();
        if !errors.is_empty() {
            let errors = errors.join(", ");
            lines.push(format!("  NRMSE in % without these records: {errors}."));
        }
    }
    if left_out > 0 {
        let all = left_out + first.missing + samples;
        lines.push(format!(
            "  {left_out} of {all} records left out: the contacts of a wheel have no equivalent single contact."
        ));
    }
    lines
}

/// A sentence about a robot that is stuck or spins its wheels.
fn trouble(progress: &Progress) -> Option<String> {
    let spins = progress.spinning.iter().any(|time| *time >= LONG_SPIN);
    let [front, middle, rear] = progress.spinning;
    let wheels = format!(
        "the wheels spun for {front:.1}, {middle:.1} and {rear:.1} s (front, middle, rear)"
    );
    // Whole centimetres; adding 0 turns -0 into 0.
    let shown = |way: f64| (way * 100.0).round() / 100.0 + 0.0;
    let (came, asked) = (shown(progress.distance), shown(progress.asked));
    let came = format!("came {came:.2} m of the {asked:.2} m that the drive asked for");
    match progress.stuck_since {
        Some(s) => Some(format!(
            "the robot is STUCK since {s:.1} s: it {came}; {wheels}."
        )),
        None => spins.then(|| format!("{wheels}; the robot {came}.")),
    }
}

/// A sentence about bars that touched the ground.
fn touch(clearance: &ClearanceSummary) -> Option<String> {
    let (time, bar) = clearance.first_touch.as_ref()?;
    let times = match clearance.touches {
        1 => "once".to_owned(),
        n => format!("{n} times"),
    };
    Some(format!(
        "{bar} TOUCHED THE GROUND at {time:.2} s, body or links {times} in all: the force of such a contact is not modelled, so the \
         truth is wrong from then on."
    ))
}

/// The scores of a row, in the order of the columns.
const SCORES: [&str; 18] = [
    "rmse_front",
    "rmse_middle",
    "rmse_rear",
    "rmse",
    "nrmse",
    "bias_front",
    "bias_middle",
    "bias_rear",
    "max_error",
    "max_error_time",
    "lag",
    "stated",
    "coverage",
    "nees",
    "traction_rmse",
    "traction_max_error",
    "samples",
    "missing",
];

/// Columns before the scores.
const NAMES: [&str; 3] = ["run", "scene", "estimator"];

/// The scores of a row.
fn scores() -> impl Iterator<Item = &'static ScoreColumn> {
    let of = |name| ScoreColumn::all().iter().find(|score| score.name == name);
    SCORES.into_iter().filter_map(of)
}

/// The runs with their labels as rows: the texts of [`NAMES`], and each score.
fn rows<T>(
    runs: &[(&str, &Summary)],
    name: impl Fn(&str) -> T,
    score: impl Fn(&ScoreColumn, Option<f64>) -> T,
) -> Vec<Vec<T>> {
    let of_run = |(label, run): &(&str, &Summary)| {
        let row = |(estimator, e): (&String, &EstimatorSummary)| {
            let names = [*label, &run.scene, estimator].map(&name).into_iter();
            let scores = scores().map(|s| score(s, s.value(run, None, Some(e))));
            names.chain(scores).collect()
        };
        run.estimators.iter().map(row).collect::<Vec<_>>()
    };
    runs.iter().flat_map(of_run).collect()
}

/// A JSON array with an object for each run and estimator: `run`, `scene`, `estimator`, and the
/// scores by name, all digits; null where there is none.
///
/// # Errors
/// Those of the writer; in memory there is none to expect.
pub fn comparison_json(runs: &[(&str, &Summary)]) -> Result<String, serde_json::Error> {
    let value = |score: &ScoreColumn, value: Option<f64>| match value {
        // A count, kept as a number.
        Some(count) if score.is_count => Value::from(count as u64),
        value => Value::from(value),
    };
    let names = || NAMES.into_iter().chain(scores().map(|score| score.name));
    let object = |row: Vec<Value>| names().zip(row).collect::<IndexMap<_, _>>();
    let rows = rows(runs, |name| Value::from(name), value).into_iter();
    serde_json::to_string_pretty(&rows.map(object).collect::<Vec<_>>())
}

/// Titles with units, and the cells of each row with four significant digits.
pub(crate) fn comparison_cells(runs: &[(&str, &Summary)]) -> (Vec<String>, Vec<Vec<String>>) {
    let title = |score: &ScoreColumn| match score.unit {
        "" => score.name.to_owned(),
        unit => format!("{}, {unit}", score.name),
    };
    let titles = NAMES.map(str::to_owned).into_iter();
    let cell = |_: &ScoreColumn, value: Option<f64>| value.map_or_else(String::new, significant);
    let rows = rows(runs, str::to_owned, cell);
    (titles.chain(scores().map(title)).collect(), rows)
}

/// Four significant digits; whole numbers with all of theirs.
fn significant(value: f64) -> String {
    if value.fract().abs() > 0.0 && value.is_finite() {
        let digits = 3 - value.abs().log10().floor() as i32;
        format!("{value:.*}", digits.clamp(0, 12) as usize)
    } else {
        value.to_string()
    }
}
