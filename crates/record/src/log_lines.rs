//! What is printed of recorded logs: means of the estimates, and what became of the rows.

use crate::grid::Grid;
use crate::summary::{EstimatorSummary, Faulty, MeanForces, Summary};
use robhaz_run::{ChannelReport, LogReport};

/// Share of the records with a flag from which on it is printed.
const OFTEN: f64 = 0.001;
/// Share of the records with a missing reading from which on hardly one has all.
const ALWAYS: f64 = 0.95;
/// Largest number of readings that are named.
const FEW: usize = 4;

/// What the table of means holds.
pub const MEANS: &str = "Means of the estimates, N: normal force N and traction T of each wheel, with the stated standard \
                         deviation.\nParity: RMS of the parity residual over its expected deviation, 1 for a right noise budget.";

/// The means of runs that have nothing to compare with: a row of N, and below it that of T. Each
/// run has a label.
pub fn means(runs: &[(&str, &Summary)], several: bool) -> Grid {
    let names = [
        "force",
        "wheel 1\nfront\nmean  sigma",
        "wheel 2\nmiddle\nmean  sigma",
        "wheel 3\nrear\nmean  sigma",
        "sum",
        "parity",
    ];
    let or_dash = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.2}"));
    let row = |force: &str, means: Option<[f64; 3]>, sigma: Option<[f64; 3]>| {
        let cell = |i: usize| {
            let [mean, sigma] = [means, sigma].map(|of| or_dash(of.map(|of| of[i])));
            format!("{mean} {sigma:>6}")
        };
        let sum = or_dash(means.map(|means| means.iter().sum()));
        let mut cells = vec![force.to_owned()];
        cells.extend((0..3).map(cell).chain([sum]));
        cells
    };
    Grid::of_estimators(runs, several, &names, |estimator| {
        let means = estimator.means.as_ref();
        let sigma = means.and_then(|m| m.normal_force_sigma);
        let mut normal = row("N", means.map(|m| m.normal_force), sigma);
        normal.extend(means.map(|m| or_dash(m.parity)));
        let sigma = means.and_then(|m| m.traction_sigma);
        let traction = row("T", means.map(|m| m.traction), sigma);
        vec![normal, traction]
    })
}

/// Needed friction (mean, and largest size), shares of the records with a flag, and channels whose
/// readings contradict others.
pub fn health(runs: &[(&str, &Summary)]) -> Grid {
    let names = [
        "T/N front",
        "T/N middle",
        "T/N rear",
        "wheel without load, %",
        "linkage at a stop, %",
        "reading missing, %",
        "reading stale, %",
        "reading absurd, %",
        "parity beyond 5 sigma, %",
        "contradictions",
    ];
    let or_dash = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.3}"));
    Grid::of_estimators(runs, false, &names, |e| {
        let Some(m) = &e.means else {
            return Vec::new();
        };
        let needed = m.needed_friction.into_iter().zip(m.largest_needed_friction);
        let needed = needed.map(|(mean, most)| format!("{} ({})", or_dash(mean), or_dash(most)));
        let f = &m.flags;
        let readings = [f.reading_missing, f.reading_stale, f.reading_absurd];
        let flags = [f.unloaded, f.at_stop].into_iter().chain(readings);
        let share = |count| format!("{:.2}", 100.0 * m.share(count));
        let flags = flags.chain([f.out_of_range]).map(share);
        let first =
            |(name, found): (&String, &Faulty)| format!("{name} from {:.1} s", found.first_s);
        let channels: Vec<String> = e.faulty_channels.iter().map(first).collect();
        vec![needed.chain(flags).chain([channels.join(", ")]).collect()]
    })
}

