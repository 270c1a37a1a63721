//! A rover from its file: static loads, then forces from the readings of a rover that stands on a
//! slope, with an inertial sensor in the body and a potentiometer at the pin of the bogie.
//!
//! `cargo run --release --example rover`

use robhaz_estimator::{Estimator, EstimatorSettings, NoiseBudget, SensorFrame};
use robhaz_model::{
    BodyMount, BodyReading, Carrier, GRAVITY, Geometry, MassSet, Outline, PinStop, Pins, Robot,
    Suspension, Vec2,
};
use serde::Deserialize;

/// JPL's Open Source Rover, one side.
const FILE: &str = include_str!("open-source-rover.toml");

/// The part of the file that the estimator needs, in SI units.
#[derive(Deserialize)]
struct File {
    robot: Parts,
}

#[derive(Deserialize)]
struct Parts {
    geometry: Places,
    mass: Masses,
}

#[derive(Deserialize)]
struct Places {
    wheel_radius: f64,
    axles: [[f64; 2]; 3],
    carriers: [String; 3],
    body_cg: [f64; 2],
    link_cg: [[f64; 2]; 2],
    suspension: Body,
    pins: Q,
    stop: Stop,
}

#[derive(Deserialize)]
struct Body {
    body: String,
}

#[derive(Deserialize)]
struct Q {
    q: [f64; 2],
}

#[derive(Deserialize)]
struct Stop {
    lower: f64,
    upper: f64,
    stiffness: f64,
    damping: f64,
}

#[derive(Deserialize)]
struct Masses {
    body: f64,
    links: [f64; 2],
    wheel: f64,
    body_inertia: f64,
    link_inertias: [f64; 2],
    wheel_inertia: f64,
    rotor_inertia: f64,
}

fn carrier(name: &str) -> Result<Carrier, String> {
    match name {
        "link1" => Ok(Carrier::Link1),
        "link2" => Ok(Carrier::Link2),
        _ => Err(format!("{name}: allowed are link1 and link2")),
    }
}

/// The robot of the file: of a bogie, so it has one pin and no link 3.
fn robot(parts: &Parts) -> Result<Robot, Box<dyn std::error::Error>> {
    let (of, mass) = (&parts.geometry, &parts.mass);
    let [front, middle, rear] = of.carriers.each_ref();
    let (axles, body_cg) = (of.axles.map(Vec2::from), Vec2::from(of.body_cg));
    let body = carrier(&of.suspension.body)?;
    let [cg1, cg2] = of.link_cg.map(Vec2::from);
    let ([link1, link2], [inertia1, inertia2]) = (mass.links, mass.link_inertias);
    let mut geometry = Geometry {
        wheel_radius: of.wheel_radius,
        axles,
        carriers: [carrier(front)?, carrier(middle)?, carrier(rear)?],
        suspension: Suspension::Bogie { body },
        pins: Pins::of_bogie(of.pins.q.into(), body, 1.0),
        body_cg,
        link_cg: [cg1, cg2, body_cg],
        stop: PinStop {
            lower: of.stop.lower,
            upper: of.stop.upper,
            stiffness: of.stop.stiffness,
            damping: of.stop.damping,
        },
        outline: Outline::derived(&axles, body_cg),
    };
    // The pins of the four-bar that a bogie is a special case of.
    geometry.make_bogie(body);
    geometry.check()?;
    let mass = MassSet {
        body: mass.body,
        links: [link1, link2, 0.0],
        wheel: mass.wheel,
        body_inertia: mass.body_inertia,
        link_inertias: [inertia1, inertia2, 0.0],
        wheel_inertia: mass.wheel_inertia,
        rotor_inertia: mass.rotor_inertia,
    };
    mass.check()?;
    let robot = Robot {
        geometry,
        mass,
        gravity: GRAVITY,
    };
    robot.check_stance()?;
    Ok(robot)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = robot(&toml::from_str::<File>(FILE)?.robot)?;
    if let Some([front, middle, rear]) = robot.static_loads() {
        println!("static loads: {front:.2}, {middle:.2}, {rear:.2} N");
    }
    // On a slope of 10 deg, held by its motors: the pin of the bogie is in its nominal pose.
    let slope = 10.0_f64.to_radians();
    let weight = robot.mass.total() * robot.gravity;
    let torque = weight * slope.sin() / 3.0 * robot.geometry.wheel_radius;
    let pin_noise = 0.1_f64.to_radians();
    let mut mount = BodyMount::new(&robot.geometry, pin_noise);
    let budget = NoiseBudget::typical();
    let settings = EstimatorSettings {
        budget: budget.of_body_sensors(&robot, [pin_noise, pin_noise]),
        ..EstimatorSettings::kalman()
    };
    let mut estimator = Estimator::new(&robot, settings);
    for k in 0..100 {
        let time = 0.02 * f64::from(k);
        let reading = BodyReading {
            inclination: Some(slope),
            rate: Some(0.0),
            pin: Some(0.0),
            wheels: [Some(0.0); 3],
        };
        let [link1, link2] = mount.links(time, &reading);
        let estimate = estimator.update(&SensorFrame {
            time,
            wheel_angle: [Some(0.0); 3],
            motor_torque: [Some(torque); 3],
            link1,
            link2,
            contact_angle: [Some(slope); 3],
            ..SensorFrame::default()
        })?;
        if k == 99 {
            let [front, middle, rear] = estimate.normal_force;
            println!("on a slope of 10 deg: {front:.2}, {middle:.2}, {rear:.2} N");
            let across = estimate.normal_force.iter().sum::<f64>();
            println!(
                "sum {across:.2} N, the weight across the slope is {:.2} N",
                weight * slope.cos()
            );
        }
    }
    Ok(())
}
