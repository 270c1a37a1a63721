//! The nominal robot: its nominal parameters, its settings, and the equations that every method
//! takes from them, with the estimate that they make.

use crate::deviation::SIGNIFICANT;
use crate::estimate::{Estimate, EstimateError};
use crate::flags::Flags;
use crate::frame::Inputs;
use crate::settings::{EstimatorSettings, Masses, Sides};
use crate::statics::{Arms, Equations, Equilibrium, Forces, Loads, OtherSide};
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Bar, GRAVITY, PointMasses, Robot, Vec2};

/// Nominal robot and settings.
#[derive(Clone, Debug)]
pub(crate) struct Nominal {
    pub robot: Robot,
    pub settings: EstimatorSettings,
    /// Mean of the wheels' normal forces at rest, N.
    pub mean_load: f64,
    /// Relative standard deviation of the robot's mass, -, by the budget.
    pub mass_sigma: f64,
    /// The masses, placed as the settings choose.
    pub masses: PointMasses,
    /// What the other side does, for one side of two.
    pub other_side: Option<OtherSide>,
}

/// Distance to an end stop at which its torque may act, rad: half a degree.
/// Guard: some times the error of an inclinometer.
const STOP_MARGIN: f64 = 0.0087;
/// Standard deviation of the torque of an end stop, N m.
/// Guard: more than any stop bears in the shipped scenes.
const STOP_TORQUE: f64 = 20.0;
/// Standard deviation of the remaining errors of a row of eq. (8), N: arm r for r - g,
/// accelerations within a step.
/// Guard.
const LOAD_SIGMA: f64 = 0.01;

/// One instant of a robot with its readings.
pub(crate) struct Instant<'a> {
    pub nominal: &'a Nominal,
    /// Time since the last frame, s; 0 at the first.
    pub dt: f64,
    pub inputs: &'a Inputs,
    /// Warnings about the readings.
    pub flags: Flags,
}

/// Flag of a joint that is near one of its end stops, with an angle and its limits in rad.
pub fn at_stop(angle: f64, [lower, upper]: [f64; 2]) -> Flags {
    Flags::AT_STOP.when(angle < lower + STOP_MARGIN || angle > upper - STOP_MARGIN)
}

/// Standard deviation of the torque of its end stop, N m.
pub fn stop_torque(at_stop: Flags) -> f64 {
    if at_stop.is_empty() { 0.0 } else { STOP_TORQUE }
}