/// Lines about a log: its channels, what was left out, readings that are missing, flags of the
/// estimators.
pub fn log_lines(summary: &Summary) -> Vec<String> {
    let Some(log) = &summary.log else {
        return Vec::new();
    };
    let of_channel = |channel: &ChannelReport| {
        let lines = time_lines(channel).into_iter();
        lines.map(|line| line.of(&channel.name)).collect::<Vec<_>>()
    };
    let mut lines: Vec<String> = log.channels.iter().flat_map(of_channel).collect();
    lines.extend(missing_line(log));
    if !log.absent.is_empty() {
        lines.push(format!(
            "not in the log, or left out: {}",
            log.absent.join(", ")
        ));
    }
    let flags = |(name, e): (_, &EstimatorSummary)| flags_line(name, e.means.as_ref()?);
    lines.extend(summary.estimators.iter().filter_map(flags));
    lines.iter().map(|line| format!("  {line}.")).collect()
}

/// What is wrong, or not, with the time stamps of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeLine {
    /// What it is about.
    pub what: &'static str,
    /// The figures, in words.
    pub text: String,
    /// The figures: name, value, unit ("-" of a count).
    pub numbers: Vec<(&'static str, f64, &'static str)>,
    /// What to do, if the estimators suffer from it.
    pub remedy: Option<&'static str>,
}

impl TimeLine {
    /// With the name of the channel, and what to do.
    fn of(&self, channel: &str) -> String {
        let text = &self.text;
        match self.remedy {
            Some(remedy) => format!("{channel}: {text} ({remedy})"),
            None => format!("{channel}: {text}"),
        }
    }
}

/// Gap after which the estimators start anew, s.
const LONGEST_GAP: f64 = 0.5;
/// Age of a row that is printed, s: below it is the rounding of stamps.
const LEAST_AGE: f64 = 1e-5;
/// Share of the rows that may be left out or lost.
const FEW_ROWS: f64 = 0.01;

/// Lines about the rate of a channel, its gaps, the order of its stamps, and its end.
pub fn time_lines(channel: &ChannelReport) -> Vec<TimeLine> {
    let line = |what, text, numbers: &[_], remedy| TimeLine {
        what,
        text,
        numbers: numbers.to_vec(),
        remedy,
    };
    let rows = |count: u64| ("rows", number(count), "-");
    let many = |count: u64| number(count) > FEW_ROWS * number(channel.rows);
    let mut lines = vec![rate_line(channel)];
    if let (Some(by), Some(at)) = (channel.largest_set_back, channel.largest_set_back_at) {
        let count = channel.set_back;
        let text = format!(
            "the clock was set back by {by:.3} s at {at:.3} s, or rows are repeated; {count} in all"
        );
        let remedy = "split the log there; stamp readings with a monotonic clock";
        let times = ("times", number(count), "-");
        let numbers = [("set back", by, "s"), ("at", at, "s"), times];
        lines.push(line("clock", text, &numbers, Some(remedy)));
    }
    if let (Some(longest), Some(at)) = (channel.longest_gap, channel.longest_gap_at) {
        let (gaps, lost) = (channel.gaps, channel.lost);
        let text = format!(
            "{gaps} gap(s), in which about {lost} rows are lost, the longest {longest:.3} s at {at:.3} s"
        );
        let remedy = match longest > LONGEST_GAP {
            true => Some("the estimators start anew after 0.5 s: split the log there"),
            false => many(lost).then_some("find out where rows are lost"),
        };
        let times = [("longest", longest, "s"), ("at", at, "s")];
        let numbers = [[("gaps", number(gaps), "-"), rows(lost)], times].concat();
        lines.push(line("gaps", text, &numbers, remedy));
    }
    // A faster channel has rows that give way, and rows before the first frame: no fault.
    let write = Some("write each row once, in order, with its own time");
    let again = "with the time of the row before are left out";
    let late = "earlier than the row before are left out";
    let early = "from before the first frame are left out";
    let newer = "give way to a newer one of the same frame";
    for (count, why, remedy) in [
        (channel.duplicates, again, write),
        (channel.late, late, write),
        (channel.before_start, early, None),
        (channel.superseded, newer, None),
    ] {
        let remedy = remedy.filter(|_| many(count));
        let text = format!("{count} rows {why}");
        let left_out = line("order", text, &[rows(count)], remedy);
        lines.extend(Some(left_out).filter(|_| count > 0));
    }
    if let Some(why) = &channel.cut_off {
        let text = format!("CUT OFF, the last row is left out: {why}");
        let remedy = "the recording was killed, or its disk was full";
        lines.push(line("end", text, &[], Some(remedy)));
    }
    lines
}

