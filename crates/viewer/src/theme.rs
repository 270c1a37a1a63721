//! Pictures on white, for print.
//!
//! Rerun 0.36 has a light theme. We found no way to select it for a viewer without a window. A light picture is
//! therefore computed from the dark one: greys are inverted, so that the background is white and letters are black.
//! Colours stay.

use crate::colours::{Colour, hues};

/// Background of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Dark, as in the viewer.
    #[default]
    Dark,
    /// White, for print.
    Light,
}

/// Grey value of the dark background, 0 to 255.
const BACKGROUND: f64 = 13.0;

impl Theme {
    /// Converts a pixel (red, green, blue; 0 to 255) of a dark picture to this theme.
    pub(crate) fn pixel(self, pixel: [u8; 3]) -> [u8; 3] {
        match self {
            Self::Dark => pixel,
            Self::Light => light(pixel),
        }
    }
}

/// Converts a pixel of a dark picture to a light one. The pixel is taken for a mixture of one of our colours and a
/// grey, of which the colour stays and the grey is inverted. A pixel that a line covers in part becomes a mixture of
/// the line's colour and white.
fn light(pixel: [u8; 3]) -> [u8; 3] {
    let channels = pixel.map(f64::from);
    let colour = nearest_hue(channels);
    let share = (chroma(channels) / chroma(colour)).min(1.0);
    let covered = channels.iter().sum::<f64>() - share * colour.iter().sum::<f64>();
    let rest = 1.0 - share;
    let grey = if rest > 0.0 {
        covered / (3.0 * rest)
    } else {
        0.0
    };
    // The background becomes white.
    let inverted = 1.0 - ((grey - BACKGROUND) / (255.0 - BACKGROUND)).clamp(0.0, 1.0);
    colour.map(|channel| {
        let mixed = share * channel + rest * 255.0 * inverted;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the value lies between two bytes"
        )]
        let byte = mixed.round().clamp(0.0, 255.0) as u8;
        byte
    })
}

/// Difference of the largest and the smallest channel, 0 for grey.
fn chroma(channels: [f64; 3]) -> f64 {
    let largest = channels.iter().copied().fold(0.0, f64::max);
    largest - channels.iter().copied().fold(255.0, f64::min)
}

/// The one of our colours whose hue is closest to that of a pixel.
fn nearest_hue(pixel: [f64; 3]) -> [f64; 3] {
    let hue = |channels: [f64; 3]| {
        let smallest = channels.iter().copied().fold(255.0, f64::min);
        channels.map(|c| (c - smallest) / chroma(channels).max(1.0))
    };
    let wanted = hue(pixel);
    let distance = |colour: &[f64; 3]| -> f64 {
        let differences = hue(*colour).into_iter().zip(wanted);
        differences.map(|(a, b)| (a - b).powi(2)).sum()
    };
    let ours = hues().map(|Colour(colour)| colour.map(f64::from));
    ours.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or([255.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colours::WHEELS;

    /// Closed form: the background becomes white, and white letters become black. The wheels keep their colours.
    #[test]
    fn greys_are_inverted_and_colours_stay() {
        assert_eq!(light([13, 13, 13]), [255; 3]);
        assert_eq!(light([0, 0, 0]), [255; 3]);
        assert_eq!(light([255, 255, 255]), [0; 3]);
        for Colour(colour) in WHEELS {
            assert_eq!(light(colour), colour);
            assert_eq!(Theme::Dark.pixel(colour), colour);
        }
    }

    /// Closed form: the edge of a blue line, half covered, is the mean of blue and white.
    #[test]
    fn edges_of_lines_fade_to_white() {
        let Colour(blue) = WHEELS[0];
        let edge = light(blue.map(|c| c / 2)).map(f64::from);
        // Half of the line and half of white. One count of rounding in a channel of 178 changes the share by 0.6 %.
        for (found, channel) in edge.into_iter().zip(blue) {
            assert!(
                (found - 0.5 * (f64::from(channel) + 255.0)).abs() < 3.0,
                "{edge:?}"
            );
        }
    }
}
