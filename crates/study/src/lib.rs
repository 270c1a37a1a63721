//! Many seeds of one scene: how exact the estimators are, whether they know it, and what each step of `best` brings.
//!
//! The truth of a scene does not depend on what is random in its readings: a [`Course`] is computed once and observed anew for
//! every seed.

mod ablation;
mod consistency;
mod course;
mod floor;
mod report;
mod score;
mod statistics;
mod summary;

pub use ablation::ladder;
pub use consistency::{Consistency, Verdict};
pub use course::{Course, CourseError};
pub use floor::{ReadingErrors, floor};
pub use report::Report;
pub use score::Score;
pub use statistics::Mean;
pub use summary::Summary;

use robhaz_run::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// Observes a course once, with the scene's seed: a score for each of its estimators.
///
/// # Errors
/// [`ModelErrorTooLarge`] when the robot that this seed tells the estimators cannot be one.
pub fn observe(scene: &Scene, course: &Course) -> Result<Vec<Score>, ModelErrorTooLarge> {
    let mut observers = Observers::new(scene)?;
    let mut scores = vec![Score::default(); scene.estimators.len()];
    for (truth, counts) in course.samples() {
        let (_, estimates) = observers.observe(truth);
        if counts {
            for (score, estimate) in scores.iter_mut().zip(estimates) {
                score.add(truth, estimate.as_ref().ok());
            }
        }
    }
    Ok(scores)
}

/// Observes a course with each of `seeds`: a summary for each of the scene's estimators.
///
/// Seeds are shared out among as many threads; the result does not depend on how many. `done` is told of every seed that is
/// finished.
///
/// # Errors
/// As [`observe`], of the first seed in the list that fails.
pub fn study(
    scene: &Scene,
    course: &Course,
    seeds: &[u64],
    threads: NonZeroUsize,
    done: &mut dyn FnMut(),
) -> Result<Vec<Summary>, ModelErrorTooLarge> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut runs: Vec<_> = std::thread::scope(|scope| {
        for _ in 0..threads.get().min(seeds.len()) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                while let Some(&seed) = seeds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let scene = Scene {
                        seed,
                        ..scene.clone()
                    };
                    // The receiver outlives the threads.
                    let _ = sender.send((seed, observe(&scene, course)));
                }
            });
        }
        drop(sender);
        receiver.iter().inspect(|_| done()).collect()
    });
    runs.sort_by_key(|(seed, _)| seeds.iter().position(|s| s == seed));
    let mut summaries: Vec<Summary> = scene
        .estimators
        .iter()
        .map(|e| Summary::new(&e.name))
        .collect();
    for (_, scores) in runs {
        for (summary, score) in summaries.iter_mut().zip(scores?) {
            summary.add(score);
        }
    }
    Ok(summaries)
}
