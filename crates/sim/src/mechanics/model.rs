//! The robot with its drives on its ground, and links 1 and 2 with the masses of their wheels: two
//! rigid bodies that turn about Q.

use super::kinematics::{Kinematics, Linkage, State};
use super::mass_matrix::MassMatrix;
use crate::drive::Drive;
use crate::ground::Ground;
use crate::setup::PlantSetup;
use nalgebra::Vector4;
use robhaz_model::{Bar, Robot, Vec2, perp, turned};

/// The equations of motion with all laws that act on the robot.
pub(crate) struct Mechanics {
    pub robot: Robot,
    pub drive: Drive,
    pub linkage: Linkage,
    pub(super) carriers: Carriers,
    pub ground: Ground,
}

impl Mechanics {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            robot: setup.robot.clone(),
            drive: setup.drive.clone(),
            linkage: Linkage::new(&setup.robot.geometry),
            carriers: Carriers::new(&setup.robot),
            ground: Ground::new(setup),
        }
    }

    /// Motor torques less the losses of the gears, N m.
    pub(super) fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| torques[i] - self.drive.loss_torque(state.omega[i]))
    }
}

/// Inertia of links 1 and 2, each with its wheels as point masses on their axles, and with the
/// inertia that wheel and rotor add to the link when the wheel spins are eliminated, J_w J_r/(J_w +
/// J_r).
#[derive(Clone, Copy)]
pub(super) struct Carriers([Carrier; 2]);

#[derive(Clone, Copy, Default)]
struct Carrier {
    /// Mass, kg.
    mass: f64,
    /// Sum of mass times nominal position relative to Q, kg m.
    moment: Vec2,
    /// Inertia about Q, kg m^2.
    inertia: f64,
}

impl Carriers {
    pub fn new(robot: &Robot) -> Self {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let q = geometry.pins.q;
        let mut carriers = [Carrier::default(); 2];
        for (k, bar) in [Bar::Link1, Bar::Link2].into_iter().enumerate() {
            let (own, inertia) = mass.of(bar);
            carriers[k].add(own, geometry.link_cg[k] - q);
            carriers[k].inertia += inertia;
        }
        let (jw, jr) = (mass.wheel_inertia, mass.rotor_inertia);
        for (axle, link) in geometry.axles.iter().zip(geometry.carriers) {
            let carrier = &mut carriers[link.index()];
            carrier.add(mass.wheel, axle - q);
            carrier.inertia += jw * jr / (jw + jr);
        }
        Self(carriers)
    }

    /// Adds both to the mass matrix, and their weight under `gravity` (m/s^2) and bias force to the
    /// right-hand side.
    #[inline]
    pub fn add(
        &self,
        gravity: f64,
        kinematics: &Kinematics,
        m: &mut MassMatrix,
        right: &mut Vector4<f64>,
    ) {
        for (k, carrier) in self.0.iter().enumerate() {
            let rate = kinematics.link_cgs[k].rate;
            let moment = turned(kinematics.axes[1 + k], carrier.moment);
            let lever = perp(moment);
            m.mass += carrier.mass;
            m.levers[k] += lever;
            m.inertia[2 * k] += carrier.inertia;
            // The centripetal accelerations have no moment about Q.
            let bias = moment * (rate * rate);
            right[0] += bias.x;
            right[1] += bias.y - carrier.mass * gravity;
            right[2 + k] -= lever.y * gravity;
        }
    }
}

impl Carrier {
    /// Adds a mass (kg) at an arm from Q, m.
    fn add(&mut self, mass: f64, arm: Vec2) {
        self.mass += mass;
        self.moment += arm * mass;
        self.inertia += mass * arm.norm_squared();
    }
}
