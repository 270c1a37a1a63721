//! The ground of a path.

use robhaz_model::Vec2;
use robhaz_record::figures::{Point, reduced};

/// Property: the ground of a short path keeps its points, that of a long one its ends and its highest point.
#[test]
fn the_ground_of_a_long_path_is_reduced() {
    let wave = |k: u32| Vec2::new(0.005 * f64::from(k), (0.1 * f64::from(k)).sin());
    let pair = |p: &Vec2| (p.x, p.y);
    let short: Vec<Vec2> = (0..1200).map(wave).collect();
    let whole: Vec<Point> = short.iter().map(pair).collect();
    assert_eq!(reduced(&short), whole);
    let mut long: Vec<Vec2> = (0..100_000).map(wave).collect();
    long[54_321].y = 9.0;
    let points = reduced(&long);
    assert!(points.len() <= 1202 && points.is_sorted_by(|a, b| a.0 < b.0));
    assert!(points.contains(&pair(&long[54_321])));
    assert_eq!(points.first(), long.first().map(pair).as_ref());
    assert_eq!(points.last(), long.last().map(pair).as_ref());
}
