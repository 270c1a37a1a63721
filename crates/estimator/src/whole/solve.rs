//! Weighted least squares of the nine rows for the six normal forces.
//!
//! Axial forces are six more unknowns that no reading shows. They are not solved for: their mean is
//! proportional to N, as far as the row of the force y and a wheel's sideways motion ask, and the rest is
//! covariance. So is every other error: each row counts for what it knows.

use super::{Contact, ROWS, Rows, WholeEquilibrium, WholeError};
use crate::filters::motion::CREEP_SIGMA;
use crate::statics::{LOAD_PARAMETERS, LoadCovariance};
use nalgebra::{Matrix6, SMatrix, SVector, Vector6};

/// What errs in the equations, in the order of their covariance.
pub mod input {
    /// First of the specific force x, y, z, m/s^2.
    pub const SPECIFIC_FORCE: usize = 0;
    /// First of the six contact angles, rad.
    pub const CONTACT_ANGLE: usize = 3;
    /// First of the six tractions, N.
    pub const TRACTION: usize = 9;
    /// Coefficient of the rolling resistance, -: of the left wheels, then of the right ones.
    pub const ROLLING_RESISTANCE: usize = 15;
}

/// Number of the uncertain inputs.
pub const INPUTS: usize = 17;

/// Covariance of the errors of the inputs in the order of [`input`], SI.
pub type InputCovariance = SMatrix<f64, INPUTS, INPUTS>;

/// Rows of two sums of forces.
const FORCE_Y: usize = 1;
const FORCE_Z: usize = 2;

// What no input accounts for, in mean loads of a wheel.

/// Axial force of a wheel over N by the angle between its plane and the way that it goes, 1/rad: cornering
/// stiffness of a tyre, 0.15 a degree. Textbook; sensitive.
pub(super) const CORNERING: f64 = 0.15 * 180.0 / core::f64::consts::PI;
/// Share of the variance of axial forces that both wheels of an axle's line have in common: a rigid
/// body slides across with both. Chosen.
const OF_AXLE: f64 = 0.7;
/// Variance of what wheels push each other across over that of what they push along: uniform from -1
/// to 1. Definition.
const PUSHED: f64 = 1.0 / 3.0;
/// Relative error of the axial forces of wheels that move sideways: that of the creep's prior, a tyre's
/// stiffness across being that along within a factor of two. Textbook.
const SLIDING: f64 = CREEP_SIGMA;
/// Drilling moment of a wheel over its radius: friction of 0.7 over a contact as wide as half a
/// radius. Chosen; sensitive.
const DRILLING: f64 = 0.2;
/// Error of each row: places, masses, penetration. Chosen; insensitive.
const ROW: f64 = 0.005;
/// Axial over normal force: no ground holds more. Guard.
const STEEPEST: f64 = 1.0;

/// Normal forces of the six wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WholeForces {
    /// In the planes of the wheels, N: the ground's inclination across them is not seen.
    pub normal: [f64; 6],
    /// Their covariance, N^2.
    pub covariance: Matrix6<f64>,
    /// Part of their variances that the ground's inclination across a wheel has, N^2.
    pub of_inclination: [f64; 6],
    /// Covariance of the errors of N and of the inputs, in the order of [`input`].
    pub with_inputs: SMatrix<f64, 6, INPUTS>,
    /// Derivatives of N by the right side of the rows.
    pub gain: [Rows; 6],
    /// Axial force over N, by which the force y is carried.
    pub axial: f64,
    /// Squared distance of the rows from what their covariance allows: chi-square with three
    /// degrees of freedom if all that is stated holds.
    pub misfit: f64,
}

/// A combination of the rows in which no normal force occurs, over the deviation of its error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Parity {
    /// Zero of exact inputs.
    pub value: f64,
    /// Derivatives by the inputs, in the order of [`input`].
    pub gradient: [f64; INPUTS],
}

impl WholeForces {
    /// Adds an error of the rows with the deviation `constant`, N, to the covariance of N: one that
    /// lasts, or that no row shows. It changes no estimate.
    pub fn consider(&mut self, constant: &Rows) {
        let moved: Vector6<f64> = along(&self.gain, constant);
        self.covariance += moved * moved.transpose();
    }

    /// Adds an error that these forces have, and those with the N `without` it (N) have not, to the covariance of N.
    pub(crate) fn consider_difference(&mut self, without: &[f64; 6]) {
        let moved = Vector6::from(*without) - Vector6::from(self.normal);
        self.covariance += moved * moved.transpose();
    }

