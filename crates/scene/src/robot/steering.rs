//! `robot.mass.steering`: steering hardware over the wheels.

use robhaz_model::{Carrier, Robot, Vec2};

/// What a file states of it.
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
