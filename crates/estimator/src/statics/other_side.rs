//! What the other side of a robot with two does to this one through the body. No reading of a side
//! shows it.
//!
//! | load on the body | size, one standard deviation |
//! |---|---|
//! | push: horizontal, half of the difference of both sides' sums of horizontal forces | found: [`crate::filters::PushFilter`] |
//! | share: vertical, as a cross slope moves the weight | half of what twice the cross slope takes from the side uphill |
//! | twist of a four-bar: moment | the share, which acts anywhere between the body's pins P and S; and what ground that is higher under one side than under the other does |
//!
//! All act at the body's centre of mass. A rocker's pivot at the body is close to it, and the
//! differential makes the moments on both rockers equal: no twist. The body of a triple bogie stands
//! on three hinges, which take none, either. A body that is fixed to two four-bars stands on six
//! wheels with five motions: ground that is uneven across lifts some of them, until one is in the air. No
//! row shows it, so it counts in what is stated alone, not in the weights.

use super::arms::Arms;
use super::equilibrium::Equilibrium;
use super::loads::{Load, Loads};
use crate::deviation::root_sum_square;
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Bar, Carrier, LoadShift, Robot, Suspension, Vec2, cross, turned};

/// Standard deviations of the loads on the body by the other side that no reading shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OtherSide {
    /// N.
    share: f64,
    /// Where it acts, from pin P in the body's nominal axes, m; `None`: at the body's centre of mass.
    share_at: Option<Vec2>,
    /// Where a push acts.
    push_at: Option<Vec2>,
    /// Standard deviation of the height of that place, m.
    push_height: f64,
    /// N m.
    twist: f64,
    /// Of ground that is uneven across, N m: uniform up to where a wheel lifts.
    lifted: f64,
}

impl OtherSide {
    /// For a side of this nominal robot whose load a cross slope moves like this; the slope's standard
    /// deviation, rad.
    pub fn new(robot: &Robot, shift: &LoadShift, cross_slope: f64) -> Self {
        let weight = 3.0 * robot.mean_wheel_load();
        // At twice the slope, of the side uphill, which its cosine takes load from, too: within two deviations.
        let (sin, cos) = libm::sincos(2.0 * cross_slope);
        let by_slope = 0.5 * (shift.height_over_half_track * sin + 1.0 - cos);
        // Which side it is, no reading says.
        let share = weight * root_sum_square(by_slope, shift.off_centre);
        let (twist, lifted) = match robot.geometry.suspension {
            Suspension::FourBar => {
                let pins = robot.geometry.pins.p - robot.geometry.pins.s;
                let [front, _, rear] = robot.geometry.axles;
                let uniform = |between: Vec2| robhaz_model::sqrt(between.norm_squared() / 12.0);
                let lifts = if cross_slope > 0.0 { weight } else { 0.0 };
                (share * uniform(pins), lifts * uniform(front - rear))
            }
            Suspension::Bogie { .. } => (0.0, 0.0),
        };
        let from_p = |place| place - robot.geometry.pins.p;
        Self {
            share,
            share_at: shift.share_at.map(from_p),
            push_at: shift.push_at.map(from_p),
            push_height: shift.push_height,
            twist,
            lifted,
        }
    }

    /// Covariance of share and twist in the rows of eq. (8), N^2, for links at `arms` and moment
    /// rows divided by `lever`, m.
    pub fn of_loads(&self, arms: &Arms, carriers: &[Carrier; 3], lever: f64) -> Matrix4<f64> {
        let share = at(
            self.share_at,
            arms,
            carriers,
            lever,
            Vec2::new(0.0, self.share),
        );
        let twist = on_body(arms, carriers, lever, Vec2::zeros(), self.twist);
        share * share.transpose() + twist * twist.transpose()
    }

    /// Rows of eq. (8) of the twist on ground whose unevenness has this mean square (m^2) under wheels that
    /// give way by `given` (m): the part of it that they do not give way to.
    pub fn by_twist(
        &self,
        arms: &Arms,
        carriers: &[Carrier; 3],
        lever: f64,
        (unevenness, given): (f64, f64),
    ) -> Vector4<f64> {
        let part = unevenness / (unevenness + given * given);
        let twist = self.lifted * robhaz_model::sqrt(part);
        on_body(arms, carriers, lever, Vec2::zeros(), twist)
    }

    /// Whether ground that is uneven across twists the body.
    pub fn twists(&self) -> bool {
        self.lifted > 0.0
    }

    /// Rows of eq. (8) of a push of 1 N, for links at `arms` and moment rows divided by `lever`, m; and those of the
    /// standard deviation of its moment.
    pub fn by_push(&self, arms: &Arms, carriers: &[Carrier; 3], lever: f64) -> [Vector4<f64>; 2] {
        let turns = on_body(arms, carriers, lever, Vec2::zeros(), self.push_height);
        [at(self.push_at, arms, carriers, lever, Vec2::x()), turns]
    }
}

/// Rows of eq. (8) of a force (N) on the body at a place from pin P in its nominal axes, m, or its centre of mass.
fn at(
    place: Option<Vec2>,
    arms: &Arms,
    carriers: &[Carrier; 3],
    lever: f64,
    force: Vec2,
) -> Vector4<f64> {
    let body = Bar::Body as usize;
    let torque = place.map_or(0.0, |place| {
        let place = arms.p + turned(arms.axes[body], place);
        cross(place - arms.centres[body], force)
    });
    on_body(arms, carriers, lever, force, torque)
}

/// Rows of eq. (8) of a load on the body: force (N) at its centre of mass, and torque (N m).
fn on_body(
    arms: &Arms,
    carriers: &[Carrier; 3],
    lever: f64,
    force: Vec2,
    torque: f64,
) -> Vector4<f64> {
    let mut part = Loads::default();
    part.bars[Bar::Body as usize] = Load { force, torque };
    Equilibrium::load_side(arms, carriers, &part, lever).0
}
