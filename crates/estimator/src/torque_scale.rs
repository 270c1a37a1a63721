//! The torques against the weight: the ratio of the torques to those that the described robot
//! needs.
//!
//! A payload makes it greater just as torques do that are read too large: no reading tells them
//! apart. What is stated of the forces holds under the budget, in which both are right; the ratio,
//! found by the [`WorkBalance`], says whether the readings confirm that. Beyond the budget the
//! forces are those of the described masses with scaled torques, and their deviations contain what
//! a payload would change.

mod passage;

use crate::deviation::{GATE, SIGNIFICANT, WITHIN};
use crate::filters::Kalman;
use passage::Passage;
pub(crate) use passage::Rolling;

/// Whether the readings confirm that torques and weight fit each other. The stated deviations hold
/// if they do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Confirmation {
    /// The readings do not show it: level ground, slopes that wheels which work against each other
    /// drown, or a ratio between what confirms and what contradicts.
    #[default]
    Unconfirmed,
    /// The ratio is known, and 1 within what is known of it.
    Confirmed,
    /// The ratio is beyond what the budget of gains and masses allows.
    Contradicts,
}

impl Confirmation {
    /// As in tables: `unconfirmed`, `confirmed`, `contradicts`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unconfirmed => "unconfirmed",
            Self::Confirmed => "confirmed",
            Self::Contradicts => "contradicts",
        }
    }
}

/// The torques against the weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueScale {
    /// Torque readings over the torques that the described robot needs, -: above 1 the robot is
    /// heavier than described, or its torques are read too large.
    pub ratio: f64,
    /// Its standard deviation; about 1 before the readings show anything.
    pub sigma: f64,
    /// What follows from it.
    pub confirmation: Confirmation,
}

impl TorqueScale {
    /// In words, for a robot of which one side is described to have the mass `described`, kg.
    pub fn in_words(self, described: f64) -> impl core::fmt::Display {
        /// Relative deviation from which on the ratio says nothing.
        /// Chosen.
        const VAGUE: f64 = 0.1;
        let Self {
            ratio,
            sigma,
            confirmation,
        } = self;
        core::fmt::from_fn(move |f| {
            let verdict = confirmation.name();
            if confirmation == Confirmation::Unconfirmed && !(sigma < VAGUE * ratio) {
                return write!(
                    f,
                    "weight {verdict} by the torques: level ground, or slopes drowned by wheels that work against each other"
                );
            }
            let (fits, error) = (ratio * described, sigma * described);
            // Three digits of a light robot; the cast saturates.
            let places = (2.0 - libm::floor(libm::log10(described))).clamp(1.0, 9.0) as usize;
            write!(
                f,
                "weight {verdict}: torques fit a robot of {fits:.places$} +- {error:.places$} kg a side; the description says {described:.places$}",
            )?;
            if confirmation == Confirmation::Contradicts {
                write!(
                    f,
                    ": other masses (a payload), or torques read at {ratio:.2} of their size (gear efficiency, motor constant), the wheels' radius, the inclinometers' scale"
                )?;
            }
            Ok(())
        })
    }
}

/// Finds the ratio, and decides what follows from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScaleFilter {
    balance: WorkBalance,
    /// What follows from the ratio.
    confirmation: Confirmation,
    /// Ratio with which weight and inertia are multiplied, so that they fit the torques as they are
    /// read: 1 unless they contradict each other.
    pub applied: f64,
    /// Relative standard deviation that all stated forces have from a ratio that is applied: a
    /// payload would change them by as much.
    pub deviation: f64,
}

impl ScaleFilter {
    /// Deviations below which a ratio beyond [`GATE`], which contradicts the budget, agrees again.
    /// Half of the alarm.
    const AGREES: f64 = 0.5 * GATE;
    /// Largest relative deviation of a ratio that confirms: a payload of a fifteenth of the robot's
    /// mass is then beyond two deviations.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const CONFIRMS: f64 = 0.03;
    /// Least ratio: motor torques that are 20 times too small.
    /// Guard.
    const LEAST: f64 = 0.05;

    /// See [`WorkBalance::new`].
    pub fn new(between: f64, resisted: f64, gain: f64) -> Self {
        Self {
            balance: WorkBalance::new(between, resisted, gain),
            confirmation: Confirmation::Unconfirmed,
            applied: 1.0,
            deviation: 0.0,
        }
    }

    /// The way ends: a gap between frames.
    pub fn interrupt(&mut self) {
        self.balance.passage.interrupt();
    }

