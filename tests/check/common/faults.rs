//! Faults of wiring, units, clocks and sensors, made by changing honest readings.

use robhaz_estimator::SensorFrame;
use std::f64::consts::TAU;

/// A fault.
pub struct Fault {
    pub name: &'static str,
    /// A finding names the fault if its channels contain one of these.
    pub channels: &'static [&'static str],
    /// Text of the remedy that names it exactly.
    pub exact: &'static str,
    /// Where the readings cannot show it, and why: a ground, a drive, or `flat soft` for one of
    /// both.
    pub hidden: Hidden,
    /// The change that it makes.
    pub change: fn(&mut Vec<SensorFrame>),
}

const ENCODERS: &[&str] = &["encoder"];
const TORQUES: &[&str] = &["torque"];
const WHEELS: &[&str] = &["encoder", "torque"];
const GYROS: &[&str] = &["gyro"];
const INCLINOMETERS: &[&str] = &["inclinometer"];

const fn fault_of(
    name: &'static str,
    channels: &'static [&'static str],
    exact: &'static str,
    hidden: Hidden,
    change: fn(&mut Vec<SensorFrame>),
) -> Fault {
    Fault {
        name,
        channels,
        exact,
        hidden,
        change,
    }
}

type Hidden = &'static [(&'static str, &'static str)];

const NOWHERE: Hidden = &[];
/// Level ground turns no link: its gyroscope reads 0 with any sign, on any link.
const LEVEL: Hidden = &[("flat", "the links do not turn")];
/// Without slopes all wheels have the same torque; a drive without integral part hardly answers
/// gentle ones.
const EQUAL: Hidden = &[
    ("flat", "the torques do not differ"),
    (
        "rough soft",
        "the torques differ by less than noise and gains",
    ),
];
/// The middle and the rear wheel are on one link.
const EQUAL_REAR: Hidden = &[
    EQUAL[0],
    EQUAL[1],
    (
        "sine soft",
        "the torques of wheels 2 and 3 hardly differ on these waves",
    ),
];
const SLOW: Hidden = &[
    ("flat", "the links do not turn"),
    ("sine", "the link never turns as fast"),
    ("rough", "the link never turns as fast"),
];
const SLIPPERY: Hidden = &[
    ("flat", "a start shows the scale to a factor of two only"),
    (
        "course PI",
        "the wheels slip as much on the slippery stretch",
    ),
];
const NEVER: Hidden = &[
    ("smooth", "both wheels are on one link"),
    ("sine", "both wheels are on one link"),
    ("course", "both wheels are on one link"),
    ("rough", "both wheels are on one link"),
    ("flat", "both wheels are on one link"),
];
const LATE: Hidden = &[
    ("flat", "the torques do not differ"),
    ("soft", "the torques hardly differ"),
];
const EDGES: Hidden = &[
    ("flat", "the links do not turn"),
    ("course", "impacts at its corners move an inclinometer more"),
];
const ACCELERATED: Hidden = &[
    ("flat", "the links do not turn"),
    ("course", "impacts at its corners move an inclinometer more"),
    (
        "PI",
        "wheels that work against each other accelerate the robot",
    ),
    ("rough soft", "impacts move an inclinometer as much"),
];

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

