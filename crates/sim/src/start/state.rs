//! The state from which an engine starts.

use crate::mechanics::State;
use crate::setup::PlantSetup;
use crate::truth::BarTruth;
use robhaz_model::{Bar, Vec2};

/// State at time zero, the same for both engines. Wheel spins count from here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    /// Coordinates and rates.
    pub state: State,
    /// Integrals of the speed errors, rad.
    pub integrals: [f64; 3],
    /// Pose and rates of each bar in this state, in the order of [`Bar::ALL`].
    pub bars: [BarTruth; 4],
}

impl Start {
    /// The nominal pose at rest, lowered by the penetration under the mean wheel load, on any
    /// ground.
    pub fn nominal(setup: &PlantSetup) -> Self {
        let geometry = &setup.robot.geometry;
        let lowered = Vec2::new(0.0, -setup.mean_penetration());
        Self {
            state: State {
                q: geometry.pins.q + lowered,
                ..State::default()
            },
            integrals: [0.0; 3],
            bars: Bar::ALL.map(|bar| BarTruth {
                position: geometry.cg(bar) + lowered,
                ..BarTruth::default()
            }),
        }
    }
}
