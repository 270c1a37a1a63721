//! Radau IIA of order 5 (three stages) for stiff equations `y' = f(t, y)`, with error control, dense output, and
//! integrals of functions of the solution.
//!
//! Source: E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II*, IV.8, and their code RADAU5:
//! simplified Newton iterations on the transformed stages (one real and one complex system), predictive step control,
//! reuse of the Jacobian and of the factorisations. Sizes are fixed and errors are absolute. If `f` has no value at a
//! state, the step becomes shorter.

use nalgebra::{Complex, Const, DimMin, LU, SMatrix, SVector, ToTypenum};

/// The problem: `N` equations, and `Q` integrals that do not influence the solution.
pub(super) trait Model<const N: usize, const Q: usize> {
    /// f(t, y); `None` if it has no value.
    fn rates(&mut self, t: f64, y: &SVector<f64, N>) -> Option<SVector<f64, N>>;

    /// df/dy at a state with known rates. It may be approximate; only the speed of convergence depends on it.
    fn jacobian(
        &mut self,
        t: f64,
        y: &SVector<f64, N>,
        rates: &SVector<f64, N>,
    ) -> Option<SMatrix<f64, N, N>>;

    /// Rates of the integrals.
    fn integrands(&mut self, t: f64, y: &SVector<f64, N>) -> SVector<f64, Q>;

    /// Longest step from here.
    fn longest_step(&self, t: f64, y: &SVector<f64, N>) -> f64;
}

/// Nodes of the method besides 1: (4 -+ sqrt 6)/10.
const C1: f64 = 0.155_051_025_721_682_2;
const C2: f64 = 0.644_948_974_278_317_8;
/// Weights of the method: integrals from the start of a step to each node.
const A: [[f64; 3]; 3] = [
    [
        0.196_815_477_223_660_44,
        -0.065_535_425_850_198_39,
        0.023_770_974_348_220_15,
    ],
    [
        0.394_424_314_739_087_3,
        0.292_073_411_665_228_45,
        -0.041_548_752_125_997_93,
    ],
    [
        0.376_403_062_700_467_3,
        0.512_485_826_188_421_6,
        0.111_111_111_111_111_1,
    ],
];
/// Eigenvalues of the inverse of the weights: one real, one pair.
const REAL: f64 = 3.637_834_252_744_496;
const PAIR: Complex<f64> = Complex::new(2.681_082_873_627_752_3, 3.050_430_199_247_410_5);
/// From transformed stages to stages, and back.
const T: [[f64; 3]; 3] = [
    [
        9.123_239_487_089_295e-2,
        -0.141_255_295_020_954_2,
        -3.002_919_410_514_742_4e-2,
    ],
    [
        0.241_717_932_707_107,
        0.204_129_352_293_799_93,
        0.382_942_112_757_262,
    ],
    [0.966_048_182_615_093, 1.0, 0.0],
];
const T_INVERSE: [[f64; 3]; 3] = [
    [
        4.325_579_890_063_155,
        0.339_199_251_815_809_9,
        0.541_770_539_935_874_9,
    ],
    [
        -4.178_718_591_551_905,
        -0.327_682_820_761_062_4,
        0.476_623_554_500_550_44,
    ],
    [
        -0.502_872_634_945_786_9,
        2.571_926_949_855_605,
        -0.596_039_204_828_224_9,
    ],
];
/// Weights of the stages in the error estimate, which is the difference to a formula of order 3.
const ERROR: [f64; 3] = [-10.048_809_399_827_416, 1.382_142_733_160_749, -1.0 / 3.0];

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

/// Cubic polynomial over a step, as divided differences from the end of the step.
#[derive(Clone, Copy)]
struct Cubic<const M: usize>([SVector<f64, M>; 3]);

impl<const M: usize> Default for Cubic<M> {
    fn default() -> Self {
        Self([SVector::zeros(); 3])
    }
}

impl<const M: usize> Cubic<M> {
    /// From the increments at the three nodes.
    fn new(z: &[SVector<f64, M>; 3]) -> Self {
        let b = (z[1] - z[2]) / (C2 - 1.0);
        let ak = (z[0] - z[1]) / (C1 - C2);
        let c = (ak - b) / (C1 - 1.0);
        let d = c - (ak - z[0] / C1) / C2;
        Self([b, c, d])
    }

    /// Increment from the step's end to `s` steps beyond it; negative within the step.
    fn beyond(&self, s: f64) -> SVector<f64, M> {
        let [b, c, d] = self.0;
        (b + (c + d * (s - (C1 - 1.0))) * (s - (C2 - 1.0))) * s
    }
}

/// Factorised matrices of the Newton iteration for one step.
struct Factors<const N: usize>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    step: f64,
    real: LU<f64, Const<N>, Const<N>>,
    pair: LU<Complex<f64>, Const<N>, Const<N>>,
}

