//! An axis of a chart: from values to places, with its ticks.

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;

/// Range beyond which an axis of positive values is logarithmic: two decades.
const DECADES: f64 = 100.0;
/// Room beside the values, as a share of the axis.
const MARGIN: f64 = 0.04;
/// Ticks of an axis, about.
const TICKS: usize = 7;
/// Most labels of a list of words.
const MOST_WORDS: usize = 14;

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// In proportion to the value.
    Linear,
    /// In proportion to its logarithm.
    Logarithmic,
}

impl Spacing {
    /// Logarithmic for positive values over more than two decades.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        match extremes(values) {
            Some((low, high)) if low > 0.0 && high > DECADES * low => Self::Logarithmic,
            _ => Self::Linear,
        }
    }

    /// The coordinate of a value that is linear along the axis.
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.log10(),
        }
    }

    /// The value at a coordinate.
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Logarithmic => 10f64.powf(coordinate),
        }
    }
}

/// An axis with a range.
#[derive(Clone, Debug)]
pub struct Scale {
    spacing: Spacing,
    /// First and last coordinate.
    low: f64,
    high: f64,
    /// Names of the values 0, 1 and so on, in place of numbers.
    words: Vec<String>,
}

impl Scale {
    /// An axis that holds these values with some room beside. Without a value, or with non-positive ones on a logarithmic
    /// axis, it is that of the others, at least one unit or decade long.
    pub fn around(values: impl IntoIterator<Item = f64>, spacing: Spacing) -> Self {
        let coordinates = values.into_iter().map(|v| spacing.coordinate(v));
        let (low, high) = extremes(coordinates).unwrap_or((0.0, 1.0));
        let room = match high - low {
            span if span > 0.0 => MARGIN * span,
            // A single value stands in the middle.
            _ if spacing == Spacing::Logarithmic => 0.5,
            _ => (0.1 * high.abs()).max(1e-9),
        };
        Self {
            spacing,
            low: low - room,
            high: high + room,
            words: Vec::new(),
        }
    }

    /// The same, from zero on where values of a linear axis are positive and near to zero in comparison to their range.
    pub fn around_errors(values: impl IntoIterator<Item = f64> + Clone, spacing: Spacing) -> Self {
        let mut scale = Self::around(values.clone(), spacing);
        if let (Spacing::Linear, Some((low, high))) = (spacing, extremes(values))
            && low >= 0.0
            && low < 0.7 * high
        {
            scale.low = 0.0;
        }
        scale
    }

    /// An axis from one coordinate to another, without room.
    pub fn between(low: f64, high: f64, spacing: Spacing) -> Self {
        Self {
            spacing,
            low,
            high,
            words: Vec::new(),
        }
    }

    /// An axis with a place for each word.
    pub fn of_words(words: Vec<String>) -> Self {
        Self {
            spacing: Spacing::Linear,
            low: -0.5,
            high: words.len() as f64 - 0.5,
            words,
        }
    }

    /// How values are spread.
    pub fn spacing(&self) -> Spacing {
        self.spacing
    }

    /// First and last value.
    pub fn ends(&self) -> (f64, f64) {
        (self.spacing.value(self.low), self.spacing.value(self.high))
    }

    /// Place of a value: 0 at the start of the axis, 1 at its end; values outside are moved to the end.
    pub fn share(&self, value: f64) -> f64 {
        let share = (self.spacing.coordinate(value) - self.low) / (self.high - self.low);
        // The logarithm of a value that is not positive stands at the start.
        if share.is_nan() {
            0.0
        } else {
            share.clamp(0.0, 1.0)
        }
    }