/// A count as a number.
// Counts of rows and records.
fn number(count: u64) -> f64 {
    count as f64
}

fn rate_line(channel: &ChannelReport) -> TimeLine {
    let (rows, period, offset, age) = (channel.rows, channel.period, channel.offset, channel.age);
    let (mut text, mut numbers) = (format!("{rows} rows"), vec![("rows", number(rows), "-")]);
    let mut add = |words: String, figure| {
        text += &words;
        numbers.push(figure);
    };
    if period > 0.0 {
        let rate = 1.0 / period;
        add(format!(" at {} Hz", digits(rate)), ("rate", rate, "Hz"));
    }
    if let Some((unit, rate)) = channel.other_unit() {
        let words = format!(", with time_unit = \"{unit}\" at {} Hz", digits(rate));
        add(words, ("rate of that unit", rate, "Hz"));
    }
    if offset != 0.0 {
        let words = format!(", time stamps {offset:+} s");
        add(words, ("offset", offset, "s"));
    }
    if age > LEAST_AGE {
        let ms = 1e3 * age;
        let words = format!(", {ms:.2} ms old at the frames on average, moved to their times");
        add(words, ("age", age, "s"));
    }
    let implausible = "no robot is recorded at such a rate: state time_unit of the channel";
    TimeLine {
        what: "rate",
        text,
        numbers,
        remedy: channel.is_of_other_unit().then_some(implausible),
    }
}

fn missing_line(log: &LogReport) -> Option<String> {
    let missing = log.missing.iter().filter(|(_, count)| **count > 0);
    let missing = missing.map(|(name, count)| format!("{name} {count}"));
    let missing: Vec<String> = missing.collect();
    let counts = log.missing.values();
    let (least, most) = (counts.clone().min()?, counts.max()?);
    let text = match missing.len() {
        0 => return None,
        few if few <= FEW => missing.join(", "),
        many => format!("{least} to {most} of each reading, {many} readings (summary.json)"),
    };
    Some(format!("frames without a new reading: {text}"))
}

fn flags_line(name: &String, means: &MeanForces) -> Option<String> {
    let f = &means.flags;
    let counts = [f.reading_absurd, f.reading_stale, f.out_of_range];
    let counts = counts.into_iter().chain([f.unloaded, f.at_stop]);
    let flags = [
        "a reading beyond what the robot can do: check units and signs",
        "a reading that has been missing for long",
        "a parity residual beyond five deviations: check signs, zeros and the noise budget",
        "a wheel without load",
        "the linkage at an end stop",
    ];
    let often = |(count, flag, least): (u64, &str, f64)| {
        let share = means.share(count);
        (share > least).then(|| format!("{:.1} % with {flag}", 100.0 * share))
    };
    // Channels of other rates leave some, and one that is silent has its own line.
    let missing = "a reading missing: where messages or rows in turn hold some readings each, a [[channel]] of its own for each kind brings them together (docs/logs.md)";
    let missing = (f.reading_missing, missing, ALWAYS);
    let counts = counts.zip(flags).map(|(count, flag)| (count, flag, OFTEN));
    let alternates = Some(missing).filter(|_| means.share(f.reading_stale) < 1.0 - ALWAYS);
    let found: Vec<String> = counts.chain(alternates).filter_map(often).collect();
    (!found.is_empty()).then(|| format!("{name}, of its records: {}", found.join("; ")))
}

/// A number with four digits at most.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded}")
}
