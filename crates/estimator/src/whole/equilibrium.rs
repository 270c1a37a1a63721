//! The nine rows of a whole rover's equilibrium.

use super::loads::loads;
use super::posture::sign;
use super::{Contact, Link, Vec3, WholeError, WholeMotion, WholePosture};
use crate::settings::NoiseBudget;
use nalgebra::SVector;
use robhaz_model::{Coupling, WholeRover};

/// Number of rows.
pub const ROWS: usize = 9;

/// One value a row, N: forces x, y, z; over the lever the moments about O of roll, pitch (nose
/// down) and yaw, the coupling's moment, the pitch moments of the left and the right bogie about
/// their Q.
///
/// The coupling's row: of a differential the pitch moment about O of the left side less that of
/// the right one, without the body; of a rear bogie its roll moment about the hinge.
pub type Rows = SVector<f64, ROWS>;

/// `sum_i N_i h_n,i + T_i h_t,i + A_i h_a,i = f`.
#[derive(Clone, Copy, Debug)]
pub struct WholeEquilibrium {
    /// Columns of the normal forces N in the wheels' planes.
    pub h_n: [Rows; 6],
    /// Columns of the tractions T.
    pub h_t: [Rows; 6],
    /// Columns of the axial forces A.
    pub h_a: [Rows; 6],
    /// Axial force over N of a wheel that moves sideways, -: [`Self::slide`].
    pub sliding: [f64; 6],
    /// Standard deviation of the same by the error of a rear bogie's rate, signed: one error moves all wheels.
    pub sliding_error: [f64; 6],
    /// Distance by which N acts ahead of the contact at a coefficient of rolling resistance of 1, m.
    pub rolling: [f64; 6],
    /// Standard deviation of the angle between a wheel's plane and the way that it goes, rad.
    pub toe: f64,
    /// Standard deviation of the moment of each pin beside its force, N m.
    pub pin_moment: f64,
    /// The same of the end stops of the coupling and of the bogies' pins, left and right, N m; 0 away from them.
    pub stop_torque: [f64; 3],
    /// Whether wheels are dragged across their planes.
    pub dragged: bool,
    /// Mean square of the ground's inclination across the wheels, rad^2.
    pub inclination_across: f64,
    /// Loads, N.
    pub f: Rows,
    /// Derivatives of the loads by the specific force x, y, z, kg.
    pub by_specific_force: [Rows; 3],
    /// Mean load of a wheel under the specific force, N.
    pub mean_load: f64,
    /// Lever of the moment rows, m: twice the wheel radius.
    pub lever: f64,
    pub(super) contacts: [Contact; 6],
    links: [Link; 6],
    q: [Vec3; 2],
    coupling: Coupling,
    wheel_radius: f64,
}

/// The rows of a force (N) in the point `at` (m) and a moment (N m) on a part.
fn rows(
    (coupling, q, lever): (Coupling, &[Vec3; 2], f64),
    link: Link,
    at: Vec3,
    force: Vec3,
    moment: Vec3,
) -> Rows {
    let about_o = at.cross(&force) + moment;
    let of_coupling = match (coupling, link) {
        (Coupling::Differential, Link::Rocker(side) | Link::Bogie(side)) => sign(side) * about_o.y,
        (Coupling::RearBogie, Link::Rocker(_)) => about_o.x,
        (Coupling::RearBogie, Link::Bogie(_)) | (_, Link::Body) => 0.0,
    };
    let about_q = |side: usize| {
        if link == Link::Bogie(side) {
            (at - q[side]).cross(&force).y + moment.y
        } else {
            0.0
        }
    };
    let [roll, pitch, yaw, of_coupling, left, right] = [
        about_o.x,
        about_o.y,
        about_o.z,
        of_coupling,
        about_q(0),
        about_q(1),
    ]
    .map(|moment| moment / lever);
    Rows::from([
        force.x,
        force.y,
        force.z,
        roll,
        pitch,
        yaw,
        of_coupling,
        left,
        right,
    ])
}

impl WholeEquilibrium {
    /// The row of the coupling.
    pub const COUPLING: usize = 6;
    /// The row of the yaw moment. Contacts over the width of a wheel resist drilling, which this
    /// row does not know.
    pub const YAW: usize = 5;

