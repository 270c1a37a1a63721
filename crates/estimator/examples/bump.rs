//! Forces of a robot that stands, then drives over a bump of 50 mm, from a table of readings.
//!
//! `cargo run --release --example bump`
//!
//! `bump.csv` beside this file has the readings of 10 s at 50 Hz, from a simulation with typical
//! sensors, and the true normal forces to compare with. Contact angles are not given.

use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::Robot;

/// One side of the robot.
const READINGS: &str = include_str!("bump.csv");

/// Columns of the table, in their order: time (s), angle (rad) and motor torque (N m) of the
/// wheels, inclination (rad) and rate (rad/s) of links 1 and 2, true normal forces (N).
const COLUMNS: usize = 14;

/// The readings of a row, SI. A reading that is missing would be `None`.
fn frame(row: &[f64; COLUMNS]) -> SensorFrame {
    let [
        time,
        a1,
        a2,
        a3,
        t1,
        t2,
        t3,
        incline1,
        incline2,
        rate1,
        rate2,
        ..,
    ] = row.map(Some);
    let link = |inclination, rate| LinkReading {
        inclination,
        rate,
        rate_error: 0.0,
    };
    SensorFrame {
        time: time.unwrap_or(f64::NAN),
        wheel_angle: [a1, a2, a3],
        motor_torque: [t1, t2, t3],
        link1: link(incline1, rate1),
        link2: link(incline2, rate2),
        contact_angle: [None; 3],
        ..SensorFrame::default()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::default_a();
    let mut estimator = Estimator::new(&robot, EstimatorSettings::kalman_without_angles());
    let (mut squares, mut within, mut count) = (0.0, 0, 0);
    println!("    s   N of front, middle and rear wheel, N, +- two standard deviations (true)");
    for (k, line) in READINGS.lines().skip(1).enumerate() {
        let mut row = [0.0; COLUMNS];
        for (value, cell) in row.iter_mut().zip(line.split(',')) {
            *value = cell.parse()?;
        }
        let estimate = estimator.update(&frame(&row))?;
        let truth = &row[COLUMNS - 3..];
        let shown = k % 50 == 0;
        if shown {
            print!("{:5.1}", estimate.time);
        }
        for (i, (force, truth)) in estimate.normal_force.iter().zip(truth).enumerate() {
            // This method always states one; those of the paper do not.
            let sigma = estimate.sigma_normal(i).unwrap_or(f64::NAN);
            let error = force - truth;
            if shown {
                print!("   {force:5.1} +- {:3.1} ({truth:5.1})", 2.0 * sigma);
            }
            squares += error * error;
            within += u32::from(error.abs() < 2.0 * sigma);
            count += 1;
        }
        if shown {
            println!();
        }
    }
    let count = f64::from(count);
    println!(
        "RMS of the errors {:.2} N, {:.1} % of the mean load; {:.0} % within two deviations",
        (squares / count).sqrt(),
        100.0 * (squares / count).sqrt() / robot.mean_wheel_load(),
        100.0 * f64::from(within) / count
    );
    Ok(())
}
