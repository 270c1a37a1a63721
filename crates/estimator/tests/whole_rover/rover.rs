//! Rovers for the tests, and what they feel.

use robhaz_estimator::whole::{
    InputCovariance, Joints, WholeEquilibrium, WholeForces, WholeMotion, WholePosture, input,
};
use robhaz_model::{
    Carrier, Coupling, GRAVITY, Geometry, MassSet, PinStop, Robot, Vec2, WholeRover,
};

/// JPL's Open Source Rover: `robots/open-source-rover.toml`, and across it half tracks and place of
/// the rockers from `osr_bringup/config/osr_params.yaml` of github.com/nasa-jpl/osr-rover-code. The
/// middle wheels run 72 mm outside the others. The inertias across are derived: boxes and rods.
#[allow(clippy::approx_constant, reason = "0.318 m is a place")]
pub fn open_source_rover() -> WholeRover {
    let mut geometry = Geometry {
        wheel_radius: 0.075,
        axles: [0.271, 0.0, -0.318].map(|x| Vec2::new(x, 0.075)),
        carriers: [Carrier::Link1, Carrier::Link1, Carrier::Link2],
        body_cg: Vec2::new(-0.02, 0.265),
        stop: PinStop::standard(),
        ..Geometry::a()
    };
    geometry.pins.q = Vec2::new(0.095, 0.169);
    geometry.make_bogie(Carrier::Link2);
    geometry.link_cg[0] = Vec2::new(0.122, 0.106);
    geometry.link_cg[1] = Vec2::new(-0.105, 0.19);
    WholeRover {
        side: Robot {
            geometry,
            mass: MassSet {
                body: 2.9,
                links: [0.25, 0.35, 0.0],
                wheel: 0.95,
                body_inertia: 0.032,
                link_inertias: [0.0022, 0.006, 0.0],
                wheel_inertia: 0.0009,
                rotor_inertia: 0.0029,
            },
            gravity: GRAVITY,
        },
        coupling: Coupling::Differential,
        pivot: Vec2::new(-0.019, 0.261),
        half_tracks: [0.184, 0.2556, 0.184],
        link_places: [0.181; 2],
        body_place: 0.0,
        body_inertia: [0.041, 0.083],
        link_inertias: [[0.0006, 0.0022], [0.0006, 0.006]],
        wheel_inertia: 0.0006,
    }
}

/// The same parts as a triple bogie: the rear wheels on a rear bogie, whose hinge is at `height`
/// (m) above the ground; all wheels of a side in one plane.
pub fn triple_bogie(height: f64) -> WholeRover {
    let rover = open_source_rover();
    WholeRover {
        coupling: Coupling::RearBogie,
        pivot: Vec2::new(-0.25, height),
        half_tracks: [0.3; 3],
        link_places: [0.3; 2],
        ..rover
    }
}

/// Independent errors: specific force (m/s^2), contact angles (rad), tractions (N).
pub fn independent(force: f64, angle: f64, traction: f64) -> InputCovariance {
    let mut p = InputCovariance::zeros();
    for k in 0..input::TRACTION + 6 {
        let sigma = match k {
            0..input::CONTACT_ANGLE => force,
            input::CONTACT_ANGLE..input::TRACTION => angle,
            _ => traction,
        };
        p[(k, k)] = sigma * sigma;
    }
    p
}

/// Errors of typical sensors: attitude 0.1 deg, contact angles 1 deg, tractions 0.4 N.
pub fn typical() -> InputCovariance {
    let attitude = 0.1_f64.to_radians() * GRAVITY;
    independent(attitude, 1.0_f64.to_radians(), 0.4)
}

pub fn equilibrium(
    rover: &WholeRover,
    joints: &Joints,
    motion: &WholeMotion,
    contact_angle: &[f64; 6],
) -> WholeEquilibrium {
    let posture = WholePosture::new(rover, joints).expect("a bogie");
    WholeEquilibrium::new(rover, &posture, motion, contact_angle).expect("a bogie")
}

/// N in the nominal pose on a plane, without tractions, for the errors of typical sensors.
pub fn on_a_plane(rover: &WholeRover, motion: &WholeMotion) -> WholeForces {
    equilibrium(rover, &Joints::default(), motion, &[0.0; 6])
        .solve(&[0.0; 6], &typical())
        .expect("determined")
}
