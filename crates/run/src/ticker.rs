//! Records at equal times.

/// Selects the first record of each period.
#[derive(Clone, Copy, Debug)]
pub struct Ticker {
    period: f64,
    next: f64,
}

impl Ticker {
    /// A ticker with a period (s), due at the first record.
    pub fn new(period: f64) -> Self {
        Self { period, next: 0.0 }
    }

    /// Whether the record at a time (s) is the first of its period.
    pub fn is_due(&mut self, time: f64) -> bool {
        // Times are sums of steps: a rounding error must not postpone a record to the next one.
        let periods = (time / self.period + 1e-6).floor();
        let due = periods >= self.next;
        if due {
            self.next = periods + 1.0;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: of 2 s at 1 kHz a ticker selects its rate times 2 s and the first record, at
    /// most all.
    #[test]
    fn records_are_thinned_evenly() {
        for (rate, expected) in [(60.0, 121), (200.0, 401), (1000.0, 2001), (4000.0, 2001)] {
            let mut ticker = Ticker::new(1.0 / rate);
            let mut time = 0.0;
            let mut count = 0;
            for _ in 0..=2000 {
                count += i32::from(ticker.is_due(time));
                time += 1e-3;
            }
            assert_eq!(count, expected, "{rate} Hz");
        }
    }
}
