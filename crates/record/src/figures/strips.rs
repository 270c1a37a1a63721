//! The strips of the path's figure, their scale, and the poses that are drawn.

use robhaz_sim::Truth;
use robhaz_terrain::Terrain;
use std::ops::Range;

/// Least distance of two robots that are drawn, m.
const DISTANCE: f64 = 0.85;
/// Largest number of robots drawn; on a long path they stand farther apart.
const MOST: f64 = 12.0;
/// Length of one strip, m, and largest number of strips: a longer path is drawn at a smaller scale.
const STRIP: f64 = 6.0;
const MOST_STRIPS: f64 = 4.0;
/// Greatest height of a strip's plot, px.
const TALLEST: f64 = 520.0;
/// Length of the arrow of a mean static wheel load, m.
pub const MEAN_LOAD_LENGTH: f64 = 0.12;
/// Spacing of the ground's points, m.
pub const SPACING: f64 = 0.005;

/// A part of the ground, m.
pub struct Strip {
    /// Positions along the ground.
    pub x: Range<f64>,
    /// Heights.
    pub y: Range<f64>,
}

/// Divides the ground that is shown, m, into strips for a width in px. Returns them and their common scale, px per m.
pub fn strips(
    poses: &[Truth],
    ground: &Terrain,
    reach: &Range<f64>,
    width: f64,
) -> (Vec<Strip>, f64) {
    let length = reach.end - reach.start;
    let count = (length / STRIP).ceil().clamp(1.0, MOST_STRIPS);
    let each = length / count;
    let mut strips = Vec::new();
    let mut k = 0.0;
    while k < count {
        let from = reach.start + k * each;
        let x = from..from + each;
        strips.push(Strip {
            y: heights(poses, ground, &x),
            x,
        });
        k += 1.0;
    }
    let tallest = strips
        .iter()
        .map(|s| s.y.end - s.y.start)
        .fold(0.0, f64::max);
    let scale = (width / each).min(TALLEST / tallest);
    // Where the height limits the scale, more ground is shown on both sides.
    let more = 0.5 * (width / scale - each);
    for strip in &mut strips {
        strip.x = strip.x.start - more..strip.x.end + more;
    }
    (strips, scale)
}

/// The heights that a strip shows, m: arrows below the ground, robots above it.
fn heights(poses: &[Truth], ground: &Terrain, x: &Range<f64>) -> Range<f64> {
    let ground = ground.outline(x.start, x.end, SPACING);
    let ground = ground.iter().map(|p| p.y);
    let (low, high) = ground.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    let parts = poses.iter().flat_map(|pose| {
        let wheels = pose.wheels.iter().map(|w| w.position);
        let pins = pose.pins.iter().map(|p| p.position);
        wheels.chain(pins).chain([pose.body.position])
    });
    let inside = parts.filter(|p| x.contains(&p.x));
    let top = inside.map(|p| p.y).fold(high, f64::max);
    low - 1.6 * MEAN_LOAD_LENGTH..top + 0.13
}

/// The poses to draw on a path of a length (m): the first, and each that is far enough from the last one drawn.
pub fn robots(poses: &[Truth], length: f64) -> Vec<&Truth> {
    let distance = DISTANCE.max(length / MOST);
    let mut chosen: Vec<&Truth> = Vec::new();
    for pose in poses {
        let far = |last: &&Truth| (pose.body.position - last.body.position).norm() >= distance;
        if chosen.last().is_none_or(far) {
            chosen.push(pose);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Robots do not overlap, and a robot that does not move is drawn once.
    #[test]
    fn robots_stand_apart() {
        let pose = |x: f64| {
            let mut truth = Truth::default();
            truth.body.position.x = x;
            truth
        };
        let poses: Vec<Truth> = (0..=40).map(|k| pose(0.1 * f64::from(k))).collect();
        let drawn: Vec<f64> = robots(&poses, 4.0)
            .iter()
            .map(|p| p.body.position.x)
            .collect();
        assert_eq!(drawn.len(), 5);
        assert!(drawn.windows(2).all(|w| w[1] - w[0] > DISTANCE - 1e-9));
        assert_eq!(robots(&[pose(1.0), pose(1.0)], 1.0).len(), 1);
    }
}
