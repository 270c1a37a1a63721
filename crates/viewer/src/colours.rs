//! Colours, the same in every view. Most are from the palette of Okabe and Ito, which people with
//! any colour vision can distinguish.

use re_sdk_types::components::Color;
use re_sdk_types::datatypes::Rgba32;

/// An opaque colour, red in the highest of three bytes, blue in the lowest.
pub(crate) const fn rgb(bytes: u32) -> Color {
    Color(Rgba32(bytes << 8 | 0xFF))
}

/// Wheels: front blue, middle vermilion, rear bluish green.
pub(crate) const WHEELS: [Color; 3] = [rgb(0x0072B2), rgb(0xD55E00), rgb(0x009E73)];
/// Estimators by their index in the scene. The order is that of the figures: purple, amber, grey,
/// white (black in a light picture). None is blue, which is the front wheel's colour.
const OTHERS: [Color; 6] = [
    rgb(0xCC79A7),
    rgb(0xE69F00),
    rgb(0x9A9A9A),
    rgb(0xFFFFFF),
    rgb(0xF0E442),
    rgb(0xA68CE8),
];
/// Pins, which have labels.
pub(crate) const PIN: Color = rgb(0xF0F0F0);
/// Paths of the pins.
pub(crate) const TRAIL: Color = rgb(0x707070);
/// The body.
pub(crate) const BODY: Color = rgb(0xB0B0B0);
/// Links 1, 2 and 3. Links 1 and 2 carry the wheels of geometry A and B.
pub(crate) const LINKS: [Color; 3] = [rgb(0xE0E0E0), rgb(0x909090), BODY];
/// The ground.
pub(crate) const GROUND: Color = rgb(0x8A7F70);
/// Scales, end stops and events of no wheel.
pub(crate) const NEUTRAL: Color = rgb(0xA0A0A0);
/// A friction stretch with less friction than elsewhere.
pub(crate) const SLIPPERY: Color = rgb(0xC8ECFF);
/// A friction stretch with more friction than elsewhere.
pub(crate) const ROUGH: Color = rgb(0xA03060);

/// A mixture with a `share` (0 to 1) of a grey, 0 to 255.
fn mixed(colour: Color, grey: f32, share: f32) -> Color {
    // The values lie between two bytes.
    let mix = |own: u8| (f32::from(own) * (1.0 - share) + grey * share).round() as u8;
    let [r, g, b, _] = colour.to_array();
    Color::from_rgb(mix(r), mix(g), mix(b))
}

/// The shade for a reading of the same quantity.
pub(crate) fn dark(colour: Color) -> Color {
    mixed(colour, 0.0, 0.4)
}

/// The shade for an estimate of the same quantity.
pub(crate) fn light(colour: Color) -> Color {
    mixed(colour, 255.0, 0.6)
}

/// The colour of an estimator by its index in the scene.
pub(crate) fn by_index(index: usize) -> Color {
    OTHERS[index % OTHERS.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: an estimator and a wheel differ by at least a quarter of the range in one channel.
    #[test]
    fn no_estimator_has_the_colour_of_a_wheel() {
        for wheel in WHEELS.map(Color::to_array) {
            for other in OTHERS.map(Color::to_array) {
                let most = wheel.iter().zip(other).map(|(a, b)| a.abs_diff(b)).max();
                assert!(most >= Some(65), "{wheel:?} {other:?}");
            }
        }
        let [r, _, b, _] = by_index(2).to_array();
        // The third estimator, by default `true-mass`, is grey: blue would be taken for the front
        // wheel.
        assert_eq!(r, b);
    }
}
