//! Readings in, wheel forces out: the paper's steps in their order.

use crate::flags::Flags;
use crate::linkage::LinkAngleFilter;
use crate::statics::{BlockForm, FullSystem, ReducedSystem, Singular};
use crate::traction::{ObserverParameters, TractionObserver};
use robhaz_model::{GRAVITY, Geometry, Pin, PointMasses, Posture, PostureError, Robot, Vec2};

/// Readings of the inclinometer and the rate gyroscope on one link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkReading {
    /// Turn from the nominal pose, rad, counter-clockwise.
    pub inclination: f64,
    /// Angular rate, rad/s, counter-clockwise.
    pub rate: f64,
}

/// Everything that the estimator sees of one instant, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorFrame {
    /// Time of the sample, s; must increase from frame to frame.
    pub time: f64,
    /// Turn of each wheel relative to its link, rad, forward positive: encoder counts times 2 pi / counts a turn.
    pub wheel_angle: [f64; 3],
    /// Motor torque at each wheel after the gear, N m, forward positive.
    pub motor_torque: [f64; 3],
    /// Sensors on link 1.
    pub link1: LinkReading,
    /// Sensors on link 2.
    pub link2: LinkReading,
    /// Contact angles, rad: given from elsewhere, as the paper assumes.
    pub contact_angle: [f64; 3],
}

/// Where the estimator thinks the linkage's mass is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Masses {
    /// Concentrated in the body's centre of mass (Fig. 7).
    LumpedToBody,
    /// Shared evenly by the wheels (Fig. 8).
    LumpedToWheels,
    /// Where it is.
    True,
}

/// Choices of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Where the linkage's mass is taken to be.
    pub masses: Masses,
    /// Pole omega_c of the traction observer, eq. (3), rad/s.
    pub observer_pole: f64,
    /// Crossover time between gyro and inclinometer, s.
    pub crossover_time: f64,
    /// Viscous damping B of the wheel module, N m s.
    pub viscous_damping: f64,
}

impl EstimatorSettings {
    /// `paper-body`: the linkage's mass in the body (Fig. 7).
    pub fn paper_body() -> Self {
        Self {
            masses: Masses::LumpedToBody,
            ..Self::true_mass()
        }
    }

    /// `paper-wheels`: the linkage's mass in the wheels (Fig. 8).
    pub fn paper_wheels() -> Self {
        Self {
            masses: Masses::LumpedToWheels,
            ..Self::true_mass()
        }
    }

    /// `true-mass`: the links' masses where they are; all else as in the paper. omega_c = 50 rad/s, B = 0.15 N m s.
    pub fn true_mass() -> Self {
        Self {
            masses: Masses::True,
            observer_pole: 50.0,
            crossover_time: 0.5,
            viscous_damping: 0.15,
        }
    }
}

/// What the estimator makes of the readings of one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Time of the readings, s.
    pub time: f64,
    /// Normal force N of each wheel, N.
    pub normal_force: [f64; 3],
    /// Traction T of each wheel, N, driving forward positive.
    pub traction: [f64; 3],
    /// Angles of the four bars, rad (Fig. 5).
    pub posture: Posture,
    /// Positions of P, Q, R, S relative to Q in world axes, m (Fig. 5).
    pub pin_from_q: [Vec2; 4],
    /// Forces in P, Q, R, S on the first bar of [`Pin::bars`], N.
    pub pin_force: [Vec2; 4],
    /// What is left of eq. (8): horizontal and vertical force (N), moments of links 1 and 2 about Q (N m).
    pub residual: [f64; 4],
    /// Covariance of x' = [T1 N1 T2 N2 T3 N3], N^2; infinite variances where the estimator knows none.
    pub covariance: [[f64; 6]; 6],
    /// The one redundancy of the statics, where the estimator checks it.
    pub parity: Option<Parity>,
    /// Reasons to trust this estimate less.
    pub flags: Flags,
}

/// What is left over in the direction in which the statics are redundant: zero but for errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parity {
    /// Value, N.
    pub value: f64,
    /// Its standard deviation, N.
    pub sigma: f64,
}

impl Estimate {
    /// Standard deviation of N of a wheel (0 front, 1 middle, 2 rear), N. `None` where the estimator knows none.
    pub fn sigma_normal(&self, wheel: usize) -> Option<f64> {
        self.sigma(2 * wheel + 1)
    }

    /// Standard deviation of T of a wheel (0 front, 1 middle, 2 rear), N. `None` where the estimator knows none.
    pub fn sigma_traction(&self, wheel: usize) -> Option<f64> {
        self.sigma(2 * wheel)
    }

    fn sigma(&self, i: usize) -> Option<f64> {
        let variance = self.covariance[i][i];
        variance.is_finite().then(|| libm::sqrt(variance))
    }
}

