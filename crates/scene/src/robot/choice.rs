//! The robot that a file states.

use crate::robot::across::Across;
use robhaz_model::{Carrier, Robot, Suspension, Vec2, WholeRover, named};

/// The robot, and the names under which its parts were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotChoice {
    /// `A`, `B`, `C`, the path of a geometry file, or `inline`; with `, changed` when an override
    /// changed a part of it.
    pub geometry_name: String,
    /// `caption`, `text`, the path of a mass file, or `inline`; with `, changed` as above.
    pub mass_name: String,
    /// Geometry and masses.
    pub robot: Robot,
    /// `suspension.kind`.
    pub(super) suspension: SuspensionKind,
    /// `suspension.body`: the link that the body of a bogie is fixed to.
    pub(super) body: Option<Carrier>,
    /// Steering as a file states it; the links of [`Self::robot`] have it.
    pub(super) steering: Steering,
    /// `[robot.across]`
    pub(super) across: Option<Across>,
}

named! {
    /// `suspension.kind`
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum SuspensionKind {
        /// Link 3 joins the body to link 2.
        FourBar = "four-bar",
        /// The body is fixed to link 1 or 2.
        Bogie = "bogie",
    }
}

impl RobotChoice {
    /// A robot with names for its geometry and its masses.
    pub fn new(geometry_name: String, mass_name: String, robot: Robot) -> Self {
        let (suspension, body) = match robot.geometry.suspension {
            Suspension::FourBar => (SuspensionKind::FourBar, None),
            Suspension::Bogie { body } => (SuspensionKind::Bogie, Some(body)),
        };
        Self {
            geometry_name,
            mass_name,
            robot,
            suspension,
            body,
            steering: Steering::default(),
            across: None,
        }
    }

    /// The robot after a weighing.
    #[must_use]
    pub fn weighed(&self, robot: Robot) -> Self {
        let names = [&self.geometry_name, &self.mass_name];
        let [geometry, mass] = names.map(|name| format!("{name}, weighed"));
        Self {
            across: self.across.clone(),
            ..Self::new(geometry, mass, robot)
        }
    }

    /// States the lateral place of the body's centre of mass, m, left positive, of a robot that
    /// says what lies across.
    pub fn set_body_place(&mut self, place: f64) {
        if let Some(across) = &mut self.across {
            across.body_place = place;
        }
    }

    /// The rover with both sides, of a file that says what lies across. Its side is
    /// [`Self::robot`].
    pub fn whole_rover(&self) -> Option<WholeRover> {
        Some(self.across.as_ref()?.rover(&self.robot))
    }
}

/// `robot.mass.steering`: what a file states of steering hardware over the wheels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Steering {
    /// At the front, middle and rear wheel, kg.
    pub masses: [f64; 3],
    /// Of its centre of mass, m.
    pub height: Option<f64>,
}

impl Steering {
    /// Height where none is stated, wheel radii: a motor over its wheel, between tyre and link.
    const HEIGHT: f64 = 3.0;

    /// Adds it to the links that carry the wheels. It is theirs from then on.
    pub fn mount(&mut self, robot: &mut Robot) {
        let Self { masses, height } = std::mem::take(self);
        let height = height.unwrap_or(Self::HEIGHT * robot.geometry.wheel_radius);
        for (wheel, mass) in masses
            .into_iter()
            .enumerate()
            .filter(|(_, mass)| *mass > 0.0)
        {
            let at = Vec2::new(robot.geometry.axles[wheel].x, height);
            add(robot, robot.geometry.carriers[wheel], mass, at);
        }
    }
}

/// A point mass becomes a part of a link: the common centre of mass, and the inertia about it.
fn add(robot: &mut Robot, link: Carrier, mass: f64, at: Vec2) {
    let k = match link {
        Carrier::Link1 => 0,
        Carrier::Link2 => 1,
    };
    let (own, centre) = (robot.mass.links[k], robot.geometry.link_cg[k]);
    let (sum, apart) = (own + mass, at - centre);
    robot.mass.links[k] = sum;
    robot.geometry.link_cg[k] = centre + apart * (mass / sum);
    robot.mass.link_inertias[k] += own * mass / sum * apart.norm_squared();
}
