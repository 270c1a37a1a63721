//! `[robot.across]`: what lies across in a rover with both sides.

use crate::robot::fault::{Fault, too_large_across};
use crate::values::{FARTHEST, POINT};
use robhaz_keys::prelude::*;
use robhaz_model::{Bar, Coupling, Robot, Suspension, Vec2, WholeRover};
use std::f64::consts::PI;

/// What a file states; the rest follows from the side. The default is before a file is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Across {
    coupling: Coupling,
    pivot: Vec2,
    half_tracks: [f64; 3],
    link_places: Option<[f64; 2]>,
    pub(crate) body_place: f64,
    coupling_stop: Option<[f64; 2]>,
    body_inertia: Option<[f64; 2]>,
    link_inertias: Option<[[f64; 2]; 2]>,
    wheel_inertia: Option<f64>,
}

const PLACE: Number = number(LENGTH, at_least(0.0).at_most(FARTHEST));
const INERTIA_OF: Number = number(INERTIA, at_least(0.0).at_most(1e6));
const ROLL_AND_YAW: Array<Number, [f64; 2]> = array("[roll, yaw], each {}", INERTIA_OF);

keys! {
    /// The keys of `[robot.across]`.
    pub(crate) KEYS: Across;

    /// what joins the sides besides the body: a differential between the rockers, or a rear bogie,
    /// which rolls about a longitudinal hinge, as in a triple bogie
    coupling (required): word(&Coupling::ALL, Coupling::name) => coupling;

    /// where the rockers turn on the body, or a point of the rear bogie's hinge
    pivot (required): POINT => pivot;

    /// distances of the front, middle and rear wheel from the middle plane
    half_tracks (required): array("[a, b, c], each {}", number(LENGTH, above(0.0).at_most(FARTHEST)))
        => half_tracks;

    /// distances of the centres of mass of links 1 and 2 from the middle plane; by default the mean
    /// of their wheels' half tracks
    link_places ("mean of own half tracks"): Maybe(array("[a, b], each {}", PLACE)) => link_places;

    /// lateral place of the body's centre of mass, left positive; nearer to the middle than every
    /// wheel
    body_place: number(LENGTH, at_least(-FARTHEST).at_most(FARTHEST)) => body_place;

    /// end stops of the coupling: limits of the left rocker's angle against the body, nose up, or of a rear bogie's
    /// roll against the body's, left side up
    coupling_stop ("none"): Maybe(array("[lower, upper], each {}", number(ANGLE, at_least(-PI).at_most(PI))))
        => coupling_stop;

    /// roll and yaw inertia of the whole body about its centre of mass; by default that of a box:
    /// the outline, as wide as the narrowest track
    body_inertia ("box of the outline"): Maybe(ROLL_AND_YAW) => body_inertia;

    /// the same of links 1 and 2 of a side; by default of rods along x: no roll inertia, yaw as
    /// pitch
    link_inertias ("0, and as in robot.mass"): Maybe(array("two of {}", ROLL_AND_YAW))
        => link_inertias;

    /// of a wheel about a diameter; by default that of a disc, half of robot.mass.wheel_inertia
    wheel_inertia ("half of J_wheel"): Maybe(INERTIA_OF) => wheel_inertia;
}

impl Across {
    /// The rover of this side.
    pub(crate) fn rover(&self, side: &Robot) -> WholeRover {
        let (geometry, mass) = (&side.geometry, &side.mass);
        let mean_track = |link| {
            let own = geometry.carriers.iter().zip(self.half_tracks);
            let own = own.filter(|(carrier, _)| carrier.bar() == link);
            let (count, sum) = own.fold((0.0, 0.0), |(n, sum), (_, y)| (n + 1.0, sum + y));
            sum / count
        };
        let [link1, link2, _] = Bar::LINKS;
        let narrowest = self.half_tracks.into_iter().fold(f64::INFINITY, f64::min);
        let box_of = geometry.outline.body_upper - geometry.outline.body_lower;
        let of_box =
            |length: f64| 2.0 * mass.body * (length * length + 4.0 * narrowest * narrowest) / 12.0;
        let [pitch1, pitch2, _] = mass.link_inertias;
        let rods = [[0.0, pitch1], [0.0, pitch2]];
        WholeRover {
            side: side.clone(),
            coupling: self.coupling,
            pivot: self.pivot,
            half_tracks: self.half_tracks,
            link_places: (self.link_places).unwrap_or([mean_track(link1), mean_track(link2)]),
            body_place: self.body_place,
            coupling_stop: self.coupling_stop.unwrap_or(WholeRover::NO_STOP),
            body_inertia: self
                .body_inertia
                .unwrap_or([of_box(box_of.y), of_box(box_of.x)]),
            link_inertias: self.link_inertias.unwrap_or(rods),
            wheel_inertia: self.wheel_inertia.unwrap_or(0.5 * mass.wheel_inertia),
        }
    }

    /// Checks it for a side.
    pub(crate) fn check(&self, side: &Robot) -> Result<(), Fault> {
        if side.geometry.suspension == Suspension::FourBar {
            let message = "the robot is a four-bar: how two of them share the body's moment, statics do not say; allowed: [robot.across] with suspension.kind = \"bogie\", or none";
            return Err(("coupling", message.to_owned()));
        }
        let mut tracks = self.half_tracks.into_iter();
        if let Some(track) = tracks.find(|track| self.body_place.abs() >= *track) {
            let message = format!(
                "the rover tips sideways, with a wheel at {track} m from the middle; allowed: nearer to the middle than every wheel"
            );
            return Err(("body_place", message));
        }
        if let Some([lower, upper]) = self.coupling_stop
            && !(lower < 0.0 && upper > 0.0)
        {
            let message =
                "it is assembled at 0; allowed: a lower limit below 0 and an upper one above";
            return Err(("coupling_stop", message.to_owned()));
        }
        too_large_across(&self.rover(side)).map_or(Ok(()), Err)
    }
}
