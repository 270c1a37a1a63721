//! State at time zero: settled on the ground, or raw.
//!
//! Both engines start from the same state. The settled start is a solution of the equations of
//! motion in `mechanics`.

mod equilibrium;
mod state;

use crate::error::PlantError;
use crate::setup::{PlantSetup, StartKind};
use robhaz_model::Vec2;

pub(crate) use state::Start;

impl Start {
    /// The state that the setup asks for.
    ///
    /// # Errors
    /// [`PlantError::RawStart`], [`PlantError::Stance`] and [`PlantError::NoRest`].
    pub fn new(setup: &PlantSetup) -> Result<Self, PlantError> {
        match setup.start {
            StartKind::Raw => raw(setup),
            StartKind::Settled => equilibrium::settled(setup).map_err(|why| {
                // If the robot cannot stand on level ground either, the robot is the reason.
                let stance = setup.robot.check_stance().err();
                stance.map_or(PlantError::NoRest { why }, PlantError::Stance)
            }),
        }
    }
}

/// The nominal pose, if each wheel has contact and is at most 1.5 times as deep as under the mean
/// wheel load.
fn raw(setup: &PlantSetup) -> Result<Start, PlantError> {
    let start = Start::nominal(setup);
    let (rest, radius) = (setup.mean_penetration(), setup.robot.geometry.wheel_radius);
    for (i, axle) in setup.robot.geometry.axles.iter().enumerate() {
        let nearest = setup.terrain.nearest(axle - Vec2::new(0.0, rest));
        let depth = nearest.map_or(f64::NEG_INFINITY, |contact| radius - contact.distance);
        // In this form a NaN is an error, too.
        if !(depth > 0.0 && depth < 1.5 * rest) {
            return Err(PlantError::RawStart {
                wheel: i + 1,
                depth,
                rest,
            });
        }
    }
    Ok(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoRest;
    use robhaz_model::StanceError;
    use robhaz_terrain::{Heights, Interpolation, Profile};

    fn slope(slope: f64) -> Profile {
        let points = [-5.0, 5.0].map(|x| Vec2::new(x, slope * x)).to_vec();
        Profile::Heights(Heights::new(points, Interpolation::Corners))
    }

    fn refusal(setup: &PlantSetup) -> Option<PlantError> {
        Start::new(setup).err()
    }

    /// Each start that fails states its reason.
    #[test]
    fn a_start_that_fails_says_why() {
        assert_eq!(refusal(&PlantSetup::on(Profile::Flat)), None);

        let mut weak = PlantSetup::on(slope(0.2));
        assert_eq!(refusal(&weak), None);
        weak.drive.torque_limit = 0.1;
        let found = refusal(&weak);
        assert!(
            matches!(found, Some(PlantError::NoRest { why: NoRest::Motor { limit, .. } }) if limit < 0.11),
            "{found:?}"
        );

        let mut slippery = PlantSetup::on(slope(0.2));
        slippery.friction.mu_s = 0.1;
        slippery.friction.mu_d = 0.1;
        let found = refusal(&slippery);
        assert!(
            matches!(found, Some(PlantError::NoRest { .. })),
            "{found:?}"
        );

        let mut tipping = PlantSetup::on(Profile::Flat);
        tipping.robot.geometry.body_cg.x = 1.0;
        let found = refusal(&tipping);
        assert!(
            matches!(
                found,
                Some(PlantError::Stance(StanceError::TipsForward { .. }))
            ),
            "{found:?}"
        );

        let mut hollow = PlantSetup::on(slope(0.2));
        hollow.start = StartKind::Raw;
        let found = refusal(&hollow)
            .map(|why| why.to_string())
            .unwrap_or_default();
        assert!(found.contains("must be level"), "{found}");
    }
}
