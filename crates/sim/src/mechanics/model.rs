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
        let (jw, jr) = (
            setup.robot.mass.wheel_inertia,
            setup.robot.mass.rotor_inertia,
        );
        Self {
            robot: setup.robot.clone(),
            drive: setup.drive.clone(),
            linkage: Linkage::new(&setup.robot.geometry),
            // What wheel and rotor add to the link when the wheel spins are eliminated.
            carriers: Carriers::new(&setup.robot, jw * jr / (jw + jr)),
            ground: Ground::new(setup),
        }
    }

    /// Motor torques less the losses of the gears, N m.
    pub(super) fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| torques[i] - self.drive.loss_torque(state.omega[i]))
    }
}

/// Inertia of links 1 and 2, each with its wheels as point masses on their axles and an inertia of
/// each wheel's gear.
#[derive(Clone, Copy)]
pub(crate) struct Carriers([Carrier; 2]);

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
    /// `gear` is the inertia that a wheel adds to its link, kg m^2.
    pub fn new(robot: &Robot, gear: f64) -> Self {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let q = geometry.pins.q;
        let mut carriers = [Carrier::default(); 2];
        for (k, bar) in [Bar::Link1, Bar::Link2].into_iter().enumerate() {
            let (own, inertia) = mass.of(bar);
            carriers[k].add(own, geometry.link_cg[k] - q);
            carriers[k].inertia += inertia;
        }
        for (axle, link) in geometry.axles.iter().zip(geometry.carriers) {
            let carrier = &mut carriers[link.index()];
            carrier.add(mass.wheel, axle - q);
            carrier.inertia += gear;
        }
        Self(carriers)
    }

    /// The mass matrix of all bars, and the right-hand side of their weights and bias forces.
    #[inline(always)]
    pub fn without_ground(
        &self,
        robot: &Robot,
        kinematics: &Kinematics,
    ) -> (MassMatrix, Vector4<f64>) {
        let gravity = robot.gravity;
        let (mut m, mut right) = (MassMatrix::default(), Vector4::zeros());
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
        for (bar, cg, turning) in kinematics.free_bars() {
            let (own, inertia) = robot.mass.of(bar);
            m.add_mass(own, [cg.j1, cg.j2]);
            m.add_inertia(inertia, [turning.k1, turning.k2]);
            let weight = Vec2::new(0.0, -gravity);
            cg.add_force((weight - cg.bias) * own, &mut right);
            turning.add_torque(-inertia * turning.bias, &mut right);
        }
        (m, right)
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
