//! Colours, the same in every view. Most are from the palette of Okabe and Ito, which people with
//! any colour vision can distinguish.

use re_sdk_types::components::Color;

/// Red, green and blue, 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Colour(pub [u8; 3]);

/// Wheels: front blue, middle vermilion, rear bluish green.
pub(crate) const WHEELS: [Colour; 3] = [
    Colour([0x00, 0x72, 0xB2]),
    Colour([0xD5, 0x5E, 0x00]),
    Colour([0x00, 0x9E, 0x73]),
];
/// Estimators by their index in the scene. The order is that of the figures: purple, amber, grey,
/// white (black in a light picture). None is blue, which is the front wheel's colour.
const OTHERS: [Colour; 6] = [
    Colour([0xCC, 0x79, 0xA7]),
    Colour([0xE6, 0x9F, 0x00]),
    Colour([0x9A, 0x9A, 0x9A]),
    Colour([0xFF, 0xFF, 0xFF]),
    Colour([0xF0, 0xE4, 0x42]),
    Colour([0xA6, 0x8C, 0xE8]),
];
/// Pins, which have labels.
pub(crate) const PIN: Colour = Colour([0xF0, 0xF0, 0xF0]);
/// Paths of the pins.
pub(crate) const TRAIL: Colour = Colour([0x70, 0x70, 0x70]);
/// The body.
pub(crate) const BODY: Colour = Colour([0xB0, 0xB0, 0xB0]);
/// Links 1, 2 and 3. Links 1 and 2 carry the wheels of geometry A and B.
pub(crate) const LINKS: [Colour; 3] =
    [Colour([0xE0, 0xE0, 0xE0]), Colour([0x90, 0x90, 0x90]), BODY];
/// The ground.
pub(crate) const GROUND: Colour = Colour([0x8A, 0x7F, 0x70]);
/// Scales, end stops and events of no wheel.
pub(crate) const NEUTRAL: Colour = Colour([0xA0, 0xA0, 0xA0]);
/// A friction stretch with less friction than elsewhere.
pub(crate) const SLIPPERY: Colour = Colour([0xC8, 0xEC, 0xFF]);
/// A friction stretch with more friction than elsewhere.
pub(crate) const ROUGH: Colour = Colour([0xA0, 0x30, 0x60]);

impl Colour {
    /// A mixture with a `share` (0 to 1) of another colour.
    fn mixed(self, other: Self, share: f32) -> Self {
        let mut out = self.0;
        for (own, far) in out.iter_mut().zip(other.0) {
            let value = f32::from(*own) * (1.0 - share) + f32::from(far) * share;
            // The value lies between two bytes.
            *own = value.round() as u8;
        }
        Self(out)
    }

    /// The shade for a reading of the same quantity.
    pub(crate) fn dark(self) -> Self {
        self.mixed(Self([0; 3]), 0.4)
    }

    /// The shade for an estimate of the same quantity.
    pub(crate) fn light(self) -> Self {
        self.mixed(Self([0xFF; 3]), 0.6)
    }
}

/// The colour of an estimator by its index in the scene.
pub(crate) fn by_index(index: usize) -> Colour {
    OTHERS[index % OTHERS.len()]
}

impl From<Colour> for Color {
    fn from(Colour([r, g, b]): Colour) -> Self {
        Self::from_rgb(r, g, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: an estimator and a wheel differ by at least a quarter of the range in one channel.
    #[test]
    fn no_estimator_has_the_colour_of_a_wheel() {
        for Colour(wheel) in WHEELS {
            for Colour(other) in OTHERS {
                let most = wheel.iter().zip(other).map(|(a, b)| a.abs_diff(b)).max();
                assert!(most >= Some(65), "{wheel:?} {other:?}");
            }
        }
        let Colour([r, _, b]) = by_index(2);
        // The third estimator, by default `true-mass`, is grey: blue would be taken for the front
        // wheel.
        assert_eq!(r, b);
    }
}
