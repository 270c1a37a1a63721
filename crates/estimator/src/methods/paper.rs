//! The paper's filters: a complementary filter for the link angles (Fig. 5), eq. (3) for the
//! tractions.

use crate::estimate::{Estimate, EstimateError, Parity};
use crate::filters::{ComplementaryFilter, TractionObserver};
use crate::nominal::{Instant, Nominal};
use crate::settings::{EstimatorSettings, PaperMethod};
use crate::statics::{Arms, Equations, Forces, Loads};
use robhaz_model::Robot;

/// Filters of the links and wheels. Before its second reading a wheel counts as at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PaperFilters {
    links: [ComplementaryFilter; 2],
    tractions: [TractionObserver; 3],
    speeds: [SpeedByDifference; 3],
}

/// Speed from the last two readings of an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct SpeedByDifference {
    /// Last angle read, rad; `None` before the first.
    angle: Option<f64>,
    /// Time since that angle was read, s.
    age: f64,
    /// Speed, rad/s.
    omega: f64,
}

impl PaperFilters {
    /// For a robot at rest.
    pub fn new(robot: &Robot, method: &PaperMethod, settings: &EstimatorSettings) -> Self {
        let mass = &robot.mass;
        let observer = TractionObserver {
            pole: method.observer_pole,
            // Eq. (2) mixes rotor (relative spin) and wheel (absolute spin) in one J.
            inertia: mass.wheel_inertia + mass.rotor_inertia,
            viscous_damping: settings.viscous_damping,
            wheel_radius: robot.geometry.wheel_radius,
            last: None,
        };
        let link = ComplementaryFilter {
            crossover_time: method.crossover_time,
            last: None,
        };
        Self {
            links: [link; 2],
            tractions: [observer; 3],
            speeds: Default::default(),
        }
    }

    /// Fig. 5, eq. (3), least squares on eq. (8).
    ///
    /// # Errors
    /// [`EstimateError::Linkage`], [`EstimateError::Singular`].
    pub fn estimate(&mut self, instant: &Instant<'_>) -> Result<Estimate, EstimateError> {
        let nominal = instant.nominal;
        let inputs = instant.inputs;
        let (rate, inclination) = (&inputs.rate, &inputs.inclination);
        let angles =
            [0, 1].map(|i| self.links[i].update(instant.dt, rate[i].value, inclination[i].value));
        let traction = [0, 1, 2].map(|i| {
            let speed = &mut self.speeds[i];
            speed.age += instant.dt;
            let reading = inputs.encoder[i].angle;
            if let Some(angle) = reading.now() {
                if let Some(last) = speed.angle.filter(|_| !inputs.encoder[i].new_zero) {
                    speed.omega = (angle - last) / speed.age;
                }
                (speed.angle, speed.age) = (Some(angle), 0.0);
            }
            self.tractions[i].update(instant.dt, inputs.motor_torque[i].value, speed.omega)
        });
        let arms = Arms::new(&nominal.robot.geometry, angles[0], angles[1])
            .map_err(EstimateError::Linkage)?;
        let contact_angle = inputs.contact_angle.map(|angle| angle.value);
        let loads = Loads::at_rest(&nominal.masses);
        let equations = nominal.equations(arms, angles, loads, &contact_angle, &[0.0; 3])?;

        let right_side = equations.equilibrium.right_side(&traction);
        let mut forces = Forces {
            normal: equations.inverse.solve(&right_side),
            traction,
            covariance: [[0.0; 6]; 6],
        };
        let flags = instant.flags
            | Nominal::unloaded(forces.normal.map(|n| nominal.carries_load(n, 0.0)))
            | nominal.at_stop(angles);
        if nominal.settings.nonnegative {
            forces.covariance = unit_covariance(&equations);
            forces.bound();
        }
        let mut estimate = nominal.assemble(&equations, &forces, &right_side, contact_angle, flags);
        estimate.parity = equations.parity_direction.map(|w| Parity {
            value: w.dot(&right_side),
            sigma: 0.0,
        });
        Ok(estimate)
    }
}

/// Covariance of the forces for rows of eq. (8) with equal errors: the metric of the bounded
/// unweighted least squares.
fn unit_covariance(equations: &Equations) -> [[f64; 6]; 6] {
    let rows = &equations.inverse.rows;
    let mut covariance = [[0.0; 6]; 6];
    for i in 0..3 {
        for j in 0..3 {
            covariance[2 * i + 1][2 * j + 1] = rows[i].dot(&rows[j]);
        }
    }
    covariance
}