impl Nominal {
    /// Places the masses.
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        let mass = &robot.mass;
        Self {
            robot: robot.clone(),
            settings,
            mean_load: robot.mean_wheel_load(),
            mass_sigma: mass_sigma(robot, &settings),
            masses: match settings.masses {
                Masses::LumpedToBody => mass.lumped_to_body(),
                Masses::LumpedToWheels => mass.lumped_to_wheels(),
                Masses::True => mass.true_points(),
            },
            other_side: match settings.sides {
                Sides::Plane => None,
                Sides::OneOfTwo => {
                    let slope = settings.budget.cross_slope;
                    Some(OtherSide::new(robot, &settings.load_shift, slope))
                }
            },
        }
    }

    /// Eq. (8) for link angles (rad), loads and contact angles (rad), with each N acting `ahead` (m) of
    /// its contact by rolling resistance.
    ///
    /// # Errors
    /// [`EstimateError::Singular`].
    #[inline(always)]
    pub fn equations(
        &self,
        arms: Arms,
        link_angles: [f64; 2],
        loads: Loads,
        contact_angle: &[f64; 3],
        ahead: &[f64; 3],
    ) -> Result<Equations, EstimateError> {
        let (geometry, lever) = (&self.robot.geometry, self.settings.moment_lever);
        let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
        let equilibrium = Equilibrium::new(&arms, carriers, radius, &loads, contact_angle, lever)
            .ok_or(EstimateError::Singular)?
            .rolling(ahead, carriers);
        Ok(Equations {
            arms,
            link_angles,
            loads,
            inverse: equilibrium.least_squares().ok_or(EstimateError::Singular)?,
            parity_direction: equilibrium.parity_direction(),
            equilibrium,
        })
    }

    /// The estimate of forces and posture, for the contact angles (rad) and the right-hand side
    /// `F' - H_T T` (N) of the least squares. Without what only some filters state, and without the
    /// time, which is the frame's. Inlined, so that it is made where it is returned: it has more
    /// than a kilobyte.
    #[inline(always)]
    pub fn assemble(
        &self,
        equations: &Equations,
        forces: &Forces,
        right_side: &Vector4<f64>,
        contact_angle: [f64; 3],
        flags: Flags,
    ) -> Estimate {
        let carriers = &self.robot.geometry.carriers;
        let (arms, [theta1, theta2]) = (&equations.arms, equations.link_angles);
        let (equilibrium, loads) = (&equations.equilibrium, &equations.loads);
        let [p, r, s] = equilibrium.pins;
        let q = equilibrium.force_in_q(loads, carriers, &forces.normal, &forces.traction);
        let mut residual = *right_side;
        for i in 0..3 {
            residual -= equilibrium.h_n[i] * forces.normal[i];
        }
        let lever = self.settings.moment_lever;
        let [x, y, m1, m2] = residual.into();
        Estimate {
            time: 0.0,
            normal_force: forces.normal,
            traction: forces.traction,
            contact_angle,
            posture: arms.posture(theta1, theta2),
            pin_from_q: [arms.p, Vec2::zeros(), arms.r, arms.s],
            pin_force: [p, q, r, s],
            residual: [x, y, m1 * lever, m2 * lever],
            parity: None,
            kalman: None,
            flags,
        }
    }

    /// Covariance of the loads in the rows of eq. (8), N^2: a floor, errors of the nominal
    /// parameters, the other side of the robot, and the torque of a stop.
    pub fn load_noise(&self, equations: &Equations) -> Matrix4<f64> {
        let (arms, loads) = (&equations.arms, &equations.loads);
        let (settings, budget) = (&self.settings, &self.settings.budget);
        let carriers = &self.robot.geometry.carriers;
        let lever = settings.moment_lever;
        let mut r = Matrix4::from_diagonal_element(LOAD_SIGMA * LOAD_SIGMA);
        let square = |column: Vector4<f64>| column * column.transpose();
        if budget.body_cg > 0.0 {
            let mut part = Loads::default();
            part.bars[Bar::Body as usize].torque = budget.body_cg
                * robhaz_model::sqrt(0.5 * loads.bars[Bar::Body as usize].force.norm_squared());
            r += square(Equilibrium::load_side(arms, carriers, &part, lever).0);
        }
        let [m1, m2, m3] = self.masses.links.map(|mass| budget.link_mass * mass);
        let [link1, link2, link3] = Bar::LINKS;
        for (bar, mass) in [
            (Bar::Body, budget.payload),
            (link1, m1),
            (link2, m2),
            (link3, m3),
        ] {
            if mass > 0.0 {
                let mut part = Loads::default();
                part.bars[bar as usize].force = Vec2::new(0.0, GRAVITY * mass);
                r += square(Equilibrium::load_side(arms, carriers, &part, lever).0);
            }
        }
        if budget.pin_moment > 0.0 {
            for pin in self.robot.geometry.suspension.pins() {
                let (one, other) = pin.bars();
                let mut part = Loads::default();
                part.bars[one as usize].torque = budget.pin_moment;
                part.bars[other as usize].torque = -budget.pin_moment;
                r += square(Equilibrium::load_side(arms, carriers, &part, lever).0);
            }
        }
        if let Some(covariance) = &budget.load_covariance {
            r += covariance.of_loads(arms, lever);
        }
        if let Some(other) = &self.other_side {
            r += other.of_loads(arms, carriers, lever);
        }
        let of_stop = self.stop_torque(equations.link_angles) / lever;
        r += square(Vector4::new(0.0, 0.0, of_stop, -of_stop));
        r
    }

    /// What rolling resistance of these `coefficients` adds to the rows of eq. (8), N: the moments f r N
    /// of the wheels of each link, at the mean load.
    pub fn by_rolling_resistance(&self, coefficients: &[f64; 3]) -> Vector4<f64> {
        let geometry = &self.robot.geometry;
        let moment = self.mean_load * geometry.wheel_radius / self.settings.moment_lever;
        let mut rows = Vector4::zeros();
        for (carrier, coefficient) in geometry.carriers.iter().zip(coefficients) {
            rows[2 + carrier.index()] += coefficient * moment;
        }
        rows
    }

    /// Flag of a linkage near an end stop, for the angles of links 1 and 2, rad.
    pub fn at_stop(&self, link_angles: [f64; 2]) -> Flags {
        let stop = &self.robot.geometry.stop;
        at_stop(link_angles[0] - link_angles[1], [stop.lower, stop.upper])
    }

    /// Standard deviation of the torque of an end stop of the pin, N m, for the angles of links 1 and 2, rad.
    pub fn stop_torque(&self, link_angles: [f64; 2]) -> f64 {
        stop_torque(self.at_stop(link_angles))
    }

    /// Whether a wheel carries load, by its normal force and the standard deviation of that, N.
    ///
    /// It carries none where N is below a twentieth of the mean load, and the mean load is beyond
    /// [`SIGNIFICANT`] deviations. The wheels share the weight: where N is hardly known, a wheel
    /// that bears its share comes out below zero as easily, and one that is left out of the rolling
    /// constraints would never come back.
    pub fn carries_load(&self, normal_force: f64, sigma: f64) -> bool {
        let least = EstimatorSettings::UNLOADED * self.mean_load;
        normal_force > least || normal_force + SIGNIFICANT * sigma > self.mean_load
    }

    /// A normal force, N, or that below which a wheel may carry no load: for quotients.
    pub fn at_least(&self, normal_force: f64) -> f64 {
        normal_force.max(EstimatorSettings::UNLOADED * self.mean_load)
    }

    /// Flags of the wheels that carry no load.
    pub fn unloaded(loaded: [bool; 3]) -> Flags {
        let mut flags = Flags::NONE;
        for (loaded, flag) in loaded.into_iter().zip(Flags::WHEEL_UNLOADED) {
            flags |= flag.when(!loaded);
        }
        flags
    }
}

