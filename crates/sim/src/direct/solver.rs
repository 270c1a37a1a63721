//! The stiff solver, taken step by step, with its dense output.

use super::equations::{Equations, OMEGA, SIZE, Y};
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ImplicitRungeKutta;
use differential_equations::ode::OrdinaryNumericalMethod;

/// Local errors allowed in a step, per unit of tolerance: positions (m, rad), velocities (m/s, rad/s), wheel speeds
/// (rad/s), integrals (rad). A penetration off by 10 nm is 2 mN of N.
const WEIGHTS: [f64; SIZE] = [
    1e-3, 1e-3, 1e-2, 1e-2, // Q, theta
    1e-1, 1e-1, 1e-1, 1e-1, // their rates
    1e-1, 1e-1, 1e-1, // omega
    1e-1, 1e-1, 1e-1, // integrals
];
/// First step, s: below the fast pole of a bare wheel on the ground (75 us).
const FIRST_STEP: f64 = 1e-5;
/// Longest step, s: 20 mm of ground at the paper's speed.
const LONGEST_STEP: f64 = 0.1;
/// Rejections in a row after which a run is given up: the step is then 1e-12 of what it was.
const MAX_REJECTIONS: u32 = 40;

/// The library's solver type has no public name: this is what we need of it.
trait Stepper {
    /// One attempt at a step.
    fn step(&mut self, equations: &Equations) -> bool;
    fn time(&self) -> f64;
    fn interpolate(&mut self, time: f64) -> Option<Y>;
}

impl<S> Stepper for S
where
    S: OrdinaryNumericalMethod<f64, Y> + Interpolation<f64, Y>,
{
    fn step(&mut self, equations: &Equations) -> bool {
        OrdinaryNumericalMethod::step(self, equations).is_ok()
    }

    fn time(&self) -> f64 {
        self.t()
    }

    fn interpolate(&mut self, time: f64) -> Option<Y> {
        Interpolation::interpolate(self, time).ok()
    }
}

/// Radau IIA of order 5 on the equations of motion, from time 0.
pub(super) struct Solver {
    stepper: Box<dyn Stepper>,
    start: Y,
    steps: u64,
    /// Where the last step began, s, and the wheel spins there and at its end, rad.
    last_step: (f64, [f64; 3], [f64; 3]),
}

fn stepper(equations: &Equations, start: &Y, tolerance: f64) -> Box<dyn Stepper> {
    // The library scales tolerances as Hairer's code does, rtol' = 0.1 rtol^(2/3) and atol' = atol rtol'/rtol. Errors
    // here are absolute: x grows, but its accuracy must not depend on it.
    let relative = 1e-14_f64;
    let scaled = 0.1 * relative.powf(2.0 / 3.0);
    let absolute = WEIGHTS.map(|w| w * tolerance * relative / scaled);
    let mut method = ImplicitRungeKutta::radau5()
        .rtol(vec![relative; SIZE])
        .atol(absolute.to_vec())
        .h0(FIRST_STEP)
        .h_max(LONGEST_STEP)
        .max_steps(usize::MAX);
    // Settings are ours and valid; a failure would show as a first step that cannot be taken.
    let _ = OrdinaryNumericalMethod::init(&mut method, equations, 0.0, f64::MAX, start);
    Box::new(method)
}

impl Solver {
    pub fn new(equations: &Equations, start: &Y, tolerance: f64) -> Self {
        Self {
            stepper: stepper(equations, start, tolerance),
            start: *start,
            steps: 0,
            last_step: (0.0, [0.0; 3], [0.0; 3]),
        }
    }

    /// Mean length of the steps so far, s.
    pub fn mean_step(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let steps = self.steps.max(1) as f64;
        self.stepper.time() / steps
    }

    /// State and wheel spins (rad) at `time` (s), which must not decrease from call to call. The error is the time where the
    /// solver got stuck.
    pub fn at(&mut self, time: f64, equations: &Equations) -> Result<(Y, [f64; 3]), f64> {
        if time <= 0.0 {
            return Ok((self.start, [0.0; 3]));
        }
        let mut rejections = 0;
        while self.stepper.time() < time {
            let before = self.stepper.time();
            let taken = self.stepper.step(equations) && self.stepper.time() > before;
            if taken {
                rejections = 0;
                equations.clear_refusal();
                self.steps += 1;
                let spins = self.last_step.2;
                self.last_step = (before, spins, spins);
                self.last_step.2 = self.spins(self.stepper.time()).ok_or(before)?;
            } else {
                rejections += 1;
                if rejections > MAX_REJECTIONS {
                    return Err(before);
                }
            }
        }
        let y = self.stepper.interpolate(time).ok_or(time)?;
        Ok((y, self.spins(time).ok_or(time)?))
    }

    /// Wheel spins at a time within the last step, rad: Simpson's rule on the speeds, exact for the cubic dense output.
    fn spins(&mut self, time: f64) -> Option<[f64; 3]> {
        let (begin, spins, _) = self.last_step;
        let a = self.stepper.interpolate(begin)?;
        let m = self.stepper.interpolate(0.5 * (begin + time))?;
        let b = self.stepper.interpolate(time)?;
        let sixth = (time - begin) / 6.0;
        Some([0, 1, 2].map(|i| {
            let j = OMEGA + i;
            spins[i] + sixth * (a[j] + 4.0 * m[j] + b[j])
        }))
    }
}
