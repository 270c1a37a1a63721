//! The Cramer-Rao bound of N from the readings of one sample.

use crate::rule::Compared;
use nalgebra::{Matrix3, Matrix4, Vector4};
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::Robot;
use robhaz_sim::sensors::SensorSpec;
use robhaz_sim::{EquivalentContact, Truth};

/// Standard deviations of the inputs of eq. (8) at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleNoise {
    /// Relative error of a torque's scale.
    pub torque_gain: f64,
    /// Offset of a torque, its white noise and the step of its reading, together, N m.
    pub torque: f64,
    /// Unmodelled gear friction in the torque reading, the same for all wheels, N m.
    pub gear_friction: f64,
    /// Error of a contact angle, rad.
    pub contact_angle: f64,
}

impl SampleNoise {
    /// The standard deviations of sensors, and of drives with a gear friction (N m) that the
    /// readings do not have. The error of a rounded reading is uniform over its step.
    pub fn of(spec: &SensorSpec, gear_friction: f64) -> Self {
        let step = spec.torque_step / 12.0_f64.sqrt();
        Self {
            torque_gain: spec.torque_gain,
            torque: spec.torque_offset.hypot(spec.torque_noise).hypot(step),
            gear_friction: spec.torque_friction + gear_friction,
            contact_angle: spec.contact_angle_error,
        }
    }

    /// Lower bound of the covariance of the three N of an unbiased estimate from one sample, N^2.
    /// The equations are linearised about the true posture and the equivalent contacts of `wheels`.
    ///
    /// With R the covariance of the residual of eq. (8), the bound is `(H_N' R^-1 H_N)^-1`. R is
    /// singular where an error is zero. The code uses the equal form
    /// `L (R - R w w' R/(w' R w)) L'`, with a left inverse L of H_N and `w' H_N = 0`, which needs
    /// no inverse of R.
    ///
    /// `None` where the contacts leave N undetermined.
    pub fn covariance(
        &self,
        robot: &Robot,
        truth: &Truth,
        wheels: &[EquivalentContact; 3],
    ) -> Option<Matrix3<f64>> {
        let geometry = &robot.geometry;
        let arms = Arms::new(geometry, truth.links[0].angle, truth.links[1].angle).ok()?;
        // Loads are known: H does not depend on them.
        let (loads, angles) = (Loads::default(), wheels.map(|wheel| wheel.angle));
        let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
        let equilibrium = Equilibrium::new(&arms, carriers, radius, &loads, &angles, 1.0)?;
        let inverse = equilibrium.least_squares()?;
        let r = self.residual_covariance(robot, truth, wheels, &equilibrium);
        let left = inverse.rows;
        let mut known = r;
        if let Some(w) = equilibrium.parity_direction() {
            let rw = r * w;
            let spread = w.dot(&rw);
            if spread > 0.0 {
                known -= rw * rw.transpose() / spread;
            }
        }
        Some(Matrix3::from_fn(|i, j| left[i].dot(&(known * left[j]))))
    }

    /// R, in N and N m squared: errors of the tractions, of the common gear friction and of the
    /// contact angles.
    fn residual_covariance(
        &self,
        robot: &Robot,
        truth: &Truth,
        wheels: &[EquivalentContact; 3],
        equilibrium: &Equilibrium,
    ) -> Matrix4<f64> {
        let geometry = &robot.geometry;
        let radius = geometry.wheel_radius;
        let mut r = Matrix4::zeros();
        let mut rub = Vector4::zeros();
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let traction = (self.torque_gain * wheel.torque).hypot(self.torque) / radius;
            let pulled = equilibrium.h_t[i] * traction;
            let forces = [wheels[i].normal_force, wheels[i].traction];
            let turned = equilibrium.by_contact_angle(i, geometry, forces) * self.contact_angle;
            r += pulled * pulled.transpose() + turned * turned.transpose();
            rub += equilibrium.h_t[i] * (self.gear_friction * wheel.omega.signum() / radius);
        }
        r + rub * rub.transpose()
    }
}

/// The Cramer-Rao bound of a run, from the sums over its samples that count.
#[derive(Clone, Debug)]
pub struct Bound {
    noise: SampleNoise,
    robot: Robot,
    square: f64,
    load: f64,
    wheels: f64,
}

impl Bound {
    /// A bound without samples.
    pub fn new(noise: SampleNoise, robot: Robot) -> Self {
        Self {
            noise,
            robot,
            square: 0.0,
            load: 0.0,
            wheels: 0.0,
        }
    }