/// The covariance of forces of which nothing is known, N^2.
const fn unknown_covariance() -> [[f64; 6]; 6] {
    let mut covariance = [[0.0; 6]; 6];
    let mut i = 0;
    while i < 6 {
        covariance[i][i] = f64::INFINITY;
        i += 1;
    }
    covariance
}

/// Why readings give no estimate. The estimator's state is as before the call; it can go on with the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EstimateError {
    /// A reading is not a finite number.
    NotFinite {
        /// Which field of [`SensorFrame`].
        field: &'static str,
    },
    /// Time did not increase.
    Time {
        /// Time of the last frame, s.
        last: f64,
        /// Time of this frame, s.
        now: f64,
    },
    /// The link angles read cannot be those of the four-bar.
    Linkage(PostureError),
    /// The statics are singular in this posture.
    Statics(Singular),
}

impl core::fmt::Display for EstimateError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotFinite { field } => write!(f, "the reading {field} is not a finite number"),
            Self::Time { last, now } => {
                write!(
                    f,
                    "time must increase: the last frame was at {last} s, this one at {now} s"
                )
            }
            Self::Linkage(e) => e.fmt(f),
            Self::Statics(e) => e.fmt(f),
        }
    }
}

impl core::error::Error for EstimateError {}

/// The paper's estimator: link angles, traction by eq. (3), least squares on eq. (8).
///
/// Wheels are taken to be at rest before the second frame.
#[derive(Clone, Debug)]
pub struct Estimator {
    geometry: Geometry,
    masses: PointMasses,
    links: [LinkAngleFilter; 2],
    tractions: [TractionObserver; 3],
    /// Time and wheel angles of the last frame.
    last: Option<(f64, [f64; 3])>,
}

impl Estimator {
    /// An estimator for a robot, at rest.
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        let mass = &robot.mass;
        let observer = TractionObserver::new(ObserverParameters {
            pole: settings.observer_pole,
            // Eq. (2) mixes rotor (relative spin) and wheel (absolute spin) in one J.
            inertia: mass.wheel_inertia + mass.rotor_inertia,
            viscous_damping: settings.viscous_damping,
            wheel_radius: robot.geometry.wheel_radius,
        });
        Self {
            geometry: robot.geometry.clone(),
            masses: match settings.masses {
                Masses::LumpedToBody => mass.lumped_to_body(),
                Masses::LumpedToWheels => mass.lumped_to_wheels(),
                Masses::True => mass.true_points(),
            },
            links: [LinkAngleFilter::new(settings.crossover_time); 2],
            tractions: [observer; 3],
            last: None,
        }
    }

    /// Takes the readings of one instant and estimates the forces of that instant.
    ///
    /// # Errors
    /// [`EstimateError`]; the estimator then stands as if the frame had not come.
    pub fn update(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        check_finite(frame)?;
        let (dt, omega) = match self.last {
            None => (0.0, [0.0; 3]),
            Some((last, angles)) => {
                let dt = frame.time - last;
                if dt <= 0.0 {
                    return Err(EstimateError::Time {
                        last,
                        now: frame.time,
                    });
                }
                let mut omega = [0.0; 3];
                for i in 0..3 {
                    omega[i] = (frame.wheel_angle[i] - angles[i]) / dt;
                }
                (dt, omega)
            }
        };
        let (mut links, mut tractions) = (self.links, self.tractions);

        // Fig. 5: the linkage's position.
        let theta1 = links[0].update(dt, frame.link1.rate, frame.link1.inclination);
        let theta2 = links[1].update(dt, frame.link2.rate, frame.link2.inclination);
        let posture =
            Posture::close(&self.geometry, theta1, theta2).map_err(EstimateError::Linkage)?;

        // Eq. (3): traction.
        let mut traction = [0.0; 3];
        for i in 0..3 {
            traction[i] = tractions[i].update(dt, frame.motor_torque[i], omega[i]);
        }

        // Eqs. (1) to (8): normal forces.
        let full = FullSystem::new(&self.geometry, &self.masses, &posture, &frame.contact_angle);
        let block = BlockForm::new(&full);
        let x_u = block.pin_forces().map_err(EstimateError::Statics)?;
        let solution = ReducedSystem::new(&block, &x_u)
            .normal_forces(&traction)
            .map_err(EstimateError::Statics)?;

        (self.links, self.tractions) = (links, tractions);
        self.last = Some((frame.time, frame.wheel_angle));
        let pin = |i: usize| Vec2::new(x_u[i], x_u[i + 1]);
        let (p, r, s) = (pin(0), pin(2), pin(4));
        let q = self.force_in_q(frame, &traction, &solution.normal_force, p);
        Ok(Estimate {
            time: frame.time,
            normal_force: solution.normal_force,
            traction,
            posture,
            pin_from_q: Pin::ALL.map(|pin| posture.pin_from_q(&self.geometry, pin)),
            pin_force: [p, q, r, s],
            residual: solution.residual,
            covariance: unknown_covariance(),
            parity: None,
            flags: Flags::default(),
        })
    }

    /// Force on link 1 from link 2, N: what the other forces on link 1 leave over.
    fn force_in_q(
        &self,
        frame: &SensorFrame,
        traction: &[f64; 3],
        normal_force: &[f64; 3],
        p: Vec2,
    ) -> Vec2 {
        let mut q = p + Vec2::new(0.0, self.masses.links[0] * GRAVITY);
        for i in 0..3 {
            if self.geometry.carriers[i].index() == 0 {
                let (sin, cos) = libm::sincos(frame.contact_angle[i]);
                q -= Vec2::new(cos, sin) * traction[i] + Vec2::new(-sin, cos) * normal_force[i];
                q.y += self.masses.wheel * GRAVITY;
            }
        }
        q
    }
}

