//! A rover with both sides: what lies across, beside the pitch plane of one side.

use crate::{Robot, Suspension, Vec2, named};

named! {
    /// What joins the two sides besides the body.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Coupling {
        /// The link that the body is fixed to in the plane is a rocker, pivoted to the body on an
        /// axis across. A differential turns both rockers against each other: the body's pitch is
        /// the mean of theirs, and both get the same moment.
        #[default]
        Differential = "differential",
        /// That link is one half of a rear bogie, which both sides have in common and which rolls
        /// about a longitudinal hinge on the body. The other link is the side's bogie, pivoted to
        /// the body at Q: a triple bogie.
        RearBogie = "rear-bogie",
    }
}

/// A rover with six wheels: one side, which the other mirrors, and the dimensions across.
///
/// Wheels are left 1 to 3, then right 1 to 3. Body frame: origin O on [`Self::pivot`] in the middle
/// plane, x forward, y left, z up.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeRover {
    /// One side, of [`Suspension::Bogie`], with half of the body's mass and half of a rear bogie's.
    /// Its inertias are those of pitch.
    pub side: Robot,
    /// What joins the sides.
    pub coupling: Coupling,
    /// The rockers' pivot axis, or a point of the rear bogie's hinge: x and height in the nominal
    /// pose of the side, m.
    pub pivot: Vec2,
    /// Distances of wheels 1 to 3 from the middle plane, m; they may differ.
    pub half_tracks: [f64; 3],
    /// Distances of the centres of mass of links 1 and 2 from the middle plane, m.
    pub link_places: [f64; 2],
    /// Lateral place of the body's centre of mass, m, left positive.
    pub body_place: f64,
    /// End stops of the coupling, rad: lower and upper limit of the left rocker's angle against the body, nose up, or
    /// of a rear bogie's roll against the body's, left side up. [`Self::NO_STOP`] where it has none.
    pub coupling_stop: [f64; 2],
    /// Roll and yaw inertia of the whole body, kg m^2.
    pub body_inertia: [f64; 2],
    /// Roll and yaw inertia of links 1 and 2 of a side, kg m^2.
    pub link_inertias: [[f64; 2]; 2],
    /// Inertia of a wheel about a diameter, kg m^2.
    pub wheel_inertia: f64,
}

/// How load moves from one side of a rover to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadShift {
    /// Height of the centre of mass above the contacts over half of the mean track, -, in the nominal pose: the
    /// part of a side's weight that a slope across moves, over its tangent.
    pub height_over_half_track: f64,
    /// Part of a side's weight that the lateral place of the body's centre of mass moves, -; to the left is
    /// positive.
    pub off_centre: f64,
    /// Where the body hands on to a side what moves, in the side's nominal pose, m: the pivot of a rocker, or a point
    /// between pin Q of a triple bogie and its rear wheel. `None`: the body's centre of mass.
    pub share_at: Option<Vec2>,
    /// Where it hands on what the other side pushes: there, too; of a triple bogie above Q by the height of the
    /// hinge, since pushes turn the rover, and the axial forces that hold it turn the rear bogie about its hinge.
    pub push_at: Option<Vec2>,
    /// Standard deviation of the height of that place, m: axial forces may be anything from none to twice those,
    /// of a triple bogie.
    pub push_height: f64,
}

impl LoadShift {
    /// Of a rover that tips over at 45 deg, as the rovers on Mars are built to bear.
    pub const UNKNOWN: Self = Self {
        height_over_half_track: 1.0,
        off_centre: 0.0,
        share_at: None,
        push_at: None,
        push_height: 0.0,
    };
}

/// Reason why a rover is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WholeRoverError {
    /// The side is a four-bar. How two of them share the body's moment is left to tyres and frame.
    #[error(
        "the side is a four-bar; allowed: a rocker-bogie or triple bogie (suspension kind \"bogie\")"
    )]
    FourBar,
    /// An entry is not finite, a distance not above 0, or an inertia below 0.
    #[error(
        "{entry} is {found}; allowed: a finite number, for a half track above 0, for an inertia at least 0, for limits of the coupling below and above 0"
    )]
    Entry {
        /// Its name.
        entry: &'static str,
        /// Its value.
        found: f64,
    },
}

impl WholeRover {
    /// Limits that no coupling reaches, rad.
    pub const NO_STOP: [f64; 2] = [-core::f64::consts::PI, core::f64::consts::PI];

    /// Checks what lies across, and that the side has a bogie. The side has checks of its own.
    ///
    /// # Errors
    /// The first [`WholeRoverError`] found.
    pub fn check(&self) -> Result<(), WholeRoverError> {
        if self.side.geometry.suspension == Suspension::FourBar {
            return Err(WholeRoverError::FourBar);
        }
        let ([a, b, c], [lower, upper]) = (self.half_tracks, self.coupling_stop);
        let [[roll1, yaw1], [roll2, yaw2]] = self.link_inertias;
        let [roll, yaw] = self.body_inertia;
        let entries = [
            ("half_tracks", a, a > 0.0),
            ("half_tracks", b, b > 0.0),
            ("half_tracks", c, c > 0.0),
            ("pivot.x", self.pivot.x, true),
            ("pivot.y", self.pivot.y, true),
            ("link_places[0]", self.link_places[0], true),
            ("link_places[1]", self.link_places[1], true),
            ("body_place", self.body_place, true),
            ("coupling_stop[0]", lower, lower < 0.0),
            ("coupling_stop[1]", upper, upper > 0.0),
            ("body_inertia", roll, roll >= 0.0),
            ("body_inertia", yaw, yaw >= 0.0),
            ("link_inertias[0]", roll1, roll1 >= 0.0),
            ("link_inertias[0]", yaw1, yaw1 >= 0.0),
            ("link_inertias[1]", roll2, roll2 >= 0.0),
            ("link_inertias[1]", yaw2, yaw2 >= 0.0),
            (
                "wheel_inertia",
                self.wheel_inertia,
                self.wheel_inertia >= 0.0,
            ),
        ];
        let is_refused = |(_, found, allowed): &(_, f64, bool)| !(*allowed && found.is_finite());
        match entries.into_iter().find(is_refused) {
            Some((entry, found, _)) => Err(WholeRoverError::Entry { entry, found }),
            None => Ok(()),
        }
    }

