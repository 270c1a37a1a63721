//! What is to be drawn of a dataset, and why it cannot be.

use super::scale::Spacing;
use std::fmt;

/// A kind of figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotKind {
    /// A score against an axis: median and quantile bands of each estimator.
    Bands,
    /// The median of a score over two axes, a map for each estimator.
    Heat,
    /// The error against the stated standard deviation, and how often two of these hold it.
    Calibration,
    /// How often a score has which value.
    Histogram,
    /// Rungs one below the other, each with the spread of its score.
    Ladder,
}

impl PlotKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::Bands,
        Self::Heat,
        Self::Calibration,
        Self::Histogram,
        Self::Ladder,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bands => "bands",
            Self::Heat => "heat",
            Self::Calibration => "calibration",
            Self::Histogram => "histogram",
            Self::Ladder => "ladder",
        }
    }
}

/// A figure of a dataset.
#[derive(Clone, Debug)]
pub struct PlotRequest {
    /// Its kind.
    pub kind: PlotKind,
    /// Column of the horizontal axis; `None` for the first key that varies, seeds last.
    pub x: Option<String>,
    /// Column of the vertical axis of [`PlotKind::Heat`], `None` for the next key that varies; column whose values are the
    /// rungs of [`PlotKind::Ladder`], `None` for the estimators.
    pub x2: Option<String>,
    /// Column of the score.
    pub y: String,
    /// Labels of the estimators; empty for all.
    pub estimators: Vec<String>,
    /// Spacing along `x`; `None`: logarithmic where the study drew the logarithm, or over more than two decades.
    pub x_spacing: Option<Spacing>,
    /// Spacing of the score; `None`: logarithmic over more than two decades.
    pub y_spacing: Option<Spacing>,
}

impl PlotRequest {
    /// The figure of this kind, with `nrmse` as score, all estimators, and the axes that the study varies.
    pub fn new(kind: PlotKind) -> Self {
        Self {
            kind,
            x: None,
            x2: None,
            y: "nrmse".to_owned(),
            estimators: Vec::new(),
            x_spacing: None,
            y_spacing: None,
        }
    }
}

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// No such column.
    #[error("the dataset has no column {name}; allowed: {}", List(allowed))]
    Column {
        /// The name.
        name: String,
        /// All columns that can stand there.
        allowed: Vec<String>,
    },
    /// No such estimator.
    #[error("the dataset has no estimator {name}; allowed: {}", List(allowed))]
    Estimator {
        /// The label.
        name: String,
        /// All labels.
        allowed: Vec<String>,
    },
    /// A column of words where numbers are needed.
    #[error(
        "the column {name} holds words, numbers are needed; allowed: {}",
        List(allowed)
    )]
    Words {
        /// The column.
        name: String,
        /// All columns of numbers.
        allowed: Vec<String>,
    },
    /// An axis with less than two values.
    #[error(
        "{name} is {value} in all rows: nothing to draw against; these vary: {}",
        List(varying)
    )]
    OneValue {
        /// The column.
        name: String,
        /// Its value.
        value: String,
        /// The keys that vary.
        varying: Vec<String>,
    },
    /// Too few axes vary.
    #[error("{needed} axes that vary are needed; found: {}", List(varying))]
    Axes {
        /// How many.
        needed: usize,
        /// The keys that vary.
        varying: Vec<String>,
    },
    /// No row with what is to be drawn.
    #[error("no row has a value of {name}: {reason}")]
    Nothing {
        /// The column.
        name: String,
        /// Why.
        reason: String,
    },
    /// A logarithmic axis with a value that has no logarithm.
    #[error("{name} has the value {value}: a logarithmic axis needs values above zero")]
    NotPositive {
        /// The column.
        name: String,
        /// The value.
        value: f64,
    },
    /// The drawing library failed.
    #[error("the figure cannot be drawn: {0}")]
    Drawing(String),
}

/// Names with commas; `none` without any.
struct List<'a>(&'a [String]);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            [] => f.write_str("none"),
            names => f.write_str(&names.join(", ")),
        }
    }
}
