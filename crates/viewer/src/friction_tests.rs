//! Friction tests: their results in words, and marks on the ground where they were made.

use crate::colours::WHEELS;
use crate::draw::flat;
use crate::error::Result;
use crate::series::WHEEL_NAMES;
use crate::writer::Writer;
use re_sdk_types::archetypes::Points2D;
use re_sdk_types::components::Radius;
use robhaz_control::FrictionTestResult;
use robhaz_model::Vec2;
use robhaz_run::RunEnd;
use robhaz_score::ground_origin;
use robhaz_sim::Truth;
use robhaz_terrain::Terrain;

/// Place of a test on the ground of a run with a `start`, m: the one that the robot itself states, from
/// its true start on; a robot that has not moved states none, and its wheels are at their start.
fn place(
    ground: &Terrain,
    start: &Truth,
    wheel_radius: f64,
    result: &FrictionTestResult,
) -> Option<Vec2> {
    let x = match result.place {
        Some(place) => ground_origin(start, wheel_radius).x + place,
        None => start.wheels[result.wheel].position.x,
    };
    ground.outline(x, x, 1.0).last().copied()
}

/// mu_max and its standard deviation, at its place.
fn label(result: &FrictionTestResult) -> String {
    let (mu, margin, wheel) = (result.mu, 2.0 * result.sigma, result.wheel + 1);
    format!("mu_max {mu:.2} +- {margin:.2}, wheel {wheel}")
}

/// The result in words, for the list of events.
pub(crate) fn in_words(result: &FrictionTestResult) -> String {
    let (wheel, margin) = (WHEEL_NAMES[result.wheel], 2.0 * result.sigma);
    if result.ramps > 0 {
        format!(
            "friction test of the {wheel} wheel: mu_max = {:.3} +- {margin:.3} (2 sigma)",
            result.mu
        )
    } else {
        format!(
            "friction test of the {wheel} wheel without slip ({}): mu_max is at least {:.3}",
            result.end.name(),
            (result.mu - margin).max(0.0)
        )
    }
}

/// Marks the tests that found mu_max on the ground. Each mark is visible from the time of its test on.
pub(crate) fn log(out: &mut Writer, ground: &Terrain, wheel_radius: f64, end: &RunEnd) -> Result {
    let found = end.friction_tests.iter().filter(|result| result.ramps > 0);
    let placed =
        found.filter_map(|r| Some((r, place(ground, end.start.as_ref()?, wheel_radius, r)?)));
    for (k, (result, at)) in placed.enumerate() {
        let columns = Points2D::update_fields()
            .with_positions([flat(at)])
            .with_colors([WHEELS[result.wheel]])
            .with_radii([Radius::new_ui_points(6.0)])
            .with_labels([label(result)])
            .with_show_labels(true)
            .columns_of_unit_batches();
        let entity = format!("world/friction_tests/{}", k + 1);
        out.columns(entity, &[result.time], columns)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_control::FrictionTestEnd;
    use robhaz_terrain::Profile;

    fn result(wheel: usize, place: Option<f64>, ramps: u32) -> FrictionTestResult {
        FrictionTestResult {
            wheel,
            end: if ramps > 0 {
                FrictionTestEnd::Slipped
            } else {
                FrictionTestEnd::TorqueLimit
            },
            time: 2.0,
            place,
            mu: 0.712,
            sigma: 0.01,
            systematic: 0.0,
            ramps,
            limits: [None, None],
            slipped_distance: 0.01,
            slip_noise: 0.0,
            duration: 3.0,
        }
    }

    /// By hand: a place counts from the true start of the robot on; a wheel that has not moved is
    /// at its own start; a test without slip has a bound in words.
    #[test]
    fn results_are_at_their_places() {
        let mut start = Truth::default();
        for (wheel, x) in start.wheels.iter_mut().zip([1.3, 1.0, 0.7]) {
            wheel.position.x = x;
        }
        let ground = Terrain::new(Profile::Flat);
        let results = [
            result(0, Some(0.5), 1),
            result(2, None, 2),
            result(1, None, 0),
        ];
        let at = [0, 1].map(|k| place(&ground, &start, 0.1, &results[k]));
        assert_eq!(at, [1.5, 0.7].map(|x| Some(Vec2::new(x, 0.0))));
        assert_eq!(label(&results[0]), "mu_max 0.71 +- 0.02, wheel 1");
        let words = results.each_ref().map(in_words);
        assert_eq!(
            words[0],
            "friction test of the front wheel: mu_max = 0.712 +- 0.020 (2 sigma)"
        );
        assert_eq!(
            words[2],
            "friction test of the middle wheel without slip (torque limit): mu_max is at least 0.692"
        );
    }
}
