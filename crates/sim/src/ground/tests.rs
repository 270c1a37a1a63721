use super::*;
use crate::friction::Stretch;
use robhaz_terrain::Profile;

fn ground(profile: Profile, stretches: &[(f64, f64, f64)]) -> Ground {
    let stretch = |&(from, to, mu): &(f64, f64, f64)| Stretch {
        from,
        to,
        mu_s: mu,
        mu_d: mu,
    };
    Ground::new(&PlantSetup {
        stretches: stretches.iter().map(stretch).collect(),
        ..PlantSetup::on(profile)
    })
}

fn act(ground: &mut Ground, motion: &WheelMotion) -> Result<GroundForces, NoTruth> {
    let mut forces = GroundForces::default();
    ground.act(motion, &mut forces, |_, _| ())?;
    Ok(forces)
}

fn truth_of(
    ground: &Ground,
    forces: &GroundForces,
    motion: &WheelMotion,
) -> Result<WheelTruth, NoTruth> {
    let mut truth = WheelTruth::default();
    ground.write_truth(forces, motion, &mut truth)?;
    Ok(truth)
}

fn spinning(x: f64, y: f64) -> WheelMotion {
    WheelMotion {
        centre: Vec2::new(x, y),
        spin: 10.0,
        ..WheelMotion::default()
    }
}

/// Closed form: T/N of a sliding wheel is the mu_d of the stretch under its contact.
#[test]
fn a_stretch_has_its_own_friction() {
    let mut ground = ground(Profile::Flat, &[(1.0, 2.0, 0.2), (2.0, 3.0, 0.4)]);
    for (x, mu) in [
        (0.999, 0.7),
        (1.0, 0.2),
        (1.999, 0.2),
        (2.0, 0.4),
        (3.0, 0.7),
    ] {
        let forces = act(&mut ground, &spinning(x, 0.0995)).unwrap();
        let ratio = forces.traction / forces.normal_force;
        assert!((ratio - mu).abs() < 1e-12, "{ratio} at {x}");
    }
}

/// A wall 0.1 mm thick, less than the penetration: the wheel has contact with the near side and
/// with the ground in front. The far side exerts no force and does not count as ground above the
/// centre. A centre within the wall is below the ground.
#[test]
fn a_thin_wall_has_no_far_side() {
    let points = [
        [-5.0, 0.0],
        [0.6, 0.0],
        [0.600_05, 0.5],
        [0.6001, 0.0],
        [5.0, 0.0],
    ];
    let points = points.map(|[x, y]| Vec2::new(x, y)).to_vec();
    let wall = Profile::Heights(robhaz_terrain::Heights::new(
        points,
        robhaz_terrain::Interpolation::Corners,
    ));
    let mut ground = ground(wall, &[]);
    let mut found = Vec::new();
    ground
        .setup
        .terrain
        .contacts(Vec2::new(0.5005, 0.0995), 0.1, &mut found);
    assert!(found.iter().any(|c| c.distance < 0.0), "{found:?}");
    let forces = act(&mut ground, &spinning(0.5005, 0.0995)).unwrap();
    assert_eq!(forces.contacts, 2);
    assert!(forces.force.x < 0.0 && forces.force.y > 0.0);
    // Within the wall, which is 80 um thick at this height.
    assert!(act(&mut ground, &spinning(0.600_05, 0.0995)).is_err());
}

/// The x of the contact decides, not that of the wheel: a wheel at a riser is behind the stretch,
/// but touches an edge within it.
#[test]
fn each_contact_has_the_friction_of_its_place() {
    let mut ground = ground(
        Profile::Stairs(robhaz_terrain::Stairs::step()),
        &[(0.7, 9.0, 0.0)],
    );
    let centre_x = 0.7 - (0.0995_f64.powi(2) - 0.0495_f64.powi(2)).sqrt();
    let forces = act(&mut ground, &spinning(centre_x, 0.0995)).unwrap();
    assert_eq!(forces.contacts, 2);
    let tread = ground.setup.contact.normal_force(0.0005, 0.0);
    assert!((forces.traction - 0.7 * tread).abs() < 1e-9 * tread);

    // Equivalence: the sums of the wheel are those of its contacts, to rounding.
    let motion = spinning(centre_x, 0.0995);
    let truth = truth_of(&ground, &forces, &motion).unwrap();
    let [rear, front] = truth.contact_list[..] else {
        panic!("{:?}", truth.contact_list);
    };
    // The level ground starts at -1e5 m, where a double has steps of 1.5e-11 m.
    assert!((rear.point - Vec2::new(centre_x, 0.0)).norm() < 1e-10);
    assert!((front.point - Vec2::new(0.7, 0.05)).norm() < 1e-10);
    assert!(front.traction == 0.0 && rear.slip_speed > 0.9);
    let normal = rear.normal * rear.normal_force + front.normal * front.normal_force;
    assert!((normal.norm() - truth.normal_force).abs() < 1e-9 * tread);
    let tangent = Vec2::new(rear.normal.y, -rear.normal.x);
    assert!((normal + tangent * rear.traction - forces.force).norm() < 1e-9 * tread);
    assert!((truth.force - forces.force).norm() == 0.0);
    // The front contact is on the stretch without friction, where it slides too.
    assert!(rear.slides && front.slides && truth.slides);
    let deeper = rear.penetration.max(front.penetration);
    assert_eq!(deeper.to_bits(), truth.penetration.to_bits());

    // Equivalence: with one contact the list has its law's values, at its point.
    let motion = spinning(0.3, 0.0995);
    let forces = act(&mut ground, &motion).unwrap();
    let truth = truth_of(&ground, &forces, &motion).unwrap();
    let [contact] = truth.contact_list[..] else {
        panic!("{:?}", truth.contact_list);
    };
    assert!((contact.point - Vec2::new(0.3, 0.0)).norm() < 1e-10);
    assert!((contact.normal - Vec2::y()).norm() < 1e-12);
    assert!((contact.normal_force - tread).abs() < 1e-9 * tread);
    assert!((contact.traction - 0.7 * tread).abs() < 1e-9 * tread);

    // In the air there is none.
    let motion = spinning(0.3, 0.2);
    let forces = act(&mut ground, &motion).unwrap();
    let truth = truth_of(&ground, &forces, &motion).unwrap();
    assert!(truth.contact_list.is_empty() && (truth.penetration + 0.1).abs() < 1e-10);
    assert!(!truth.slides && truth.force == Vec2::zeros());
}

/// A wheel that climbs a riser without slip grips, although its contact with the tread slides.
#[test]
fn a_wheel_grips_while_one_of_its_contacts_grips() {
    let mut ground = ground(Profile::Stairs(robhaz_terrain::Stairs::step()), &[]);
    // The wheel is 0.5 mm deep in the level ground and in the edge of the kerb.
    let centre = Vec2::new(
        0.7 - (0.0995_f64.powi(2) - 0.0495_f64.powi(2)).sqrt(),
        0.0995,
    );
    let edge = Vec2::new(0.7, 0.05);
    let normal = (centre - edge).normalize();
    let tangent = Vec2::new(normal.y, -normal.x);
    let climbing = WheelMotion {
        wheel: 0,
        centre,
        velocity: tangent * 0.2,
        spin: 2.0,
    };
    let forces = act(&mut ground, &climbing).unwrap();
    let truth = truth_of(&ground, &forces, &climbing).unwrap();
    let [tread, edge] = truth.contact_list[..] else {
        panic!("{:?}", truth.contact_list);
    };
    assert!(tread.slides && !edge.slides && !truth.slides);
    assert_eq!(truth.contacts, 2);
}