    /// The same for the errors of the load parameters, by the rows' derivatives by them.
    pub(crate) fn consider_parameters(
        &mut self,
        columns: &[Rows; LOAD_PARAMETERS],
        loads: &LoadCovariance,
    ) {
        self.covariance += loads.of_columns(&columns.map(|column| along(&self.gain, &column)));
    }

    /// Standard deviation of N of wheel `i`, N; not a number beyond the sixth.
    pub fn sigma_normal(&self, i: usize) -> f64 {
        let variance = self.covariance.get((i, i));
        robhaz_model::sqrt(variance.map_or(f64::NAN, |variance| variance.clamp(0.0, f64::INFINITY)))
    }
}

/// Rows of the inverse of the lower root of a positive definite matrix, by its columns: they make
/// what has this covariance white. `None` where a pivot is lost in rounding.
fn whitener<const N: usize>(columns: &[SVector<f64, N>; N]) -> Option<[SVector<f64, N>; N]> {
    let mut rows = [SVector::<f64, N>::zeros(); N];
    for i in 0..N {
        let (column, mut row) = (columns[i], SVector::<f64, N>::zeros());
        let mut pivot = column[i];
        row[i] = 1.0;
        for done in &rows[..i] {
            let along = done.dot(&column);
            pivot -= along * along;
            row -= done * along;
        }
        // Written so that a NaN fails too.
        if !(pivot > 1e-13 * column[i] && pivot < f64::INFINITY) {
            return None;
        }
        rows[i] = row / robhaz_model::sqrt(pivot);
    }
    Some(rows)
}

/// The unit vector along the part of `vector` that is orthogonal to the `base`. `None` where there is
/// none.
#[inline(always)]
fn beside(base: &[Rows], vector: Rows) -> Option<Rows> {
    let mut left = vector;
    // Twice: once leaves rounding of the parts that are taken out.
    for _ in 0..2 {
        for done in base {
            left -= done * done.dot(&left);
        }
    }
    let square = left.norm_squared();
    (square > 1e-20 * vector.norm_squared()).then(|| left / robhaz_model::sqrt(square))
}

/// `sum_k columns_k x_k`.
#[inline(always)]
fn combined<const N: usize>(
    columns: &[SVector<f64, N>],
    x: impl IntoIterator<Item = f64>,
) -> SVector<f64, N> {
    let mut sum = SVector::<f64, N>::zeros();
    for (column, x) in columns.iter().zip(x) {
        sum += column * x;
    }
    sum
}

/// The products of a vector with each of the rows.
#[inline(always)]
fn along<const N: usize, const K: usize>(
    rows: &[SVector<f64, N>; K],
    vector: &SVector<f64, N>,
) -> SVector<f64, K> {
    let mut products = SVector::<f64, K>::zeros();
    for (product, row) in products.iter_mut().zip(rows) {
        *product = row.dot(vector);
    }
    products
}

impl WholeEquilibrium {
    /// The six normal forces for tractions in N and the covariance of the inputs' errors.
    ///
    /// # Errors
    /// [`WholeError::Singular`].
    pub fn solve(
        &self,
        traction: &[f64; 6],
        inputs: &InputCovariance,
    ) -> Result<WholeForces, WholeError> {
        let y = self.right_side(traction);
        // Equal loads that carry the force z: on a plane, however inclined, their axial forces are
        // exact. From them alone N errs as little, but what is stated of a contact angle is that of
        // the mean load.
        let carried: f64 = self.h_n.iter().map(|column| column[FORCE_Z]).sum();
        let about = self
            .fit(&y, traction, &[y[FORCE_Z] / carried; 6], inputs)?
            .normal;
        self.solve_about(traction, inputs, &about)
    }

    /// The same, linearised at the normal forces `about`, N: those of a moment ago serve as well as a
    /// first pass.
    pub(crate) fn solve_about(
        &self,
        traction: &[f64; 6],
        inputs: &InputCovariance,
        about: &[f64; 6],
    ) -> Result<WholeForces, WholeError> {
        let found = self.fit(&self.right_side(traction), traction, about, inputs)?;
        if found.misfit < f64::INFINITY {
            Ok(found)
        } else {
            Err(WholeError::Singular)
        }
    }

    /// Axial force over N that all wheels have in common, from the row of the force y.
    fn axial_share(&self, y: &Rows, normal: &[f64; 6]) -> f64 {
        let (mut left, mut across) = (y[FORCE_Y], 0.0);
        for i in 0..6 {
            left -= self.h_n[i][FORCE_Y] * normal[i];
            let of_wheel = self.h_a[i][FORCE_Y] * normal[i].max(0.0);
            left -= of_wheel * self.sliding[i];
            across += of_wheel;
        }
        (left / across).clamp(-STEEPEST, STEEPEST)
    }

