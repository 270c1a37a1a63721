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
/// Two points of one x whose order their lines do not show.
pub fn sorted(points: &[Vec2]) -> Result<Vec<Vec2>, (Vec2, Vec2)> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a].x.total_cmp(&points[*b].x));
    let mut sorted: Vec<Vec2> = Vec::with_capacity(points.len());
    for group in order.chunk_by(|a, b| is_same_x(points[*a], points[*b])) {
        let mut group = group.to_vec();
        let [first, .., last] = group[..] else {
            sorted.extend(group.iter().map(|i| points[*i]));
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
                return Err((points[first], points[*other]));
            }
            if is_backward {
                group.reverse();
            }
        }
        for i in group {
            if sorted.last() != Some(&points[i]) {
                sorted.push(points[i]);
            }
        }
    }
    Ok(sorted)
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