    /// The rows in a posture, with a motion, for contact angles in rad
    /// ([`WholePosture::contacts`]).
    ///
    /// # Errors
    /// [`WholeError::FourBar`].
    pub fn new(
        rover: &WholeRover,
        posture: &WholePosture,
        motion: &WholeMotion,
        contact_angle: &[f64; 6],
    ) -> Result<Self, WholeError> {
        let loads = loads(rover, posture, motion)?;
        let wheel_radius = rover.side.geometry.wheel_radius;
        let contacts = posture.contacts(wheel_radius, contact_angle);
        let lever = 2.0 * wheel_radius;
        let frame = (rover.coupling, &posture.q, lever);
        let column = |i: usize, direction: Vec3| {
            let Contact { point, .. } = contacts[i];
            rows(frame, posture.links[i], point, direction, Vec3::zeros())
        };
        let mut f = Rows::zeros();
        let mut by_specific_force = [Rows::zeros(); 3];
        let mut mass = 0.0;
        for load in &loads {
            f += rows(frame, load.link, load.at, load.force, load.moment);
            mass += load.mass;
            for (column, axis) in
                by_specific_force
                    .iter_mut()
                    .zip([Vec3::x(), Vec3::y(), Vec3::z()])
            {
                *column += rows(frame, load.link, load.at, axis * load.mass, Vec3::zeros());
            }
        }
        Ok(Self {
            h_n: core::array::from_fn(|i| column(i, contacts[i].normal)),
            h_t: core::array::from_fn(|i| column(i, contacts[i].tangent)),
            h_a: core::array::from_fn(|i| column(i, contacts[i].axial)),
            sliding: [0.0; 6],
            sliding_error: [0.0; 6],
            rolling: [0.0; 6],
            toe: NoiseBudget::typical().toe,
            pin_moment: 0.0,
            stop_torque: [0.0; 3],
            dragged: false,
            inclination_across: 0.0,
            f,
            by_specific_force,
            mean_load: mass * robhaz_model::sqrt(motion.specific_force.norm_squared()) / 6.0,
            lever,
            contacts,
            links: posture.links,
            q: posture.q,
            coupling: rover.coupling,
            wheel_radius,
        })
    }

    /// Takes the axial forces of wheels that move sideways, at a forward `speed` and with the slip speeds
    /// `creep` at T = N, m/s: friction is the same in all directions, and its law along the wheel is
    /// known. A rear bogie that rolls about its hinge moves its wheels across the ground. Without one
    /// the wheels move across alike but for the yaw, and nothing changes. `rate_error` (rad/s) is the standard deviation of
    /// the rear bogie's rate.
    pub fn slide(&mut self, motion: &WholeMotion, speed: f64, creep: &[f64; 6], rate_error: f64) {
        /// Largest axial force over N: firm ground.
        /// Textbook.
        const FRICTION: f64 = 0.7;
        if self.coupling != Coupling::RearBogie {
            return;
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let mut rate = motion.rate;
            let mut error = Vec3::zeros();
            if let Link::Rocker(_) = self.links[i] {
                rate.x += motion.coupling.rate;
                error.x = rate_error;
            }
            let share_of = |velocity: Vec3| contact.axial.dot(&velocity) / (FRICTION * creep[i]);
            let share = share_of(Vec3::x() * speed + rate.cross(&contact.point));
            let root = robhaz_model::sqrt(1.0 + share * share);
            self.sliding[i] = -FRICTION * share / root;
            let error = share_of(error.cross(&contact.point)) / (root * root * root);
            self.sliding_error[i] = -FRICTION * error.clamp(-1.0, 1.0);
        }
        // What all have in common, the force across that the rover needs shows.
        for sliding in [&mut self.sliding, &mut self.sliding_error] {
            let common = sliding.iter().sum::<f64>() / 6.0;
            for sliding in sliding {
                *sliding -= common;
            }
        }
    }

    /// Variance of each row by the moments of coupling and pins and of their end stops, N^2. A differential's row has
    /// the moments of both rockers.
    pub(crate) fn by_pins(&self) -> Rows {
        let pin = self.pin_moment;
        let rockers = match self.coupling {
            Coupling::Differential => pin * pin,
            Coupling::RearBogie => 0.0,
        };
        let mut rows = Rows::zeros();
        let beside = [rockers, 0.0, 0.0].into_iter().zip(self.stop_torque);
        for (row, (beside, stop)) in rows.iter_mut().skip(Self::COUPLING).zip(beside) {
            *row = (pin * pin + beside + stop * stop) / (self.lever * self.lever);
        }
        rows
    }

