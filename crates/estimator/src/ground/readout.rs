//! What the memory knows of the ground, and of its friction.

use super::cells::{Cell, Cells};
use super::memory::{GroundMemory, UNEVEN};
use super::motion::{level, tangent};
use super::point::{FrictionBounds, GroundPoint};

/// Length along the ground over which the error of a stored slope lasts, m: that of the penetration
/// speed, 50 ms at 0.2 m/s.
/// Chosen; sensitive. Held by `crates/run/tests/run/ground.rs`.
const SLOPE_LENGTH: f64 = 0.01;
/// Part of that error which lasts for the distance of two wheels, rad: 0.5 deg. It is an error of
/// the wheel that comes there, too.
/// Chosen; sensitive. Held by `crates/run/tests/run/ground.rs`.
const REPEATED: f64 = 8.7e-3;

impl GroundMemory {
    /// All points in memory, in order of x.
    pub fn points(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let window = self.cells.window().filter(|_| !self.ended);
        window.filter_map(|number| self.point(number))
    }

    /// The points that the last sample left, in order of x.
    pub fn completed(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let cells = &self.cells;
        let left = if self.ended {
            cells.all()
        } else {
            cells.left()
        };
        left.filter_map(|number| self.point(number))
    }

    /// Angle of the ground at a place (m) as a wheel stored it, rad, and its standard deviation for
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
        Some((
            slope + share * (next - slope),
            robhaz_model::sqrt(variance.max(next_variance) + by_place),
        ))
    }

    /// What mapped ground shows of the contact angle of wheel `i`, rad, and the variance of the
    /// white noise of the same effect, one measurement a point. `None` on unmapped ground.
    pub fn mapped_slope(&self, i: usize) -> Option<(f64, f64)> {
        let place = self.wheel_places()?.get(i).copied()?;
        let (slope, sigma) = self.slope_at(place).filter(|_| self.drift.agrees())?;
        let white = (2.0 * SLOPE_LENGTH / self.cells.spacing).max(1.0);
        Some((slope, white * (sigma * sigma + REPEATED * REPEATED)))
    }

    /// A stored point as it is known now.
    fn point(&self, number: i64) -> Option<GroundPoint> {
        let cell = self.cells.stored(number)?;
        let (error, variance) = self.drift.at(Cells::between(number));
        let (slope, slope_variance) = self.slope_of(number, cell);
        let (rise, bend) = (tangent(slope), self.curvature(number));
        let place = cell.place_variance;
        Some(GroundPoint {
            x: self.cells.place(number),
            sigma_x: robhaz_model::sqrt(place),
            height: cell.height - error,
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
        (
            cell.slope - level * error,
            level * level * variance + cell.slope_variance,
        )
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