    /// Place of O ahead of the middle axles, m: steered about these, a rover turns in O by as much sideways.
    pub fn ahead_of_middle(&self) -> f64 {
        let [_, middle, _] = self.side.geometry.axles;
        self.pivot.x - middle.x
    }

    /// Height of O above the contacts, m, in the nominal pose.
    pub fn height_of_pivot(&self) -> f64 {
        let geometry = &self.side.geometry;
        let axle = geometry.axles.iter().map(|axle| axle.y).sum::<f64>() / 3.0;
        self.pivot.y - axle + geometry.wheel_radius
    }

    /// Mean distance of the wheels from the middle plane, m.
    pub fn mean_half_track(&self) -> f64 {
        self.half_tracks.iter().sum::<f64>() / 3.0
    }

    /// How load moves from one side to the other.
    pub fn load_shift(&self) -> LoadShift {
        /// Standard deviation of a uniform distribution, of its half: its reciprocal.
        const SQRT_3: f64 = 1.732_050_807_568_877_2;
        let geometry = &self.side.geometry;
        let mass = &self.side.mass;
        let half_track = self.mean_half_track();
        let q = geometry.pins.q;
        let (pin, above, to_rear) = match self.coupling {
            Coupling::Differential => (self.pivot, 0.0, Vec2::zeros()),
            Coupling::RearBogie => (
                q,
                self.height_of_pivot(),
                geometry.axles[self.lone_wheel()] - q,
            ),
        };
        LoadShift {
            height_over_half_track: self.height() / half_track,
            off_centre: mass.body * self.body_place / (half_track * mass.total()),
            share_at: Some(pin + to_rear * self.rear_share()),
            push_at: Some(pin + Vec2::y() * above),
            push_height: above / SQRT_3,
        }
    }

    /// Part of the load that a slope across moves which a rear bogie moves between its wheels: as much as its hinge is
    /// low, and as the rear wheel carries of a side.
    fn rear_share(&self) -> f64 {
        let loads = self.side.static_loads().unwrap_or([1.0; 3]);
        loads[self.lone_wheel()] / loads.iter().sum::<f64>() * self.height_of_pivot()
            / self.height()
    }

    /// The wheel that no bogie of its side carries.
    fn lone_wheel(&self) -> usize {
        let carriers = &self.side.geometry.carriers;
        let is_alone = |i: &usize| carriers.iter().filter(|c| **c == carriers[*i]).count() == 1;
        (0..3).find(is_alone).unwrap_or(2)
    }

    /// Height of the centre of mass above the contacts, m, in the nominal pose.
    fn height(&self) -> f64 {
        let (geometry, mass) = (&self.side.geometry, &self.side.mass);
        let axle = geometry.axles.iter().map(|axle| axle.y).sum::<f64>() / 3.0;
        let mut moment = 3.0 * mass.wheel * axle + mass.body * geometry.body_cg.y;
        for (link, centre) in mass.links.iter().zip(&geometry.link_cg) {
            moment += link * centre.y;
        }
        moment / mass.total() - axle + geometry.wheel_radius
    }

    /// Mean static load of a wheel, N: a sixth of the weight.
    pub fn mean_wheel_load(&self) -> f64 {
        self.side.mean_wheel_load()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Carrier;

    /// Each kind of fault is refused by its name, and the rover without one is not.
    #[test]
    fn faults_across_are_refused_by_name() {
        let mut side = Robot::default_a();
        side.geometry.make_bogie(Carrier::Link1);
        let rover = WholeRover {
            side,
            coupling: Coupling::Differential,
            pivot: Vec2::new(0.0, 0.3),
            half_tracks: [0.3; 3],
            link_places: [0.25; 2],
            body_place: 0.0,
            coupling_stop: WholeRover::NO_STOP,
            body_inertia: [0.1, 0.2],
            link_inertias: [[0.0; 2]; 2],
            wheel_inertia: 0.0,
        };
        assert_eq!(rover.check(), Ok(()));
        let refused = |change: fn(&mut WholeRover), name: &str| {
            let mut rover = rover.clone();
            change(&mut rover);
            match rover.check() {
                Err(WholeRoverError::Entry { entry, .. }) => assert_eq!(entry, name),
                other => panic!("{name}: {other:?}"),
            }
        };
        refused(|r| r.half_tracks[1] = 0.0, "half_tracks");
        refused(|r| r.half_tracks[2] = f64::NAN, "half_tracks");
        refused(|r| r.pivot.y = f64::INFINITY, "pivot.y");
        refused(|r| r.link_inertias[1][0] = -1.0, "link_inertias[1]");
        refused(|r| r.coupling_stop = [0.1, 0.2], "coupling_stop[0]");
        let four_bar = WholeRover {
            side: Robot::default_a(),
            ..rover.clone()
        };
        assert_eq!(four_bar.check(), Err(WholeRoverError::FourBar));
    }
}