/// See [`Nominal::mass_sigma`].
fn mass_sigma(robot: &Robot, settings: &EstimatorSettings) -> f64 {
    let budget = &settings.budget;
    let mut variance = budget.payload * budget.payload;
    for link in &robot.mass.links {
        variance += budget.link_mass * budget.link_mass * link * link;
    }
    if let Some(covariance) = &budget.load_covariance {
        variance += covariance.rows()[0][0];
    }
    robhaz_model::sqrt(variance.max(0.0)) / robot.mass.total()
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::Carrier;

    /// Closed form: on level ground at T = 0 a moment M = f_r r N a wheel changes N by the moments
    /// of link 1 (wheel 1) and link 2 (wheels 2 and 3) about Q, with the same weight: x1 N1 = -M,
    /// x2 N2 + x3 N3 = -2 M, N1 + N2 + N3 = 0. Rounding.
    #[test]
    fn rolling_resistance_moves_the_normal_forces() {
        let robot = Robot::default_a();
        let nominal = Nominal::new(&robot, EstimatorSettings::kalman());
        let arms = Arms::new(&robot.geometry, 0.0, 0.0).expect("the nominal pose");
        let [x1, x2, x3] = arms.axles.map(|axle| axle.x);
        let loads = Loads::at_rest(&nominal.masses);
        let equations = nominal
            .equations(arms, [0.0; 2], loads, &[0.0; 3], &[0.0; 3])
            .expect("regular");
        let resistance = 0.1;
        let by_resistance = nominal.by_rolling_resistance(&[resistance; 3]);
        let found = equations.inverse.solve(&by_resistance).map(f64::abs);

        let moment = resistance * robot.geometry.wheel_radius * robot.mean_wheel_load();
        let front = -moment / x1;
        let middle = (-2.0 * moment + x3 * front) / (x2 - x3);
        for (found, expected) in found.into_iter().zip([front, middle, -front - middle]) {
            assert!((found - expected.abs()).abs() < 1e-12, "{found} {expected}");
        }
    }

    /// Closed form: a payload moves eq. (8) as the weight of a body that is heavier by it. Rounding.
    #[test]
    fn a_payload_is_weight_of_the_body() {
        let robot = Robot::default_a();
        let of_load = |robot: &Robot, payload: f64| {
            let mut settings = EstimatorSettings::kalman();
            settings.budget.payload = payload;
            let nominal = Nominal::new(robot, settings);
            let arms = Arms::new(&robot.geometry, 0.1, -0.1).expect("a pose");
            let loads = Loads::at_rest(&nominal.masses);
            let equations = nominal.equations(arms, [0.1, -0.1], loads, &[0.0; 3], &[0.0; 3]);
            let equations = equations.expect("regular");
            let carriers = &robot.geometry.carriers;
            let lever = nominal.settings.moment_lever;
            let side = Equilibrium::load_side(&equations.arms, carriers, &loads, lever).0;
            (side, nominal.load_noise(&equations))
        };
        let payload = 2.0;
        let mut heavier = robot.clone();
        heavier.mass.body += payload;
        let ((light, exact), (_, stated)) = (of_load(&robot, 0.0), of_load(&robot, payload));
        let moved = of_load(&heavier, 0.0).0 - light;
        let error = stated - exact - moved * moved.transpose();
        assert!(error.amax() < 1e-9, "{error}");
    }

    /// Closed form: a moment of the pin of a bogie turns both links against each other, and nothing else
    /// has it. Rounding.
    #[test]
    fn a_pin_moment_is_between_both_links() {
        let mut robot = Robot::default_a();
        robot.geometry.make_bogie(Carrier::Link2);
        let noise = |pin_moment: f64| {
            let mut settings = EstimatorSettings::kalman();
            settings.budget.pin_moment = pin_moment;
            let nominal = Nominal::new(&robot, settings);
            let arms = Arms::new(&robot.geometry, 0.0, 0.0).expect("the nominal pose");
            let loads = Loads::at_rest(&nominal.masses);
            let equations = nominal.equations(arms, [0.0; 2], loads, &[0.0; 3], &[0.0; 3]);
            nominal.load_noise(&equations.expect("regular"))
        };
        let row = 0.5 / EstimatorSettings::kalman().moment_lever;
        let between = Vector4::new(0.0, 0.0, row, -row);
        let error = noise(0.5) - noise(0.0) - between * between.transpose();
        assert!(error.amax() < 1e-12, "{error}");
    }

    /// A wheel whose N came out at zero or below carries no load where N is known, and its share of
    /// the weight where N is not: at a third of the mean load each three deviations reach it.
    #[test]
    fn a_wheel_is_in_the_air_only_where_its_load_is_known() {
        let nominal = Nominal::new(&Robot::default_a(), EstimatorSettings::kalman());
        let mean = nominal.mean_load;
        for (load, sigma, carries) in [
            (1.0, 0.02, true),
            (0.06, 0.02, true),
            (0.0, 0.02, false),
            (-0.1, 0.02, false),
            (0.0, 0.32, false),
            (0.0, 0.34, true),
            (-0.5, 0.49, false),
            (-0.5, 0.51, true),
            (f64::NAN, 0.02, false),
        ] {
            let found = nominal.carries_load(load * mean, sigma * mean);
            assert_eq!(found, carries, "{load} {sigma}");
        }
    }
}
