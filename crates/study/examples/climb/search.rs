//! Differential evolution over the designs.

use crate::Outcome;
use crate::design::{VARIABLES, geometry, violation};
use crate::trial::{Control, End, Trial};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, De, DeMutation,
    Executor, PopulationProgress,
};
use robhaz_model::Geometry;
use robhaz_sim::random::Stream;
use std::cell::Cell;
use std::convert::Infallible;

/// Size of a search.
pub struct Plan {
    pub seed: u32,
    pub population: u32,
    pub generations: u32,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            seed: 1,
            population: 40,
            generations: 60,
        }
    }
}

/// The ladder of trials, from easy to hard: control, mu, riser (m), tread (m).
#[rustfmt::skip]
const LADDER: [(Control, f64, f64, f64); 22] = [
    (Control::Pi,   1.00, 0.08, 0.30),
    (Control::Pi,   0.80, 0.08, 0.30),
    (Control::Soft, 0.80, 0.08, 0.30),
    (Control::Pi,   0.80, 0.08, 0.32),
    (Control::Pi,   0.70, 0.08, 0.30),
    (Control::Soft, 0.70, 0.08, 0.30),
    (Control::Pi,   0.65, 0.08, 0.28),
    (Control::Pi,   0.60, 0.08, 0.30),
    (Control::Soft, 0.60, 0.08, 0.30),
    (Control::Pi,   0.80, 0.10, 0.30),
    (Control::Pi,   0.55, 0.08, 0.30),
    (Control::Soft, 0.55, 0.08, 0.30),
    (Control::Pi,   0.50, 0.08, 0.30),
    (Control::Soft, 0.50, 0.08, 0.30),
    (Control::Pi,   0.50, 0.08, 0.32),
    (Control::Pi,   0.45, 0.08, 0.30),
    (Control::Soft, 0.45, 0.08, 0.30),
    (Control::Pi,   0.80, 0.12, 0.30),
    (Control::Pi,   0.40, 0.08, 0.30),
    (Control::Soft, 0.40, 0.08, 0.30),
    (Control::Pi,   0.35, 0.08, 0.30),
    (Control::Pi,   0.30, 0.08, 0.30),
];

/// Cost of a design that breaks a constraint, before its violation: worse than every design that meets all of them.
const FORBIDDEN: f64 = 1.0;
/// Draws for the first generation.
const MOST_DRAWS: u32 = 10_000_000;

/// The problem that the optimiser sees.
struct Climbing {
    lower: Vec<f64>,
    upper: Vec<f64>,
    evaluations: Cell<u32>,
    best: Cell<f64>,
}

impl Constraints for Climbing {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        let bounds = BoxBounds::new(Some(&self.lower), Some(&self.upper));
        ConstraintSet::new().with_bounds(bounds)
    }
}

impl CostFunction for Climbing {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Infallible> {
        let cost = cost(x);
        self.evaluations.set(self.evaluations.get() + 1);
        if cost < self.best.get() {
            self.best.set(cost);
            let millimetres: Vec<f64> = x.iter().map(|v| (1e3 * v).round()).collect();
            println!("{}: {cost:.3} {millimetres:?}", self.evaluations.get());
        }
        Ok(cost)
    }
}

/// Minus the number of rungs of the ladder that a design climbs, with the share of the first one that it does not.
fn cost(x: &[f64]) -> f64 {
    let geometry = geometry(x);
    let violation = violation(&geometry);
    if violation > 0.0 {
        return FORBIDDEN + violation;
    }
    let mut climbed = 0.0;
    for (control, mu, rise, run) in LADDER {
        let trial = Trial {
            control,
            mu,
            rise,
            run,
        };
        // A robot that cannot start has done nothing of the way.
        let Ok(drove) = trial.drive(&geometry) else {
            break;
        };
        if drove.end != End::Passed {
            climbed += drove.share.min(0.999);
            break;
        }
        climbed += 1.0;
    }
    -climbed
}

/// Designs that meet all constraints, drawn uniformly: the first generation. Of uniform draws 0.6 % do.
fn allowed(plan: &Plan) -> Outcome<Vec<Vec<f64>>> {
    let mut stream = Stream::new(u64::from(plan.seed), "climb");
    let mut draw = || {
        let one = |(_, low, high): &(&str, f64, f64)| low + (high - low) * stream.uniform();
        VARIABLES.iter().map(one).collect::<Vec<f64>>()
    };
    let draws = (0..MOST_DRAWS).map(|_| draw());
    let found: Vec<_> = draws
        .filter(|x| violation(&geometry(x)) <= 0.0)
        .take(plan.population as usize)
        .collect();
    match found.len() == plan.population as usize {
        true => Ok(found),
        false => Err("too few designs meet all constraints".into()),
    }
}

/// The best geometry of a search.
pub fn search(plan: &Plan) -> Outcome<Geometry> {
    let problem = Climbing {
        lower: VARIABLES.iter().map(|v| v.1).collect(),
        upper: VARIABLES.iter().map(|v| v.2).collect(),
        evaluations: Cell::new(0),
        best: Cell::new(f64::INFINITY),
    };
    let solver = De::new(u64::from(plan.seed))
        .with_pop_size(plan.population as usize)
        .with_mutation(DeMutation::RandToBest1)
        .with_dither(0.4, 0.9);
    let start = PopulationProgress::from_population(allowed(plan)?);
    let result = Executor::new(problem, solver, start)
        .max_iter(u64::from(plan.generations))
        .run()?;
    println!(
        "{} designs; the best one climbs {:.2} of {} rungs",
        result.cost_evals(),
        -result.best_cost(),
        LADDER.len()
    );
    Ok(geometry(result.best_param()))
}