    /// Whether the ratio is beyond what the budget allows.
    pub fn contradicts(&self) -> bool {
        self.confirmation == Confirmation::Contradicts
    }

    /// Takes a sample, `dt` seconds after the last; `rolling` is `None` where the wheels do not
    /// simply roll, `mass` the relative error of the described mass. Returns whether another ratio
    /// is applied from now on that makes all estimated errors of the readings void.
    pub fn update(&mut self, rolling: Option<&Rolling>, weight: f64, mass: f64, dt: f64) -> bool {
        self.balance.update(rolling, weight, dt) && self.judge(weight, mass)
    }

    fn judge(&mut self, weight: f64, mass: f64) -> bool {
        let (ratio, sigma) = self.balance.ratio(weight);
        let ratio = ratio.max(Self::LEAST);
        let (log, sigma) = (libm::log(ratio), sigma / ratio);
        let few = sigma * robhaz_model::sqrt(self.balance.few_passages());
        let square = log * log / (few * few + mass * mass);
        let applied = libm::log(self.applied);
        let before = self.contradicts();
        if square > GATE * GATE && self.balance.shows_scatter() {
            self.confirmation = Confirmation::Contradicts;
        } else if before && !(square < Self::AGREES * Self::AGREES && GATE * sigma < applied.abs())
        {
            // Not yet.
        } else if square < WITHIN * WITHIN && few < Self::CONFIRMS {
            self.confirmation = Confirmation::Confirmed;
        } else {
            self.confirmation = Confirmation::Unconfirmed;
        }
        if !self.contradicts() {
            (self.applied, self.deviation) = (1.0, 0.0);
            return before;
        }
        let of_payload = (ratio - 1.0) * (ratio - 1.0) + sigma * sigma;
        self.deviation = robhaz_model::sqrt(of_payload);
        if before && (log - applied).abs() < WITHIN * sigma {
            return false;
        }
        self.applied = ratio;
        // What was found with another ratio is less exact.
        self.balance.loosen();
        true
    }

    /// What is found, for a robot of this weight, N.
    pub fn found(&self, weight: f64) -> TorqueScale {
        let (ratio, sigma) = self.balance.ratio(weight);
        TorqueScale {
            ratio,
            sigma,
            confirmation: self.confirmation,
        }
    }
}

/// The work of the ground on the wheels against the energy of the robot: a fit by recursive least
/// squares.
///
/// When the middle wheel stands where the front wheel stood, the posture at both times gives the
/// height by which the centre of mass has risen in between, however the ground looks: the axle was
/// at the same place. So the work of the ground is known twice, from the torques and from the
/// weight:
///
/// ```text
/// sum of W_i - m d(v^2)/2 = q (m g dh + W_B) + w_0 + sum of g_i W_i
/// W_i = int (T_i + B omega_i/r) (u_i + r dtheta_k/dt) dt
/// W_B = sum of int B omega_i/r (u_i + r dtheta_k/dt) dt
/// ```
///
/// The kinetic energy is small but for a start, and its error, that of the speed, must not count as
/// an error of what q multiplies. The work W_B of the damping counts on both sides: it is a part of
/// the torque that is read. u_i is the speed of the wheel's centre, theta_k the angle of its link,
/// on which the moment r T_i acts. q is the ratio of the torques to those that the described robot
/// needs; w_0 holds offsets, friction and rolling resistance, which act all along the way; g_i are
/// the errors of the single gains.
///
/// No slope enters. Slopes that the filters estimate have errors that go with the torques, and a
/// regression of torques on them is biased.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WorkBalance {
    pub passage: Passage,
    /// Error of the heights, m. Not part of the state.
    height: f64,
    /// `[q, w_0 (J), g_1, g_2, g_3]`, for passages that err by `height`.
    fit: Kalman<5>,
    /// Sum of the normalised squares that the fit leaves, and the number of passages.
    left: [f64; 2],
    /// Sums of what q multiplies (J) and of its squares (J^2) over the same passages.
    energy: [f64; 2],
}

impl WorkBalance {
    /// Standard deviation of q before any reading.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const PRIOR_RATIO: f64 = 1.0;
    /// Angle by which posture and place err, rad: 0.1 deg, an error of height over the distance of
    /// the axles. What the fit leaves scales it.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const ANGLE: f64 = 5e-4 / 0.3;
    /// Independent passages by which that height counts against what the fit leaves.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const PRIOR_COUNT: f64 = 2.0;
    /// Relative error of the speed along the ground, of which the slip is a part, and so of q.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const SPEED: f64 = 0.015;
    /// Passages after which what the fit has left no longer counts: some 25 m.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const LASTS: f64 = 2000.0;
    /// Change of q in that way.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const CHANGE: f64 = 0.01;

