//! Radau IIA of order 5 (three stages) for stiff equations `y' = f(t, y)`, with error control,
//! dense output, and integrals of functions of the solution.
//!
//! Source: E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II*, IV.8, and their
//! code RADAU5: simplified Newton iterations on the transformed stages (one real and one complex
//! system), predictive step control, reuse of the Jacobian and of the factorisations. Sizes are
//! fixed and errors are absolute. If `f` has no value at a state, the step becomes shorter.

use super::method::{A, C1, C2, Cubic, ERROR, PAIR, REAL, Stages, T, T_INVERSE, combined};
use nalgebra::{Complex, SVector};

/// Largest number of Newton iterations. After these, a shorter step is tried.
const ITERATIONS: u32 = 7;
/// Allowed error of Newton's method, as a share of the tolerance.
const NEWTON: f64 = 0.03;
/// The Jacobian is kept for the next step if Newton's method contracts faster than this.
const KEEP_JACOBIAN: f64 = 1e-3;
/// The step is not increased by less than this ratio, so that the factorisations can be reused.
const KEEP_STEP: f64 = 1.2;
/// Safety factor of the step control.
const SAFETY: f64 = 0.9;
/// Largest number of failed attempts in a row. The step is then 1e-12 of its first length.
const MOST_ATTEMPTS: u32 = 60;

/// The problem: `N` equations, and `Q` integrals that do not influence the solution.
pub(super) trait Model<const N: usize, const Q: usize> {
    /// How linear systems with df/dy are solved.
    type System: System<N>;

    /// f(t, y); `None` if it has no value.
    fn rates(&mut self, t: f64, y: &SVector<f64, N>) -> Option<SVector<f64, N>>;

    /// df/dy at a state with known rates. It may be approximate; only the speed of convergence
    /// depends on it.
    fn jacobian(
        &mut self,
        t: f64,
        y: &SVector<f64, N>,
        rates: &SVector<f64, N>,
    ) -> Option<<Self::System as System<N>>::Jacobian>;

    /// Rates of the integrals.
    fn integrands(&mut self, t: f64, y: &SVector<f64, N>) -> SVector<f64, Q>;

    /// Longest step from a state with known rates. It is called once for each step.
    fn longest_step(&mut self, t: f64, y: &SVector<f64, N>, rates: &SVector<f64, N>) -> f64;
}

/// Factorised matrices `s 1 - df/dy` for a real s and a complex one.
pub(super) trait System<const N: usize>: Sized {
    /// df/dy.
    type Jacobian;

    /// The factorisations; `None` if a matrix is singular.
    fn factorise(jacobian: &Self::Jacobian, real: f64, pair: Complex<f64>) -> Option<Self>;

    /// Solves the real system in place.
    fn solve_real(&self, right: &mut SVector<f64, N>);

    /// Solves the complex system in place.
    fn solve_pair(&self, right: &mut SVector<Complex<f64>, N>);
}

/// No step is short enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoStep;

/// Work of the solver so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Work {
    /// Steps taken.
    pub steps: u64,
    /// Rejected attempts.
    pub rejected: u64,
    /// Evaluations of f, without those for Jacobians.
    pub rates: u64,
    /// Evaluations of df/dy.
    pub jacobians: u64,
    /// Pairs of factorisations.
    pub factorisations: u64,
}

/// Factorised matrices of the Newton iteration for one step length.
struct Factors<S> {
    step: f64,
    system: S,
}

/// A solution that advances step by step.
pub(super) struct Radau<const N: usize, const Q: usize, M: Model<N, Q>> {
    /// Allowed error of a step for each component.
    scale: SVector<f64, N>,
    /// End of the last step.
    pub time: f64,
    y: SVector<f64, N>,
    rates: SVector<f64, N>,
    integrals: SVector<f64, Q>,
    /// Start of the last step, and the solution over it.
    begin: f64,
    dense: Cubic<N>,
    dense_integrals: Cubic<Q>,
    /// The step to try next.
    step: f64,
    /// Last step and its error, for the step control.
    last: Option<(f64, f64)>,
    jacobian: Option<<M::System as System<N>>::Jacobian>,
    factors: Option<Factors<M::System>>,
    /// Error after the first iteration of Newton's method over the change in it, as expected from
    /// earlier steps.
    expected_contraction: f64,
    /// Work so far.
    pub work: Work,
}

/// Increments of the stages, number of iterations, and contraction of the error per iteration.
type Increments<const N: usize> = (Stages<N>, u32, f64);

/// The attempt failed; the next one has the step times this factor.
struct Shorter(f64);

