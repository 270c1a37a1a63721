//! Reasons why a profile is refused.

/// Reason why a profile is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// Too few points.
    #[error("found {found} points; there must be at least 2")]
    FewPoints {
        /// Number of points.
        found: usize,
    },
    /// A coordinate of a point is not finite.
    #[error("point {point}: a coordinate is not a finite number")]
    Point {
        /// Index of the point, from 0.
        point: usize,
    },
    /// A point does not lie in front of the previous one.
    #[error("point {point}: x is {found} m; it must be above that of the point before, {before} m")]
    Order {
        /// Index of the point, from 0.
        point: usize,
        /// Its x, m.
        found: f64,
        /// x of the previous point, m.
        before: f64,
    },
    /// A part of a course is level ground, or a course itself.
    #[error("part {part} is level ground or a sequence itself")]
    Part {
        /// Index of the part, from 0.
        part: usize,
    },
    /// A part of a course starts before the end of the previous one.
    #[error("part {part} starts at {start} m, before the end of the part before, {end} m")]
    Overlap {
        /// Index of the part, from 0.
        part: usize,
        /// x of its start, m.
        start: f64,
        /// x of the end of the previous part, m.
        end: f64,
    },
    /// A number is out of its range.
    #[error("{entry} is {found}; it must be {allowed}")]
    Range {
        /// Name of the parameter.
        entry: &'static str,
        /// Its value.
        found: f64,
        /// The allowed values; completes the sentence "it must be ...".
        allowed: &'static str,
    },
}
