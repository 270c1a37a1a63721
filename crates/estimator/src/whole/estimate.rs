//! What the estimator of a whole rover says of one instant.

use crate::estimate::Estimate;
use crate::flags::Flags;
use crate::torque_scale::TorqueScale;

/// The line about which a rover would tip over first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TipLine {
    /// Through the contacts of the left wheels.
    #[default]
    Left,
    /// Through those of the right wheels.
    Right,
    /// Through those of the front wheels.
    Front,
    /// Through those of the rear wheels.
    Rear,
}

impl TipLine {
    /// All lines.
    pub const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Front, Self::Rear];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Front => "front",
            Self::Rear => "rear",
        }
    }

    /// Whether wheel `i` stands off the line: it has no load where the rover tips about it.
    pub(super) fn is_off(self, i: usize) -> bool {
        match self {
            Self::Left => i >= 3,
            Self::Right => i < 3,
            Self::Front => !i.is_multiple_of(3),
            Self::Rear => i % 3 != 2,
        }
    }
}

/// Forces of the ground on the six wheels at one instant. Wheels are left 1 to 3, then right 1 to 3.
#[derive(Clone, Copy, Debug)]
pub struct WholeEstimate {
    /// Time of the frame, s.
    pub time: f64,
    /// Normal forces in the planes of the wheels, N.
    pub normal_force: [f64; 6],
    /// Covariance of the normal forces, N^2. It contains what the ground's inclination across a wheel does
    /// to the force along the ground's normal, which no reading shows.
    pub covariance: [[f64; 6]; 6],
    /// The part of the variances that is of that inclination, N^2: N in the wheels' planes does not have it.
    pub of_inclination: [f64; 6],
    /// Tractions, N.
    pub traction: [f64; 6],
    /// Angle of the body, rad, nose up, and its roll, left side up.
    pub attitude: [f64; 2],
    /// The force of the ground on all wheels across the body, N, to the left.
    pub lateral_force: f64,
    /// Mean axial force of a wheel over its normal force, -: the share of the friction that a cross
    /// slope or a turn needs. A wheel needs `hypot(T/N, axial_share)`.
    pub axial_share: f64,
    /// Load of the wheels off [`Self::tip_line`] over their load on level ground, -: at 0 the rover
    /// tips over.
    pub tip_margin: f64,
    /// The line with the least margin.
    pub tip_line: TipLine,
    /// Whether wheels are dragged across, as in a skid turn: their axial forces are not known, and
    /// what is stated is large.
    pub dragged: bool,
    /// Squared distance of the nine rows from what their covariance allows: chi-square with three
    /// degrees of freedom if all that is stated holds.
    pub misfit: f64,
    /// The torques against the rover's weight. Where they contradict it, the covariances contain what
    /// a payload would change.
    pub torque_scale: TorqueScale,
    /// Warnings of the readings of the body: roll and rates. [`Flags::CONTRADICTION`] where the mean misfit of the last
    /// forty radians of the wheels is beyond [`Self::largest_misfit`], of 220 honest logs in MuJoCo in none, and where roll
    /// and its rate contradict each other for 0.2 s.
    pub body_flags: Flags,
    /// What each side's filters state, with the forces above: left, right.
    pub sides: [Estimate; 2],
}

impl WholeEstimate {
    /// Turn of the wheels after which the errors of the equations are independent of those before, rad:
    /// axial forces last over five wheel radii.
    pub const INDEPENDENT: f64 = 5.0;
    /// Longest way over which a misfit is averaged, as a turn of the wheels, rad: errors that last as long as the drive
    /// make more samples worthless.
    pub(crate) const LONGEST_WAY: f64 = 8.0 * Self::INDEPENDENT;
    /// Largest misfit of one instant that counts in a mean, as of innovations: 25 for each degree of freedom.
    pub const LARGEST_MISFIT: f64 = 75.0;

    /// Mean misfit over a drive beyond which its readings contradict each other: correct ones are there
    /// once in 10 000 drives. `rolled` is how far the wheels have turned, rad.
    ///
    /// The mean of n independent misfits is a chi-square with 3 n degrees of freedom over n (its quantile
    /// by Wilson and Hilferty).
    pub fn largest_misfit(rolled: f64) -> f64 {
        const DEVIATE: f64 = 3.72;
        let samples = rolled.clamp(Self::INDEPENDENT, Self::LONGEST_WAY) / Self::INDEPENDENT;
        let share = 2.0 / (9.0 * 3.0 * samples);
        let root = 1.0 - share + DEVIATE * robhaz_model::sqrt(share);
        3.0 * root * root * root
    }

    /// The covariance of N in the planes of the wheels, N^2.
    pub fn in_plane_covariance(&self) -> [[f64; 6]; 6] {
        let mut covariance = self.covariance;
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] -= self.of_inclination[i];
        }
        covariance
    }

    /// Standard deviation of N of wheel `i` (0 to 5) along the ground's normal, N.
    pub fn sigma_normal(&self, i: usize) -> Option<f64> {
        let variance: &f64 = self.covariance.get(i)?.get(i)?;
        Some(robhaz_model::sqrt(variance.clamp(0.0, f64::INFINITY)))
    }

    /// Standard deviation of N of wheel `i` (0 to 5) in its plane, N.
    pub fn sigma_in_plane(&self, i: usize) -> Option<f64> {
        let variance = self.covariance.get(i)?.get(i)? - self.of_inclination.get(i)?;
        Some(robhaz_model::sqrt(variance.clamp(0.0, f64::INFINITY)))
    }

    /// Standard deviation of T of wheel `i` (0 to 5), N.
    pub fn sigma_traction(&self, i: usize) -> Option<f64> {
        self.sides.get(i / 3)?.sigma_traction(i % 3)
    }

    /// Friction that wheel `i` (0 to 5) needs: `hypot(T, A)/N` with its mean axial force A. `None`
    /// without load.
    pub fn needed_friction(&self, i: usize) -> Option<f64> {
        let (t, n) = (self.traction.get(i)?, self.normal_force.get(i)?);
        let axial = self.axial_share * n;
        (*n > 0.0).then(|| robhaz_model::sqrt(t * t + axial * axial) / n)
    }

    /// Warnings of both sides and of the body's readings.
    pub fn flags(&self) -> Flags {
        let [left, right] = &self.sides;
        left.flags | right.flags | self.body_flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the chi-square: 21.11 is the upper 1e-4 quantile of three degrees of freedom, 58.6 of 24;
    /// the approximation errs by 4 % and less.
    #[test]
    fn the_largest_misfit_is_a_quantile() {
        for (rolled, expected) in [
            (0.0, 21.11),
            (5.0, 21.11),
            (40.0, 58.6 / 8.0),
            (1e9, 58.6 / 8.0),
        ] {
            let found = WholeEstimate::largest_misfit(rolled);
            assert!((found / expected - 1.0).abs() < 0.04, "{rolled}: {found}");
        }
    }
}
