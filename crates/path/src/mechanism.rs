//! Postures in which all wheels touch the ground, one after the other along the path.
//!
//! Two wheels sit on one link, at a fixed distance from each other; the third has a fixed distance
//! from pin Q. With the places s_i of the three centres along their curve as unknowns these are two
//! equations: the postures form a line in the space of the s_i, which is followed in small steps
//! (predictor along the line's tangent, Newton's method as corrector). A step ends at a kink of the
//! curve, where a wheel touches two places.

use crate::curve::{CentreCurve, OnCurve};
use nalgebra::{Matrix3, Vector3};
use robhaz_model::{Geometry, Posture, PostureError, Vec2, cross, turned};

/// Longest step, m of the fastest wheel.
const LONGEST_STEP: f64 = 0.005;
/// Shortest step, m. Below it the line has no continuation.
const SHORTEST_STEP: f64 = 1e-6;
/// Largest turn of a wheel's contact in a step, rad.
const LARGEST_TURN: f64 = 0.06;
/// Largest error of the two distances, m.
const CLOSED: f64 = 1e-11;
/// A wheel this near to a kink touches both sides of it, m.
const AT_KINK: f64 = 1e-8;

/// Places of the wheels along their curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wheels {
    /// Smooth piece of the curve on which each wheel is.
    pub piece: [usize; 3],
    /// Arc length of each wheel, m.
    pub s: [f64; 3],
}

/// The robot on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnGround {
    /// Centres of the wheels, m.
    pub axles: [Vec2; 3],
    /// Pin Q, m.
    pub q: Vec2,
    /// Angles of links 1 and 2, rad.
    pub angles: [f64; 2],
}

impl OnGround {
    /// The angle of pin Q, theta_1 - theta_2, rad.
    pub fn opening(&self) -> f64 {
        self.angles[0] - self.angles[1]
    }

    /// All angles of the four-bar.
    ///
    /// # Errors
    /// [`PostureError`] where body and link 3 do not reach.
    pub fn posture(&self, geometry: &Geometry) -> Result<Posture, PostureError> {
        Posture::close(geometry, self.angles[0], self.angles[1])
    }
}

/// Direction of the path at a posture: velocities for a mean speed of the wheels' centres of 1 m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangent {
    /// Velocity of Q, -.
    pub q: Vec2,
    /// Rates of links 1 and 2, rad/m.
    pub angles: [f64; 2],
    /// Speeds of the wheels' centres, forward positive, -.
    pub centres: [f64; 3],
}

/// The two links, with their wheels on a curve.
pub struct Mechanism<'a> {
    geometry: &'a Geometry,
    /// The curve of the wheels' centres.
    pub curve: &'a CentreCurve,
    /// The wheels on one link, and the other one.
    pair: [usize; 2],
    single: usize,
    /// Q from the first wheel of the pair, in units of the vector to the second (a complex number).
    q: Vec2,
    /// Distances of the pair, and of the single wheel from Q, m.
    distances: [f64; 2],
}

impl<'a> Mechanism<'a> {
    /// The links of a checked geometry: both carry wheels.
    pub fn new(geometry: &'a Geometry, curve: &'a CentreCurve) -> Self {
        let carriers = geometry.carriers;
        let alone = |i: usize| (0..3).filter(|j| carriers[*j] == carriers[i]).count() == 1;
        let single = (0..3).find(|i| alone(*i)).unwrap_or(0);
        let pair = [(single + 1) % 3, (single + 2) % 3];
        let [a, b, c] = [pair[0], pair[1], single].map(|i| geometry.axles[i]);
        let (base, q) = (b - a, geometry.pins.q - a);
        let inverse = Vec2::new(base.x, -base.y) / base.norm_squared();
        Self {
            pair,
            single,
            q: turned(inverse, q),
            distances: [base.norm(), (c - geometry.pins.q).norm()],
            geometry,
            curve,
        }
    }

    fn at(&self, piece: [usize; 3], s: [f64; 3]) -> [OnCurve; 3] {
        [0, 1, 2].map(|i| self.curve.at(piece[i], s[i]))
    }

    fn pin_q(&self, a: Vec2, b: Vec2) -> Vec2 {
        a + turned(self.q, b - a)
    }

    /// Positions and link angles of wheels that meet the two distances.
    pub fn on_ground(&self, wheels: &Wheels) -> OnGround {
        let axles = self.at(wheels.piece, wheels.s).map(|at| at.centre);
        let ([a, b], c) = (self.pair, self.single);
        let q = self.pin_q(axles[a], axles[b]);
        let nominal = self.geometry;
        let mut angles = [angle(nominal.axles[b] - nominal.axles[a], axles[b] - axles[a]); 2];
        angles[nominal.carriers[c].index()] =
            angle(nominal.axles[c] - nominal.pins.q, axles[c] - q);
        OnGround { axles, q, angles }
    }