    /// Adds a sample that counts.
    pub fn add(&mut self, truth: &Truth, compared: &Compared) {
        let contacts = &compared.wheels;
        let Some(covariance) = self.noise.covariance(&self.robot, truth, contacts) else {
            return;
        };
        self.square += covariance.trace().max(0.0);
        self.load += contacts.iter().map(|c| c.normal_force).sum::<f64>();
        self.wheels += 3.0;
    }

    /// Cramer-Rao bound of the NRMSE from one sample, -: RMS of the smallest standard deviation of
    /// N over wheels and samples, over the mean of N. `None` where torques and contact angles are
    /// exact, and without samples.
    pub fn nrmse(&self) -> Option<f64> {
        let bound = (self.square / self.wheels).sqrt() / (self.load / self.wheels);
        (bound > 0.0).then_some(bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_sim::{BarTruth, WheelTruth};

    const ERRORS: SampleNoise = SampleNoise {
        torque_gain: 0.02,
        torque: 0.14,
        gear_friction: 0.3,
        contact_angle: 0.035,
    };

    /// A posture with links and contacts turned, wheels that pull against each other.
    fn truth() -> Truth {
        let link = |angle| BarTruth {
            angle,
            ..BarTruth::default()
        };
        let wheel = |contact_angle, normal_force, traction| WheelTruth {
            contact_angle,
            normal_force,
            traction,
            torque: 0.1 * traction + 0.3,
            omega: 2.0,
            ..WheelTruth::default()
        };
        Truth {
            links: [link(0.1), link(-0.05), BarTruth::default()],
            wheels: [
                wheel(0.2, 40.0, 20.0),
                wheel(-0.1, 50.0, -15.0),
                wheel(0.05, 47.0, 5.0),
            ],
            ..Truth::default()
        }
    }

    fn contacts() -> [EquivalentContact; 3] {
        Compared::of(&truth()).expect("one contact a wheel").wheels
    }

    fn parts(errors: &SampleNoise) -> (Equilibrium, Matrix4<f64>) {
        let (robot, truth) = (Robot::default_a(), truth());
        let geometry = &robot.geometry;
        let arms = Arms::new(geometry, truth.links[0].angle, truth.links[1].angle).expect("closes");
        let equilibrium = Equilibrium::new(
            &arms,
            &geometry.carriers,
            geometry.wheel_radius,
            &Loads::default(),
            &truth.wheels.map(|w| w.contact_angle),
            1.0,
        )
        .expect("regular");
        let r = errors.residual_covariance(&robot, &truth, &contacts(), &equilibrium);
        (equilibrium, r)
    }

    /// Equivalence: where R can be inverted the bound is `(H_N' R^-1 H_N)^-1`.
    #[test]
    fn it_is_the_inverse_of_the_information() {
        let (equilibrium, r) = parts(&ERRORS);
        let weight = r.try_inverse().expect("regular");
        let h = &equilibrium.h_n;
        let information = Matrix3::from_fn(|i, j| h[i].dot(&(weight * h[j])));
        let expected = information.try_inverse().expect("regular");
        let found = ERRORS
            .covariance(&Robot::default_a(), &truth(), &contacts())
            .expect("regular");
        // Rounding, times the condition of R (about 1e3).
        assert!(
            (found - expected).norm() < 1e-9 * expected.norm(),
            "{found} {expected}"
        );
    }

    /// Conservation: exact contact angles leave the forces on the whole robot known but for the
    /// tractions, and with nothing unknown nothing is unknown.
    #[test]
    fn exact_readings_leave_nothing_unknown() {
        let exact = SampleNoise {
            torque_gain: 0.0,
            torque: 0.0,
            gear_friction: 0.0,
            contact_angle: 0.0,
        };
        let of = |errors: &SampleNoise| {
            let covariance = errors.covariance(&Robot::default_a(), &truth(), &contacts());
            covariance.expect("regular").trace()
        };
        assert!(of(&exact).abs() < 1e-12);
        // Each error alone makes R singular (rank 1 to 3), and more unknown than none, less than
        // all.
        let alone = [
            SampleNoise {
                torque: 0.1,
                ..exact
            },
            SampleNoise {
                contact_angle: 0.03,
                ..exact
            },
        ];
        for errors in alone {
            let found = of(&errors);
            assert!(found > 0.1 && found < of(&ERRORS), "{errors:?} {found}");
        }
    }
}
