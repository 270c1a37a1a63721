//! The loop of a robot's controller: read the sensors, estimate, use the estimate with its flags.
//!
//! `cargo run --release -p robhaz-estimator --example on_a_robot`
//!
//! With the argument `paper-wheels` it runs this estimator of the paper instead of `kalman`:
//! `.ci/instructions` compares their cost.

use robhaz_estimator::{
    Estimator, EstimatorSettings, Flags, LinkReading, NoiseBudget, SensorFrame, Sides,
};
use robhaz_model::Robot;

/// Counts of the encoders in a turn of the wheel: 500 pulses, four edges each, gear 80.
const COUNTS: f64 = 160_000.0;
/// Torque at the wheel a motor current, N m/A: motor constant times gear times its efficiency.
const TORQUE_OF_CURRENT: f64 = 0.03 * 80.0 * 0.8;

/// Raw values of the drivers, `None` where a sensor did not answer.
struct Raw {
    seconds: f64,
    counts: [Option<i64>; 3],
    amperes: [Option<f64>; 3],
    /// Links 1 and 2: inclination in degrees, nose up positive; rate in degrees a second.
    inclination: [Option<f64>; 2],
    rate: [Option<f64>; 2],
}

/// Stands in for the drivers: starts on level ground and rolls at 0.2 m/s; the second motor's
/// current drops out for a while.
fn read_sensors(k: u32) -> Raw {
    /// Spin acceleration at the start, rad/s^2: 0.2 m/s^2.
    const ACCELERATION: f64 = 2.0;
    /// Torque for it at each wheel, N m: 0.094 kg m^2 of wheel and rotor, a third of 14 kg at 0.1
    /// m.
    const TO_ACCELERATE: f64 = 0.281;
    /// Damping of a wheel module, N m s.
    const DAMPING: f64 = 0.15;
    let seconds = 1e-3 * f64::from(k);
    // From rest to 2 rad/s within a second.
    let driven = seconds - 0.2;
    let starts = (0.0..1.0).contains(&driven);
    let spin = ACCELERATION * driven.clamp(0.0, 1.0);
    let turned = match driven {
        ..0.0 => 0.0,
        ..1.0 => 0.5 * ACCELERATION * driven * driven,
        _ => ACCELERATION * (driven - 0.5),
    };
    let turns = turned / core::f64::consts::TAU;
    let torque = DAMPING * spin + if starts { TO_ACCELERATE } else { 0.0 };
    // A current is never quite constant: one that is shows a broken sensor.
    let ripple = 0.02 * f64::from(k).sin();
    let current = torque / TORQUE_OF_CURRENT + ripple;
    // An inclinometer shows the acceleration, too.
    let direction = if starts { 0.2_f64.atan2(9.81) } else { 0.0 };
    let lost = (1500..1700).contains(&k);
    Raw {
        seconds,
        counts: [Some((turns * COUNTS).floor() as i64); 3],
        amperes: [Some(current), (!lost).then_some(current), Some(current)],
        inclination: [Some(direction.to_degrees()); 2],
        rate: [Some(0.0); 2],
    }
}

/// SI units, and the signs of the estimator.
fn frame(raw: &Raw) -> SensorFrame {
    let link = |i: usize| LinkReading {
        inclination: raw.inclination[i].map(f64::to_radians),
        rate: raw.rate[i].map(f64::to_radians),
        rate_error: 0.0,
    };
    let angle = |counts: i64| counts as f64 * core::f64::consts::TAU / COUNTS;
    SensorFrame {
        time: raw.seconds,
        wheel_angle: raw.counts.map(|counts| counts.map(angle)),
        motor_torque: raw.amperes.map(|a| a.map(|a| a * TORQUE_OF_CURRENT)),
        link1: link(0),
        link2: link(1),
        // From a map, a camera, or the wheels' paths; here the ground is level.
        contact_angle: [Some(0.0); 3],
        ..SensorFrame::default()
    }
}

fn main() {
    let preset = match std::env::args().nth(1).as_deref() {
        Some("paper-wheels") => EstimatorSettings::paper_wheels(),
        _ => EstimatorSettings::kalman(),
    };
    let settings = EstimatorSettings {
        // A robot has two; a test rig of one side, or a simulated robot, is Sides::Plane.
        sides: Sides::OneOfTwo,
        budget: NoiseBudget {
            encoder_counts: COUNTS,
            torque_noise: 0.05,
            ..NoiseBudget::typical()
        },
        ..preset
    };
    let mut estimator = Estimator::new(&Robot::default_a(), settings);
    let mut last = Flags::NONE;
    for k in 0..2500 {
        match estimator.update(&frame(&read_sensors(k))) {
            Ok(estimate) => {
                if estimate.flags != last {
                    let names: Vec<_> = estimate.flags.names().collect();
                    println!("{:.3} s: flags: [{}]", estimate.time, names.join(", "));
                    last = estimate.flags;
                }
                if k % 500 == 499 {
                    print!("{:.3} s: N =", estimate.time);
                    for (i, n) in estimate.normal_force.iter().enumerate() {
                        // `kalman` always states a standard deviation, the paper's estimators none.
                        let sigma = estimate.sigma_normal(i).unwrap_or(f64::NAN);
                        print!(" {n:.1} +- {:.1} N,", 2.0 * sigma);
                    }
                    println!(" T of wheel 2 = {:.1} N", estimate.traction[1]);
                }
            }
            // No estimate for this frame: continue with the next one.
            Err(error) => println!("frame {k}: {error}"),
        }
    }
}
