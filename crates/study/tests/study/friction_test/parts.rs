//! What makes up the error of mu_max of a single ramp: true values put in for estimated ones, one
//! at a time.

use super::{FIRST_SEED, GROUNDS, LAWS, MU, Outcome, scene};
use rayon::prelude::*;
use robhaz_estimator::Estimate;
use robhaz_model::WheelCommand;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_sim::Truth;
use std::collections::VecDeque;

/// Parts of the error of one event over mu_s, %.
#[derive(Clone, Copy)]
struct Parts {
    /// Estimated mu_max.
    all: f64,
    /// True T and N at that time: lag of the filters, and the plant's own T/N.
    time: f64,
    /// True N, and T with the mean error of the three tractions: slope.
    common: f64,
    /// True N, and T with its own error beside that mean: torque offsets and gains.
    own: f64,
    /// True T, estimated N.
    load: f64,
}

/// T and N of the wheels, true and estimated, at one time.
struct Instant {
    time: f64,
    traction: [f64; 3],
    load: [f64; 3],
    found_traction: [f64; 3],
    found_load: [f64; 3],
}

impl Instant {
    fn new(truth: &Truth, estimate: &Estimate) -> Self {
        let wheels = &truth.wheels;
        let needed = |i: usize| {
            let friction = estimate.kalman.as_ref().map(|k| &k.friction);
            friction.and_then(|wheels| wheels[i].needed)
        };
        // Traction as the needed friction has it, with what the memory of the ground knows of the
        // slope.
        let traction =
            |i: usize| needed(i).map_or(f64::NAN, |n| n.value * estimate.normal_force[i]);
        Self {
            time: truth.time,
            traction: [0, 1, 2].map(|i| wheels[i].traction),
            load: [0, 1, 2].map(|i| wheels[i].normal_force),
            found_traction: [0, 1, 2].map(traction),
            found_load: estimate.normal_force,
        }
    }

    fn parts(&self, i: usize, found: f64, mu: f64) -> Parts {
        let errors = [0, 1, 2].map(|k| self.found_traction[k] - self.traction[k]);
        let mean = errors.iter().sum::<f64>() / 3.0;
        let sign = self.traction[i].signum();
        let percent = 100.0 * sign / mu;
        let (t, n) = (self.traction[i], self.load[i]);
        Parts {
            all: 100.0 * (found / mu - 1.0),
            time: percent * t / n - 100.0,
            common: percent * mean / n,
            own: percent * (errors[i] - mean) / n,
            load: percent * (t / self.found_load[i] - t / n),
        }
    }
}

#[derive(Default)]
struct Ramps {
    mu: f64,
    /// The last second.
    history: VecDeque<Instant>,
    found: Vec<Parts>,
}

impl Sink for Ramps {
    fn begin(&mut self, _: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let (Some(truth), Some(commands), Some(Ok(estimate))) =
            (frame.truth, frame.commands, frame.estimates.first())
        else {
            return Ok(());
        };
        self.history.push_back(Instant::new(truth, estimate));
        let old = |instant: &Instant| instant.time < truth.time - 1.0;
        while self.history.front().is_some_and(old) {
            self.history.pop_front();
        }
        for (i, command) in commands.iter().enumerate() {
            let event = estimate.kalman.and_then(|k| k.friction[i].slip_event);
            let Some(event) = event.filter(|_| matches!(command, WheelCommand::Torque(_))) else {
                continue;
            };
            let at = truth.time - event.age - 1e-9;
            let instant = self.history.iter().find(|instant| instant.time >= at);
            let parts = instant.map(|instant| instant.parts(i, event.mu_max, self.mu));
            self.found.extend(parts);
        }
        Ok(())
    }

    fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

fn parts(law: &str, mu: f64, ground: &[&str], seeds: u64) -> Outcome<Vec<Parts>> {
    let runs: Outcome<Vec<Vec<Parts>>> = (FIRST_SEED..FIRST_SEED + seeds)
        .into_par_iter()
        .map(|seed| {
            let mut ramps = Ramps {
                mu,
                ..Ramps::default()
            };
            robhaz_run::run(&scene(law, mu, ground, seed)?, &mut [&mut ramps])?;
            Ok(ramps.found)
        })
        .collect();
    Ok(runs?.concat())
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_parts() -> Outcome<()> {
    let seeds = std::env::var("ROBHAZ_SEEDS").unwrap_or_default();
    let seeds = seeds.parse().unwrap_or(5);
    println!("| case | ramps | all, % | time | slope | own T | N |");
    println!("|---|---|---|---|---|---|---|");
    let (ground, overrides) = GROUNDS[1];
    for law in LAWS {
        for mu in MU {
            let found = parts(law, mu, overrides, seeds)?;
            let rms = |part: fn(&Parts) -> f64| {
                let squares = found.iter().map(|parts| part(parts) * part(parts));
                (squares.sum::<f64>() / found.len() as f64).sqrt()
            };
            println!(
                "| {ground}, {law}, {mu} | {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
                found.len(),
                rms(|p| p.all),
                rms(|p| p.time),
                rms(|p| p.common),
                rms(|p| p.own),
                rms(|p| p.load)
            );
        }
    }
    Ok(())
}
