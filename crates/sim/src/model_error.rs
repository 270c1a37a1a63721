//! What the estimators are told of the robot, where it differs from the robot.

use crate::random::Stream;
use crate::sensors::Grade;
use robhaz_model::{GeometryError, MassError, Pins, Robot, Vec2};
use std::f64::consts::TAU;

/// How far what is told is from the truth. With all values 0 it is the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelError {
    /// Distance by which the body's centre of mass is moved in a random direction, m.
    pub body_cg: f64,
    /// Standard deviation of the masses of links 1 to 3, relative; a link's inertia goes with its mass.
    pub link_masses: f64,
    /// Distance by which each pin is moved in a random direction of its own, m.
    pub pins: f64,
    /// Error of the viscous damping B, relative: 0.1 is told 10 % too high.
    pub viscous_damping: f64,
    /// Error of the wheels' inertia J_wheel, relative.
    pub wheel_inertia: f64,
    /// Error of the rotors' inertia J_rotor, relative.
    pub rotor_inertia: f64,
    /// Error of the wheels' radius, relative.
    pub wheel_radius: f64,
}

/// Why what was drawn cannot be a robot.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ModelErrorTooLarge {
    /// The geometry cannot.
    #[error("the geometry that the estimators would be told cannot be a robot's: {0}")]
    Geometry(GeometryError),
    /// The masses cannot.
    #[error("the masses that the estimators would be told cannot be a robot's: {0}")]
    Mass(MassError),
}

impl Grade {
    /// How well the robot is known where sensors are of this grade: B is told 10 % too high unless they are ideal.
    pub fn model_error(self) -> ModelError {
        let viscous_damping = match self {
            Self::Ideal => 0.0,
            Self::Typical | Self::Poor => 0.10,
        };
        ModelError {
            viscous_damping,
            ..ModelError::default()
        }
    }
}

impl ModelError {
    /// The robot that the estimators are told of. What is random comes from the run's seed, each part from a stream of its
    /// own.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when that cannot be a robot.
    pub fn told_robot(&self, robot: &Robot, seed: u64) -> Result<Robot, ModelErrorTooLarge> {
        let stream = |part: &str| Stream::new(seed, &format!("model_error/{part}"));
        let moved = |at: Vec2, distance: f64, part: &str| {
            let (sin, cos) = (TAU * stream(part).uniform()).sin_cos();
            at + Vec2::new(cos, sin) * distance
        };
        let mut told = robot.clone();
        let (geometry, mass) = (&mut told.geometry, &mut told.mass);
        geometry.body_cg = moved(geometry.body_cg, self.body_cg, "body_cg");
        let Pins { p, q, r, s } = geometry.pins;
        geometry.pins = Pins {
            p: moved(p, self.pins, "pin_p"),
            q: moved(q, self.pins, "pin_q"),
            r: moved(r, self.pins, "pin_r"),
            s: moved(s, self.pins, "pin_s"),
        };
        geometry.wheel_radius *= 1.0 + self.wheel_radius;
        for (i, part) in ["link1_mass", "link2_mass", "link3_mass"]
            .iter()
            .enumerate()
        {
            let factor = 1.0 + self.link_masses * stream(part).normal();
            mass.links[i] *= factor;
            mass.link_inertias[i] *= factor;
        }
        mass.wheel_inertia *= 1.0 + self.wheel_inertia;
        mass.rotor_inertia *= 1.0 + self.rotor_inertia;
        told.geometry
            .check()
            .map_err(ModelErrorTooLarge::Geometry)?;
        told.mass.check().map_err(ModelErrorTooLarge::Mass)?;
        Ok(told)
    }