/// A solution that advances step by step.
pub(super) struct Radau<const N: usize, const Q: usize>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    /// Allowed error of a step for each component.
    scale: SVector<f64, N>,
    time: f64,
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
    jacobian: Option<SMatrix<f64, N, N>>,
    factors: Option<Factors<N>>,
    work: Work,
}

/// Result of the Newton iteration.
enum Newton<const N: usize> {
    /// Increments of the stages, number of iterations, and contraction of the error per iteration.
    Converged([SVector<f64, N>; 3], u32, f64),
    /// Failed; a new attempt with the step times this factor may succeed.
    Failed(f64),
}

/// The attempt failed; the next one has the step times this factor.
struct Shorter(f64);

impl<const N: usize, const Q: usize> Radau<N, Q>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    /// Starts at time 0 with all integrals at zero. `scale` is the allowed error of a step for each component.
    ///
    /// # Errors
    /// [`NoStep`] if f has no value at the start.
    pub fn new(
        model: &mut impl Model<N, Q>,
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
            dense: Cubic::default(),
            dense_integrals: Cubic::default(),
            step: first_step,
            last: None,
            jacobian: None,
            factors: None,
            work: Work::default(),
        })
    }

    /// End of the last step.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Work so far.
    pub fn work(&self) -> Work {
        self.work
    }

    /// The solution and the integrals at a time within the last step.
    pub fn at(&self, time: f64) -> (SVector<f64, N>, SVector<f64, Q>) {
        let length = self.time - self.begin;
        let s = if length > 0.0 {
            (time - self.time) / length
        } else {
            0.0
        };
        (
            self.y + self.dense.beyond(s),
            self.integrals + self.dense_integrals.beyond(s),
        )
    }

    /// Starts anew at a time within the last step, where f jumps. What was computed beyond it is dropped.
    ///
    /// # Errors
    /// [`NoStep`] if f has no value there.
    pub fn restart(&mut self, model: &mut impl Model<N, Q>, time: f64) -> Result<(), NoStep> {
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
    pub fn advance(&mut self, model: &mut impl Model<N, Q>) -> Result<(), NoStep> {
        let longest = model.longest_step(self.time, &self.y);
        // Whether the Jacobian was evaluated at the start of this step.
        let mut fresh = self.jacobian.is_none();
        for attempt in 0..MOST_ATTEMPTS {
            if self.step > longest {
                self.step = longest;
            }
            if self.time + self.step <= self.time {
                return Err(NoStep);
            }
            match self.attempt(model, attempt > 0, longest) {
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
    fn attempt(
        &mut self,
        model: &mut impl Model<N, Q>,
        retried: bool,
        longest: f64,
    ) -> Result<(), Shorter> {
        let h = self.step;
        let factors = self.factors(model, h).ok_or(Shorter(0.5))?;
        let newton = self.newton(model, &factors, h);
        let (z, iterations, contraction) = match newton {
            Newton::Converged(z, iterations, contraction) => (z, iterations, contraction),
            Newton::Failed(factor) => {
                self.factors = Some(factors);
                return Err(Shorter(factor));
            }
        };
        let error = self.error(model, &factors, h, &z, retried || self.last.is_none());
        self.factors = Some(factors);
        let longest_iteration = f64::from(1 + 2 * ITERATIONS);
        let safety = SAFETY * (longest_iteration / f64::from(iterations + 2 * ITERATIONS)).min(1.0);
        let factor = (safety * error.powf(-0.25)).clamp(0.125, 5.0);
        if error.is_nan() || error >= 1.0 {
            return Err(Shorter(if error.is_nan() {
                0.125
            } else {
                factor.min(SAFETY)
            }));
        }
        let y = self.y + z[2];
        let rates = model.rates(self.time + h, &y).ok_or(Shorter(0.5))?;
        self.work.rates += 1;
        self.accept(model, h, &z, y, rates);
        self.plan(h, error, factor, contraction, longest);
        Ok(())
    }

    /// The factorised matrices for a step, reused from the last step if possible. `None` if one is singular.
    fn factors(&mut self, model: &mut impl Model<N, Q>, h: f64) -> Option<Factors<N>> {
        if let (Some(factors), Some(_)) = (self.factors.take(), &self.jacobian)
            && (factors.step - h).abs() <= 1e-12 * h
        {
            return Some(factors);
        }
        let jacobian = match self.jacobian {
            Some(jacobian) => jacobian,
            None => {
                self.work.jacobians += 1;
                let jacobian = model.jacobian(self.time, &self.y, &self.rates)?;
                *self.jacobian.insert(jacobian)
            }
        };
        self.work.factorisations += 1;
        let mut real = -jacobian;
        let mut pair = jacobian.map(|entry| Complex::new(-entry, 0.0));
        for i in 0..N {
            real[(i, i)] += REAL / h;
            pair[(i, i)] += PAIR / h;
        }
        let factors = Factors {
            step: h,
            real: real.lu(),
            pair: pair.lu(),
        };
        (factors.real.is_invertible() && factors.pair.is_invertible()).then_some(factors)
    }

    /// RMS over the components of an error relative to the allowed errors.
    fn norm(&self, error: &SVector<f64, N>) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a small number of equations")]
        let count = N as f64;
        (error.component_div(&self.scale).norm_squared() / count).sqrt()
    }

    /// Simplified Newton iterations for the increments of the stages, started from the extrapolated polynomial of the
    /// last step.
    fn newton(&mut self, model: &mut impl Model<N, Q>, factors: &Factors<N>, h: f64) -> Newton<N> {
        let length = self.time - self.begin;
        let mut z = [C1, C2, 1.0].map(|c| {
            if length > 0.0 {
                self.dense.beyond(c * h / length)
            } else {
                SVector::zeros()
            }
        });
        let mut w = combined(&T_INVERSE, &z);
        let (mut before, mut contraction) = (0.0, 0.0);
        for iteration in 1..=ITERATIONS {
            let mut f = [SVector::zeros(); 3];
            for i in 0..3 {
                let node = self.time + [C1, C2, 1.0][i] * h;
                self.work.rates += 1;
                let Some(rates) = model.rates(node, &(self.y + z[i])) else {
                    return Newton::Failed(0.5);
                };
                f[i] = rates;
            }
            let f = combined(&T_INVERSE, &f);
            let mut real = f[0] - w[0] * (REAL / h);
            let mut pair = SVector::<Complex<f64>, N>::from_fn(|i, _| {
                let w = Complex::new(w[1][i], w[2][i]);
                Complex::new(f[1][i], f[2][i]) - PAIR / h * w
            });
            factors.real.solve_mut(&mut real);
            factors.pair.solve_mut(&mut pair);
            w[0] += real;
            w[1] += pair.map(|p| p.re);
            w[2] += pair.map(|p| p.im);
            z = combined(&T, &w);
            let square = self.norm(&real).powi(2)
                + self.norm(&pair.map(|p| p.re)).powi(2)
                + self.norm(&pair.map(|p| p.im)).powi(2);
            let change = (square / 3.0).sqrt();
            if !change.is_finite() {
                return Newton::Failed(0.5);
            }
            if iteration > 1 {
                let ratio: f64 = change / before;
                contraction = if iteration == 2 {
                    ratio
                } else {
                    (contraction * ratio).sqrt()
                };
                if contraction >= 0.99 {
                    return Newton::Failed(0.5);
                }
                // Expected error after the remaining iterations.
                let remaining = i32::try_from(ITERATIONS - iteration).unwrap_or(0);
                let left = contraction / (1.0 - contraction) * change;
                let expected = left * contraction.powi(remaining) / NEWTON;
                if expected >= 1.0 {
                    let factor = 0.8
                        * expected
                            .clamp(1e-4, 20.0)
                            .powf(-1.0 / f64::from(4 + remaining));
                    return Newton::Failed(factor);
                }
                if left <= NEWTON {
                    return Newton::Converged(z, iteration, contraction);
                }
            } else if change <= 1e-3 * NEWTON {
                return Newton::Converged(z, iteration, contraction);
            }
            before = change;
        }
        Newton::Failed(0.5)
    }

    /// Error of the step relative to the allowed one.
    fn error(
        &mut self,
        model: &mut impl Model<N, Q>,
        factors: &Factors<N>,
        h: f64,
        z: &[SVector<f64, N>; 3],
        retried: bool,
    ) -> f64 {
        let stages = (z[0] * ERROR[0] + z[1] * ERROR[1] + z[2] * ERROR[2]) / h;
        let mut error = stages + self.rates;
        factors.real.solve_mut(&mut error);
        let first = self.norm(&error);
        // The estimate is too large for errors of stiff components: it is filtered once more.
        if first >= 1.0 && retried {
            self.work.rates += 1;
            if let Some(rates) = model.rates(self.time, &(self.y + error)) {
                let mut error = stages + rates;
                factors.real.solve_mut(&mut error);
                return self.norm(&error).max(1e-10);
            }
        }
        first.max(1e-10)
    }

    /// Accepts the step and integrates over it.
    fn accept(
        &mut self,
        model: &mut impl Model<N, Q>,
        h: f64,
        z: &[SVector<f64, N>; 3],
        y: SVector<f64, N>,
        rates: SVector<f64, N>,
    ) {
        let integrands: [SVector<f64, Q>; 3] = [0, 1, 2].map(|i| {
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
    fn plan(&mut self, h: f64, error: f64, factor: f64, contraction: f64, longest: f64) {
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
        self.step = (h * factor).min(longest);
    }
}

/// Product of the matrix `rows` with three vectors.
fn combined<const M: usize>(
    rows: &[[f64; 3]; 3],
    v: &[SVector<f64, M>; 3],
) -> [SVector<f64, M>; 3] {
    rows.map(|[a, b, c]| v[0] * a + v[1] * b + v[2] * c)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests;
