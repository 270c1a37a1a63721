//! Measurements of both sides' filters: what the body between them and the nine rows ask for.

use super::WholeEstimator;
use crate::estimator::{Estimator, SideStep};
use crate::filters::GaussMarkov;
use crate::filters::motion::{JointMeasurement, MotionFilter, TURN_TIME};
use crate::settings::NoiseBudget;
use crate::state::{INPUTS, VELOCITY};
use crate::whole::WholeError;
use crate::whole::readings::bogie_of;
use robhaz_model::{Vec2, perp};

/// Correlation time of what the rows do not know, s: axial forces last for some tenths of a metre of
/// ground.
/// Chosen; insensitive.
const ROWS_LAST: f64 = 2.0;

impl WholeEstimator {
    /// Corrects both sides' filters by the body that they are on: the left Q moves up faster than the right
    /// one by what the body rolls, and the links that carry them turn. `budget`: in the units of the filters.
    pub(super) fn impose_body(&mut self, steps: &mut [SideStep; 2], budget: &NoiseBudget) {
        let rover = &self.rover;
        let bogie = bogie_of(&rover.side.geometry);
        let between = 2.0 * rover.link_places[bogie];
        let q = rover.side.geometry.pins.q - rover.pivot;
        let carriers = steps.each_ref().map(|step| step.state.links[1 - bogie]);
        let [left, right] = carriers.map(|[angle, rate, _]| {
            let (s, c) = libm::sincos(angle);
            let arm = Vec2::new(c * q.x - s * q.y, s * q.x + c * q.y);
            perp(arm).y * rate
        });
        let (speed, dt) = (self.units.speed(), steps[0].dt);
        let up = libm::cos(0.5 * (carriers[0][0] + carriers[1][0])) * between / self.units.time;
        let asked = left - right + self.roll.rate * up;
        let [a, b] = steps.each_ref().map(|step| step.state.velocity.y);
        // Of the body's gyroscope, and of the coupling.
        let arm = robhaz_model::sqrt(q.norm_squared());
        let of_coupling = 2.0 * arm * self.readings.rocker_rate_error();
        let white = (up * budget.rate_noise) * (up * budget.rate_noise) + of_coupling * of_coupling;
        let bias = GaussMarkov::new(up * self.roll.rate_bias_sigma(), TURN_TIME);
        let measurement = JointMeasurement {
            innovation: (asked - (a - b)) / speed,
            rows: [[(VELOCITY.of(1), 1.0)], [(VELOCITY.of(1), -1.0)]],
            sigma: robhaz_model::sqrt(white + bias.sigma * bias.sigma) / speed,
            white: (white + bias.white(dt)) / (speed * speed),
        };
        let [left, right] = &mut self.sides;
        if let (Some(left), Some(right)) = (left.motion(), right.motion()) {
            MotionFilter::correct_both(left, right, &measurement);
        }
        self.retake(steps);
    }

    /// Corrects both sides' filters by the combinations of the rows without normal forces. `settled` as in
    /// [`crate::methods::Across`].
    // Its stack is as large as that of the solution after it.
    #[inline(never)]
    pub(super) fn impose_parities(
        &mut self,
        steps: &mut [SideStep; 2],
        roll: [f64; 3],
        settled: bool,
    ) -> Result<(), WholeError> {
        let rover = &self.rover;
        let states = steps.each_ref().map(|step| &step.state);
        let (inputs, _, equations) = self.equations(states, roll)?;
        let roll_sigma = self.roll.angle_sigma(&self.settings.budget);
        let traction = inputs.traction();
        let covariance = inputs.covariance(rover, roll_sigma);
        let found = equations.solve_about(&traction, &covariance, &self.about)?;
        let noise = inputs.noise(rover, roll_sigma);
        let parities = equations
            .parities(&traction, &found, &noise)
            .ok_or(WholeError::Singular)?;
        // Axial forces of wheels that are dragged last as long as the turn.
        let lasts = if settled { ROWS_LAST } else { TURN_TIME };
        let error = GaussMarkov::new(1.0, lasts);
        let measurements = parities.map(|parity| JointMeasurement::<INPUTS> {
            innovation: -parity.value,
            rows: inputs
                .gradient(&parity.gradient)
                .map(|gradient| core::array::from_fn(|k| (k, gradient[k]))),
            sigma: error.sigma,
            white: error.white(steps[0].dt),
        });
        let [left, right] = &mut self.sides;
        if let (Some(left), Some(right)) = (left.motion(), right.motion()) {
            let before = [left.inputs(), right.inputs()];
            for mut measurement in measurements {
                // What those before have corrected is no innovation any more.
                let after = [left.inputs(), right.inputs()];
                for ((row, after), before) in measurement.rows.iter().zip(&after).zip(&before) {
                    for (((_, derivative), after), before) in row.iter().zip(after).zip(before) {
                        measurement.innovation -= derivative * (after - before);
                    }
                }
                MotionFilter::correct_both(left, right, &measurement);
            }
        }
        self.retake(steps);
        Ok(())
    }

    /// Takes the states of both sides anew, after their filters were corrected.
    fn retake(&self, steps: &mut [SideStep; 2]) {
        for (side, step) in self.sides.iter().zip(steps) {
            Estimator::retake(side, step);
        }
    }
}
