use super::*;
use nalgebra::{Const, DimMin, LU, SMatrix, ToTypenum};

/// Any system of equations, by factorisations of the whole matrices.
struct Dense<const N: usize>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    real: LU<f64, Const<N>, Const<N>>,
    pair: LU<Complex<f64>, Const<N>, Const<N>>,
}

impl<const N: usize> System<N> for Dense<N>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    type Jacobian = SMatrix<f64, N, N>;

    fn factorise(jacobian: &Self::Jacobian, real: f64, pair: Complex<f64>) -> Option<Self> {
        let of_pair = SMatrix::<Complex<f64>, N, N>::identity() * pair
            - jacobian.map(|entry| Complex::new(entry, 0.0));
        let factors = Self {
            real: (SMatrix::identity() * real - jacobian).lu(),
            pair: of_pair.lu(),
        };
        (factors.real.is_invertible() && factors.pair.is_invertible()).then_some(factors)
    }

    fn solve_real(&self, right: &mut SVector<f64, N>) {
        self.real.solve_mut(right);
    }

    fn solve_pair(&self, right: &mut SVector<Complex<f64>, N>) {
        self.pair.solve_mut(right);
    }
}

/// Equations given by a function that may have no value. The integrals are those of the solution
/// itself.
struct Test<const N: usize, F> {
    f: F,
    longest_step: f64,
}

impl<const N: usize, F> Model<N, N> for Test<N, F>
where
    F: Fn(f64, &SVector<f64, N>) -> Option<SVector<f64, N>>,
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    type System = Dense<N>;

    fn rates(&mut self, t: f64, y: &SVector<f64, N>) -> Option<SVector<f64, N>> {
        (self.f)(t, y)
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &SVector<f64, N>,
        rates: &SVector<f64, N>,
    ) -> Option<SMatrix<f64, N, N>> {
        let mut jacobian = SMatrix::<f64, N, N>::zeros();
        for i in 0..N {
            let shift = 1e-7 * y[i].abs().max(1e-7);
            let mut moved = *y;
            moved[i] += shift;
            jacobian.set_column(i, &(((self.f)(t, &moved)? - rates) / shift));
        }
        Some(jacobian)
    }

    fn integrands(&mut self, _: f64, y: &SVector<f64, N>) -> SVector<f64, N> {
        *y
    }

    fn longest_step(&mut self, _: f64, _: &SVector<f64, N>, _: &SVector<f64, N>) -> f64 {
        self.longest_step
    }
}

impl<const N: usize, F> Radau<N, N, Test<N, F>>
where
    F: Fn(f64, &SVector<f64, N>) -> Option<SVector<f64, N>>,
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    /// A step of fixed length, without error control.
    fn forced_step(&mut self, model: &mut Test<N, F>, h: f64) {
        self.step = h;
        let factors = self.factors(model).unwrap();
        let Ok((z, ..)) = self.newton(model, &factors.system) else {
            panic!("no convergence");
        };
        let y = self.y + z[2];
        let rates = model.rates(self.time + h, &y).unwrap();
        self.accept(model, &z, y, rates);
        self.factors = Some(factors);
    }
}

type Solution<const N: usize, F> = (Radau<N, N, Test<N, F>>, Result<(), NoStep>);

/// Solves until `end`, or until no step is short enough.
fn solve<const N: usize, F>(
    f: F,
    start: [f64; N],
    end: f64,
    scale: [f64; N],
    longest_step: f64,
) -> Solution<N, F>
where
    F: Fn(f64, &SVector<f64, N>) -> Option<SVector<f64, N>>,
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    let mut model = Test { f, longest_step };
    let first = longest_step.min(1e-6);
    let (start, scale) = (SVector::from(start), SVector::from(scale));
    let mut radau = Radau::new(&mut model, &start, scale, first).unwrap();
    while radau.time < end {
        if let Err(no_step) = radau.advance(&mut model) {
            return (radau, Err(no_step));
        }
    }
    (radau, Ok(()))
}