impl<const N: usize, const Q: usize, M: Model<N, Q>> Radau<N, Q, M> {
    /// Starts at time 0 with all integrals at zero. `scale` is the allowed error of a step for each
    /// component.
    ///
    /// # Errors
    /// [`NoStep`] if f has no value at the start.
    pub fn new(
        model: &mut M,
        start: &SVector<f64, N>,
        scale: SVector<f64, N>,
        first_step: f64,
    ) -> Result<Self, NoStep> {
        Ok(Self {
            scale,
            time: 0.0,
            y: *start,
            rates: model.rates(0.0, start).ok_or(NoStep)?,
            integrals: SVector::zeros(),
            begin: 0.0,
            dense: Cubic([SVector::zeros(); 3]),
            dense_integrals: Cubic([SVector::zeros(); 3]),
            step: first_step,
            last: None,
            jacobian: None,
            factors: None,
            expected_contraction: 1.0,
            work: Work::default(),
        })
    }

    /// The solution and the integrals at a time within the last step.
    #[inline]
    pub fn at(&self, time: f64) -> (SVector<f64, N>, SVector<f64, Q>) {
        let length = self.time - self.begin;
        let s = match length > 0.0 {
            true => (time - self.time) / length,
            false => 0.0,
        };
        let (y, integrals) = (self.dense.beyond(s), self.dense_integrals.beyond(s));
        (self.y + y, self.integrals + integrals)
    }

    /// Starts anew at a time within the last step, where f jumps. What was computed beyond it is
    /// dropped.
    ///
    /// # Errors
    /// [`NoStep`] if f has no value there.
    pub fn restart(&mut self, model: &mut M, time: f64) -> Result<(), NoStep> {
        if time < self.time {
            (self.y, self.integrals) = self.at(time);
            self.time = time;
            self.begin = time;
        }
        self.rates = model.rates(self.time, &self.y).ok_or(NoStep)?;
        self.work.rates += 1;
        self.last = None;
        Ok(())
    }

    /// Advances by one step, as long as the error allows.
    ///
    /// # Errors
    /// [`NoStep`] if no step is short enough.
    pub fn advance(&mut self, model: &mut M) -> Result<(), NoStep> {
        let longest = model.longest_step(self.time, &self.y, &self.rates);
        // Whether the Jacobian was evaluated at the start of this step.
        let mut fresh = self.jacobian.is_none();
        for attempt in 0..MOST_ATTEMPTS {
            self.step = self.step.min(longest);
            if self.time + self.step <= self.time {
                return Err(NoStep);
            }
            match self.attempt(model, attempt > 0) {
                Ok(()) => return Ok(()),
                Err(Shorter(factor)) => {
                    self.work.rejected += 1;
                    self.step *= factor;
                    if !fresh {
                        self.jacobian = None;
                        fresh = true;
                    }
                }
            }
        }
        Err(NoStep)
    }

    /// One attempt at a step of the planned length.
    fn attempt(&mut self, model: &mut M, retried: bool) -> Result<(), Shorter> {
        let factors = self.factors(model).ok_or(Shorter(0.5))?;
        let retried = retried || self.last.is_none();
        let solved = (self.newton(model, &factors.system)).map(|stages| {
            (
                stages,
                self.error(model, &factors.system, &stages.0, retried),
            )
        });
        self.factors = Some(factors);
        let ((z, iterations, contraction), error) = solved?;
        if iterations > 1 {
            self.expected_contraction = contraction / (1.0 - contraction);
        }
        let longest_iteration = f64::from(1 + 2 * ITERATIONS);
        let safety = SAFETY * (longest_iteration / f64::from(iterations + 2 * ITERATIONS)).min(1.0);
        let factor = (safety * error.powf(-0.25)).clamp(0.125, 5.0);
        if error.is_nan() {
            return Err(Shorter(0.125));
        }
        if error >= 1.0 {
            return Err(Shorter(factor.min(SAFETY)));
        }
        let y = self.y + z[2];
        let rates = model.rates(self.time + self.step, &y).ok_or(Shorter(0.5))?;
        self.work.rates += 1;
        self.accept(model, &z, y, rates);
        self.plan(error, factor, contraction);
        Ok(())
    }

    /// The factorised matrices for a step, reused from the last step if possible. `None` if one is
    /// singular.
    fn factors(&mut self, model: &mut M) -> Option<Factors<M::System>> {
        let h = self.step;
        if let (Some(factors), Some(_)) = (self.factors.take(), &self.jacobian)
            && (factors.step - h).abs() <= 1e-12 * h
        {
            return Some(factors);
        }
        if self.jacobian.is_none() {
            self.work.jacobians += 1;
            self.jacobian = Some(model.jacobian(self.time, &self.y, &self.rates)?);
        }
        let jacobian = self.jacobian.as_ref()?;
        self.work.factorisations += 1;
        let system = M::System::factorise(jacobian, REAL / h, PAIR / h)?;
        Some(Factors { step: h, system })
    }

    /// RMS over the components of an error relative to the allowed errors.
    fn norm(&self, error: &SVector<f64, N>) -> f64 {
        let count = N as f64;
        (error.component_div(&self.scale).norm_squared() / count).sqrt()
    }

