//! Faults of wiring, units, clocks and sensors, made by changing honest readings.

use robhaz_estimator::SensorFrame;

/// A fault.
pub struct Fault {
    pub name: &'static str,
    /// Test of `check` that must find it.
    #[allow(dead_code, reason = "of one of the tests that share this module")]
    pub test: &'static str,
    /// The change that it makes.
    pub change: fn(&mut Vec<SensorFrame>),
}

const fn fault_of(
    name: &'static str,
    test: &'static str,
    change: fn(&mut Vec<SensorFrame>),
) -> Fault {
    Fault { name, test, change }
}

fn each(frames: &mut [SensorFrame], change: impl Fn(&mut SensorFrame)) {
    frames.iter_mut().for_each(change);
}

fn negate(value: &mut Option<f64>) {
    *value = value.map(|v| -v);
}

fn scale(value: &mut Option<f64>, factor: f64) {
    *value = value.map(|v| v * factor);
}

fn shift(value: &mut Option<f64>, by: f64) {
    *value = value.map(|v| v + by);
}

/// Delays a part of the frames by whole samples.
fn delay<T: Copy>(
    frames: &mut [SensorFrame],
    samples: usize,
    part: impl Fn(&mut SensorFrame) -> &mut T,
) {
    let values: Vec<T> = frames.iter_mut().map(|f| *part(f)).collect();
    for (k, frame) in frames.iter_mut().enumerate() {
        *part(frame) = values[k.saturating_sub(samples)];
    }
}

/// Keeps the value of a reading from the first frame after `from` (s) on.
fn stick(
    frames: &mut [SensorFrame],
    from: f64,
    part: impl Fn(&mut SensorFrame) -> &mut Option<f64>,
) {
    let mut held = None;
    for frame in frames.iter_mut().filter(|f| f.time > from) {
        let value = part(frame);
        held = held.or(*value);
        *value = held;
    }
}

/// The faults of the list, of 20 kinds and more.
pub const FAULTS: &[Fault] = &[
    fault_of("gyro 1 sign", "sign and unit", |f| {
        each(f, |f| negate(&mut f.link1.rate))
    }),
    fault_of("gyro 2 sign", "sign and unit", |f| {
        each(f, |f| negate(&mut f.link2.rate))
    }),
    fault_of("inclinometer 1 sign", "sign and unit", |f| {
        each(f, |f| negate(&mut f.link1.inclination));
    }),
    fault_of("both inclinometers' signs", "sign and unit", |f| {
        each(f, |f| {
            negate(&mut f.link1.inclination);
            negate(&mut f.link2.inclination);
        });
    }),
    fault_of("inclinations in degrees", "sign and unit", |f| {
        each(f, |f| {
            scale(&mut f.link1.inclination, 1f64.to_degrees());
            scale(&mut f.link2.inclination, 1f64.to_degrees());
        });
    }),
    fault_of("rates in degrees a second", "sign and unit", |f| {
        each(f, |f| {
            scale(&mut f.link1.rate, 1f64.to_degrees());
            scale(&mut f.link2.rate, 1f64.to_degrees());
        });
    }),
    fault_of(
        "sensors of the links exchanged",
        "links on the ground",
        |f| {
            each(f, |f| std::mem::swap(&mut f.link1, &mut f.link2));
        },
    ),
    fault_of("gyros exchanged", "links exchanged", |f| {
        each(f, |f| std::mem::swap(&mut f.link1.rate, &mut f.link2.rate));
    }),
    fault_of("encoder 1 sign", "sign and counts", |f| {
        each(f, |f| negate(&mut f.wheel_angle[0]))
    }),
    fault_of("encoder 2 counts doubled", "sign and counts", |f| {
        each(f, |f| scale(&mut f.wheel_angle[1], 2.0));
    }),
    fault_of("all counts 10 % too many", "distance", |f| {
        each(f, |f| {
            f.wheel_angle.iter_mut().for_each(|a| scale(a, 1.1));
        });
    }),
    fault_of("torque 1 sign", "wiring of wheels", |f| {
        each(f, |f| negate(&mut f.motor_torque[0]))
    }),
    fault_of("all torques' signs", "wiring of wheels", |f| {
        each(f, |f| f.motor_torque.iter_mut().for_each(negate));
    }),
    fault_of("torques 1 and 2 exchanged", "wiring of wheels", |f| {
        each(f, |f| f.motor_torque.swap(0, 1));
    }),
    fault_of("torques 2 and 3 exchanged", "wiring of wheels", |f| {
        each(f, |f| f.motor_torque.swap(1, 2));
    }),
    fault_of("torque 1 stuck", "stuck", |f| {
        stick(f, 3.0, |f| &mut f.motor_torque[0])
    }),
    fault_of("gyro 2 stuck", "stuck", |f| {
        stick(f, 3.0, |f| &mut f.link2.rate)
    }),
    fault_of("encoder 3 stuck", "stuck", |f| {
        stick(f, 3.0, |f| &mut f.wheel_angle[2])
    }),
    fault_of("torques 20 ms late", "delay", |f| {
        delay(f, 20, |f| &mut f.motor_torque)
    }),
    fault_of("gyros 30 ms late", "delay", |f| {
        delay(f, 30, |f| &mut f.link1.rate);
        delay(f, 30, |f| &mut f.link2.rate);
    }),
    fault_of("inclinometer 1 50 ms late", "delay", |f| {
        delay(f, 50, |f| &mut f.link1.inclination);
    }),
    fault_of("gyro 1 offset 2 deg/s", "zero at rest", |f| {
        each(f, |f| shift(&mut f.link1.rate, 2f64.to_radians()));
    }),
    fault_of("torque 2 offset 1.5 N m", "zero at rest", |f| {
        each(f, |f| shift(&mut f.motor_torque[1], 1.5));
    }),
    fault_of("gyro 1 saturated at 8 deg/s", "range", |f| {
        let limit = 8f64.to_radians();
        each(f, |f| {
            f.link1.rate = f.link1.rate.map(|r| r.clamp(-limit, limit));
        });
    }),
    fault_of(
        "inclinometer 2 five times its noise",
        "noise at rest",
        |f| {
            // A fixed sequence with the standard deviation of 0.5 deg: sums of three uniform numbers.
            let mut state = 1_u64;
            for frame in f.iter_mut() {
                let mut sum = -1.5;
                for _ in 0..3 {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
                }
                shift(
                    &mut frame.link2.inclination,
                    2.0 * sum * 0.5f64.to_radians(),
                );
            }
        },
    ),
];

/// A fault by its name.
#[allow(dead_code, reason = "of one of the tests that share this module")]
pub fn fault(name: &str) -> Option<fn(&mut Vec<SensorFrame>)> {
    let found = FAULTS.iter().find(|fault| fault.name == name);
    found.map(|fault| fault.change)
}
