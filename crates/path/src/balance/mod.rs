//! The best distribution of tractions at one place, by linear programs.
//!
//! Equilibrium is eq. (8), `H x' = F'`, with a column for N and one for T of every contact, two
//! contacts of a wheel included. Eq. (8) has four rows, so with one contact a wheel two of the six
//! forces can be chosen. The needed friction is the least m with `|T_k| <= m N_k` and `N_k >= 0` at
//! every contact k and `|sum of T_k|` of each wheel at most the torque limit over the wheel radius.
//!
//! More generally `|T_k| <= max(mu_k + e, 0) N_k` is solved for the least e: with mu_k = 0 it is the
//! needed friction, with the available mu_k it is minus the margin. For a fixed e
//!
//! ```text
//! min t   subject to   H x' = F',   |T_k| - (mu_k + e) N_k <= t w_k,   N_k >= 0
//! ```
//!
//! with T_k = 0 where mu_k + e is not above 0 is a linear program, and e is allowed where t <= 0.
//! From an allowed e the largest `|T_k|/N_k - mu_k` of its solution, over the contacts with a
//! traction, is a smaller allowed e, and so on down to the least one
//! (Dinkelbach's method for ratios, with the N_k of the last solution as weights w_k; Crouzeix,
//! Ferland and Schaible 1985).

use crate::setup::Tractions;
use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Variable};
use nalgebra::Vector4;
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::{Geometry, Posture, PostureError, Robot, Vec2, cross, perp};

/// An e that is allowed wherever the robot can be balanced at all: a contact that nearly slides
/// along its own normal.
const LARGEST: f64 = 1e4;
/// The search has converged when e falls by less. A contact whose friction has fallen to that has
/// none.
const CONVERGED: f64 = 1e-9;
/// A traction below this share of the weight is none: the tolerance of the solver.
const NO_TRACTION: f64 = 1e-9;
/// Least weight of a contact, N: one that carries next to nothing still counts.
const LEAST_WEIGHT: f64 = 1e-3;
/// Largest N and |T| of a contact over the weight of the robot. Two contacts of a wheel can press
/// against each other without bound, which balances nothing more; and a traction without moment
/// would get one by rounding.
const LARGEST_LOAD: f64 = 10.0;
/// Largest number of linear programs for one e.
const MOST_PROGRAMS: u32 = 60;

/// A contact of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundContact {
    /// Wheel: 0 front, 1 middle, 2 rear.
    pub wheel: usize,
    /// Point on the ground, m.
    pub point: Vec2,
    /// Unit tangent, pointing forward.
    pub tangent: Vec2,
    /// Available friction coefficient there, -.
    pub mu: f64,
}

impl GroundContact {
    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        perp(self.tangent)
    }
}

/// Eq. (8) at one place.
#[derive(Clone, Debug)]
pub struct Balance {
    contacts: Vec<GroundContact>,
    /// Columns of N and T of each contact: two rows of forces (N), moments of links 1 and 2 about Q
    /// over the wheel radius (N).
    columns: Vec<[Vector4<f64>; 2]>,
    right: Vector4<f64>,
    /// Largest tractions of a wheel.
    limits: Tractions,
}

/// Forces that balance the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Least e, -.
    pub excess: f64,
    /// Sum of N over the contacts of each wheel, N.
    pub normal_force: [f64; 3],
    /// Sum of T over the contacts of each wheel, N.
    pub traction: [f64; 3],
}

/// Why a linear program has no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unsolved {
    /// No forces fulfil the conditions.
    Infeasible,
    /// A numerical failure.
    Numerical,
}

/// Columns of N and T of each contact in eq. (8), with moments over the wheel radius; `q` is the
/// position of pin Q, m.
pub fn columns_of(
    geometry: &Geometry,
    q: Vec2,
    contacts: &[GroundContact],
) -> Vec<[Vector4<f64>; 2]> {
    let column = |contact: &GroundContact, force: Vec2| {
        let mut rows = Vector4::new(force.x, force.y, 0.0, 0.0);
        let moment = cross(contact.point - q, force) / geometry.wheel_radius;
        rows[2 + geometry.carriers[contact.wheel].index()] = moment;
        rows
    };
    let both = |c: &GroundContact| [column(c, c.normal()), column(c, c.tangent)];
    contacts.iter().map(both).collect()
}