    /// For axles at a distance of `between` (m). `resisted` is the deviation of what offsets,
    /// friction and rolling resistance take of the sum of the tractions (N), `gain` that of the
    /// relative error of each torque.
    pub fn new(between: f64, resisted: f64, gain: f64) -> Self {
        let of_way = resisted * between;
        let sigma = [Self::PRIOR_RATIO, of_way, gain, gain, gain];
        Self {
            passage: Passage::new(between),
            height: Self::ANGLE * between,
            fit: Kalman::new([1.0, 0.0, 0.0, 0.0, 0.0], sigma),
            left: [0.0; 2],
            energy: [0.0; 2],
        }
    }

    /// Makes the deviations of q and w_0 as large as what is [`SIGNIFICANT`] of them. The gains keep their prior: with more they would explain any
    /// ratio.
    pub fn loosen(&mut self) {
        let factor = |k: usize| if k < 2 { SIGNIFICANT } else { 1.0 };
        for (i, row) in self.fit.p.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry *= factor(i) * factor(j);
            }
        }
    }

    /// Takes a sample, `dt` seconds after the last; `None` where the wheels do not simply roll.
    /// `weight` is that of the robot, N. Returns whether a wheel has come to where another was.
    pub fn update(&mut self, rolling: Option<&Rolling>, weight: f64, dt: f64) -> bool {
        let Some(passed) = self.passage.update(rolling, dt) else {
            return false;
        };
        let [w1, w2, w3] = passed.work;
        let [q, b, d1, d2, d3] = self.fit.x;
        let row = [(0, passed.energy), (1, 1.0), (2, w1), (3, w2), (4, w3)];
        let expected = q * passed.energy + b + d1 * w1 + d2 * w2 + d3 * w3;
        let height = self.height * weight;
        // Passages that share a part of the way count as one.
        let noise = height * height * Passage::OVERLAP;
        let left = w1 + w2 + w3 - passed.kinetic - expected;
        let innovation = self.fit.update(&row, left, noise);
        let keep = 1.0 - 1.0 / Self::LASTS;
        let [squares, count] = self.left;
        self.left = [keep * squares + innovation.nis(), keep * count + 1.0];
        let [sum, of_squares] = self.energy;
        self.energy = [
            keep * sum + passed.energy,
            keep * of_squares + passed.energy * passed.energy,
        ];
        if let Some(variance) = self.fit.p.first_mut().and_then(|row| row.first_mut()) {
            *variance += Self::CHANGE * Self::CHANGE / Self::LASTS;
        }
        true
    }

    /// Whether more independent passages than stand behind the prior have shown how far they
    /// scatter: fewer raise no alarm, because they show their own errors no better than the ratio.
    pub fn shows_scatter(&self) -> bool {
        let [_, count] = self.left;
        count > Self::PRIOR_COUNT * Passage::OVERLAP
    }

    /// Factor on the variance of q by few passages, which show their own scatter no better than they
    /// show q: Student's distribution with that many degrees of freedom has `(count + prior)/count`
    /// times the variance of the normal one.
    pub fn few_passages(&self) -> f64 {
        let [_, count] = self.left;
        let prior = Self::PRIOR_COUNT * Passage::OVERLAP;
        1.0 + prior / count.max(1.0)
    }

    /// q and its standard deviation, for a robot of this weight, N.
    ///
    /// Errors of the heights make q too small, by their share of the squares of the energy: on
    /// level ground nothing else is left of these. They are at most what the fit leaves.
    pub fn ratio(&self, weight: f64) -> (f64, f64) {
        let ([q, ..], [[variance, ..], ..]) = (self.fit.x, self.fit.p);
        let [squares, count] = self.left;
        let prior = Self::PRIOR_COUNT * Passage::OVERLAP;
        let scale = (Passage::OVERLAP * squares + prior) / (count + prior);
        let of_speed = Self::SPEED * q;
        let height = self.height * weight;
        let [sum, of_squares] = self.energy;
        let energy = of_squares - sum * sum / count.max(1.0);
        // No error is greater than that of the prior.
        let share = (scale * count * height * height / energy.max(0.0)).min(1.0);
        let of_height = Self::PRIOR_RATIO * share;
        let sum = variance * scale + of_speed * of_speed + of_height * of_height;
        (q, robhaz_model::sqrt(sum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::GRAVITY;

    const BETWEEN: f64 = 0.3;
    const MASS: f64 = 14.0;
    const WEIGHT: f64 = MASS * GRAVITY;
    const DT: f64 = 1e-3;

    /// A robot on a ground of the amplitude (m) that rolls at `speed` (m/s), its centre of mass
    /// above the mean of its axles. Its torques are read `q` times too large, and `hidden` N of
    /// friction act beside.
    fn rolling(time: f64, speed: f64, amplitude: f64, q: f64, hidden: f64) -> Rolling {
        let x = speed * time;
        let height = |ahead: f64| amplitude * libm::sin(4.0 * (x + ahead));
        let slope = |ahead: f64| 4.0 * amplitude * libm::cos(4.0 * (x + ahead));
        let places = [BETWEEN, 0.0, -BETWEEN];
        let power = places.map(|at| (q * WEIGHT * slope(at) + hidden) / 3.0 * speed);
        let centre = places.map(height).iter().sum::<f64>() / 3.0;
        let above = |at: f64| WEIGHT * (centre - height(at));
        Rolling {
            power,
            damping: 0.0,
            speed,
            axles: [BETWEEN, 0.0],
            energy: [above(BETWEEN), above(0.0)],
            kinetic: 0.5 * MASS * speed * speed,
        }
    }

    fn found(speed: f64, amplitude: f64, q: f64) -> (f64, f64) {
        // Without errors of single gains, which would take a part of the ratio within their prior.
        let mut balance = WorkBalance::new(BETWEEN, 90.0, 0.0);
        for k in 0..20_000 {
            let sample = rolling(DT * f64::from(k), speed, amplitude, q, -12.0);
            balance.update(Some(&sample), WEIGHT, DT);
        }
        balance.ratio(WEIGHT)
    }

    /// Closed form: on uneven ground the ratio is that with which the torques were made, forwards
    /// and backwards, whatever friction hides. Within 1 %, as cells are passed to 0.2 mm of 0.3 m,
    /// and within the deviation.
    #[test]
    fn the_ratio_is_found_on_any_ground() {
        for speed in [0.2, -0.2] {
            for q in [0.4, 1.0, 2.0] {
                let (ratio, sigma) = found(speed, 0.04, q);
                let error = (ratio - q).abs();
                assert!(
                    error < 0.01 && error < sigma,
                    "{speed} {q}: {ratio} {sigma}"
                );
            }
        }
    }

    /// Level ground shows nothing: the ratio stays, and its deviation far beyond the 0.1 from which
    /// on it counts as known: that of the prior, 1.
    #[test]
    fn level_ground_shows_nothing() {
        let (ratio, sigma) = found(0.2, 0.0, 2.0);
        assert!((ratio - 1.0).abs() < 0.1 && sigma > 0.9, "{ratio} {sigma}");
    }

    /// What lies before an interruption does not count: no passage within the next 0.3 m of way.
    #[test]
    fn an_interruption_ends_the_way() {
        let mut balance = WorkBalance::new(BETWEEN, 90.0, 0.02);
        let mut passages = [0_u32; 2];
        for k in 0..6_000 {
            let sample = rolling(DT * f64::from(k), 0.2, 0.04, 1.0, 0.0);
            let valid = k != 3_000;
            let passed = balance.update(valid.then_some(&sample), WEIGHT, DT);
            // 0.3 m at 0.2 m/s are 1.5 s.
            let in_gap = (3_000..4_400).contains(&k);
            passages[usize::from(in_gap)] += u32::from(passed);
        }
        assert!(passages[0] > 40 && passages[1] == 0, "{passages:?}");
    }

    /// A passage or two raise no alarm, however exact their ratio looks; more do.
    #[test]
    fn few_passages_are_no_proof() {
        let mut scale = ScaleFilter::new(BETWEEN, 90.0, 0.0);
        let (mut passages, mut alarm) = (0, None);
        for k in 0..20_000 {
            let sample = rolling(DT * f64::from(k), 0.2, 0.04, 2.0, -12.0);
            let before = scale.balance.left;
            scale.update(Some(&sample), WEIGHT, 0.0, DT);
            passages += u32::from(scale.balance.left.map(f64::to_bits) != before.map(f64::to_bits));
            if scale.contradicts() && alarm.is_none() {
                alarm = Some(passages);
            }
        }
        // 24 cells are a passage of its own; within five of them torques of twice their size show.
        let alarm = alarm.expect("torques of twice their size");
        assert!(alarm > 48 && alarm < 120, "{alarm}");
    }
}
