//! The result: places along the path, the first failure, go or no-go; and its words.

use crate::setup::PathSetup;
use robhaz_record::Grid;
use serde::Serialize;

/// Why the robot cannot pass a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// The needed friction is above the available friction.
    Friction,
    /// A motor torque would have to be above its limit.
    Torque,
    /// No tractions and N >= 0 balance the robot: a wheel lifts, or the robot tips over.
    Tipping,
    /// All wheels touch the ground only beyond an end stop of pin Q.
    EndStop,
    /// The body or a link touches the ground.
    Clearance,
    /// There is no posture in which all wheels touch the ground.
    Posture,
    /// The linear program failed, which is no statement on the robot.
    Solver,
}

impl Reason {
    /// In words.
    pub const fn words(self) -> &'static str {
        self.words_and_unit().0
    }

    /// Words, and the unit of the amount of the failure.
    const fn words_and_unit(self) -> (&'static str, &'static str) {
        match self {
            Self::Friction => ("the needed friction is above the available friction", "1"),
            Self::Torque => ("a motor torque would be above its limit", "N m"),
            Self::Tipping => (
                "no tractions and N >= 0 balance the robot: it tips over or a wheel lifts",
                "N",
            ),
            Self::EndStop => ("pin Q would be beyond an end stop", "rad"),
            Self::Clearance => ("the body or a link touches the ground", ""),
            Self::Posture => (
                "there is no posture in which all wheels touch the ground",
                "",
            ),
            Self::Solver => ("the linear program failed, so nothing is known", ""),
        }
    }
}

/// A failure at a place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// x of the middle wheel's centre, m.
    pub x: f64,
    /// The reason.
    pub reason: Reason,
    /// By how much: needed minus available friction (-), torque above its limit (N m), load that
    /// the least loaded wheel lacks (N), angle beyond the stop (rad). `None` without a measure.
    pub by: Option<f64>,
    /// Unit of `by`.
    pub unit: &'static str,
}

impl Failure {
    pub(crate) fn new(x: f64, reason: Reason, by: Option<f64>) -> Self {
        let (_, unit) = reason.words_and_unit();
        Self {
            x,
            reason,
            by,
            unit,
        }
    }
}

/// One place of the path. Positions are those of the wheels' centres.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// x of each wheel's centre, front to rear, m.
    pub wheel_x: [f64; 3],
    /// y of each wheel's centre, m.
    pub wheel_y: [f64; 3],
    /// Number of contacts of each wheel.
    pub contacts: [usize; 3],
    /// Angle of pin Q, theta_1 - theta_2, rad.
    pub opening: f64,
    /// The needed friction mu_n, -; `None` where no allowed forces balance the robot.
    pub needed_mu: Option<f64>,
    /// How much the available friction coefficients can all fall, -; below 0 they must rise.
    pub margin: Option<f64>,
    /// Sum of N over the contacts of each wheel at the largest margin, N.
    pub normal_force: Option<[f64; 3]>,
    /// Sum of T over the contacts of each wheel at the largest margin, N.
    pub traction: Option<[f64; 3]>,
    /// Mean speed of the wheels' centres of the driven robot, m/s; `None` for the drive `ideal` and
    /// behind the place where it gets stuck.
    pub speed: Option<f64>,
    /// Least clearance of body and links, m; at 0 or below one of them touches the ground.
    pub clearance: f64,
    /// The bar with the least clearance: `body`, `link1` ...
    pub nearest_bar: &'static str,
    /// Why the robot cannot pass.
    pub failure: Option<Failure>,
}

impl Place {
    /// x of the middle wheel's centre, m.
    pub fn x(&self) -> f64 {
        self.wheel_x[1]
    }

    /// The available friction that belongs to mu_n and margin: where contacts differ in mu, the
    /// equal coefficient with the same margin. -
    pub fn available_mu(&self) -> Option<f64> {
        Some(self.needed_mu? + self.margin?)
    }
}

/// A stretch of the ground with a friction coefficient of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// x of its start, m.
    pub from: f64,
    /// x of its end, m.
    pub to: f64,
    /// Mean of the available friction coefficient on it, -.
    pub mu: f64,
}