    /// The column of N of wheel `i` with its axial force, `axial` of which all wheels have in common.
    fn column(&self, i: usize, axial: f64) -> Rows {
        let share = (axial + self.sliding[i]).clamp(-STEEPEST, STEEPEST);
        self.h_n[i] + self.h_a[i] * share
    }

    /// Variances of the forces, N^2, by which wheels push each other along and across the rover. The linkage
    /// pushes them along, which the spread of T about a common T/N shows; friction, which is the same in all
    /// directions, lets them push across by anything up to as much. Those that are dragged do.
    fn pushes(&self, traction: &[f64; 6], normal: &[f64; 6]) -> [f64; 2] {
        let common = traction.iter().sum::<f64>() / normal.iter().sum::<f64>();
        let share = if self.dragged { 1.0 } else { PUSHED };
        let (mut square, mut seen) = (0.0, 0.0);
        for (contact, (t, n)) in self.contacts.iter().zip(traction.iter().zip(normal)) {
            let (beyond, axial) = (t - common * n, contact.axial);
            square += beyond * beyond;
            seen += axial.y * axial.y + share * axial.x * axial.x;
        }
        let along = square / seen;
        let least = CORNERING * self.toe * self.mean_load;
        [along, share * along].map(|push| push + least * least)
    }

    /// Mean variance of the axial forces beyond the part that is proportional to N and what the ground's inclination
    /// adds, N^2.
    pub(crate) fn axial_variance(&self, traction: &[f64; 6], normal: &[f64; 6]) -> f64 {
        let [along, across] = self.pushes(traction, normal);
        let of_wheel = |contact: &Contact| {
            let axial = contact.axial;
            along * axial.x * axial.x + across * axial.y * axial.y
        };
        self.contacts.iter().map(of_wheel).sum::<f64>() / 6.0
    }

    /// What an error of each input does to `f - H_T T - H_N N`.
    fn effects(&self, traction: &[f64; 6], normal: &[f64; 6]) -> [Rows; INPUTS] {
        let mut effects = [Rows::zeros(); INPUTS];
        let (direct, of_wheels) = effects.split_at_mut(input::CONTACT_ANGLE);
        direct.copy_from_slice(&self.by_specific_force);
        let (of_angles, others) = of_wheels.split_at_mut(6);
        let (of_tractions, of_rolling) = others.split_at_mut(6);
        for (i, effect) in of_angles.iter_mut().enumerate() {
            *effect = -self.by_contact_angle(i, normal[i], traction[i]);
        }
        for (effect, column) in of_tractions.iter_mut().zip(&self.h_t) {
            *effect = -column;
        }
        for (i, n) in normal.iter().enumerate() {
            if let Some(effect) = of_rolling.get_mut(i / 3) {
                *effect -= self.of_shift(i, self.rolling[i], *n);
            }
        }
        effects
    }

    /// Covariance of the rows, by columns, and of the rows with the inputs.
    #[inline(always)]
    fn row_covariance(
        &self,
        effects: &[Rows; INPUTS],
        traction: &[f64; 6],
        normal: &[f64; 6],
        inputs: &InputCovariance,
    ) -> ([Rows; ROWS], [Rows; INPUTS]) {
        let mut with = [Rows::zeros(); INPUTS];
        let mut covariance = [Rows::zeros(); ROWS];
        let mut add = |a: &Rows, b: &Rows| {
            for (column, b) in covariance.iter_mut().zip(b.iter()) {
                *column += a * *b;
            }
        };
        for (j, with) in with.iter_mut().enumerate() {
            *with = combined(effects, inputs.column(j).iter().copied());
            add(with, &effects[j]);
        }
        let [along, across] = self.pushes(traction, normal);
        // N has a part across the wheel then.
        let of_inclination = self.inclination_across * self.mean_load * self.mean_load;
        for i in 0..3 {
            let pair = [i, i + 3];
            let (mut across_rover, mut sliding) = (Rows::zeros(), Rows::zeros());
            for k in pair {
                let (column, axial) = (self.h_a[k], self.contacts[k].axial);
                across_rover += column * axial.y;
                sliding += column * (self.sliding[k] * normal[k]);
                let own = along * axial.x * axial.x + (1.0 - OF_AXLE) * across * axial.y * axial.y;
                add(&(column * (own + of_inclination)), &column);
            }
            add(&(across_rover * (OF_AXLE * across)), &across_rover);
            add(&(sliding * (SLIDING * SLIDING)), &sliding);
        }
        let mut of_rate = Rows::zeros();
        for (i, error) in self.sliding_error.iter().enumerate() {
            of_rate += self.h_a[i] * (error * normal[i]);
        }
        add(&of_rate, &of_rate);
        let by_pins = self.by_pins();
        for (k, column) in covariance.iter_mut().enumerate() {
            // The lever is twice the radius.
            let drilling = if k == Self::YAW {
                6.0 * (0.5 * DRILLING) * (0.5 * DRILLING)
            } else {
                0.0
            };
            column[k] += (ROW * ROW + drilling) * self.mean_load * self.mean_load + by_pins[k];
        }
        (covariance, with)
    }

