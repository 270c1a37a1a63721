//! The rows of a dataset that a figure shows, and its axes.

use super::request::{PlotError, PlotRequest};
use super::scale::{Spacing, label};
use crate::dataset::{Dataset, DatasetColumn, DatasetValues, distinct};
use robhaz_scene::AxisValues;

/// Keys that draw something anew and mean nothing in themselves.
pub const SEEDS: [&str; 2] = ["seed", "terrain.seed"];

/// A row that is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its place in the dataset.
    pub row: usize,
    /// Place of its estimator among those of the selection.
    pub estimator: usize,
    /// The score.
    pub value: f64,
}

/// Rows with a score, of the chosen estimators.
pub struct Selection<'a> {
    /// The dataset.
    pub dataset: &'a Dataset,
    /// Column of the score.
    pub score: &'a DatasetColumn,
    /// The estimators with a score: place among all of the dataset, which gives the colour, and label.
    pub estimators: Vec<(usize, &'a str)>,
    /// The rows.
    pub rows: Vec<Row>,
    /// Estimators with rows that have no score, and the number of these.
    pub without: Vec<(&'a str, usize)>,
}

impl<'a> Selection<'a> {
    /// The rows of a request.
    ///
    /// # Errors
    /// [`PlotError`]: unknown column or estimator, a score of words, no row.
    pub fn new(dataset: &'a Dataset, request: &PlotRequest) -> Result<Self, PlotError> {
        let score = column(dataset, &request.y, is_numeric)?;
        let DatasetValues::Numbers(values) = &score.values else {
            return Err(PlotError::Words {
                name: request.y.clone(),
                allowed: names(dataset, is_numeric),
            });
        };
        let labels = dataset.estimators();
        if let Some(name) = request
            .estimators
            .iter()
            .find(|e| !labels.contains(&e.as_str()))
        {
            return Err(PlotError::Estimator {
                name: name.clone(),
                allowed: labels.iter().map(|&l| l.to_owned()).collect(),
            });
        }
        let chosen = |label: &str| {
            request.estimators.is_empty() || request.estimators.iter().any(|e| e == label)
        };
        let mut counts = vec![(0, 0); labels.len()];
        let mut rows = Vec::new();
        for (row, (estimator, value)) in dataset.words("estimator").iter().zip(values).enumerate() {
            let place = estimator.as_deref().filter(|e| chosen(e));
            let place = place.and_then(|e| labels.iter().position(|l| *l == e));
            let Some((place, count)) = place.and_then(|p| Some((p, counts.get_mut(p)?))) else {
                continue;
            };
            match value.filter(|v| v.is_finite()) {
                Some(value) => {
                    count.0 += 1;
                    rows.push(Row {
                        row,
                        estimator: place,
                        value,
                    });
                }
                None => count.1 += 1,
            }
        }
        if rows.is_empty() {
            return Err(nothing(dataset, &request.y));
        }
        let all = labels.iter().copied().zip(counts).enumerate();
        let with = |(place, (label, count)): (usize, (&'a str, (usize, usize)))| {
            (count.0 > 0).then_some((place, label))
        };
        let estimators: Vec<_> = all.clone().filter_map(with).collect();
        for row in &mut rows {
            let place = estimators
                .iter()
                .position(|(place, _)| *place == row.estimator);
            row.estimator = place.unwrap_or(0);
        }
        let without = all.filter(|(_, (_, count))| count.1 > 0);
        let without = without
            .map(|(_, (label, count))| (label, count.1))
            .collect();
        Ok(Self {
            dataset,
            score,
            estimators,
            rows,
            without,
        })
    }

    /// Name of the score with its unit.
    pub fn score_label(&self) -> String {
        with_unit(self.score)
    }

    /// Scores of an estimator.
    pub fn scores(&self, estimator: usize) -> impl Iterator<Item = f64> + Clone {
        let rows = self.rows.iter().filter(move |r| r.estimator == estimator);
        rows.map(|r| r.value)
    }

    /// Spacing of the score.
    ///
    /// # Errors
    /// [`PlotError::NotPositive`]
    pub fn score_spacing(&self, asked: Option<Spacing>) -> Result<Spacing, PlotError> {
        let values = self.rows.iter().map(|r| r.value);
        spacing(&self.score.name, values, asked, false)
    }
}

/// Values of the rows of a selection along one column.
pub struct Axis {
    /// Name and unit.
    pub label: String,
    /// Name of the column.
    pub name: String,
    /// One a row of the selection: a number, or the place of its word; `None` where the column has none.
    pub values: Vec<Option<f64>>,
    /// The words, where the column holds words.
    pub words: Option<Vec<String>>,
    /// Spacing of numbers.
    pub spacing: Spacing,
    /// Whether the study lists the values: each is a place of its own.
    pub listed: bool,
}

impl Axis {
    /// An axis along a column.
    ///
    /// # Errors
    /// [`PlotError`]: unknown column, a single value, logarithmic and not positive.
    pub fn new(
        selection: &Selection<'_>,
        name: &str,
        asked: Option<Spacing>,
    ) -> Result<Self, PlotError> {
        let dataset = selection.dataset;
        let column = column(dataset, name, |_| true)?;
        let rows = || selection.rows.iter().map(|r| r.row);
        let (values, words): (Vec<Option<f64>>, _) = match &column.values {
            DatasetValues::Numbers(all) => {
                let value = |row: usize| all.get(row).copied().flatten().filter(|v| v.is_finite());
                (rows().map(value).collect(), None)
            }
            DatasetValues::Words(all) => {
                let word = |row: usize| all.get(row).and_then(Option::as_ref);
                let words = distinct(rows().filter_map(word));
                let place = |word: &String| words.iter().position(|w| w == word);
                let values = rows().map(|row| Some(place(word(row)?)? as f64));
                let words: Vec<String> = words.iter().map(|&w| w.to_owned()).collect();
                (values.collect(), Some(words))
            }
        };
        let found = sorted(values.iter().flatten().copied());
        if found.len() < 2 {
            let only = found.first().map_or("nothing".to_owned(), |v| {
                let word = words.as_ref().and_then(|w| w.first());
                word.cloned().unwrap_or_else(|| label(*v, 0.0))
            });
            return Err(PlotError::OneValue {
                name: name.to_owned(),
                value: only,
                varying: varying(selection),
            });
        }
        let drawn = dataset.is_drawn_logarithmic(name);
        let mut axes = dataset.study.axes.iter();
        let listed = axes.any(|axis| {
            !matches!(axis.values, AxisValues::Drawn(_)) && axis.keys.iter().any(|k| k == name)
        });
        Ok(Self {
            label: with_unit(column),
            name: name.to_owned(),
            spacing: match words {
                Some(_) => Spacing::Linear,
                None => spacing(name, found.iter().copied(), asked, drawn)?,
            },
            values,
            words,
            listed,
        })
    }

    /// Its values, each once, ascending.
    pub fn places(&self) -> Vec<f64> {
        sorted(self.values.iter().flatten().copied())
    }
}

/// The keys with more than one value, seeds last.
pub fn varying(selection: &Selection<'_>) -> Vec<String> {
    let keys = selection
        .dataset
        .keys()
        .filter(|key| varies(selection, key));
    let (seeds, others): (Vec<&str>, Vec<&str>) = keys.partition(|key| SEEDS.contains(key));
    others.into_iter().chain(seeds).map(str::to_owned).collect()
}

/// The first of the keys that vary together, of each axis that varies, seeds last.
pub fn varying_apart(selection: &Selection<'_>) -> Vec<String> {
    let axes = &selection.dataset.study.axes;
    let first = |key: &String| {
        let axis = axes.iter().find(|axis| axis.keys.contains(key));
        let mut keys = axis.into_iter().flat_map(|axis| &axis.keys);
        keys.find(|k| varies(selection, k)) == Some(key)
    };
    varying(selection).into_iter().filter(first).collect()
}

fn varies(selection: &Selection<'_>, key: &str) -> bool {
    let rows = || selection.rows.iter().map(|r| r.row);
    match selection.dataset.column(key).map(|c| &c.values) {
        Some(DatasetValues::Numbers(values)) => {
            let numbers = rows().filter_map(|row| values.get(row).copied().flatten());
            sorted(numbers).len() > 1
        }
        Some(DatasetValues::Words(values)) => {
            let words = rows().filter_map(|row| values.get(row).and_then(Option::as_ref));
            distinct(words).len() > 1
        }
        None => false,
    }
}

/// Each value once, ascending.
fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn spacing(
    name: &str,
    values: impl Iterator<Item = f64> + Clone,
    asked: Option<Spacing>,
    drawn_logarithmic: bool,
) -> Result<Spacing, PlotError> {
    let chosen = asked.unwrap_or(match drawn_logarithmic {
        true => Spacing::Logarithmic,
        false => Spacing::of(values.clone()),
    });
    match values.clone().find(|v| *v <= 0.0) {
        Some(value) if chosen == Spacing::Logarithmic => Err(PlotError::NotPositive {
            name: name.to_owned(),
            value,
        }),
        _ => Ok(chosen),
    }
}

/// Name and unit of a column.
pub fn with_unit(column: &DatasetColumn) -> String {
    match column.unit.as_str() {
        "" => column.name.clone(),
        unit => format!("{} ({unit})", column.name),
    }
}

fn is_numeric(column: &DatasetColumn) -> bool {
    matches!(column.values, DatasetValues::Numbers(_))
}

fn names(dataset: &Dataset, allowed: impl Fn(&DatasetColumn) -> bool) -> Vec<String> {
    let columns = dataset.columns.iter().filter(|c| allowed(c));
    columns.map(|c| c.name.clone()).collect()
}

fn column<'a>(
    dataset: &'a Dataset,
    name: &str,
    allowed: impl Fn(&DatasetColumn) -> bool,
) -> Result<&'a DatasetColumn, PlotError> {
    dataset.column(name).ok_or_else(|| PlotError::Column {
        name: name.to_owned(),
        allowed: names(dataset, allowed),
    })
}

/// No row has a score: why not.
fn nothing(dataset: &Dataset, name: &str) -> PlotError {
    let failures = dataset.failures();
    let failed: u64 = failures.iter().map(|f| f.1).sum();
    let reason = match failures.first() {
        _ if dataset.words("estimator").is_empty() => "the dataset has no rows".to_owned(),
        Some((reason, _, first)) if failed == dataset.runs => {
            format!("all {failed} runs failed, run {first}: {reason}")
        }
        Some(_) => format!(
            "{failed} of {} runs failed, and the chosen estimators have none",
            dataset.runs
        ),
        None => "the chosen estimators have none".to_owned(),
    };
    PlotError::Nothing {
        name: name.to_owned(),
        reason,
    }
}
