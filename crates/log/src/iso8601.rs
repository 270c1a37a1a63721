//! Time stamps as text: ISO 8601 and RFC 3339.

use crate::Stamp;
use chrono::DateTime;

const SECOND: i64 = 1_000_000_000;

/// Date, time of day and zone, with and without marks and seconds.
const FORMATS: [&str; 8] = [
    "%Y-%m-%dT%H:%M:%S%.f%#z",
    "%Y-%m-%dT%H:%M%#z",
    "%Y-%m-%dT%H%M%S%.f%#z",
    "%Y-%m-%dT%H%M%#z",
    "%Y%m%dT%H:%M:%S%.f%#z",
    "%Y%m%dT%H:%M%#z",
    "%Y%m%dT%H%M%S%.f%#z",
    "%Y%m%dT%H%M%#z",
];

/// The stamp of a date with a time of day: `2024-05-01T12:00:00.010Z`, `2024-05-01 14:00:00,01+02:00`,
/// `20240501T120000Z`. Without a zone it counts as UTC. `None` for another text.
pub fn parse(text: &str) -> Option<Stamp> {
    let (date, rest) = text.trim().split_once(['T', 't', ' '])?;
    let is_of_zone = |c: char| !(c.is_ascii_digit() || ":.,".contains(c));
    let (time, zone) = rest.split_at(rest.find(is_of_zone).unwrap_or(rest.len()));
    let zone = match zone.trim() {
        "" | "UTC" | "GMT" => "Z",
        zone => zone,
    };
    let text = format!("{date}T{}{zone}", time.replace(',', "."));
    let read = |format: &str| DateTime::parse_from_str(&text, format).ok();
    // The usual form first: a format is parsed with each text.
    let usual = DateTime::parse_from_rfc3339(&text).ok();
    let found = usual.or_else(|| FORMATS.into_iter().find_map(read))?;
    let whole = found.timestamp().checked_mul(SECOND)?;
    // A second or more in a leap second.
    let rest = i64::from(found.timestamp_subsec_nanos());
    whole.checked_add(rest).map(Stamp::Nanoseconds)
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
