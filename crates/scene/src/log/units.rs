//! Units that a table states of a column: in brackets, at the end of the name, in the metadata of a Parquet field.
//! One that contradicts the description is an error: nothing in the numbers need show it.

use Kind::{Angle, Counts, Current, Force, Other, Rate, Time, Torque};
use std::f64::consts::{PI, TAU};

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An angle.
    Angle,
    /// Counts of an encoder.
    Counts,
    /// A torque.
    Torque,
    /// A current, of a motor.
    Current,
    /// An angular velocity.
    Rate,
    /// A time.
    Time,
    /// A force.
    Force,
    /// What no reading is in.
    Other,
}

/// A unit: what it measures, and its factor to the SI unit of that.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As it is written.
    pub name: String,
    /// What it measures.
    pub kind: Kind,
    /// Its factor to the SI unit.
    pub factor: f64,
}

const DEGREE: f64 = PI / 180.0;

/// Units by their names without spaces and multiplication signs, in small letters.
const UNITS: &[(Kind, f64, &str)] = &[
    (Angle, 1.0, "rad radian radians"),
    (Angle, 1e-3, "mrad milliradian milliradians"),
    (Angle, DEGREE, "deg degs degree degrees \u{b0} \u{ba}"),
    (Angle, DEGREE, "\u{2da}"),
    (Angle, PI / 180e3, "mdeg millidegree millidegrees"),
    (Angle, TAU, "turn turns rev revs revolution revolutions rot"),
    (Angle, TAU, "rotations"),
    (Counts, 1.0, "count counts cnt cnts tick ticks pulse pulses"),
    (Torque, 1.0, "nm newtonmetre newtonmetres newtonmeter"),
    (Torque, 1.0, "newtonmeters"),
    (Torque, 1e-3, "mnm nmm millinewtonmetre millinewtonmeter"),
    (Torque, 1e-2, "ncm"),
    (Torque, 1e-6, "unm \u{b5}nm \u{3bc}nm"),
    (Torque, 1e3, "knm"),
    (Torque, 0.098_066_5, "kgcm kgfcm kpcm"),
    (Torque, 9.806_65, "kgm kgfm kpm"),
    (Torque, 1.355_818, "lbft ftlb lbfft ftlbf"),
    (Torque, 0.112_985, "lbin inlb lbfin inlbf"),
    (Torque, 0.007_061_6, "ozin inoz ozfin"),
    (Current, 1.0, "a amp amps ampere amperes"),
    (Current, 1e-3, "ma milliamp milliamps milliampere"),
    (Current, 1e-3, "milliamperes"),
    (Current, 1e-6, "ua \u{b5}a \u{3bc}a"),
    (Rate, 1.0, "rad/s rad/sec rad/second rads^1 rads1"),
    (Rate, 1.0, "rads\u{207b}\u{b9} radps radpers radpersec"),
    (Rate, 1.0, "radpersecond radianspersecond"),
    (Rate, 1e-3, "mrad/s mrad/sec mradps"),
    (Rate, DEGREE, "deg/s deg/sec deg/second degs^1 degs1"),
    (Rate, DEGREE, "degs\u{207b}\u{b9} \u{b0}/s \u{b0}/sec"),
    (Rate, DEGREE, "\u{ba}/s dps degps degpers degpersec"),
    (Rate, DEGREE, "degpersecond degrees/s degrees/sec degree/s"),
    (Rate, DEGREE, "degreespersecond"),
    (Rate, PI / 180e3, "mdps mdeg/s"),
    (Rate, TAU / 60.0, "rpm r/min rev/min turns/min 1/min u/min"),
    (Rate, TAU / 60.0, "min^1 min1 min\u{207b}\u{b9}"),
    (Rate, TAU, "rps r/s rev/s revs/s turns/s turn/s"),
    (Time, 1.0, "s sec secs second seconds"),
    (Time, 1e-3, "ms msec msecs millis millisecond milliseconds"),
    (Time, 1e-6, "us \u{b5}s \u{3bc}s usec usecs micros"),
    (Time, 1e-6, "microsecond microseconds"),
    (Time, 1e-9, "ns nsec nsecs nanosec nanosecs nanos"),
    (Time, 1e-9, "nanosecond nanoseconds"),
    (Time, 60.0, "min mins minute minutes"),
    (Time, 3600.0, "h hr hour hours"),
    (Force, 1.0, "n newton newtons"),
    (Force, 1e3, "kn kilonewton kilonewtons"),
    (Other, 1.0, "v mv volt volts m mm cm m/s m/s^2 m/s2 g %"),
    (Other, 1.0, "percent pwm w watt \u{b0}c"),
];

impl Unit {
    /// The unit of a name, however it is written.
    pub fn of(name: &str) -> Option<Self> {
        let is_left_out = |c: &char| " \u{a0}\t*.\u{b7}\u{22c5}\u{d7}-_".contains(*c);
        let plain: String = name.trim().chars().filter(|c| !is_left_out(c)).collect();
        let plain = plain.to_lowercase();
        let mut all = UNITS.iter();
        let (kind, factor, _) =
            all.find(|(.., names)| names.split(' ').any(|name| name == plain))?;
        Some(Self {
            name: name.trim().to_owned(),
            kind: *kind,
            factor: *factor,
        })
    }

    /// Whether two names mean the same unit, however they are written.
    pub fn is_same(one: &str, other: &str) -> bool {
        match (Self::of(one), Self::of(other)) {
            (Some(a), Some(b)) => a.kind == b.kind && a.factor.to_bits() == b.factor.to_bits(),
            _ => one == other,
        }
    }

