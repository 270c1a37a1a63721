//! The ground's height over x, with slope and curvature in closed form.

use std::f64::consts::PI;

/// One Gaussian bump (or hollow) `height exp(-((x - centre)/width)^2)`; m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// Where the summit is, m.
    pub centre: f64,
    /// Half width at 1/e of the height, m.
    pub width: f64,
}

/// The shape of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// Level ground at y = 0.
    Flat,
    /// A sum of Gaussian bumps on level ground.
    Bumps(Vec<Bump>),
    /// `height/2 (1 + cos(pi (x - centre)/half_width))` for `|x - centre| < half_width`, level elsewhere; m.
    ///
    /// Its curvature jumps where it meets the level ground.
    CosBump {
        /// Height of the summit, m; negative for a hollow.
        height: f64,
        /// Where the summit is, m.
        centre: f64,
        /// Half of the bump's length, m.
        half_width: f64,
    },
}

/// Why a profile cannot be ground.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// A number is not finite.
    #[error("bump {bump}: {entry} is not a finite number")]
    NotFinite {
        /// Which bump, from 0.
        bump: usize,
        /// Which of its numbers.
        entry: &'static str,
    },
    /// A width is not above zero.
    #[error("bump {bump}: the width is {found} m; it must be above 0")]
    Width {
        /// Which bump, from 0.
        bump: usize,
        /// What was found, m.
        found: f64,
    },
}

/// Square of the distance from a bump's centre, in widths, beyond which it counts as level ground.
const FADED: f64 = 40.0;

impl Profile {
    /// Profile `smooth`: stands for the paper's "relatively smooth geometric profile", which was not published.
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

    /// Profile `cosbump`: one cosine bump, 60 mm high and 0.70 m long, around x = 1.2 m.
    pub fn cosbump() -> Self {
        Self::CosBump {
            height: 0.06,
            centre: 1.2,
            half_width: 0.35,
        }
    }

    /// Whether the numbers describe a ground.
    ///
    /// # Errors
    /// The first [`ProfileError`] found.
    pub fn check(&self) -> Result<(), ProfileError> {
        let check = |bump, height: f64, centre: f64, width: f64| {
            for (entry, value) in [("height", height), ("centre", centre), ("width", width)] {
                if !value.is_finite() {
                    return Err(ProfileError::NotFinite { bump, entry });
                }
            }
            if width <= 0.0 {
                return Err(ProfileError::Width { bump, found: width });
            }
            Ok(())
        };
        match self {
            Self::Flat => Ok(()),
            Self::Bumps(bumps) => bumps
                .iter()
                .enumerate()
                .try_for_each(|(i, b)| check(i, b.height, b.centre, b.width)),
            Self::CosBump {
                height,
                centre,
                half_width,
            } => check(0, *height, *centre, *half_width),
        }
    }

    /// Height (m), slope (-) and second derivative (1/m) at x.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        match self {
            Self::Flat => [0.0; 3],
            Self::Bumps(bumps) => {
                let mut sum = [0.0; 3];
                for b in bumps {
                    let u = (x - b.centre) / b.width;
                    // exp(-40) is below the rounding of any height that matters.
                    if u * u > FADED {
                        continue;
                    }
                    let e = b.height * (-u * u).exp();
                    sum[0] += e;
                    sum[1] -= 2.0 * u / b.width * e;
                    sum[2] += (4.0 * u * u - 2.0) / (b.width * b.width) * e;
                }
                sum
            }
            Self::CosBump {
                height,
                centre,
                half_width,
            } => {
                let u = (x - centre) / half_width;
                if u.abs() > 1.0 {
                    return [0.0; 3];
                }
                let (k, half) = (PI / half_width, 0.5 * height);
                let (sin, cos) = (PI * u).sin_cos();
                [half * (1.0 + cos), -half * k * sin, -half * k * k * cos]
            }
        }
    }

    /// The stretch of x outside of which the ground is level (a bump has faded long before 8 widths from its centre), and the spacing of knots
    /// on it that no bend slips through; m. `None` for level ground.
    pub(crate) fn extent(&self) -> Option<(f64, f64, f64)> {
        /// Knots no farther apart than this, m: fine enough that a wheel's nearest point is alone on its edge.
        const SPACING: f64 = 0.01;
        match self {
            Self::Flat => None,
            Self::Bumps(bumps) => bumps
                .iter()
                .map(|b| {
                    (
                        b.centre - 8.0 * b.width,
                        b.centre + 8.0 * b.width,
                        b.width / 10.0,
                    )
                })
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1), a.2.min(b.2)))
                .map(|(from, to, h)| (from, to, h.min(SPACING))),
            Self::CosBump {
                centre, half_width, ..
            } => Some((
                centre - half_width,
                centre + half_width,
                SPACING.min(half_width / 20.0),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form against central differences: error of the second difference at h = 1e-5 is below 1e-5 for these bumps.
    #[test]
    fn derivatives_match_differences() {
        for profile in [Profile::smooth(), Profile::cosbump()] {
            for i in 0..400 {
                let x = 0.2 + 0.008_71 * f64::from(i);
                let h = 1e-5;
                let (m, p) = (profile.eval(x - h), profile.eval(x + h));
                let [_, slope, bend] = profile.eval(x);
                assert!(
                    (slope - (p[0] - m[0]) / (2.0 * h)).abs() < 1e-7,
                    "slope at {x}"
                );
                assert!(
                    (bend - (p[1] - m[1]) / (2.0 * h)).abs() < 1e-5,
                    "bend at {x}"
                );
            }
        }
    }

    #[test]
    fn impossible_bumps_are_refused() {
        let bad = Profile::Bumps(vec![Bump {
            height: 0.1,
            centre: 0.0,
            width: 0.0,
        }]);
        assert_eq!(
            bad.check(),
            Err(ProfileError::Width {
                bump: 0,
                found: 0.0
            })
        );
    }
}
