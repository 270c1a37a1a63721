//! What a recorded log held, and what became of its rows.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// What a recorded log held, and what became of its rows. Its keys in `summary.json` have units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LogReport {
    /// The file or folder, as the user named it.
    pub source: String,
    /// Time stamp of the log at time 0 of the run, s.
    #[serde(rename = "start_s")]
    pub start: f64,
    /// The channels; the first is the time base: its rows are the frames.
    pub channels: Vec<ChannelReport>,
    /// Number of frames without each reading, by name; only readings that the log has.
    pub missing: IndexMap<String, u64>,
    /// Readings that the log does not have at all.
    pub absent: Vec<String>,
}

/// What a channel of a log held.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelReport {
    /// Its name: the table or topic.
    pub name: String,
    /// Rows read.
    pub rows: u64,
    /// Median time between rows, s.
    #[serde(rename = "period_s")]
    pub period: f64,
    /// Offset that was added to its time stamps, s.
    #[serde(rename = "offset_s")]
    pub offset: f64,
    /// Mean age of its rows at the frames, s; 0 of the time base. Its readings are moved to the times
    /// of the frames.
    #[serde(default, rename = "age_s")]
    pub age: f64,
    /// Gaps of more than one and a half periods.
    pub gaps: u64,
    /// Rows that these gaps could hold.
    pub lost: u64,
    /// The longest gap, s; `None` without gaps.
    #[serde(rename = "longest_gap_s")]
    pub longest_gap: Option<f64>,
    /// Start of the longest gap, s.
    #[serde(rename = "longest_gap_at_s")]
    pub longest_gap_at: Option<f64>,
    /// Rows left out because they have the time of the row before.
    pub duplicates: u64,
    /// Rows left out because they are earlier than the row before.
    pub late: u64,
    /// How often the clock was set back, or rows are repeated.
    pub set_back: u64,
    /// By how much at most, s; `None` if never.
    #[serde(rename = "largest_set_back_s")]
    pub largest_set_back: Option<f64>,
    /// Time before that, s.
    #[serde(rename = "largest_set_back_at_s")]
    pub largest_set_back_at: Option<f64>,
    /// Rows left out because a newer one of the same frame has all readings.
    pub superseded: u64,
    /// Rows left out because they are earlier than the first frame.
    pub before_start: u64,
    /// Why the channel ends before its end.
    pub cut_off: Option<String>,
    /// How many units of its times a second has, as stated; `None` of seconds.
    #[serde(
        default,
        rename = "time_units_in_1_s",
        skip_serializing_if = "Option::is_none"
    )]
    pub units_in_second: Option<f64>,
}

impl ChannelReport {
    /// Lowest rate that the estimators can use, Hz: they start anew after 0.5 s.
    const LOWEST_RATE: f64 = 2.0;
    /// Highest rate of a robot's readings, Hz.
    const HIGHEST_RATE: f64 = 100_000.0;
    /// Highest usual one, Hz.
    const USUAL_RATE: f64 = 10_000.0;

    /// Whether no robot is recorded at its rate: its times have another unit than stated.
    pub fn is_of_other_unit(&self) -> bool {
        let plausible = 1.0 / Self::HIGHEST_RATE..=1.0 / Self::LOWEST_RATE;
        self.period > 0.0 && !plausible.contains(&self.period)
    }

    /// The unit of its times in which it has a usual rate, and that rate, Hz.
    pub fn other_unit(&self) -> Option<(&'static str, f64)> {
        let units = [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
        let step = self.units_in_second.unwrap_or(1.0) * self.period;
        let of = units.map(|(unit, factor)| (unit, factor / step));
        let usual = Self::LOWEST_RATE..Self::USUAL_RATE;
        of.into_iter()
            .find(|(_, rate)| self.is_of_other_unit() && usual.contains(rate))
    }
}