/// Sums of forces of contacts (N) over the contacts of each wheel, N.
pub fn by_wheel(contacts: &[GroundContact], forces: &[f64]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (contact, force) in contacts.iter().zip(forces) {
        sums[contact.wheel] += force;
    }
    sums
}

/// Adds eq. (8) to a linear program: its variables with their columns, and the right side.
pub fn add_equations(
    problem: &mut Problem,
    columns: &[(Variable, Vector4<f64>)],
    right: &Vector4<f64>,
) {
    for i in 0..4 {
        let row = columns
            .iter()
            .map(|(variable, column)| (*variable, column[i]));
        let row: Vec<_> = row.filter(|(_, value)| *value != 0.0).collect();
        problem.add_constraint(&row, ComparisonOp::Eq, right[i]);
    }
}

/// A linear program in N_k and T_k.
struct Program {
    problem: Problem,
    normal: Vec<Variable>,
    traction: Vec<Variable>,
    /// The variable that is minimised.
    objective: Variable,
}

impl Balance {
    /// Eq. (8) with `contacts`, whose wheels sit on the links in this posture; `q` is the position
    /// of pin Q, m.
    ///
    /// # Errors
    /// [`PostureError`] where the four-bar cannot close.
    pub fn new(
        robot: &Robot,
        posture: &Posture,
        q: Vec2,
        contacts: Vec<GroundContact>,
        limits: Tractions,
    ) -> Result<Self, PostureError> {
        let geometry = &robot.geometry;
        let [theta1, theta2, _] = posture.links;
        let arms = Arms::new(geometry, theta1, theta2)?;
        let up = Vec2::new(0.0, robot.gravity);
        let weights = Loads::uniform(&robot.mass.true_points(), up);
        let lever = geometry.wheel_radius;
        let (right, _) = Equilibrium::load_side(&arms, &geometry.carriers, &weights, lever);
        Ok(Self {
            columns: columns_of(geometry, q, &contacts),
            contacts,
            right,
            limits,
        })
    }

    /// The least e with `|T_k| <= max(mu_k + e, 0) N_k`, searched from `guess`. Without `available`
    /// all mu_k are 0, so e is the needed friction. At least minus the largest mu_k: no friction is
    /// left then.
    ///
    /// # Errors
    /// [`Unsolved`]
    pub fn least_excess(&self, available: bool, guess: f64) -> Result<Distribution, Unsolved> {
        let mu = self.contacts.iter();
        let mu = mu.map(|c| if available { c.mu } else { 0.0 });
        let mu: Vec<f64> = mu.collect();
        let mut best = match self.improve(guess, &mu, None)? {
            Some(first) => first,
            None => (self.improve(LARGEST, &mu, None)?).ok_or(Unsolved::Infeasible)?,
        };
        for _ in 0..MOST_PROGRAMS {
            let Some(next) = self.improve(best.0.excess, &mu, Some(&best.1))? else {
                break;
            };
            let fall = best.0.excess - next.0.excess;
            if fall > 0.0 {
                best = next;
            }
            if fall < CONVERGED {
                break;
            }
        }
        Ok(best.0)
    }

    /// The solution for e = `excess` and the N_k; `None` if that e is not allowed.
    fn improve(
        &self,
        excess: f64,
        mu: &[f64],
        weights: Option<&[f64]>,
    ) -> Result<Option<(Distribution, Vec<f64>)>, Unsolved> {
        // Without friction at all contacts nothing else bounds t.
        let mut program = self.program((-LARGEST * self.right[1].abs(), f64::INFINITY), 0.0);
        let t = program.objective;
        for (k, mu) in mu.iter().enumerate() {
            let (normal, traction) = (program.normal[k], program.traction[k]);
            if mu + excess <= CONVERGED {
                let row = [(traction, 1.0)];
                program.problem.add_constraint(row, ComparisonOp::Eq, 0.0);
                continue;
            }
            let weight = weights.map_or(1.0, |w| w[k].max(LEAST_WEIGHT));
            for sign in [1.0, -1.0] {
                let row = [(traction, sign), (normal, -(mu + excess)), (t, -weight)];
                program.problem.add_constraint(row, ComparisonOp::Le, 0.0);
            }
        }
        self.limit_tractions(&mut program, None);
        let (normal, traction, t) = match program.solve() {
            Err(Unsolved::Infeasible) => return Ok(None),
            other => other?,
        };
        let none = NO_TRACTION * self.right[1].abs();
        let largest = mu.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let ratios = normal.iter().zip(&traction).zip(mu);
        let ratios = ratios.filter(|((n, t), _)| **n > 1e-9 && t.abs() > none);
        let ratios = ratios.map(|((n, t), mu)| t.abs() / n - mu);
        let found = ratios.fold(0.0 - largest, f64::max);
        // An e that is allowed only within the tolerance of the solver is the least one.
        if t > 1e-9 * self.right.norm() {
            return Ok(None);
        }
        Ok(Some((self.distribution(found, &normal, &traction), normal)))
    }