    /// The three combinations of the rows in which no normal force occurs, about the solution
    /// `found`: each with its value and its derivatives by the inputs, over the deviation of its
    /// error by axial forces, drilling, places, and by `noise`, a covariance of the inputs. Their
    /// errors are independent.
    #[inline(always)]
    pub(crate) fn parities(
        &self,
        traction: &[f64; 6],
        found: &WholeForces,
        noise: &InputCovariance,
    ) -> Option<[Parity; 3]> {
        let effects = self.effects(traction, &found.normal);
        let (covariance, _) = self.row_covariance(&effects, traction, &found.normal, noise);
        let white = whitener(&covariance)?;
        // An orthonormal base of what the normal forces reach.
        let mut base = [Rows::zeros(); ROWS];
        for i in 0..6 {
            let column = self.column(i, found.axial);
            base[i] = beside(&base[..i], along(&white, &column))?;
        }
        let y = along(&white, &self.right_side(traction));
        let mut parities = [Parity::default(); 3];
        for (k, parity) in parities.iter_mut().enumerate() {
            // The axis that is farthest from what is there already.
            let left = |axis: usize| {
                let row = |done: &Rows| done.get(axis).copied().unwrap_or(0.0);
                1.0 - base[..6 + k]
                    .iter()
                    .map(|done| row(done) * row(done))
                    .sum::<f64>()
            };
            let farthest = (1..ROWS).fold(0, |a, b| if left(b) > left(a) { b } else { a });
            let mut unit = Rows::zeros();
            if let Some(entry) = unit.get_mut(farthest) {
                *entry = 1.0;
            }
            let direction = beside(&base[..6 + k], unit)?;
            base[6 + k] = direction;
            parity.value = direction.dot(&y);
            for (derivative, effect) in parity.gradient.iter_mut().zip(&effects) {
                *derivative = direction.dot(&along(&white, effect));
            }
        }
        Some(parities)
    }

    /// Weighted least squares, linearised at the forces `normal`, N.
    #[inline(always)]
    fn fit(
        &self,
        y: &Rows,
        traction: &[f64; 6],
        normal: &[f64; 6],
        inputs: &InputCovariance,
    ) -> Result<WholeForces, WholeError> {
        let axial = self.axial_share(y, normal);
        let effects = self.effects(traction, normal);
        let (covariance, with) = self.row_covariance(&effects, traction, normal, inputs);
        let white = whitener(&covariance).ok_or(WholeError::Singular)?;

        let columns: [Rows; 6] = core::array::from_fn(|i| self.column(i, axial));
        let white_columns = columns.each_ref().map(|column| along(&white, column));
        let mut information = [Vector6::zeros(); 6];
        for (row, column) in information.iter_mut().zip(&white_columns) {
            *row = along(&white_columns, column);
        }
        let white_normal = whitener(&information).ok_or(WholeError::Singular)?;
        let mut covariance = Matrix6::zeros();
        for row in &white_normal {
            covariance += row * row.transpose();
        }
        // The gain: covariance of N, columns, weight of the rows.
        let (mut weighted, mut gain) = ([Rows::zeros(); 6], [Rows::zeros(); 6]);
        for (weighted, column) in weighted.iter_mut().zip(&white_columns) {
            *weighted = combined(&white, column.iter().copied());
        }
        for (j, row) in gain.iter_mut().enumerate() {
            *row = combined(&weighted, covariance.column(j).iter().copied());
        }
        let normal: [f64; 6] = along(&gain, y).into();
        let left = y - combined(&columns, normal);
        let mut with_inputs = SMatrix::<f64, 6, INPUTS>::zeros();
        for (mut column, with) in with_inputs.column_iter_mut().zip(&with) {
            column.copy_from(&along(&gain, with));
        }
        Ok(WholeForces {
            normal,
            covariance,
            of_inclination: [0.0; 6],
            with_inputs,
            gain,
            axial,
            misfit: along(&white, &left).norm_squared(),
        })
    }
}
