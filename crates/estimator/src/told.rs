//! What the estimator is told of the robot, and the steps that every estimator takes with it.

use crate::arms::Arms;
use crate::best::BestFilters;
use crate::equilibrium::{Equilibrium, LeastSquaresInverse, Loads};
use crate::estimate::{Estimate, EstimateError, Parity};
use crate::flags::Flags;
use crate::forces::Forces;
use crate::frame::Inputs;
use crate::settings::{EstimatorSettings, Masses};
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Bar, GRAVITY, PointMasses, Robot, Vec2};

/// Robot and settings.
#[derive(Clone, Debug)]
pub(crate) struct Told {
    pub robot: Robot,
    pub settings: EstimatorSettings,
    /// The masses where the settings take them to be.
    pub masses: PointMasses,
}

/// One frame of readings, checked.
pub(crate) struct Instant<'a> {
    /// s.
    pub time: f64,
    /// Time since the last frame, s; 0 at the first.
    pub dt: f64,
    pub inputs: &'a Inputs,
    /// What the inputs warn of.
    pub flags: Flags,
}

/// Eq. (8) at one instant, its left inverse and its redundancy.
pub(crate) struct Statics {
    pub arms: Arms,
    /// Angles of links 1 and 2, rad.
    pub angles: [f64; 2],
    pub loads: Loads,
    pub equilibrium: Equilibrium,
    pub inverse: LeastSquaresInverse,
    pub parity: Option<Vector4<f64>>,
}

/// Distance to an end stop at which its torque may act, rad: half a degree.
const STOP_MARGIN: f64 = 0.0087;
/// What is believed of the torque of a stop, N m.
const STOP_TORQUE: f64 = 20.0;
/// Errors of the loads at the lever that nothing else covers, N: arm r for r - g, accelerations within a step.
const LOAD_SIGMA: f64 = 0.01;

impl Told {
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        let mass = &robot.mass;
        Self {
            robot: robot.clone(),
            settings,
            masses: match settings.masses {
                Masses::LumpedToBody => mass.lumped_to_body(),
                Masses::LumpedToWheels => mass.lumped_to_wheels(),
                Masses::True => mass.true_points(),
            },
        }
    }

    /// Eq. (8) for given loads and contact angles (rad).
    pub fn statics(
        &self,
        arms: Arms,
        angles: [f64; 2],
        loads: Loads,
        contact_angle: &[f64; 3],
    ) -> Result<Statics, EstimateError> {
        let geometry = &self.robot.geometry;
        let equilibrium = Equilibrium::new(
            &arms,
            &geometry.carriers,
            geometry.wheel_radius,
            &loads,
            contact_angle,
            self.settings.moment_lever,
        )
        .ok_or(EstimateError::Singular)?;
        Ok(Statics {
            arms,
            angles,
            loads,
            inverse: equilibrium.least_squares().ok_or(EstimateError::Singular)?,
            parity: equilibrium.parity_direction(),
            equilibrium,
        })
    }

    /// Covariance of the loads, N^2: a floor, the drawings, and the torque of a stop.
    pub fn load_noise(&self, statics: &Statics) -> Matrix4<f64> {
        let (arms, loads) = (&statics.arms, &statics.loads);
        let (settings, budget) = (&self.settings, &self.settings.budget);
        let carriers = &self.robot.geometry.carriers;
        let lever = settings.moment_lever;
        let mut r = Matrix4::from_diagonal_element(LOAD_SIGMA * LOAD_SIGMA);
        let mut add = |column: Vector4<f64>| r += column * column.transpose();
        if budget.body_cg > 0.0 {
            let mut part = Loads::default();
            part.bars[Bar::Body as usize].torque = budget.body_cg
                * libm::sqrt(0.5 * loads.bars[Bar::Body as usize].force.norm_squared());
            add(Equilibrium::right_of(arms, carriers, &part, lever).0);
        }
        if budget.link_mass > 0.0 {
            for bar in Bar::LINKS {
                let mut part = Loads::default();
                part.bars[bar as usize].force = Vec2::new(
                    0.0,
                    GRAVITY * budget.link_mass * self.masses.links[bar as usize - 1],
                );
                add(Equilibrium::right_of(arms, carriers, &part, lever).0);
            }
        }
        if !self.at_stop(statics.angles).is_empty() {
            let torque = STOP_TORQUE / lever;
            add(Vector4::new(0.0, 0.0, torque, -torque));
        }
        r
    }

    /// Whether the linkage is at an end stop, for the angles of links 1 and 2, rad.
    pub fn at_stop(&self, angles: [f64; 2]) -> Flags {
        let (stop, opening) = (&self.robot.geometry.stop, angles[0] - angles[1]);
        if opening < stop.lower + STOP_MARGIN || opening > stop.upper - STOP_MARGIN {
            Flags::AT_STOP
        } else {
            Flags::NONE
        }
    }

    /// Wheels that carry less than a twentieth of the mean load, N.
    pub fn unloaded(&self, normal_force: &[f64; 3]) -> Flags {
        let least = BestFilters::UNLOADED * self.robot.mean_wheel_load();
        let mut flags = Flags::NONE;
        for (n, flag) in normal_force.iter().zip(Flags::WHEEL_UNLOADED) {
            if *n < least {
                flags |= flag;
            }
        }
        flags
    }

    /// The estimate that forces and right side (N) of one instant make.
    pub fn estimate(
        &self,
        instant: &Instant<'_>,
        statics: &Statics,
        forces: &Forces,
        right: &Vector4<f64>,
        parity: Option<Parity>,
        flags: Flags,
    ) -> Estimate {
        let carriers = &self.robot.geometry.carriers;
        let Statics {
            arms,
            angles,
            loads,
            equilibrium,
            ..
        } = statics;
        let [p, r, s] = equilibrium.pins;
        let q = equilibrium.force_in_q(loads, carriers, &forces.normal, &forces.traction);
        let mut residual = *right;
        for i in 0..3 {
            residual -= equilibrium.h_n[i] * forces.normal[i];
        }
        let lever = self.settings.moment_lever;
        Estimate {
            time: instant.time,
            normal_force: forces.normal,
            traction: forces.traction,
            covariance: None,
            posture: arms.posture(angles[0], angles[1]),
            angle_sigma: None,
            pin_from_q: [arms.p, Vec2::zeros(), arms.r, arms.s],
            pin_force: [p, q, r, s],
            residual: [
                residual.x,
                residual.y,
                residual.z * lever,
                residual.w * lever,
            ],
            parity,
            reading_errors: None,
            flags,
        }
    }
}