/// Delays a part of the frames by a time (s), in whole samples.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few samples"
)]
fn delay<T: Copy>(
    frames: &mut [SensorFrame],
    time: f64,
    part: impl Fn(&mut SensorFrame) -> &mut T,
) {
    let samples = (time / (frames[1].time - frames[0].time)).round() as usize;
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

/// The faults.
pub const FAULTS: &[Fault] = &[
    fault_of(
        "inclinations in degrees",
        INCLINOMETERS,
        "deg",
        NOWHERE,
        |f| {
            each(f, |f| {
                scale(&mut f.link1.inclination, 1f64.to_degrees());
                scale(&mut f.link2.inclination, 1f64.to_degrees());
            });
        },
    ),
    fault_of("rates in degrees a second", GYROS, "deg/s", NOWHERE, |f| {
        each(f, |f| {
            scale(&mut f.link1.rate, 1f64.to_degrees());
            scale(&mut f.link2.rate, 1f64.to_degrees());
        });
    }),
    fault_of("encoders in degrees", ENCODERS, "deg", NOWHERE, |f| {
        each(f, |f| {
            f.wheel_angle
                .iter_mut()
                .for_each(|a| scale(a, 1f64.to_degrees()));
        });
    }),
    fault_of(
        "encoders in turns",
        ENCODERS,
        r#"state unit = "turns""#,
        NOWHERE,
        |f| {
            each(f, |f| {
                f.wheel_angle.iter_mut().for_each(|a| scale(a, 1.0 / TAU));
            });
        },
    ),
    fault_of(
        "encoder 2 in degrees",
        ENCODERS,
        "radius of wheel 2",
        NOWHERE,
        |f| {
            each(f, |f| {
                scale(&mut f.wheel_angle[1], 1f64.to_degrees());
            });
        },
    ),
    fault_of("currents in mA, stated in A", TORQUES, "mA", NOWHERE, |f| {
        each(f, |f| {
            f.motor_torque.iter_mut().for_each(|t| scale(t, 1e3));
        });
    }),
    fault_of(
        "encoder 2 counts doubled",
        ENCODERS,
        "radius of wheel 2",
        NOWHERE,
        |f| {
            each(f, |f| {
                scale(&mut f.wheel_angle[1], 2.0);
            });
        },
    ),
    fault_of("one edge counted of four", ENCODERS, "0.2", NOWHERE, |f| {
        each(f, |f| {
            f.wheel_angle.iter_mut().for_each(|a| scale(a, 0.25));
        });
    }),
    fault_of(
        "all counts 10 % too many",
        ENCODERS,
        "counts a turn are too few",
        SLIPPERY,
        |f| {
            each(f, |f| {
                f.wheel_angle.iter_mut().for_each(|a| scale(a, 1.1));
            });
        },
    ),
    fault_of(
        "encoder 1 starts anew each turn",
        ENCODERS,
        "state `wrap`",
        NOWHERE,
        |f| {
            each(f, |f| {
                f.wheel_angle[0] = f.wheel_angle[0].map(|a| a.rem_euclid(TAU));
            });
        },
    ),
    fault_of(
        "encoder 1 sign",
        ENCODERS,
        "wheel 1 counts backwards",
        NOWHERE,
        |f| {
            each(f, |f| {
                negate(&mut f.wheel_angle[0]);
            });
        },
    ),
    fault_of("all encoders' signs", ENCODERS, "encoders", NOWHERE, |f| {
        each(f, |f| {
            f.wheel_angle.iter_mut().for_each(negate);
        });
    }),
    fault_of("torque 1 sign", TORQUES, "sign of torque 1", NOWHERE, |f| {
        each(f, |f| {
            negate(&mut f.motor_torque[0]);
        });
    }),
    fault_of("all torques' signs", TORQUES, "sign", NOWHERE, |f| {
        each(f, |f| {
            f.motor_torque.iter_mut().for_each(negate);
        });
    }),
    fault_of(
        "gyro 1 sign",
        GYROS,
        "gyro 1 has the wrong sign",
        LEVEL,
        |f| {
            each(f, |f| {
                negate(&mut f.link1.rate);
            });
        },
    ),
    fault_of(
        "gyro 2 sign",
        GYROS,
        "gyro 2 has the wrong sign",
        LEVEL,
        |f| {
            each(f, |f| {
                negate(&mut f.link2.rate);
            });
        },
    ),
    fault_of(
        "inclinometer 1 sign",
        INCLINOMETERS,
        "inclinometer 1 has the wrong sign",
        NOWHERE,
        |f| {
            each(f, |f| {
                negate(&mut f.link1.inclination);
            });
        },
    ),
    fault_of(
        "both inclinometers' signs",
        INCLINOMETERS,
        "inclinometer",
        NOWHERE,
        |f| {
            each(f, |f| {
                negate(&mut f.link1.inclination);
                negate(&mut f.link2.inclination);
            });
        },
    ),
    fault_of(
        "all signs of both links",
        INCLINOMETERS,
        "inclinometers",
        NOWHERE,
        |f| {
            each(f, |f| {
                negate(&mut f.link1.inclination);
                negate(&mut f.link2.inclination);
                negate(&mut f.link1.rate);
                negate(&mut f.link2.rate);
            });
        },
    ),
    fault_of(
        "torques 1 and 2 exchanged",
        TORQUES,
        "exchange the columns of wheel1_motor_torque and wheel2_motor_torque",
        EQUAL,
        |f| {
            each(f, |f| {
                f.motor_torque.swap(0, 1);
            });
        },
    ),
    fault_of(
        "torques 2 and 3 exchanged",
        TORQUES,
        "exchange the columns of wheel2_motor_torque and wheel3_motor_torque",
        EQUAL_REAR,
        |f| {
            each(f, |f| {
                f.motor_torque.swap(1, 2);
            });
        },
    ),
    fault_of("torques moved on by one", TORQUES, "torque", EQUAL, |f| {
        each(f, |f| {
            f.motor_torque.rotate_left(1);
        });
    }),
    fault_of(
        "encoders 1 and 2 exchanged",
        WHEELS,
        "exchange the columns of wheel1_angle and wheel2_angle",
        LEVEL,
        |f| {
            each(f, |f| {
                f.wheel_angle.swap(0, 1);
            });
        },
    ),
    fault_of(
        "encoders 2 and 3 exchanged",
        WHEELS,
        "wheel2_angle and wheel3_angle",
        EQUAL_REAR,
        |f| {
            each(f, |f| {
                f.wheel_angle.swap(1, 2);
            });
        },
    ),
    fault_of(
        "encoder and torque of wheels 1 and 2",
        WHEELS,
        "exchange the columns of wheel1_motor_torque and wheel2_motor_torque; exchange the columns of wheel1_angle and wheel2_angle",
        LEVEL,
        |f| {
            each(f, |f| {
                f.wheel_angle.swap(0, 1);
                f.motor_torque.swap(0, 1);
            });
        },
    ),
    fault_of(
        "encoder and torque of wheels 2 and 3",
        WHEELS,
        "exchange the columns of wheel2_motor_torque and wheel3_motor_torque; exchange the columns of wheel2_angle and wheel3_angle",
        NEVER,
        |f| {
            each(f, |f| {
                f.wheel_angle.swap(1, 2);
                f.motor_torque.swap(1, 2);
            });
        },
    ),
    fault_of(
        "encoder 1 and torque 1 exchanged",
        WHEELS,
        "exchange the columns of encoder 1 and torque 1",
        NOWHERE,
        |f| {
            each(f, |f| {
                std::mem::swap(&mut f.wheel_angle[0], &mut f.motor_torque[0]);
            });
        },
    ),
    fault_of(
        "sensors of the links exchanged",
        INCLINOMETERS,
        "exchange",
        LEVEL,
        |f| {
            each(f, |f| {
                std::mem::swap(&mut f.link1, &mut f.link2);
            });
        },
    ),
    fault_of(
        "gyros exchanged",
        GYROS,
        "exchange gyro 1 and gyro 2",
        LEVEL,
        |f| {
            each(f, |f| {
                std::mem::swap(&mut f.link1.rate, &mut f.link2.rate);
            });
        },
    ),
    fault_of(
        "inclinometers exchanged",
        INCLINOMETERS,
        "exchange inclinometer 1 and inclinometer 2",
        LEVEL,
        |f| {
            each(f, |f| {
                std::mem::swap(&mut f.link1.inclination, &mut f.link2.inclination);
            });
        },
    ),
    fault_of(
        "torque 1 twice",
        TORQUES,
        "the same column twice",
        NOWHERE,
        |f| {
            each(f, |f| {
                f.motor_torque[1] = f.motor_torque[0];
            });
        },
    ),
    fault_of(
        "encoder 2 twice",
        ENCODERS,
        "the same column twice",
        NOWHERE,
        |f| {
            each(f, |f| {
                f.wheel_angle[2] = f.wheel_angle[1];
            });
        },
    ),
    fault_of(
        "gyro 1 twice",
        GYROS,
        "the same column twice",
        NOWHERE,
        |f| {
            each(f, |f| {
                f.link2.rate = f.link1.rate;
            });
        },
    ),
    fault_of(
        "inclinometer 1 twice",
        INCLINOMETERS,
        "the same column twice",
        NOWHERE,
        |f| {
            each(f, |f| {
                f.link2.inclination = f.link1.inclination;
            });
        },
    ),
    fault_of("torque 1 stuck", TORQUES, "dead from", NOWHERE, |f| {
        stick(f, 3.0, |f| &mut f.motor_torque[0]);
    }),
    fault_of("gyro 2 stuck", GYROS, "dead from", NOWHERE, |f| {
        stick(f, 3.0, |f| &mut f.link2.rate);
    }),
    fault_of(
        "inclinometer 1 stuck",
        INCLINOMETERS,
        "dead from",
        NOWHERE,
        |f| {
            stick(f, 3.0, |f| &mut f.link1.inclination);
        },
    ),
    fault_of("encoder 3 stuck", ENCODERS, "dead from", NOWHERE, |f| {
        stick(f, 3.0, |f| &mut f.wheel_angle[2]);
    }),
    fault_of("torques 20 ms late", TORQUES, "offset", LATE, |f| {
        delay(f, 0.02, |f| &mut f.motor_torque)
    }),
    fault_of("gyros 30 ms late", GYROS, "offset", EDGES, |f| {
        delay(f, 0.03, |f| &mut f.link1.rate);
        delay(f, 0.03, |f| &mut f.link2.rate);
    }),
    fault_of(
        "inclinometer 1 50 ms late",
        INCLINOMETERS,
        "offset",
        ACCELERATED,
        |f| delay(f, 0.05, |f| &mut f.link1.inclination),
    ),
    fault_of(
        "gyro 1 offset 2 deg/s",
        GYROS,
        "zero it at rest",
        NOWHERE,
        |f| {
            each(f, |f| {
                shift(&mut f.link1.rate, 2f64.to_radians());
            });
        },
    ),
    fault_of(
        "torque 2 offset 1.5 N m",
        TORQUES,
        "zero it",
        NOWHERE,
        |f| {
            each(f, |f| {
                shift(&mut f.motor_torque[1], 1.5);
            });
        },
    ),
    fault_of(
        "inclinometer 2 offset 3 deg",
        INCLINOMETERS,
        "zero both",
        NOWHERE,
        |f| {
            each(f, |f| {
                shift(&mut f.link2.inclination, 3f64.to_radians());
            });
        },
    ),
    fault_of(
        "gyro 1 saturated at 8 deg/s",
        GYROS,
        "saturated",
        SLOW,
        |f| {
            let limit = 8f64.to_radians();
            each(f, |f| {
                f.link1.rate = f.link1.rate.map(|r| r.clamp(-limit, limit))
            });
        },
    ),
    fault_of(
        "inclinometer 2 five times its noise",
        INCLINOMETERS,
        "noise",
        NOWHERE,
        |f| {
            // A fixed sequence with the standard deviation of 0.5 deg: sums of three uniform
            // numbers.
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
pub fn fault(name: &str) -> Option<fn(&mut Vec<SensorFrame>)> {
    let found = FAULTS.iter().find(|fault| fault.name == name);
    found.map(|fault| fault.change)
}

impl Fault {
    /// Why the readings of a ground and drive cannot show it; `None` where they do.
    pub fn hidden(&self, ground: &str, drive: &str) -> Option<&'static str> {
        let both = format!("{ground} {drive}");
        let here = |(place, _): &&(&str, &str)| [ground, drive, &both].contains(place);
        self.hidden.iter().find(here).map(|(_, why)| *why)
    }
}
