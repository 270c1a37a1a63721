//! Time stamps as text: ISO 8601 and RFC 3339.

use crate::stamp::Stamp;

const SECOND: i64 = 1_000_000_000;

/// The stamp of a date with a time of day: `2024-05-01T12:00:00.010Z`, `2024-05-01 14:00:00,01+02:00`,
/// `20240501T120000Z`. Without a zone it counts as UTC. `None` for another text.
pub fn parse(text: &str) -> Option<Stamp> {
    let mut rest = Digits(text.trim());
    let year = rest.number(4)?;
    let has_marks = rest.skip('-');
    let month = rest.number(2)?;
    if rest.skip('-') != has_marks {
        return None;
    }
    let day = rest.number(2)?;
    if !(rest.skip('T') || rest.skip('t') || rest.skip(' ')) {
        return None;
    }
    let hour = rest.number(2)?;
    let has_marks = rest.skip(':');
    let minute = rest.number(2)?;
    let mut nanoseconds = 0;
    let mut second = 0;
    if rest.skip(':') || !has_marks && rest.starts_with_digit() {
        second = rest.number(2)?;
        if rest.skip('.') || rest.skip(',') {
            nanoseconds = rest.fraction()?;
        }
    }
    let zone = rest.zone()?;
    let is_date = (1..=12).contains(&month) && (1..=days_of(year, month)).contains(&day);
    // 60 is a leap second.
    if !is_date || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let seconds = days_since_1970(year, month, day) * 86_400 + hour * 3_600 + minute * 60 + second;
    let whole = (seconds - zone).checked_mul(SECOND)?;
    whole.checked_add(nanoseconds).map(Stamp::Nanoseconds)
}

/// What is left of a text.
struct Digits<'a>(&'a str);

impl Digits<'_> {
    fn starts_with_digit(&self) -> bool {
        self.0.starts_with(|c: char| c.is_ascii_digit())
    }

    /// A number of so many digits.
    fn number(&mut self, digits: usize) -> Option<i64> {
        let (number, rest) = self.0.split_at_checked(digits)?;
        let is_number = number.bytes().all(|b| b.is_ascii_digit());
        self.0 = rest;
        is_number.then(|| number.parse().ok()).flatten()
    }

    fn skip(&mut self, mark: char) -> bool {
        let rest = self.0.strip_prefix(mark);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    /// Digits of a fraction of a second, as nanoseconds; those beyond are cut.
    fn fraction(&mut self) -> Option<i64> {
        let end = self.0.find(|c: char| !c.is_ascii_digit());
        let (digits, rest) = self.0.split_at(end.unwrap_or(self.0.len()));
        self.0 = rest;
        let nine: String = digits.chars().chain("000000000".chars()).take(9).collect();
        (!digits.is_empty()).then(|| nine.parse().ok()).flatten()
    }

    /// Seconds of the zone east of UTC, at the end of the text.
    fn zone(&mut self) -> Option<i64> {
        self.0 = self.0.trim_start();
        if self.0.is_empty() || matches!(self.0, "Z" | "z" | "UTC" | "GMT") {
            return Some(0);
        }
        let sign = match (self.skip('+'), self.skip('-') || self.skip('\u{2212}')) {
            (true, false) => 1,
            (false, true) => -1,
            _ => return None,
        };
        let hours = self.number(2)?;
        self.skip(':');
        let minutes = if self.0.is_empty() {
            0
        } else {
            self.number(2)?
        };
        let is_zone = self.0.is_empty() && hours < 24 && minutes < 60;
        is_zone.then_some(sign * (hours * 3_600 + minutes * 60))
    }
}

fn days_of(year: i64, month: i64) -> i64 {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days of the Gregorian calendar since 1970-01-01.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    // Years that start in March, so that the leap day is the last one.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days_of_year = (153 * month + 2) / 5 + day - 1;
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    year * 365 + leap_days + days_of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known instants: those of `date -u -d TEXT +%s`.
    #[test]
    fn instants_are_known() {
        for (text, seconds, nanoseconds) in [
            ("1970-01-01T00:00:00Z", 0, 0),
            ("2024-05-01T12:00:00.010Z", 1_714_564_800, 10_000_000),
            ("2024-05-01 12:00:00,010", 1_714_564_800, 10_000_000),
            ("2024-05-01T14:00:00.01+02:00", 1_714_564_800, 10_000_000),
            ("2024-05-01T06:30-0530", 1_714_564_800, 0),
            ("20240501T120000.123456789123Z", 1_714_564_800, 123_456_789),
            ("2000-02-29T23:59:60Z", 951_868_800, 0),
            ("1969-12-31 23:59:59.5 UTC", -1, 500_000_000),
        ] {
            let expected = Stamp::Nanoseconds(seconds * SECOND + nanoseconds);
            assert_eq!(parse(text), Some(expected), "{text}");
        }
        for text in [
            "",
            "2024-05-01",
            "12:00:00",
            "1714564800",
            "2024-13-01T00:00:00Z",
            "2023-02-29T00:00:00Z",
            "2024-05-01T12:00:00.Z",
            "2024-05-01T25:00:00Z",
            "2024-05-01T12:00:00+2",
            "01.05.2024 12:00:00",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