    /// Takes the rolling resistance of the wheels, of these coefficients, signed as the spin: each N
    /// acts ahead of its contact. `share` are the smoothed signs of the spins.
    pub fn roll(&mut self, resistance: &[f64; 6], share: &[f64; 6]) {
        for i in 0..6 {
            self.h_n[i] += self.of_shift(i, resistance[i] * self.wheel_radius, 1.0);
            self.rolling[i] = share[i] * self.wheel_radius;
        }
    }

    /// The rows of a load on a link: force (N) in a point relative to O (m), and moment (N m).
    pub fn of_load(&self, link: Link, at: Vec3, force: Vec3, moment: Vec3) -> Rows {
        let frame = (self.coupling, &self.q, self.lever);
        rows(frame, link, at, force, moment)
    }

    /// What moving a normal force N along its wheel's tangent by a distance (m) adds to the rows;
    /// zero beyond the sixth wheel.
    pub(crate) fn of_shift(&self, i: usize, distance: f64, normal: f64) -> Rows {
        let (Some(contact), Some(link)) = (self.contacts.get(i), self.links.get(i)) else {
            return Rows::zeros();
        };
        let moment = (contact.tangent * distance).cross(&(contact.normal * normal));
        self.of_load(*link, Vec3::zeros(), Vec3::zeros(), moment)
    }

    /// What a `turn` (rad) of the bogie of a side about its pin adds to the rows with the forces N and T
    /// (N): the contacts of its wheels move.
    pub(crate) fn of_turn(&self, side: usize, turn: Vec3, n: &[f64; 6], t: &[f64; 6]) -> Rows {
        let mut moment = Vec3::zeros();
        for (i, contact) in self.contacts.iter().enumerate() {
            if self.links[i] == Link::Bogie(side) {
                let force = contact.normal * n[i] + contact.tangent * t[i];
                moment += turn.cross(&(contact.point - self.q[side])).cross(&force);
            }
        }
        self.of_load(Link::Bogie(side), Vec3::zeros(), Vec3::zeros(), moment)
    }

    /// What a `turn` (rad) of a rear bogie about its hinge adds to the rows with the forces N and T (N): its wheels' contacts
    /// and planes turn.
    pub(crate) fn of_rear_turn(&self, turn: f64, n: &[f64; 6], t: &[f64; 6]) -> Rows {
        let turn = Vec3::x() * turn;
        let mut rows = Rows::zeros();
        for (i, contact) in self.contacts.iter().enumerate() {
            if let Link::Rocker(_) = self.links[i] {
                let force = contact.normal * n[i] + contact.tangent * t[i];
                let moment = turn.cross(&contact.point.cross(&force));
                rows += self.of_load(self.links[i], Vec3::zeros(), turn.cross(&force), moment);
            }
        }
        rows
    }

    /// The rows of a force on wheel `i`, N, in a point relative to O, m.
    pub fn of_force(&self, i: usize, at: Vec3, force: Vec3) -> Rows {
        let frame = (self.coupling, &self.q, self.lever);
        rows(frame, self.links[i], at, force, Vec3::zeros())
    }

    /// Derivative of the rows by the contact angle of wheel `i` with the forces N and T (N), N/rad:
    /// the forces turn and the contact moves along the rim.
    #[inline(always)]
    pub fn by_contact_angle(&self, i: usize, normal: f64, traction: f64) -> Rows {
        let contact = &self.contacts[i];
        let force = contact.normal * normal + contact.tangent * traction;
        let turned = contact.normal * traction - contact.tangent * normal;
        let moved = (contact.tangent * self.wheel_radius).cross(&force);
        let frame = (self.coupling, &self.q, self.lever);
        rows(frame, self.links[i], contact.point, turned, moved)
    }

    /// `f - H_T T`, N, for tractions in N.
    pub fn right_side(&self, traction: &[f64; 6]) -> Rows {
        let mut y = self.f;
        for (column, t) in self.h_t.iter().zip(traction) {
            y -= column * *t;
        }
        y
    }
}
