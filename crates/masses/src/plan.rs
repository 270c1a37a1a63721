//! The most informative postures: optimal design over blocks.
//!
//! The criterion is the mean variance of the normal forces over the postures of a drive, after
//! weighing (I-optimal design; Atkinson, Donev, Tobias, "Optimum Experimental Designs, with SAS",
//! 2007, ch. 10). Postures are chosen one after the other, then exchanged until no exchange helps.

use crate::blocks::{Blocks, posture_on};
use crate::error::{Result, WeighError};
use crate::fit::{Information, Normal, of_robot};
use crate::loads::{forces_by_unknowns, mean_variance};
use crate::measurements::Accuracy;
use crate::parameters::Tolerances;
use crate::prior::{Prior, Unknowns};
use robhaz_model::Robot;

/// Postures for a weighing.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// In the order in which they help most.
    pub postures: Vec<PlannedPosture>,
    /// Number of postures on blocks that were compared.
    pub candidates: usize,
    /// Standard deviation of a normal force without weighing, N: RMS over wheels and the postures
    /// of a drive.
    pub before: f64,
}

/// One posture of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedPosture {
    /// Heights under the wheels, m.
    pub blocks: Blocks,
    /// Inclinations of links 1 and 2 nominal, rad.
    pub angles: [f64; 2],
    /// Forces of the wheels nominal, N.
    pub forces: [f64; 3],
    /// Standard deviation of a normal force after weighing in this and all earlier postures, N.
    pub after: f64,
}

/// A posture, and the information of its readings.
type Candidate = (PlannedPosture, Information);

/// The `count` most informative postures, with scales under all wheels and blocks of the heights
/// `heights` (m) or none under each wheel.
///
/// # Errors
/// [`WeighError`]
pub fn plan(
    nominal: &Robot,
    tolerances: &Tolerances,
    accuracy: &Accuracy,
    heights: &[f64],
    count: usize,
) -> Result<Plan> {
    if let Some(height) = heights.iter().find(|h| !(**h > 0.0 && **h <= 1.0)) {
        return Err(WeighError::new(format!(
            "a block's height is {height} m; allowed: above 0 and at most 1 m"
        )));
    }
    let prior = Prior::new(nominal, tolerances, accuracy)?;
    let candidates = candidates(&prior, heights)?;
    if candidates.len() < count {
        return Err(WeighError::new(format!(
            "{} postures are possible with these blocks, fewer than {count}; allowed: more or other heights",
            candidates.len()
        )));
    }
    let forces = forces_by_unknowns(&prior, nominal).map_err(WeighError::of_nominal)?;
    let variance = |chosen: &[usize]| {
        let add = |sum: Information, i: &usize| sum + candidates[*i].1;
        let information = chosen.iter().fold(Information::identity(), add);
        // The prior keeps it regular.
        let factor = information.cholesky();
        factor.map_or(f64::INFINITY, |c| {
            mean_variance(&forces, &of_robot(&c.inverse()))
        })
    };
    let chosen = choose(candidates.len(), count, &variance);
    let posture = |k: usize| PlannedPosture {
        after: variance(&chosen[..=k]).sqrt(),
        ..candidates[chosen[k]].0
    };
    Ok(Plan {
        postures: (0..chosen.len()).map(posture).collect(),
        candidates: candidates.len(),
        before: variance(&[]).sqrt(),
    })
}

/// Every posture on blocks that the robot can take.
fn candidates(prior: &Prior<'_>, heights: &[f64]) -> Result<Vec<Candidate>> {
    let all = [&[0.0], heights].concat();
    let count = all.len();
    let mut found: Vec<Candidate> = Vec::new();
    for k in 0..count.pow(3) {
        let blocks = [k / (count * count), k / count, k].map(|k| all[k % count]);
        // Higher blocks under all wheels are the same posture.
        if blocks.iter().all(|h| *h > 0.0) {
            continue;
        }
        let Ok(angles) = posture_on(prior.nominal, &blocks) else {
            continue;
        };
        let Ok(predicted) = prior.predict(&Unknowns::zeros(), angles) else {
            continue;
        };
        let mut normal = Normal::prior(&Unknowns::zeros());
        let forces: [f64; 3] = predicted.forces.into();
        let added = normal.add(&predicted, &forces.map(Some));
        added.ok_or_else(WeighError::not_converged)?;
        let planned = PlannedPosture {
            blocks,
            angles,
            forces,
            after: f64::NAN,
        };
        found.push((planned, normal.information - Information::identity()));
    }
    Ok(found)
}

/// Indices of `count` of `all` with the least value of `of`, nearly, the most telling first:
/// greedy, then exchanges; each at most once.
fn choose(all: usize, count: usize, of: &impl Fn(&[usize]) -> f64) -> Vec<usize> {
    let mut chosen = in_order(0..all, count, of);
    loop {
        let before = of(&chosen);
        for place in 0..chosen.len() {
            let with = |i: usize| {
                let mut tried = chosen.clone();
                tried[place] = i;
                of(&tried)
            };
            let own = chosen[place];
            let is_free = |i: &usize| *i == own || !chosen.contains(i);
            if let Some(best) = least((0..all).filter(is_free), with) {
                chosen[place] = best;
            }
        }
        // Only a real gain goes on, so that it ends.
        if of(&chosen) > before * (1.0 - 1e-6) {
            break;
        }
    }
    in_order(chosen.iter().copied(), count, of)
}

/// `count` of these, one after the other: each adds most information to those before it.
fn in_order(
    from: impl Iterator<Item = usize> + Clone,
    count: usize,
    of: &impl Fn(&[usize]) -> f64,
) -> Vec<usize> {
    let mut ordered = Vec::with_capacity(count);
    for _ in 0..count {
        let left = from.clone().filter(|i| !ordered.contains(i));
        let next = least(left, |i| of(&[ordered.as_slice(), &[i]].concat()));
        ordered.extend(next);
    }
    ordered
}

/// The one with the least value, the first of equal ones.
fn least(of: impl Iterator<Item = usize>, value: impl Fn(usize) -> f64) -> Option<usize> {
    let valued = of.map(|i| (i, value(i)));
    let (i, _) = valued.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(i)
}
