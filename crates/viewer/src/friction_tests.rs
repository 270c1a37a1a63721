//! Friction tests: their results in words, and marks on the ground where they were made.

use crate::ViewerError;
use crate::colours::WHEELS;
use crate::draw::flat;
use crate::series::WHEEL_NAMES;
use crate::writer::Writer;
use re_sdk_types::archetypes::Points2D;
use re_sdk_types::components::Radius;
use robhaz_control::FrictionTestResult;
use robhaz_model::Vec2;
use robhaz_run::RunDescription;
use robhaz_score::ground_origin;
use robhaz_sim::Truth;
use robhaz_terrain::Terrain;

/// A result at its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TestMark {
    /// Time of the largest T/N, s.
    time: f64,
    /// The tested wheel, 0 to 2.
    wheel: usize,
    /// Place on the ground, m.
    at: Vec2,
    /// mu_max and its standard deviation.
    label: String,
}

/// Where the robot starts.
struct Start {
    /// x of the origin of the estimators' ground, m.
    origin: f64,
    /// x of the wheels' centres, m.
    wheels: [f64; 3],
}

/// Puts the results of a simulated run on its ground.
pub(crate) struct TestPlaces {
    wheel_radius: f64,
    /// `None` for recorded readings: they have no world to draw in.
    terrain: Option<Terrain>,
    start: Option<Start>,
}

impl TestPlaces {
    /// Before the first record of a run.
    pub(crate) fn new(run: &RunDescription) -> Self {
        let world = run.world.as_ref().filter(|_| run.takes_commands());
        Self {
            wheel_radius: run.robot.robot.geometry.wheel_radius,
            terrain: world.map(|w| w.terrain.build(&run.robot.robot)),
            start: None,
        }
    }

    /// Keeps the start: the first truth.
    pub(crate) fn sample(&mut self, truth: &Truth) {
        if self.start.is_none() {
            self.start = Some(Start {
                origin: ground_origin(truth, self.wheel_radius).x,
                wheels: truth.wheels.map(|w| w.position.x),
            });
        }
    }

    /// Marks of the tests that found mu_max. A place is the one that the robot itself states, from
    /// its true start on; a robot that has not moved states none, and its wheels are at their
    /// start.
    pub(crate) fn marks(&self, results: &[FrictionTestResult]) -> Vec<TestMark> {
        let (Some(terrain), Some(start)) = (&self.terrain, &self.start) else {
            return Vec::new();
        };
        let found = results.iter().filter(|result| result.ramps > 0);
        found
            .filter_map(|result| {
                let along = result.place.map(|place| start.origin + place);
                let x = along.unwrap_or(start.wheels[result.wheel]);
                Some(TestMark {
                    time: result.time,
                    wheel: result.wheel,
                    at: *terrain.outline(x, x, 1.0).last()?,
                    label: format!(
                        "mu_max {:.2} +- {:.2}, wheel {}",
                        result.mu,
                        2.0 * result.sigma,
                        result.wheel + 1
                    ),
                })
            })
            .collect()
    }
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

/// Logs marks. Each is visible from the time of its test on.
pub(crate) fn log(out: &mut Writer, marks: &[TestMark]) -> Result<(), ViewerError> {
    for (k, mark) in marks.iter().enumerate() {
        let columns = Points2D::update_fields()
            .with_positions([flat(mark.at)])
            .with_colors([WHEELS[mark.wheel]])
            .with_radii([Radius::new_ui_points(6.0)])
            .with_labels([mark.label.as_str()])
            .with_show_labels(true);
        out.columns(
            format!("world/friction_tests/{}", k + 1),
            &[mark.time],
            columns.columns_of_unit_batches(),
        )?;
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
    /// at its own start; a test without slip has no mark, and a bound in words.
    #[test]
    fn results_are_at_their_places() {
        let places = TestPlaces {
            wheel_radius: 0.1,
            terrain: Some(Terrain::new(Profile::Flat)),
            start: Some(Start {
                origin: 1.0,
                wheels: [1.3, 1.0, 0.7],
            }),
        };
        let results = [
            result(0, Some(0.5), 1),
            result(2, None, 2),
            result(1, None, 0),
        ];
        let marks = places.marks(&results);
        let found: Vec<_> = marks.iter().map(|m| (m.at, m.label.as_str())).collect();
        let expected = [
            (Vec2::new(1.5, 0.0), "mu_max 0.71 +- 0.02, wheel 1"),
            (Vec2::new(0.7, 0.0), "mu_max 0.71 +- 0.02, wheel 3"),
        ];
        assert_eq!(found, expected);
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