    /// Values with a label.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if !self.words.is_empty() {
            let step = self.words.len().div_ceil(MOST_WORDS);
            let words = self.words.iter().enumerate().step_by(step);
            return words.map(|(i, word)| (i as f64, word.clone())).collect();
        }
        let values = match self.spacing {
            Spacing::Linear => RangedCoordf64::from(self.low..self.high).key_points(TICKS),
            Spacing::Logarithmic => self.logarithmic(),
        };
        let step = match values.get(..2) {
            Some([a, b]) if self.spacing == Spacing::Linear => b - a,
            _ => 0.0,
        };
        let label = |v: f64| (v, label(v, step));
        values.into_iter().map(label).collect()
    }

    /// Powers of ten; over a short range also two and five times these, or else the ticks of a linear axis.
    fn logarithmic(&self) -> Vec<f64> {
        let mantissas: &[f64] = if self.high - self.low < 2.5 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let powers = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = powers.flat_map(|p| mantissas.iter().map(move |m| m * 10f64.powi(p)));
        let inside = |v: &f64| (self.low..=self.high).contains(&v.log10());
        let values: Vec<f64> = all.filter(inside).collect();
        if values.len() > 1 {
            return values;
        }
        let (low, high) = self.ends();
        RangedCoordf64::from(low..high).key_points(TICKS)
    }
}

/// Least and largest finite value; `None` without any.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite.fold(None, |found, v| match found {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

/// A number without the rounding error of binary fractions: as many decimals as the step needs, four digits without one.
pub fn label(value: f64, step: f64) -> String {
    if value.abs() < 1e-9 * step.abs() || value.abs() < f64::MIN_POSITIVE {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&value.abs()) {
        let text = format!("{value:.3e}");
        // 1.500e-5 as 1.5e-5
        return match text.split_once('e') {
            Some((digits, power)) => {
                let digits = digits.trim_end_matches('0').trim_end_matches('.');
                format!("{digits}e{power}")
            }
            None => text,
        };
    }
    let smallest = if step.abs() > 0.0 {
        step.abs() * 0.1
    } else {
        value.abs() * 1e-3
    };
    let decimals = (-smallest.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the middle of a logarithmic axis is the geometric mean of its ends.
    #[test]
    fn a_logarithmic_axis_is_linear_in_the_logarithm() {
        let scale = Scale::around([0.001, 10.0], Spacing::Logarithmic);
        assert!((scale.share(0.1) - 0.5).abs() < 1e-12);
        let ticks: Vec<String> = scale.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(ticks, ["0.001", "0.01", "0.1", "1", "10"]);
        // No logarithm: at the start.
        assert!(scale.share(-1.0).abs() < 1e-12 && scale.share(0.0).abs() < 1e-12);
    }

    /// Two decades decide; a value that is not positive makes the axis linear.
    #[test]
    fn the_spacing_follows_the_range() {
        assert_eq!(Spacing::of([1.0, 99.0]), Spacing::Linear);
        assert_eq!(Spacing::of([1.0, 101.0]), Spacing::Logarithmic);
        assert_eq!(Spacing::of([0.0, 101.0]), Spacing::Linear);
        assert_eq!(Spacing::of([]), Spacing::Linear);
    }

    /// All ticks lie on the axis, whatever its size, and have different labels.
    #[test]
    fn ticks_are_inside_and_distinct() {
        for spacing in [Spacing::Linear, Spacing::Logarithmic] {
            for size in [1e-7, 0.003, 1.0, 42.0, 1e7] {
                let scale = Scale::around([size, 1.7 * size], spacing);
                let ticks = scale.ticks();
                assert!(ticks.len() > 1, "{spacing:?} {size}: {ticks:?}");
                let (low, high) = scale.ends();
                assert!(ticks.iter().all(|t| (low..=high).contains(&t.0)));
                let mut labels: Vec<_> = ticks.iter().map(|t| &t.1).collect();
                labels.dedup();
                assert_eq!(labels.len(), ticks.len(), "{ticks:?}");
            }
        }
    }

    #[test]
    fn labels_are_short() {
        let cases = [
            (0.1 + 0.2, 0.1, "0.3"),
            (-2.0, 1.0, "-2"),
            (1e-17, 0.5, "0"),
            (1.5e-5, 0.5e-5, "1.5e-5"),
            (120.0, 20.0, "120"),
            (0.012_345, 0.0, "0.01235"),
        ];
        for (value, step, expected) in cases {
            assert_eq!(label(value, step), expected);
        }
    }
}
