//! The robot that a file states.

use crate::robot::across::Across;
use crate::robot::steering::Steering;
use robhaz_model::{Carrier, Robot, Suspension, WholeRover, named};

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
