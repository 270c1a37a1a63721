//! The columns of the tables of a log of both sides.

use super::estimate::{contacts, weight};
use super::{Source, Table, WHEEL};
use robhaz_estimator::whole::TipLine;
use robhaz_model::Coupling;

/// The sides in the order of the wheels.
const SIDES: [&str; 2] = ["left", "right"];

/// Start of the names of a wheel's columns (0 to 5), and of their descriptions.
fn wheel(i: usize) -> (String, String) {
    let (side, k) = (SIDES[i / 3], i % 3);
    (
        format!("{side}_wheel{}_", k + 1),
        format!("{side} {}", WHEEL[k]),
    )
}

impl Table {
    /// `sensors` of both sides.
    pub(super) fn sensors_of_both(coupling: Coupling) -> Self {
        let mut table = Self::new("sensors");
        for i in 0..6 {
            let (start, of) = wheel(i);
            columns! { table, Source::readings; start, of;
                "angle", "rad", "encoder, turn against its link, forward positive" => move |r| r.wheel_angle[i];
                "motor_torque", "N m", "motor torque from its current, after the gear, forward positive" =>
                    move |r| r.motor_torque[i];
                "steering", "rad", "steering, to the left positive; empty of a wheel that is not steered" =>
                    move |r| r.steering[i];
            }
        }
        for (k, side) in SIDES.into_iter().enumerate() {
            columns! { table, Source::readings; format!("{side}_"), format!("{side} ");
                "pin_angle", "rad", "bogie against the link that it is pivoted to, nose up positive" =>
                    move |r| r.pins[k];
            }
        }
        match coupling {
            Coupling::Differential => columns! { table, Source::readings; "", "";
                "differential_angle", "rad", "left rocker against the body, nose up positive" => |r| r.coupling;
            },
            Coupling::RearBogie => columns! { table, Source::readings; "", "";
                "rear_bogie_angle", "rad", "roll of the rear bogie against the body's, left side up positive" =>
                    |r| r.coupling;
            },
        }
        columns! { table, Source::readings; "body_", "body: ";
            "inclination", "rad", "inclinometer, nose up positive" => |r| r.inclination;
            "roll", "rad", "inclinometer, left side up positive" => |r| r.roll;
            "roll_rate", "rad/s", "gyroscope, left side up positive" => |r| r.rates[0];
            "rate", "rad/s", "gyroscope, nose up positive" => |r| r.rates[1];
            "yaw_rate", "rad/s", "gyroscope, to the left positive" => |r| r.rates[2];
        }
        table
    }

    /// `estimate-NAME` of both sides. A row without an estimate has its time, too.
    pub fn estimate_of_both(name: &str) -> Self {
        let mut table = Self::new(format!("estimate-{name}"));
        (0..6).for_each(|i| table.add_wheel_of_both(i));
        columns! { table, Source::both; "", "";
            "lateral_force", "N", "force of the ground on all wheels across the body, to the left" => |e| Some(e.lateral_force);
            "axial_share", "1", "mean axial force of a wheel over its N: the friction that a cross slope or a turn needs" =>
                |e| Some(e.axial_share);
            "tip_margin", "1", "load of the wheels off the line about which the rover would tip first, over their load on level \
             ground: at 0 it tips" => |e| Some(e.tip_margin);
            "tip_line", "1", "that line, through the contacts of the wheels: left 0, right 1, front 2, rear 3" => |e| {
                let line = e.tip_line;
                TipLine::ALL.iter().position(|l| *l == line).map(|place| place as f64)
            };
            "body_inclination", "rad", "inclination of the body, nose up positive" => |e| Some(e.attitude[0]);
            "body_roll", "rad", "roll of the body, left side up positive" => |e| Some(e.attitude[1]);
            "dragged", "1", "1 where wheels are dragged across, as in a skid turn: outside of the model, with large stated \
             deviations; otherwise 0" => |e| Some(f64::from(u8::from(e.dragged)));
            "rolling_resistance", "1", "coefficient found of the rolling resistance, mean of both sides" => |e| {
                let of_side = |k: usize| e.sides[k].kalman.as_ref().map(|k| k.reading_errors.rolling_resistance.0);
                Some(0.5 * (of_side(0)? + of_side(1)?))
            };
            "misfit", "1", "squared distance of the nine equations from what is stated: 3 on average if it holds" =>
                |e| Some(e.misfit);
            "weight", "1", "the torques against the described weight: 1 confirmed, 0 unconfirmed, -1 contradicts" =>
                |e| Some(weight(e.torque_scale.confirmation));
        }
        columns! { table, Source::both; "body_", "body and both sides: ";
            "flags", "1", "warnings, a bit each: reading of the body missing 16, stale 32, absurd 64; its readings, or the nine \
             equations, contradict each other 512" => |e| Some(f64::from(e.body_flags.bits()));
        }
        for (k, side) in SIDES.into_iter().enumerate() {
            columns! { table, Source::both; format!("{side}_"), format!("{side} side: ");
                "flags", "1", "warnings, a bit each: wheels 1 to 3 unloaded 1, 2, 4; linkage at a stop 8; reading missing 16, stale \
                 32, absurd 64; out of the model's range 128; spins in place 256; readings contradict each other 512" =>
                    move |e| Some(f64::from(e.sides[k].flags.bits()));
                "faulty_channels", "1", "channels whose readings contradict others, a bit each: encoders 1, 2, 4; torques 8, 16, 32; \
                 gyroscopes 512, 1024; inclinometers 2048, 4096; parity 8192; torque scale or mass 16384" =>
                    move |e| Some(f64::from(e.sides[k].kalman?.health.faulty.bits()));
            }
        }
        table
    }

    fn add_wheel_of_both(&mut self, i: usize) {
        let (start, of) = wheel(i);
        let (side, k) = (i / 3, i % 3);
        columns! { self, Source::both; start, of;
            "normal_force", "N", "normal force N in the wheel's plane" => move |e| Some(e.normal_force[i]);
            "normal_force_sigma", "N", "standard deviation of N along the ground's normal, which may be inclined across the wheel" =>
                move |e| e.sigma_normal(i);
            "in_plane_normal_force_sigma", "N", "standard deviation of N in the wheel's plane, as a force sensor above it reads" =>
                move |e| e.sigma_in_plane(i);
            "traction", "N", "traction T, driving forward positive" => move |e| Some(e.traction[i]);
            "traction_sigma", "N", "standard deviation of T" => move |e| e.sigma_traction(i);
            "needed_friction", "1", "needed friction: root of the squares of T/N and axial_share; empty without load" =>
                move |e| e.needed_friction(i);
            "contact_angle", "rad", "slope of the ground along the wheel, against the level" =>
                move |e| Some(e.sides[side].contact_angle[k]);
            "contact_angle_sigma", "rad", "standard deviation of the contact angle" =>
                move |e| Some(e.sides[side].kalman?.contact_angle_sigma[k]);
            "contacts", "1", "contacts found, 0 (in the air), 1 or 2" =>
                move |e| Some(contacts(e.sides[side].kalman?.contact[k].state));
            "sliding", "1", "1 if it is found sliding, otherwise 0" =>
                move |e| Some(f64::from(u8::from(e.sides[side].kalman?.contact[k].sliding)));
            "slip", "m/s", "slip speed found, rim less ground, creep included" =>
                move |e| Some(e.sides[side].kalman?.contact[k].slip);
        }
    }
}
