//! Clearances with a closed form, and parry2d as a second opinion on the contacts of wheels.

use parry2d::math::{Pose, Vector};
use parry2d::query::distance;
use parry2d::shape::{Ball, Polyline};
use robhaz_model::{Bar, Geometry, Posture, Vec2};
use robhaz_sim::clearance::{BarPlace, ClearanceMeter};
use robhaz_terrain::{Profile, Stairs, Terrain};

/// The bars of geometry A in a posture, with Q at a place, m.
fn places(geometry: &Geometry, angles: [f64; 2], q: Vec2) -> Option<[BarPlace; 4]> {
    let posture = Posture::close(geometry, angles[0], angles[1]).ok()?;
    Some(Bar::ALL.map(|bar| BarPlace {
        centre: q + posture.cg_from_q(geometry, bar),
        angle: posture.angle(bar),
    }))
}

/// Closed form: on level ground in the nominal pose the clearance is the height of the lowest point
/// less the half width: pin Q for link 1, the line from R to Q where it enters the middle wheel for
/// link 2, pin R for link 3, the lower of box and pins for the body. Raised, it grows by as much;
/// turned with the robot, the lowest point goes down by its arm times the sine.
#[test]
fn level_ground_has_the_nominal_heights() {
    let geometry = Geometry::a();
    let half = geometry.outline.half_width;
    let lowest = geometry.pins.p.y.min(geometry.outline.body_lower.y);
    // On the line from R to Q, at a share s of it: x = -0.25 + 0.2 s, y = 0.16 - 0.02 s, and 0.1 m
    // from (0, 0.1). With a s^2 + b s + c = 0 the line enters the wheel at the smaller root.
    let (a, b, c) = (0.0404_f64, -0.1024, 0.0561);
    let entry = 0.16 - 0.02 * (-b - (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let mut meter = ClearanceMeter::new(&geometry, Terrain::new(Profile::Flat));
    for (raised, x) in [(0.0, 0.0), (0.3, 2.0), (-0.05, 40.0), (0.0, -7.0)] {
        let q = geometry.pins.q + Vec2::new(x, raised);
        let found = meter.measure_each(&places(&geometry, [0.0; 2], q).unwrap());
        let expected =
            [lowest, geometry.pins.q.y, entry, geometry.pins.r.y].map(|y| y + raised - half);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
    // Sunk so deep that pin Q is in the ground.
    let sunk = places(&geometry, [0.0; 2], geometry.pins.q - Vec2::new(0.0, 0.135)).unwrap();
    let found = meter.measure(&sunk);
    assert!(found.touches() && found.least.0 != Bar::Body);
    // Nose up by 0.2 rad about Q: the lowest point of the body is its rear corner or pin S.
    let angle = 0.2_f64;
    let found = meter.measure_each(&places(&geometry, [angle; 2], geometry.pins.q).unwrap());
    let heights = geometry.outline_points(Bar::Body).map(|p| {
        let arm = p - geometry.pins.q;
        geometry.pins.q.y + arm.x * angle.sin() + arm.y * angle.cos()
    });
    let expected = heights.fold(f64::INFINITY, f64::min) - half;
    assert!((found[0] - expected).abs() < 1e-9, "{found:?} {expected}");
}

/// Closed form: link 1 goes straight from P down to the front axle and touches a kerb of 160 mm
/// under it. With a strut over the wheel its lowest point is where the strut leaves the wheel, a
/// radius from the axle.
#[test]
fn a_strut_lifts_a_link_over_a_kerb() {
    let mut geometry = Geometry::a();
    for strut in [None, Some(Vec2::new(0.29, 0.22))] {
        geometry.outline.through[0][0] = strut;
        let step = Stairs {
            start: 0.2,
            rise: 0.16,
            run: 10.0,
            count: 1,
        };
        let mut meter = ClearanceMeter::new(&geometry, Terrain::new(Profile::Stairs(step)));
        let found = meter.measure_each(&places(&geometry, [0.0; 2], geometry.pins.q).unwrap());
        let of_link1 = found[1];
        assert!(strut.is_some() || of_link1 < 0.0, "{of_link1}");
        let leaves = 0.1 + 0.1 * 0.12 / 0.01_f64.hypot(0.12);
        let expected = leaves - 0.16 - geometry.outline.half_width;
        assert!(strut.is_none() || (of_link1 - expected).abs() < 1e-9);
    }
}

/// Closed form: ahead of a kerb's edge between the rear and the middle wheel, pin Q at 0.14 m is
/// the lowest point; with the half width of 15 mm it is 5 mm above a kerb of 120 mm and touches one
/// of 130 mm.
#[test]
fn a_kerb_under_the_linkage_is_seen() {
    let geometry = Geometry::a();
    for (rise, touched) in [(0.12, false), (0.13, true)] {
        let step = Stairs {
            start: -0.2,
            rise,
            run: 10.0,
            count: 1,
        };
        let terrain = Terrain::new(Profile::Stairs(step));
        let mut meter = ClearanceMeter::new(&geometry, terrain);
        let robot = places(&geometry, [0.0; 2], geometry.pins.q).unwrap();
        let found = meter.measure(&robot);
        let (bar, least) = found.least;
        assert!(
            bar == Bar::Link1 && (least - (0.125 - rise)).abs() < 1e-9,
            "{found:?}"
        );
        assert_eq!(found.touches(), touched);
        // The others are higher.
        let each = meter.measure_each(&robot);
        assert!(each[2] > least && each[3] > 0.03, "{each:?}");
    }
}

/// Equivalence: parry2d's distance of a ball to the ground's polyline is that of the ground's own
/// nearest contact, on smooth ground and at corners, within the sag of the polyline's chords.
#[test]
fn contacts_of_wheels_are_those_of_parry() {
    let profiles = [
        Profile::CosBump(Default::default()),
        Profile::Ramp(Default::default()),
        Profile::Stairs(Default::default()),
    ];
    for profile in profiles {
        let terrain = Terrain::new(profile);
        let points = terrain.outline(-1.0, 4.0, 0.001);
        let points: Vec<_> = points.into_iter().map(|p| Vector::new(p.x, p.y)).collect();
        let ground = Polyline::new(points, None);
        let mut compared = 0;
        for i in 0..300 {
            let x = 0.01 * f64::from(i);
            for height in [0.12, 0.2, 0.4] {
                let centre = Vec2::new(x, height);
                let Some(own) = terrain.nearest(centre).filter(|c| c.distance > 0.0) else {
                    continue;
                };
                let pose = Pose::new(Vector::new(x, height), 0.0);
                let ball = Ball::new(0.001);
                let found = distance(&pose, &ball, &Pose::IDENTITY, &ground)
                    .unwrap()
                    .distance
                    + 0.001;
                if found <= 0.002 {
                    continue;
                }
                // A chord of 1 mm on a curve of 0.1 m is 1.3e-6 m off.
                assert!(
                    (found - own.distance).abs() < 2e-6,
                    "{x} {height}: {found} {}",
                    own.distance
                );
                compared += 1;
            }
        }
        assert!(compared > 300, "{compared}");
    }
}
