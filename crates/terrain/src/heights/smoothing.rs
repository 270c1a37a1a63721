//! Takes short waves out of measured heights.

use crate::Vec2;

/// Width of a window over the length of the waves that the smoothing halves: (sin(pi w)/(pi w))^3 =
/// 1/2.
const WIDTH: f64 = 0.366_063_256_638;
/// So many windows one after the other: near enough to a Gaussian that no wave comes back upside
/// down with more than 1.1 %.
const PASSES: usize = 3;

/// Points whose heights are the mean over a window about each, three times over; `length` above 0, m.
///
/// Between points the ground is straight, before the first and after the last it is level. A wave
/// of wavelength l comes back with (sin(a)/a)^3 of its amplitude, a = pi w/l: a half at l =
/// `length`, 85 % at twice it, 3 % at half of it.
pub(crate) fn smoothed(points: &[Vec2], length: f64) -> Vec<Vec2> {
    (0..PASSES).fold(points.to_vec(), |smooth, _| {
        averaged(&smooth, 0.5 * WIDTH * length)
    })
}

/// Means over `half` to both sides of each point.
fn averaged(points: &[Vec2], half: f64) -> Vec<Vec2> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    // Integral of the height over the first one, from the first point to each.
    let mut sums = Vec::with_capacity(points.len());
    let mut sum = 0.0;
    sums.push(sum);
    for pair in points.windows(2) {
        sum += (pair[1].x - pair[0].x) * (0.5 * (pair[0].y + pair[1].y) - first.y);
        sums.push(sum);
    }
    // The same up to any x; `piece` is the piece that x was on last, and x never falls.
    let up_to = |x: f64, piece: &mut usize| {
        if x <= first.x {
            return 0.0;
        }
        if x >= last.x {
            return sum + (x - last.x) * (last.y - first.y);
        }
        while points[*piece + 1].x < x {
            *piece += 1;
        }
        let (a, b) = (points[*piece], points[*piece + 1]);
        let s = x - a.x;
        sums[*piece] + s * (a.y - first.y + 0.5 * s * (b.y - a.y) / (b.x - a.x))
    };
    let (mut rear, mut front) = (0, 0);
    let mean = |p: &Vec2| {
        let area = up_to(p.x + half, &mut front) - up_to(p.x - half, &mut rear);
        Vec2::new(p.x, first.y + area / (2.0 * half))
    };
    points.iter().map(mean).collect()
}
