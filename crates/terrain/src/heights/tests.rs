//! Tests of ground through points.

use super::*;
use crate::Profile;
use proptest::prelude::*;

fn points(heights: &[f64]) -> Vec<Vec2> {
    let mut x = -0.3;
    let mut next = |y: &f64| {
        // Gaps of several lengths.
        x += 0.05 + 0.1 * (*y * 37.0).rem_euclid(1.0);
        Vec2::new(x, *y)
    };
    heights.iter().map(&mut next).collect()
}

/// Worked out by hand: from 0 to 1 the spline is (3 x - x^3)/2, then its mirror image.
#[test]
fn three_points_by_hand() {
    let given = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)].map(|(x, y)| Vec2::new(x, y));
    let ground = Heights::new(given.to_vec(), Interpolation::Spline);
    for (x, expected) in [
        (0.0, [0.0, 1.5, 0.0]),
        (0.5, [0.6875, 1.125, -1.5]),
        (1.0, [1.0, 0.0, -3.0]),
        (1.5, [0.6875, -1.125, -1.5]),
    ] {
        for (found, expected) in ground.eval(x).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "at {x}: {found}");
        }
    }
}

proptest! {
    /// Property: a spline goes through its points, and slope and curvature have no jump there.
    #[test]
    fn splines_are_smooth(y in proptest::collection::vec(-0.1..0.1_f64, 2..12)) {
        let given = points(&y);
        let ground = Heights::new(given.clone(), Interpolation::Spline);
        for (i, p) in given.iter().enumerate() {
            prop_assert!((ground.eval(p.x)[0] - (p.y - y[0])).abs() < 1e-12);
            if i > 0 && i + 1 < given.len() {
                let (before, after) = (ground.eval(p.x - 1e-9), ground.eval(p.x + 1e-9));
                prop_assert!((before[1] - after[1]).abs() < 1e-5);
                prop_assert!((before[2] - after[2]).abs() < 1e-3);
            }
        }
        let (first, last) = (given[0].x, given[given.len() - 1].x);
        prop_assert!(ground.eval(first)[2].abs() < 1e-12 && ground.eval(last)[2].abs() < 1e-12);
    }
}

#[test]
fn corners_are_straight_between_the_points() {
    let given = vec![
        Vec2::new(1.0, 5.0),
        Vec2::new(2.0, 5.1),
        Vec2::new(4.0, 4.9),
    ];
    let ground = Heights::new(given, Interpolation::Corners);
    for (x, y) in [
        (0.0, 0.0),
        (1.5, 0.05),
        (3.0, 0.0),
        (4.0, -0.1),
        (9.0, -0.1),
    ] {
        assert!((ground.eval(x)[0] - y).abs() < 1e-12, "at {x}");
    }
}

/// Points in between on the straight lines are no corners, 1e-9 m beside them they are.
#[test]
fn points_on_a_straight_line_are_no_corners() {
    let line = |x: f64| {
        Vec2::new(
            x,
            if x < 2.0 {
                100.0 + 0.1 * x
            } else {
                100.6 - 0.2 * x
            },
        )
    };
    let mut points: Vec<Vec2> = (0..=4000).map(|i| line(1e-3 * f64::from(i))).collect();
    let count = |points: &[Vec2]| {
        let ground = Heights::new(points.to_vec(), Interpolation::Corners);
        ground.pieces().1.len()
    };
    assert_eq!(count(&points), 2);
    assert_eq!(count(&points[..2]), 1);
    points[700].y += 1e-9;
    assert_eq!(count(&points), 5);
}

/// Property: between two points the ground stays between their heights and goes one way only;
/// height, slope and second derivative are continuous at every point, also where the level ground
/// joins. Bounds are rounding: heights of 0.1 m, and second derivatives up to 1e4 1/m over steps of
/// 1e-9 m.
mod monotone {
    use super::*;

    proptest! {
        #[test]
        fn ground_has_no_summit_of_its_own(
            y in proptest::collection::vec(-0.1..0.1_f64, 2..12),
            flat in proptest::collection::vec(proptest::bool::ANY, 12),
        ) {
            // Level pieces too, as a measured kerb has them.
            let mut y = y;
            for i in 1..y.len() {
                if flat[i] {
                    y[i] = y[i - 1];
                }
            }
            let given = points(&y);
            let ground = Heights::new(given.clone(), Interpolation::Monotone);
            prop_assert!(ground.overshoot().is_none());
            for pair in given.windows(2) {
                let (a, b) = (pair[0].y - y[0], pair[1].y - y[0]);
                let mut before = a;
                for i in 0..=200 {
                    let x = pair[0].x + (pair[1].x - pair[0].x) * f64::from(i) / 200.0;
                    let [height, slope, _] = ground.eval(x);
                    prop_assert!((height - before) * (b - a) >= -1e-15, "falls back at {x}");
                    prop_assert!(slope * (b - a) >= -1e-12, "slope {slope} at {x}");
                    before = height;
                }
            }
        }

        #[test]
        fn ground_is_twice_differentiable(y in proptest::collection::vec(-0.1..0.1_f64, 2..12)) {
            let given = points(&y);
            let ground = Heights::new(given.clone(), Interpolation::Monotone);
            for p in &given {
                prop_assert!((ground.eval(p.x)[0] - (p.y - y[0])).abs() < 1e-15);
                let (before, after) = (ground.eval(p.x - 1e-9), ground.eval(p.x + 1e-9));
                prop_assert!((before[1] - after[1]).abs() < 1e-4, "{before:?} {after:?}");
                prop_assert!((before[2] - after[2]).abs() < 1e-2, "{before:?} {after:?}");
            }
        }
    }