    /// Errors of the two distances (m) and their derivatives with respect to the s_i.
    fn errors(&self, at: &[OnCurve; 3]) -> ([f64; 2], [Vector3<f64>; 2]) {
        let ([a, b], c) = (self.pair, self.single);
        let base = at[b].centre - at[a].centre;
        let leg = at[c].centre - self.pin_q(at[a].centre, at[b].centre);
        let (length, reach) = (base.norm(), leg.norm());
        let (u, v) = (base / length, leg / reach);
        let mut rows = [Vector3::zeros(); 2];
        rows[0][a] = -u.dot(&at[a].slope);
        rows[0][b] = u.dot(&at[b].slope);
        let of_a = at[a].slope - turned(self.q, at[a].slope);
        rows[1][a] = -v.dot(&of_a);
        rows[1][b] = -v.dot(&turned(self.q, at[b].slope));
        rows[1][c] = v.dot(&at[c].slope);
        let errors = [length - self.distances[0], reach - self.distances[1]];
        (errors, rows)
    }

    /// Newton's method from `s`, with `row . s = value` as the third equation.
    fn solve(
        &self,
        piece: [usize; 3],
        mut s: Vector3<f64>,
        row: Vector3<f64>,
        value: f64,
    ) -> Option<Vector3<f64>> {
        for _ in 0..20 {
            let (errors, rows) = self.errors(&self.at(piece, s.into()));
            let third = row.dot(&s) - value;
            let matrix =
                Matrix3::from_rows(&[rows[0].transpose(), rows[1].transpose(), row.transpose()]);
            let right = Vector3::new(errors[0], errors[1], third);
            let step = matrix.lu().solve(&right)?;
            s -= step;
            if !step.iter().all(|d| d.is_finite()) {
                return None;
            }
            if step.amax() < CLOSED {
                return Some(s);
            }
        }
        None
    }

    /// The place near the nominal pose with the middle wheel at x (m).
    pub fn start(&self, x: f64) -> Option<Wheels> {
        let (axles, curve) = (&self.geometry.axles, self.curve);
        let shift = x - axles[1].x;
        let mut wheels = Wheels::default();
        for (i, axle) in axles.iter().enumerate() {
            (wheels.piece[i], wheels.s[i]) = curve.at_x(axle.x + shift)?;
        }
        // Beyond the end of a piece Newton's method goes on from the neighbouring one.
        for _ in 0..10 {
            let row = Vector3::y();
            let found = self.solve(wheels.piece, wheels.s.into(), row, wheels.s[1])?;
            let before = wheels.piece;
            for i in 0..3 {
                let (low, high) = curve.ends(wheels.piece[i]);
                if found[i] > high && wheels.piece[i] + 1 < curve.pieces() {
                    wheels.piece[i] += 1;
                } else if found[i] < low {
                    wheels.piece[i] = wheels.piece[i].checked_sub(1)?;
                }
            }
            wheels.s = found.into();
            if wheels.piece == before {
                return Some(wheels);
            }
        }
        None
    }

    /// Velocities of the links where the wheels move along the curve with the rates of `along`,
    /// for a mean of 1.
    fn velocities(&self, wheels: &Wheels, along: &Vector3<f64>) -> Tangent {
        let direction = along / along.abs().mean();
        let at = self.at(wheels.piece, wheels.s);
        let velocity = [0, 1, 2].map(|i| at[i].slope * direction[i]);
        let ([a, b], c) = (self.pair, self.single);
        let base = at[b].centre - at[a].centre;
        let of_base = velocity[b] - velocity[a];
        let q = velocity[a] + turned(self.q, of_base);
        let leg = at[c].centre - self.pin_q(at[a].centre, at[b].centre);
        let rate = |arm: Vec2, v: Vec2| cross(arm, v) / arm.norm_squared();
        let mut angles = [rate(base, of_base); 2];
        angles[self.geometry.carriers[c].index()] = rate(leg, velocity[c] - q);
        Tangent {
            q,
            angles,
            centres: direction.into(),
        }
    }

    /// Direction of the line of postures, with its largest component 1.
    fn tangent(&self, wheels: &Wheels) -> Option<Vector3<f64>> {
        let (_, rows) = self.errors(&self.at(wheels.piece, wheels.s));
        let direction = rows[0].cross(&rows[1]);
        let largest = direction.amax();
        (largest > 1e-9).then(|| direction / largest)
    }
}

/// Angle from one vector to another, rad, counter-clockwise.
fn angle(from: Vec2, to: Vec2) -> f64 {
    cross(from, to).atan2(from.dot(&to))
}

/// What a step along the path has reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// A place on smooth parts of the curve.
    Place,
    /// A wheel has come to a kink, and goes on behind it.
    Kink {
        /// Index of the wheel.
        wheel: usize,
    },
    /// There is no further posture.
    End,
}

/// The robot on its way along the curve.
pub struct Walk<'a> {
    /// The links.
    pub mechanism: &'a Mechanism<'a>,
    /// The present places.
    pub wheels: Wheels,
    direction: Vector3<f64>,
    /// At a kink: velocities of the links just before it.
    pub approach: Option<Tangent>,
}

impl<'a> Walk<'a> {
    /// A walk forward from a place; `None` where no direction is defined.
    pub fn new(mechanism: &'a Mechanism<'a>, wheels: Wheels) -> Option<Self> {
        let direction = mechanism.tangent(&wheels)?;
        Some(Self {
            mechanism,
            wheels,
            direction: direction * direction[1].signum(),
            approach: None,
        })
    }

