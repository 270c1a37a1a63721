//! A quantity over time, reduced to the resolution of a figure.

/// Number of intervals into which a run is divided.
const INTERVALS: u64 = 600;

/// A point: abscissa (time in s, or position in m) and value.
pub type Point = (f64, f64);

/// Extremes and mean of one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Interval {
    /// Lowest and highest point.
    low: Point,
    high: Point,
    /// Whether the highest point came before the lowest.
    high_first: bool,
    /// Sums over the points, and their number.
    sum: Point,
    count: f64,
}

impl Interval {
    fn new(point: Point) -> Self {
        Self {
            low: point,
            high: point,
            high_first: false,
            sum: point,
            count: 1.0,
        }
    }

    fn add(&mut self, point: Point) {
        if point.1 < self.low.1 {
            self.low = point;
            self.high_first = true;
        }
        if point.1 > self.high.1 {
            self.high = point;
            self.high_first = false;
        }
        self.sum = (self.sum.0 + point.0, self.sum.1 + point.1);
        self.count += 1.0;
    }

    fn mean(&self) -> Point {
        (self.sum.0 / self.count, self.sum.1 / self.count)
    }
}

/// A line over time. Each interval keeps its extremes, so that no peak is lost, and its mean.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Records in an interval. With one record, mean and extremes are the same.
    stride: u64,
    /// Records of the current interval so far.
    seen: u64,
    current: Option<Interval>,
    /// `None` where no record has a value: the line has a gap.
    intervals: Vec<Option<Interval>>,
}

impl Trace {
    /// An empty trace for a run of `records`.
    pub fn new(records: u64) -> Self {
        Self {
            stride: records.div_ceil(INTERVALS).max(1),
            seen: 0,
            current: None,
            intervals: Vec::new(),
        }
    }

    /// The next record; `None` where there is no value.
    pub fn add(&mut self, at: f64, value: Option<f64>) {
        if let Some(value) = value.filter(|v| v.is_finite()) {
            let point = (at, value);
            match &mut self.current {
                Some(interval) => interval.add(point),
                None => self.current = Some(Interval::new(point)),
            }
        }
        self.seen += 1;
        if self.seen == self.stride {
            self.seen = 0;
            self.intervals.push(self.current.take());
        }
    }

    /// Pieces of the line through the extremes of every interval.
    pub fn extremes(&self) -> Vec<Vec<Point>> {
        self.pieces(|s| match (s.low == s.high, s.high_first) {
            (true, _) => vec![s.low],
            (false, true) => vec![s.high, s.low],
            (false, false) => vec![s.low, s.high],
        })
    }

    /// Pieces of the line through the means of every interval.
    pub fn means(&self) -> Vec<Vec<Point>> {
        self.pieces(|s| vec![s.mean()])
    }

    /// Pieces of the line along the lowest values of every interval, over the interval's mean
    /// abscissa.
    pub fn lows(&self) -> Vec<Vec<Point>> {
        self.pieces(|s| vec![(s.mean().0, s.low.1)])
    }

    /// Pieces of the line along the highest values of every interval, over the interval's mean
    /// abscissa.
    pub fn highs(&self) -> Vec<Vec<Point>> {
        self.pieces(|s| vec![(s.mean().0, s.high.1)])
    }

    /// The points of all intervals between gaps, with the last interval as far as it came.
    fn pieces(&self, points: impl Fn(&Interval) -> Vec<Point>) -> Vec<Vec<Point>> {
        let mut all = self.intervals.clone();
        all.push(self.current);
        let pieces = all.split(Option::is_none).filter(|piece| !piece.is_empty());
        let line = |piece: &[Option<Interval>]| piece.iter().flatten().flat_map(&points).collect();
        pieces.map(line).collect()
    }
}

/// A quantity with two standard deviations around it.
#[derive(Clone, Debug)]
pub struct Estimated {
    /// The quantity.
    pub line: Trace,
    lower: Trace,
    upper: Trace,
}

impl Estimated {
    /// Without values, for a run of `records`.
    pub fn new(records: u64) -> Self {
        let [line, lower, upper] = [(); 3].map(|()| Trace::new(records));
        Self { line, lower, upper }
    }

    /// The next record: value, and one standard deviation; `None` where there is none.
    pub fn add(&mut self, at: f64, value: Option<f64>, sigma: Option<f64>) {
        self.add_around(at, value, value, sigma);
    }

    /// The next record of a value whose deviations are those around a `centre`, also where there is
    /// no value.
    pub fn add_around(
        &mut self,
        at: f64,
        value: Option<f64>,
        centre: Option<f64>,
        sigma: Option<f64>,
    ) {
        let bound = |side: f64| Some(centre? + side * 2.0 * sigma?);
        self.line.add(at, value);
        self.lower.add(at, bound(-1.0));
        self.upper.add(at, bound(1.0));
    }

    /// Whether it has standard deviations.
    pub fn has_band(&self) -> bool {
        !self.band().is_empty()
    }

    /// Closed outlines of the pieces of its band. In an interval it spans from the lowest lower to
    /// the highest upper bound.
    pub fn band(&self) -> Vec<Vec<Point>> {
        let (lower, upper) = (self.lower.lows(), self.upper.highs());
        let pieces = lower.iter().zip(&upper).filter(|(low, _)| low.len() > 1);
        pieces
            .map(|(low, high)| low.iter().chain(high.iter().rev()).copied().collect())
            .collect()
    }
}