    /// Simplified Newton iterations for the increments of the stages, started from the extrapolated
    /// polynomial of the last step.
    fn newton(&mut self, model: &mut M, system: &M::System) -> Result<Increments<N>, Shorter> {
        let h = self.step;
        let length = self.time - self.begin;
        let mut z = [C1, C2, 1.0].map(|c| match length > 0.0 {
            true => self.dense.beyond(c * h / length),
            false => SVector::zeros(),
        });
        let mut w = combined(&T_INVERSE, &z);
        let (mut before, mut contraction) = (0.0, 0.0);
        // The convergence rate of an earlier step counts less from step to step.
        self.expected_contraction = self.expected_contraction.max(1e-16).powf(0.8);
        for iteration in 1..=ITERATIONS {
            let mut f = [SVector::zeros(); 3];
            for i in 0..3 {
                let node = self.time + [C1, C2, 1.0][i] * h;
                self.work.rates += 1;
                f[i] = (model.rates(node, &(self.y + z[i]))).ok_or(Shorter(0.5))?;
            }
            let f = combined(&T_INVERSE, &f);
            let mut real = f[0] - w[0] * (REAL / h);
            let mut pair = SVector::<Complex<f64>, N>::from_fn(|i, _| {
                let w = Complex::new(w[1][i], w[2][i]);
                Complex::new(f[1][i], f[2][i]) - PAIR / h * w
            });
            system.solve_real(&mut real);
            system.solve_pair(&mut pair);
            w[0] += real;
            w[1] += pair.map(|p| p.re);
            w[2] += pair.map(|p| p.im);
            z = combined(&T, &w);
            let square = self.norm(&real).powi(2)
                + self.norm(&pair.map(|p| p.re)).powi(2)
                + self.norm(&pair.map(|p| p.im)).powi(2);
            let change = (square / 3.0).sqrt();
            if !change.is_finite() {
                return Err(Shorter(0.5));
            }
            if iteration > 1 {
                let ratio: f64 = change / before;
                contraction = match iteration {
                    2 => ratio,
                    _ => (contraction * ratio).sqrt(),
                };
                if contraction >= 0.99 {
                    return Err(Shorter(0.5));
                }
                // Expected error after the remaining iterations.
                let remaining = i32::try_from(ITERATIONS - iteration).unwrap_or(0);
                let left = contraction / (1.0 - contraction) * change;
                let expected = left * contraction.powi(remaining) / NEWTON;
                if expected >= 1.0 {
                    let power = -1.0 / f64::from(4 + remaining);
                    return Err(Shorter(0.8 * expected.clamp(1e-4, 20.0).powf(power)));
                }
                if left <= NEWTON {
                    return Ok((z, iteration, contraction));
                }
            } else if self.expected_contraction * change <= NEWTON {
                return Ok((z, iteration, 0.0));
            }
            before = change;
        }
        Err(Shorter(0.5))
    }

    /// Error of the step relative to the allowed one.
    fn error(&mut self, model: &mut M, system: &M::System, z: &Stages<N>, retried: bool) -> f64 {
        let stages = (z[0] * ERROR[0] + z[1] * ERROR[1] + z[2] * ERROR[2]) / self.step;
        let mut error = stages + self.rates;
        system.solve_real(&mut error);
        let first = self.norm(&error);
        // The estimate is too large for errors of stiff components: it is filtered once more.
        if first >= 1.0 && retried {
            self.work.rates += 1;
            if let Some(rates) = model.rates(self.time, &(self.y + error)) {
                let mut error = stages + rates;
                system.solve_real(&mut error);
                return self.norm(&error).max(1e-10);
            }
        }
        first.max(1e-10)
    }

    /// Accepts the step and integrates over it.
    fn accept(&mut self, model: &mut M, z: &Stages<N>, y: SVector<f64, N>, rates: SVector<f64, N>) {
        let h = self.step;
        let integrands: Stages<Q> = [0, 1, 2].map(|i| {
            let node = self.time + [C1, C2, 1.0][i] * h;
            model.integrands(node, &(self.y + z[i]))
        });
        let integrals = combined(&A, &integrands).map(|z| z * h);
        self.dense = Cubic::new(z);
        self.dense_integrals = Cubic::new(&integrals);
        self.begin = self.time;
        self.time += h;
        self.y = y;
        self.integrals += integrals[2];
        self.rates = rates;
        self.work.steps += 1;
    }

    /// Chooses the length of the next step and what it reuses.
    fn plan(&mut self, error: f64, factor: f64, contraction: f64) {
        let h = self.step;
        let mut factor = factor;
        if let Some((last_step, last_error)) = self.last {
            // Gustafsson's predictive control: a growing error is expected to continue to grow.
            let predicted = SAFETY * h / last_step * (last_error / (error * error)).powf(0.25);
            factor = factor.min(predicted).clamp(0.125, 5.0);
        }
        self.last = Some((h, error.max(0.01)));
        if contraction > KEEP_JACOBIAN {
            self.jacobian = None;
        } else if (1.0..=KEEP_STEP).contains(&factor) {
            factor = 1.0;
        }
        self.step = h * factor;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests;
