//! The robot on its path.

use robhaz_model::Vec2;
use robhaz_record::figures::{arrow, robots};
use robhaz_sim::{ContactTruth, Truth};

/// Closed form: on level ground the arrow of N points up, and its tip is where the wheel touches.
#[test]
fn the_arrow_of_a_normal_force_ends_at_the_contact() {
    let contact = ContactTruth {
        point: Vec2::new(2.0, 0.0),
        normal: Vec2::y(),
        ..ContactTruth::default()
    };
    let ([foot, _], head) = arrow(&contact, 0.3, 0.02);
    assert!((foot.0 - 2.0).abs() < 1e-12 && (foot.1 + 0.3).abs() < 1e-12);
    assert!((head[0].0 - 2.0).abs() < 1e-12 && head[0].1.abs() < 1e-12);
}

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
    assert!(drawn.windows(2).all(|w| w[1] - w[0] > 0.85 - 1e-9));
    assert_eq!(robots(&[pose(1.0), pose(1.0)], 1.0).len(), 1);
}
