//! Points of equal x: vertical risers, in the order of the ground.

use crate::Vec2;
use crate::heights::Interpolation;
use crate::shape::ProfileError;

/// Whether a ground can go through points (m), x not falling: points of equal x are a riser, which only corners have,
/// and which smoothing would make a ramp of.
///
/// # Errors
/// [`ProfileError`] with the place of the first riser that this ground cannot have.
pub fn check_risers(
    points: &[Vec2],
    interpolation: Interpolation,
    smoothing: f64,
) -> Result<(), ProfileError> {
    let mut at = points.windows(2).filter(|w| is_same_x(w[0], w[1]));
    let Some(first) = at.next() else {
        return Ok(());
    };
    let found = format!(
        "found two points at x = {} m, heights {} and {} m: a riser",
        first[0].x, first[0].y, first[1].y
    );
    if interpolation != Interpolation::Corners {
        return Err(ProfileError(format!(
            "{found}; allowed: interpolation = \"corners\", or each x once"
        )));
    }
    if smoothing > 0.0 {
        return Err(ProfileError(format!(
            "{found}, which smoothing would make a ramp of; allowed: smoothing = 0, or each x once"
        )));
    }
    let is_spike =
        |w: &&[Vec2]| is_same_x(w[0], w[2]) && (w[1].y - w[0].y) * (w[2].y - w[1].y) < 0.0;
    match points.windows(3).find(is_spike) {
        Some(w) => Err(ProfileError(format!(
            "found a wall of no width at x = {} m, heights {}, {} and {} m; allowed: of points of one x a riser, up or down",
            w[0].x, w[0].y, w[1].y, w[2].y
        ))),
        None => Ok(()),
    }
}

/// Points in the order of x. Points of one x keep the order in which the ground passes them, which neighbouring lines
/// show; the same point again is left out.
///
/// # Errors
/// What was found, and what is allowed: two points of one x whose order their lines do not show, or a height that goes
/// to and fro only because lines run back.
pub fn sorted(points: &[Vec2]) -> Result<Vec<Vec2>, String> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a].x.total_cmp(&points[*b].x));
    let mut sorted: Vec<usize> = Vec::with_capacity(points.len());
    for group in order.chunk_by(|a, b| is_same_x(points[*a], points[*b])) {
        let mut group = group.to_vec();
        let [first, .., last] = group[..] else {
            sorted.extend(group);
            continue;
        };
        let x = points[first].x;
        if let Some(other) = group.iter().find(|i| points[**i] != points[first]) {
            let before = first.checked_sub(1).map(|i| points[i].x);
            let after = points.get(last + 1).map(|p| p.x);
            let is_forward = before.is_some_and(|b| b < x) || after.is_some_and(|a| a > x);
            let is_backward = before.is_some_and(|b| b > x) || after.is_some_and(|a| a < x);
            let are_neighbours = last - first + 1 == group.len();
            if is_forward == is_backward || !are_neighbours {
                return Err(format!(
                    "found the heights {} and {} m at x = {x} m in lines whose order does not show which comes first; allowed: a riser in two lines, one after the other, as the ground passes them, or each x once",
                    points[first].y, points[*other].y
                ));
            }
            if is_backward {
                group.reverse();
            }
        }
        for i in group {
            if sorted.last().is_none_or(|last| points[*last] != points[i]) {
                sorted.push(i);
            }
        }
    }
    match (!is_in_no_order(&sorted)).then(|| to_and_fro(points, &sorted)) {
        Some(Some([a, b, c])) => Err(format!(
            "found a height that goes to and fro because lines run back: {} m at x = {} m, {} m at x = {} m, {} m at x = {} m; allowed: one height at each x, without overhangs and points that run back",
            a.y, a.x, b.y, b.x, c.y, c.x
        )),
        _ => Ok(sorted.into_iter().map(|i| points[i]).collect()),
    }
}

/// Whether the lines of points, in the order of x, are in no order: then they say nothing of how the ground runs. Lines
/// in no order are a third of all apart; of few lines they are three apart by an overhang, too.
fn is_in_no_order(lines: &[usize]) -> bool {
    let apart: usize = lines.windows(2).map(|w| w[0].abs_diff(w[1])).sum();
    let count = lines.len().saturating_sub(1);
    6 * apart > lines.len().max(18) * count
}

/// Neighbours in the order of x between which the height rises and falls again, or falls and rises, and which the lines
/// have in another order: an overhang, or a wall that was measured with errors of x. Sorted it is a lower ground.
fn to_and_fro(points: &[Vec2], lines: &[usize]) -> Option<[Vec2; 3]> {
    let at = |i: usize| points[i];
    let rise = |w: &[usize]| at(w[1]).y - at(w[0]).y;
    let steps: Vec<&[usize]> = lines.windows(2).filter(|w| rise(w) != 0.0).collect();
    let turns = steps.windows(2).find(|s| {
        // Between the two steps the height may stay.
        let (a, top, b) = (s[0][0], [s[0][1], s[1][0]], s[1][1]);
        let are_between = |a: usize, b: usize| top.iter().all(|i| a < *i && *i < b);
        rise(s[0]) * rise(s[1]) < 0.0 && !are_between(a, b) && !are_between(b, a)
    })?;
    Some([turns[0][0], turns[0][1], turns[1][1]].map(at))
}