/// Convergence: y'' = -y with a fixed step. Solution and integral are of order 5 at the ends of the
/// steps; the error of the dense output has the fourth power of the step.
#[test]
fn order_five_and_dense_output_of_order_three() {
    let errors = [0.4, 0.2, 0.1].map(|h: f64| {
        let oscillator = |_: f64, y: &SVector<f64, 2>| Some(SVector::from([y[1], -y[0]]));
        let mut model = Test {
            f: oscillator,
            longest_step: h,
        };
        // The error of Newton's method depends on the tolerance, and must be negligible.
        let (start, scale) = (SVector::from([1.0, 0.0]), SVector::from([1e-12; 2]));
        let mut radau = Radau::new(&mut model, &start, scale, h).unwrap();
        let (mut ends, mut between) = (0.0_f64, 0.0_f64);
        while radau.time < 3.9 {
            radau.forced_step(&mut model, h);
            let t = radau.time;
            let (y, integral) = radau.at(t);
            ends = ends
                .max((y - SVector::from([t.cos(), -t.sin()])).norm())
                .max((integral - SVector::from([t.sin(), t.cos() - 1.0])).norm());
            let t = t - 0.4 * h;
            let (y, _) = radau.at(t);
            between = between.max((y - SVector::from([t.cos(), -t.sin()])).norm());
        }
        (ends, between)
    });
    for pair in errors.windows(2) {
        let order = |of: fn(&(f64, f64)) -> f64| f64::log2(of(&pair[0]) / of(&pair[1]));
        let (ends, between) = (order(|e| e.0), order(|e| e.1));
        assert!((4.8..5.2).contains(&ends), "{ends}");
        assert!((3.7..4.3).contains(&between), "{between}");
    }
}

/// Closed form (Prothero and Robinson): y' = -1e6 (y - cos t) - sin t has the solution y = cos t. A
/// stiff solver solves it with long steps.
#[test]
fn a_stiff_pole_costs_no_steps() {
    let f = |t: f64, y: &SVector<f64, 1>| Some(SVector::from([-1e6 * (y[0] - t.cos()) - t.sin()]));
    let (radau, done) = solve(f, [1.0], 10.0, [1e-6], 1.0);
    assert_eq!(done, Ok(()));
    assert!(radau.work.steps < 100, "{:?}", radau.work);
    for i in 0..10 {
        let t = radau.time - 0.1 * f64::from(i) * (radau.time - radau.begin);
        // Between the nodes the error is that of a cubic over a second: at most 0.04/4!.
        assert!((radau.at(t).0[0] - t.cos()).abs() < 2e-3);
    }
}

/// Reference: Robertson's reaction (rates from 0.04 to 3e7) at t = 40, to ten digits as in the test
/// sets for stiff solvers.
#[test]
fn robertsons_reaction() {
    let f = |_: f64, y: &SVector<f64, 3>| {
        let (slow, fast, back) = (0.04 * y[0], 3e7 * y[1] * y[1], 1e4 * y[1] * y[2]);
        Some(SVector::from([back - slow, slow - back - fast, fast]))
    };
    let expected = SVector::from([0.715_827_068_7, 9.185_534_765e-6, 0.284_163_745_7]);
    let mut last = f64::INFINITY;
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let scale = [tolerance, 1e-5 * tolerance, tolerance];
        let (radau, done) = solve(f, [1.0, 0.0, 0.0], 40.0, scale, 1.0);
        assert_eq!(done, Ok(()));
        let error = (radau.at(40.0).0 - expected).component_div(&SVector::from([1.0, 1e-5, 1.0]));
        let error = error.norm();
        println!("{tolerance}: {error:.1e} {:?}", radau.work);
        // The errors of some tens of steps add up.
        assert!(
            error < 10.0 * tolerance && error < last,
            "{tolerance}: {error}"
        );
        last = error;
        // The sum of the concentrations is constant, also in the integrals.
        assert!((radau.at(40.0).1.sum() - 40.0).abs() < 1e-9);
    }
}

/// Property: a step into a state without rates is rejected. If no other step exists, the solver
/// stops close to this state.
#[test]
fn states_without_rates_are_avoided_or_reported() {
    // Long steps would overshoot 0, where there are no rates.
    let decay = |_: f64, y: &SVector<f64, 1>| {
        (y[0] > -1e-9).then(|| SVector::from([-1e3 * y[0].max(0.0).sqrt()]))
    };
    let (radau, done) = solve(decay, [1.0], 5e-3, [1e-2], 1.0);
    assert_eq!(done, Ok(()));
    assert!(radau.at(5e-3).0[0].abs() < 1e-2);

    let wall = |_: f64, y: &SVector<f64, 1>| (y[0] > 0.0).then(|| SVector::from([-1.0]));
    let (radau, done) = solve(wall, [1.0], 2.0, [1e-6], 0.3);
    assert_eq!(done, Err(NoStep));
    assert!((0.999..=1.0).contains(&radau.time), "{}", radau.time);
}
