//! The paper's filters: a complementary filter for the link angles (Fig. 5), eq. (3) for traction.

use crate::arms::Arms;
use crate::equilibrium::Loads;
use crate::estimate::{Estimate, EstimateError, Parity};
use crate::forces::Forces;
use crate::frame::Inputs;
use crate::linkage::LinkAngleFilter;
use crate::settings::EstimatorSettings;
use crate::told::{Instant, Told};
use crate::traction::{ObserverParameters, TractionObserver};
use crate::visit::visit_fields;
use robhaz_model::Robot;

/// Filters of the links and wheels. Wheels are taken to be at rest before the second reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PaperFilters {
    links: [LinkAngleFilter; 2],
    tractions: [TractionObserver; 3],
    speeds: [SpeedByDifference; 3],
}

visit_fields!(PaperFilters: links, tractions, speeds);

/// Speed from the last two readings of an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct SpeedByDifference {
    angle: f64,
    /// Time since that angle was read, s.
    age: f64,
    omega: f64,
    started: bool,
}

visit_fields!(SpeedByDifference: angle, age, omega, started);

impl PaperFilters {
    pub fn new(robot: &Robot, settings: &EstimatorSettings) -> Self {
        let mass = &robot.mass;
        let observer = TractionObserver::new(ObserverParameters {
            pole: settings.observer_pole,
            // Eq. (2) mixes rotor (relative spin) and wheel (absolute spin) in one J.
            inertia: mass.wheel_inertia + mass.rotor_inertia,
            viscous_damping: settings.viscous_damping,
            wheel_radius: robot.geometry.wheel_radius,
        });
        Self {
            links: [LinkAngleFilter::new(settings.crossover_time); 2],
            tractions: [observer; 3],
            speeds: [SpeedByDifference::default(); 3],
        }
    }

    /// Angles of links 1 and 2 (rad) and tractions (N), `dt` seconds after the last readings.
    fn update(&mut self, inputs: &Inputs, dt: f64) -> ([f64; 2], [f64; 3]) {
        let mut angles = [0.0; 2];
        for i in 0..2 {
            angles[i] = self.links[i].update(dt, inputs.rate[i].value, inputs.inclination[i].value);
        }
        let mut tractions = [0.0; 3];
        for i in 0..3 {
            let speed = &mut self.speeds[i];
            speed.age += dt;
            let reading = inputs.wheel_angle[i];
            if reading.fresh() {
                if speed.started && !inputs.new_zero[i] {
                    speed.omega = (reading.value - speed.angle) / speed.age;
                }
                (speed.angle, speed.age, speed.started) = (reading.value, 0.0, true);
            }
            tractions[i] = self.tractions[i].update(dt, inputs.motor_torque[i].value, speed.omega);
        }
        (angles, tractions)
    }

    /// Fig. 5, eq. (3), least squares on eq. (8).
    pub fn estimate(
        &mut self,
        told: &Told,
        instant: &Instant<'_>,
    ) -> Result<Estimate, EstimateError> {
        let (angles, traction) = self.update(instant.inputs, instant.dt);
        let arms = Arms::new(&told.robot.geometry, angles[0], angles[1])
            .map_err(EstimateError::Linkage)?;
        let contact_angle = instant.inputs.contact_angle.map(|angle| angle.value);
        let statics = told.statics(arms, angles, Loads::at_rest(&told.masses), &contact_angle)?;

        let right = statics.equilibrium.right_side(&traction);
        let mut forces = Forces {
            normal: statics.inverse.solve(&right),
            traction,
            covariance: [[0.0; 6]; 6],
        };
        let flags = instant.flags | told.unloaded(&forces.normal) | told.at_stop(angles);
        if told.settings.nonnegative {
            // All right sides taken as equally uncertain: the constrained least squares.
            let rows = &statics.inverse.rows;
            for i in 0..3 {
                for j in 0..3 {
                    forces.covariance[2 * i + 1][2 * j + 1] = rows[i].dot(&rows[j]);
                }
            }
            forces.without_pull();
        }
        let parity = statics.parity.map(|w| Parity {
            value: w.dot(&right),
            sigma: 0.0,
        });
        Ok(told.estimate(instant, &statics, &forces, &right, parity, flags))
    }
}
