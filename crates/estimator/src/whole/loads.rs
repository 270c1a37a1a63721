//! Weight and inertia of the rover's parts (d'Alembert).

use super::posture::{bogie_index, sign};
use super::{Link, Vec3, WholeError, WholePosture};
use nalgebra::Matrix3;
use robhaz_model::{Coupling, WholeRover};

/// Rate (rad/s) and acceleration (rad/s^2) of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointMotion {
    /// Rate.
    pub rate: f64,
    /// Acceleration.
    pub acceleration: f64,
}

/// The motion of the rover. Steering is slow: its rates do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WholeMotion {
    /// Acceleration of O less gravity, m/s^2: what an accelerometer in O reads.
    pub specific_force: Vec3,
    /// Rates of the body: roll, nose down, yaw, rad/s.
    pub rate: Vec3,
    /// Angular accelerations of the body, rad/s^2.
    pub acceleration: Vec3,
    /// [`super::Joints::coupling`].
    pub coupling: JointMotion,
    /// [`super::Joints::pins`].
    pub pins: [JointMotion; 2],
    /// Spin of the wheels relative to their links, forward positive.
    pub spin: [JointMotion; 6],
}

impl WholeMotion {
    /// At rest, or at a steady speed straight ahead, under `gravity` (m/s^2) with the body's
    /// inclination, nose up, and roll, left side up, rad.
    ///
    /// They are those of the specific force: `atan2(f_x, hypot(f_y, f_z))` and `atan2(f_y, f_z)`.
    pub fn at_rest(gravity: f64, inclination: f64, roll: f64) -> Self {
        let (sp, cp) = libm::sincos(inclination);
        let (sr, cr) = libm::sincos(roll);
        Self {
            specific_force: Vec3::new(sp, cp * sr, cp * cr) * gravity,
            ..Self::default()
        }
    }
}

/// Required force and moment of a part about its centre of mass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub link: Link,
    pub mass: f64,
    /// Centre of mass, m.
    pub at: Vec3,
    /// N.
    pub force: Vec3,
    /// N m.
    pub moment: Vec3,
}

/// Motion of a part: that of one of its points and its turning.
#[derive(Clone, Copy)]
struct Turning {
    /// The point, m.
    about: Vec3,
    /// Its acceleration less gravity, m/s^2.
    force: Vec3,
    rate: Vec3,
    acceleration: Vec3,
}

impl Turning {
    /// Acceleration less gravity of a point of the part.
    fn at(&self, point: Vec3) -> Vec3 {
        let (w, r) = (self.rate, point - self.about);
        self.force + self.acceleration.cross(&r) + w.cross(&w.cross(&r))
    }

    /// The part that turns about `axis` through the point `about` of this part.
    fn joint(&self, about: Vec3, axis: Vec3, motion: &JointMotion) -> Self {
        let turn = axis * motion.rate;
        Self {
            about,
            force: self.at(about),
            rate: self.rate + turn,
            acceleration: self.acceleration + axis * motion.acceleration + self.rate.cross(&turn),
        }
    }

    /// Required moment for the inertia `inertia` (kg m^2, body frame) about the centre of mass.
    fn moment(&self, inertia: &Matrix3<f64>) -> Vec3 {
        inertia * self.acceleration + self.rate.cross(&(inertia * self.rate))
    }
}

/// The inertia of a part with the principal axes x, y, z of its nominal pose.
fn turned(turn: &Matrix3<f64>, roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    turn * Matrix3::from_diagonal(&Vec3::new(roll, pitch, yaw)) * turn.transpose()
}

/// The loads of body, rockers, bogies and wheels.
pub(super) fn loads(
    rover: &WholeRover,
    posture: &WholePosture,
    motion: &WholeMotion,
) -> Result<[Load; 11], WholeError> {
    let bogie_link = bogie_index(rover)?;
    let mass = &rover.side.mass;
    let ([m1, m2, _], [j1, j2, _]) = (mass.links, mass.link_inertias);
    let [k1, k2] = rover.link_inertias;
    let link1 = (m1, k1[0], j1, k1[1]);
    let link2 = (m2, k2[0], j2, k2[1]);
    let (of_bogie, of_rocker) = if bogie_link == 0 {
        (link1, link2)
    } else {
        (link2, link1)
    };

    let body = Turning {
        about: Vec3::zeros(),
        force: motion.specific_force,
        rate: motion.rate,
        acceleration: motion.acceleration,
    };
    let nose_up = -Vec3::y();
    let rocker = [0, 1].map(|side| match rover.coupling {
        Coupling::Differential => body.joint(Vec3::zeros(), nose_up * sign(side), &motion.coupling),
        Coupling::RearBogie => body.joint(Vec3::zeros(), Vec3::x(), &motion.coupling),
    });
    let bogie = [0, 1].map(|side| {
        let parent = match rover.coupling {
            Coupling::Differential => rocker[side],
            Coupling::RearBogie => body,
        };
        parent.joint(posture.q[side], nose_up, &motion.pins[side])
    });

    let part = |link, turning: &Turning, at, mass, inertia: &Matrix3<f64>| Load {
        link,
        mass,
        at,
        force: turning.at(at) * mass,
        moment: turning.moment(inertia),
    };
    let [body_roll, body_yaw] = rover.body_inertia;
    let of_body = turned(
        &Matrix3::identity(),
        body_roll,
        2.0 * mass.body_inertia,
        body_yaw,
    );
    let link = |side: usize, on_bogie: bool| {
        let (m, roll, pitch, yaw) = if on_bogie { of_bogie } else { of_rocker };
        let (link, turning, frame, at) = if on_bogie {
            let at = posture.bogie_centres[side];
            (Link::Bogie(side), &bogie[side], &posture.bogie[side], at)
        } else {
            let at = posture.rocker_centres[side];
            (Link::Rocker(side), &rocker[side], &posture.rocker[side], at)
        };
        let inertia = turned(&frame.turn, roll, pitch, yaw);
        part(link, turning, at, m, &inertia)
    };
    let wheel = |i: usize| {
        let (axle, spin) = (posture.axial[i], &motion.spin[i]);
        let turning = match posture.links[i] {
            Link::Bogie(_) => &bogie[i / 3],
            _ => &rocker[i / 3],
        };
        let across = rover.wheel_inertia;
        let inertia = Matrix3::from_diagonal_element(across)
            + axle * axle.transpose() * (mass.wheel_inertia - across);
        let at = posture.axles[i];
        let mut load = part(posture.links[i], turning, at, mass.wheel, &inertia);
        // The rotor is an armature between link and wheel: its torque is internal.
        let gyroscopic = turning.rate.cross(&axle) * spin.rate;
        load.moment += (axle * spin.acceleration + gyroscopic) * mass.wheel_inertia;
        load
    };
    Ok([
        part(
            Link::Body,
            &body,
            posture.body_centre,
            2.0 * mass.body,
            &of_body,
        ),
        link(0, false),
        link(1, false),
        link(0, true),
        link(1, true),
        wheel(0),
        wheel(1),
        wheel(2),
        wheel(3),
        wheel(4),
        wheel(5),
    ])
}
