//! The report as text for the terminal.

use crate::report::{Failure, PathReport, Place, Reason};
use crate::setup::Stretch;
use robhaz_record::Grid;

/// Number of stretches of the path in the table.
const ROWS: usize = 10;
/// Number of friction stretches that are listed.
const SHOWN: usize = 5;

impl PathReport {
    /// The verdict, and a table with the place of the least margin in each tenth of the path.
    pub fn text(&self) -> String {
        let header = [
            "x, m", "mu_n", "mu", "margin", "N1, N", "N2, N", "N3, N", "T1, N", "T2, N", "T3, N",
        ];
        let mut table = Grid::new(&[], &header);
        for place in self.shown() {
            table.row(cells(place));
        }
        let tractions = match self.drive {
            "ideal" => "the best tractions",
            "shared" => "the tractions of shared control at rest",
            _ => "the tractions of speed control at rest",
        };
        let clearance = match (self.clearance, self.clearance_x) {
            (Some(clearance), Some(x)) => format!(
                "\nLeast clearance of body and links: {:.0} mm at x = {x:.3} m.",
                1e3 * clearance
            ),
            _ => String::new(),
        };
        format!(
            "Place of the least margin in each tenth of the path, with {tractions}; x is that of the middle wheel\n\
             {}\n{}{clearance}{}",
            table.text(None),
            self.verdict(),
            self.stretches()
        )
    }

    /// A line on the friction stretches; nothing without any.
    fn stretches(&self) -> String {
        let Some(least) = self.stretches.iter().map(|s| s.mu).min_by(f64::total_cmp) else {
            return String::new();
        };
        let one = |s: &Stretch| format!("{} from x = {:.3} to {:.3} m", s.mu, s.from, s.to);
        let shown: Vec<String> = self.stretches.iter().take(SHOWN).map(one).collect();
        let more = match self.stretches.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more, the least of all {least}"),
        };
        format!(
            "\nAvailable friction: {}; the friction stretches of the scene keep their own: {}{more}.",
            self.mu,
            shown.join(", ")
        )
    }

    /// The place with the least margin in each of ten equal parts of the path; one that fails
    /// without a margin first.
    fn shown(&self) -> Vec<&Place> {
        let size = self.places.len().div_ceil(ROWS).max(1);
        let least = |part: &'_ [Place]| -> usize {
            let key = |p: &Place| p.margin.unwrap_or(f64::NEG_INFINITY);
            let order = |a: &usize, b: &usize| key(&part[*a]).total_cmp(&key(&part[*b]));
            (0..part.len()).min_by(order).unwrap_or(0)
        };
        let parts = self.places.chunks(size);
        parts.map(|part| &part[least(part)]).collect()
    }

    /// Whether a wheel needs more than the available friction somewhere: a driven robot can pass
    /// all the same.
    fn has_sliding_wheels(&self) -> bool {
        let needs_more = |place: &Place| place.needed_mu > place.available_mu();
        self.places.iter().any(needs_more)
    }

    /// One line: go or no-go, and why.
    fn verdict(&self) -> String {
        let sigma = match self.mu_sigma {
            s if s > 0.0 => format!(
                "; probability of go {:.3} at a standard deviation of {s}",
                self.probability
            ),
            _ => String::new(),
        };
        match (&self.first_failure, self.margin, self.margin_x) {
            (None, Some(margin), Some(x)) => format!(
                "{}: GO over {:.2} m. Needed friction {:.3}, least margin {margin:.3} at x = {x:.3} m{sigma}.{}",
                self.scene,
                self.distance,
                self.needed_mu.unwrap_or(0.0),
                if self.has_sliding_wheels() {
                    " At places a wheel needs more than there is: it slides, and the robot goes on."
                } else {
                    ""
                },
            ),
            (Some(failure), ..) => format!(
                "{}: NO-GO at x = {:.3} m: {}{sigma}.",
                self.scene,
                failure.x,
                words(failure)
            ),
            (None, ..) => format!("{}: GO{sigma}.", self.scene),
        }
    }
}

/// Reason and amount of a failure.
fn words(failure: &Failure) -> String {
    let reason = failure.reason.words();
    match (failure.reason, failure.by) {
        (Reason::Friction, Some(by)) => format!("{reason} by {by:.3}"),
        (Reason::Torque, Some(by)) => format!("{reason} by {by:.2} N m"),
        (Reason::Tipping, Some(by)) => format!("{reason}; the least loaded wheel lacks {by:.1} N"),
        (Reason::EndStop, Some(by)) => format!("{reason} by {:.1} deg", by.to_degrees()),
        _ => reason.to_owned(),
    }
}

fn cells(place: &Place) -> impl Iterator<Item = String> {
    let (x, available) = (Some(place.x()), place.available_mu());
    let friction = [x, place.needed_mu, available, place.margin].map(|value| number(value, 3));
    let of_wheels = |f: Option<[f64; 3]>| [0, 1, 2].map(|i| number(f.map(|f| f[i]), 1));
    let forces = [place.normal_force, place.traction].map(of_wheels);
    friction.into_iter().chain(forces.into_iter().flatten())
}

/// A value with a number of digits behind the point, `-` without one. A value that rounds to zero
/// has no sign.
fn number(value: Option<f64>, digits: usize) -> String {
    let Some(value) = value else {
        return "-".to_owned();
    };
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: what rounds to zero has no sign, all else keeps it, and no value is a dash.
    #[test]
    fn zero_has_no_sign() {
        let values = [
            (Some(-0.04), 1, "0.0"),
            (Some(-0.0), 3, "0.000"),
            (Some(-0.05001), 1, "-0.1"),
            (Some(-10.0), 0, "-10"),
            (Some(0.04), 1, "0.0"),
            (None, 1, "-"),
        ];
        for (value, digits, expected) in values {
            assert_eq!(number(value, digits), expected, "{value:?}");
        }
    }
}
