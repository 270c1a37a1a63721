//! What the other side of a robot with two does to this one through the body. No reading of a side
//! shows it.
//!
//! | load on the body | size, one standard deviation |
//! |---|---|
//! | push: horizontal, half of the difference of both sides' sums of horizontal forces | found: [`crate::filters::PushFilter`] |
//! | share: vertical, as a cross slope moves the weight | the side's weight times the tangent of the cross slope times the height of the centre of mass over half of the track |
//! | twist of a four-bar: moment | the share, which acts anywhere between the body's pins P and S |
//!
//! All act at the body's centre of mass. A rocker's pivot at the body is close to it, and the
//! differential makes the moments on both rockers equal: no twist. The body of a triple bogie stands
//! on three hinges, which take none, either. A body that is fixed to two four-bars makes it
//! undetermined how they share its moment.

use super::arms::Arms;
use super::equilibrium::Equilibrium;
use super::loads::{Load, Loads};
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Bar, Carrier, Robot, Suspension, Vec2};

/// Standard deviations of the loads on the body by the other side that no reading shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OtherSide {
    /// N.
    share: f64,
    /// N m.
    twist: f64,
}

impl OtherSide {
    /// For a side of this nominal robot of whose weight a `part` moves to the other side, as a standard
    /// deviation.
    pub fn new(robot: &Robot, part: f64) -> Self {
        let share = part * 3.0 * robot.mean_wheel_load();
        Self {
            share,
            twist: match robot.geometry.suspension {
                Suspension::FourBar => {
                    let between = robot.geometry.pins.p - robot.geometry.pins.s;
                    // Uniform.
                    share * robhaz_model::sqrt(between.norm_squared() / 12.0)
                }
                Suspension::Bogie { .. } => 0.0,
            },
        }
    }

    /// Covariance of share and twist in the rows of eq. (8), N^2, for links at `arms` and moment
    /// rows divided by `lever`, m.
    pub fn of_loads(&self, arms: &Arms, carriers: &[Carrier; 3], lever: f64) -> Matrix4<f64> {
        let share = on_body(arms, carriers, lever, Vec2::new(0.0, self.share), 0.0);
        let twist = on_body(arms, carriers, lever, Vec2::zeros(), self.twist);
        share * share.transpose() + twist * twist.transpose()
    }

    /// Rows of eq. (8) of a push of 1 N, for links at `arms` and moment rows divided by `lever`, m.
    pub fn by_push(arms: &Arms, carriers: &[Carrier; 3], lever: f64) -> Vector4<f64> {
        on_body(arms, carriers, lever, Vec2::x(), 0.0)
    }
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