    /// The unit in the name of a column that is taken for a quantity of a kind: in brackets anywhere, after a slash, a
    /// comma or `in`, or as one of its words.
    pub fn in_name(name: &str, taken_for: Kind) -> Option<Self> {
        let brackets = [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')];
        let in_brackets = brackets.iter().find_map(|(open, close)| {
            let (_, rest) = name.split_once(*open)?;
            Self::of(rest.split_once(*close)?.0)
        });
        let after = |mark: &str| Self::of(name.rsplit_once(mark)?.1);
        let behind = || [" / ", ", ", " in "].into_iter().find_map(after);
        let found = in_brackets.or_else(behind);
        found.or_else(|| Self::of_words(name, taken_for))
    }

    /// The unit among the words of a name: `wheel1_angle_deg`, `torque_mNm`, `gyro_dps_y`, `rate_rad_s`, `angleDeg`.
    fn of_words(name: &str, taken_for: Kind) -> Option<Self> {
        let is_mark = |c: char| !(c.is_alphanumeric() || "\u{b0}\u{ba}\u{2da}%".contains(c));
        let parts = name.split(is_mark).filter(|part| !part.is_empty());
        // Words of an unseparated name begin with capitals, but `mNm` is one.
        let words = parts.flat_map(|part| match Self::of(part) {
            None if part != "mN" => humps(part),
            _ => vec![part],
        });
        let words: Vec<&str> = words.collect();
        for (i, word) in words.iter().enumerate() {
            let behind = &words[i + 1..];
            let of_more = match behind {
                [per, second, ..] if per.eq_ignore_ascii_case("per") => {
                    Self::of(&format!("{word}/{second}"))
                }
                [next, ..] if ["N", "mN"].contains(word) => Self::of(&format!("{word}{next}")),
                [next, ..] if ["s", "sec", "second"].contains(&&*next.to_lowercase()) => {
                    Self::of(&format!("{word}/s"))
                }
                _ => None,
            };
            let is_it = |unit: &Self| unit.is_word(word, name, taken_for, behind.is_empty());
            if let Some(unit) = of_more.or_else(|| Self::of(word).filter(is_it)) {
                return Some(unit);
            }
        }
        None
    }

    /// Whether a word of a name means this unit, and not something else: short words only at the end, and of what
    /// the column is taken for. `rad` is also a wheel in German, `a` a name.
    fn is_word(&self, word: &str, name: &str, taken_for: Kind, ends: bool) -> bool {
        let is_time = taken_for == Kind::Time;
        match self.kind {
            Kind::Time => is_time && ends,
            Kind::Force | Kind::Other => false,
            _ if is_time => false,
            // `ma` may be a moving average, `A` a motor.
            Kind::Current if matches!(word, "A" | "a" | "ma" | "MA" | "Ma") => {
                let lower = name.to_lowercase();
                let hints = ["current", "strom", "amp"];
                word != "a" && ends && hints.iter().any(|hint| lower.contains(hint))
            }
            Kind::Current | Kind::Torque => {
                taken_for == Kind::Torque && (ends || word.contains('N') || word.contains("mA"))
            }
            Kind::Counts => ends,
            Kind::Angle if word.eq_ignore_ascii_case("rad") => ends && taken_for != Kind::Torque,
            // A turn of a wheel, its rotation: quantities, not units.
            Kind::Angle if self.factor > 1.0 => ends && !matches!(word, "turn" | "rot"),
            Kind::Angle | Kind::Rate => true,
        }
    }
}

/// The words of a name in which each begins with a capital: `gyroYDps`, `rateDPS`.
fn humps(part: &str) -> Vec<&str> {
    let chars: Vec<(usize, char)> = part.char_indices().collect();
    let begins = |k: &usize| {
        let (before, next) = (chars[k - 1].1, chars.get(k + 1));
        let ends_lower = before.is_lowercase() || before.is_ascii_digit();
        let starts_lower = next.is_some_and(|(_, next)| next.is_lowercase());
        chars[*k].1.is_uppercase() && (ends_lower || starts_lower)
    };
    let begins = (1..chars.len()).filter(begins).map(|k| chars[k].0);
    let mut start = 0;
    let ends = begins.chain([part.len()]);
    ends.map(|end| &part[std::mem::replace(&mut start, end)..end])
        .collect()
}

/// Largest factor between what is stated and what the column's unit asks for: a gear's efficiency is above a half,
/// the smallest factor of a wrong unit 2 pi.
const AGREES: f64 = 2.0;

impl Unit {
    /// Whether a column with a unit of its own has this one, which a description states; of counts and currents, that of
    /// angle and torque. `scale`: that of the description, without its sign.
    pub fn agrees(&self, scale: f64, column: &Self) -> bool {
        let is_scaled = (scale - 1.0).abs() > 1e-9;
        let is_same = |factor: f64| (self.factor / factor - 1.0).abs() < 1e-6;
        let fits = |factor: f64| {
            let ratio = self.factor * scale / factor;
            is_same(factor) || (1.0 / AGREES..=AGREES).contains(&ratio)
        };
        match (self.kind, column.kind) {
            (a, b) if a == b => a == Kind::Counts || fits(column.factor),
            // The time may be a column of another quantity.
            (Kind::Time, _) => true,
            // `gyro_deg` is in degrees a second.
            (Kind::Rate, Kind::Angle) => fits(column.factor),
            // The scale may hold the torque constant, or the counts in a turn.
            (Kind::Torque, Kind::Current | Kind::Force | Kind::Other)
            | (Kind::Angle, Kind::Counts | Kind::Force | Kind::Other)
            | (Kind::Rate, Kind::Force | Kind::Other) => is_scaled,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests;
