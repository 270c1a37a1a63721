//! What the memory knows of the ground: its points, slopes and friction.

use super::{GroundMemory, UNEVEN};
use crate::filters::motion::{PENETRATION_SPEED, REFERENCE_SPEED};
use crate::ground::cells::{Cell, Cells, FrictionBounds};
use crate::ground::motion::{level, tangent};

/// Length along the ground over which the error of a stored slope lasts, m: that of the penetration
/// speed.
/// Definition.
const SLOPE_LASTS: f64 = REFERENCE_SPEED * PENETRATION_SPEED.time;
/// Part of that error which lasts for the distance of two wheels, rad: 0.5 deg. It is an error of
/// the wheel that comes there, too.
/// Chosen; sensitive. Held by `crates/run/tests/run/ground.rs`.
const REPEATED: f64 = 8.7e-3;

/// A point of the ground as the wheels have found it.
///
/// The origin is the contact point of the middle wheel where the section started: `x = 0`,
/// `height = 0`. The robot knows neither its place in the world nor that place's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundPoint {
    /// Place along the path, m, horizontal, forward positive.
    pub x: f64,
    /// Place of the axle of a wheel that touches the point, m: what tells it from other points.
    pub axle_x: f64,
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

impl GroundMemory {
    /// All points in memory, in order of their axles.
    pub fn points(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let window = self.cells.window().filter(|_| !self.ended);
        window.filter_map(|number| self.point(number))
    }

    /// The points that the last sample left, in order of their axles.
    pub fn completed(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let (all, left) = (self.cells.all(), self.cells.left());
        let left = if self.ended { all } else { left };
        left.filter_map(|number| self.point(number))
    }

    /// Angle of the ground under an axle at a place (m) as a wheel stored it, rad, and its standard deviation for
    /// a wheel that comes to that place now. The deviation includes the error of the place relative
    /// to the stored one, times the curvature. `None` where the ground is not known.
    ///
    /// The angle is an earlier estimate of the motion filter. As far as its errors last, it says
    /// nothing new to that filter: see [`Self::mapped_slope`].
    pub fn slope_at(&self, x: f64) -> Option<(f64, f64)> {
        let number = self.cells.number(x);
        let (behind, ahead) = (self.cells.known(number)?, self.cells.known(number + 1)?);
        let (slope, variance) = self.slope_of(number, behind);
        let (next, next_variance) = self.slope_of(number + 1, ahead);
        let share = (x - self.cells.place(number)) / self.cells.spacing;
        let curvature = (next - slope) / self.cells.spacing;
        let place = (self.place_variance - behind.place_variance).max(0.0);
        let by_place = curvature * curvature * place;
        let sigma = robhaz_model::sqrt(variance.max(next_variance) + by_place);
        Some((slope + share * (next - slope), sigma))
    }

    /// What mapped ground shows of the contact angle of wheel `i`, rad, and the variance of the
    /// white noise of the same effect, one measurement a point. `None` on unmapped ground, and where it was
    /// mapped before the filters had settled.
    pub fn mapped_slope(&self, i: usize) -> Option<(f64, f64)> {
        let place = self.wheel_places()?.get(i).copied()?;
        let settled = |number: i64| self.cells.known(number).filter(|cell| cell.settled);
        let number = self.cells.number(place);
        settled(number).and(settled(number + 1))?;
        let (slope, sigma) = self.slope_at(place)?;
        let white = (2.0 * SLOPE_LASTS / self.cells.spacing).max(1.0);
        let variance = self.drift.contradiction() * (sigma * sigma + REPEATED * REPEATED);
        Some((slope, white * variance))
    }

    /// A stored point as it is known now.
    fn point(&self, number: i64) -> Option<GroundPoint> {
        let cell = self.cells.stored(number)?;
        let (error, variance) = self.drift.at(Cells::between(number));
        let (slope, slope_variance) = self.slope_of(number, cell);
        let (rise, bend) = (tangent(slope), self.curvature(number));
        let place = cell.place_variance;
        let (sin, cos) = libm::sincos(slope);
        let axle_x = self.cells.place(number);
        Some(GroundPoint {
            x: axle_x + self.radius * sin,
            axle_x,
            sigma_x: robhaz_model::sqrt(place),
            height: cell.height - error - self.radius * cos,
            sigma_height: robhaz_model::sqrt(variance + UNEVEN * UNEVEN + rise * rise * place),
            slope,
            sigma_slope: robhaz_model::sqrt(slope_variance + bend * bend * place),
            friction: self.cells.friction(number),
            section: self.section,
        })
    }

    /// Angle of the ground at a stored point, rad, and its variance, rad^2.
    fn slope_of(&self, number: i64, cell: &Cell) -> (f64, f64) {
        let spacing = self.cells.node_spacing();
        let (error, variance) = self.drift.slope_at(Cells::between(number), spacing);
        let level = level(cell.slope);
        let variance = level * level * variance + cell.slope_variance;
        (cell.slope - level * error, variance)
    }

    /// Change of the stored angle along x, rad/m, over up to three points on both sides; 0 where no
    /// neighbour is known.
    fn curvature(&self, number: i64) -> f64 {
        const FAR: i64 = 3;
        let slope = |other: i64| Some((other, self.cells.stored(other)?.slope));
        let behind = (number - FAR..=number).find_map(slope);
        let ahead = (number..=number + FAR).rev().find_map(slope);
        match (behind, ahead) {
            (Some((from, first)), Some((to, last))) if to > from => {
                (last - first) / (self.cells.place(to) - self.cells.place(from))
            }
            _ => 0.0,
        }
    }

    /// A wheel bears T/N without slip at a place (m): mu_max is at least `bound`, -.
    pub fn friction_held(&mut self, x: f64, bound: f64) {
        if let Some(stored) = self.cells.friction_mut(self.cells.number(x)) {
            stored.at_least = stored.at_least.max(bound);
        }
    }

    /// A wheel began to slip at a place (m): mu_max is between the bounds, -. They replace what was
    /// known there.
    pub fn friction_measured(&mut self, x: f64, at_least: f64, at_most: f64) {
        if let Some(stored) = self.cells.friction_mut(self.cells.number(x)) {
            *stored = FrictionBounds {
                at_least: at_least.max(0.0),
                at_most: Some(at_most),
            };
        }
    }

    /// Bounds of the friction at a place in memory (m).
    pub fn friction_at(&self, x: f64) -> FrictionBounds {
        let number = self.cells.number(x);
        if self.cells.window().contains(&number) {
            self.cells.friction(number)
        } else {
            FrictionBounds::default()
        }
    }
}
