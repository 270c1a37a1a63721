//! Changes of the links' angles within a time, by inclinometers and by gyroscopes, and how the
//! first follow the second.

use crate::check::recorded::body;
use crate::check::{Channel, Readings};
use robhaz_score::signals::{derivative, difference, integral, robust_fit, smooth, subtract};

/// Least time over which changes are compared, s: the specific force of the robot's own motion
/// changes less in it than the angles on uneven ground. A slow robot needs longer for its angles to
/// change: until it has rolled by the radius of its wheels.
pub const SPAN: f64 = 0.5;
/// Longest such time, s: a gyroscope's drift stays small.
const LONGEST_SPAN: f64 = 10.0;
/// Time over which both are averaged, s.
pub const SMOOTHING: f64 = 0.02;
/// Time over which the robot's acceleration is averaged, s.
pub const FORWARD: f64 = 0.1;
/// Change of an angle within that time that shows something, rad: 0.3 deg, several times the noise
/// of a smoothed inclinometer.
pub const LEAST_CHANGE: f64 = 0.3 * DEGREE;
/// Radians of a degree: also the factor of a wrong unit.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Share from which on a wrong scale is no matter of impacts.
pub const CERTAIN: f64 = 0.95;
/// Deviations of a coefficient that tell its sign, or that it is not 1.
pub const GATE: f64 = 5.0;

/// Changes of one angle of each link within a time.
pub struct Changes {
    /// Gyroscope and inclinometer of each link.
    pub channels: [[Channel; 2]; 2],
    /// Of the inclinometers, rad.
    pub inclination: [Vec<f64>; 2],
    /// Of the integrated gyroscopes, rad.
    pub rate: [Vec<f64>; 2],
    /// Of the angle that the encoders' acceleration makes an inclinometer show, rad; none of
    /// inclinometers without it.
    pub forward: Vec<f64>,
    /// What noise of the inclinometers makes of their changes, rad.
    pub noise: f64,
    /// Time within which they change, s.
    pub span: f64,
    /// Factor of standard deviations: residuals are correlated over the span.
    correlated: f64,
}

/// Coefficients of the changes of an inclination.
#[derive(Clone, Copy)]
pub struct Coefficients {
    /// Of the integrated rate.
    pub rate: f64,
    pub rate_sigma: f64,
    /// Of the acceleration, with its deviation; `None` of inclinometers that do not measure it.
    pub forward: Option<(f64, f64)>,
    pub explained: f64,
}

impl Changes {
    /// The changes of a recording within `span` (s), without the part of the inclinations that is
    /// `acceleration` (rad). Of a log whose readings of the links are made of those of the body these are those of the
    /// body, twice.
    pub fn of(
        log: &Readings<'_>,
        span: f64,
        acceleration: Option<&[f64]>,
        forward: &[f64],
    ) -> Self {
        let recording = &log.recording;
        let (angles, rates) = match log.stated.body {
            Some(_) => {
                let [rate, inclination, _] =
                    body(log.stated, &recording.inclination, &recording.rate);
                ([inclination.clone(), inclination], [rate.clone(), rate])
            }
            None => (recording.inclination.clone(), recording.rate.clone()),
        };
        let half = recording.steps(0.5 * span);
        let change = |x: &[f64]| difference(&smooth(x, recording.steps(0.5 * SMOOTHING)), half);
        let inclination = |k: usize| match acceleration {
            None => change(&angles[k]),
            Some(acceleration) => change(&subtract(&angles[k], acceleration)),
        };
        let correlated = (recording.steps(span) as f64).sqrt();
        let smoothed = recording.steps(SMOOTHING) as f64;
        Self {
            channels: [0, 1].map(|k| match log.stated.body {
                Some(_) => [Channel::BodyRate, Channel::BodyInclination],
                None => Channel::of_link(k),
            }),
            span,
            noise: log.stated.settings.budget.inclination_noise * (2.0 / smoothed).sqrt(),
            correlated,
            inclination: [0, 1].map(inclination),
            rate: [0, 1].map(|k| change(&integral(&rates[k], recording.dt))),
            forward: change(forward),
        }
    }

    /// The changes with what the inclinations are fitted to: the rates, and the acceleration where
    /// inclinometers show it.
    pub fn of_links(log: &Readings<'_>, span: f64) -> Self {
        let forward = match log.stated.settings.budget.specific_force {
            true => forward(log),
            false => Vec::new(),
        };
        Self::of(log, span, None, &forward)
    }

    /// How inclination `k` follows the gyroscope of link `j` and the acceleration.
    pub fn fit(&self, k: usize, j: usize) -> Option<Coefficients> {
        let (y, rate) = (&self.inclination[k], &self.rate[j]);
        let fit = robust_fit(y, &[rate, &self.forward]).or_else(|| robust_fit(y, &[rate]))?;
        let sigma = |i: usize| self.correlated * fit.deviations[i];
        let forward = fit.coefficients.get(1);
        Some(Coefficients {
            rate: fit.coefficients[0],
            rate_sigma: sigma(0),
            forward: forward.map(|value| (*value, sigma(1))),
            explained: fit.explained,
        })
    }
}

impl Coefficients {
    /// Whether the coefficient of the rate is known to a tenth of itself.
    pub fn is_known(&self) -> bool {
        self.explained > CERTAIN && self.rate_sigma < 0.1 * self.rate.abs()
    }

    pub fn figure(&self) -> String {
        format!(
            "inclinometer over integrated gyro {:.3} (1 is right), {:.0} % explained",
            self.rate,
            100.0 * self.explained
        )
    }

    /// Sign of the coefficient of the acceleration: that of the inclinometer. 0 where it is not
    /// known.
    pub fn of_acceleration(&self) -> f64 {
        match self.forward {
            Some((value, sigma)) if value.abs() > GATE * sigma => value.signum(),
            _ => 0.0,
        }
    }
}

/// Time over which changes are compared, s. Only rovers, whose sensors are in the body, are so slow.
pub fn span(log: &Readings<'_>) -> f64 {
    if log.stated.body.is_none() {
        return SPAN;
    }
    let spin = log.recording.usual_spin().unwrap_or(0.0);
    (1.0 / spin).clamp(SPAN, LONGEST_SPAN)
}

/// Angle that an inclinometer shows more when wheels accelerate the robot as the encoders say, rad. Of the encoders alone,
/// so that no other channel can spoil it.
fn forward(log: &Readings<'_>) -> Vec<f64> {
    let radius = log.stated.robot.geometry.wheel_radius;
    shown_by_inclinometer(log, &log.recording.middle_spin, radius)
}

/// Angle that an inclinometer shows more at the acceleration that goes with a speed times `scale` (m/s), rad; 0 near the
/// ends of the log, where it is not known.
pub fn shown_by_inclinometer(log: &Readings<'_>, speed: &[f64], scale: f64) -> Vec<f64> {
    let recording = &log.recording;
    let acceleration = derivative(speed, recording.steps(0.5 * FORWARD), recording.dt);
    let scale = scale / log.stated.robot.gravity;
    let angle = |a: &f64| if a.is_finite() { scale * a } else { 0.0 };
    acceleration.iter().map(angle).collect()
}
