//! Rovers for the tests, and their equations.

use robhaz_estimator::whole::{
    InputCovariance, Joints, WholeEquilibrium, WholeForces, WholeFrame, WholeMotion, WholePosture,
    input,
};
use robhaz_model::{
    Carrier, Coupling, GRAVITY, Geometry, MassSet, PinStop, Robot, Vec2, WholeRover,
};

/// JPL's Open Source Rover: `robots/open-source-rover.toml`. The middle wheels run 72 mm outside the
/// others.
pub fn open_source_rover() -> WholeRover {
    let file = include_str!("../../../../robots/open-source-rover.toml");
    let file: toml::Value = toml::from_str(file).expect("TOML");
    let robot = &file["robot"];
    let [g, m, across] = ["geometry", "mass", "across"].map(|part| &robot[part]);
    let axles: [[f64; 2]; 3] = of(&g["axles"]);
    let mut geometry = Geometry {
        wheel_radius: of(&g["wheel_radius"]),
        axles: axles.map(Vec2::from),
        carriers: [Carrier::Link1, Carrier::Link1, Carrier::Link2],
        body_cg: point(&g["body_cg"]),
        stop: PinStop::standard(),
        ..Geometry::a()
    };
    geometry.pins.q = point(&g["pins"]["q"]);
    geometry.make_bogie(Carrier::Link2);
    let [bogie, rocker]: [[f64; 2]; 2] = of(&g["link_cg"]);
    geometry.link_cg[..2].copy_from_slice(&[bogie.into(), rocker.into()]);
    let of_links = |key: &str| {
        let [bogie, rocker]: [f64; 2] = of(&m[key]);
        [bogie, rocker, 0.0]
    };
    WholeRover {
        side: Robot {
            geometry,
            mass: MassSet {
                body: of(&m["body"]),
                links: of_links("links"),
                wheel: of(&m["wheel"]),
                body_inertia: of(&m["body_inertia"]),
                link_inertias: of_links("link_inertias"),
                wheel_inertia: of(&m["wheel_inertia"]),
                rotor_inertia: of(&m["rotor_inertia"]),
            },
            gravity: GRAVITY,
        },
        coupling: Coupling::Differential,
        pivot: point(&across["pivot"]),
        half_tracks: of(&across["half_tracks"]),
        link_places: of(&across["link_places"]),
        body_place: of(&across["body_place"]),
        coupling_stop: WholeRover::NO_STOP,
        body_inertia: of(&across["body_inertia"]),
        link_inertias: of(&across["link_inertias"]),
        wheel_inertia: of(&across["wheel_inertia"]),
    }
}

fn of<T: serde::de::DeserializeOwned>(value: &toml::Value) -> T {
    value.clone().try_into().expect("a value of this kind")
}

fn point(value: &toml::Value) -> Vec2 {
    of::<[f64; 2]>(value).into()
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

/// What a rover reads that stands on level ground.
pub fn level_frame(time: f64) -> WholeFrame {
    WholeFrame {
        time,
        wheel_angle: [Some(0.0); 6],
        motor_torque: [Some(0.0); 6],
        steering: [None; 6],
        pins: [Some(0.0); 2],
        coupling: Some(0.0),
        inclination: Some(0.0),
        roll: Some(0.0),
        rates: [Some(0.0); 3],
    }
}
