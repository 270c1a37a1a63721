//! Where the rover's pins, axles, centres of mass and contacts are.

use super::{Vec3, WholeError};
use nalgebra::Matrix3;
use robhaz_model::{Carrier, Coupling, Suspension, Vec2, WholeRover};

/// The angles of all joints, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joints {
    /// Left rocker less body, nose up; the right rocker has the opposite. Of a rear bogie its roll
    /// less the body's, left side up.
    pub coupling: f64,
    /// Bogies less the link that they are pivoted to, nose up: left, right.
    pub pins: [f64; 2],
    /// Steering of each wheel about an axis through its centre, to the left.
    pub steering: [f64; 6],
}

impl Joints {
    /// Inclination of the body's x-y plane along each wheel, rad, for that of the body, nose up, and its roll,
    /// left side up, rad: a wheel that is steered on a cross slope climbs it. What a contact angle against the
    /// horizontal exceeds it by is that against the body.
    pub fn inclinations(&self, [inclination, roll]: [f64; 2]) -> [f64; 6] {
        let (sp, cp) = libm::sincos(inclination);
        let sr = libm::sin(roll);
        self.steering.map(|steering| {
            let (s, c) = libm::sincos(steering);
            libm::asin((c * sp + s * cp * sr).clamp(-1.0, 1.0))
        })
    }
}

/// A rigid part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// The body.
    Body,
    /// The rocker of side 0 (left) or 1 (right), or that side's half of a rear bogie.
    Rocker(usize),
    /// The bogie of a side.
    Bogie(usize),
}

/// A turned part: the point `nominal` of the nominal pose is at `at`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub turn: Matrix3<f64>,
    nominal: Vec3,
    pub at: Vec3,
}

impl Frame {
    /// Where a point of the nominal pose is now.
    fn place(&self, nominal: Vec3) -> Vec3 {
        self.at + self.turn * (nominal - self.nominal)
    }
}

/// Positions relative to O in the body frame, m.
#[derive(Clone, Copy, Debug)]
pub struct WholePosture {
    /// Pins Q, in the middle plane of their bogies.
    pub q: [Vec3; 2],
    /// Centres of the wheels.
    pub axles: [Vec3; 6],
    /// Unit vectors along the axles, pointing left.
    pub axial: [Vec3; 6],
    /// What carries each wheel.
    pub links: [Link; 6],
    pub(super) rocker: [Frame; 2],
    pub(super) bogie: [Frame; 2],
    /// Centres of mass of the body, of the rockers and of the bogies.
    pub(super) body_centre: Vec3,
    pub(super) rocker_centres: [Vec3; 2],
    pub(super) bogie_centres: [Vec3; 2],
}

/// Where a wheel touches the ground, and the directions of its forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Contact point relative to O, m.
    pub point: Vec3,
    /// Direction of the traction T: forward, in the wheel's plane.
    pub tangent: Vec3,
    /// Direction of the normal force N, in the wheel's plane.
    pub normal: Vec3,
    /// Direction of the axial force A: the axle, pointing left.
    pub axial: Vec3,
}

/// +1 for the left side, -1 for the right one.
pub(super) fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// The index of the link that carries the bogie's wheels: 0 for link 1.
pub(super) fn bogie_index(rover: &WholeRover) -> Result<usize, WholeError> {
    match rover.side.geometry.suspension {
        Suspension::FourBar => Err(WholeError::FourBar),
        Suspension::Bogie { body } => Ok(1 - body.index()),
    }
}

fn nose_up(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    Matrix3::new(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c)
}

fn left_up(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

impl WholePosture {
    /// The posture that the joints' angles give.
    ///
    /// # Errors
    /// [`WholeError::FourBar`].
    pub fn new(rover: &WholeRover, joints: &Joints) -> Result<Self, WholeError> {
        let (geometry, bogie_link) = (&rover.side.geometry, bogie_index(rover)?);
        let nominal = |at: Vec2, y: f64| Vec3::new(at.x - rover.pivot.x, y, at.y - rover.pivot.y);
        let places = rover.link_places;
        let [bogie_place, rocker_place] = if bogie_link == 0 {
            places
        } else {
            [places[1], places[0]]
        };
        let [cg1, cg2, _] = geometry.link_cg;
        let [bogie_cg, rocker_cg] = if bogie_link == 0 {
            [cg1, cg2]
        } else {
            [cg2, cg1]
        };
        let whole = Frame {
            turn: Matrix3::identity(),
            nominal: Vec3::zeros(),
            at: Vec3::zeros(),
        };
        let rocker = [0, 1].map(|side| Frame {
            turn: match rover.coupling {
                Coupling::Differential => nose_up(sign(side) * joints.coupling),
                Coupling::RearBogie => left_up(joints.coupling),
            },
            ..whole
        });
        let bogie = [0, 1].map(|side| {
            let parent = match rover.coupling {
                Coupling::Differential => rocker[side],
                Coupling::RearBogie => whole,
            };
            let q = nominal(geometry.pins.q, sign(side) * bogie_place);
            Frame {
                turn: parent.turn * nose_up(joints.pins[side]),
                nominal: q,
                at: parent.place(q),
            }
        });
        let on_bogie = geometry
            .carriers
            .map(|carrier| Carrier::index(carrier) == bogie_link);
        let wheels: [_; 6] = core::array::from_fn(|i| {
            let (side, wheel) = (i / 3, i % 3);
            let (link, frame) = if on_bogie[wheel] {
                (Link::Bogie(side), &bogie[side])
            } else {
                (Link::Rocker(side), &rocker[side])
            };
            let (s, c) = libm::sincos(joints.steering[i]);
            let at = nominal(geometry.axles[wheel], sign(side) * rover.half_tracks[wheel]);
            (link, frame.place(at), frame.turn * Vec3::new(-s, c, 0.0))
        });
        let centre = |frame: &[Frame; 2], cg, place: f64| {
            [0, 1].map(|side| frame[side].place(nominal(cg, sign(side) * place)))
        };
        Ok(Self {
            q: [bogie[0].at, bogie[1].at],
            axles: wheels.map(|wheel| wheel.1),
            axial: wheels.map(|wheel| wheel.2),
            links: wheels.map(|wheel| wheel.0),
            body_centre: nominal(geometry.body_cg, rover.body_place),
            rocker_centres: centre(&rocker, rocker_cg, rocker_place),
            bogie_centres: centre(&bogie, bogie_cg, bogie_place),
            rocker,
            bogie,
        })
    }

    /// The contacts of wheels with the given radius, m, in a posture. A contact angle, rad, is that
    /// by which the ground rises along the wheel's plane against the body's x-y plane.
    ///
    /// The ground's inclination across the wheel's plane moves the contact along the axle by as much as
    /// the tyre's crown allows: it is neglected, as the penetration is.
    pub fn contacts(&self, wheel_radius: f64, contact_angle: &[f64; 6]) -> [Contact; 6] {
        core::array::from_fn(|i| {
            let axial = self.axial[i];
            let up = Vec3::z() - axial * axial.z;
            let up = up / robhaz_model::sqrt(up.norm_squared());
            let ahead = axial.cross(&up);
            let (s, c) = libm::sincos(contact_angle[i]);
            let (tangent, normal) = (ahead * c + up * s, up * c - ahead * s);
            Contact {
                point: self.axles[i] - normal * wheel_radius,
                tangent,
                normal,
                axial,
            }
        })
    }
}
