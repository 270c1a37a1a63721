//! What is printed of recorded logs: means of the estimates, and what became of the rows.

use crate::estimator_rows::{first_cells, heading, right};
use crate::summary::{ChannelSummary, EstimatorSummary, LogSummary, MeanForces, Summary};
use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{Row, Table};

/// Share of the records with a flag from which on it is printed.
const OFTEN: f64 = 0.001;
/// Largest number of readings that are named.
const FEW: usize = 4;

/// The table of the means of runs that have nothing to compare with. Each run has a label.
pub fn means_table(runs: &[(&str, &Summary)], several: bool) -> String {
    let mut table = Table::new();
    table
        .load_preset(UTF8_FULL_CONDENSED)
        .set_header(header(several));
    for (label, summary) in runs {
        for (i, estimator) in summary.estimators.iter().enumerate() {
            let label = several.then_some(if i == 0 { *label } else { "" });
            table.add_rows(rows(label, estimator));
        }
    }
    let title = "Means of the estimates, N: normal force N and traction T of each wheel, with the stated standard deviation.\n\
                 Parity: RMS of the parity residual over its expected deviation, 1 for a right noise budget.\n";
    format!("{title}{}", table.trim_fmt())
}

fn header(several: bool) -> Row {
    let names = [
        "force",
        "wheel 1\nfront\nmean  sigma",
        "wheel 2\nmiddle\nmean  sigma",
        "wheel 3\nrear\nmean  sigma",
        "sum",
        "parity",
    ];
    heading(&names, several)
}

/// The row of N, and below it that of T.
fn rows(label: Option<&str>, estimator: &EstimatorSummary) -> [Row; 2] {
    let mut normal = first_cells(label, &estimator.name);
    let mut traction = first_cells(label.map(|_| ""), "");
    let Some(means) = &estimator.means else {
        fill(&mut normal, "N", None, None);
        fill(&mut traction, "T", None, None);
        return [normal, traction];
    };
    let MeanForces {
        normal_force_sigma,
        traction_sigma,
        ..
    } = means;
    fill(
        &mut normal,
        "N",
        Some(&means.normal_force),
        normal_force_sigma.as_ref(),
    );
    fill(
        &mut traction,
        "T",
        Some(&means.traction),
        traction_sigma.as_ref(),
    );
    let parity = means.parity.map(|p| format!("{p:.2}"));
    normal.add_cell(right(parity.unwrap_or_else(|| "-".to_owned())));
    [normal, traction]
}

/// Adds the cells of one force: its name, its mean with deviation of each wheel, its sum.
fn fill(row: &mut Row, force: &str, means: Option<&[f64; 3]>, sigma: Option<&[f64; 3]>) {
    row.add_cell(right(force));
    for i in 0..3 {
        let mean = means.map_or("-".to_owned(), |means| format!("{:.2}", means[i]));
        let sigma = sigma.map_or("-".to_owned(), |sigma| format!("{:.2}", sigma[i]));
        row.add_cell(right(format!("{mean} {sigma:>6}")));
    }
    let sum = means.map_or("-".to_owned(), |means| {
        format!("{:.2}", means.iter().sum::<f64>())
    });
    row.add_cell(right(sum));
}

/// Lines about a log: its channels, what was left out, readings that are missing, flags of the estimators.
pub fn log_lines(summary: &Summary) -> String {
    let Some(log) = &summary.log else {
        return String::new();
    };
    let mut lines: Vec<String> = log.channels.iter().flat_map(channel_lines).collect();
    lines.extend(missing_line(log));
    if !log.absent.is_empty() {
        lines.push(format!("not in the log: {}", log.absent.join(", ")));
    }
    let flags = |e: &EstimatorSummary| flags_line(e.means.as_ref()?, e);
    lines.extend(summary.estimators.iter().filter_map(flags));
    lines.iter().map(|line| format!("\n  {line}.")).collect()
}

fn channel_lines(channel: &ChannelSummary) -> Vec<String> {
    let name = &channel.name;
    let rate = if channel.period_s > 0.0 {
        format!(" at {} Hz", digits(1.0 / channel.period_s))
    } else {
        String::new()
    };
    let offset = match channel.offset_s {
        0.0 => String::new(),
        offset => format!(", time stamps {offset:+} s"),
    };
    let mut lines = vec![format!("{name}: {} rows{rate}{offset}", channel.rows)];
    if let (Some(longest), Some(at)) = (channel.longest_gap_s, channel.longest_gap_at_s) {
        lines.push(format!(
            "{name}: {} gaps, in which about {} rows are lost, the longest {longest:.3} s at {at:.3} s",
            channel.gaps, channel.lost
        ));
    }
    let counts = [
        (
            channel.duplicates,
            "with the time of the row before are left out",
        ),
        (channel.late, "earlier than the row before are left out"),
        (
            channel.before_start,
            "from before the first frame are left out",
        ),
        (
            channel.superseded,
            "give way to a newer one of the same frame",
        ),
    ];
    for (count, what) in counts.iter().filter(|(count, _)| *count > 0) {
        lines.push(format!("{name}: {count} rows {what}"));
    }
    if let Some(why) = &channel.cut_off {
        lines.push(format!("{name}: CUT OFF, the last row is left out: {why}"));
    }
    lines
}

fn missing_line(log: &LogSummary) -> Option<String> {
    let missing: Vec<String> = log
        .missing
        .iter()
        .filter(|(_, count)| **count > 0)
        .map(|(name, count)| format!("{name} {count}"))
        .collect();
    let counts = log.missing.values();
    let (least, most) = (counts.clone().min()?, counts.max()?);
    let text = match missing.len() {
        0 => return None,
        few if few <= FEW => missing.join(", "),
        many => format!("{least} to {most} of each reading, {many} readings (summary.json)"),
    };
    Some(format!("frames without a new reading: {text}"))
}

fn flags_line(means: &MeanForces, estimator: &EstimatorSummary) -> Option<String> {
    #[expect(clippy::cast_precision_loss, reason = "counts of records")]
    let share = |count: u64| count as f64 / estimator.samples as f64;
    let flags = [
        (
            means.reading_absurd,
            "a reading beyond what the robot can do: check units and signs",
        ),
        (
            means.reading_stale,
            "a reading that has been missing for long",
        ),
        (
            means.out_of_range,
            "a parity residual beyond five deviations: check signs, zeros and the noise budget",
        ),
        (means.unloaded, "a wheel without load"),
        (means.at_stop, "the linkage at an end stop"),
    ];
    let often = |(count, what): &(u64, &str)| {
        let share = share(*count);
        (share > OFTEN).then(|| format!("{:.1} % with {what}", 100.0 * share))
    };
    let found: Vec<String> = flags.iter().filter_map(often).collect();
    let name = &estimator.name;
    (!found.is_empty()).then(|| format!("{name}, of its records: {}", found.join("; ")))
}

/// A number with four digits at most.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded}")
}