    /// Convergence: on a sampled hill the error falls with the square of the spacing or faster
    /// where the hill is highest, which is between two points, and with its third power or faster
    /// on the flanks.
    #[test]
    fn finer_points_come_nearer_to_the_hill() {
        let error = |count: u32, from: f64, to: f64| {
            let hill = Profile::Bumps(vec![crate::Bump {
                height: 0.05,
                // The summit lies at the same place between two points.
                centre: 1.0 + 0.3 * 2.0 / f64::from(count),
                width: 0.22,
            }]);
            let x = |i: u32| 2.0 * f64::from(i) / f64::from(count);
            let given = (0..=count).map(|i| Vec2::new(x(i), hill.eval(x(i))[0]));
            let ground = Heights::new(given.collect(), Interpolation::Monotone);
            let places = (0..=2000).map(|i| from + (to - from) * f64::from(i) / 2000.0);
            places
                .map(|x| (ground.eval(x)[0] - hill.eval(x)[0] + hill.eval(0.0)[0]).abs())
                .fold(0.0, f64::max)
        };
        for (from, to, order) in [(0.9, 1.1, 2), (1.15, 1.3, 3)] {
            let (coarse, fine) = (error(40, from, to), error(160, from, to));
            assert!(fine * 4.0_f64.powi(order) < 1.2 * coarse, "{coarse} {fine}");
        }
    }

    /// A kerb with points every 5 cm: the spline swings beyond both levels, the monotone curve does
    /// not.
    #[test]
    fn kerbs_do_not_ring() {
        let kerb = |way| {
            let y = |i: i32| if i < 10 { 0.0 } else { 0.05 };
            let given = (0..20).map(|i| Vec2::new(0.05 * f64::from(i), y(i)));
            Heights::new(given.collect(), way)
        };
        let swing = kerb(Interpolation::Spline).overshoot().expect("it swings");
        assert!(
            swing.share > 0.05 && (swing.x - 0.475).abs() < 0.076,
            "{swing:?}"
        );
        let found = kerb(Interpolation::Spline).eval(swing.x)[0];
        let outside = (found - 0.05).max(-found);
        // Rounding of heights of 5 cm.
        assert!((outside - swing.beyond).abs() < 1e-15, "{swing:?} {found}");
        for i in 0..=1000 {
            let height = kerb(Interpolation::Monotone).eval(1e-3 * f64::from(i))[0];
            assert!((0.0..=0.05 + 1e-16).contains(&height));
        }
    }
}

/// Closed form: waves that are sampled finely come back with (sin(a)/a)^3 of their amplitude, a
/// half at the stated length. The window sees straight pieces between points: 1e-3 at 100 points a
/// wave and three passes.
#[test]
fn smoothing_halves_waves_of_its_length() {
    for (wave, expected) in [(0.1, 0.5), (0.2, 0.846), (0.05, 0.034), (1.0, 0.993_4)] {
        let height = |x: f64| 0.01 * (std::f64::consts::TAU * x / wave).sin();
        let step = wave / 100.0;
        let given = (0..2000).map(|i| step * f64::from(i));
        let given = given.map(|x| Vec2::new(x, height(x))).collect();
        let ground = Heights::with_smoothing(given, Interpolation::Spline, 0.1);
        let middle = (8..=12).map(|k| (f64::from(k) + 0.25) * wave);
        for x in middle {
            // Far from the ends the height of the first point is all that is taken off.
            let (crest, trough) = (ground.eval(x)[0], ground.eval(x + 0.5 * wave)[0]);
            let share = 0.5 * (crest - trough) / 0.01;
            assert!((share - expected).abs() < 2e-3, "{wave}: {share}");
        }
    }
    // Level ground and straight slopes far from their ends stay what they are; rounding of sums
    // over 1 m.
    let slope = (0..=100).map(|i| Vec2::new(0.01 * f64::from(i), 0.001 * f64::from(i)));
    let ground = Heights::with_smoothing(slope.collect(), Interpolation::Corners, 0.1);
    for i in 20..=80 {
        let x = 0.01 * f64::from(i);
        let fall = ground.eval(x)[0] - ground.eval(0.5)[0] - 0.1 * (x - 0.5);
        assert!(fall.abs() < 1e-14, "{fall}");
    }
}
