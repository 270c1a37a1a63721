//! A quantity over time, thinned out to what a figure can show.

/// Stretches of time into which a whole run is divided; each keeps its lowest and its highest point.
const BUCKETS: u64 = 600;

/// A point: time (s) and value.
pub type Point = (f64, f64);

/// A line over time. Peaks are kept, since every stretch keeps its extremes.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Records in a stretch.
    stride: u64,
    /// Records seen of the current stretch.
    seen: u64,
    extremes: Option<(Point, Point)>,
    /// Pieces of line; between them there is nothing to show.
    pieces: Vec<Vec<Point>>,
    /// Whether the next point belongs to the last piece.
    joined: bool,
}

impl Trace {
    /// An empty trace for a run of `records`.
    pub fn new(records: u64) -> Self {
        Self {
            stride: records.div_ceil(BUCKETS).max(1),
            seen: 0,
            extremes: None,
            pieces: Vec::new(),
            joined: false,
        }
    }

    /// The next record; `None` where there is no value.
    pub fn add(&mut self, time: f64, value: Option<f64>) {
        if let Some(value) = value.filter(|v| v.is_finite()) {
            let point = (time, value);
            let (low, high) = self.extremes.get_or_insert((point, point));
            if value < low.1 {
                *low = point;
            }
            if value > high.1 {
                *high = point;
            }
        }
        self.seen += 1;
        if self.seen == self.stride {
            self.close_stretch();
        }
    }

    /// The pieces of the line, with what is left of the last stretch.
    pub fn pieces(&self) -> Vec<Vec<Point>> {
        let mut whole = self.clone();
        if whole.seen > 0 {
            whole.close_stretch();
        }
        whole.pieces
    }

    fn close_stretch(&mut self) {
        self.seen = 0;
        let Some((low, high)) = self.extremes.take() else {
            self.joined = false;
            return;
        };
        if !self.joined {
            self.pieces.push(Vec::new());
            self.joined = true;
        }
        if let Some(piece) = self.pieces.last_mut() {
            let (first, second) = if low.0 <= high.0 {
                (low, high)
            } else {
                (high, low)
            };
            piece.push(first);
            if second.0 > first.0 {
                piece.push(second);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A peak of a single record among a hundred thousand is not lost.
    #[test]
    fn peaks_survive() {
        let mut trace = Trace::new(100_000);
        for k in 0..100_000 {
            let value = if k == 54_321 { 99.0 } else { f64::from(k % 7) };
            trace.add(f64::from(k), Some(value));
        }
        let pieces = trace.pieces();
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].len() <= 1200);
        assert!(pieces[0].contains(&(54_321.0, 99.0)));
        assert!(pieces[0].is_sorted_by(|a, b| a.0 < b.0));
    }

    /// A short run is kept whole, its last record too.
    #[test]
    fn few_records_are_all_kept() {
        let mut trace = Trace::new(3);
        for k in 0..3 {
            trace.add(f64::from(k), Some(f64::from(k)));
        }
        assert_eq!(trace.pieces(), [[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]]);
    }

    /// A line is not drawn across records without a value.
    #[test]
    fn missing_values_break_the_line() {
        let mut trace = Trace::new(6);
        for (k, value) in [None, Some(1.0), Some(2.0), None, Some(f64::NAN), Some(3.0)]
            .into_iter()
            .enumerate()
        {
            trace.add([0.0, 1.0, 2.0, 3.0, 4.0, 5.0][k], value);
        }
        assert_eq!(
            trace.pieces(),
            [vec![(1.0, 1.0), (2.0, 2.0)], vec![(5.0, 3.0)]]
        );
    }
}
