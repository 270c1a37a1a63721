//! A point of the ground, and the bounds of its friction.

/// A point of the ground as the wheels have found it.
///
/// The origin is the contact point of the middle wheel where the section started: `x = 0`,
/// `height = 0`. The robot knows neither its place in the world nor that place's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundPoint {
    /// Place along the path, m, horizontal, forward positive.
    pub x: f64,
    /// Standard deviation of `x`, m.
    pub sigma_x: f64,
    /// Height over the origin, m.
    pub height: f64,
    /// Standard deviation of the height at `x`, m. It includes that of `x`, times the slope.
    pub sigma_height: f64,
    /// Angle of the tangent, rad, positive where the ground rises forward.
    pub slope: f64,
    /// Standard deviation of the angle, rad.
    pub sigma_slope: f64,
    /// Bounds of the friction there.
    pub friction: FrictionBounds,
    /// Number of the section, from 0. A new section with an origin of its own starts when the
    /// filters start anew: after a gap of the readings, or when the motion was estimated wrongly.
    pub section: u32,
}

/// Bounds of the available friction mu_max at a place, each two standard deviations away from what
/// was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionBounds {
    /// mu_max is at least this: the largest |T/N| that a wheel has borne there without slip. 0
    /// where nothing was borne.
    pub at_least: f64,
    /// mu_max is at most this: a wheel began to slip there. `None` where none has.
    pub at_most: Option<f64>,
}