    /// The smallest possible largest T of a wheel without a limit of the torque, N; backwards less
    /// by twice the losses of the gear, which help to brake.
    ///
    /// # Errors
    /// [`Unsolved::Infeasible`] where no N >= 0 balance the robot with any tractions.
    pub fn least_traction(&self) -> Result<f64, Unsolved> {
        let mut program = self.program((f64::NEG_INFINITY, f64::INFINITY), 0.0);
        let largest = program.objective;
        self.limit_tractions(&mut program, Some(largest));
        program.solve().map(|(_, _, value)| value)
    }

    /// The N of the wheel with the least load, N, at the tractions that make it largest; below 0
    /// where a wheel lifts.
    ///
    /// # Errors
    /// [`Unsolved`]
    pub fn largest_least_load(&self) -> Result<f64, Unsolved> {
        let mut program = self.program((f64::NEG_INFINITY, f64::INFINITY), f64::NEG_INFINITY);
        let lack = program.objective;
        for variable in &program.normal {
            // N_k >= -lack
            let row = [(*variable, 1.0), (lack, 1.0)];
            program.problem.add_constraint(row, ComparisonOp::Ge, 0.0);
        }
        program.solve().map(|(_, _, lack)| -lack)
    }

    /// Variables and eq. (8). The objective has the given range, N_k a lower bound.
    fn program(&self, range: (f64, f64), least: f64) -> Program {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let mut variables = |range: (f64, f64)| -> Vec<Variable> {
            let one = |_| problem.add_var(0.0, range);
            self.contacts.iter().map(one).collect()
        };
        let largest = LARGEST_LOAD * self.right[1].abs();
        let normal = variables((least, largest));
        let traction = variables((-largest, largest));
        let objective = problem.add_var(1.0, range);
        let columns = self.columns.iter().zip(normal.iter().zip(&traction));
        let columns = columns.flat_map(|(c, (n, t))| [(*n, c[0]), (*t, c[1])]);
        add_equations(&mut problem, &columns.collect::<Vec<_>>(), &self.right);
        Program {
            problem,
            normal,
            traction,
            objective,
        }
    }

    /// The sum of T of each wheel within the limits; or at most a variable, and backwards as much
    /// more as the limits differ.
    fn limit_tractions(&self, program: &mut Program, most: Option<Variable>) {
        let Tractions { braking, driving } = self.limits;
        for wheel in 0..3 {
            for (sign, limit) in [(1.0, driving), (-1.0, braking)] {
                let limit = most.map_or(limit, |_| limit - driving);
                let all = self.contacts.iter().zip(&program.traction);
                let own = all.filter(|(c, _)| c.wheel == wheel);
                let mut row: Vec<_> = own.map(|(_, t)| (*t, sign)).collect();
                row.extend(most.map(|m| (m, -1.0)));
                let problem = &mut program.problem;
                problem.add_constraint(&row, ComparisonOp::Le, limit);
            }
        }
    }

    fn distribution(&self, excess: f64, normal: &[f64], traction: &[f64]) -> Distribution {
        Distribution {
            excess,
            normal_force: by_wheel(&self.contacts, normal),
            traction: by_wheel(&self.contacts, traction),
        }
    }
}

/// N_k, T_k and the objective.
type Values = (Vec<f64>, Vec<f64>, f64);

impl Program {
    fn solve(&self) -> Result<Values, Unsolved> {
        let outcome = self.problem.solve().map_err(|error| match error {
            Error::Infeasible => Unsolved::Infeasible,
            _ => Unsolved::Numerical,
        })?;
        let solution = outcome.into_solution();
        let solution = solution.map_err(|_| Unsolved::Numerical)?;
        let values = |variables: &[Variable]| -> Vec<f64> {
            let one = |v: &Variable| solution.var_value(*v);
            variables.iter().map(one).collect()
        };
        let objective = solution.var_value(self.objective);
        Ok((values(&self.normal), values(&self.traction), objective))
    }
}

#[cfg(test)]
mod tests;
