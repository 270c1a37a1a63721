//! The stiff solver, taken step by step, with its dense output.

use super::equations::{Equations, Y};
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ImplicitRungeKutta;
use differential_equations::ode::OrdinaryNumericalMethod;

/// Local errors allowed in a step, per unit of tolerance: positions (m, rad), velocities (m/s, rad/s), wheel speeds
/// (rad/s), integrals and spins (rad). A penetration off by 10 nm is 2 mN of N; a spin only counts.
const WEIGHTS: [f64; 17] = [
    1e-3, 1e-3, 1e-2, 1e-2, // Q, theta
    1e-1, 1e-1, 1e-1, 1e-1, // their rates
    1e-1, 1e-1, 1e-1, // omega
    1e-1, 1e-1, 1e-1, // integrals
    1.0, 1.0, 1.0, // spins
];
/// First step, s: below the fast pole of a bare wheel on the ground (75 us).
const FIRST_STEP: f64 = 1e-5;
/// Longest step, s: no bump of the ground or ramp of the drive slips through.
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
}

fn stepper(equations: &Equations, start: &Y, tolerance: f64) -> Box<dyn Stepper> {
    // The library scales tolerances as Hairer's code does, rtol' = 0.1 rtol^(2/3) and atol' = atol rtol'/rtol. Errors
    // here are absolute: x grows, but its accuracy must not depend on it.
    let relative = 1e-14_f64;
    let scaled = 0.1 * relative.powf(2.0 / 3.0);
    let absolute = WEIGHTS.map(|w| w * tolerance * relative / scaled);
    let mut method = ImplicitRungeKutta::radau5()
        .rtol(vec![relative; 17])
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
        }
    }

    /// Mean length of the steps so far, s.
    pub fn mean_step(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let steps = self.steps.max(1) as f64;
        self.stepper.time() / steps
    }

    /// The state at `time` (s), which must not decrease from call to call. The error is the time where the solver got stuck.
    pub fn at(&mut self, time: f64, equations: &Equations) -> Result<Y, f64> {
        if time <= 0.0 {
            return Ok(self.start);
        }
        let mut rejections = 0;
        while self.stepper.time() < time {
            let before = self.stepper.time();
            let taken = self.stepper.step(equations) && self.stepper.time() > before;
            if taken {
                rejections = 0;
                self.steps += 1;
            } else {
                rejections += 1;
                if rejections > MAX_REJECTIONS {
                    return Err(before);
                }
            }
        }
        self.stepper.interpolate(time).ok_or(time)
    }
}