#[expect(clippy::float_cmp, reason = "the same number in the file")]
fn is_same_x(a: Vec2, b: Vec2) -> bool {
    a.x == b.x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(of: &[(f64, f64)]) -> Vec<Vec2> {
        of.iter().map(|(x, y)| Vec2::new(*x, *y)).collect()
    }

    /// A kerb measured forwards, backwards, or in two pieces is the same kerb.
    #[test]
    fn a_riser_keeps_its_order() {
        let kerb = points(&[(0.0, 0.0), (1.5, 0.0), (1.5, 0.05), (3.0, 0.05)]);
        let mut backwards = kerb.clone();
        backwards.reverse();
        let pieces = points(&[(1.5, 0.0), (1.5, 0.05), (3.0, 0.05), (0.0, 0.0)]);
        for lines in [&kerb, &backwards] {
            assert_eq!(sorted(lines).as_ref(), Ok(&kerb));
        }
        assert_eq!(sorted(&pieces), Ok(kerb.clone()));
        // Twice the same ground is the same ground; its risers are of lines that are no neighbours.
        let level = points(&[(0.0, 0.1), (1.0, 0.2), (0.0, 0.1), (1.0, 0.2)]);
        assert_eq!(sorted(&level), Ok(points(&[(0.0, 0.1), (1.0, 0.2)])));
        let apart = points(&[(1.5, 0.05), (0.0, 0.0), (1.5, 0.0), (3.0, 0.05)]);
        assert!(sorted(&apart).is_err());
    }

    /// Closed forms: an overhang, a loop and a kerb that was measured with errors of x are no ground of one height at
    /// each x; the same points in no order at all may be one.
    #[test]
    fn a_height_does_not_go_to_and_fro() {
        let overhang = points(&[(0.0, 0.0), (1.5, 0.0), (1.48, 0.05), (3.0, 0.05)]);
        let up = [(0.0, 0.0), (1.5, 0.0), (1.7, 0.05), (1.4, 0.1), (3.0, 0.1)];
        // The height stays on both ways.
        let flat = [(0.0, 0.0), (1.495, 0.0), (1.5, 0.0)];
        let flat = [flat.as_slice(), &[(1.48, 0.05), (1.49, 0.05), (3.0, 0.05)]].concat();
        for lines in [overhang, points(&up), points(&flat)] {
            let mut backwards = lines.clone();
            backwards.reverse();
            for lines in [lines, backwards] {
                assert!(sorted(&lines).is_err_and(|e| e.contains("to and fro")));
            }
        }
        // Points every 2 cm and 2 mm up the wall, with errors of x of some mm; without the wall.
        let error = |i: u32| 0.003 * f64::from(i * 7 % 11) - 0.015;
        let wall = |i: u32| Vec2::new(1.5 + error(i), 0.002 * f64::from(i));
        let x = |i: u32| Vec2::new(0.02 * f64::from(i), if i < 76 { 0.0 } else { 0.05 });
        let kerb: Vec<Vec2> = (0..75)
            .map(x)
            .chain((0..25).map(wall))
            .chain((76..150).map(x))
            .collect();
        assert!(sorted(&kerb).is_err());
        let level: Vec<Vec2> = (0..150)
            .map(|i| Vec2::new(x(i).x + 3.0 * error(i), 0.0))
            .collect();
        assert!(sorted(&level).is_ok());
        // Rough ground, its points in no order: 67 and 150 have no common divisor.
        let rough = |i: u32| Vec2::new(x(i).x, 0.01 * f64::from(i).sin());
        let shuffled: Vec<Vec2> = (0..150).map(|i| rough(i * 67 % 150)).collect();
        assert_eq!(sorted(&shuffled), Ok((0..150).map(rough).collect()));
    }

    #[test]
    fn only_corners_have_risers() {
        let kerb = points(&[(0.0, 0.0), (1.5, 0.0), (1.5, 0.05), (3.0, 0.05)]);
        let corners = Interpolation::Corners;
        assert!(check_risers(&kerb, corners, 0.0).is_ok());
        assert!(check_risers(&kerb, corners, 0.02).is_err());
        assert!(check_risers(&kerb, Interpolation::Monotone, 0.0).is_err());
        let wall = points(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.3), (1.0, 0.0), (2.0, 0.0)]);
        assert!(check_risers(&wall, corners, 0.0).is_err());
    }
}
