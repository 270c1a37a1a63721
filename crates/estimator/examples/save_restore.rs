//! Saves an estimator's state as bytes and restores another one from them: both continue with the same bits.
//!
//! `cargo run --release -p robhaz-estimator --example save_restore`

use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SavedState, SensorFrame};
use robhaz_model::Robot;

/// A robot at rest on level ground whose motors read an offset of 0.1 N m.
fn frame(k: u32) -> SensorFrame {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
    };
    SensorFrame {
        time: 1e-3 * f64::from(k),
        wheel_angle: [Some(0.0); 3],
        motor_torque: [Some(0.1); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (robot, settings) = (Robot::default_a(), EstimatorSettings::best());
    let mut first = Estimator::new(&robot, settings);
    for k in 0..5000 {
        first.update(&frame(k))?;
    }
    // To flash, to a file, over a wire.
    let bytes = first.save().to_bytes();
    println!("{} bytes saved", bytes.len());

    let mut second = Estimator::new(&robot, settings);
    second.restore(&SavedState::from_bytes(&bytes)?)?;
    let (a, b) = (first.update(&frame(5000))?, second.update(&frame(5000))?);
    assert_eq!(a, b);
    for (i, n) in b.normal_force.iter().enumerate() {
        println!("wheel {}: N = {n:.2} N in both", i + 1);
    }

    let mut flipped = bytes;
    flipped[100] ^= 1;
    if let Err(error) = SavedState::from_bytes(&flipped) {
        println!("with one bit changed: {error}");
    }
    Ok(())
}