    /// Pieces whose contacts a wheel has: its own and, at a kink, the neighbouring one.
    pub fn pieces_of(&self, wheel: usize) -> (usize, Option<usize>) {
        let (piece, s) = (self.wheels.piece[wheel], self.wheels.s[wheel]);
        let curve = self.mechanism.curve;
        let (low, high) = curve.ends(piece);
        let other = if high - s < AT_KINK {
            Some(piece + 1).filter(|p| *p < curve.pieces())
        } else if s - low < AT_KINK {
            piece.checked_sub(1)
        } else {
            None
        };
        (piece, other)
    }

    /// Velocities of the links onward from the present place.
    pub fn tangent(&self) -> Tangent {
        (self.mechanism).velocities(&self.wheels, &self.direction)
    }

    /// One step forward. At a kink the wheel is already on the piece behind it.
    pub fn step(&mut self) -> Reached {
        self.approach = None;
        let mut length = LONGEST_STEP;
        while length >= SHORTEST_STEP {
            if let Some(found) = self.try_step(length) {
                return found;
            }
            length *= 0.5;
        }
        Reached::End
    }

    /// A step of a length (m); `None` if it is too long.
    fn try_step(&mut self, length: f64) -> Option<Reached> {
        let from = Vector3::from(self.wheels.s);
        let row = self.direction;
        let predicted = from + row * length;
        let piece = self.wheels.piece;
        let (mechanism, along) = (self.mechanism, row.dot(&predicted));
        let s = mechanism.solve(piece, predicted, row, along)?;
        if (s - predicted).amax() > 0.5 * length {
            return None;
        }
        if let Some((wheel, end)) = self.first_beyond(from, s) {
            return self.land(wheel, end, from, s);
        }
        let [before, after] = [from, s].map(|s| mechanism.at(piece, s.into()));
        let turns = (0..3).map(|i| angle(before[i].slope, after[i].slope).abs());
        let turn = turns.fold(0.0, f64::max);
        if turn > LARGEST_TURN && length > 1e3 * SHORTEST_STEP {
            return None;
        }
        self.wheels.s = s.into();
        let tangent = mechanism.tangent(&self.wheels)?;
        self.direction = tangent * tangent.dot(&row).signum();
        Some(Reached::Place)
    }

    /// The wheel that leaves its piece first on the way between two places, and the end at which it
    /// does.
    fn first_beyond(&self, from: Vector3<f64>, to: Vector3<f64>) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64, f64)> = None;
        for i in 0..3 {
            let (low, high) = self.mechanism.curve.ends(self.wheels.piece[i]);
            let end = if to[i] > high { high } else { low };
            if to[i] > high || to[i] < low {
                let share = (end - from[i]) / (to[i] - from[i]);
                if first.is_none_or(|(_, _, before)| share < before) {
                    first = Some((i, end, share));
                }
            }
        }
        first.map(|(wheel, end, _)| (wheel, end))
    }

    /// Puts a wheel on the end of its piece, and then on the next piece.
    fn land(
        &mut self,
        wheel: usize,
        end: f64,
        from: Vector3<f64>,
        to: Vector3<f64>,
    ) -> Option<Reached> {
        let share = ((end - from[wheel]) / (to[wheel] - from[wheel])).clamp(0.0, 1.0);
        let mut row = Vector3::zeros();
        row[wheel] = 1.0;
        let (mechanism, piece) = (self.mechanism, self.wheels.piece);
        let curve = mechanism.curve;
        let guess = from + (to - from) * share;
        let s = mechanism.solve(piece, guess, row, end)?;
        // Another wheel may be beyond its piece by rounding, when both reach a kink at once.
        let inside = (0..3).all(|i| {
            let (low, high) = curve.ends(piece[i]);
            s[i] > low - AT_KINK && s[i] < high + AT_KINK
        });
        if !inside {
            return None;
        }
        let sign = (to[wheel] - from[wheel]).signum();
        let next = if sign > 0.0 {
            Some(piece[wheel] + 1).filter(|p| *p < curve.pieces())
        } else {
            piece[wheel].checked_sub(1)
        };
        let Some(next) = next else {
            return Some(Reached::End);
        };
        self.wheels.s = s.into();
        if let Some(tangent) = mechanism.tangent(&self.wheels) {
            let direction = tangent * tangent.dot(&self.direction).signum();
            self.approach = Some(mechanism.velocities(&self.wheels, &direction));
        }
        self.wheels.piece[wheel] = next;
        // The pieces meet within the accuracy to which a kink is found.
        let (low, high) = curve.ends(next);
        self.wheels.s[wheel] = self.wheels.s[wheel].clamp(low, high);
        let Some(tangent) = mechanism.tangent(&self.wheels) else {
            return Some(Reached::End);
        };
        let along = if tangent[wheel].abs() > 1e-6 {
            tangent[wheel] * sign
        } else {
            tangent.dot(&self.direction)
        };
        self.direction = tangent * along.signum();
        Some(Reached::Kink { wheel })
    }
}