fn check_finite(frame: &SensorFrame) -> Result<(), EstimateError> {
    let fields = [
        ("time", frame.time.is_finite()),
        ("wheel_angle", all_finite(&frame.wheel_angle)),
        ("motor_torque", all_finite(&frame.motor_torque)),
        ("link1.inclination", frame.link1.inclination.is_finite()),
        ("link1.rate", frame.link1.rate.is_finite()),
        ("link2.inclination", frame.link2.inclination.is_finite()),
        ("link2.rate", frame.link2.rate.is_finite()),
        ("contact_angle", all_finite(&frame.contact_angle)),
    ];
    match fields.into_iter().find(|(_, finite)| !finite) {
        Some((field, _)) => Err(EstimateError::NotFinite { field }),
        None => Ok(()),
    }
}

fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_rest(time: f64) -> SensorFrame {
        SensorFrame {
            time,
            wheel_angle: [0.0; 3],
            motor_torque: [0.0; 3],
            link1: LinkReading {
                inclination: 0.0,
                rate: 0.0,
            },
            link2: LinkReading {
                inclination: 0.0,
                rate: 0.0,
            },
            contact_angle: [0.0; 3],
        }
    }

    #[test]
    fn bad_frames_are_refused_and_leave_the_state_alone() {
        let robot = Robot::default_a();
        let mut estimator = Estimator::new(&robot, EstimatorSettings::true_mass());
        estimator.update(&at_rest(0.0)).expect("a good frame");
        let before = estimator.clone();

        let mut bad = at_rest(0.001);
        bad.motor_torque[1] = f64::NAN;
        assert_eq!(
            estimator.update(&bad),
            Err(EstimateError::NotFinite {
                field: "motor_torque"
            })
        );
        assert_eq!(
            estimator.update(&at_rest(0.0)),
            Err(EstimateError::Time {
                last: 0.0,
                now: 0.0
            })
        );
        let mut bad = at_rest(0.001);
        bad.link1.inclination = 1000.0;
        assert!(matches!(
            estimator.update(&bad),
            Err(EstimateError::Linkage(_))
        ));

        let good = at_rest(0.002);
        let mut untouched = before;
        assert_eq!(estimator.update(&good), untouched.update(&good));
    }

    /// Newton's third law across the estimate: the three forces on the body balance its weight, those on link 3 too.
    #[test]
    fn pin_forces_balance_the_bars() {
        let robot = Robot::default_a();
        let mut estimator = Estimator::new(&robot, EstimatorSettings::true_mass());
        let mut frame = at_rest(0.0);
        frame.link1.inclination = 0.1;
        frame.link2.inclination = -0.05;
        frame.contact_angle = [0.2, 0.0, -0.1];
        frame.motor_torque = [0.5, -0.2, 0.3];
        let estimate = estimator.update(&frame).expect("a good frame");
        let [p, q, r, s] = estimate.pin_force;
        let weight = |m: f64| Vec2::new(0.0, -m * GRAVITY);
        assert!((p + s + weight(robot.mass.body)).norm() < 1e-9);
        assert!((r - s + weight(robot.mass.links[2])).norm() < 1e-9);
        let ground = |i: usize| {
            let (sin, cos) = libm::sincos(frame.contact_angle[i]);
            Vec2::new(cos, sin) * estimate.traction[i]
                + Vec2::new(-sin, cos) * estimate.normal_force[i]
        };
        let link1 = ground(0) + q - p + weight(robot.mass.links[0] + robot.mass.wheel);
        assert!(link1.norm() < 1e-9);
    }
}
