//! One colour for one thing, everywhere. Okabe and Ito's palette: told apart with any colour vision.

use rerun::components::Color;

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Colour(pub [u8; 3]);

/// Front wheel blue, middle vermilion, rear bluish green.
pub(crate) const WHEELS: [Colour; 3] = [
    Colour([0x00, 0x72, 0xB2]),
    Colour([0xD5, 0x5E, 0x00]),
    Colour([0x00, 0x9E, 0x73]),
];
/// Estimators by their place in the scene, and runs by their place in a comparison, in the order of the figures: purple,
/// amber, grey, white (black in a light picture). No blue: the front wheel has it.
const OTHERS: [Colour; 6] = [
    Colour([0xCC, 0x79, 0xA7]),
    Colour([0xE6, 0x9F, 0x00]),
    Colour([0x9A, 0x9A, 0x9A]),
    Colour([0xFF, 0xFF, 0xFF]),
    Colour([0xF0, 0xE4, 0x42]),
    Colour([0xA6, 0x8C, 0xE8]),
];
/// Pins and their trails: labels tell them apart.
pub(crate) const PIN: Colour = Colour([0xF0, 0xF0, 0xF0]);
/// Where the pins have been.
pub(crate) const TRAIL: Colour = Colour([0x70, 0x70, 0x70]);
/// The body and link 3, which carry no wheel.
pub(crate) const BODY: Colour = Colour([0xB0, 0xB0, 0xB0]);
/// Links 1 and 2, which carry the wheels.
pub(crate) const LINKS: [Colour; 3] =
    [Colour([0xE0, 0xE0, 0xE0]), Colour([0x90, 0x90, 0x90]), BODY];
/// The ground.
pub(crate) const GROUND: Colour = Colour([0x8A, 0x7F, 0x70]);
/// What belongs to no wheel.
pub(crate) const NEUTRAL: Colour = Colour([0xA0, 0xA0, 0xA0]);
const ICE: Colour = Colour([0xC8, 0xEC, 0xFF]);
const RUBBER: Colour = Colour([0xA0, 0x30, 0x60]);

impl Colour {
    /// A mixture with `share` (0 to 1) of another colour.
    fn mixed(self, other: Self, share: f32) -> Self {
        let mut out = self.0;
        for (own, far) in out.iter_mut().zip(other.0) {
            let value = f32::from(*own) * (1.0 - share) + f32::from(far) * share;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between two bytes"
            )]
            {
                *own = value.round() as u8;
            }
        }
        Self(out)
    }

    /// The shade of what is estimated of the same thing.
    pub(crate) fn light(self) -> Self {
        self.mixed(Self([0xFF; 3]), 0.6)
    }
}

/// The colour of an estimator by its place in the scene; of a run by its place in a comparison.
pub(crate) fn by_place(place: usize) -> Colour {
    OTHERS[place % OTHERS.len()]
}

/// Every colour of wheels, estimators and runs that is no grey.
pub(crate) fn hues() -> impl Iterator<Item = Colour> {
    let all = WHEELS.into_iter().chain(OTHERS);
    all.filter(|Colour([r, g, b])| !(r == g && g == b))
}

/// The colour of a stretch of ground: the less friction beside the rest of the ground, the more like ice; the more, the more
/// like rubber.
pub(crate) fn stretch(mu: f64, elsewhere: f64) -> Colour {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a share between zero and one"
    )]
    let share = |difference: f64, whole: f64| (difference / whole).clamp(0.0, 1.0) as f32;
    if mu < elsewhere {
        GROUND.mixed(ICE, 0.4 + 0.6 * share(elsewhere - mu, elsewhere))
    } else {
        GROUND.mixed(RUBBER, 0.4 + 0.6 * share(mu - elsewhere, 1.0))
    }
}

impl From<Colour> for Color {
    fn from(Colour([r, g, b]): Colour) -> Self {
        Self::from_rgb(r, g, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An estimator and a wheel differ by at least a quarter of the range in one channel, whatever the estimator's place.
    #[test]
    fn no_estimator_has_the_colour_of_a_wheel() {
        for Colour(wheel) in WHEELS {
            for Colour(other) in OTHERS {
                let most = wheel.iter().zip(other).map(|(a, b)| a.abs_diff(b)).max();
                assert!(most >= Some(65), "{wheel:?} {other:?}");
            }
        }
        let Colour([r, _, b]) = by_place(2);
        // The third estimator, `true-mass` by default, is not blue.
        assert_eq!(r, b);
    }
}
