//! Profiles of the shipped scenes.

use crate::profile::Profile;
use crate::{Bump, CosBump, Ditch, Ramp, Rough, RoughClass, RoughSettings, Sine, Stairs};

impl Profile {
    /// Profile `smooth`, five bumps: it replaces the paper's "relatively smooth geometric profile",
    /// which was not published.
    pub fn smooth() -> Self {
        let bump = |height, centre, width| Bump {
            height,
            centre,
            width,
        };
        Self::Bumps(vec![
            bump(0.050, 1.00, 0.22),
            bump(-0.035, 1.45, 0.20),
            bump(0.040, 1.90, 0.17),
            bump(0.060, 2.50, 0.28),
            bump(-0.030, 2.95, 0.16),
        ])
    }

    /// Profile `cosbump`: [`CosBump::default`].
    pub fn cosbump() -> Self {
        Self::CosBump(CosBump::default())
    }

    /// Profile `ramp`: [`Ramp::default`].
    pub fn ramp() -> Self {
        Self::Ramp(Ramp::default())
    }

    /// Profile `step`: [`Stairs::step`].
    pub fn step() -> Self {
        Self::Stairs(Stairs::step())
    }

    /// Profile `stairs`: [`Stairs::default`].
    pub fn stairs() -> Self {
        Self::Stairs(Stairs::default())
    }

    /// Profile `sine`: [`Sine::default`].
    pub fn sine() -> Self {
        Self::Sine(Sine::default())
    }

    /// Profile `ditch`: [`Ditch::default`].
    pub fn ditch() -> Self {
        Self::Ditch(Ditch::default())
    }

    /// Profile `rough`: [`RoughSettings::default`] with a seed.
    pub fn rough(seed: u64) -> Self {
        let settings = RoughSettings::default();
        Self::Rough(Rough::new(RoughSettings { seed, ..settings }))
    }
}

impl Default for CosBump {
    /// One cosine bump, 60 mm high and 0.70 m long, around x = 1.2 m.
    fn default() -> Self {
        Self {
            height: 0.06,
            centre: 1.2,
            half_width: 0.35,
        }
    }
}

impl Default for Ramp {
    /// An incline of 15 deg, 0.8 m long, from x = 0.7 m.
    fn default() -> Self {
        Self {
            angle: 15.0_f64.to_radians(),
            start: 0.7,
            length: 0.8,
        }
    }
}

impl Stairs {
    /// A kerb of 50 mm at x = 0.7 m.
    pub fn step() -> Self {
        Self {
            rise: 0.05,
            count: 1,
            ..Self::default()
        }
    }
}

impl Default for Stairs {
    /// 4 steps of 80 mm, 300 mm apart, from x = 0.7 m.
    fn default() -> Self {
        Self {
            rise: 0.08,
            run: 0.3,
            count: 4,
            start: 0.7,
        }
    }
}

impl Default for Sine {
    /// 5 waves of 0.5 m, 20 mm from trough to crest, from x = 0.7 m.
    fn default() -> Self {
        Self {
            amplitude: 0.01,
            wavelength: 0.5,
            start: 0.7,
            periods: 5,
        }
    }
}

impl Default for Ditch {
    /// 50 mm deep and 120 mm wide, at x = 0.7 m.
    fn default() -> Self {
        Self {
            depth: 0.05,
            width: 0.12,
            start: 0.7,
        }
    }
}

impl Default for RoughSettings {
    /// Class C, wavelengths from 0.2 m to 10 m; 10 m long from x = 0.7 m, with fades of 1 m.
    fn default() -> Self {
        Self {
            class: RoughClass::C,
            shortest: 0.2,
            longest: 10.0,
            start: 0.7,
            extent: 10.0,
            fade: 1.0,
            seed: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: slope and second derivative against central differences. The bounds cover the
    /// errors of the differences at h = 1e-5 m.
    #[test]
    fn derivatives_match_differences() {
        for profile in [
            Profile::smooth(),
            Profile::cosbump(),
            Profile::sine(),
            Profile::rough(0),
        ] {
            for i in 0..400 {
                let x = 0.2 + 0.008_71 * f64::from(i);
                let h = 1e-5;
                let (m, p) = (profile.eval(x - h), profile.eval(x + h));
                let [_, slope, second] = profile.eval(x);
                assert!(
                    (slope - (p[0] - m[0]) / (2.0 * h)).abs() < 1e-7,
                    "slope at {x}"
                );
                assert!(
                    (second - (p[1] - m[1]) / (2.0 * h)).abs() < 1e-5,
                    "second derivative at {x}"
                );
            }
        }
    }
}
