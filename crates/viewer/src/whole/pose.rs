//! Where a rover with both sides is, by dead reckoning.

use nalgebra::{Matrix3, Rotation3};
use robhaz_estimator::whole::{
    Contact, Joints, Link, Vec3, WholeEstimate, WholeFrame, WholePosture,
};
use robhaz_model::{Coupling, WholeRover};

/// What dead reckoning knows.
#[derive(Default)]
pub(super) struct Pose {
    time: Option<f64>,
    /// Of O, m, on ground that starts at height 0.
    position: Option<Vec3>,
    /// rad, to the left.
    yaw: f64,
    yaw_rate: f64,
    /// Of each wheel, rad.
    pub(super) turns: [Option<f64>; 6],
    inclination: f64,
    joints: Joints,
}

/// Where a rover is.
pub(super) struct Place {
    /// Of O, m.
    pub(super) position: Vec3,
    /// How far O moved along the body since the record before, m.
    pub(super) way: f64,
    /// From the body frame to the world's.
    pub(super) attitude: Matrix3<f64>,
    pub(super) posture: WholePosture,
    /// In the body frame.
    pub(super) contacts: [Contact; 6],
}

impl Pose {
    /// Where the rover is at a frame with an estimate. A four-bar is nowhere: `WholeEstimator`
    /// refuses it.
    pub(super) fn reckon(
        &mut self,
        rover: &WholeRover,
        frame: &WholeFrame,
        estimate: &WholeEstimate,
    ) -> Option<Place> {
        self.read(frame);
        let posture = WholePosture::new(rover, &self.joints).ok()?;
        let [inclination, roll] = estimate.attitude;
        let planes = self.joints.inclinations(estimate.attitude);
        let angles =
            std::array::from_fn(|i| estimate.sides[i / 3].contact_angle[i % 3] - planes[i]);
        let radius = rover.side.geometry.wheel_radius;
        let contacts = posture.contacts(radius, &angles);
        let moved = self.advance(frame, inclination, &contacts.map(|c| c.tangent), radius);
        let attitude = attitude(self.yaw, inclination, roll);
        let position = self.position.get_or_insert_with(|| {
            let mean = contacts.iter().map(|c| attitude * c.point).sum::<Vec3>() / 6.0;
            Vec3::new(0.0, 0.0, -mean.z)
        });
        *position += attitude * moved;
        Some(Place {
            position: *position,
            way: moved.x,
            attitude,
            posture,
            contacts,
        })
    }

    /// Holds the readings of a frame.
    fn read(&mut self, frame: &WholeFrame) {
        let held = |held: &mut f64, read: Option<f64>| {
            *held = read.filter(|r| r.is_finite()).unwrap_or(*held);
        };
        held(&mut self.yaw_rate, frame.rates[2]);
        held(&mut self.joints.coupling, frame.coupling);
        (0..2).for_each(|k| held(&mut self.joints.pins[k], frame.pins[k]));
        (0..6).for_each(|i| held(&mut self.joints.steering[i], frame.steering[i]));
    }

    /// Turns by the yaw rate. Returns how far O moves in the body frame, m: the mean of what the
    /// wheels roll along their tangents.
    fn advance(
        &mut self,
        frame: &WholeFrame,
        inclination: f64,
        tangents: &[Vec3; 6],
        radius: f64,
    ) -> Vec3 {
        let dt = self.time.map_or(0.0, |last| frame.time - last);
        self.yaw += self.yaw_rate * dt;
        let pitched = inclination - self.inclination;
        let (mut moved, mut count) = (Vec3::zeros(), 0.0);
        for (i, tangent) in tangents.iter().enumerate() {
            let read = frame.wheel_angle[i].filter(|angle| angle.is_finite());
            if let (Some(last), Some(now)) = (self.turns[i], read) {
                // A link that turns nose up with its wheel held rolls it back.
                moved += tangent * (radius * (now - last - pitched));
                count += 1.0;
            }
            self.turns[i] = read.or(self.turns[i]);
        }
        self.inclination = inclination;
        self.time = Some(frame.time);
        if count > 0.0 { moved / count } else { moved }
    }
}

impl Place {
    /// Rockers (or the halves of a rear bogie) and bogies of both sides, from joint to joint.
    pub(super) fn links(&self, rover: &WholeRover) -> [Vec<Vec3>; 4] {
        let posture = &self.posture;
        let of = |link: Link| {
            let mut points: Vec<Vec3> = (0..6)
                .filter(|i| posture.links[*i] == link)
                .map(|i| posture.axles[i])
                .collect();
            match link {
                Link::Bogie(side) => points.push(posture.q[side]),
                Link::Rocker(side) => {
                    let hinge = match rover.coupling {
                        Coupling::Differential => Vec3::y() * posture.q[side].y,
                        Coupling::RearBogie => Vec3::zeros(),
                    };
                    points.push(hinge);
                    if rover.coupling == Coupling::Differential {
                        points.push(posture.q[side]);
                    }
                }
                Link::Body => {}
            }
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            points
        };
        [
            Link::Rocker(0),
            Link::Bogie(0),
            Link::Rocker(1),
            Link::Bogie(1),
        ]
        .map(of)
    }
}

/// Turns the body frame into the world's: yaw, then inclination, then roll.
fn attitude(yaw: f64, inclination: f64, roll: f64) -> Matrix3<f64> {
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
    let (yaw, pitch) = (
        about(Vec3::z_axis(), yaw),
        about(Vec3::y_axis(), -inclination),
    );
    (yaw * pitch * about(Vec3::x_axis(), roll)).into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the specific force at rest in the body frame is that of the sensors'
    /// definition, (sin p, cos p sin r, cos p cos r), for any yaw.
    #[test]
    fn the_attitude_is_that_of_the_accelerometer() {
        let (pitch, roll) = (0.3_f64, -0.2_f64);
        let up = attitude(1.1, pitch, roll).transpose() * Vec3::z();
        let expected = Vec3::new(
            pitch.sin(),
            pitch.cos() * roll.sin(),
            pitch.cos() * roll.cos(),
        );
        assert!((up - expected).norm() < 1e-15);
    }
}
