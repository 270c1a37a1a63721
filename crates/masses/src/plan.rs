//! The postures that tell most: optimal design over blocks.
//!
//! The criterion is the mean variance of the normal forces over the postures of a drive, after weighing (I-optimal design;
//! Atkinson, Donev, Tobias, "Optimum Experimental Designs, with SAS", 2007, ch. 10). Postures are chosen one after the other,
//! then exchanged until no exchange helps.

use crate::blocks::{Blocks, posture_on};
use crate::error::WeighError;
use crate::fit::{Information, Normal};
use crate::loads::{forces_by_unknowns, mean_variance};
use crate::measurements::Accuracy;
use crate::parameters::{PARAMETERS, Tolerances};
use crate::prior::{Predicted, Prior, Unknowns};
use nalgebra::SMatrix;
use robhaz_model::Robot;

/// Postures for a weighing.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// In the order in which they help most.
    pub postures: Vec<PlannedPosture>,
    /// Number of postures on blocks that were compared.
    pub candidates: usize,
    /// Standard deviation of a normal force without weighing, N: RMS over wheels and the postures of a drive.
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

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Too few postures.
    #[error(
        "{found} postures are possible with these blocks, fewer than {asked}; allowed: more or other heights"
    )]
    TooFew {
        /// Possible postures.
        found: usize,
        /// Postures asked for.
        asked: usize,
    },
    /// A height is not possible.
    #[error("a block's height is {0} m; allowed: above 0 and at most 1 m")]
    Height(f64),
    /// The rest.
    #[error(transparent)]
    Weigh(#[from] WeighError),
}

struct Candidate {
    planned: PlannedPosture,
    information: Information,
}

/// The `count` postures that tell most, with scales under all wheels and blocks of the heights `heights` (m) or none under
/// each wheel.
///
/// # Errors
/// [`PlanError`]
pub fn plan(
    nominal: &Robot,
    tolerances: &Tolerances,
    accuracy: &Accuracy,
    heights: &[f64],
    count: usize,
) -> Result<Plan, PlanError> {
    if let Some(height) = heights.iter().find(|h| !(**h > 0.0 && **h <= 1.0)) {
        return Err(PlanError::Height(*height));
    }
    let prior = Prior::new(nominal, tolerances, accuracy)?;
    let candidates = candidates(&prior, heights)?;
    if candidates.len() < count {
        let (found, asked) = (candidates.len(), count);
        return Err(PlanError::TooFew { found, asked });
    }
    let forces = forces_by_unknowns(&prior, nominal).map_err(WeighError::Statics)?;
    let variance = |chosen: &[usize]| {
        let mut information = Information::identity();
        for i in chosen {
            information += candidates[*i].information;
        }
        // The prior keeps it regular.
        information.cholesky().map_or(f64::INFINITY, |c| {
            let covariance = c.inverse();
            let part: SMatrix<f64, PARAMETERS, PARAMETERS> =
                covariance.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into();
            mean_variance(&forces, &part)
        })
    };
    let chosen = choose(candidates.len(), count, &variance);
    let mut postures = Vec::with_capacity(count);
    for (k, i) in chosen.iter().enumerate() {
        postures.push(PlannedPosture {
            after: variance(&chosen[..=k]).sqrt(),
            ..candidates[*i].planned
        });
    }
    Ok(Plan {
        postures,
        candidates: candidates.len(),
        before: variance(&[]).sqrt(),
    })
}

/// Every posture on blocks that the robot can take.
fn candidates(prior: &Prior<'_>, heights: &[f64]) -> Result<Vec<Candidate>, PlanError> {
    let mut all = vec![0.0];
    all.extend_from_slice(heights);
    let mut found: Vec<Candidate> = Vec::new();
    for front in &all {
        for middle in &all {
            for rear in &all {
                let blocks = [*front, *middle, *rear];
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
                found.push(candidate(blocks, angles, &predicted)?);
            }
        }
    }
    Ok(found)
}

fn candidate(
    blocks: Blocks,
    angles: [f64; 2],
    predicted: &Predicted,
) -> Result<Candidate, PlanError> {
    let mut normal = Normal::prior(&Unknowns::zeros());
    let forces: [f64; 3] = predicted.forces.into();
    normal
        .add(predicted, &forces.map(Some))
        .ok_or(WeighError::NotConverged)?;
    Ok(Candidate {
        planned: PlannedPosture {
            blocks,
            angles,
            forces,
            after: f64::NAN,
        },
        information: normal.information - Information::identity(),
    })
}

/// Indices of `count` of `all` with the least value of `of`, nearly: greedy, then exchanges; each at most once.
fn choose(all: usize, count: usize, of: &impl Fn(&[usize]) -> f64) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::with_capacity(count);
    let best_at = |chosen: &[usize], place: usize| {
        let mut best: Option<(usize, f64)> = None;
        for i in 0..all {
            let is_other = chosen
                .iter()
                .enumerate()
                .any(|(k, c)| k != place && *c == i);
            if is_other {
                continue;
            }
            let mut tried = chosen.to_vec();
            match tried.get_mut(place) {
                Some(there) => *there = i,
                None => tried.push(i),
            }
            let value = of(&tried);
            if best.is_none_or(|(_, least)| value < least) {
                best = Some((i, value));
            }
        }
        best
    };
    for place in 0..count {
        if let Some((i, _)) = best_at(&chosen, place) {
            chosen.push(i);
        }
    }
    loop {
        let before = of(&chosen);
        for place in 0..chosen.len() {
            if let Some((i, _)) = best_at(&chosen, place) {
                chosen[place] = i;
            }
        }
        // Only a real gain goes on, so that it ends.
        if of(&chosen) > before * (1.0 - 1e-6) {
            break;
        }
    }
    in_order(&chosen, of)
}

/// The same postures, the most telling first.
fn in_order(chosen: &[usize], of: &impl Fn(&[usize]) -> f64) -> Vec<usize> {
    let mut ordered: Vec<usize> = Vec::with_capacity(chosen.len());
    while ordered.len() < chosen.len() {
        let mut best: Option<(usize, f64)> = None;
        for i in chosen.iter().filter(|i| !ordered.contains(i)) {
            let value = of(&[ordered.as_slice(), &[*i]].concat());
            if best.is_none_or(|(_, least)| value < least) {
                best = Some((*i, value));
            }
        }
        match best {
            Some((i, _)) => ordered.push(i),
            None => break,
        }
    }
    ordered
}
