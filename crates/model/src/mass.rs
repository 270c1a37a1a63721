//! Masses and inertias, and the point masses of the static equilibrium.

use crate::Bar;

/// Masses (kg) and inertias (kg m^2) of one side. Every inertia is about the part's own centre of
/// mass.
#[derive(Clone, Debug, PartialEq)]
pub struct MassSet {
    /// Half of the real body, kg.
    pub body: f64,
    /// Links 1 to 3 without wheels, kg; link 3 of a bogie has none.
    pub links: [f64; 3],
    /// Each wheel module, kg.
    pub wheel: f64,
    /// Inertia of the body, kg m^2.
    pub body_inertia: f64,
    /// Inertia of links 1 to 3, kg m^2.
    pub link_inertias: [f64; 3],
    /// J_wheel: inertia of the wheel's disc, kg m^2. It resists the wheel's absolute angular
    /// acceleration.
    pub wheel_inertia: f64,
    /// J_rotor: inertia of the drive's rotor, reflected through the gear, kg m^2. It resists the
    /// angular acceleration relative to the link.
    pub rotor_inertia: f64,
}

/// Reason why a mass set is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{entry} is {found}; it must be a finite number above 0")]
pub struct MassError {
    /// Name of the invalid entry.
    pub entry: &'static str,
    /// Its value.
    pub found: f64,
}

impl MassSet {
    /// Rotor inertia at the wheel: 135 g cm^2 through the 80:1 gear, kg m^2.
    pub const ROTOR_INERTIA: f64 = 135e-7 * 80.0 * 80.0;

    /// Mass set `caption`, the default: the masses that the captions of Figs. 7 and 8 imply (body 5
    /// kg, wheels 1.5 kg each, links 4.5 kg in all). The links' shares and the inertias are chosen,
    /// not published.
    pub fn caption() -> Self {
        Self {
            body: 5.0,
            links: [1.8, 2.2, 0.5],
            wheel: 1.5,
            body_inertia: 0.076,
            link_inertias: [0.018, 0.0225, 0.0004],
            wheel_inertia: 0.0075,
            rotor_inertia: Self::ROTOR_INERTIA,
        }
    }

    /// Mass (kg) and inertia (kg m^2) of a bar without wheels.
    pub fn of(&self, bar: Bar) -> (f64, f64) {
        let ([a, b, c], [i, j, k]) = (self.links, self.link_inertias);
        [(self.body, self.body_inertia), (a, i), (b, j), (c, k)][bar as usize]
    }

    /// Mass set `text`: half of the masses that the paper's text states for both sides: body 10 kg,
    /// wheels 10 kg, linkage 8 kg.
    pub fn text() -> Self {
        Self {
            links: [1.6, 1.9556, 0.4444],
            wheel: 1.6667,
            ..Self::caption()
        }
    }

    /// Mass of one side, kg.
    pub fn total(&self) -> f64 {
        self.body + self.links.iter().sum::<f64>() + 3.0 * self.wheel
    }

    /// Checks that every mass and inertia is a finite number above zero; of link 3, that both are,
    /// or both zero, as those of a bogie.
    ///
    /// # Errors
    /// A [`MassError`] with the first entry that is not.
    pub fn check(&self) -> Result<(), MassError> {
        let has_link3 = self.links[2] != 0.0 || self.link_inertias[2] != 0.0;
        let entries = [
            ("body", self.body),
            ("links[0]", self.links[0]),
            ("links[1]", self.links[1]),
            ("links[2]", self.links[2]),
            ("wheel", self.wheel),
            ("body_inertia", self.body_inertia),
            ("link_inertias[0]", self.link_inertias[0]),
            ("link_inertias[1]", self.link_inertias[1]),
            ("link_inertias[2]", self.link_inertias[2]),
            ("wheel_inertia", self.wheel_inertia),
            ("rotor_inertia", self.rotor_inertia),
        ];
        for (entry, found) in entries {
            if !has_link3 && entry.ends_with("[2]") {
                continue;
            }
            if !(found > 0.0 && found.is_finite()) {
                return Err(MassError { entry, found });
            }
        }
        Ok(())
    }

    /// Every mass at its own place, as the estimator `true-mass` uses them.
    pub fn true_points(&self) -> PointMasses {
        PointMasses {
            body: self.body,
            links: self.links,
            wheel: self.wheel,
        }
    }

    /// Fig. 7: the mass of links 1 to 3 is moved to the body's centre of mass.
    pub fn lumped_to_body(&self) -> PointMasses {
        PointMasses {
            body: self.body + self.links.iter().sum::<f64>(),
            links: [0.0; 3],
            wheel: self.wheel,
        }
    }

    /// Fig. 8: the mass of links 1 to 3 is distributed evenly to the wheels.
    pub fn lumped_to_wheels(&self) -> PointMasses {
        PointMasses {
            body: self.body,
            links: [0.0; 3],
            wheel: self.wheel + self.links.iter().sum::<f64>() / 3.0,
        }
    }
}

/// Masses whose weights act in the static equilibrium, kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMasses {
    /// Mass at the body's centre of mass.
    pub body: f64,
    /// Masses at the centres of mass of links 1 to 3.
    pub links: [f64; 3],
    /// Mass at each axle.
    pub wheel: f64,
}