    /// The viscous damping that an estimator is told where it should be told `damping`, N m s.
    pub fn told_damping(&self, damping: f64) -> f64 {
        damping * (1.0 + self.viscous_damping)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAD: ModelError = ModelError {
        body_cg: 0.010,
        link_masses: 0.10,
        pins: 0.002,
        viscous_damping: 0.10,
        wheel_inertia: -0.05,
        rotor_inertia: 0.2,
        wheel_radius: 0.01,
    };

    #[test]
    fn without_errors_the_truth_is_told() {
        let robot = Robot::default_a();
        assert_eq!(ModelError::default().told_robot(&robot, 3), Ok(robot));
        assert!((ModelError::default().told_damping(0.15) - 0.15).abs() < 1e-16);
    }

    /// Closed form: distances and factors are what was asked for; the rest is the robot's.
    #[test]
    fn errors_have_the_size_asked_for() {
        let robot = Robot::default_a();
        for seed in 0..100 {
            let told = CAD.told_robot(&robot, seed).expect("small errors");
            let (is, should) = (&told.geometry, &robot.geometry);
            assert!(((is.body_cg - should.body_cg).norm() - 0.010).abs() < 1e-15);
            for pin in robhaz_model::Pin::ALL {
                let moved = (is.pins.get(pin) - should.pins.get(pin)).norm();
                assert!((moved - 0.002).abs() < 1e-15);
            }
            assert!((is.wheel_radius / should.wheel_radius - 1.01).abs() < 1e-15);
            assert_eq!((is.axles, is.link_cg), (should.axles, should.link_cg));
            let (is, should) = (&told.mass, &robot.mass);
            assert!((is.wheel_inertia / should.wheel_inertia - 0.95).abs() < 1e-15);
            assert!((is.rotor_inertia / should.rotor_inertia - 1.2).abs() < 1e-15);
            for i in 0..3 {
                let mass = is.links[i] / should.links[i];
                let inertia = is.link_inertias[i] / should.link_inertias[i];
                assert!((mass - inertia).abs() < 1e-15);
            }
        }
        assert!((CAD.told_damping(0.15) - 0.165).abs() < 1e-15);
    }

    /// Statistics over seeds, within four standard errors: masses have their standard deviation, no direction is preferred,
    /// pins move independently.
    #[test]
    fn directions_and_masses_are_random() {
        let robot = Robot::default_a();
        const SEEDS: u32 = 5000;
        let n = f64::from(SEEDS);
        let [mut sum, mut square, mut product] = [Vec2::zeros(), Vec2::zeros(), Vec2::zeros()];
        let (mut mass, mut variance) = (0.0, 0.0);
        for seed in 0..u64::from(SEEDS) {
            let told = CAD.told_robot(&robot, seed).expect("small errors");
            let p = (told.geometry.pins.p - robot.geometry.pins.p) / CAD.pins;
            let q = (told.geometry.pins.q - robot.geometry.pins.q) / CAD.pins;
            sum += p / n;
            square += p.component_mul(&p) / n;
            product += p.component_mul(&q) / n;
            let w = (told.mass.links[1] / robot.mass.links[1] - 1.0) / CAD.link_masses;
            mass += w / n;
            variance += w * w / n;
        }
        let error = 4.0 / n.sqrt();
        // A cosine has the variance 1/2, its square 1/8, the product of two 1/4.
        for i in 0..2 {
            assert!(sum[i].abs() < error * 0.5_f64.sqrt(), "{sum}");
            assert!(
                (square[i] - 0.5).abs() < error * 0.125_f64.sqrt(),
                "{square}"
            );
            assert!(product[i].abs() < error * 0.5, "{product}");
        }
        assert!(mass.abs() < error, "{mass}");
        assert!(
            (variance - 1.0).abs() < error * 2.0_f64.sqrt(),
            "{variance}"
        );
    }

    /// The same seed draws the same robot; one error does not draw another anew.
    #[test]
    fn every_part_has_its_own_stream() {
        let robot = Robot::default_a();
        let told = CAD.told_robot(&robot, 8).expect("small errors");
        assert_eq!(CAD.told_robot(&robot, 8), Ok(told.clone()));
        let without = ModelError {
            pins: 0.0,
            body_cg: 0.0,
            ..CAD
        };
        let other = without.told_robot(&robot, 8).expect("small errors");
        assert_eq!(other.mass, told.mass);
        assert_eq!(other.geometry.pins, robot.geometry.pins);
    }

    /// What cannot be a robot is refused: a mass below zero, coinciding pins.
    #[test]
    fn impossible_robots_are_refused() {
        let robot = Robot::default_a();
        let heavy = ModelError {
            link_masses: 10.0,
            ..CAD
        };
        let refused = |e: &ModelError| {
            (0..20)
                .filter(|s| e.told_robot(&robot, *s).is_err())
                .count()
        };
        // Each of three factors is negative in 46 % of the draws: all of 20 seeds miss that with a probability of 1e-16.
        assert!(refused(&heavy) > 0);
        let radius = ModelError {
            wheel_radius: -1.0,
            ..CAD
        };
        assert_eq!(
            radius.told_robot(&robot, 0),
            Err(ModelErrorTooLarge::Geometry(GeometryError::WheelRadius(
                0.0
            )))
        );
    }
}
