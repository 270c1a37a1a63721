//! One colour for one thing, everywhere. Okabe and Ito's palette: told apart with any colour vision.

use re_sdk_types::components::Color;

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Colour(pub [u8; 3]);

/// Front wheel blue, middle vermilion, rear bluish green.
pub(crate) const WHEELS: [Colour; 3] = [
    Colour([0x00, 0x72, 0xB2]),
    Colour([0xD5, 0x5E, 0x00]),
    Colour([0x00, 0x9E, 0x73]),
];
/// Pins P, Q, R, S: reddish purple, orange, sky blue, yellow.
pub(crate) const PINS: [Colour; 4] = [
    Colour([0xCC, 0x79, 0xA7]),
    Colour([0xE6, 0x9F, 0x00]),
    Colour([0x56, 0xB4, 0xE9]),
    Colour([0xF0, 0xE4, 0x42]),
];
/// The body and link 3, which carry no wheel.
pub(crate) const BODY: Colour = Colour([0xB0, 0xB0, 0xB0]);
/// Links 1 and 2, which carry the wheels.
pub(crate) const LINKS: [Colour; 3] =
    [Colour([0xE0, 0xE0, 0xE0]), Colour([0x90, 0x90, 0x90]), BODY];
/// The ground.
pub(crate) const GROUND: Colour = Colour([0x8A, 0x7F, 0x70]);
/// What belongs to no wheel.
pub(crate) const NEUTRAL: Colour = Colour([0xA0, 0xA0, 0xA0]);
const WHITE: Colour = Colour([0xFF; 3]);
const BLACK: Colour = Colour([0; 3]);

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

    /// The shade of an estimator, by its place in the scene.
    pub(crate) fn estimator(self, place: usize) -> Self {
        let (other, share) = [(WHITE, 0.35), (BLACK, 0.4), (WHITE, 0.7), (BLACK, 0.6)][place % 4];
        self.mixed(other, share)
    }

    /// The shade of the estimated forces in the scene.
    pub(crate) fn light(self) -> Self {
        self.mixed(WHITE, 0.6)
    }
}

impl From<Colour> for Color {
    fn from(Colour([r, g, b]): Colour) -> Self {
        Self::from_rgb(r, g, b)
    }
}