/// Judgement of a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathReport {
    /// Name of the scene.
    pub scene: String,
    /// Distribution of the tractions.
    pub drive: &'static str,
    /// Whether the robot can pass the whole path at the mean friction coefficients.
    pub go: bool,
    /// Probability of that when all friction coefficients have the same normally distributed
    /// deviation from their means.
    pub probability: f64,
    /// Mean of the available friction coefficient outside the friction stretches, -.
    pub mu: f64,
    /// The friction stretches of the scene. They keep their own coefficients.
    pub stretches: Vec<Stretch>,
    /// Its standard deviation, -.
    pub mu_sigma: f64,
    /// Largest needed friction of all places that have one, -.
    pub needed_mu: Option<f64>,
    /// How far all friction coefficients can fall before the robot does not pass, -. With the drive
    /// `ideal` it is the least margin of all places. `None` where no friction lets it pass.
    pub margin: Option<f64>,
    /// x of the middle wheel at the least margin, m.
    pub margin_x: Option<f64>,
    /// Least clearance of body and links over the path, m; `None` without a place.
    pub clearance: Option<f64>,
    /// x of the middle wheel there, m.
    pub clearance_x: Option<f64>,
    /// First place that the robot cannot pass.
    pub first_failure: Option<Failure>,
    /// Distance that the middle wheel was to travel, m.
    pub distance: f64,
    /// The places from the start on.
    pub places: Vec<Place>,
}

impl PathReport {
    /// The judgement from its places, from the reason why there are no further ones, and of a
    /// driven robot from how far all friction coefficients can fall.
    pub(crate) fn new(
        setup: &PathSetup,
        places: Vec<Place>,
        end: Option<Failure>,
        driven: Option<Option<f64>>,
    ) -> Self {
        let options = &setup.options;
        let failures = || places.iter().filter_map(|p| p.failure).chain(end);
        let order = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
        let margins = places.iter().filter_map(|p| Some((p.margin?, p.x())));
        let least = margins.min_by(order);
        let clearances = places.iter().map(|p| (p.clearance, p.x()));
        let nearest = clearances.min_by(order);
        let needed = places.iter().filter_map(|p| p.needed_mu);
        let first_failure = failures().next();
        // Friction alone depends on mu.
        let other_reason = failures().any(|f| f.reason != Reason::Friction);
        let margin = driven.unwrap_or(least.map(|l| l.0));
        let margin = margin.filter(|_| !other_reason);
        let spread = driven.zip(least).map_or(0.0, |(_, (margin, x))| {
            MODEL_SPREAD * (setup.mu_at(x) - margin).max(0.0)
        });
        let stretches = setup.scene.terrain.stretches.iter().map(|s| Stretch {
            from: s.from,
            to: s.to,
            mu: s.mu_s,
        });
        let sigma = options.mu_sigma.hypot(spread);
        let probability = match margin {
            Some(margin) if sigma > 0.0 => normal_distribution(margin / sigma),
            _ if first_failure.is_none() => 1.0,
            _ => 0.0,
        };
        Self {
            go: first_failure.is_none(),
            probability,
            needed_mu: needed.max_by(f64::total_cmp),
            margin,
            margin_x: margin.and(least).map(|l| l.1),
            clearance: nearest.map(|n| n.0),
            clearance_x: nearest.map(|n| n.1),
            first_failure,
            scene: setup.scene.name.clone(),
            drive: options.drive.name(),
            mu: setup.mu(),
            stretches: stretches.collect(),
            mu_sigma: options.mu_sigma,
            distance: setup.distance,
            places,
        }
    }
}

/// Standard deviation of the needed friction of a driven robot, over its value: the shares of the
/// tractions follow the estimated normal forces, which err by about 5 %.
const MODEL_SPREAD: f64 = 0.05;

/// Standard normal distribution function.
fn normal_distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Number of stretches of the path in the table.
const ROWS: usize = 10;
/// Needed friction up to which none is needed, -: a hundred times the accuracy of the linear programs.
const NO_FRICTION: f64 = 1e-6;
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
        let key = |p: &Place| p.margin.unwrap_or(f64::NEG_INFINITY);
        let parts = self.places.chunks(size).map(|part| part.iter());
        let least = parts.filter_map(|part| part.min_by(|a, b| key(a).total_cmp(&key(b))));
        least.collect()
    }

    /// Whether a wheel needs all of the available friction somewhere, or more: a driven robot can
    /// pass all the same. Where no friction is needed none slides, also on ground without friction.
    fn has_sliding_wheels(&self) -> bool {
        let slides = |place: &Place| {
            place.margin.is_some_and(|margin| margin <= 0.0)
                && place.needed_mu.is_none_or(|needed| needed > NO_FRICTION)
        };
        self.places.iter().any(slides)
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
                    " At places a wheel needs all there is, or more: it slides, and the robot goes on."
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
        (Reason::Friction, Some(by)) if by < 5e-4 => format!("{reason} by less than 0.001"),
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

    /// Closed form: values of the standard normal distribution from tables of four digits.
    #[test]
    fn the_normal_distribution_is_that_of_the_tables() {
        for (z, p) in [(0.0, 0.5), (1.0, 0.8413), (-1.645, 0.05), (2.0, 0.9772)] {
            assert!((normal_distribution(z) - p).abs() < 6e-5, "{z}");
        }
    }

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
